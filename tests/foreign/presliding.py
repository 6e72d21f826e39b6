"""A mass on bristles (docs/rigs.md, `presliding`): Dahl, LuGre, Maxwell slip (docs/laws.md).

    M dv/dt = F + spring (end - x) - offset - F_f

F and the spring's end are straight lines between their samples. Bristles bend by explicit steps.
"""

from __future__ import annotations

from math import exp
from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, line, segment, steps_in


class LuGre(NamedTuple):
    """F_f = sigma_0 z + sigma_1 z' + F_V v; Dahl's law (exponent 1) is F_S = F_C, sigma_1 = 0."""

    sigma_0: float
    sigma_1: float
    F_S: float
    F_C: float
    v_s: float
    F_V: float


class BristleMotion(NamedTuple):
    """A motion; `force` is F and the spring's, `friction` what acts, `end` the spring's end."""

    t: Array
    position: Array
    velocity: Array
    force: Array
    end: Array
    friction: Array


def dahl(sigma_0: float, F_C: float, F_V: float = 0.0) -> LuGre:
    """Dahl's law with its exponent 1."""
    return LuGre(sigma_0, 0.0, F_C, F_C, 1.0, F_V)


def simulate(
    mass: float, law: LuGre | tuple[Array, Array, float], times: Array, force: Array,
    end: Array | None = None, spring: float = 0.0, offset: float = 0.0, dt: float = 1e-3,
    h: float = 1e-5,
) -> BristleMotion:  # fmt: skip
    """A motion from rest at 0, the bristles as the first force has bent them out of rest.

    Args:
        mass: of the axis.
        law: LuGre's parameters, or of Maxwell slip the levels W_i, the displacements d_i at which
            they slip, and F_V.
        times: instants of the force, the first 0.
        force: on the axis.
        end: positions of a spring's other end.
        spring: its stiffness.
        offset: constant force against the axis.
        dt: from sample to sample.
        h: the step; stable while sqrt(stiffness / mass) h is far below 1.
    """
    every, samples = steps_in(dt, h), int(times[-1] / dt + 1e-9) + 1
    ends = np.zeros_like(force) if end is None else end
    numbers = (float(mass), float(spring), float(offset))
    first = force[0] + spring * ends[0] - offset
    if isinstance(law, LuGre):
        law = LuGre(*(float(parameter) for parameter in law))
        rows = _run_lugre(law, first / law.sigma_0, numbers, times, force, ends, samples, every, h)
    else:
        levels, yields = (np.asarray(values, float) for values in law[:2])
        way = np.concatenate([[0.0], np.sort(yields)])
        loads = np.minimum(way[:, None] / yields, 1.0) @ levels  # of the virgin curve
        bent = np.clip(np.sign(first) * np.interp(abs(first), loads, way) / yields, -1.0, 1.0)
        rows = _run_maxwell(
            levels, yields, bent, float(law[2]), numbers, times, force, ends, samples, every, h
        )
    return BristleMotion(dt * np.arange(samples), *rows)


@compiled
def bending(z: float, v: float, law: LuGre) -> float:
    """z'."""
    g = law.F_C + (law.F_S - law.F_C) * exp(-((v / law.v_s) ** 2))
    return v - law.sigma_0 * abs(v) * z / g


@compiled
def _run_lugre(
    law: LuGre, z: float, numbers: tuple[float, float, float], times: Array, force: Array,
    end: Array, samples: int, every: int, h: float,
) -> Array:  # fmt: skip
    rows = np.empty((5, samples))
    mass, spring, offset = numbers
    x, v, k = 0.0, 0.0, 0
    for i in range((samples - 1) * every + 1):
        t = i * h
        k = segment(t, k, times)
        goal = line(t, k, times, end)
        drive = line(t, k, times, force) + spring * (goal - x)
        friction = law.sigma_0 * z + law.sigma_1 * bending(z, v, law) + law.F_V * v
        if i % every == 0:
            n = i // every
            rows[0, n], rows[1, n], rows[2, n] = x, v, drive
            rows[3, n], rows[4, n] = goal, friction
        v += h * (drive - offset - friction) / mass
        z += h * bending(z, v, law)
        x += h * v
    return rows


@compiled
def _run_maxwell(
    levels: Array, yields: Array, bent: Array, viscous: float, numbers: tuple[float, float, float],
    times: Array, force: Array, end: Array, samples: int, every: int, h: float,
) -> Array:  # fmt: skip
    rows = np.empty((5, samples))
    mass, spring, offset = numbers
    x, v, k = 0.0, 0.0, 0
    for i in range((samples - 1) * every + 1):
        t = i * h
        k = segment(t, k, times)
        goal = line(t, k, times, end)
        drive = line(t, k, times, force) + spring * (goal - x)
        friction = viscous * v
        for j in range(len(levels)):
            friction += levels[j] * bent[j]
        if i % every == 0:
            n = i // every
            rows[0, n], rows[1, n], rows[2, n] = x, v, drive
            rows[3, n], rows[4, n] = goal, friction
        v += h * (drive - offset - friction) / mass
        x += h * v
        for j in range(len(levels)):
            bent[j] = min(max(bent[j] + h * v / yields[j], -1.0), 1.0)
    return rows
