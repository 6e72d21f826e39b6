"""Closed loops with a friction compensator (docs/compensation.md), from the page's words.

At each sample of the controller the compensator reads the position, takes its difference to the
reading before for the velocity, looks its friction curve up, and adds the result to what the
controller commands, held to the next sample. The axis moves in tiny steps in between: a slide bed
(docs/physics.md), or a mass under a proportional-derivative controller, whose velocity may be the
axis's or a difference of readings (EMPS), and whose motor may brake (a servo).
"""

from __future__ import annotations

from math import cos, floor, sin
from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, steps_in
from .friction import Curve, as_floats, level, next_velocity
from .slide_bed import Bed, _acceleration


class Settings(NamedTuple):
    """The compensator: mode 0 looks the reference's speed up, 1 the measured one.

    With a crossover above 0, mode 1 looks the measured speed up to there, and the reference's
    where that is faster.
    """

    scale: float = 0.0
    mode: float = 0.0
    dead_band: float = 1e-6
    reference_band: float = 1e-6
    drive: float = 0.0
    crossover: float = 0.0
    resolution: float = 0.0
    noise: float = 0.0


class Loop(NamedTuple):
    """A mass under control; hold 0 acts at once, 1 to the next sample, 2 a sample late.

    `difference` takes the velocity from the readings of two samples before; `rate` is 1 where the
    derivative is of the error. `brake` is the motor's own damping, outside of the limit.
    """

    mass: float
    kp: float
    kd: float = 0.0
    rate: float = 1.0
    limit: float = 1e9
    hold: float = 0.0
    difference: float = 0.0
    brake: float = 0.0
    g_sin: float = 0.0
    g_cos: float = 0.0
    g_0: float = 0.0


class LoopMotion(NamedTuple):
    """A motion at the samples; `slowest` and `fastest` speeds from each sample to the next."""

    t: Array
    position: Array
    slowest: Array
    fastest: Array
    output: Array


@compiled
def looked_up(v: float, plus: Curve, minus: Curve) -> float:
    """Friction against a velocity, with its sign; at +-0 the breakaway level."""
    if v > 0.0:
        return level(v, plus)
    return -level(-v, minus)


@compiled
def compensation(v_ref: float, seen: float, plus: Curve, minus: Curve, s: Settings) -> float:
    """What the compensator adds."""
    if s.scale == 0.0 or abs(v_ref) <= s.reference_band:
        return 0.0
    v = v_ref
    if s.mode > 0.0 and (s.crossover == 0.0 or abs(v_ref) <= s.crossover):
        v = seen
        if s.crossover > 0.0:
            v = min(max(v, -s.crossover), s.crossover)
        if abs(seen) <= s.dead_band:
            v = 1e-12 if v_ref > 0.0 else -1e-12
    rub = looked_up(v, plus, minus)
    return s.scale * (rub + (s.drive if rub > 0.0 else -s.drive))


@compiled
def _reading(x: float, noise: float, resolution: float) -> float:
    shown = x + noise
    if resolution > 0.0:
        shown = resolution * floor(shown / resolution + 0.5)
    return shown


def simulate_bed(
    bed: Bed, plus: Curve, minus: Curve, model: tuple[Curve, Curve], settings: Settings,
    command: Array, period: float = 1e-3, h: float = 2e-5, seed: int = 1,
) -> LoopMotion:  # fmt: skip
    """A slide bed from rest at the first command, one command a sample."""
    bed = Bed(*(float(constant) for constant in bed))
    noise = settings.noise * np.random.default_rng(seed).standard_normal(len(command))
    rows = _bed(
        bed, as_floats(plus), as_floats(minus), as_floats(model[0]), as_floats(model[1]),
        Settings(*map(float, settings)), command, noise, period, steps_in(period, h), h,
    )  # fmt: skip
    return LoopMotion(period * np.arange(len(command)), *rows)


@compiled
def _bed(
    bed: Bed, plus: Curve, minus: Curve, m_plus: Curve, m_minus: Curve, s: Settings,
    command: Array, noise: Array, period: float, every: int, h: float,
) -> Array:  # fmt: skip
    rows = np.zeros((4, len(command)))
    x, v, w, last = command[0], 0.0, 0.0, _reading(command[0], noise[0], s.resolution)
    for n in range(len(command)):
        slope = (command[n + 1] - command[n]) / period if n + 1 < len(command) else 0.0
        shown = _reading(x, noise[n], s.resolution)
        added = compensation(slope, (shown - last) / period, m_plus, m_minus, s)
        last = shown
        rows[0, n], rows[1, n], rows[2, n], rows[3, n] = x, abs(v), abs(v), added
        if n + 1 == len(command):
            break
        for i in range(every):
            goal = command[n] + slope * i * h
            stretch = goal - x
            motor = (bed.k_hat_up if stretch > 0.0 else bed.k_hat_down) * stretch + added
            spring = (bed.k_spring_up if stretch > 0.0 else bed.k_spring_down) * stretch
            drive = motor - min(max(motor, -bed.F_fm), bed.F_fm) + spring
            if v > 0.0:
                v += h * _acceleration(bed, drive - level(v, plus), v)
                v = max(v, 0.0)
            elif v < 0.0:
                v += h * _acceleration(bed, drive + level(-v, minus), v)
                v = min(v, 0.0)
            elif drive > plus.F_S:
                w += h * _acceleration(bed, drive - plus.F_S, 0.0)
            elif drive < -minus.F_S:
                w += h * _acceleration(bed, drive + minus.F_S, 0.0)
            if w != 0.0:
                v, w = w, 0.0
            x += h * v
            rows[1, n], rows[2, n] = min(rows[1, n], abs(v)), max(rows[2, n], abs(v))
    return rows


