"""The path of a measured motion without the to and fro of its sensor.

A friction law with states adds up the way that an axis goes, to and fro: bristles bend back and
slip by noise that no velocity shows. So the path is taken as monotone from one reversal to the
next, and a reversal is what turns back by more than the sensor may be off. Between reversals it is
the monotone sequence nearest to the measured one (isotonic regression: Barlow, Bartholomew,
Bremner, Brunk 1972; by pooling adjacent violators). Where it turns, the farthest of noisy samples
lies too far: as much is cut off as denoising by total variation would (Rudin, Osher, Fatemi 1992).
"""

from __future__ import annotations

import numpy as np
from numba import float64, int64, types, void
from numpy.typing import NDArray

from ..compile_cache import compiled
from ..space import Array, contiguous

_F1 = types.Array(float64, 1, "C", readonly=True)


def motion_path(x: Array, threshold: float, noise: float) -> Array:
    """The path that is monotone between reversals, (N,).

    Args:
        x: Positions, (N,).
        threshold: A way back that is a reversal if the motion exceeds it, in the unit of x.
        noise: Standard deviation of the positions' noise, in the same unit.
    """
    places = turns(x, threshold)
    path = np.asarray(_path(contiguous(x), places))
    if noise > 0:
        _cut(path, places, float(noise))
    return path


def turns(x: Array, threshold: float) -> NDArray[np.int64]:
    """The samples at which a motion turns back by more than a threshold, with both ends."""
    return np.asarray(_turns(contiguous(x), float(threshold)))


@compiled(int64[::1](_F1, float64))
def _turns(x: Array, threshold: float) -> NDArray[np.int64]:
    n = len(x)
    places = np.zeros(n + 1, dtype=np.int64)
    count, low, high, way = 1, 0, 0, 0
    for i in range(n):
        if x[i] > x[high]:
            high = i
        if x[i] < x[low]:
            low = i
        if way >= 0 and x[high] - x[i] > threshold:
            if way > 0:  # before the first stroke there is noise alone
                places[count] = high
                count += 1
            way, low, high = -1, i, i
        elif way <= 0 and x[i] - x[low] > threshold:
            if way < 0:
                places[count] = low
                count += 1
            way, low, high = 1, i, i
    places[count] = n - 1
    return places[: count + 1].copy()


@compiled(float64[::1](_F1, int64[::1]))
def _path(x: Array, places: NDArray[np.int64]) -> Array:
    path = x.copy()
    mean = np.empty(len(x))
    weight = np.empty(len(x))
    for k in range(len(places) - 1):
        first, last = places[k], places[k + 1]
        sign = 1.0 if x[last] >= x[first] else -1.0
        pools = 0
        for i in range(first, last + 1):
            mean[pools], weight[pools] = sign * x[i], 1.0
            pools += 1
            while pools > 1 and mean[pools - 2] > mean[pools - 1]:
                total = weight[pools - 2] + weight[pools - 1]
                mean[pools - 2] += (mean[pools - 1] - mean[pools - 2]) * weight[pools - 1] / total
                weight[pools - 2] = total
                pools -= 1
        at = first
        for j in range(pools):
            for _ in range(int(weight[j])):
                path[at] = sign * mean[j]
                at += 1
    return path


@compiled(void(float64[::1], int64[::1], float64))
def _cut(path: Array, places: NDArray[np.int64], most: float) -> None:
    """Level the turns of a path in place: what lies beyond a level sums to `most` at each."""
    for k in range(1, len(places) - 1):
        first, at, last = places[k - 1], places[k], places[k + 1]
        sign = 1.0 if path[at] >= path[first] else -1.0
        left, right, area, level = at, at, 0.0, sign * path[at]
        while left - 1 > first or right + 1 < last:
            before = sign * path[left - 1] if left - 1 > first else -np.inf
            after = sign * path[right + 1] if right + 1 < last else -np.inf
            width, below = right - left + 1, max(before, after)
            if area + (level - below) * width > most:
                level -= (most - area) / width
                break
            area += (level - below) * width
            level = below
            if before >= after:
                left -= 1
            else:
                right += 1
        path[left : right + 1] = sign * level
