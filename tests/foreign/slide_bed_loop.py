"""The slide bed of `slide_bed.py` under a PC that reads a noisy converter (docs/physics.md).

Each `period` the PC reads the transducer and asks for a current, which it holds:

    reading = converted(x + noise),    i_asked = k_hat (command - reading) / force_per_ampere

The supply of U volts over R ohm and the back-EMF leave of it what |R i + K_e v| <= U allows; of a
drive that holds a voltage u = R i_asked, |u| <= U, i = (u - K_e v) / R. No current is above i_max.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, line, segment, steps_in
from .friction import Curve, as_floats, level
from .slide_bed import Bed


class Loop(NamedTuple):
    """Constants of the loop, SI; the transducer is as fast as the PC."""

    force_per_ampere: float = 101.1021
    K_e: float = 134.93769  # V s/m at the slide: 18.2e-3 V s/rad times 7414.16 rad/m
    resistance: float = 5.0
    supply: float = 24.0
    i_max: float = 2.5
    voltage: bool = False
    low: float = 0.0
    high: float = 0.4
    levels: int = 4096


def simulate(
    bed: Bed, loop: Loop, plus: Curve, minus: Curve, times: Array, command: Array, start: float,
    noise: Array, period: float = 0.02, dt: float = 0.01, h: float = 1e-5,
) -> Array:  # fmt: skip
    """Position, velocity, reading, current and command, (5, samples), dt apart, from rest.

    Args:
        bed: Constants of the slide.
        loop: Of the loop.
        plus: Friction to the right.
        minus: To the left.
        times: Instants of the command, the first 0.
        command: Its positions.
        start: Where the slide rests at first, m.
        noise: Of each reading, m.
        period: From reading to reading, s.
        dt: From sample to sample, s.
        h: The step, s.
    """
    samples = int(times[-1] / dt + 1e-9) + 1
    return _run(
        Bed(*(float(c) for c in bed)), loop, as_floats(plus), as_floats(minus), times, command,
        float(start), noise, steps_in(period, h), steps_in(dt, h), samples, h,
    )  # fmt: skip


@compiled
def _amperes(loop: Loop, asked: float, v: float) -> float:
    if loop.voltage:
        wish = min(max(asked, -loop.i_max), loop.i_max)
        u = min(max(loop.resistance * wish, -loop.supply), loop.supply)
        i = (u - loop.K_e * v) / loop.resistance
    else:
        u = loop.resistance * min(max(asked, -loop.i_max), loop.i_max) + loop.K_e * v
        i = (min(max(u, -loop.supply), loop.supply) - loop.K_e * v) / loop.resistance
    return min(max(i, -loop.i_max), loop.i_max)


@compiled
def _run(
    bed: Bed, loop: Loop, plus: Curve, minus: Curve, times: Array, command: Array, x: float,
    noise: Array, per_reading: int, per_sample: int, samples: int, h: float,
) -> Array:  # fmt: skip
    rows = np.empty((5, samples))
    v, w, k, asked, reading = 0.0, 0.0, 0, 0.0, 0.0
    step = (loop.high - loop.low) / loop.levels
    for i in range((samples - 1) * per_sample + 1):
        t = i * h
        k = segment(t, k, times)
        goal = line(t, k, times, command)
        if i % per_reading == 0:
            code = np.floor((x + noise[i // per_reading] - loop.low) / step)
            reading = loop.low + (min(max(code, 0.0), loop.levels - 1.0) + 0.5) * step
            seen = goal - reading
            asked = (bed.k_hat_up if seen > 0.0 else bed.k_hat_down) * seen / loop.force_per_ampere
        amperes = _amperes(loop, asked, v)
        motor = loop.force_per_ampere * amperes
        stretch = goal - x
        spring = (bed.k_spring_up if stretch > 0.0 else bed.k_spring_down) * stretch
        drive = motor - min(max(motor, -bed.F_fm), bed.F_fm) + spring
        if i % per_sample == 0:
            n = i // per_sample
            rows[0, n], rows[1, n], rows[2, n], rows[3, n], rows[4, n] = (
                x,
                v,
                reading,
                amperes,
                goal,
            )
        if v == 0.0:
            beyond = max(drive - plus.F_S, 0.0) + min(drive + minus.F_S, 0.0)
            w = w + h * beyond if beyond != 0.0 else 0.0
            if abs(w) > bed.dp:
                v, w = np.copysign(bed.dv, w), 0.0
        else:
            s = np.sign(v)
            net = drive - s * level(abs(v), plus if s > 0.0 else minus)
            a = (net - bed.K_D * v) / (bed.m + bed.K_J)
            back = bed.K_J * a + bed.K_D * v
            if abs(back) > bed.F_m_max:
                a = (net - np.copysign(bed.F_m_max, back)) / bed.m
            v += h * a
            if s * v <= bed.dv:
                v = 0.0
        x += h * v
    return rows
