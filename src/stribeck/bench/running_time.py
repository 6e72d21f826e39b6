"""The expected running time: what the runs show of it, and the tail that they may not show.

It is the time that restarting a method until it succeeds takes on average: evaluations spent over
successes. Two intervals of it are joined. A bootstrap of the runs assumes nothing about the times,
but knows of none that is longer than the longest run: with heavy tails and few runs its upper end
is too low. `likely_times` knows of longer ones, up to the budget at which a run is ended.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..space import Array, Rng
from .record import Record
from .statistics import (
    LEVEL,
    NOTHING,
    IntervalEstimate,
    labelled_rng,
    met,
    percentile,
    place,
    resamples,
    wilson,
)
from .time_tails import FEWEST, RunTimes, likely_times

#: Logarithm of a number of evaluations that no run ever spends: an end beyond it is none.
_LONGEST = 70.0


def ert(records: Sequence[Record], precision: float | None = None) -> IntervalEstimate:
    """The expected running time of a cell, in evaluations.

    All evaluations that the runs spent until they met the target, or until they ended without
    it, divided by the number of runs that met it: what restarting the method until it succeeds
    costs on average. Auger and Hansen 2005, doi 10.1109/CEC.2005.1554903; Hansen et al. 2021,
    doi 10.1080/10556788.2020.1808977.

    The interval is that of `interval_ends`. How often it holds the truth is measured in
    `benchmarks/ert_coverage.py`.

    No run met the target: the time is inf, and the lower end is the time at the upper end of
    Wilson's interval for the success rate.

    Args:
        records: Runs of one cell.
        precision: Target, above the minimum; None for each job's own.
    """
    if not records or (precision is None and any(r.job.target is None for r in records)):
        return NOTHING
    runs = sorted(records, key=place)
    at = np.array([met(r, precision) for r in runs])
    hit = np.isfinite(at)
    spent = np.where(hit, at, [r.evaluations for r in runs])
    if not hit.any():
        rate = wilson(0, len(runs)).high
        return IntervalEstimate(math.inf, float(spent.mean()) * (1 - rate) / rate, math.inf)
    value = float(spent.sum() / hit.sum())
    if len(runs) == 1:
        return IntervalEstimate(value, math.nan, math.nan)
    cut = ~hit & np.array([r.evaluations >= r.job.budget for r in runs])
    cell = RunTimes(spent, hit, cut, float(max(r.job.budget for r in runs)))
    rng = labelled_rng("ert", *runs[0].job.cell)
    return IntervalEstimate(value, *interval_ends(cell, resamples(len(runs), rng), rng))


def interval_ends(runs: RunTimes, drawn: Array, rng: Rng) -> tuple[float, float]:
    """The interval of an expected running time, of level LEVEL or more.

    Its ends are those of the bootstrap; the upper one is moved out to the upper end of
    `likely_times` at LEVEL, where that is higher. A resample without success has an infinite time
    and counts as such, so the upper end is inf where successes are few.

    Args:
        runs: At least two, and one success.
        drawn: As for `percentile_ends`.
        rng: Of what is likely.
    """
    low, high = studentised_ends(drawn, runs.spent, runs.hit.astype(float))
    if runs.hit.sum() < FEWEST or np.ptp(runs.spent[runs.hit]) == 0.0:
        return low, high
    return low, max(high, float(np.quantile(likely_times(runs, rng), LEVEL)))


def percentile_ends(drawn: Array, spent: Array, hit: Array) -> tuple[float, float]:
    """The percentile interval of an expected running time.

    Args:
        drawn: How often each run is drawn in each resample, (resamples, runs).
        spent: Evaluations of each run, (runs,).
        hit: 1 for a run that met the target, else 0.
    """
    with np.errstate(divide="ignore"):
        times = drawn @ spent / (drawn @ hit)
    interval = percentile(math.nan, times, len(spent))
    return interval.low, interval.high


def studentised_ends(drawn: Array, spent: Array, hit: Array) -> tuple[float, float]:
    """The bootstrap-t interval of an expected running time, by its logarithm; as `percentile_ends`.

    Each resample's deviation counts in standard errors of its own, so that the long tail of the
    times shows in the upper end. It is joined with the percentile interval, which knows that
    resamples without success take for ever.
    """
    n, total, successes = len(spent), drawn @ spent, drawn @ hit
    able = successes > 0
    logs = np.log(total[able] / successes[able])
    error = _log_error(drawn[able], spent, hit)
    own = float(_log_error(np.ones((1, n)), spent, hit)[0])
    centre = float(np.log(spent.sum() / hit.sum()))
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.nan_to_num((logs - centre) / error, nan=0.0)
    low, high = percentile_ends(drawn, spent, hit)
    least, most = np.quantile(t, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    longest = centre - float(least) * own
    upper = math.exp(longest) if longest < _LONGEST else math.inf
    return min(low, math.exp(centre - float(most) * own)), max(high, upper)


def _log_error(drawn: Array, spent: Array, hit: Array) -> Array:
    """Standard errors of the logarithm of the expected running time, (resamples,)."""
    n = len(spent)
    share = spent[None] / (drawn @ spent)[:, None] - hit[None] / (drawn @ hit)[:, None]
    error: Array = np.sqrt((drawn * share**2).sum(axis=1) * n / (n - 1))
    return error
