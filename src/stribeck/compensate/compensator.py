"""The friction compensator: what a controller adds to its command against friction.

`compensator_output` is the one definition. At each of its samples, h seconds apart, a controller

1. evaluates the friction law at the velocity `evaluation_velocity`,
2. shapes its friction, `shaped_output`,
3. adds the result to the force (or torque) that it commands, and holds it for a
   sample.

The simulation runs these functions, and every export to a controller is translated from them: they
are written in the Python that laws are written in.

How a law is evaluated is part of the definition:

- a law without states, loads and terms: its `slip` at that velocity;
- a law with loads or terms and no states: its `rub`, under the loads of the sample before, times
  the factors of the terms;
- a law with states: its `rub` over the span h, which advances the states. With feedback, a resting
  axis keeps them, and the law is evaluated by its `slip`: a controller does not know the force
  that a bristle holds at rest, but the force at which it breaks away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import float64, types

from ..compile_cache import compiled
from ..errors import InputError
from ..space import Array

#: Places of the settings in `c`.
(
    SCALE, FEEDBACK, DEAD_BAND, SMOOTHING, SLEW, LIMIT, DRIVE, REST, REFERENCE_BAND, CROSSOVER,
) = range(10)  # fmt: skip

#: Speed at which a law that has a level at rest is evaluated for a resting axis, m/s or rad/s: no
#: law has lost anything of its breakaway level there.
TINY = 1e-9


@dataclass(frozen=True)
class Setting:
    """A setting of the compensator: its name, unit and meaning.

    Args:
        name: Its name.
        index: Its place in `c`.
        unit: SI unit on a linear axis.
        rotary: The same on a rotary one.
        meaning: What it does.
    """

    name: str
    index: int
    unit: str
    rotary: str
    meaning: str


SETTINGS = (
    Setting("scale", SCALE, "", "", "share of the model's friction that is compensated"),
    Setting("feedback", FEEDBACK, "", "",
            "1: the law is asked at the measured velocity, 0: at that of the reference"),
    Setting("dead_band", DEAD_BAND, "m/s", "rad/s",
            "measured speed up to which the axis counts as resting"),
    Setting("smoothing", SMOOTHING, "m/s", "rad/s",
            "speed of the reference beyond the dead band over which compensation sets in"),
    Setting("slew", SLEW, "N/s", "N m/s", "most by which the output changes in a second; 0: any"),
    Setting("limit", LIMIT, "N", "N m", "largest output; 0: any"),
    Setting("drive", DRIVE, "N", "N m", "Coulomb friction of the drive that eats its command"),
    Setting("rest", REST, "m/s", "rad/s", "speed at which a resting axis asks the law"),
    Setting("reference_band", REFERENCE_BAND, "m/s", "rad/s",
            "speed up to which the reference counts as resting, and nothing is compensated"),
    Setting("crossover", CROSSOVER, "m/s", "rad/s",
            "speed up to which feedback asks at the measured velocity; 0: any"),
)  # fmt: skip


@dataclass(frozen=True)
class Compensator:
    """The settings of a compensator, SI.

    Args:
        scale: Share of the model's friction that is compensated.
        feedback: Whether the law is evaluated at the measured velocity. Else it is evaluated at
            the reference's, which needs no sensor, and cannot undo what falls with speed.
        dead_band: Measured speed up to which the axis counts as resting, m/s or rad/s. The
            default is for a sensor without steps. One that counts needs more than a count a
            sample, which a resting axis shows where it trembles between two: see
            `sensor_dead_band`.
        smoothing: The output grows from nothing at a reference speed of `reference_band` to its
            whole at `reference_band + smoothing`, m/s or rad/s; at 0 it is there at once.
        slew: Most by which the output changes in a second, N/s or N m/s; 0 for no limit.
        limit: Largest output, N or N m; 0 for no limit.
        drive: Coulomb friction of the drive itself that eats the command before it reaches the
            axis, N or N m (the slide bed's F_fm).
        rest: Speed at which the law is evaluated for a resting axis, m/s or rad/s. The default
            gives the breakaway level of a law that has one; a law that is smooth through rest has
            none, and must be evaluated where its friction has risen.
        reference_band: Speed up to which the reference counts as resting, m/s or rad/s; a
            reference is known without a sensor.
        crossover: Speed up to which feedback takes the measured velocity, m/s or rad/s: where
            friction falls with speed, and has to be undone. 0: at any.
    """

    scale: float = 1.0
    feedback: bool = True
    dead_band: float = 1e-6
    smoothing: float = 0.0
    slew: float = 0.0
    limit: float = 0.0
    drive: float = 0.0
    rest: float = TINY
    reference_band: float = 1e-6
    crossover: float = 0.0

    def __post_init__(self) -> None:
        for s in SETTINGS:
            value = float(getattr(self, s.name))
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(
                    f"compensator: {s.name} = {value:g}: give a finite number, 0 or above"
                )
        if not self.rest > 0.0:
            raise InputError("compensator: rest = 0: a law is asked beside rest: give a speed")

    @property
    def c(self) -> Array:
        """The settings as the compiled functions read them, (10,)."""
        return np.array([float(getattr(self, s.name)) for s in SETTINGS])


def sensor_dead_band(resolution: float, h: float) -> float:
    """The dead band that hides what a counting sensor shows of a resting axis, m/s or rad/s.

    One and a half counts a sample: an axis that rests at the edge of two counts is seen to move
    by one.

    Args:
        resolution: A count, m or rad.
        h: Sample time, s.
    """
    return 1.5 * resolution / h


_READ = types.Array(float64, 1, "C", readonly=True)


@compiled(float64(float64, _READ))
def fed_back(v_ref: float, c: Array) -> float:
    """1 where the law is evaluated at the measured velocity, 0 where at the reference's.

    Args:
        v_ref: Velocity of the reference, m/s or rad/s.
        c: The settings.
    """
    if c[FEEDBACK] == 0.0:
        return 0.0
    if c[CROSSOVER] > 0.0 and abs(v_ref) > c[CROSSOVER]:
        return 0.0
    return 1.0


@compiled(float64(float64, float64, _READ))
def evaluation_velocity(v_ref: float, v: float, c: Array) -> float:
    """The velocity at which the friction law is evaluated, m/s or rad/s.

    Without feedback, the reference's. With feedback, the measured one; where the axis rests and
    the reference moves, a tiny speed in the reference's direction: there the law gives its
    breakaway level, so that a stuck axis is pushed off. With a crossover the measured velocity
    counts up to that speed only, beyond which friction damps the axis, and that of a reference
    faster than it is taken as it is.

    Args:
        v_ref: Velocity of the reference, m/s or rad/s.
        v: Measured velocity, m/s or rad/s.
        c: The settings.
    """
    if fed_back(v_ref, c) == 0.0:
        return v_ref
    if abs(v) > c[DEAD_BAND]:
        if c[CROSSOVER] > 0.0:
            return min(max(v, -c[CROSSOVER]), c[CROSSOVER])  # type: ignore[no-any-return]
        return v
    if v_ref < 0.0:
        return -c[REST]  # type: ignore[no-any-return]
    return c[REST]  # type: ignore[no-any-return]


@compiled(float64(float64, float64, float64, float64, _READ))
def shaped_output(force: float, v_ref: float, h: float, before: float, c: Array) -> float:
    """The compensator's output for a modelled friction, N or N m.

    scale * share * (force + drive in its direction), where the share rises from 0 to 1 as the
    reference's speed goes from its own dead band to the smoothing beyond it; then limited in its
    change and in its size. Where the reference rests nothing is compensated: friction may hold.

    Args:
        force: The modelled friction.
        v_ref: Velocity of the reference, m/s or rad/s.
        h: Sample time, s.
        before: The output of the sample before.
        c: The settings.
    """
    speed = abs(v_ref) - c[REFERENCE_BAND]
    share = 0.0
    if speed > 0.0:
        share = 1.0
        if speed < c[SMOOTHING]:
            share = speed / c[SMOOTHING]
    drive = 0.0
    if force > 0.0:
        drive = c[DRIVE]
    if force < 0.0:
        drive = -c[DRIVE]
    out = c[SCALE] * share * (force + drive)
    if c[SLEW] > 0.0:
        change = c[SLEW] * h
        out = min(max(out, before - change), before + change)
    if c[LIMIT] > 0.0:
        out = min(max(out, -c[LIMIT]), c[LIMIT])
    return out  # type: ignore[no-any-return]


@compiled(forceinline=True)
def compensator_output(
    slip: Any, rub: Any, general: bool, states: int, factor: float, v_ref: float, v: float,
    h: float, before: float, z: Array, load: Array, p: Array, c: Array, out: Array,
) -> float:  # fmt: skip
    """The compensator's output at a sample, N or N m; the law's states after h go into `out`.

    Args:
        slip: The law's `slip`.
        rub: Its `rub`, where it has one.
        general: Whether it has one.
        states: How many states it has.
        factor: The factor of its terms; 1 without.
        v_ref: Velocity of the reference over the sample to come, m/s or rad/s.
        v: Measured velocity, m/s or rad/s.
        h: Sample time, s.
        before: The output of the sample before, N or N m.
        z: The compensator's own states of the law, (states,).
        load: The loads of the sample before, as laws read them, (5,).
        p: The law's parameters as the compensator believes them.
        c: The settings, (10,).
        out: The states after h, as z.
    """
    at = evaluation_velocity(v_ref, v, c)
    if not general:
        force = factor * slip(at, p)
    elif states > 0 and fed_back(v_ref, c) == 1.0 and abs(v) <= c[DEAD_BAND]:
        for i in range(states):
            out[i] = z[i]
        force = factor * slip(at, p)
    else:
        force = factor * rub(at, h, z, load, p, out)
    return shaped_output(force, v_ref, h, before, c)  # type: ignore[no-any-return]
