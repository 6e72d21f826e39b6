"""The acceleration of an axis in an instant, and explicit steps by it.

Nyström's method of order 4 for q'' = a(t, q, v) (1925; Abramowitz and Stegun 25.5.20): an instant's
acceleration is asked for twice in the middle of a step and once at its end, and no equation is
solved. It serves axes under laws without states, as long as they move and their velocity decays by
little within a step; `passage.py` does the rest.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...compile_cache import compiled
from ...friction.law import terms_factor
from ...space import Array
from .drive_force import driven, mixed
from .drives import CLAMP, DAMPING, INERTIA, SLIDE
from .velocity import rubs

#: A step is explicit where by friction and by the drive's damping, each by itself, a velocity
#: decays or grows by no more than this share in it; how fast it does is told by velocities that
#: differ by more than the other, as a share. (Where the two are large and cancel each other, a
#: slide is about to become unstable: there nothing may stir it, no change of method either.)
MILD, DISTINCT = 0.5, 1e-9
#: What two rules differ by is an estimate, which may be too small by this factor.
SURE = 4.0
#: No difference of velocities tells of an error that is less than this share of them.
ROUNDING = float(np.finfo(float).eps)


@compiled(forceinline=True)
def acceleration(
    slip: Any, rub: Any, general: bool, kind: int, p: Array, term: Array, c: Array, u: Array,
    q: float, v: float, z: Array, load: Array, out: Array,
) -> float:  # fmt: skip
    """The acceleration in an instant; at rest the sign of a zero says which way it goes."""
    mass, F, d, _ = driven(kind, c, u, q, v, load)
    F -= d * v + rubs(slip, rub, general, terms_factor(term, p, load), v, 0.0, z, load, p, out)
    if kind == SLIDE and (c[INERTIA] > 0.0 or c[DAMPING] > 0.0):
        a = (F - c[DAMPING] * v) / (mass + c[INERTIA])
        motor = c[INERTIA] * a + c[DAMPING] * v
        if abs(motor) > c[CLAMP]:
            a = (F - np.copysign(c[CLAMP], motor)) / mass
        return a  # type: ignore[no-any-return]
    return F / mass  # type: ignore[no-any-return]


@compiled(inline="always")
def explicit_step(  # noqa: C901 - the stages of one method
    slip: Any, rub: Any, general: bool, kind: int, p: Array, term: Array, c: Array, inputs: Array,
    held: Array, k: int, begin: float, share: float, h: float, base: float, way: float,
    band: float, q: float, v: float, a_0: float, tolerance: float, none: Array, load: Array,
    out: Array, u: Array,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """A step by Nyström's explicit method of order 4, of an axis that does not stop in it.

    Returns position, velocity and acceleration after it, its error, m or rad (inf where a velocity
    within it is not beyond `band` on the side `way` of rest), and the rate at which the velocity
    decays, 1/s.

    The acceleration is a parabola through its values at the start, the middle and the end. The
    error is at most a third of the second difference of these, whatever lies between them; where
    that is too much to tell, Boole's rule, with the accelerations at the quarters, tells.
    """
    at, v_s, q_s = 0.5, v + 0.5 * h * a_0, q + 0.5 * h * (v + 0.25 * h * a_0)
    q_1, v_1, a_1, a_2, a_3, a_4, a_m, a_q = q, v, a_0, a_0, a_0, a_0, a_0, a_0
    slope, bend, error, rate = 0.0, 0.0, 0.0, 0.0
    for stage in range(6):
        if not way * v_s > band:
            return q, v, a_0, np.inf, 0.0
        if stage not in (1, 3):  # at the same instant as the one before
            mixed(inputs, held, k, begin + at * share, u)
        a = acceleration(slip, rub, general, kind, p, term, c, u, q_s, v_s, none, load, out)
        if stage == 0:
            a_2, v_s = a, v + 0.5 * h * a
        elif stage == 1:
            a_3, at, v_s, q_s = a, 1.0, v + h * a, q + h * (v + 0.5 * h * a)
            if abs(a_2 - a_0) * h > DISTINCT * abs(v):
                rate = 2.0 * (a_2 - a_3) / (h * (a_2 - a_0))
        elif stage == 2:  # noqa: PLR2004 - the next one
            a_4 = a
            v_1 = v_s = v + h * (a_0 + 2.0 * (a_2 + a_3) + a_4) / 6.0
            q_1 = q_s = q + h * (v + h * (a_0 + a_2 + a_3) / 6.0)
        elif stage == 3:  # noqa: PLR2004 - the next one
            a_1, a_m = a, 0.5 * (a_2 + a_3)
            slope, bend = 4.0 * a_m - 3.0 * a_0 - a_1, a_0 - 2.0 * a_m + a_1
            error = base * h * (abs(a_1 - a_4) / 6.0 + abs(bend) / 3.0)
            if error <= tolerance:
                break
            at = 0.25
        elif stage == 4:  # noqa: PLR2004 - the next one
            a_q, at = a, 0.75
        else:
            faster = h * (7.0 * (a_0 + a_1) + 32.0 * (a_q + a) + 12.0 * a_m) / 90.0
            further = h * h * (7.0 * a_0 + 24.0 * a_q + 6.0 * a_m + 8.0 * a) / 90.0
            error = SURE * (base * abs(v + faster - v_1) + abs(q + h * v + further - q_1))
            error += ROUNDING * base * abs(v_1)
        if stage >= 3:  # noqa: PLR2004 - on the parabola
            v_s = v + h * at * (a_0 + at * (0.5 * slope + at * bend * 2.0 / 3.0))
            q_s = q + h * at * (v + h * at * (0.5 * a_0 + at * (slope + at * bend) / 6.0))
    return q_1, v_1, a_1, error, rate
