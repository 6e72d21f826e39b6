"""Random effects: a quantity that differs from unit to unit (slip, log), each known with an error.

The value of unit i is m + e_i with e_i of standard deviation s, and it is known with an error
sigma_i. The spread is the s for which sum_i (y_i - m)^2 / (s^2 + sigma_i^2) is what it is on
average, its degrees of freedom (Paule and Mandel 1982, doi 10.6028/jres.087.022); its interval has
those s for which the sum lies between the 2.5 and the 97.5 % point of chi-squared (Viechtbauer
2007, doi 10.1002/sim.2514), which is exact for few units. The interval of the mean is Student's
with the variance of Hartung and Knapp (2001, doi 10.1002/sim.791), each unit an observation.

Whether units differ at all is asked by the same sum with s = 0, Cochran's Q (1954, doi
10.2307/3001666). Errors that are estimated themselves make it larger than chi-squared, so it is
compared with F as by Welch (1951, doi 10.1093/biomet/38.3-4.330).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri, fdtrc, stdtrit

from ..space import Array

#: Level of intervals, two-sided.
TAIL = 0.025


@dataclass(frozen=True)
class RandomEffects:
    """How a quantity differs from unit to unit.

    Args:
        mean: Its mean over the units, each weighed by how well it is known and how they differ.
        low: Lower end of the 95 % interval of the mean.
        high: Upper end.
        sd: Standard deviation from unit to unit, the errors taken out.
        sd_low: Lower end of its 95 % interval.
        sd_high: Upper end.
        units: How many there are.
        chance: Probability that units that do not differ show so great differences.
    """

    mean: float
    low: float
    high: float
    sd: float
    sd_low: float
    sd_high: float
    units: int
    chance: float


def random_effects(values: Array, errors: Array, dofs: Array) -> RandomEffects:
    """How a quantity differs over two units or more.

    Args:
        values: Of the units, (n,).
        errors: Standard errors of these, above zero, (n,).
        dofs: Degrees of freedom of the errors, (n,).
    """
    n = len(values)
    sd, low, high = spread_of(values, errors, n - 1.0)
    weights = 1.0 / (sd**2 + np.square(errors))
    mean = float(weights @ values / weights.sum())
    variance = float(weights @ np.square(values - mean)) / ((n - 1) * float(weights.sum()))
    half = float(stdtrit(n - 1, 1.0 - TAIL)) * float(np.sqrt(variance))
    chance = _chance(values, errors, dofs)
    return RandomEffects(mean, mean - half, mean + half, sd, low, high, n, chance)


def _chance(values: Array, errors: Array, dofs: Array) -> float:
    """The probability of Cochran's Q, its errors with so many degrees of freedom, after Welch."""
    n, weights = len(values), 1.0 / np.square(errors)
    total = float(weights.sum())
    Q = float(weights @ np.square(values - weights @ values / total))
    lack = float(np.sum(np.square(1.0 - weights / total) / dofs)) / (n * n - 1.0)
    F = Q / (n - 1) / (1.0 + 2.0 * (n - 2) * lack)
    return float(fdtrc(n - 1, 1.0 / (3.0 * lack), F))


def spread_of(
    values: Array, errors: Array, dof: float, about: float | None = None
) -> tuple[float, float, float]:
    """Standard deviation of what lies behind values with errors, and its interval.

    Args:
        values: (n,).
        errors: Their standard errors, (n,).
        dof: What the sum of their squares is on average, each over its variance.
        about: Their mean where it is known; by default it is estimated with each spread.
    """
    targets = (dof, float(chdtri(dof, TAIL)), float(chdtri(dof, 1.0 - TAIL)))
    sd, low, high = (_solved(values, errors, target, about) for target in targets)
    return sd, low, high


def _solved(values: Array, errors: Array, target: float, about: float | None) -> float:
    """The s at which the sum of squares over variances is the target; 0 if it nowhere is."""

    def excess(s: float) -> float:
        variances = s * s + np.square(errors)
        mean = np.sum(values / variances) / np.sum(1.0 / variances) if about is None else about
        return float(np.sum(np.square(values - mean) / variances)) - target

    middle = float(np.mean(values)) if about is None else about
    most = float(np.sqrt(np.sum(np.square(values - middle)) / target))
    least = 1e-9 * most
    if not most > 0 or excess(least) <= 0:
        return 0.0
    from scipy.optimize import brentq  # noqa: PLC0415 - slow to import

    return float(brentq(excess, least, most, xtol=1e-9 * most))
