"""What a covariate does to a quantity, and whether it can be told from a change in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from ..space import Array
from .series import ScatterModel, Series

_TAIL = 0.025


@dataclass(frozen=True)
class CovariateEffect:
    """The dependence on the covariate that is taken out of a series.

    Args:
        slope: In the values' unit by the covariate's; nan where it cannot be told.
        low: Lower end of its 95 % interval.
        high: Upper end.
        shared: Share of the covariate's variance within kinds that goes with time, or with the one
            step that it is most like: a change of the quantity of that shape is taken for what the
            covariate does.
    """

    slope: float
    low: float
    high: float
    shared: float


def covariate_effect(
    series: Series, covariate: Array, scatter: ScatterModel, steps: Sequence[int]
) -> CovariateEffect:
    """The effect of the covariate, by generalised least squares on all estimates.

    Args:
        series: All estimates.
        covariate: That of the series, (n,).
        scatter: What the variance of the estimates is made up of.
        steps: Indices of estimates from which on the level is another one.
    """
    n = len(series)
    since = np.tri(n)[:, [k for k in steps if 0 < k < n]]
    levels = np.column_stack([series.design[:, :-1], since])
    root = np.linalg.cholesky(series.covariance(scatter))
    y, x, *fixed = np.linalg.solve(root, np.column_stack([series.values, covariate, levels])).T
    y, x = (_without(column, np.array(fixed).T) for column in (y, x))
    power, dof = float(x @ x), n - np.linalg.matrix_rank(levels) - 1
    shared = _shared(covariate, series)
    if dof < 1 or not power > 1e-12 * float(covariate @ covariate):
        return CovariateEffect(np.nan, np.nan, np.nan, shared)
    slope = float(x @ y) / power
    rest = y - slope * x
    half = float(stdtrit(dof, 1.0 - _TAIL)) * float(np.sqrt(rest @ rest / dof / power))
    return CovariateEffect(slope, slope - half, slope + half, shared)


def _shared(covariate: Array, series: Series) -> float:
    """The greatest square of a correlation within kinds, with time or with a step."""
    kinds = series.design[:, :-1]
    x = _without(covariate, kinds)
    candidates = _without(np.column_stack([series.times, np.tri(len(x))[:, 1:]]), kinds)
    squares = np.square(candidates).sum(axis=0)
    seen = squares > 1e-9 * len(x)
    if not seen.any() or not x.any():
        return 0.0
    along = np.square(candidates[:, seen].T @ x) / squares[seen]
    return float(min(1.0, along.max() / float(x @ x)))


def _without(columns: Array, levels: Array) -> Array:
    """What columns have that levels have not."""
    fitted: Array = levels @ np.linalg.lstsq(levels, columns, rcond=None)[0]
    return np.asarray(columns - fitted)
