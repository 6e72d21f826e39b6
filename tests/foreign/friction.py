"""The Stribeck curve, and one step of an axis that can stick."""

from __future__ import annotations

from math import exp
from typing import NamedTuple

from . import compiled


class Curve(NamedTuple):
    """Friction in one direction over the speed there (`stribeck-free` of docs/laws.md)."""

    F_S: float
    F_C: float
    F_V: float = 0.0
    v_SS: float = 1.0
    exponent: float = 1.0


def coulomb_viscous(F_C: float, F_V: float = 0.0) -> Curve:
    """A curve without a drop."""
    return Curve(F_C, F_C, F_V)


def as_floats(curve: Curve) -> Curve:
    """The same, of one type for the compiler."""
    return Curve(*(float(value) for value in curve))


@compiled
def level(speed: float, curve: Curve) -> float:
    """Friction at a speed, both magnitudes; at zero speed the breakaway level."""
    if curve.F_S == curve.F_C:  # without a drop
        return curve.F_C + curve.F_V * speed
    drop = exp(-((speed / curve.v_SS) ** curve.exponent))
    return curve.F_C + (curve.F_S - curve.F_C) * drop + curve.F_V * speed


@compiled
def scattered(curve: Curve, factor: float) -> Curve:
    """The curve with another breakaway level."""
    return Curve(factor * curve.F_S, curve.F_C, curve.F_V, curve.v_SS, curve.exponent)


@compiled
def next_velocity(v: float, drive: float, up: float, down: float, mass: float, h: float) -> float:
    """Velocity a step later under a drive.

    `up` and `down` are the magnitudes of friction against motion to the right and to the left: at
    rest the breakaway levels.
    """
    if v > 0.0 or (v == 0.0 and drive > up):
        return max(v + h * (drive - up) / mass, 0.0)
    if v < 0.0 or (v == 0.0 and drive < -down):
        return min(v + h * (drive + down) / mass, 0.0)
    return 0.0


@compiled
def acting(v: float, drive: float, up: float, down: float) -> float:
    """The friction that acts, with its sign: against the velocity, at rest against the drive."""
    if v > 0.0:
        return up
    if v < 0.0:
        return -down
    return min(max(drive, -down), up)
