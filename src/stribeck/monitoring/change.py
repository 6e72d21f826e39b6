"""By how much a quantity has changed, and since when: a step or a ramp, with effects of days.

Both are a column more in the regression of the estimates on kind and covariate, whose beginning is
the one with the least sum of squares. The interval of the size is that of the sums of squares over
all beginnings and sizes: it holds the sizes that from some beginning on leave no more than
1 + t^2 / dof times the least sum (Seber and Wild 2003, section 5.4), so it is as wide as the
beginning is uncertain.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import stdtrit

from ..space import Array
from .series import ScatterModel, Series

Shape = Literal["step", "ramp"]
#: Level of the interval, two-sided; share of the greatest below which a direction is none.
_TAIL, _RANK = 0.025, 1e-9


@dataclass(frozen=True)
class LevelChange:
    """A change of level.

    Args:
        shape: A step, or a ramp that goes on to the last estimate.
        at: Index of the first estimate after a step, of the last before a ramp.
        size: By how much, in the unit of the values; of a ramp by day.
        low: Lower end of its 95 % interval.
        high: Upper end.
        level: The level before it of the kind of that estimate, at its covariate.
        log_likelihood: Restricted, up to a constant of all changes among the same estimates.
    """

    shape: Shape
    at: int
    size: float
    low: float
    high: float
    level: float
    log_likelihood: float


def change(
    series: Series, start: int, end: int, scatter: ScatterModel, shape: Shape = "step"
) -> LevelChange | None:
    """The change among the estimates from `start` to before `end`; None where none can be told.

    Args:
        series: All estimates.
        start: First that is looked at.
        end: First that is not.
        scatter: What the variance of the estimates is made up of.
        shape: Of the change.
    """
    inside = slice(start, end)
    n, design = end - start, series.design[inside]
    columns = _columns(series.times[inside], shape)
    root = np.linalg.cholesky(series.covariance(scatter)[inside, inside])
    whitened = np.linalg.solve(root, np.column_stack([design, series.values[inside], columns]))
    fixed, rest = np.split(whitened, [design.shape[1]], axis=1)
    basis, singular, right = np.linalg.svd(fixed, full_matrices=False)
    known = singular > _RANK * singular.max(initial=0.0)
    basis, inverse = basis[:, known], right[known].T / singular[known]
    left = rest - basis @ (basis.T @ rest)
    y, left = left[:, 0], left[:, 1:]
    dof = n - basis.shape[1] - 2  # a size and a beginning
    power = np.square(left).sum(axis=0)
    seen = np.flatnonzero(power > _RANK * np.square(rest[:, 1:]).sum(axis=0))
    if dof < 1 or not len(seen):
        return None
    power, along = power[seen], left[:, seen].T @ y
    sizes, squares = along / power, np.maximum(float(y @ y) - np.square(along) / power, 0.0)
    best = int(np.argmin(squares))
    limit = squares[best] * (1.0 + float(stdtrit(dof, 1.0 - _TAIL)) ** 2 / dof)
    within = squares <= limit
    half = np.sqrt((limit - squares[within]) / power[within])
    low, high = (sizes[within] - half).min(), (sizes[within] + half).max()
    at, size = int(seen[best]), float(sizes[best])
    levels = inverse @ (basis.T @ (rest[:, 0] - size * rest[:, 1 + at]))
    log_likelihood = -0.5 * (dof + 1) * float(np.log(max(squares[best], 1e-300)))
    return LevelChange(
        shape, start + at, size, float(low), float(high), float(design[at] @ levels),
        log_likelihood,
    )  # fmt: skip


def _columns(times: Array, shape: Shape) -> Array:
    """What a change of size 1 that begins at each of the estimates adds to them, (n, n)."""
    if shape == "step":
        return np.tri(len(times))
    return np.maximum(0.0, times[:, None] - times)
