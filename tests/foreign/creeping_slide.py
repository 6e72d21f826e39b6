"""The slide bed of `slide_bed.py` under two laws that hold it by no level of their own.

Makkar's law is a function of the velocity, LuGre's has a bristle that bends. Heun's rule: the
acceleration at both ends of a step, second order; half a step, a quarter of the error.
"""

from __future__ import annotations

from math import exp, tanh

import numpy as np

from . import compiled
from .clock import Array, line, segment, steps_in
from .slide_bed import Bed, _acceleration


@compiled
def _friction(makkar: bool, p: Array, v: float, z: float) -> tuple[float, float]:
    """The force of friction, and how fast the bristle bends."""
    if makkar:
        drop = p[0] * (tanh(p[1] * v) - tanh(p[2] * v))
        return drop + p[3] * tanh(p[4] * v) + p[5] * v, 0.0
    sigma_0, sigma_1, F_S, F_C, v_s, F_V = p[0], p[1], p[2], p[3], p[4], p[5]
    g = F_C + (F_S - F_C) * exp(-((v / v_s) ** 2))
    bends = v - sigma_0 * abs(v) / g * z
    return sigma_0 * z + sigma_1 * bends + F_V * v, bends


@compiled
def _slopes(
    bed: Bed, makkar: bool, p: Array, stretch: float, v: float, z: float
) -> tuple[float, float]:
    motor = (bed.k_hat_up if stretch > 0.0 else bed.k_hat_down) * stretch
    spring = (bed.k_spring_up if stretch > 0.0 else bed.k_spring_down) * stretch
    drive = motor - min(max(motor, -bed.F_fm), bed.F_fm) + spring
    force, bends = _friction(makkar, p, v, z)
    return _acceleration(bed, drive - force, v), bends


@compiled
def _run(
    bed: Bed, makkar: bool, p: Array, times: Array, command: Array, samples: int, every: int,
    h: float,
) -> Array:  # fmt: skip
    rows = np.empty((2, samples))
    x, v, z, k = command[0], 0.0, 0.0, 0
    for i in range((samples - 1) * every + 1):
        if i % every == 0:
            rows[0, i // every], rows[1, i // every] = x, v
        k = segment(i * h, k, times)
        a, b = _slopes(bed, makkar, p, line(i * h, k, times, command) - x, v, z)
        x_1, v_1, z_1 = x + h * v, v + h * a, z + h * b
        k = segment((i + 1) * h, k, times)
        a_1, b_1 = _slopes(bed, makkar, p, line((i + 1) * h, k, times, command) - x_1, v_1, z_1)
        x += 0.5 * h * (v + v_1)
        v += 0.5 * h * (a + a_1)
        z += 0.5 * h * (b + b_1)
    return rows


def simulate(
    bed: Bed, law: str, p: Array, times: Array, command: Array, h: float, dt: float = 0.01
) -> tuple[Array, Array]:
    """Positions and velocities every dt, from rest where the command begins.

    Args:
        bed: constants.
        law: `makkar` or `lugre`.
        p: its parameters, in the order of `docs/laws.md`.
        times: instants of the command, the first 0.
        command: its positions, a straight line between them.
        h: the step.
        dt: from sample to sample.
    """
    bed = Bed(*(float(constant) for constant in bed))
    samples = int(times[-1] / dt + 1e-9) + 1
    rows = _run(bed, law == "makkar", p, times, command, samples, steps_in(dt, h), h)
    return rows[0], rows[1]
