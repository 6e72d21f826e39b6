"""EMPS: a slide under a sampled position and velocity cascade (docs/validation.md).

    u_k = clip(kv (kp (q_ref,k - q_k) - (q_k - q_k-2) / 2T), u_max)
    M dv/dt = gtau u - F_f - offset

The velocity is the difference of a mean of two positions; u is held for T, from `delay` after its
sample on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, steps_in
from .friction import Curve, acting, as_floats, level, next_velocity


class Cascade(NamedTuple):
    """The published axis."""

    M: float = 95.1089
    offset: float = -3.1648
    kp: float = 160.18
    kv: float = 243.45
    gtau: float = 35.1507
    u_max: float = 10.0
    T: float = 1e-3
    delay: float = 1e-3


class CascadeMotion(NamedTuple):
    """A motion; `voltage` is what the controller writes at the sample, `force` what acts then."""

    t: Array
    position: Array
    velocity: Array
    command: Array
    voltage: Array
    force: Array
    friction: Array


def simulate(
    cascade: Cascade, plus: Curve, minus: Curve, command: Array, h: float = 1e-5
) -> CascadeMotion:
    """A motion from rest at the first command, one command and one sample a tick of the clock.

    Args:
        cascade: constants.
        plus: friction to the right.
        minus: friction to the left.
        command: positions.
        h: the step.
    """
    cascade = Cascade(*(float(constant) for constant in cascade))
    late = 0 if cascade.delay == 0.0 else steps_in(cascade.delay, h)
    rows = _run(
        cascade, as_floats(plus), as_floats(minus), command, steps_in(cascade.T, h), late, h
    )
    t = cascade.T * np.arange(len(command))
    return CascadeMotion(t, rows[0], rows[1], command.copy(), rows[2], rows[3], rows[4])


@compiled
def _run(
    c: Cascade, plus: Curve, minus: Curve, command: Array, tick: int, late: int, h: float
) -> Array:
    rows = np.empty((5, len(command)))
    x, v, u, force = command[0], 0.0, 0.0, 0.0
    last, before_last = x, x
    for i in range((len(command) - 1) * tick + 1):
        n = i // tick
        if i % tick == 0:
            if late == tick and i > 0:
                force = c.gtau * u  # of the tick before
            u = c.kv * (c.kp * (command[n] - x) - (x - before_last) / (2.0 * c.T))
            u = min(max(u, -c.u_max), c.u_max)
            last, before_last = x, last
        if i % tick == late:
            force = c.gtau * u
        up, down = level(abs(v), plus), level(abs(v), minus)
        drive = force - c.offset
        if i % tick == 0:
            rows[0, n], rows[1, n], rows[2, n] = x, v, u
            rows[3, n], rows[4, n] = force, acting(v, drive, up, down)
        v = next_velocity(v, drive, up, down, c.M, h)
        x += h * v
    return rows
