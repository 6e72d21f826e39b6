"""What a log shows of its axis, and experiments that stay within that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ...space import Array
from ...units import unit

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ...friction import Law

#: Seconds of rest before a stroke from rest.
HOLD = 1.0


@dataclass(frozen=True, eq=False)
class Exposure:
    """What an axis with a measured force was exposed to, SI.

    Args:
        acceleration: Greatest acceleration, but for the odd sample.
        normal: Least and greatest normal load; None where there is none.
        temperature: Mean, K; 0 where it was not recorded.
    """

    acceleration: float
    normal: tuple[float, float] | None
    temperature: float


@dataclass(frozen=True, eq=False)
class OperatingRange:
    """An axis as its model and its logs show it, SI.

    Args:
        law: The identified law.
        p: The complete parameter set, the law's and then the rig's, (k,).
        values: The same by name.
        units: Units in which people see position, velocity and force, by these names.
        logs: The recordings.
        interval: Seconds from one sample that counts to the next.
        low: Least position.
        high: Greatest position.
        pace: Mean speed of what moves the axis while it moves.
        fastest: Greatest speed of the axis.
        lag: How far the axis was from its command at most; 0 where there is none.
        force: Greatest force of the drive that the log shows; inf where it shows none.
        directions: Directions in which the model holds, +1 or -1 or both.
        exposure: Acceleration and loads of an axis with a measured force.
    """

    law: Law
    p: Array
    values: Mapping[str, float]
    units: Mapping[str, str]
    logs: tuple[Recording, ...]
    interval: float
    low: float
    high: float
    pace: float
    fastest: float
    lag: float
    force: float
    directions: tuple[int, ...]
    exposure: Exposure | None = None

    @property
    def temperature(self) -> float | None:
        """Mean temperature of the first log that has one, K."""
        recorded = [log.temperature for log in self.logs if log.temperature is not None]
        return float(recorded[0].mean()) if recorded else None

    def place(self, position: float) -> str:
        """A position as people see it."""
        if abs(position) < 1e-3 * (self.high - self.low):
            position = 0.0
        return self.shown("position", position)

    def rate(self, speed: float) -> str:
        """A speed as people see it."""
        return self.shown("velocity", speed)

    def push(self, force: float) -> str:
        """A force or torque as people see it."""
        return self.shown("force", force)

    def listed(self, quantity: str, values: Sequence[float]) -> str:
        """Several of a quantity in the unit its rig shows: 1, 2 and 3 mm/s."""
        *first, last = (self.shown(quantity, value) for value in values)
        return f"{', '.join(value.split()[0] for value in first)} and {last}"

    def shown(self, quantity: str, value: float) -> str:
        """A quantity in the unit its rig shows."""
        written = self.units[quantity]
        figure = float(f"{float(unit(written).from_si(value)):.3g}")
        return f"{figure:g} {written}"


@dataclass(frozen=True, eq=False)
class Course:
    """A command to an axis, from one start on.

    Args:
        t: Times, s, from 0, (N,).
        command: Commanded position or applied force, SI, (N,).
        extra: Further channels of the log that it would make, by name.
        start: Where the axis is at first, SI; where the command is by default.
        force: Whether the command is a force.
    """

    t: Array
    command: Array
    extra: Mapping[str, Any] = field(default_factory=dict)
    start: float | None = None
    force: bool = False


@dataclass(frozen=True, eq=False)
class ImposedMotion:
    """A motion that an axis is taken to follow, SI.

    Args:
        position: (N,).
        velocity: (N,).
        acceleration: (N,).
        normal: Normal load, (N,); the mean of the logs by default.
    """

    position: Array
    velocity: Array
    acceleration: Array
    normal: Array | None = None


@dataclass(frozen=True, eq=False)
class Offer:
    """An experiment that a rig can do.

    Args:
        name: In few words.
        words: What a technician does, in a sentence.
        courses: The commands of a simulated rig, one from each start.
        motion: The motion of a rig whose forces are balanced.
        seconds: How long it takes, where that is more than its courses.
        refusal: Why it is left out; "" where it is not.
    """

    name: str
    words: str
    courses: Sequence[Course] = ()
    motion: ImposedMotion | None = None
    seconds: float | None = None
    refusal: str = ""


def course(axis: OperatingRange, t: Sequence[float], x: Sequence[float]) -> Course:
    """A command that is linear between knots, at the sampling interval of the axis."""
    seconds = float(t[-1])
    clock: Array = axis.interval * np.arange(max(int(seconds / axis.interval), 2) + 1, dtype=float)
    return Course(clock, np.interp(clock, t, x))


def clock(axis: OperatingRange, seconds: float) -> Array:
    """The samples of an experiment of some length, s."""
    t: Array = axis.interval * np.arange(int(seconds / axis.interval) + 1, dtype=float)
    return t
