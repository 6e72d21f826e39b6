"""A mass that a control loop moves along a trajectory, its drive force known: for force balances.

    M a = F - offset - spring (x - spring_at) - g_sin sin x - g_cos cos x - cogging - F_f

F is the drive's, a sampled loop's: held from tick to tick. With `g_sin` it is the forced pendulum
of docs/forces.md; what a balance of Coulomb and viscous friction leaves out is in `Extras`.
"""

from __future__ import annotations

from math import cos, exp, pi, sin
from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, line, segment, steps_in
from .friction import Curve, acting, as_floats, level, next_velocity


class Loop(NamedTuple):
    """F = kp e + kd de/dt + ki (integral of e) + mass_ff a_c, within the limit, once a tick."""

    kp: float
    kd: float
    ki: float = 0.0
    mass_ff: float = 0.0
    limit: float = 1e9
    tick: float = 1e-3


class Extras(NamedTuple):
    """What a plain balance does not know, all off by default.

    Cogging is a force over position, at rest, too. Friction as a whole is multiplied by
    1 + wave cos(2 pi x / wave_period) and by 1 + warming exp(-t / warming_time).
    """

    offset: float = 0.0
    g_sin: float = 0.0
    g_cos: float = 0.0
    square: float = 0.0  # F_f has square v |v| besides
    cogging: float = 0.0
    cogging_period: float = 1.0
    wave: float = 0.0
    wave_period: float = 1.0
    spring: float = 0.0
    spring_at: float = 0.0
    warming: float = 0.0
    warming_time: float = 1.0


class DrivenMotion(NamedTuple):
    """A motion; `force` is the drive's, `friction` what acts, with the sign of the velocity."""

    t: Array
    position: Array
    velocity: Array
    command: Array
    force: Array
    friction: Array


def simulate(
    mass: float, plus: Curve, minus: Curve, loop: Loop, times: Array, command: Array,
    extras: Extras | None = None, dt: float = 1e-3, h: float = 1e-5,
) -> DrivenMotion:  # fmt: skip
    """A motion from rest at the first command.

    Args:
        mass: or inertia, the motor's with it.
        plus: friction to the right.
        minus: friction to the left.
        loop: what drives.
        times: instants of the command, the first 0, evenly spaced.
        command: its positions; the loop follows their central differences, straight in between.
        extras: what else acts.
        dt: from sample to sample.
        h: the step.
    """
    extras = Extras(*(float(constant) for constant in extras or Extras()))
    loop = Loop(*(float(constant) for constant in loop))
    speed = np.gradient(command, times)
    goals = np.vstack([command, speed, np.gradient(speed, times)])
    every, samples = steps_in(dt, h), int(times[-1] / dt + 1e-9) + 1
    rows = _run(
        float(mass), as_floats(plus), as_floats(minus), loop, extras, times, goals, samples, every,
        steps_in(loop.tick, h), h,
    )  # fmt: skip
    return DrivenMotion(dt * np.arange(samples), *rows)


@compiled
def _surroundings(x: float, extras: Extras) -> float:
    """What the drive has to bear besides inertia and friction; what is off is not computed."""
    force = extras.offset + extras.spring * (x - extras.spring_at)
    if extras.g_sin != 0.0 or extras.g_cos != 0.0:
        force = force + extras.g_sin * sin(x) + extras.g_cos * cos(x)
    if extras.cogging != 0.0:
        force += extras.cogging * sin(2.0 * pi * x / extras.cogging_period)
    return force


@compiled
def asked(
    loop: Loop, t: float, k: int, times: Array, goals: Array, x: float, v: float, integral: float
) -> tuple[float, float]:
    """The force of a loop at a tick after knot k, and the integral of its error.

    Goals are position, velocity and acceleration at the knots, (3, K).
    """
    goal = line(t, k, times, goals[0])
    integral += (goal - x) * loop.tick
    force = loop.kp * (goal - x) + loop.ki * integral
    force += loop.kd * (line(t, k, times, goals[1]) - v)
    force += loop.mass_ff * line(t, k, times, goals[2])
    return min(max(force, -loop.limit), loop.limit), integral


@compiled
def _run(
    mass: float, plus: Curve, minus: Curve, loop: Loop, extras: Extras, times: Array, goals: Array,
    samples: int, every: int, tick: int, h: float,
) -> Array:  # fmt: skip
    rows = np.empty((5, samples))
    x, v, integral, force, k = goals[0, 0], 0.0, 0.0, 0.0, 0
    for i in range((samples - 1) * every + 1):
        t = i * h
        if i % tick == 0:
            k = segment(t, k, times)
            force, integral = asked(loop, t, k, times, goals, x, v, integral)
        factor = 1.0
        if extras.wave != 0.0:
            factor += extras.wave * cos(2.0 * pi * x / extras.wave_period)
        if extras.warming != 0.0:
            factor *= 1.0 + extras.warming * exp(-t / extras.warming_time)
        up = factor * (level(abs(v), plus) + extras.square * v * v)
        down = factor * (level(abs(v), minus) + extras.square * v * v)
        drive = force - _surroundings(x, extras)
        if i % every == 0:
            n = i // every
            rows[0, n], rows[1, n], rows[2, n] = x, v, line(t, k, times, goals[0])
            rows[3, n], rows[4, n] = force, acting(v, drive, up, down)
        v = next_velocity(v, drive, up, down, mass, h)
        x += h * v
    return rows
