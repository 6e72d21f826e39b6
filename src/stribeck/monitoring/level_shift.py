"""By how much a quantity has changed, and when: a step in a regression with effects of days.

The step's time is the one with the least sum of squares. The interval of its size is that of the
sums of squares over all times and sizes: it holds the sizes that at some time leave no more than
1 + t^2 / dof times the least sum (Seber and Wild 2003, section 5.4), so it is as wide as the time
is uncertain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from ..space import Array
from .series import Series

#: Level of the interval, two-sided; share of the greatest below which a direction is none.
_TAIL, _RANK = 0.025, 1e-9


@dataclass(frozen=True)
class LevelShift:
    """A change of level.

    Args:
        at: Index of the first estimate after it.
        size: By how much, in the unit of the values.
        low: Lower end of its 95 % interval.
        high: Upper end.
        level: The level before it, at the covariate's mean, of the kind that changed first.
    """

    at: int
    size: float
    low: float
    high: float
    level: float


def level_shift(
    series: Series, start: int, end: int, day_share: float, known: float
) -> LevelShift | None:
    """The step among the estimates from `start` to before `end`; None where none can be told.

    Args:
        series: All estimates.
        start: First that is looked at.
        end: First that is not.
        day_share: r of `innovations`.
        known: c.
    """
    inside = slice(start, end)
    n = end - start
    root = np.linalg.cholesky(_covariance(series, inside, day_share, known))
    whitened = np.linalg.solve(
        root, np.column_stack([series.design[inside], series.values[inside]])
    )
    basis, singular, _ = np.linalg.svd(whitened[:, :-1], full_matrices=False)
    basis = basis[:, singular > _RANK * singular.max(initial=0.0)]
    y = whitened[:, -1] - basis @ (basis.T @ whitened[:, -1])
    dof = n - basis.shape[1] - 2  # a size and a time
    steps = np.linalg.solve(root, np.tri(n).astype(float))  # column k: 1 from k on
    steps -= basis @ (basis.T @ steps)
    power = np.square(steps).sum(axis=0)
    known_times = np.flatnonzero(power > _RANK * power.max(initial=0.0))
    known_times = known_times[known_times > 0]
    if dof < 1 or not len(known_times):
        return None
    power, along = power[known_times], steps[:, known_times].T @ y
    sizes, rest = along / power, float(y @ y) - np.square(along) / power
    best = int(np.argmin(rest))
    limit = rest[best] * (1.0 + float(stdtrit(dof, 1.0 - _TAIL)) ** 2 / dof)
    inside_limit = rest <= limit
    half = np.sqrt((limit - rest[inside_limit]) / power[inside_limit])
    low, high = (sizes[inside_limit] - half).min(), (sizes[inside_limit] + half).max()
    at = start + int(known_times[best])
    return LevelShift(at, float(sizes[best]), float(low), float(high), _level(series, start, at))


def _level(series: Series, start: int, at: int) -> float:
    """Mean of the estimates before a step, of the kind of the first after it if there are any."""
    before = slice(start, at)
    alike = series.values[before][series.kinds[before] == series.kinds[at]]
    return float(np.mean(alike if len(alike) else series.values[before]))


def _covariance(series: Series, inside: slice, day_share: float, known: float) -> Array:
    days = series.days[inside]
    same = (days[:, None] == days).astype(float)
    return np.asarray(day_share * same + np.diag((1.0 - day_share) * series.share(known)[inside]))
