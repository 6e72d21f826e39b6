"""A motor and a load that a spring with play joins, by plain small steps.

Written from the equations of the two bodies: the motor's velocity and the load's are moved on by
what acts on each, Coulomb friction stops a body within a step and holds what it can, and the play
is a body without mass between the flanks that the spring and its damper push. Nothing is shared
with the stepper under test.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit  # type: ignore[untyped-decorator]
def slowed(v: float, change: float, grip: float) -> float:
    """A velocity after a step of so much change of it, against friction that can take `grip`."""
    free = v + change
    if abs(free) <= grip:
        return 0.0
    return free - math.copysign(grip, free)


@njit  # type: ignore[untyped-decorator]
def coupled(
    ahead: float, twist: float, play: float, k: float, d: float, h: float
) -> tuple[float, float]:
    """Force and twist of the spring, by which the motor is ahead, a step of h after a twist."""
    # The flank moves so that the spring is relaxed, unless it is at an end of the play.
    relaxed = twist * math.exp(-k * h / d) if d > 0 else 0.0
    b_new = min(max(ahead - relaxed, -play / 2), play / 2)
    if play > 0 and abs(b_new) < play / 2:
        return 0.0, ahead - b_new
    new = ahead - b_new
    T = k * new + d * (new - twist) / h
    if play > 0 and T * b_new < 0.0:  # it would pull: the flank is left
        return 0.0, relaxed
    return T, new


@njit  # type: ignore[untyped-decorator]
def _steps(t: Array, drive: Array, goal: Array, c: Array, sub: int, out: Array) -> None:
    """Positions of motor and load at the samples, into `out` (2, N); see `simulate`."""
    (m_m, m, k, d, play, kp, kd, C_m, V_m, C_l, V_l, S_l, v_s, g_s, a0, eta, eta_back) = c
    q, v, q_m, v_m = 0.0, 0.0, a0, 0.0
    twist = 0.0
    for i in range(len(t)):
        out[0, i], out[1, i] = q_m, q
        if i + 1 == len(t):
            break
        h = (t[i + 1] - t[i]) / sub
        for j in range(sub):
            share = j / sub
            F = drive[i] + share * (drive[i + 1] - drive[i])
            wish = goal[i] + share * (goal[i + 1] - goal[i])
            F += kp * (wish - q_m) - kd * v_m
            T, twist = coupled(q_m - q, twist, play, k, d, h)
            v_m = slowed(v_m, h * (F - T - V_m * v_m) / m_m, h * C_m / m_m)
            level = C_l
            if v_s > 0:
                level = C_l + (S_l - C_l) * math.exp(-((v / v_s) ** 2))
            T *= eta if T * v >= 0.0 else 1.0 / eta_back
            v = slowed(v, h * (T - V_l * v - g_s * math.sin(q)) / m, h * level / m)
            q_m += h * v_m
            q += h * v


def simulate(
    values: Mapping[str, float],
    t: Array,
    sub: int,
    *,
    drive: Array | None = None,
    goal: Array | None = None,
) -> tuple[Array, Array]:
    """Positions of the motor and of the load at the samples, (N,) each, from rest at 0.

    Args:
        values: M_m and M, stiffness, damping and play, kp and kd of the motor's controller, F_C
            and F_V of both sides (`_motor`), F_S and v_SS of the load, g_sin, `ahead` at the
            start; 0 for what is not there.
        t: Samples, (N,).
        sub: Steps from sample to sample.
        drive: Force of the motor, (N,).
        goal: Position that it is asked for, (N,).
    """
    get = values.get
    c = np.array([
        values["M_m"], values["M"], values["stiffness"], get("damping", 0.0), get("play", 0.0),
        get("kp", 0.0), get("kd", 0.0), get("F_C_motor", 0.0), get("F_V_motor", 0.0),
        get("F_C", 0.0), get("F_V", 0.0), get("F_S", 0.0), get("v_SS", 0.0), get("g_sin", 0.0),
        get("ahead", 0.0), get("eta", 1.0), get("eta_back", 1.0),
    ])  # fmt: skip
    out = np.empty((2, len(t)))
    none = np.zeros(len(t))
    _steps(t, none if drive is None else drive, none if goal is None else goal, c, sub, out)
    return out[0], out[1]