def simulate_loop(
    loop: Loop, plus: Curve, minus: Curve, model: tuple[Curve, Curve], settings: Settings,
    command: Array, period: float = 1e-3, h: float = 1e-5, seed: int = 1,
) -> LoopMotion:  # fmt: skip
    """A mass from rest at the first command, one command a sample."""
    noise = settings.noise * np.random.default_rng(seed).standard_normal(len(command))
    rows = _loop(
        Loop(*map(float, loop)), as_floats(plus), as_floats(minus), as_floats(model[0]),
        as_floats(model[1]), Settings(*map(float, settings)), command, noise, period,
        steps_in(period, h), h,
    )  # fmt: skip
    return LoopMotion(period * np.arange(len(command)), *rows)


@compiled
def _loop(
    c: Loop, plus: Curve, minus: Curve, m_plus: Curve, m_minus: Curve, s: Settings,
    command: Array, noise: Array, period: float, every: int, h: float,
) -> Array:  # fmt: skip
    rows = np.zeros((4, len(command)))
    x, v, last = command[0], 0.0, _reading(command[0], noise[0], s.resolution)
    before, before_last, held, computed = x, x, 0.0, 0.0
    for n in range(len(command)):
        slope = (command[n + 1] - command[n]) / period if n + 1 < len(command) else 0.0
        shown = _reading(x, noise[n], s.resolution)
        added = compensation(slope, (shown - last) / period, m_plus, m_minus, s)
        last = shown
        speed = (x - before_last) / (2.0 * period) if c.difference > 0.0 else v
        before, before_last = x, before
        demand = c.kp * (command[n] - x) + c.kd * (c.rate * slope - speed) + added
        demand = min(max(demand, -c.limit), c.limit)
        held, computed = (computed if c.hold == 2.0 else demand), demand
        rows[0, n], rows[1, n], rows[2, n], rows[3, n] = x, abs(v), abs(v), added
        if n + 1 == len(command):
            break
        for i in range(every):
            force = held
            if c.hold == 0.0:
                error = command[n] + slope * i * h - x
                force = c.kp * error + c.kd * (c.rate * slope - v) + added
                force = min(max(force, -c.limit), c.limit)
            drive = force - c.brake * v - c.g_sin * sin(x) - c.g_cos * cos(x) - c.g_0
            v = next_velocity(v, drive, level(abs(v), plus), level(abs(v), minus), c.mass, h)
            x += h * v
            rows[1, n], rows[2, n] = min(rows[1, n], abs(v)), max(rows[2, n], abs(v))
    return rows


# --- what a motion does, judged in the plainest way ----------------------------------------------


def ramp(speed: float, seconds: float, start: float = 0.0, period: float = 1e-3) -> Array:
    """A command that rests for a second and goes on at one speed."""
    t = period * np.arange(round((seconds + 1.0) / period) + 1)
    x: Array = start + speed * np.maximum(t - 1.0, 0.0)
    return x


def sine(speed: float, amplitude: float, cycles: int, start: float = 0.0,
         period: float = 1e-3) -> Array:  # fmt: skip
    """A command that rests for a second and swings to one side and back, `cycles` times."""
    w = speed / amplitude
    t = period * np.arange(round((2.0 * np.pi * cycles / w + 1.0) / period) + 1)
    x: Array = start + amplitude * (1.0 - np.cos(w * np.maximum(t - 1.0, 0.0)))
    return x


def swing(command: Array, motion: LoopMotion, share: float) -> tuple[float, float]:
    """How far the error of a ramp swings in its last share, and in as much before that."""
    n = int(share * len(command))
    error = command - motion.position
    return float(np.ptp(error[-n:])), float(np.ptp(error[-2 * n : -n]))


def stands(command: Array, motion: LoopMotion, share: float = 1.0 / 3.0) -> float:
    """Share of the last samples at speed (half of the greatest or more) at which it rests."""
    speed = np.abs(np.diff(command, append=command[-1]))
    rows = np.arange(len(command)) >= (1.0 - share) * len(command)
    rows &= speed > 0.5 * speed.max()
    return float((motion.slowest[rows] == 0.0).mean())
