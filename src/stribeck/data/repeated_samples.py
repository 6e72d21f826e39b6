"""Repeated samples of a sensor that is read more often than it measures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..space import Array
from .resolution import noise_of, step

if TYPE_CHECKING:
    from .recording import Recording

#: Share of samples that repeat their predecessor from which on a sensor is taken to hold.
_SHARE = 0.35
_REACH = 10
#: Distinct values, and samples from one to the next, of a channel that is held.
_DISTINCT, _APART = 8, 1.5


def is_new(recording: Recording) -> NDArray[np.bool_]:
    """Which samples of the position were measured anew, (N,); see `new_samples`."""
    return new_samples(recording.position)


def new_samples(x: Array) -> NDArray[np.bool_]:
    """Which samples of a channel were measured anew, (N,).

    All of them, unless the sensor holds its value between measurements: then more than a third
    of the samples equal the one before, even where noise or motion would have changed each of
    them by more than a quantisation step. Held values are late by up to a measuring interval,
    which a model must not be blamed for.
    """
    q = step(x)
    same = np.zeros(len(x), dtype=bool)
    np.equal(x[1:], x[:-1], out=same[1:])
    lag = min(_REACH, (len(x) - 1) // 2)
    if lag < 1:
        return np.ones(len(x), dtype=bool)
    pace = x[2 * lag :] - x[: -2 * lag]
    np.abs(pace, out=pace)
    pace /= 2 * lag  # a sample's share of the motion
    telling = np.zeros(len(x), dtype=bool)
    telling[lag:-lag] = pace > q
    if noise_of(x) >= max(q, 1e-12):
        telling[:] = True
    if telling.sum() < _REACH or same[telling].mean() < _SHARE:
        return np.ones(len(x), dtype=bool)
    return ~same


def renewal(t: Array, x: Array) -> float:
    """How long a channel keeps each value that it repeats, s; 0 if it is measured at each sample.

    A channel that is held hardly ever changes twice in a row, and takes more values than a command
    that is set anew now and then.
    """
    measured = new_samples(x)
    if measured.all() or len(np.unique(x)) < _DISTINCT:
        return 0.0
    spans = np.diff(t[measured])
    interval = float(np.median(np.diff(t)))
    often = float(np.quantile(spans, 0.1)) < _APART * interval
    period = float(np.median(spans))
    return 0.0 if often or period < _APART * interval else period
