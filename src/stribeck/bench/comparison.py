"""Comparison of two methods: rank tests, their correction for a family, the size of the effect."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import ndtri
from scipy.stats import PermutationMethod, mannwhitneyu, rankdata, wilcoxon

from ..space import Array
from .record import Record
from .statistics import LEVEL, NOTHING, IntervalEstimate, met, place, precision

#: Up to so many, a rank test is exact: pairs of runs, and ways to deal runs to two methods.
PAIRS, ARRANGEMENTS = 100, 20_000


@dataclass(frozen=True)
class Comparison:
    """One method against another on one problem.

    Args:
        p: Two-sided p-value that neither tends to be better; nan without runs of both.
        paired: Whether run was set against run on the same instance (signed ranks), or all of
            the first against all of the second (rank sum).
        runs: How many of the first's and of the second's runs were used.
        effect: A12, the chance that a run of the first is better than one of the second.
    """

    p: float
    paired: bool
    runs: tuple[int, int]
    effect: IntervalEstimate


def scores(first: Sequence[Record], second: Sequence[Record]) -> tuple[Array, Array]:
    """The ranks of two methods' runs among each other, from 1, the best; ties share the mean.

    Any success is better than any failure; successes rank by evaluations to their target,
    failures by the precision they ended with.
    """
    keys = [_performance(r) for r in (*first, *second)]
    order = {key: k for k, key in enumerate(sorted(set(keys)))}
    ranks = rankdata([order[key] for key in keys])
    return ranks[: len(first)], ranks[len(first) :]


def _performance(record: Record) -> tuple[bool, float]:
    effort = met(record)
    return (True, precision(record)) if math.isinf(effort) else (False, effort)


def compare(first: Sequence[Record], second: Sequence[Record]) -> Comparison:
    """Test whether one method tends to do better than another on a problem.

    Where the problem's instance changes from repeat to repeat and both methods met the same one,
    the runs of a repeat are a pair: how hard the instance is then drops out. The pairs' rank
    differences are tested by signed ranks with zeros as Pratt has them (Kornbrot 1990,
    doi 10.1111/j.2044-8317.1990.tb00939.x: the scores are ordinal, so only differences of their
    ranks can be compared in size; Pratt 1959, doi 10.1080/01621459.1959.10501526). Repeats that
    only one of them has are left out.

    Where all repeats are on one and the same function, runs share nothing but their number
    (every job has a random stream of its own), and to pair them would be to pair by chance: then
    it is the rank sum test (Mann and Whitney 1947, doi 10.1214/aoms/1177730491).

    The interval of A12 takes the runs as independent; for pairs it errs to the wide side.

    Args:
        first: Runs of a method on a problem.
        second: Runs of another on the same problem.
    """
    pairs = _pairs(first, second)
    if pairs:
        first, second = [a for a, _ in pairs], [b for _, b in pairs]
    runs = len(first), len(second)
    if not all(runs):
        return Comparison(math.nan, False, runs, NOTHING)
    x, y = scores(first, second)
    p = signed_rank(x - y) if pairs else rank_sum(x, y)
    return Comparison(p, bool(pairs), runs, a12(x, y))


def _pairs(first: Sequence[Record], second: Sequence[Record]) -> list[tuple[Record, Record]]:
    """The runs of two methods on the same instance, where the instance changes; else none."""
    theirs = {r.job.repeat: r for r in second}
    mine = sorted((r for r in first if r.job.repeat in theirs), key=place)
    pairs = [(r, theirs[r.job.repeat]) for r in mine]
    instances = {json.dumps(dict(r.job.surface), sort_keys=True) for r in mine}
    paired = all(a.job.surface == b.job.surface for a, b in pairs)
    return pairs if paired and len(instances) > 1 else []


def compare_over_problems(effects: Sequence[float]) -> float:
    """Test one method against another over problems, each problem one pair: the p-value.

    Signed ranks (zeros as Pratt has them) of A12 - 1/2, an effect that has the same meaning and
    size on every problem. With k problems p cannot fall below 2^(1-k). After Demsar 2006, J.
    Machine Learning Research 7:1-30.

    Args:
        effects: A12 on each problem; nan where it was not run.
    """
    finite = np.array([e for e in effects if not math.isnan(e)])
    return signed_rank(np.round(finite - 0.5, 12))  # equal effects stay equal, whatever their sign


def signed_rank(differences: ArrayLike) -> float:
    """Wilcoxon's signed rank test, zeros as Pratt has them: the two-sided p-value.

    Exact for up to PAIRS pairs, ties and zeros included, of which scipy counts the arrangements
    one by one; beyond, scipy's normal approximation.
    """
    d = np.asarray(differences, dtype=float)
    if not d.any():
        return 1.0 if d.size else math.nan
    if d.size > PAIRS:
        return float(wilcoxon(d, zero_method="pratt", axis=None).pvalue)
    doubled = np.rint(2 * rankdata(np.abs(d))).astype(int)  # whole numbers, with ties too
    chance = np.ones(1)  # of each sum of the positive ranks, all signs being as likely
    for rank in doubled[d != 0]:
        chance = (np.pad(chance, (0, rank)) + np.pad(chance, (rank, 0))) / 2
    away = np.abs(2 * np.arange(len(chance)) - (len(chance) - 1))
    return min(float(chance[away >= away[doubled[d > 0].sum()]].sum()), 1.0)


def rank_sum(first: ArrayLike, second: ArrayLike) -> float:
    """The Mann-Whitney rank sum test: the two-sided p-value.

    Where the arrangements are few they are all counted, which is exact with ties too; else the
    normal approximation, corrected for ties. With a single run there is nothing to test: nan.
    """
    x, y = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    if min(x.size, y.size) < 2:  # noqa: PLR2004 - a single run is no sample
        return math.nan
    if np.ptp(np.concatenate([x, y])) == 0:
        return 1.0
    if math.comb(x.size + y.size, x.size) <= ARRANGEMENTS:
        permutations = PermutationMethod(n_resamples=ARRANGEMENTS)
        return float(mannwhitneyu(x, y, method=permutations).pvalue)
    return float(mannwhitneyu(x, y, method="asymptotic").pvalue)


def holm(p: ArrayLike) -> Array:
    """p-values of a family of tests, adjusted so that any false alarm at all is as rare.

    The k-th least of m is multiplied by m - k + 1, none falls below one before it. Holm 1979,
    Scand. J. Statistics 6:65-70. A test that was not made (nan) does not count.
    """
    raw = np.asarray(p, dtype=float)
    tested = np.flatnonzero(~np.isnan(raw))
    order = tested[np.argsort(raw[tested], kind="stable")]
    adjusted = np.full(raw.shape, np.nan)
    steps = raw[order] * np.arange(len(order), 0, -1)
    adjusted[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return adjusted


def a12(first: ArrayLike, second: ArrayLike) -> IntervalEstimate:
    """The chance that a score of the first is better (less) than one of the second, ties half.

    Vargha and Delaney 2000, doi 10.3102/10769986025002101. The interval is method 5 of Newcombe
    2006, doi 10.1002/sim.2324: a score interval, which unlike the bootstrap keeps its width
    where one is always better.

    Args:
        first: Scores of one method's runs, shape (m,).
        second: Scores of the other's, shape (n,).
    """
    x, y = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    if not (x.size and y.size):
        return NOTHING
    won = float(mannwhitneyu(y, x, method="asymptotic").statistic) / (x.size * y.size)
    return IntervalEstimate(won, *_newcombe(won, x.size, y.size))


def _newcombe(won: float, m: int, n: int) -> tuple[float, float]:
    z2, half = float(ndtri((1 + LEVEL) / 2)) ** 2, (m + n) / 2 - 1

    def excess(theta: float) -> float:
        spread = 1 + half * ((1 - theta) / (2 - theta) + theta / (1 + theta))
        return (won - theta) ** 2 - z2 * theta * (1 - theta) * spread / (m * n)

    inside = min(max(won, 1e-12), 1 - 1e-12)  # `excess` is zero at won = 0 and 1 themselves
    low = brentq(excess, 0.0, inside) if won > 0 else 0.0
    high = brentq(excess, inside, 1.0) if won < 1 else 1.0
    return float(low), float(high)
