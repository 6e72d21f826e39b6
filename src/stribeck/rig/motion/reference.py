"""The slide bed in plain fixed steps, to be read beside section 4.3 of the paper.

Two schemes, scalar Python in the order of the paper's steps. `implicit` is the well-posed
reading (docs/physics.md): the motor's inertia solved for, then clamped, and rest found where the
velocity falls back to the band. It is of second order in the step. `paper` is the printed
procedure to the letter: explicit, the motor's inertia force taken from the last step's
acceleration, rest only where the momentum happens to lie inside its dead band. It does not
converge, and is here to show that.

Both are far too slow to search with; `compiled` runs the same functions through numba.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import njit

from ...space import Array, contiguous
from .drives import (
    BAND,
    CLAMP,
    DAMPING,
    F_FM,
    IMPULSE,
    INERTIA,
    K_HAT_M,
    K_HAT_P,
    K_SPRING_M,
    K_SPRING_P,
    MASS,
)
from .event_driven import from_zero

if TYPE_CHECKING:
    from collections.abc import Callable

    from ...friction import Law
    from .track import Track


def implicit(
    slip: Any, p: Array, c: Array, knots_t: Array, knots_x: Array, t: Array, x0: float, dt: float
) -> tuple[Array, Array]:
    """Position and velocity at the samples t, from rest at x0, in steps of dt (Heun's rule)."""
    F_S_plus, F_S_minus = slip(0.0, p), slip(-0.0, p)
    xs, vs = np.empty(len(t)), np.empty(len(t))
    time, x, v, s, P = t[0], x0, 0.0, 0.0, 0.0
    i = 0
    while i < len(t):
        step = min(dt, t[i] - time)  # a sample is always met exactly
        if s == 0.0:  # stuck
            F_now = drive(c, command(knots_t, knots_x, time) - x)
            F_next = drive(c, command(knots_t, knots_x, time + step) - x)
            excess_now = F_now - min(max(F_now, F_S_minus), F_S_plus)
            excess_next = F_next - min(max(F_next, F_S_minus), F_S_plus)
            P_next = P + 0.5 * step * (excess_now + excess_next)
            if F_S_minus <= F_next <= F_S_plus or excess_now * excess_next < 0.0:
                P_next = 0.0  # back inside the stick band, or through it in one step
            dp = c[IMPULSE]
            leaves = abs(P_next) > dp or (dp == 0.0 and P_next != 0.0)
            if leaves:  # out of the dead band: where in this step?
                s = 1.0 if P_next > 0.0 else -1.0
                share = (dp - abs(P)) / (abs(P_next) - abs(P)) if dp > 0.0 else 0.0
                time, v, P = time + share * step, s * c[BAND], 0.0
                continue
            time, P = time + step, P_next
        else:  # slip
            e = command(knots_t, knots_x, time) - x
            a = acceleration(slip, p, c, e, v, s)
            v_guess = v + step * a
            e_guess = command(knots_t, knots_x, time + step) - (x + step * v)
            a_guess = acceleration(slip, p, c, e_guess, v_guess, s)
            v_next = v + 0.5 * step * (a + a_guess)
            if s * v_next < c[BAND] and step > 0.0:  # comes to rest: where in this step?
                share = (s * v - c[BAND]) / (s * v - s * v_next)
                x += share * step * (0.5 * (v + s * c[BAND]))
                time, v, s, P = time + max(share * step, 1e-9), 0.0, 0.0, 0.0
                continue
            x += 0.5 * step * (v + v_guess)
            time, v = time + step, v_next
        if time >= t[i]:
            xs[i], vs[i] = x, v
            i += 1
    return xs, vs


def paper(
    slip: Any, p: Array, c: Array, knots_t: Array, knots_x: Array, t: Array, x0: float, dt: float,
    late: bool = True,
) -> tuple[Array, Array]:  # fmt: skip
    """The same by the printed procedure, steps 1 to 5 of section 4.3, explicit in steps of dt.

    `late`: the position is integrated after the velocity, with the new one.
    """
    F_S_plus, F_S_minus = slip(0.0, p), slip(-0.0, p)
    xs, vs = np.empty(len(t)), np.empty(len(t))
    time, x, v, dvdt, P = t[0], x0, 0.0, 0.0, 0.0
    i = 0
    while i < len(t):
        e = command(knots_t, knots_x, time) - x
        # Steps 1 and 2 and the spring force of step 4.
        F_drive = drive(c, e)
        # Step 3: from the velocity and the acceleration of the last step.
        F_m_motor = min(max(c[INERTIA] * dvdt + c[DAMPING] * v, -c[CLAMP]), c[CLAMP])
        # Step 4.
        F_in = F_drive - F_m_motor
        F_f = min(max(F_in, F_S_minus), F_S_plus) if v == 0.0 else slip(v, p)
        # Step 5.
        P += (F_in - F_f) * dt
        v_next = 0.0 if abs(P) < c[IMPULSE] else P / c[MASS]
        x += (v_next if late else v) * dt
        dvdt = (v_next - v) / dt
        v = v_next
        time += dt
        while i < len(t) and t[i] <= time:
            xs[i], vs[i] = x, v
            i += 1
    return xs, vs


def command(knots_t: Array, knots_x: Array, time: float) -> float:
    """x_i: the command between its knots, held before the first and after the last."""
    if time <= knots_t[0]:
        return knots_x[0]  # type: ignore[no-any-return]
    for j in range(1, len(knots_t)):
        if time < knots_t[j]:
            share = (time - knots_t[j - 1]) / (knots_t[j] - knots_t[j - 1])
            return knots_x[j - 1] + share * (knots_x[j] - knots_x[j - 1])  # type: ignore[no-any-return]
    return knots_x[-1]  # type: ignore[no-any-return]


def drive(c: Array, e: float) -> float:
    """F_motor - F_f_motor + F_sp of section 4.3: steps 1, 2 and the spring force of step 4."""
    F_motor = (c[K_HAT_P] if e > 0.0 else c[K_HAT_M]) * e
    F_f_motor = min(max(F_motor, -c[F_FM]), c[F_FM])
    F_sp = (c[K_SPRING_P] if e > 0.0 else c[K_SPRING_M]) * e
    return F_motor - F_f_motor + F_sp  # type: ignore[no-any-return]


def inertial(c: Array, force: float, v: float) -> float:
    """Acceleration under a net force: F_m of step 3 solved for with m a = force - F_m, clamped."""
    a = (force - c[DAMPING] * v) / (c[MASS] + c[INERTIA])
    F_m_motor = c[INERTIA] * a + c[DAMPING] * v
    if F_m_motor > c[CLAMP]:
        return (force - c[CLAMP]) / c[MASS]  # type: ignore[no-any-return]
    if F_m_motor < -c[CLAMP]:
        return (force + c[CLAMP]) / c[MASS]  # type: ignore[no-any-return]
    return a  # type: ignore[no-any-return]


def acceleration(slip: Any, p: Array, c: Array, e: float, v: float, s: float) -> float:
    """Acceleration in slip in direction s; friction stays on its side of zero speed."""
    return inertial(c, drive(c, e) - slip(v if s * v > 0.0 else s * 0.0, p), v)


@cache
def compiled(scheme: str) -> Callable[..., tuple[Array, Array]]:
    """`implicit` or `paper` through numba: the same source, fast enough to test widely with."""
    scope: dict[str, Any] = dict(globals())
    for name in ("command", "drive", "inertial", "acceleration"):
        scope[name] = njit(_rebound(globals()[name], scope))
    return njit(_rebound(globals()[scheme], scope), nogil=True)  # type: ignore[no-any-return]


def _rebound(function: Any, scope: dict[str, Any]) -> Any:
    """The same function, looking its neighbours up in another scope."""
    return type(function)(function.__code__, scope, function.__name__, function.__defaults__)


def trajectory(
    law: Law, p: Array, c: Array, track: Track, dt: float, scheme: str = "implicit"
) -> tuple[Array, Array]:
    """Position and velocity, (N,) each, of one parameter set over a track."""
    p, c = contiguous(p), contiguous(c)
    track = from_zero(track)
    return compiled(scheme)(law.slip, p, c, track.knots_t, track.knots_x, track.t, track.x0, dt)
