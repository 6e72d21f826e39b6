"""What an expected running time may be, by families of distributions of the times to success.

Five families are locations and scales of the logarithm of the time. With the right Haar prior, flat
in the location and in the logarithm of the scale, families can be weighed against each other by the
same runs: Berger, Pericchi and Varshavsky 1998, *Bayes factors and marginal distributions in
invariant situations*, Sankhya A 60. A run that was ended by its budget was going to take longer.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr, ndtri

from ..space import Array, Rng

Bools = NDArray[np.bool_]

#: Draws of a time; successes that it takes.
DRAWS, FEWEST = 2000, 3
#: Points of the grid of locations and scales; the scales at its ends, in standard deviations of
#: the logarithms.
_LOCATIONS, _SCALES, _RATIOS = 64, 32, (0.11, 5.0)
#: Locations reach (1 + _REACH / sqrt(runs)) standard deviations to both sides of the mean.
_REACH = 8.0
#: Log odds at which a distribution's quantiles are taken, to integrate over it.
_ODDS: Array = np.linspace(-14.0, 42.0, 225)


@dataclass(frozen=True, eq=False)
class RunTimes:
    """The runs of a cell.

    Args:
        spent: Evaluations of each, until success or until it ended, (n,).
        hit: Whether it met the target.
        cut: Whether its budget ended it before.
        budget: Evaluations at which a run is ended.
    """

    spent: Array
    hit: Bools
    cut: Bools
    budget: float


class Family(NamedTuple):
    """Distributions of times, by z = (log T - location) / scale.

    Attributes:
        density: Logarithm of the density of z.
        survival: Logarithm of the probability of a greater z.
        quantile: z, by the log odds of a smaller one.
    """

    density: Callable[[Array], Array]
    survival: Callable[[Array], Array]
    quantile: Callable[[Array], Array]


def _exp(z: Array) -> Array:
    raised: Array = np.exp(np.minimum(z, 700.0))
    return raised


WEIBULL = Family(
    lambda z: z - _exp(z),
    lambda z: -_exp(z),
    lambda odds: np.log(np.logaddexp(0.0, odds)),
)
LOG_NORMAL = Family(
    lambda z: -0.5 * z**2 - 0.5 * math.log(2.0 * math.pi),
    lambda z: log_ndtr(-z),
    lambda odds: -ndtri(1.0 / (1.0 + np.exp(odds))),
)
LOG_LOGISTIC = Family(
    lambda z: -z - 2.0 * np.logaddexp(0.0, -z),
    lambda z: -np.logaddexp(0.0, z),
    lambda odds: odds,
)
FRECHET = Family(
    lambda z: -z - _exp(-z),
    lambda z: np.log(-np.expm1(-_exp(-z))),
    lambda odds: -np.log(np.logaddexp(0.0, -odds)),
)
PARETO = Family(
    lambda z: np.where(z < 0.0, -np.inf, -z),
    lambda z: -np.maximum(z, 0.0),
    lambda odds: np.logaddexp(0.0, odds),
)
#: Those whose posterior is taken on a grid, and all.
SMOOTH = (WEIBULL, LOG_NORMAL, LOG_LOGISTIC, FRECHET)
FAMILIES = (*SMOOTH, PARETO)


def likely_times(runs: RunTimes, rng: Rng) -> Array:
    """Draws of the expected running time from its posterior, (DRAWS,).

    A run succeeds at a time of one of the families if it gets there before its budget, and if it
    does not end for another reason, the chance of which has Jeffreys' prior.

    Args:
        runs: At least FEWEST successes, not all at one time.
        rng: Of the draws.
    """
    location, scale, family = _posterior(runs, rng)
    spent, share = np.empty(DRAWS), np.empty(DRAWS)
    for k, kind in enumerate(FAMILIES):
        mine = family == k
        spent[mine], share[mine] = until_budget(runs.budget, kind, location[mine], scale[mine])
    other = ~runs.hit & ~runs.cut
    if not other.any():
        return spent / share
    count = int(other.sum())
    ends = rng.beta(count + 0.5, len(other) - count + 0.5, DRAWS)
    lost = ends / (1.0 - ends) * float(runs.spent[other].mean())
    times: Array = (spent + lost) / share
    return times


def _posterior(runs: RunTimes, rng: Rng) -> tuple[Array, Array, NDArray[np.int64]]:
    """Draws of location, scale and number of the family, (DRAWS,) each."""
    logs, limit, cut = np.log(runs.spent[runs.hit]), math.log(runs.budget), int(runs.cut.sum())
    posteriors = [_on_grid(kind, logs, limit, cut, rng) for kind in SMOOTH]
    posteriors.append(_of_pareto(logs, limit, cut, rng))
    weights = np.exp([p[0] - max(p[0] for p in posteriors) for p in posteriors])
    family = rng.choice(len(FAMILIES), DRAWS, p=weights / weights.sum())
    locations, scales = (np.array([p[k] for p in posteriors]) for k in (1, 2))
    each = np.arange(DRAWS)
    return locations[family, each], scales[family, each], family


def _on_grid(
    kind: Family, logs: Array, limit: float, cut: int, rng: Rng
) -> tuple[float, Array, Array]:
    """The logarithm of a family's evidence, and draws of its locations and scales.

    Args:
        kind: The family.
        logs: Logarithms of the times to success, (m,).
        limit: Logarithm of the budget.
        cut: How many runs the budget ended.
        rng: Of the draws.
    """
    mean, deviation = float(logs.mean()), float(logs.std(ddof=1))
    reach = 1.0 + _REACH / math.sqrt(len(logs))
    axes = (np.linspace(-reach, reach, _LOCATIONS), np.geomspace(*_RATIOS, _SCALES))
    cell = deviation * (axes[0][1] - axes[0][0]) * math.log(axes[1][1] / axes[1][0])
    location, scale = (axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    location, scale = mean + deviation * location, deviation * scale
    z = (logs - location[:, None]) / scale[:, None]
    weights = kind.density(z).sum(axis=1) - len(logs) * np.log(scale)
    if cut:
        with np.errstate(divide="ignore"):
            weights = weights + cut * kind.survival((limit - location) / scale)
    most = float(weights.max())
    shares = np.exp(weights - most)
    at = rng.choice(len(shares), DRAWS, p=shares / shares.sum())
    return most + math.log(cell * float(shares.sum())), location[at], scale[at]


def _of_pareto(logs: Array, limit: float, cut: int, rng: Rng) -> tuple[float, Array, Array]:
    """As `_on_grid`, in closed form: the location is the least time there may be."""
    m, least = len(logs), float(logs.min())
    above = float((logs - least).sum()) + cut * (limit - least)
    scale = above / rng.gamma(m - 1.0, size=DRAWS)
    location = least - scale / (m + cut) * rng.exponential(size=DRAWS)
    evidence = math.lgamma(m - 1.0) - math.log(m + cut) - (m - 1.0) * math.log(above)
    return evidence, location, scale


def until_budget(budget: float, kind: Family, location: Array, scale: Array) -> tuple[Array, Array]:
    """Mean evaluations of runs that end at the budget, and the share that ends before."""
    z, chance = kind.quantile(_ODDS), 0.25 / np.cosh(_ODDS / 2.0) ** 2 * (_ODDS[1] - _ODDS[0])
    logs = location[:, None] + scale[:, None] * z
    mean: Array = np.exp(np.minimum(logs, math.log(budget))) @ chance
    return mean, -np.expm1(kind.survival((math.log(budget) - location) / scale))
