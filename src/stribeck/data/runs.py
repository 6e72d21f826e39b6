"""Runs of marked samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def runs(flags: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First sample and the one past the last of each run of True."""
    if not len(flags):
        return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
    inner = np.flatnonzero(flags[1:] != flags[:-1]) + 1
    first, last = ([0] if flags[0] else []), ([len(flags)] if flags[-1] else [])
    edges = np.concatenate([first, inner, last]).astype(np.intp)
    return edges[::2], edges[1::2]


def slices(flags: NDArray[np.bool_]) -> list[slice]:
    """Each run of True, as a slice."""
    starts, stops = runs(flags)
    return [slice(a, b) for a, b in zip(starts.tolist(), stops.tolist(), strict=True)]


def within(marked: NDArray[np.bool_], reach: int) -> NDArray[np.bool_]:
    """Samples at most `reach` from a marked one, (N,)."""
    starts, stops = runs(marked)
    starts, stops = np.maximum(starts - reach, 0), np.minimum(stops + reach, len(marked))
    apart = starts[1:] > stops[:-1]
    change = np.zeros(len(marked) + 1, dtype=np.int8)
    change[starts[np.r_[True, apart]] if len(starts) else starts] = 1
    change[stops[np.r_[apart, True]] if len(stops) else stops] = -1
    np.cumsum(change, out=change)  # of a long log each mask is a byte a row
    return change[:-1].view(np.bool_)
