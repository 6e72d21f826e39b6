"""The paper's slide bed (docs/physics.md): a slide that a motor with friction and a spring pull.

    m a = F_motor - clip(F_motor, F_fm) + k_spring e - clip(K_J a + K_D v, F_m_max) - F_f
    F_motor = k_hat e,    e = command - x

The acceleration is solved for. A slip ends where its speed has fallen to dv; one begins where the
impulse of what exceeds the breakaway level amounts to dp = m dv; it starts at the speed dv.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, line, segment, steps_in
from .friction import Curve, as_floats, level, scattered


class Bed(NamedTuple):
    """Constants, SI; the motor's inertia and damping as they weigh at the slide.

    `up` is for a stretch above zero, as on a ramp to the right.
    """

    m: float = 10.9
    k_hat_up: float = 3500.0
    k_hat_down: float = 2800.0
    k_spring_up: float = 967.98
    k_spring_down: float = 553.84
    F_fm: float = 23.5
    K_J: float = 171.746  # K_kt J_m
    K_D: float = 107.084  # K_kt D_m
    F_m_max: float = 30.0
    dv: float = 1e-4
    dp: float = 1.09e-3


class BedMotion(NamedTuple):
    """A motion; `force` is F_motor, before its friction, `drive` what pulls at a slide at rest."""

    t: Array
    position: Array
    velocity: Array
    command: Array
    force: Array
    drive: Array


def simulate(
    bed: Bed, plus: Curve, minus: Curve, times: Array, command: Array, start: float,
    dt: float = 0.01, scatter: Array | None = None, h: float = 1e-5,
) -> BedMotion:  # fmt: skip
    """A motion from rest at `start` under a command, a straight line between its samples.

    Args:
        bed: constants.
        plus: friction to the right.
        minus: friction to the left.
        times: instants of the command, the first 0.
        command: its positions.
        start: where the slide rests at first.
        dt: from sample to sample.
        scatter: factors on F_S, one from each coming to rest to the next, over and over.
        h: the step.
    """
    bed = Bed(*(float(constant) for constant in bed))
    every = steps_in(dt, h)
    samples = int(times[-1] / dt + 1e-9) + 1
    rows = _run(
        bed, as_floats(plus), as_floats(minus), times, command, float(start),
        np.ones(1) if scatter is None else np.asarray(scatter, float), samples, every, h,
    )  # fmt: skip
    return BedMotion(dt * np.arange(samples), *rows)


@compiled
def _acceleration(bed: Bed, force: float, v: float) -> float:
    """The motor's inertia and damping take what force they need, at most F_m_max."""
    a = (force - bed.K_D * v) / (bed.m + bed.K_J)
    motor = bed.K_J * a + bed.K_D * v
    if motor > bed.F_m_max:
        return (force - bed.F_m_max) / bed.m
    if motor < -bed.F_m_max:
        return (force + bed.F_m_max) / bed.m
    return a


@compiled
def _run(  # noqa: C901 - one step of every state
    bed: Bed, plus: Curve, minus: Curve, times: Array, command: Array, x: float, scatter: Array,
    samples: int, every: int, h: float,
) -> Array:  # fmt: skip
    rows = np.empty((5, samples))
    mean_plus, mean_minus, rest = plus, minus, 0
    plus, minus = scattered(mean_plus, scatter[0]), scattered(mean_minus, scatter[0])
    v, w, k = 0.0, 0.0, 0  # w: the impulse of what exceeds the breakaway level
    for i in range((samples - 1) * every + 1):
        t = i * h
        k = segment(t, k, times)
        goal = line(t, k, times, command)
        stretch = goal - x
        motor = (bed.k_hat_up if stretch > 0.0 else bed.k_hat_down) * stretch
        spring = (bed.k_spring_up if stretch > 0.0 else bed.k_spring_down) * stretch
        drive = motor - min(max(motor, -bed.F_fm), bed.F_fm) + spring
        if i % every == 0:
            n = i // every
            rows[0, n], rows[1, n], rows[2, n] = x, v, goal
            rows[3, n], rows[4, n] = motor, drive
        moved = v != 0.0
        if v > 0.0:
            v += h * _acceleration(bed, drive - level(v, plus), v)
            if v <= bed.dv:
                v = 0.0
        elif v < 0.0:
            v += h * _acceleration(bed, drive + level(-v, minus), v)
            if v >= -bed.dv:
                v = 0.0
        elif drive > plus.F_S:
            w += h * (drive - plus.F_S)
        elif drive < -minus.F_S:
            w += h * (drive + minus.F_S)
        else:
            w = 0.0
        if abs(w) > bed.dp:
            v, w = np.copysign(max(bed.dv, 1e-12), w), 0.0
        x += h * v
        if moved and v == 0.0:
            rest += 1
            factor = scatter[rest % len(scatter)]
            plus, minus = scattered(mean_plus, factor), scattered(mean_minus, factor)
    return rows
