"""Steps of a slide that creeps, as long as its motion allows: extrapolated, stiff or not.

In the acceleration's units of `event_driven`,

    dv/dt = offset + slope e − damping v − inverse F_f(v, z),   de/dt = rate − v,

a step of implicit Euler of h seconds solves one scalar equation for its velocity w,

    w (1 + h damping + h² slope) + h inverse F_f(w, z after h at w)
        = v + h (offset + slope (e + h rate)),

in which the law itself advances its states z, exactly or stably for any h. One, two, three and four
such steps over the same span are extrapolated to order 4 (Deuflhard 1985, doi 10.1137/1027140;
Hairer, Wanner, Solving Ordinary Differential Equations II, IV.9): what is too quick to be followed
fades. Where nothing is, one, two and three steps of the implicit midpoint rule, which is symmetric
in time, are extrapolated to order 6: for z it takes the middle of a span at one velocity. The
difference from the order below is the error.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...compile_cache import compiled
from ...space import Array
from .event_driven import Piece
from .velocity import downhill, rubs

#: Weights of implicit Euler's one, two, ... steps for order 4 and 3, and of the implicit midpoint
#: rule's for order 6 and 4.
EULER = np.array([-1.0 / 6.0, 4.0, -13.5, 32.0 / 3.0])
EULER_LOWER = np.array([0.0, 2.0, -9.0, 8.0])
MIDPOINT = np.array([1.0 / 24.0, -16.0 / 15.0, 81.0 / 40.0])
MIDPOINT_LOWER = np.array([0.0, -0.8, 1.8])
#: How steeply friction rises before that is asked, 1/s; it is 0 where secants did not tell.
UNKNOWN = 1e-30
#: Its share of the way by which the velocities of a stiff step tell that it jumped something.
JUMPED = 100.0
#: Secants for a velocity before it is bracketed.
_SECANTS = 6


@compiled(forceinline=True)
def _velocity(
    slip: Any, rub: Any, general: bool, inverse: float, A: float, B: float, h: float, v: float,
    guess: float, fine: float, z: Array, load: Array, p: Array, out: Array, slopes: Array, at: int,
) -> float:  # fmt: skip
    """The velocity w that solves A w + h inverse F_f(w) = B, by secants from a guess, else from v.

    `slopes[at]` is how steeply friction rose when it was last asked. The law's states after h at a
    velocity that differs from w by less than `fine` are in `out`.
    """
    w = guess
    g = A * w + h * rubs(slip, rub, general, inverse, w, h, z, load, p, out) - B
    step = -g / (A + h * slopes[at])
    if abs(step) <= fine:
        return w + step  # type: ignore[no-any-return]
    for _ in range(_SECANTS):
        other = w + step
        g_other = A * other + h * rubs(slip, rub, general, inverse, other, h, z, load, p, out) - B
        slope = (g_other - g) / step
        if not slope > 0.0:
            break
        w, g, step = other, g_other, -g_other / slope
        if abs(step) <= fine:
            slopes[at] = max((slope - A) / h, -0.5 * A / h)
            return w + step  # type: ignore[no-any-return]
    slopes[at] = 0.0
    w = downhill(slip, rub, general, inverse, A, B, h, v, z, load, p, out)
    rubs(slip, rub, general, inverse, w, h, z, load, p, out)
    return w  # type: ignore[no-any-return]


@compiled(forceinline=True)
def acceleration_at(
    slip: Any, rub: Any, general: bool, p: Array, load: Array, piece: Piece, e: float, v: float,
    z: Array, out: Array,
) -> float:  # fmt: skip
    """The acceleration in an instant."""
    friction = rubs(slip, rub, general, piece.inverse, v, 0.0, z, load, p, out)
    return piece.offset + piece.slope * e - piece.damping * v - friction  # type: ignore[no-any-return]


@compiled()
def stiff_step(
    slip: Any, rub: Any, general: bool, p: Array, load: Array, piece: Piece, e: float, v: float,
    a: float, rate: float, h: float, fine: float, z: Array, states: Array, slopes: Array,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """A stiff step of h: travel, velocity and acceleration at its end, and errors of the first two.

    The law's states go on from `z` into `states[0]`; the next two rows are for steps within.
    """
    n = len(z)
    end, here, there = states[0], states[1], states[2]
    end[:] = 0.0
    travel, w_end, low_travel, low_w, a_end, middle = 0.0, 0.0, 0.0, 0.0, a, 0.0
    for j in range(len(EULER)):
        hn = h / (j + 1)
        A = 1.0 + hn * piece.damping + hn * hn * piece.slope
        ahead, moved, w, before, earlier = e, 0.0, v, v - hn * a, v - 2.0 * hn * a
        for i in range(n):
            here[i] = z[i]
        for i in range(j + 1):
            B = w + hn * (piece.offset + piece.slope * (ahead + hn * rate))
            new = _velocity(
                slip, rub, general, piece.inverse, A, B, hn, w, 2.0 * w - before, fine, here,
                load, p, there, slopes, j,
            )  # fmt: skip
            here, there = there, here
            ahead += hn * (rate - new)
            moved += hn * new
            earlier, before, w = before, w, new
            if 2 * (i + 1) == j + 1:
                middle = 2.0 * new - middle if j > 1 else new
        travel += EULER[j] * moved
        w_end += EULER[j] * w
        low_travel += EULER_LOWER[j] * moved
        low_w += EULER_LOWER[j] * w
        for i in range(n):
            end[i] += EULER[j] * here[i]
        a_end = (1.5 * w - 2.0 * before + 0.5 * earlier) / hn
    # What fades within a step has moved the slide before: its velocities by Simpson's rule tell.
    jumped = abs(h * (v + 4.0 * middle + w_end) / 6.0 - travel) / JUMPED
    return travel, w_end, a_end, max(abs(travel - low_travel), jumped), abs(w_end - low_w)


@compiled()
def smooth_step(
    slip: Any, rub: Any, general: bool, p: Array, load: Array, piece: Piece, e: float, v: float,
    a: float, rate: float, h: float, fine: float, z: Array, states: Array, slopes: Array,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """The same of a step that nothing is stiff in, by the implicit midpoint rule."""
    n = len(z)
    end, here, there = states[0], states[1], states[2]
    end[:] = 0.0
    travel, v_end, low_travel, low_v = 0.0, 0.0, 0.0, 0.0
    for j in range(len(MIDPOINT)):
        hn = h / (j + 1)
        half = 0.5 * hn
        A = 1.0 + half * piece.damping + half * half * piece.slope
        ahead, moved, now, guess, before = e, 0.0, v, v + half * a, v - half * a
        for i in range(n):
            here[i] = z[i]
        for _ in range(j + 1):
            B = now + half * (piece.offset + piece.slope * (ahead + half * rate))
            w = _velocity(
                slip, rub, general, piece.inverse, A, B, half, now, guess, fine, here, load, p,
                there, slopes, j,
            )  # fmt: skip
            if n > 0:
                rub(w, hn, here, load, p, there)
                here, there = there, here
            ahead += hn * (rate - w)
            moved += hn * w
            now = 2.0 * w - now
            before, guess = w, 2.0 * w - before
        travel += MIDPOINT[j] * moved
        v_end += MIDPOINT[j] * now
        low_travel += MIDPOINT_LOWER[j] * moved
        low_v += MIDPOINT_LOWER[j] * now
        for i in range(n):
            end[i] += MIDPOINT[j] * here[i]
    a_end = acceleration_at(
        slip, rub, general, p, load, piece, e + h * rate - travel, v_end, end, there
    )
    return travel, v_end, a_end, abs(travel - low_travel), abs(v_end - low_v)
