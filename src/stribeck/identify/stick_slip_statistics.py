"""Statistics of stick-slip of a measured and a modelled motion, whatever their phase.

Two axes with the same friction soon slip at different times if slips come at a force that is not
the same each time: the position error of a long simulation then says little of the friction. How
often they slip, how far, and for how much of the time they rest, does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..data.recording import Recording
from ..data.resolution import noise, step
from ..data.segmentation import segment
from ..space import Array

if TYPE_CHECKING:
    from ..rig import Motion
    from .segment import Segment

#: Fewer slips of an axis make no staircase.
_FEWEST = 5


@dataclass(frozen=True)
class StickSlipStatistics:
    """How an axis stuck and slipped.

    Args:
        slips: How often it slipped from one rest to the next.
        jump: How far, as the median, m or rad; 0 without slips.
        stuck: For which share of the time it rested.
    """

    slips: int
    jump: float
    stuck: float


def stick_slip_statistics(
    segments: Sequence[Segment], motions: Sequence[Motion]
) -> tuple[StickSlipStatistics | None, StickSlipStatistics | None]:
    """How the axis and how the model stuck and slipped, over all segments.

    The model's motion is read as the sensor would have shown it, with its noise (drawn anew, the
    same each time) and its quantisation, and both are taken apart by the same rules. None for
    both if the axis hardly slipped.
    """
    pairs = [
        _pair(s, m) for s, m in zip(segments, motions, strict=True) if len(s.track.t) > _FEWEST
    ]
    if not pairs:
        return None, None
    measured, modelled = (_statistics([pair[k] for pair in pairs]) for k in (0, 1))
    return (measured, modelled) if measured.slips >= _FEWEST else (None, None)


def _pair(segment: Segment, motion: Motion) -> tuple[Recording, Recording]:
    log, track = segment.recording, segment.track
    counts = np.flatnonzero(track.score > 0)
    rows = slice(int(counts[0]), int(counts[-1]) + 1)
    command = np.interp(track.t, track.knots_t, track.knots_x)[rows]
    sd, q = noise(log), step(log.position)
    x = motion.position[0][rows] + sd * np.random.default_rng(0).standard_normal(len(track.t[rows]))
    if q > 0:
        x = q * np.rint(x / q)
    return (
        Recording(track.t[rows], track.measured[rows], command, rotary=log.rotary),
        Recording(track.t[rows], _finite(x), command, rotary=log.rotary),
    )


def _finite(x: Array) -> Array:
    """A motion that runs away ends where it was last seen."""
    finite = np.isfinite(x) & (np.abs(x) < 1e9)  # noqa: PLR2004 - nothing goes that far
    return np.where(finite, x, x[finite][-1] if finite.any() else 0.0)


def _statistics(logs: Sequence[Recording]) -> StickSlipStatistics:
    segmentations = [segment(log) for log in logs]
    jumps = [abs(slip.jump) for s in segmentations for slip in s.slips]
    seconds = np.array([log.t[-1] - log.t[0] for log in logs])
    stuck = float(np.sum([s.stuck for s in segmentations] * seconds) / np.sum(seconds))
    return StickSlipStatistics(len(jumps), float(np.median(jumps)) if jumps else 0.0, stuck)
