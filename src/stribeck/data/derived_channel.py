"""Channels that are worked out where they are asked for, of one that is kept.

A long log has room for one filtered channel, not for its slopes as well: these are differences of
neighbours, made for a block of samples at a time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..space import Array
from .zero_phase import Samples


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


#: Weights of the differences of order 6 over one, two and three samples to each side.
_WIDE = (3 / 4, -3 / 20, 1 / 60)


@dataclass(frozen=True, eq=False)
class Slope:
    """Central differences of a channel over time, one-sided at its ends.

    Args:
        channel: Of which.
        rate: Samples a second.
        wide: Whether over three samples to each side, of order 6 (Fornberg 1988, doi
            10.1090/S0025-5718-1988-0935077-0, table 1), but for three samples at each end.
    """

    channel: SampledChannel
    rate: float
    wide: bool = False

    def __len__(self) -> int:
        return len(self.channel)

    def __getitem__(self, at: Samples, /) -> Array:
        slope = self._over_neighbours(at)
        reach, n = len(_WIDE), len(self)
        if not self.wide or n <= 2 * reach or not len(slope):
            return slope
        if isinstance(at, slice) and at.indices(n)[2] == 1:
            start, stop, _ = at.indices(n)
            first, end = max(start, reach), min(stop, n - reach)
            if first < end:
                x = self.channel[slice(first - reach, end + reach)]
                slope[first - start : end - start] = self._weighted(x, reach, end - first)
            return slope
        samples = np.arange(n)[at] if isinstance(at, slice) else at
        inner = (samples >= reach) & (samples < n - reach)
        if inner.any():
            near = samples[inner][:, None] + np.arange(-reach, reach + 1)
            x = self.channel[near.ravel()].reshape(near.shape).T
            slope[inner] = self._weighted(x, reach, 1)[0]
        return slope

    def _weighted(self, x: Array, reach: int, n: int) -> Array:
        """The differences of order 6 at n samples from the one numbered `reach` on, (n, ...)."""
        return np.asarray(sum(
            weight * self.rate * (x[reach + k : reach + k + n] - x[reach - k : reach - k + n])
            for k, weight in enumerate(_WIDE, 1)
        ))  # fmt: skip

    def _over_neighbours(self, at: Samples) -> Array:
        n, dt = len(self), 1.0 / self.rate
        if not isinstance(at, slice):
            before, after = np.maximum(at - 1, 0), np.minimum(at + 1, n - 1)
            rise = self.channel[after] - self.channel[before]
            return np.asarray(rise / ((after - before) * dt))
        start, stop, step = at.indices(n)
        if step != 1:
            return self._over_neighbours(np.arange(start, stop, step))
        if start >= stop:
            return np.empty(0)
        x = self.channel[slice(max(start - 1, 0), min(stop + 1, n))]
        slope = np.empty(stop - start)
        inner = slice(int(start == 0), len(slope) - int(stop == n))
        np.subtract(x[2:], x[:-2], out=slope[inner])
        slope[inner] /= 2.0 * dt
        if start == 0:
            slope[0] = (x[1] - x[0]) / dt
        if stop == n:
            slope[-1] = (x[-1] - x[-2]) / dt
        return slope


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
