"""The residuals of a force balance over a box of parameters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...friction.orders import orders
from ...space import Array, Space
from ..uncertainty.residuals import ROUNDING
from .regression import System


class BalanceResiduals:
    """A force balance by its residuals: measured less predicted force, N (N m).

    Args:
        system: The stacked regression of a force balance.
    """

    def __init__(self, system: System) -> None:
        self.space = Space(system.parameters.free)
        self.logs = tuple(len(log.t) for log in system.logs)
        at = {k: i for i, k in enumerate(system.free)}
        pairs = orders(system.law, nonlinear=system.law.states > 0)
        self.orders = tuple((at[i], at[j]) for i, j in pairs if i in at and j in at)
        self._system, self._prior = system, system.free_prior
        self.priors = len(self._prior)
        # Ranges of a balance are wide enough for a press, and say nothing of the force of a motor.
        self.rounding = ROUNDING * float(np.abs(system.y).max(initial=0.0))
        self._shape = [system.free.index(i) for i in system.shape]

    def physical(self, x: Array) -> NDArray[np.bool_]:
        """Which points the law allows."""
        law = self._system.law
        p = self._system.parameters.full(x)[:, : len(law.params)]
        return np.asarray(law.physical(p), dtype=bool)

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points to (n, rows) residuals; nan where the law does not allow a point."""
        physical = self.physical(x)
        rows = len(self._system.y)
        residuals = np.full((len(x), rows + self.priors), np.nan)
        shapes = x[:, self._shape]
        for shape in np.unique(shapes[physical], axis=0):
            at = np.flatnonzero(physical & (shapes == shape).all(axis=1))
            # What is kept is as fast point by point; else logs are filtered for all at once.
            for some in [[i] for i in at] if self._system.is_kept(shape) else [at]:
                forces = self._system.predicted(self._system.parameters.full(x[some]))
                residuals[some, :rows] = np.subtract(self._system.y[:, None], forces, out=forces).T
        residuals[:, rows:] = -x @ self._prior.T
        return residuals
