"""The kind of a force channel: measured or computed from the position; clean or with spikes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..space import Array
from ..wording import either

if TYPE_CHECKING:
    from .recording import Recording

#: A force that keeps this close to a function of the position, as a share of its own spread,
#: whichever way the axis moves, was computed from it.
EXACT = 0.03
#: A force has spikes if what stands away from both neighbours makes this share of its variance, and
#: its fourth moment is that of few large ones (white noise has 7).
SPIKES, KURTOSIS = 0.05, 12.0
#: Bins of position; those passed both ways that it takes, and samples each way in one.
_BINS, _BOTH, _WAY = 60, 8, 4
#: Samples that are worked on at once.
BLOCK = 1 << 16


def force_left_out(recording: Recording) -> str:
    """The column that was not taken as force for its unit, and how to say it; or nothing."""
    left = next((n for n in recording.notes if n.endswith("was not taken as force")), "")
    way = either("", "; `read` and `Recording.of` take it as drive={...}")
    return left and f"{left}; `stribeck drives` shows what that can be and how to say it{way}"


def both_ways(t: Array, position: Array, force: Array) -> float | None:
    """How far a force is from a function of the position, as a share of its spread.

    Root mean square about a line in each of 60 bins of position that are passed both ways; None
    where there are too few of these, or the force is the same everywhere.
    """
    span = float(np.ptp(position))
    if not span > 0:
        return None
    least = position.min()

    def blocks() -> Iterator[tuple[NDArray[np.intp], slice]]:
        for k in range(0, len(t), BLOCK):
            rows = slice(k, min(k + BLOCK, len(t)))
            bins = (_BINS * (position[rows] - least) / span).astype(int)
            yield np.minimum(bins, _BINS - 1), rows

    def sums(bins: NDArray[np.intp], values: Array | NDArray[np.bool_]) -> Array:
        return np.asarray(np.bincount(bins, values, _BINS), dtype=float)

    counted = np.zeros((5, _BINS))
    for bins, rows in blocks():
        first, last = max(rows.start - 1, 0), min(rows.stop + 1, len(t))
        v = np.gradient(position[first:last], t[first:last])[rows.start - first :][: len(bins)]
        of = (v > 0, v < 0, np.ones(len(bins)), position[rows], force[rows])
        counted += [sums(bins, values) for values in of]
    used = counted[:2].min(axis=0) >= _WAY
    if np.count_nonzero(used) < _BOTH:
        return None
    n = np.maximum(counted[2], 1.0)
    middle, level, mean = counted[3] / n, counted[4] / n, counted[4][used].sum() / n[used].sum()
    squares = np.zeros((4, _BINS))
    for bins, rows in blocks():
        x, y = position[rows] - middle[bins], force[rows] - level[bins]
        squares += [
            sums(bins, values) for values in (x * x, x * y, y * y, (force[rows] - mean) ** 2)
        ]
    xx, xy, yy, total = squares[:, used]
    residual = float(np.sum(yy - xy**2 / np.maximum(xx, 1e-300)))
    # The sums cancel where nothing is left, to their last digits.
    return float(np.sqrt(max(residual, 0.0) / total.sum())) if total.sum() > 0 else None


def spikes(forces: Sequence[Array]) -> float:
    """The share of a force's variance that single samples make, far from both of their neighbours.

    0 if they are not few and large. Several stretches of one force count together.
    """
    square, fourth, variance, inner, count = 0.0, 0.0, 0.0, 0, 0
    for f in forces:
        mean = float(f.mean())
        for k in range(0, len(f), BLOCK):
            variance += float(np.sum((f[k : k + BLOCK] - mean) ** 2))
            a, b, c = (f[k + i : k + i + BLOCK][: len(f) - 2 - k] for i in range(3))
            middle = np.maximum(np.minimum(a, b), np.minimum(np.maximum(a, b), c))
            square += float(np.sum((b - middle) ** 2))
            fourth += float(np.sum((b - middle) ** 4))
        inner, count = inner + len(f) - 2, count + len(f)
    square, fourth, variance = square / inner, fourth / inner, variance / count
    heavy_tailed = fourth >= KURTOSIS * square**2
    return (
        square / variance if heavy_tailed and square >= SPIKES * variance and variance > 0 else 0.0
    )
