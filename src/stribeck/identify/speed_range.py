"""How fast and how far a log moves, by which it is told whether two logs move alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data.recording import Recording
from ..rig.motion.command import Drive
from ..space import Array

#: A motion is taken as straight lines that miss it by this share of its range: noise is no speed.
_LINE = 0.01
#: Shares of the time in motion whose speeds are told; a share of the greatest speed is rest.
_SHARES, _REST = (0.1, 0.5, 0.9), 0.02


@dataclass(frozen=True)
class SpeedRange:
    """How logs move, m/s and m, or rad/s and rad.

    Args:
        low: Speed that the axis is below for a tenth of the time in which it moves.
        median: For half of it.
        high: For nine tenths of it.
        travel: From the least to the greatest position; 0 of runs at constant speed.
        rotary: Whether positions are angles.
    """

    low: float
    median: float
    high: float
    travel: float
    rotary: bool


def speed_range(recordings: list[Recording]) -> SpeedRange | None:
    """How logs move, all taken together; None where none does."""
    pieces = [_pieces(log) for log in recordings]
    speeds = np.concatenate([speed for speed, _ in pieces])
    times = np.concatenate([time for _, time in pieces])
    moving = speeds > _REST * speeds.max(initial=0.0)
    if not moving.any():
        return None
    order = np.argsort(speeds[moving], kind="stable")
    spent = np.cumsum(times[moving][order])
    at = np.searchsorted(spent, np.multiply(_SHARES, spent[-1]))
    low, median, high = (float(v) for v in speeds[moving][order][np.minimum(at, len(order) - 1)])
    travels = [float(np.ptp(log.position)) for log in recordings]
    return SpeedRange(low, median, high, max(travels), recordings[0].rotary)


def _pieces(log: Recording) -> tuple[Array, Array]:
    """Speeds of the straight lines of a motion, and how long each takes."""
    if log.runs is not None and log.velocity is not None:
        return np.abs(log.velocity), np.ones(len(log))
    lines = Drive.sampled(log.t, log.position, _LINE)
    times = np.diff(lines.t)
    return np.abs(np.diff(lines.x)) / times, times
