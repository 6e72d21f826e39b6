"""A quantity that was estimated again and again, with what its estimates depend on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..space import Array

#: A normal 95 % interval is so many standard errors wide on either side.
SIDE = 1.959963984540054


@dataclass(frozen=True, eq=False)
class Series:
    """Estimates in the order of time.

    Args:
        values: (n,).
        errors: Their standard errors, as their intervals have it, (n,).
        days: The day of each, counted from any, (n,).
        kinds: The kind of each, from 0: estimates of different kinds are not compared, (n,).
        covariate: Temperature, say, on which values depend linearly; None where there is none.
    """

    values: Array
    errors: Array
    days: NDArray[np.int64]
    kinds: NDArray[np.int64]
    covariate: Array | None = None

    def __len__(self) -> int:
        return len(self.values)

    @property
    def design(self) -> Array:
        """Columns of the regression on kind and covariate, (n, p)."""
        columns = [self.kinds == kind for kind in range(int(self.kinds.max(initial=-1)) + 1)]
        design = np.array(columns, dtype=float).T
        if self.covariate is None:
            return design
        return np.column_stack([design, self.covariate - self.covariate[0]])

    def share(self, known: float) -> Array:
        """Variance of each estimate beside that of a usual one, without what a day adds, (n,).

        Args:
            known: How much of it goes with the squares of the errors; the rest is the same for all.
        """
        squares = np.square(self.errors)
        usual = float(np.median(squares[: max(3, min(len(squares), 10))]))
        if not usual > 0:
            return np.ones(len(squares))
        return np.asarray(1.0 - known + known * squares / usual)
