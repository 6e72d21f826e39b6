"""How fast and how far logs move, which reference motions are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..rig.motion.command import Drive

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..data.recording import Recording

#: Share of a command's mean speed below which it rests.
_MOVES = 1e-3
#: A measured motion is taken as straight lines that miss it by this share of its range; of their
#: greatest speed such a share is slow.
_LINE, _SLOW = 0.01, 0.25


@dataclass(frozen=True, order=True)
class Pace:
    """How a log moves.

    Args:
        speed: m/s or rad/s.
        travel: m or rad.
        start: m or rad.
    """

    speed: float
    travel: float
    start: float


def paced(recordings: Sequence[Recording]) -> Pace | None:
    """The slowest pace of logs; None where none moves.

    The speed of a command is its mean over the time in which it moves. A log without one has a
    quarter of the greatest speed of its measured motion.
    """
    paces = [pace for log in recordings if log.runs is None and (pace := _pace(log)) is not None]
    return min(paces) if paces else None


def _pace(log: Recording) -> Pace | None:
    if log.command is None:
        drive = Drive.sampled(log.t, log.position, _LINE)
        speeds = np.abs(np.diff(drive.x) / np.diff(drive.t))
        speed = _SLOW * float(speeds.max(initial=0.0))
    else:
        drive = Drive.sampled(log.t, log.command)  # a command's own steps, not its rounding
        distance, takes = np.abs(np.diff(drive.x)), np.diff(drive.t)
        moves = distance > _MOVES * float(np.ptp(drive.x)) * takes / (drive.t[-1] - drive.t[0])
        speed = float(distance[moves].sum() / takes[moves].sum()) if moves.any() else 0.0
    return Pace(speed, float(np.ptp(drive.x)), float(drive.x[0])) if speed > 0.0 else None
