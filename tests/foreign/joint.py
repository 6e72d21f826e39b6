"""A robot joint under PD control with feed-forward, with gravity (docs/rigs.md, `joint`)."""

from __future__ import annotations

from math import cos, sin
from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, line, segment, steps_in
from .driven import DrivenMotion
from .friction import Curve, acting, as_floats, level, next_velocity, scattered


class Joint(NamedTuple):
    """Inertia, gravity and controller; hold 0 acts at once, 1 to the next sample, 2 a sample late.

    Samples are those of the command.
    """

    J: float
    g_sin: float = 0.0
    g_cos: float = 0.0
    g_0: float = 0.0
    kp: float = 100.0
    kd: float = 5.0
    gain: float = 1.0
    limit: float = 1000.0
    hold: float = 0.0


def simulate(
    joint: Joint, plus: Curve, minus: Curve, times: Array, command: Array,
    speed: Array | None = None, feed_forward: Array | None = None, start: float | None = None,
    scatter: Array | None = None, h: float = 1e-5,
) -> DrivenMotion:  # fmt: skip
    """A motion from rest, sampled where the command is.

    Args:
        joint: constants.
        plus: friction towards greater angles.
        minus: friction towards smaller ones.
        times: instants of command and samples, the first 0, whole numbers of steps.
        command: angles, straight lines in between.
        speed: the command's velocity, straight lines in between; without it the slope of each line.
        feed_forward: torques, straight lines in between.
        start: the angle at first, else the command's.
        scatter: factors on F_S, one from each coming to rest to the next, over and over.
        h: the step.
    """
    joint = Joint(*(float(constant) for constant in joint))
    has_speed = speed is not None
    rows = _run(
        joint, as_floats(plus), as_floats(minus), times, command,
        np.zeros_like(command) if speed is None else speed, has_speed,
        np.zeros_like(command) if feed_forward is None else feed_forward,
        float(command[0] if start is None else start),
        np.ones(1) if scatter is None else np.asarray(scatter, float), steps_in(times[-1], h), h,
    )  # fmt: skip
    return DrivenMotion(times.copy(), rows[0], rows[1], command.copy(), rows[2], rows[3])


@compiled
def _run(
    joint: Joint, plus: Curve, minus: Curve, times: Array, command: Array, speed: Array,
    has_speed: bool, feed_forward: Array, q: float, scatter: Array, steps: int, h: float,
) -> Array:  # fmt: skip
    rows = np.empty((4, len(times)))
    w, k, n, computed, torque = 0.0, 0, 0, 0.0, 0.0
    rest, up_curve, down_curve = 0, scattered(plus, scatter[0]), scattered(minus, scatter[0])
    for i in range(steps + 1):
        t = i * h
        k = segment(t, k, times)
        sample = n < len(times) and t >= times[n] - 1e-12
        if joint.hold == 0.0 or sample:
            error = line(t, k, times, command) - q
            slope = (command[k + 1] - command[k]) / (times[k + 1] - times[k])
            goal_speed = line(t, k, times, speed) if has_speed else slope
            demand = joint.kp * error + joint.kd * (goal_speed - w)
            demand = line(t, k, times, feed_forward) + joint.gain * demand
            demand = min(max(demand, -joint.limit), joint.limit)
            torque = computed if joint.hold == 2.0 and i > 0 else demand
            computed = demand
        drive = torque - joint.g_sin * sin(q) - joint.g_cos * cos(q) - joint.g_0
        up, down = level(abs(w), up_curve), level(abs(w), down_curve)
        if sample:
            rows[0, n], rows[1, n], rows[2, n] = q, w, torque
            rows[3, n] = acting(w, drive, up, down)
            n += 1
        moved = w != 0.0
        w = next_velocity(w, drive, up, down, joint.J, h)
        q += h * w
        if moved and w == 0.0:
            rest += 1
            factor = scatter[rest % len(scatter)]
            up_curve, down_curve = scattered(plus, factor), scattered(minus, factor)
    return rows
