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


@dataclass(frozen=True, eq=False)
class Slope:
    """Central differences of a channel over time, one-sided at its ends.

    Args:
        channel: Of which.
        rate: Samples a second.
    """

    channel: SampledChannel
    rate: float

    def __len__(self) -> int:
        return len(self.channel)

    def __getitem__(self, at: Samples, /) -> Array:
        n, dt = len(self), 1.0 / self.rate
        if not isinstance(at, slice):
            before, after = np.maximum(at - 1, 0), np.minimum(at + 1, n - 1)
            rise = self.channel[after] - self.channel[before]
            return np.asarray(rise / ((after - before) * dt))
        start, stop, step = at.indices(n)
        if step != 1:
            return self[np.arange(start, stop, step)]
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
