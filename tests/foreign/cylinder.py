"""A cylinder on a testing machine: rod force and pressure measured (docs/forces.md, `cylinder`).

    F - p A = M a + F_f + b p + offset,    F_f = (F_C + mu_p |p|) sgn v + F_V v

The machine's head moves at a given speed, whatever it takes, and the rod with it through the load
cell, a stiff damped spring: F is what the cell shows. The speed has no jumps: a
damper would make spikes of them that a sampled force shows and a sampled position does not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, line, segment, steps_in
from .friction import acting, next_velocity


class Cylinder(NamedTuple):
    """Constants, SI: mu_p and b in N/Pa; cell and damping between the machine's head and the rod.

    A cell of 2e5 N/m on 2 kg with 1000 N s/m is damped by 0.8 of the critical.
    """

    M: float
    F_C: float
    F_V: float
    mu_p: float
    bore: float = 0.025
    b: float = 0.0
    offset: float = 0.0
    cell: float = 2e5
    damping: float = 1000.0


class CylinderMotion(NamedTuple):
    """A motion; `force` is the rod's, `friction` what acts, `command` the machine's head."""

    t: Array
    position: Array
    velocity: Array
    command: Array
    force: Array
    pressure: Array
    friction: Array


def simulate(
    cylinder: Cylinder, times: Array, speed: Array, pressure: Array, dt: float = 1e-3,
    h: float = 1e-5,
) -> CylinderMotion:  # fmt: skip
    """A motion from rest at 0, the cell loaded by the first pressure so that nothing moves.

    Args:
        cylinder: the constants.
        times: instants of speed and pressure, the first 0.
        speed: of the machine's head, straight lines in between.
        pressure: in Pa, straight lines in between.
        dt: from sample to sample.
        h: the step.
    """
    cylinder = Cylinder(*(float(constant) for constant in cylinder))
    every, samples = steps_in(dt, h), int(times[-1] / dt + 1e-9) + 1
    rows = _run(cylinder, times, speed, pressure, samples, every, h)
    return CylinderMotion(dt * np.arange(samples), *rows)


@compiled
def _run(
    c: Cylinder, times: Array, speed: Array, pressure: Array, samples: int, every: int, h: float
) -> Array:
    rows = np.empty((6, samples))
    area = np.pi * c.bore**2 / 4.0
    slack = (pressure[0] * (area + c.b) + c.offset) / c.cell  # head over rod at the start
    x, v, head, k = 0.0, 0.0, 0.0, 0
    for i in range((samples - 1) * every + 1):
        t = i * h
        k = segment(t, k, times)
        pace, p = line(t, k, times, speed), line(t, k, times, pressure)
        force = c.cell * (head + slack - x) + c.damping * (pace - v)
        drive = force - p * (area + c.b) - c.offset
        rub = c.F_C + c.mu_p * abs(p) + c.F_V * abs(v)
        if i % every == 0:
            n = i // every
            rows[0, n], rows[1, n], rows[2, n] = x, v, head
            rows[3, n], rows[4, n], rows[5, n] = force, p, acting(v, drive, rub, rub)
        v = next_velocity(v, drive, rub, rub, c.M, h)
        x += h * v
        head += h * pace
    return rows
