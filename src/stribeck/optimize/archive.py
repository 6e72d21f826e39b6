"""The archive of a search: sampled cells and minima, and a surrogate for the next start."""

from __future__ import annotations

import numpy as np

from ..space import Array, Rng
from .unit_cube import squares

#: Cells, minima and starts of descents that are kept.
CELLS, MINIMA, STARTS = 100, 300, 100
#: Cells that are looked at together.
BLOCK = 20
#: Floors closer than this, in every coordinate, are one.
SAME = 1e-3
#: Up to so many dimensions Kronecker's sequence fills the cube more evenly than chance does.
EVEN = 12


class Archive:
    """Cells, the minima of basins, and the places from which descents began.

    Attributes:
        dim: Of the space.
        best: The least cost met so far, wherever.
        minima: Points of the unit cube at which descents ended, (k, dim).
        costs: Theirs, (k,).
    """

    def __init__(self, dim: int, rng: Rng) -> None:
        self.dim, self._rng, self.best = dim, rng, np.inf
        self.minima, self.costs = np.empty((0, dim)), np.empty(0)
        self._cells, self._J = np.empty((0, dim)), np.empty(0)  # in order of cost
        self._starts = np.empty((0, dim))
        self._drawn, self._shift, self._stride = 0, rng.random(dim), _stride(dim)

    def sample(self, n: int) -> Array:
        """`n` more places for cells, (n, dim), which fill the cube evenly whatever their number.

        (In more than `EVEN` dimensions they are random.)
        """
        if self.dim > EVEN:
            self._drawn += n
            return self._rng.random((n, self.dim))
        k = np.arange(self._drawn, self._drawn + n)[:, None]
        self._drawn += n
        places: Array = (self._shift + k * self._stride) % 1.0
        return places

    def keep(self, theta: Array, J: Array) -> None:
        """Remember cells, (n, dim), and their costs, the better ones for longer."""
        theta, J = np.vstack([self._cells, theta]), np.concatenate([self._J, J])
        order = np.argsort(J, kind="stable")[:CELLS]
        order = order[np.isfinite(J[order])]
        self._cells, self._J = theta[order], J[order]

    def update(self, cost: float) -> bool:
        """The least cost of a batch; says whether it is notably better than all before."""
        better = cost < self.best - self.little
        self.best = min(self.best, cost)
        return better

    @property
    def worth(self) -> float:
        """How far the best is below the middle of the cells: what there was to be gained."""
        return float(self._J[len(self._J) // 2]) - self.best if len(self._J) else 0.0

    @property
    def little(self) -> float:
        """A gain that is none: a millionth of what there was to be gained."""
        return 1e-6 * max(self.worth, 0.0) if np.isfinite(self.best) else 0.0

    def start(self, share: float) -> tuple[Array, float] | None:
        """The best cell that stands for a basin of its own, and its cost; it is taken out.

        It does if nothing better is known within a radius that shrinks as cells get more, and no
        descent began there. (The form of the rule is that of multi-level single linkage: Rinnooy
        Kan and Timmer 1987, doi 10.1007/BF02592071. Its guarantees need a larger radius.)
        """
        if not len(self._J):
            return None
        radius = share * (np.log(self._drawn + 1) / self._drawn) ** (1.0 / self.dim)
        visited = np.vstack([self._cells, self.minima, self._starts])
        costs = np.concatenate([self._J, self.costs, np.full(len(self._starts), -np.inf)])
        for begin in range(0, len(self._J), BLOCK):  # mostly it is one of the first
            block = slice(begin, begin + BLOCK)
            neighbours = squares(self._cells[block], visited) < radius**2
            neighbours &= costs < self._J[block, None]
            alone = np.flatnonzero(~neighbours.any(axis=1))
            if len(alone):
                k = begin + int(alone[0])
                chosen = self._cells[k], float(self._J[k])
                self._cells, self._J = np.delete(self._cells, k, axis=0), np.delete(self._J, k)
                return chosen
        return None

    def begin(self, u: Array) -> None:
        """A descent begins here: no other one will for a while."""
        self._starts = np.vstack([self._starts, u])[-STARTS:]

    def end(self, u: Array, cost: float) -> None:
        """A descent ended here; where nothing could be run there is nothing to remember."""
        if not np.isfinite(cost):
            return
        if len(self.costs):
            distance = np.abs(self.minima - u).max(axis=1)
            k = int(distance.argmin())
            if distance[k] < SAME:
                if cost < self.costs[k]:
                    self.minima[k], self.costs[k] = u, cost
                return
        self.minima = np.vstack([self.minima, u])
        self.costs = np.append(self.costs, cost)
        if len(self.costs) > MINIMA:
            cheapest = np.sort(np.argsort(self.costs, kind="stable")[: MINIMA // 2])
            self.minima, self.costs = self.minima[cheapest], self.costs[cheapest]

    def surrogate_minimum(self) -> Array | None:
        """Where the minima themselves seem to lead: the least of a quadratic through the best.

        Basins often line a wider valley, whose own minimum no slope inside a basin shows. The place
        is one that no minimum or start is near, (dim,); None while too few minima are known.
        """
        dim, n = self.dim, len(self.costs)
        if n < dim + 2:
            return None
        bends = dim * (dim + 1) // 2
        best = np.argsort(self.costs, kind="stable")[: min(max(3 + dim + bends, n // 2), 60)]
        X, y = self.minima[best], self.costs[best] - self.costs[best[0]]
        if not y.max() > 0.0:
            return None
        y /= y.max()
        if len(best) > dim + bends:
            i, j = np.triu_indices(dim)
        elif len(best) > 2 * dim:
            i = j = np.arange(dim)
        else:
            i = j = np.arange(0)
        origin = X[0]
        weights = np.linalg.lstsq(_terms(X - origin, i, j), y, rcond=None)[0]
        margin = 0.5 * np.ptp(X, axis=0)
        low = np.maximum(X.min(axis=0) - margin, 0.0)
        high = np.minimum(X.max(axis=0) + margin, 1.0)
        places = low + (high - low) * self._rng.random((100, dim))
        if len(i):
            bend = np.zeros((dim, dim))
            np.add.at(bend, (i, j), weights[dim + 1 :])
            bend += bend.T
            ahead = np.linalg.lstsq(bend, weights[1 : dim + 1], rcond=None)[0]
            places = np.vstack([np.clip(origin - ahead, low, high), places])
        promise = _terms(places - origin, i, j) @ weights
        gaps = squares(X, X)
        np.fill_diagonal(gaps, np.inf)
        distant = self._gap(places) > 0.2 * np.median(gaps.min(axis=1))
        if not distant.any():
            return None
        k: Array = places[np.flatnonzero(distant)[promise[distant].argmin()]]
        return k

    def thinnest(self) -> Array:
        """Of some random places the one farthest from all that is known, (dim,)."""
        places = self._rng.random((10 * self.dim, self.dim))
        place: Array = places[self._gap(places).argmax()]
        return place

    def _gap(self, places: Array) -> Array:
        """Squared distances to the nearest minimum or start."""
        visited = np.vstack([self.minima, self._starts])
        return (
            squares(places, visited).min(axis=1) if len(visited) else np.full(len(places), np.inf)
        )


def _terms(z: Array, i: np.ndarray, j: np.ndarray) -> Array:
    return np.column_stack([np.ones(len(z)), z, z[:, i] * z[:, j]])


def _stride(dim: int) -> Array:
    """The step of Kronecker's sequence: powers of the root of g^(dim + 1) = g + 1."""
    g = 2.0
    for _ in range(60):  # converges by a factor of at least 2 a turn
        g = (1.0 + g) ** (1.0 / (dim + 1))
    return g ** -np.arange(1.0, dim + 1.0)
