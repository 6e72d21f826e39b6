"""What each estimate differs by from those before it, standardised: independent differences.

An estimate of kind g, at covariate x, on day d, is m_g + b x + u_d + e, where u and e are normal:
u of variance r s^2, the same for all estimates of a day; e of variance (1 - r) s^2 w, where w is
1 - c + c times the square of its own standard error over a usual one. Nothing is known of m, b and
s before the first estimate.

For a given (r, c) the recursive residuals of that regression (Brown, Durbin and Evans 1975,
doi 10.1111/j.2517-6161.1975.tb01532.x) are independent; they come from a Kalman filter with diffuse
levels. Over the residuals before it, a residual is a Student's t, whose probability as a normal
quantile is standard normal: a self-starting chart (Hawkins 1987, doi 10.2307/2348827; Quesenberry
1991, doi 10.1080/00224065.1991.11979328), exact from the third estimate on, that needs no period
in which all is well. r and c are on a grid; the predictions of its points are weighed by the
restricted likelihood of all that was before.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Self

import numpy as np
from scipy.special import ndtri, stdtr

from ..space import Array
from .series import Series

#: Grid of r and c. It has more of large r: until days have shown otherwise they may differ.
DAY_SHARES = (0.0, 0.25, 0.5, 0.7, 0.8, 0.9, 0.95)
KNOWN_SHARES = (0.0, 0.5, 1.0)
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
        squares: Sum of the squares of the residuals so far, (G,).
        logs: Sum of the logarithms of their variances, (G,).
        count: How many residuals there are.
        day: The day of the last estimate.
    """

    mean: Array
    variance: Array
    squares: Array
    logs: Array
    count: int = 0
    day: int | None = None

    @classmethod
    def of(cls, columns: int) -> Self:
        """The state before the first estimate of a regression with so many columns."""
        points, size = len(GRID), columns + 1
        variance = np.zeros((points, size, size))
        variance[:, range(columns), range(columns)] = _DIFFUSE
        return cls(np.zeros((points, size)), variance, np.zeros(points), np.zeros(points))

    def forgotten(self) -> Self:
        """The same without its levels, slope and day; what is known of the scatter stays."""
        start = Filter.of(self.mean.shape[1] - 1)
        return replace(self, mean=start.mean, variance=start.variance, day=None)

    @property
    def weights(self) -> Array:
        """Restricted likelihood of the points of the grid, adding up to 1, (G,)."""
        log = -0.5 * (self.logs + self.count * np.log(np.maximum(self.squares, _LEAST)))
        weights = np.exp(log - log.max())
        return np.asarray(weights / weights.sum())


GRID = np.array(list(product(DAY_SHARES, KNOWN_SHARES)))


def step(
    state: Filter, value: float, row: Array, day: int, shares: Array, error: float
) -> tuple[Filter, float]:
    """The state after one more estimate, and its standardised difference.

    Args:
        state: Before it.
        value: The estimate.
        row: Its row of the regression, (p,).
        day: Its day.
        shares: w at the points of the grid, (G,).
        error: Its standard error: no difference is standardised by less.

    Returns:
        The difference is nan where nothing before it can be compared with it.
    """
    day_shares = GRID[:, 0]
    mean, variance = state.mean.copy(), state.variance.copy()
    if day != state.day:
        mean[:, -1] = 0.0
        variance[:, -1, :] = variance[:, :, -1] = 0.0
        variance[:, -1, -1] = day_shares
    h = np.append(row, 1.0)
    gain = variance @ h
    predicted = gain @ h + (1.0 - day_shares) * shares
    residual = value - mean @ h
    mean += gain * (residual / predicted)[:, None]
    variance -= gain[:, :, None] * gain[:, None, :] / predicted[:, None, None]
    after = replace(state, mean=mean, variance=variance, day=day)
    if predicted.min() > _UNKNOWN:
        return after, np.nan
    difference = _standardised(state, residual, predicted, error)
    after = replace(
        after,
        squares=state.squares + np.square(residual) / predicted,
        logs=state.logs + np.log(predicted),
        count=state.count + 1,
    )
    return after, difference


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
    """W of every estimate at every point of the grid, (n, G)."""
    by_known = {c: series.share(c) for c in KNOWN_SHARES}
    return np.array([by_known[c] for _, c in GRID.tolist()]).T
