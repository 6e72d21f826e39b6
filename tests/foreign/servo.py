"""A pendulum on a servo (docs/rigs.md, `servo-pendulum`), friction by BAM's laws (docs/laws.md).

(m l^2 + armature) dw/dt = t_m + t_e - F_f
t_m = k_t (V - k_t w) / R, no current while the torque is off
t_e = -m g l sin(q + q_offset)
V = vin clip(duty kp (goal - q), -1, 1)
"""

from __future__ import annotations

from math import exp, sin
from typing import NamedTuple

import numpy as np

from . import compiled
from .clock import Array, line, segment, steps_in
from .friction import acting, next_velocity


class Servo(NamedTuple):
    """Pendulum and motor; the values are of the size of a Dynamixel XL330's."""

    m: float = 0.49
    l: float = 0.1  # noqa: E741 - the equation's letter
    armature: float = 1e-3
    k_t: float = 0.4
    R: float = 4.0
    q_offset: float = 0.0
    kp: float = 400.0
    duty: float = 0.00287738
    vin: float = 7.4
    g: float = 9.80665


class Bam(NamedTuple):
    """`bam-m6`, which holds the others: K_m = K_e and K_ms = K_es is m4, zeros for the rest."""

    K_c: float
    K_v: float
    K_cs: float = 0.0
    w_s: float = 1.0
    alpha: float = 1.0
    K_m: float = 0.0
    K_e: float = 0.0
    K_ms: float = 0.0
    K_es: float = 0.0
    K_mq: float = 0.0
    K_eq: float = 0.0


class ServoMotion(NamedTuple):
    """A motion; `motor` is t_m, `enabled` 1 while the servo drives."""

    t: Array
    position: Array
    velocity: Array
    command: Array
    enabled: Array
    motor: Array
    friction: Array


def simulate(
    servo: Servo, bam: Bam, times: Array, goal: Array, enabled: Array | None = None,
    start: tuple[float, float] = (0.0, 0.0), straight: bool = True, h: float = 1e-5,
) -> ServoMotion:  # fmt: skip
    """A motion sampled where the goal is.

    Args:
        servo: constants.
        bam: friction.
        times: instants of goal and samples, the first 0, whole numbers of steps.
        goal: angles.
        enabled: where the servo drives from a sample to the next (everywhere without it).
        start: angle and speed at first.
        straight: a goal is a straight line between its samples, or else held.
        h: the step.
    """
    servo = Servo(*(float(constant) for constant in servo))
    bam = Bam(*(float(constant) for constant in bam))
    on = np.ones_like(goal) if enabled is None else np.asarray(enabled, float)
    rows = _run(
        servo, bam, times, goal, on, float(start[0]), float(start[1]), straight,
        steps_in(times[-1], h), h,
    )  # fmt: skip
    return ServoMotion(times.copy(), rows[0], rows[1], goal.copy(), on, rows[2], rows[3])


@compiled
def bam_level(speed: float, t_m: float, t_e: float, bam: Bam) -> float:
    """Friction at a speed under two torques, a magnitude; at zero speed the breakaway level."""
    drop = exp(-((speed / bam.w_s) ** bam.alpha))
    square = 0.0
    if t_m * t_e < 0.0:
        square = bam.K_eq * t_e**2 if abs(t_m) > abs(t_e) else bam.K_mq * t_m**2
    at_rest = bam.K_cs + abs(bam.K_ms * t_m - bam.K_es * t_e) + square
    return bam.K_c + bam.K_v * speed + abs(bam.K_m * t_m - bam.K_e * t_e) + drop * at_rest


@compiled
def _run(
    servo: Servo, bam: Bam, times: Array, goal: Array, on: Array, q: float, w: float,
    straight: bool, steps: int, h: float,
) -> Array:  # fmt: skip
    rows = np.empty((4, len(times)))
    inertia = servo.m * servo.l**2 + servo.armature
    k, n = 0, 0
    for i in range(steps + 1):
        t = i * h
        k = segment(t, k, times)
        t_m = 0.0
        if on[k] > 0.0:
            there = line(t, k, times, goal) if straight else goal[k]
            share = min(max(servo.duty * servo.kp * (there - q), -1.0), 1.0)
            t_m = servo.k_t * (servo.vin * share - servo.k_t * w) / servo.R
        t_e = -servo.m * servo.g * servo.l * sin(q + servo.q_offset)
        rub = bam_level(abs(w), t_m, t_e, bam)
        if n < len(times) and t >= times[n] - 1e-12:
            rows[0, n], rows[1, n], rows[2, n] = q, w, t_m
            rows[3, n] = acting(w, t_m + t_e, rub, rub)
            n += 1
        w = next_velocity(w, t_m + t_e, rub, rub, inertia, h)
        q += h * w
    return rows
