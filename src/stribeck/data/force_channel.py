"""The kind of a force channel: measured or computed from the position; clean or with spikes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..space import Array

#: A force that keeps this close to a function of the position, as a share of its own spread,
#: whichever way the axis moves, was computed from it.
EXACT = 0.03
#: A force has spikes if what stands away from both neighbours makes this share of its variance, and
#: its fourth moment is that of few large ones (white noise has 7).
SPIKES, KURTOSIS = 0.05, 12.0
#: Bins of position; those passed both ways that it takes, and samples each way in one.
_BINS, _BOTH, _WAY = 60, 8, 4


def both_ways(t: Array, position: Array, force: Array) -> float | None:
    """How far a force is from a function of the position, as a share of its spread.

    Root mean square about a line in each of 60 bins of position that are passed both ways; None
    where there are too few of these, or the force is the same everywhere.
    """
    span = float(np.ptp(position))
    if not span > 0:
        return None
    bins = np.minimum((_BINS * (position - position.min()) / span).astype(int), _BINS - 1)
    v = np.gradient(position, t)
    residual, total, n, used = 0.0, [], 0, 0
    for k in range(_BINS):
        at = bins == k
        if min(np.count_nonzero(v[at] > 0), np.count_nonzero(v[at] < 0)) < _WAY:
            continue
        x, y = position[at] - position[at].mean(), force[at] - force[at].mean()
        slope = float(x @ y) / max(float(x @ x), 1e-300)
        residual += float(np.sum((y - slope * x) ** 2))
        total.append(force[at])
        n, used = n + int(np.count_nonzero(at)), used + 1
    if used < _BOTH:
        return None
    spread = float(np.std(np.concatenate(total)))
    return float(np.sqrt(residual / n)) / spread if spread > 0 else None


def spikes(forces: Sequence[Array]) -> float:
    """The share of a force's variance that single samples make, far from both of their neighbours.

    0 if they are not few and large. Several stretches of one force count together.
    """
    alone = [f[1:-1] - np.median([f[:-2], f[1:-1], f[2:]], axis=0) for f in forces]
    d, centred = np.concatenate(alone), np.concatenate([f - f.mean() for f in forces])
    square, variance = float(np.mean(d**2)), float(np.mean(centred**2))
    heavy_tailed = float(np.mean(d**4)) >= KURTOSIS * square**2
    return (
        square / variance if heavy_tailed and square >= SPIKES * variance and variance > 0 else 0.0
    )
