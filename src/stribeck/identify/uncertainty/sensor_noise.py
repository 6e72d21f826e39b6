"""The noise of a position sensor, read off the rests of an axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from ...data.repeated_samples import is_new
from ...data.resolution import noise, step
from ...data.segmentation import rests
from ...space import Array

if TYPE_CHECKING:
    from ...data.recording import Recording

#: Samples of a rest below which it says nothing of the noise, and what is cut off its ends.
FEWEST, CUT = 12, 0.1
#: A rest is flat if a parabola leaves at least this share of what a line leaves: an axis that still
#: swings or creeps to its rest leaves less, noise that remembers twenty samples more.
BENT = 0.5

_SEEN: WeakKeyDictionary[Recording, float] = WeakKeyDictionary()


def sensor_noise(log: Recording) -> float:
    """Noise and quantisation of a log's position, m or rad; looked at once."""
    if log not in _SEEN:
        seen = float(np.hypot(noise(log), step(log.position) / np.sqrt(12)))
        _SEEN[log] = float(np.fmax(seen, rest_noise([log])))
    return _SEEN[log]


def rest_noise(recordings: Sequence[Recording]) -> float:
    """Standard deviation of the position while axes rest, m or rad; nan without rests.

    It is what the sensor does to a position that does not change, quantisation included, about
    a line through each rest that is flat; samples that a sensor merely holds are left out.
    """
    squares, count = 0.0, 0
    for log in recordings:
        measured = is_new(log)
        for rest in rests(log):
            n = rest.stop - rest.start
            inner = slice(rest.start + int(CUT * n), rest.stop - int(CUT * n))
            keep = measured[inner]
            if int(keep.sum()) < FEWEST:
                continue
            x, t = log.position[inner][keep], log.t[inner][keep]
            square, curved = (_squares_about(t, x, degree) for degree in (1, 2))
            if curved < BENT * square:
                continue
            squares += square
            count += len(t) - 2
    return float(np.sqrt(squares / count)) if count else float("nan")


def _squares_about(t: Array, x: Array, degree: int) -> float:
    """Sum of squares of a position about its best polynomial."""
    W = np.vander((t - t.mean()) / np.ptp(t), degree + 1)
    y = x - x[0]
    return float(np.sum((y - W @ np.linalg.lstsq(W, y, rcond=None)[0]) ** 2))
