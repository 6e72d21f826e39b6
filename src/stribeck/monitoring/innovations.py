"""What each estimate differs by from those before it, standardised: independent differences.

An estimate of kind g, at covariate x, on day d, is m_g + b x + u_d + e, where u and e are normal:
u of variance r s^2, the same for all estimates of a day, its correlation between days a^t at a
distance of t usual gaps; e of variance (1 - r) s^2 w, where w is 1 - c + c times the square of its
own standard error over a usual one. Nothing is known of m, b and s before the first estimate.

For a given (r, c, a) the recursive residuals of that regression (Brown, Durbin and Evans 1975,
doi 10.1111/j.2517-6161.1975.tb01532.x) are independent; they come from a Kalman filter with diffuse
levels. Over the residuals before it, a residual is a Student's t, whose probability as a normal
quantile is standard normal: a self-starting chart (Hawkins 1987, doi 10.2307/2348827; Quesenberry
1991, doi 10.1080/00224065.1991.11979328), exact from the third estimate on, that needs no period
in which all is well. r, c and a are on a grid; the predictions of its points are weighed by the
restricted likelihood of all that was before.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Self

import numpy as np
from scipy.special import ndtri, stdtr

from ..space import Array
from .series import ScatterModel, Series

#: Grid of r, c and a. It has more of large r: until days have shown otherwise they may differ.
DAY_SHARES = (0.0, 0.25, 0.5, 0.7, 0.8, 0.9, 0.95)
KNOWN_SHARES = (0.0, 0.5, 1.0)
MEMORIES = (0.0, 0.5, 0.8)
#: Variance of a level of which nothing is known, and that of a prediction above which it rests on
#: such a level, in s^2.
_DIFFUSE, _UNKNOWN = 1e10, 50.0
#: Residuals before the first that is standardised.
_FEWEST = 2
#: No standardised difference is larger; no sum of squares, scatter or probability is less.
_LARGEST, _LEAST = 8.0, 1e-300


@dataclass(frozen=True, eq=False)
class Filter:
    """The state of the filter between two estimates, for every point of the grid, (G, ...).

    Args:
        mean: Of the levels, the slope and the day's effect, (G, p + 1).
        variance: Of the same, in s^2, (G, p + 1, p + 1).
        response: By how much the mean has followed a level that is 1 higher since the last day's
            beginning, (G, p + 1).
        first: Deviation of the last day's first residual, in s, (G,).
        squares: Sum of the squares of the residuals so far, (G,).
        logs: Sum of the logarithms of their variances, (G,).
        count: How many residuals there are.
        day: The day of the last estimate, in usual gaps; None where no day is known.
    """

    mean: Array
    variance: Array
    response: Array
    first: Array
    squares: Array
    logs: Array
    count: int = 0
    day: float | None = None

    @classmethod
    def of(cls, columns: int) -> Self:
        """The state before the first estimate of a regression with so many columns."""
        points, size = len(GRID), columns + 1
        variance = np.zeros((points, size, size))
        variance[:, range(columns), range(columns)] = _DIFFUSE
        zeros = np.zeros(points)
        return cls(
            np.zeros((points, size)), variance, np.zeros((points, size)), zeros, zeros, zeros
        )

    def forgotten(self) -> Self:
        """The same without its levels, slope and day; what is known of the scatter stays."""
        start = Filter.of(self.mean.shape[1] - 1)
        return replace(self, mean=start.mean, variance=start.variance, day=None)

    def with_deviation(self, deviation: float) -> Self:
        """The same with another standard deviation; what is known of r, c and a stays.

        Itself where one of the two deviations is not known, or none.
        """
        if not (deviation > 0.0 and self.deviation > 0.0):
            return self
        return replace(self, squares=self.squares * (deviation / self.deviation) ** 2)

    @property
    def weights(self) -> Array:
        """Restricted likelihood of the points of the grid times `PRIOR`, adding up to 1, (G,)."""
        log = np.log(PRIOR) - 0.5 * (
            self.logs + self.count * np.log(np.maximum(self.squares, _LEAST))
        )
        weights = np.exp(log - log.max())
        return np.asarray(weights / weights.sum())

    @property
    def scatter(self) -> ScatterModel:
        """The means of r, c and a over the grid."""
        return ScatterModel(*(self.weights @ GRID).tolist())

    @property
    def deviation(self) -> float:
        """The mean of s^2 over the grid, as its root; nan before the first residual."""
        return float(np.sqrt(self.weights @ self.squares / self.count)) if self.count else np.nan


#: Rows of r, c and a, (G, 3). Where days have no effect there is nothing to remember.
GRID = np.array([
    (r, c, a) for r, c, a in product(DAY_SHARES, KNOWN_SHARES, MEMORIES) if r > 0 or a == 0
])  # fmt: skip
#: Before the first estimate, days with a memory are as likely as days without one, (G,).
PRIOR = np.where(GRID[:, 2] > 0, 1.0 / (len(MEMORIES) - 1), 1.0)


def step(
    state: Filter, value: float, row: Array, day: float, shares: Array, error: float
) -> tuple[Filter, float, float]:
    """The state after one more estimate, its standardised difference, and what a change adds to it.

    Args:
        state: Before it.
        value: The estimate.
        row: Its row of the regression, (p,).
        day: Its day, in usual gaps.
        shares: w at the points of the grid, (G,).
        error: Its standard error: no difference is standardised by less.

    Returns:
        The difference is nan where nothing before it can be compared with it. A level that has
        changed since the day began adds so much to it, as a share of what it adds to the first
        difference of the day: 1 of that one, and the less of those after it the more of the
        scatter is that of days, since they have the day's effect in common.
    """
    day_shares, memories = GRID[:, 0], GRID[:, 2]
    mean, variance = state.mean.copy(), state.variance.copy()
    kept = memories ** (day - state.day) if state.day is not None else np.zeros(len(GRID))
    mean[:, -1] *= kept
    variance[:, -1, :] *= kept[:, None]
    variance[:, :, -1] *= kept[:, None]
    variance[:, -1, -1] += day_shares * (1.0 - np.square(kept))
    h = np.append(row, 1.0)
    gain = variance @ h
    predicted = gain @ h + (1.0 - day_shares) * shares
    deviation, gain = np.sqrt(predicted), gain / np.sqrt(predicted)[:, None]
    response, first = state.response, state.first
    if day != state.day:
        response, first = np.zeros_like(mean), deviation
    residual, added = value - mean @ h, (1.0 - response @ h) / deviation
    mean += gain * (residual / deviation)[:, None]
    variance -= gain[:, :, None] * gain[:, None, :]
    response = response + gain * added[:, None]
    after = replace(state, mean=mean, variance=variance, response=response, first=first, day=day)
    if predicted.min() > _UNKNOWN:
        return after, np.nan, 0.0
    share = float(np.clip(state.weights @ (added * first), 0.0, 1.0))
    difference = _standardised(state, residual, predicted, error)
    after = replace(
        after,
        squares=state.squares + np.square(residual) / predicted,
        logs=state.logs + np.log(predicted),
        count=state.count + 1,
    )
    return after, difference, share


def _standardised(state: Filter, residual: Array, predicted: Array, error: float) -> float:
    """The normal quantile of the probability of a smaller residual, over the grid."""
    if state.count < _FEWEST:
        return np.nan
    spread = np.maximum(np.sqrt(predicted * state.squares / state.count), max(error, _LEAST))
    # The side on which the probability is small has all its digits.
    sign = -1.0 if np.median(residual) > 0 else 1.0
    probability = float(state.weights @ stdtr(state.count, sign * residual / spread))
    return float(np.clip(sign * ndtri(max(probability, _LEAST)), -_LARGEST, _LARGEST))


def centred(series: Series) -> Array:
    """The values less the first of their kind: what levels of nothing known begin at, (n,)."""
    _, first = np.unique(series.kinds, return_index=True)
    start = dict(zip(series.kinds[first].tolist(), series.values[first].tolist(), strict=True))
    return np.asarray(series.values - [start[kind] for kind in series.kinds.tolist()])


def shares_of(series: Series) -> Array:
    """The weight w of every estimate at every point of the grid, (n, G)."""
    by_known = {c: series.share(c) for c in KNOWN_SHARES}
    return np.array([by_known[c] for _, c, _ in GRID.tolist()]).T
