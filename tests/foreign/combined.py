"""A mass that a control loop moves, on LuGre's bristles or generalised Maxwell elements.

    M a = F - offset - F_f

F is the drive's, held from tick to tick, as in `driven`; friction has states (docs/laws.md), which
bend by explicit steps. An element of the generalised Maxwell slip sticks, W c' = (W/d) v, until it
reaches its level s(v) the way the axis moves; then it slides, c' = (sgn v - c/s)/tau, until the
velocity changes its sign.
"""

from __future__ import annotations

from math import exp
from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, segment, steps_in
from .driven import Loop, asked
from .presliding import LuGre, bending


class Elements(NamedTuple):
    """Levels W_i, the displacements d_i at which they slip, and what sliding is like."""

    levels: Array
    yields: Array
    F_V: float
    ratio: float
    v_s: float
    tau: float


class CombinedMotion(NamedTuple):
    """A motion; `force` is the drive's, `friction` what acts, with the sign of the velocity."""

    t: Array
    position: Array
    velocity: Array
    force: Array
    friction: Array


def simulate(
    mass: float, law: LuGre | Elements, loop: Loop, times: Array, command: Array,
    offset: float = 0.0, dt: float = 1e-3, h: float = 1e-5,
) -> CombinedMotion:  # fmt: skip
    """A motion from rest at the first command, nothing bent.

    Args:
        mass: of the axis.
        law: its friction.
        loop: what drives.
        times: instants of the command, the first 0, evenly spaced.
        command: its positions; the loop follows their central differences, straight in between.
        offset: constant force against the axis.
        dt: from sample to sample.
        h: the step; stable while sqrt(stiffness / mass) h is far below 1.
    """
    speed = np.gradient(command, times)
    goals = np.vstack([command, speed, np.gradient(speed, times)])
    loop = Loop(*(float(constant) for constant in loop))
    every, samples = steps_in(dt, h), int(times[-1] / dt + 1e-9) + 1
    bristles = law if isinstance(law, LuGre) else LuGre(1.0, 0.0, 1.0, 1.0, 1.0, 0.0)
    elements = (
        Elements(np.empty(0), np.empty(0), 0.0, 1.0, 1.0, 1.0) if isinstance(law, LuGre) else law
    )
    rows = _run(
        float(mass), float(offset), LuGre(*(float(x) for x in bristles)),
        Elements(np.asarray(elements[0], float), np.asarray(elements[1], float),
                 *(float(x) for x in elements[2:])),
        loop, times, goals, samples, every, steps_in(loop.tick, h), h,
    )  # fmt: skip
    return CombinedMotion(dt * np.arange(samples), *rows)


@compiled
def _run(  # noqa: C901 - two laws in one plain loop
    mass: float, offset: float, bristles: LuGre, elements: Elements, loop: Loop, times: Array,
    goals: Array, samples: int, every: int, tick: int, h: float,
) -> Array:  # fmt: skip
    rows = np.empty((4, samples))
    n = len(elements.levels)
    bent, slides = np.zeros(n), np.zeros(n)
    x, v, z, integral, force, k = goals[0, 0], 0.0, 0.0, 0.0, 0.0, 0
    for i in range((samples - 1) * every + 1):
        t = i * h
        if i % tick == 0:
            k = segment(t, k, times)
            force, integral = asked(loop, t, k, times, goals, x, v, integral)
        if n == 0:
            friction = bristles.sigma_0 * z + bristles.sigma_1 * bending(z, v, bristles)
            friction += bristles.F_V * v
        else:
            friction = elements.F_V * v
            for j in range(n):
                friction += elements.levels[j] * bent[j]
        if i % every == 0:
            m = i // every
            rows[0, m], rows[1, m], rows[2, m], rows[3, m] = x, v, force, friction
        before = v
        v += h * (force - offset - friction) / mass
        x += h * v
        if n == 0:
            z += h * bending(z, v, bristles)
            continue
        way = 1.0 if v >= 0.0 else -1.0
        level = 1.0 + (elements.ratio - 1.0) * exp(-((v / elements.v_s) ** 2))
        for j in range(n):
            if v * before <= 0.0:
                slides[j] = 0.0
            if slides[j] > 0.0:
                bent[j] += h * (way - bent[j] / level) / elements.tau
            else:
                bent[j] += h * v / elements.yields[j]
                if way * bent[j] >= level:
                    bent[j], slides[j] = way * level, 1.0
    return rows
