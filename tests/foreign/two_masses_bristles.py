"""A motor and a load that a spring with play joins, each on bristles, by plain small steps.

    M_m v_m' = F + kp (goal − q_m) − kd v_m − T − F_f,m,    M v' = η T − g_sin sin q − F_f

Bristles of either side bend by explicit steps: LuGre's and Dahl's, or elements of Maxwell slip with
levels that fall and lag (GMS). F and the goal are straight lines between samples.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from .clock import Array
from .combined import Elements
from .presliding import LuGre, bending
from .two_masses import coupled

#: A law of the other kind, where a side has one of the first.
_NO_LUGRE = LuGre(1.0, 0.0, 1.0, 1.0, 1.0, 0.0)
_NO_ELEMENTS = Elements(np.empty(0), np.empty(0), 0.0, 1.0, 1.0, 1.0)


class Axis(NamedTuple):
    """Two masses, what joins them, the motor's loop, gravity, and what the coupling passes on."""

    M_m: float
    M: float
    stiffness: float
    damping: float = 0.0
    play: float = 0.0
    kp: float = 0.0
    kd: float = 0.0
    g_sin: float = 0.0
    eta: float = 1.0
    eta_back: float = 1.0


def simulate(
    axis: Axis, motor: LuGre | Elements, load: LuGre | Elements, t: Array, sub: int,
    drive: Array | None = None, goal: Array | None = None,
) -> Array:  # fmt: skip
    """Position and velocity of the motor, then of the load, (4, N), from rest at 0.

    Args:
        axis: All of it but friction.
        motor: Friction of the motor.
        load: Friction of the load.
        t: Samples, (N,).
        sub: Steps from sample to sample.
        drive: Force of the motor, (N,).
        goal: Position that it is asked for, (N,).
    """
    laws = [
        (LuGre(*map(float, law)), _NO_ELEMENTS)
        if isinstance(law, LuGre)
        else (_NO_LUGRE, Elements(law[0], law[1], *map(float, law[2:])))
        for law in (motor, load)
    ]
    none = np.zeros(len(t))
    moved: Array = _steps(
        Axis(*map(float, axis)), *laws[0], *laws[1], t, sub, none if drive is None else drive,
        none if goal is None else goal,
    )  # fmt: skip
    return moved


@njit  # type: ignore[untyped-decorator]
def _friction(bristles: LuGre, elements: Elements, v: float, state: Array) -> float:
    """The friction of a side; its state is one bristle's, or of each element share and slip."""
    n = len(elements.levels)
    if n == 0:
        bends = bending(state[0], v, bristles)
        return bristles.sigma_0 * float(state[0]) + bristles.sigma_1 * bends + bristles.F_V * v
    total = elements.F_V * v
    for j in range(n):
        total += float(elements.levels[j] * state[j])
    return total


@njit  # type: ignore[untyped-decorator]
def _bent(
    bristles: LuGre, elements: Elements, before: float, v: float, h: float, state: Array
) -> None:
    """A side's state a step of h later, at a velocity v after another one."""
    n = len(elements.levels)
    if n == 0:
        state[0] += h * bending(state[0], v, bristles)
        return
    way = 1.0 if v >= 0.0 else -1.0
    level = 1.0 + (elements.ratio - 1.0) * math.exp(-((v / elements.v_s) ** 2))
    for j in range(n):
        if v * before <= 0.0:
            state[n + j] = 0.0
        if state[n + j] > 0.0:
            state[j] += h * (way - state[j] / level) / elements.tau
        else:
            state[j] += h * v / elements.yields[j]
            if way * state[j] >= level:
                state[j], state[n + j] = way * level, 1.0


@njit  # type: ignore[untyped-decorator]
def _steps(
    axis: Axis, bristles_m: LuGre, elements_m: Elements, bristles: LuGre, elements: Elements,
    t: Array, sub: int, drive: Array, goal: Array,
) -> Array:  # fmt: skip
    out = np.empty((4, len(t)))
    z_m, z = np.zeros(2 * len(elements_m.levels) + 1), np.zeros(2 * len(elements.levels) + 1)
    q, v, q_m, v_m, twist = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(t)):
        out[0, i], out[1, i], out[2, i], out[3, i] = q_m, v_m, q, v
        if i + 1 == len(t):
            break
        h = (t[i + 1] - t[i]) / sub
        for j in range(sub):
            F = drive[i] + j / sub * (drive[i + 1] - drive[i])
            F += axis.kp * (goal[i] + j / sub * (goal[i + 1] - goal[i]) - q_m) - axis.kd * v_m
            T, twist = coupled(q_m - q, twist, axis.play, axis.stiffness, axis.damping, h)
            passed = T * (axis.eta if T * v >= 0.0 else 1.0 / axis.eta_back)
            old_m, old = v_m, v
            v_m += h * (F - T - _friction(bristles_m, elements_m, v_m, z_m)) / axis.M_m
            pull = passed - axis.g_sin * math.sin(q)
            v += h * (pull - _friction(bristles, elements, v, z)) / axis.M
            q_m += h * v_m
            q += h * v
            _bent(bristles_m, elements_m, old_m, v_m, h, z_m)
            _bent(bristles, elements, old, v, h, z)
    return out
