"""Channels that are worked out where they are asked for, of one that is kept.

A long log has room for one filtered channel, not for its slopes as well: these are differences of
neighbours, made for a block of samples at a time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numba import float64, types
from numpy.typing import NDArray

from ..compile_cache import compiled
from ..space import Array
from .zero_phase import BLOCK, Samples


class SampledChannel(Protocol):
    """Samples of a channel by their slice or numbers: an array, or what makes them."""

    def __len__(self) -> int:
        """How many there are."""

    def __getitem__(self, at: Samples, /) -> Array:
        """Some of them, (len(at),)."""


@dataclass(frozen=True, eq=False)
class Shifted:
    """A channel and a constant on top.

    Args:
        channel: It.
        offset: The constant.
    """

    channel: SampledChannel
    offset: float

    def __len__(self) -> int:
        return len(self.channel)

    def __getitem__(self, at: Samples, /) -> Array:
        return self.channel[at] + self.offset


#: Weights of the differences over one, two and more samples to each side, by their order of
#: accuracy (Fornberg 1988, doi 10.1090/S0025-5718-1988-0935077-0, table 1).
_WEIGHTS = {2: np.array([1 / 2]), 6: np.array([3 / 4, -3 / 20, 1 / 60])}


@dataclass(frozen=True, eq=False)
class Slope:
    """Central differences of a channel over time.

    Args:
        channel: Of which, (N,).
        rate: Samples a second.
        accuracy: Their order, 2 or 6: over one or three samples to each side. The ends, which lack
            such neighbours, have differences of order 2, and the outermost samples one-sided ones.
    """

    channel: SampledChannel
    rate: float
    accuracy: int = 6

    def __len__(self) -> int:
        return len(self.channel)

    def __getitem__(self, at: Samples, /) -> Array:
        n, reach = len(self), len(_WEIGHTS[self.accuracy])
        if not isinstance(at, slice):
            return self._at(at)
        start, stop, step = at.indices(n)
        if step != 1:
            return picked(self, np.arange(start, stop, step))
        if start >= stop:
            return np.empty(0)
        first = min(max(start, reach), stop)
        end = max(min(stop, n - reach), first)
        ends = [self._at_ends(np.arange(*span)) for span in ((start, first), (end, stop))]
        if first == end:
            return np.concatenate(ends)
        near = np.ascontiguousarray(self.channel[slice(first - reach, end + reach)])
        inner = _differences(near, _WEIGHTS[self.accuracy] * self.rate)
        return inner if len(inner) == stop - start else np.concatenate([ends[0], inner, ends[1]])

    def _at(self, at: NDArray[np.intp]) -> Array:
        """The differences at samples of any order."""
        n, reach = len(self), len(_WEIGHTS[self.accuracy])
        slope = np.empty(len(at))
        inner = (at >= reach) & (at < n - reach)
        slope[~inner] = self._at_ends(at[~inner])
        if inner.any():
            near = at[inner, None] + np.arange(-reach, reach + 1)
            x = self.channel[near.ravel()].reshape(near.shape)
            rises = x[:, reach + 1 :] - x[:, reach - 1 :: -1]
            slope[inner] = (rises * (_WEIGHTS[self.accuracy] * self.rate)).sum(axis=1)
        return slope

    def _at_ends(self, at: NDArray[np.intp]) -> Array:
        """Differences over one sample to each side that there is."""
        before, after = np.maximum(at - 1, 0), np.minimum(at + 1, len(self) - 1)
        rise = self.channel[after] - self.channel[before]
        return np.asarray(rise * self.rate / (after - before))


@dataclass(frozen=True, eq=False)
class Inner:
    """A channel without its first and last samples.

    Args:
        channel: It.
        first: Samples left out at the start.
        last: The same at the end.
    """

    channel: SampledChannel
    first: int
    last: int

    def __len__(self) -> int:
        return len(self.channel) - self.first - self.last

    def __getitem__(self, at: Samples, /) -> Array:
        if not isinstance(at, slice):
            return self.channel[at + self.first]
        start, stop, step = at.indices(len(self))
        return self.channel[slice(start + self.first, max(start, stop) + self.first, step)]


def picked(channel: SampledChannel, places: NDArray[np.intp]) -> Array:
    """Samples of a channel at rising places, (places,), a block of the channel at a time."""
    if isinstance(channel, np.ndarray):
        return np.asarray(channel[places])
    samples = np.empty(len(places))
    first = 0
    while first < len(places):
        start = places[first]
        stop = first + int(np.searchsorted(places[first:], start + BLOCK))
        block = channel[slice(int(start), int(places[stop - 1]) + 1)]
        samples[first:stop] = block[places[first:stop] - start]
        first = stop
    return samples


_F1 = types.Array(float64, 1, "C", readonly=True)


@compiled(float64[::1](_F1, _F1))
def _differences(x: Array, weights: Array) -> Array:
    """Weighted differences over one, two and more samples to each side, (n - 2 weights,)."""
    n, reach = len(x), len(weights)
    slope = np.zeros(n - 2 * reach)
    for k in range(1, reach + 1):
        weight, ahead, behind = weights[k - 1], x[reach + k :], x[reach - k :]
        for i in range(len(slope)):
            slope[i] += (ahead[i] - behind[i]) * weight
    return slope
