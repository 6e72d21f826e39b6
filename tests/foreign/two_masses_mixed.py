"""A motor under Coulomb friction and a load on a bristle, joined by a spring with play.

    M_m v_m' = kp (goal − q_m) − kd v_m − T − F_f,m,    M v' = T − F_f

By plain small steps, of which each slows the motor by what its friction can take, and bends the
bristle; the goal is a straight line between samples.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .clock import Array
from .presliding import LuGre, bending
from .two_masses import coupled, slowed
from .two_masses_bristles import Axis


@njit  # type: ignore[untyped-decorator]
def _steps(
    axis: Axis, F_C: float, F_V: float, bristle: LuGre, t: Array, sub: int, goal: Array
) -> Array:
    out = np.empty((2, len(t)))
    q, v, q_m, v_m, twist, z = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(t)):
        out[0, i], out[1, i] = q_m, q
        if i + 1 == len(t):
            break
        h = (t[i + 1] - t[i]) / sub
        for j in range(sub):
            wish = goal[i] + j / sub * (goal[i + 1] - goal[i])
            T, twist = coupled(q_m - q, twist, axis.play, axis.stiffness, axis.damping, h)
            F = axis.kp * (wish - q_m) - axis.kd * v_m - T - F_V * v_m
            v_m = slowed(v_m, h * F / axis.M_m, h * F_C / axis.M_m)
            bends = bending(z, v, bristle)
            v += h * (T - bristle.sigma_0 * z - bristle.sigma_1 * bends - bristle.F_V * v) / axis.M
            z += h * bends
            q_m += h * v_m
            q += h * v
    return out


def simulate(
    axis: Axis, F_C: float, F_V: float, bristle: LuGre, t: Array, sub: int, goal: Array
) -> Array:
    """Positions of the motor and of the load at the samples, (2, N), from rest at 0.

    Args:
        axis: All of it but friction.
        F_C: Coulomb friction of the motor.
        F_V: Its viscous friction.
        bristle: Friction of the load.
        t: Samples, (N,).
        sub: Steps from sample to sample.
        goal: Position that the motor is asked for, (N,).
    """
    moved: Array = _steps(
        Axis(*map(float, axis)), F_C, F_V, LuGre(*map(float, bristle)), t, sub, goal
    )
    return moved
