"""The spectrum of a contact: at which displacements which share of its friction has yielded.

Maxwell elements of many fixed yield displacements are linear in their levels, so that a motion and
its force give the levels at once, without a start (W. D. Iwan 1966, doi 10.1115/1.3625199). What a
law with states is, roughly, is read off them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ..space import Array

#: Bins of a spectrum that are told apart; neighbours are merged until so many are left.
_MOST = 12
#: Share of the friction that yields last, of which elements may be an artefact.
_TAIL = 0.1


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Levels of Maxwell elements over the displacements at which they yield.

    Args:
        yields: Displacements, rising, m (rad), (m,).
        levels: What yields at each, at least one above 0, N (N m), (m,).
        speeds: Speeds at which the axis slides, rising, m/s (rad/s), (s,).
    """

    yields: Array
    levels: Array
    speeds: Array

    @property
    def level(self) -> float:
        """Friction once all of it has yielded, N (N m)."""
        return float(self.levels.sum())

    @property
    def stiffness(self) -> float:
        """Slope of the friction after a reversal, N/m (N m/rad)."""
        return float(np.sum(self.levels / self.yields))

    @property
    def way(self) -> float:
        """Displacement by which half of the friction has yielded, m (rad)."""
        share = np.cumsum(self.levels) / self.level
        return float(self.yields[int(np.searchsorted(share, 0.5))])

    def without_tail(self) -> Spectrum:
        """The same without the last tenth of its friction, in which a drop with speed hides."""
        kept = np.cumsum(self.levels) <= (1.0 - _TAIL) * self.level
        kept[int(np.argmin(kept))] = True
        return replace(self, levels=np.where(kept, self.levels, 0.0))

    def merged(self, n: int) -> tuple[Array, Array]:
        """Levels and yields of n elements that are nearest to it, (n,) each, yields rising.

        Neighbours are merged so that their logarithms of yield scatter least about those of the
        elements, weighted by level; one element is split where there are fewer.
        """
        W, d = self._bins()
        while len(W) < n:
            k = int(np.argmax(W))
            W = np.insert(W, k, 0.5 * W[k])
            W[k + 1] *= 0.5
            d = np.insert(d, k, d[k] / 2)
            d[k + 1] *= 2
            d.sort()
        parts = min(
            (np.split(np.arange(len(W)), at) for at in combinations(range(1, len(W)), n - 1)),
            key=lambda parts: sum(_scatter(W[k], d[k]) for k in parts),
        )
        means = [float(np.exp(np.average(np.log(d[k]), weights=W[k]))) for k in parts]
        return np.array([W[k].sum() for k in parts]), np.array(means)

    def _bins(self) -> tuple[Array, Array]:
        counts = self.levels > 0
        W, d = self.levels[counts], self.yields[counts].copy()
        while len(W) > _MOST:
            k = int(np.argmin(W[:-1] + W[1:]))
            total = W[k] + W[k + 1]
            d[k] = np.exp((W[k] * np.log(d[k]) + W[k + 1] * np.log(d[k + 1])) / total)
            W = np.delete(W, k + 1)
            W[k], d = total, np.delete(d, k + 1)
        return W.copy(), d


def _scatter(W: Array, d: Array) -> float:
    logs = np.log(d)
    return float(np.sum(W * (logs - np.average(logs, weights=W)) ** 2))
