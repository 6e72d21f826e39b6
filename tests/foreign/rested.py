"""A mass that a control loop moves, on a contact that grows together at rest (docs/laws.md).

    M a = F - offset - F_f

F is the drive's, held from tick to tick, as in `driven`. The contact is a spring up to its level,
F_C + (F_S - F_C) s. At rest, below a tenth of v_s, s rises with the time of rest t from where the
slide has left it, s_a + (1 - s_a) t / (t + gamma); in a slide it falls to what it was at its
beginning over 1 + r^2, r = |v| / v_s - 1/10, with a lag tau_L. All by explicit steps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, segment, steps_in
from .combined import CombinedMotion
from .driven import Loop, asked


class Rested(NamedTuple):
    """Armstrong's seven parameters."""

    sigma_0: float
    F_S: float
    F_C: float
    v_s: float
    F_V: float
    gamma: float
    tau_L: float


def simulate(
    mass: float, law: Rested, loop: Loop, times: Array, command: Array, offset: float = 0.0,
    dt: float = 1e-3, h: float = 1e-5,
) -> CombinedMotion:  # fmt: skip
    """A motion from rest at the first command, after a long rest; arguments as of `combined`."""
    speed = np.gradient(command, times)
    goals = np.vstack([command, speed, np.gradient(speed, times)])
    every, samples = steps_in(dt, h), int(times[-1] / dt + 1e-9) + 1
    rows = _run(
        float(mass), float(offset), Rested(*(float(x) for x in law)),
        Loop(*(float(constant) for constant in loop)), times, goals, samples, every,
        steps_in(loop.tick, h), h,
    )  # fmt: skip
    return CombinedMotion(dt * np.arange(samples), *rows)


@compiled
def _run(
    mass: float, offset: float, law: Rested, loop: Loop, times: Array, goals: Array, samples: int,
    every: int, tick: int, h: float,
) -> Array:  # fmt: skip
    rows = np.empty((4, samples))
    x, v, bent, integral, force, k = goals[0, 0], 0.0, 0.0, 0.0, 0.0, 0
    share, at_start, at_end, rested = 1.0, 1.0, 1.0, 0.0
    for i in range((samples - 1) * every + 1):
        t = i * h
        if i % tick == 0:
            k = segment(t, k, times)
            force, integral = asked(loop, t, k, times, goals, x, v, integral)
        friction = law.sigma_0 * bent + law.F_V * v
        if i % every == 0:
            m = i // every
            rows[0, m], rows[1, m], rows[2, m], rows[3, m] = x, v, force, friction
        v += h * (force - offset - friction) / mass
        x += h * v
        r = abs(v) / law.v_s - 0.1
        if r <= 0.0:
            if rested == 0.0:
                at_end = share
            rested += h
            share = at_end + (1.0 - at_end) * rested / (rested + law.gamma)
        else:
            if rested > 0.0:
                at_start = share
            rested = 0.0
            share += h * (at_start / (1.0 + r * r) - share) / law.tau_L
        level = (law.F_C + (law.F_S - law.F_C) * share) / law.sigma_0
        bent += h * v
        if v > 0.0:
            bent = min(bent, level)
        elif v < 0.0:
            bent = max(bent, -level)
    return rows
