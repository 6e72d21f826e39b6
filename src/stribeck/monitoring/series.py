"""A quantity that was estimated again and again, with what its estimates depend on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..space import Array

#: A normal 95 % interval is so many standard errors wide on either side.
SIDE = 1.959963984540054
#: What is usual in a series is the median of so many of its first, which later ones do not change.
_USUAL = 10


@dataclass(frozen=True, eq=False)
class Series:
    """Estimates in the order of time.

    Args:
        values: (n,).
        errors: Their standard errors, as their intervals have it, (n,).
        times: In days, counted from any midnight, (n,).
        kinds: The kind of each, from 0: estimates of different kinds are not compared, (n,).
        covariate: Temperature, say, on which values depend linearly; None where there is none.
    """

    values: Array
    errors: Array
    times: Array
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

    @cached_property
    def days(self) -> Array:
        """The day of each, in usual gaps from one day with estimates to the next, (n,)."""
        days = np.floor(self.times)
        gaps = np.diff(days)
        gaps = gaps[gaps > 0][:_USUAL]
        return np.asarray(days / (np.median(gaps) if len(gaps) else 1.0))

    def share(self, known: float) -> Array:
        """Variance of each estimate beside that of a usual one, without what a day adds, (n,).

        Args:
            known: How much of it goes with the squares of the errors; the rest is the same for all.
        """
        squares = np.square(self.errors)
        usual = float(np.median(squares[:_USUAL]))
        if not usual > 0:
            return np.ones(len(squares))
        return np.asarray(1.0 - known + known * squares / usual)

    def covariance(self, scatter: ScatterModel) -> Array:
        """Covariance of the estimates about their levels, in s^2, (n, n)."""
        apart = np.abs(self.days[:, None] - self.days)
        logs = (1.0 - scatter.day_share) * self.share(scatter.known_share)
        return np.asarray(scatter.day_share * scatter.memory**apart + np.diag(logs))


@dataclass(frozen=True)
class ScatterModel:
    """How estimates scatter about their level while nothing changes.

    Args:
        day_share: r, the share of days in the variance s^2 of a usual estimate.
        known_share: c, how much of what is not the day's goes with the squares of the errors.
        memory: a, the correlation of the effects of two days that are a usual gap apart.
    """

    day_share: float
    known_share: float
    memory: float
