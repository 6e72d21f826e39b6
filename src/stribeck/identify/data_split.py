"""What an identification trains on and what it holds out."""

from __future__ import annotations

from dataclasses import dataclass

from ..data.ranges import Range
from ..data.recording import Recording
from ..rig.simulated import SimulatedRig
from .segment import Segment, segments


@dataclass(frozen=True, eq=False)
class DataSplit:
    """Recordings, and the ranges of them that are trained on and held out.

    Args:
        recordings: The logs.
        train: Ranges to train on; none means everything.
        holdout: Ranges to validate on.
    """

    recordings: tuple[Recording, ...]
    train: tuple[Range, ...]
    holdout: tuple[Range, ...]

    @property
    def ranges(self) -> tuple[Range, ...]:
        """All ranges, those to train on first."""
        return (*self.train, *self.holdout)


@dataclass(frozen=True, eq=False)
class SegmentSplit:
    """The segments of a data split, ready to be simulated.

    Args:
        train: Those to train on.
        holdout: Each range that is held out, with its segments.
    """

    train: tuple[Segment, ...]
    holdout: tuple[tuple[Range, tuple[Segment, ...]], ...]


def split_segments(data: DataSplit, rig: SimulatedRig, *, restart: bool) -> SegmentSplit:
    """The segments of a rig's logs.

    Args:
        data: The logs and their ranges.
        rig: How its motions start.
        restart: Whether a new segment starts at every rest.

    Raises:
        InputError: a range has no segment, or a log has none in any range.
    """
    logs = data.recordings
    train = [s for r in data.train or (None,) for s in segments(logs, rig, r, restart=restart)]
    holdout = [(r, tuple(segments(logs, rig, r, restart=restart))) for r in data.holdout]
    used = {
        id(s.recording) for part in (train, *(held_out for _, held_out in holdout)) for s in part
    }
    for log in logs:
        if id(log) not in used:
            for held_range in data.ranges or (None,):
                segments([log], rig, held_range)  # raises the reason
    return SegmentSplit(tuple(train), tuple(holdout))
