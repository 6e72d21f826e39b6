"""How estimates of an axis may scatter while nothing changes, with no part of the package in it.

Each gives values of about unit deviation, their standard errors and their days, (n,) each.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

Array = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Draw = Callable[[np.random.Generator, int], tuple[Array, Array, Array]]


def _of_unknown_errors(values: Array) -> tuple[Array, Array, Array]:
    n = len(values)
    return values, np.zeros(n), np.arange(n, dtype=float)


def normal(draw: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
    """Independent and normal, a log a day: what the limits are computed for."""
    return _of_unknown_errors(draw.normal(size=count))


def heavy(draw: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
    """Student's t with three degrees of freedom: every eightieth is beyond four quartiles."""
    return _of_unknown_errors(draw.standard_t(3.0, size=count))


def skewed(draw: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
    """Log-normal, 30 % of the level."""
    return _of_unknown_errors(np.exp(0.3 * draw.normal(size=count)) / 0.3)


def outliers(draw: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
    """One estimate in fifty scatters five times as widely."""
    scale = np.where(draw.random(count) < 0.02, 5.0, 1.0)
    return _of_unknown_errors(scale * draw.normal(size=count))


def unequal(draw: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
    """As widely as their intervals say, which differ by a factor of up to nine."""
    errors = np.exp(draw.uniform(np.log(1 / 3), np.log(3.0), count))
    return errors * draw.normal(size=count), errors, np.arange(count, dtype=float)


def irregular(draw: np.random.Generator, count: int) -> tuple[Array, Array, Array]:
    """Days of one to four logs with an effect in common, one to ten days apart."""
    logs = draw.integers(1, 5, size=count)
    day = np.repeat(np.arange(count), logs)[:count]
    effects = draw.normal(0.0, 0.7, size=count)
    values = effects[day] + draw.normal(0.0, 0.7, size=count)
    dates = np.cumsum(draw.integers(1, 11, size=count)).astype(float)
    return values, np.zeros(count), dates[day]


def days_alike(
    draw: np.random.Generator, count: int, *, correlation: float
) -> tuple[Array, Array, Array]:
    """An autoregression of first order, with that correlation from day to day."""
    values = draw.normal(size=count)
    for k in range(1, count):
        values[k] = correlation * values[k - 1] + np.sqrt(1 - correlation**2) * values[k]
    return _of_unknown_errors(values)


SCATTER: dict[str, Draw] = {
    "normal": normal,
    "heavy tails": heavy,
    "log-normal": skewed,
    "outliers": outliers,
    "unequal intervals": unequal,
    "irregular dates": irregular,
    "days alike, 0.3": partial(days_alike, correlation=0.3),
    "days alike, 0.6": partial(days_alike, correlation=0.6),
    "days alike, 0.9": partial(days_alike, correlation=0.9),
}
