"""The noise of a position sensor, read off the rests of an axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...data.repeated_samples import is_new
from ...data.segmentation import rests

if TYPE_CHECKING:
    from ...data.recording import Recording

#: Samples of a rest below which it says nothing of the noise, and what is cut off its ends.
FEWEST, CUT = 12, 0.1


def rest_noise(recordings: Sequence[Recording]) -> float:
    """Standard deviation of the position while axes rest, m or rad; nan without rests.

    It is what the sensor does to a position that does not change, quantisation included, about
    a line through each rest; samples that a sensor merely holds are left out.
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
            W = np.column_stack([np.ones(len(t)), t - t.mean()])
            line = np.linalg.lstsq(W, x - x[0], rcond=None)[0]
            squares += float(np.sum((x - x[0] - W @ line) ** 2))
            count += len(t) - 2
    return float(np.sqrt(squares / count)) if count else float("nan")
