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
        self.space = Space(system.parameters.free)
        self.logs = tuple(len(log.t) for log in system.logs)
        at = {k: i for i, k in enumerate(system.free)}
        self.orders = tuple((at[i], at[j]) for i, j in orders(system.law) if i in at and j in at)
        self._system = system
        self._linear = [system.free.index(i) for i in system.linear]
        self._shape = [system.free.index(i) for i in system.shape]
        self._known: dict[bytes, tuple[Array, Array]] = {}

    def physical(self, x: Array) -> NDArray[np.bool_]:
        """Which points the law allows."""
        law = self._system.law
        p = self._system.parameters.full(x)[:, : len(law.params)]
        return np.asarray(law.physical(p), dtype=bool)

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points to (n, rows) residuals; nan where the law does not allow a point."""
        physical = self.physical(x)
        residuals = np.full((len(x), len(self._system.y)), np.nan)
        shapes = x[:, self._shape]
        for shape in np.unique(shapes[physical], axis=0):
            rows = physical & (shapes == shape).all(axis=1)
            residuals[rows] = self._shaped(shape, x[rows])
        return residuals

    def _shaped(self, shape: Array, x: Array) -> Array:
        """Residuals of points of one shape: affine in all else, so seldom predicted one by one."""
        system, key = self._system, shape.tobytes()
        if key not in self._known and len(x) <= len(self._linear):
            predicted = system.predicted(system.parameters.full(x))
            return np.ascontiguousarray(system.y - predicted.T)
        if key not in self._known:
            if len(self._known) >= SHAPES:
                self._known.pop(next(iter(self._known)))
            self._known[key] = system.columns(shape)
        W, base = self._known[key]
        return np.asarray(system.y - base - np.einsum("im,jm->ij", x[:, self._linear], W))
