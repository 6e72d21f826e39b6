"""An identified axis: its parameters, their ranges and noise, and what its logs show of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...data.repeated_samples import is_new
from ...rig.experiments.offer import Exposure, OperatingRange
from ...space import Array
from .experiment import PriorBox

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...data.recording import Recording
    from ..parameters import Parameters

#: Samples each way over which a speed is taken from positions.
_REACH = 5


@dataclass(frozen=True, eq=False)
class IdentifiedAxis:
    """An axis as its model and its logs show it, SI.

    Args:
        parameters: Rig, law and which parameters are free.
        x: The free parameters, as fitted, (dim,).
        box: Ranges of the free parameters.
        noise: Standard deviation of a residual of the fit.
        sensor: The part of it that the sensor has at rest; nan where that is not known.
        inflation: How many times the variance of each estimate is that of white noise, (dim,).
        trained: Seconds of the data that were fitted.
        shown: What its logs show.
    """

    parameters: Parameters
    x: Array
    box: PriorBox
    noise: float
    sensor: float
    inflation: Array
    trained: float
    shown: OperatingRange

    def repeated(self, interval: float) -> Array:
        """The inflation at another sampling interval: what repeats itself does so in time."""
        return 1.0 + (self.inflation - 1.0) * self.shown.interval / interval


def operating_range(
    parameters: Parameters,
    x: Array,
    logs: Sequence[Recording],
    directions: tuple[int, ...],
    exposure: Exposure | None = None,
    **figures: float,
) -> OperatingRange:
    """What logs show of the axis of a fitted model.

    Args:
        parameters: Rig, law and which parameters are free.
        x: The free parameters, as fitted, (dim,).
        logs: The recordings.
        directions: Directions in which the model holds.
        exposure: Acceleration and loads of an axis with a measured force.
        figures: The numbers of `OperatingRange`.
    """
    rig, p = parameters.rig, parameters.full(x[None])[0]
    units = {
        "position": rig.unit_shown("position"),
        "velocity": rig.unit_shown("velocity"),
        "force": rig.shows.get("force", rig.si_unit("force")),
    }
    return OperatingRange(
        law=parameters.law, p=p, values=parameters.values(p), units=units, logs=tuple(logs),
        directions=directions, exposure=exposure, **figures,
    )  # fmt: skip


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
