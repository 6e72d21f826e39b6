"""What a log shows of its axis: travel, speeds, forces, sampling, noise. Plans stay inside that."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...data.repeated_samples import is_new
from ...space import Array
from ...units import unit
from .experiment import Box

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...data.recording import Recording
    from ..parameters import Parameters

#: Samples each way over which a speed is taken from positions.
_REACH = 5


@dataclass(frozen=True, eq=False)
class Axis:
    """An axis as its model and its logs show it, SI.

    Args:
        parameters: Rig, law and which parameters are free.
        x: The free parameters, as fitted, (dim,).
        logs: The recordings.
        box: Ranges of the free parameters.
        noise: Standard deviation of a residual of the fit.
        sensor: The part of it that the sensor has at rest; nan where that is not known.
        inflation: How many times the variance of each estimate is that of white noise, (dim,).
        interval: Seconds from one sample that counts to the next.
        trained: Seconds of the data that were fitted.
        low: Least position.
        high: Greatest position.
        pace: Mean speed of what moves the axis while it moves.
        fastest: Greatest speed of the axis.
        lag: How far the axis was from its command at most; 0 where there is none.
        force: Greatest force of the drive that the log shows; inf where it shows none.
    """

    parameters: Parameters
    x: Array
    logs: tuple[Recording, ...]
    box: Box
    noise: float
    sensor: float
    inflation: Array
    interval: float
    trained: float
    low: float
    high: float
    pace: float
    fastest: float
    lag: float
    force: float

    def repeated(self, interval: float) -> Array:
        """The inflation at another sampling interval: what repeats itself does so in time."""
        return 1.0 + (self.inflation - 1.0) * self.interval / interval

    def value(self, name: str) -> float:
        """A parameter by name."""
        full = self.parameters.full(self.x[None])[0]
        return self.parameters.values(full)[name]

    def place(self, position: float) -> str:
        """A position as people see it."""
        if abs(position) < 1e-3 * (self.high - self.low):
            position = 0.0
        return self.shown("position", position, "rad" if self.parameters.rig.rotary else "m")

    def rate(self, speed: float) -> str:
        """A speed as people see it."""
        return self.shown("velocity", speed, "rad/s" if self.parameters.rig.rotary else "m/s")

    def push(self, force: float) -> str:
        """A force or torque as people see it."""
        return self.shown("force", force, "N m" if self.parameters.rig.rotary else "N")

    def shown(self, what: str, value: float, si: str) -> str:
        """A quantity in the unit its rig shows."""
        written = self.parameters.rig.shows.get(what, si)
        figure = float(f"{float(unit(written).from_si(value)):.3g}")
        return f"{figure:g} {written}"


def counted(log: Recording, rows: Sequence[slice]) -> tuple[float, int]:
    """Seconds of the rows of a log that are used, and how many samples measured anew they have."""
    anew = is_new(log)
    seconds = sum(float(log.t[r.stop - 1] - log.t[r.start]) + log.dt for r in rows)
    return seconds, sum(int(np.count_nonzero(anew[r])) for r in rows)


def speeds(t: Array, x: Array) -> tuple[float, float]:
    """Mean speed while moving, and the greatest one, of positions or a command."""
    n = min(_REACH, (len(x) - 1) // 2)
    v = np.abs((x[2 * n :] - x[: -2 * n]) / (t[2 * n :] - t[: -2 * n]))
    top = float(v.max())
    moving = v > 0.05 * top
    return (float(v[moving].mean()) if moving.any() else 0.0), top
