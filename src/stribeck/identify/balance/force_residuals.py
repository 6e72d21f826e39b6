"""The residuals of a force balance over a box of parameters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...friction.orders import orders
from ...space import Array, Space
from .regression import System

#: Shapes of the curve whose regressors are kept.
SHAPES = 16


class BalanceResiduals:
    """A force balance by its residuals: measured less predicted force, N (N m).

    Args:
        system: The stacked regression of a force balance.
    """

    def __init__(self, system: System) -> None:
        wanted = system.wanted
        self.space = Space(tuple(wanted.params[i] for i in wanted.free))
        self.logs = tuple(len(log.t) for log in system.logs)
        at = {k: i for i, k in enumerate(wanted.free)}
        self.orders = tuple((at[i], at[j]) for i, j in orders(wanted.law) if i in at and j in at)
        self._system = system
        self._linear = [wanted.free.index(i) for i in wanted.linear]
        self._shape = [wanted.free.index(i) for i in wanted.shape]
        self._known: dict[bytes, tuple[Array, Array]] = {}

    def physical(self, x: Array) -> NDArray[np.bool_]:
        """Which points the law allows."""
        wanted = self._system.wanted
        p = wanted.full(x, wanted.free)[:, : len(wanted.law.params)]
        return np.asarray(wanted.law.physical(p), dtype=bool)

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points to (n, rows) residuals; nan where the law does not allow a point."""
        good = self.physical(x)
        found = np.full((len(x), len(self._system.y)), np.nan)
        shapes = x[:, self._shape]
        for shape in np.unique(shapes[good], axis=0):
            rows = good & (shapes == shape).all(axis=1)
            found[rows] = self._shaped(shape, x[rows])
        return found

    def _shaped(self, shape: Array, x: Array) -> Array:
        """Residuals of points of one shape: affine in all else, so seldom predicted one by one."""
        system, key = self._system, shape.tobytes()
        if key not in self._known and len(x) <= len(self._linear):
            predicted = system.predicted(system.wanted.full(x, system.wanted.free))
            return np.ascontiguousarray(system.y - predicted.T)
        if key not in self._known:
            if len(self._known) >= SHAPES:
                self._known.pop(next(iter(self._known)))
            self._known[key] = system.columns(shape)
        W, base = self._known[key]
        return np.asarray(system.y - base - np.einsum("im,jm->ij", x[:, self._linear], W))
