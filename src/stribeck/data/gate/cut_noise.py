"""A noisy channel that a limit cuts off, with or without noise of a later stage on top.

Noise that a limit cuts off makes no plateau: a sample is at the limit, the next one below. But what
would lie beyond the limit all lies at it. Noise that a later stage adds spreads that heap, and by
less than the channel itself is noisy, which the upper edge of no other density is: noise on top of
whatever motion leaves no edge sharper than itself.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from ..resolution import stretches

#: Share of the samples that lie at a limit at least, and beyond it at most.
SHARE, _BEYOND = 0.005, 0.001
#: Rounds by which the middle of a heap and its spread are found.
_ROUNDS = 3
#: Standard deviations of the noise on top that a heap reaches to each side, for a count of it and
#: for all of it, and beyond which there is nothing.
_COUNTED, _REACH, _OUT = 2.0, 3.0, 5.0
#: The noise on top is this share of the channel's own at most; that is so many steps of the sensor.
_SHARPER, _STEPS = 0.25, 3.0
#: A heap is told beside noise: next to samples that are lower by this share of a standard
#: deviation, as many of which are one below the heap as show how dense it would be without a limit.
_LOWER, _FEWEST = 0.5, 10
#: A heap has so many more samples than that, in those of a standard deviation of such density (a
#: limit in the middle of noise makes 1.3, one that cuts off a tenth 0.6; the crests of waves
#: of a few samples 0.3), and in standard deviations of the count.
_HEAPED, _SURE = 0.4, 4.0
#: Second differences that tell the noise, and the median of their size for one of its deviations.
_BENDS, _MEDIAN_OF_BENDS = 30, 0.6745 * 6.0**0.5


class _Heap(NamedTuple):
    """The narrowest heap of an upper half: its middle, and the noise on top."""

    level: float
    sd: float


def cut_noise(y: Array, q: float) -> NDArray[np.bool_]:
    """Samples at the upper limit of a channel, where it cuts off noise, (N,).

    Args:
        y: The channel.
        q: Its quantisation step.
    """
    some = stretches(y)
    heap = _heap(np.sort(some))
    rows = np.zeros(len(y), dtype=bool)
    if _is_limit(some, heap, q):
        rows |= y >= heap.level - max(_REACH * heap.sd, 0.5 * q, _tiny(some))
    return rows if SHARE <= rows.mean() <= 1.0 - SHARE else np.zeros(len(y), dtype=bool)


def _tiny(y: Array) -> float:
    return 1e-9 * float(np.ptp(y))


def _heap(values: Array) -> _Heap:
    """The narrowest heap in the upper half of sorted values."""
    upper = values[len(values) // 2 :]
    count = max(int(0.5 * SHARE * len(values)), 1)
    widths = upper[count:] - upper[:-count]
    if not len(widths):
        return _Heap(float(values[-1]), 0.0)
    first = len(widths) - 1 - int(np.argmin(widths[::-1]))
    level, sd = float(np.median(upper[first : first + count + 1])), 0.0
    for _ in range(_ROUNDS):
        above = upper[upper > level] - level
        sd = float(np.median(above)) / 0.6745 if len(above) else 0.0
        level = float(np.median(upper[np.abs(upper - level) <= _COUNTED * sd]))
    return _Heap(level, sd)


def _is_limit(y: Array, heap: _Heap, q: float) -> bool:
    """Whether a heap is what a limit has cut off, by the samples beside it."""
    level, tiny = heap.level, _tiny(y)
    reach = max(_COUNTED * heap.sd, 0.5 * q, tiny)
    at, under = np.abs(y - level) <= reach, y < level - reach
    if np.mean(y > level + max(_OUT * heap.sd, q, tiny)) > _BEYOND or at.mean() < SHARE:
        return False
    if not under.any():
        return False
    free = under & (y > np.median(y[under]))  # the other limit does not show the noise
    inner = free[:-2] & free[1:-1] & free[2:]
    bends = np.abs(y[:-2] - 2.0 * y[1:-1] + y[2:])[inner]
    if len(bends) < _BENDS:
        return False
    sd = float(np.median(bends)) / _MEDIAN_OF_BENDS
    if sd <= _STEPS * q or heap.sd > _SHARPER * sd:
        return False
    low = y < level - max(reach, _LOWER * sd)
    beside = np.zeros(len(y), dtype=bool)
    beside[1:] |= low[:-1]
    beside[:-1] |= low[1:]
    width = max(reach, _LOWER * sd)
    width = q * np.ceil(width / q) if q else width
    below = int((beside & under & (y >= level - reach - width)).sum())
    density, count = below / width, int((beside & at).sum())
    excess = count - 2.0 * reach * density
    sure = excess > _SURE * np.sqrt(count + 2.0 * reach * density)
    return bool(sure and below >= _FEWEST and excess > _HEAPED * density * sd)
