"""A rod that two pressures drive, under a loop of its position (docs/forces.md, `two-chambers`).

    M a = p A - p_b A_b - offset - (F_C + mu |p - p_b|) sgn v - F_V v

A controller asks for a force; each pressure follows its share of it about a mean with a first-order
lag. Explicit steps, sticking as in `friction`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, steps_in
from .friction import acting, next_velocity


class Chambers(NamedTuple):
    """Constants, SI: mu in N/Pa, areas of the two chambers, the lag of the valve, the loop."""

    M: float
    F_C: float
    F_V: float
    mu: float
    offset: float = 0.0
    area: float = np.pi / 4 * 0.05**2
    ring: float = np.pi / 4 * (0.05**2 - 0.02**2)
    mean: float = 3e5
    lag: float = 5e-3
    kp: float = 2e4
    kd: float = 1.5e3


class ChamberMotion(NamedTuple):
    """A motion; `friction` is what acts."""

    t: Array
    position: Array
    velocity: Array
    pressure: Array
    back_pressure: Array
    friction: Array


def simulate(
    axis: Chambers, command: Array, rise: Array, dt: float = 1e-3, h: float = 1e-5
) -> ChamberMotion:
    """A motion from rest at the first command, both chambers at their mean.

    Args:
        axis: the constants.
        command: positions at the samples.
        rise: what is added to both pressures at the samples, in proportion to the areas, Pa.
        dt: from sample to sample.
        h: the step.
    """
    axis = Chambers(*(float(constant) for constant in axis))
    rows = _run(axis, command, rise, steps_in(dt, h), dt, h)
    return ChamberMotion(dt * np.arange(len(command)), *rows)


@compiled
def _run(c: Chambers, command: Array, rise: Array, every: int, dt: float, h: float) -> Array:
    rows = np.empty((5, len(command)))
    x, v, force = command[0], 0.0, 0.0
    for n in range(len(command)):
        speed = (command[min(n + 1, len(command) - 1)] - command[n]) / dt
        for i in range(every):
            asked = c.kp * (command[n] + i * h * speed - x) + c.kd * (speed - v)
            force += h * (asked - force) / c.lag
            base = c.mean + rise[n]
            p = base + 0.5 * force / c.area
            back = (base * c.area - 0.5 * force) / c.ring
            drive = p * c.area - back * c.ring - c.offset
            rub = c.F_C + c.mu * abs(p - back) + c.F_V * abs(v)
            if i == 0:
                rows[0, n], rows[1, n], rows[2, n] = x, v, p
                rows[3, n], rows[4, n] = back, acting(v, drive, rub, rub)
            v = next_velocity(v, drive, rub, rub, c.M, h)
            x += h * v
    return rows
