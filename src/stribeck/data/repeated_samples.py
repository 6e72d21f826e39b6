"""Repeated samples of a sensor that is read more often than it measures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .segmentation import noise, step

if TYPE_CHECKING:
    from .recording import Recording

#: Share of samples that repeat their predecessor from which on a sensor is taken to hold.
_SHARE = 0.35
_REACH = 10


def is_new(recording: Recording) -> NDArray[np.bool_]:
    """Which samples of the position were measured anew, (N,).

    All of them, unless the sensor holds its value between measurements: then more than a third
    of the samples equal the one before, even where noise or motion would have changed each of
    them by more than a quantisation step. Held values are late by up to a measuring interval,
    which a model must not be blamed for.
    """
    x = recording.position
    q = step(x)
    same = np.concatenate([[False], np.diff(x) == 0.0])
    lag = min(_REACH, (len(x) - 1) // 2)
    if lag < 1:
        return np.ones(len(x), dtype=bool)
    pace = np.abs(x[2 * lag :] - x[: -2 * lag]) / (2 * lag)  # a sample's share of the motion
    telling = np.zeros(len(x), dtype=bool)
    telling[lag:-lag] = pace > q
    if noise(recording) >= max(q, 1e-12):
        telling[:] = True
    if telling.sum() < _REACH or same[telling].mean() < _SHARE:
        return np.ones(len(x), dtype=bool)
    return ~same
