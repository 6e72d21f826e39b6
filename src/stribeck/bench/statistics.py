"""Statistics of a campaign's runs with intervals: success rates and curves.

The unit is the run. Every interval is of level LEVEL; those that are resampled draw runs, from a
generator seeded by the labels of what they describe, so the same records give the same numbers in
whatever order they come.

An unsuccessful run may have ended by its budget or by its method's own word ("count_max",
"exhausted", ...). Either way it counts with the evaluations that it spent, no more and no less.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr, stdtrit
from scipy.stats import binomtest

from ..errors import InputError
from ..space import Array, Rng
from .record import Job, Record

LEVEL = 0.95
#: Resamples behind an interval, and behind each point of a band that is only drawn.
RESAMPLES, BAND = 5000, 1000
#: Precisions above the minimum, as in BBOB: 51 from 1e2 to 1e-8, even on the log axis.
TARGETS: Array = np.logspace(2, -8, 51)
TARGETS.flags.writeable = False

#: Precisions for every problem, or by the problem's label; TARGETS for a label that is missing.
Targets: TypeAlias = Array | Mapping[str, Array]
#: The runs of each (problem, algorithm), by repeat.
Cells: TypeAlias = dict[tuple[str, str], list[Record]]


@dataclass(frozen=True)
class IntervalEstimate:
    """A number and its interval of level LEVEL; nan where there is nothing to say."""

    value: float
    low: float
    high: float


NOTHING = IntervalEstimate(math.nan, math.nan, math.nan)


@dataclass(frozen=True, eq=False)
class StepCurve:
    """A step curve: from `at[i]` on, until `at[i + 1]`, it has the height `share[i]`; 0 before.

    Args:
        at: Where it rises, rising, shape (k,).
        share: How high, in 0..1, shape (k,).
    """

    at: Array
    share: Array


# --- records ---------------------------------------------------------------------------------


def cells(records: Iterable[Record], jobs: Sequence[Job] = ()) -> Cells:
    """The records by (problem, algorithm), each cell in the order of its repeats.

    Args:
        records: In any order; a record that comes twice counts once.
        jobs: The campaign's jobs. Where they are given, they set the order of the cells, a cell
            without records is there and empty, and records of other jobs are left out. Where
            not, the cells are in the order of their labels.

    Raises:
        InputError: two different jobs claim to be one repeat of a cell.
    """
    records_by_key = {record.job.key: record for record in records}
    groups: Cells = {job.cell: [] for job in jobs}
    ordered = (
        [records_by_key[job.key] for job in jobs if job.key in records_by_key]
        if jobs
        else list(records_by_key.values())
    )
    for record in sorted(ordered, key=place):
        groups.setdefault(record.job.cell, []).append(record)
    for (problem, algorithm), runs in groups.items():
        if len({r.job.repeat for r in runs}) < len(runs):
            raise InputError(
                f"{algorithm} on {problem}: some repeat is there twice, with different settings; "
                "give the records of one campaign at a time"
            )
    return groups


def problems_of(cells: Iterable[tuple[str, str]]) -> list[str]:
    """The problems' labels, in the order of the cells."""
    return list(dict.fromkeys(problem for problem, _ in cells))


def algorithms_of(cells: Iterable[tuple[str, str]]) -> list[str]:
    """The methods' labels, in the order of the cells."""
    return list(dict.fromkeys(algorithm for _, algorithm in cells))


def compared(cells: Cells) -> tuple[list[str], list[str]]:
    """The methods that can be set side by side over problems, and the problems to do it on.

    They are those meant for every problem (for some, where none is meant for all) that have runs,
    on the problems that each of them has runs on so far.
    """
    started = {method for (_, method), runs in cells.items() if runs}
    some = [m for m in algorithms_of(cells) if m in started]
    problems = problems_of(cells)
    methods = [m for m in some if all((p, m) in cells for p in problems)] or some
    return methods, [p for p in problems if methods and all(cells.get((p, m)) for m in methods)]


def precision(record: Record) -> float:
    """The final cost above the least there is; the cost itself where that is not known."""
    return record.cost - (record.job.minimum or 0.0)


def hits(record: Record, precisions: ArrayLike) -> Array:
    """Evaluations until a run first met each precision, inf where it never did; shape (k,)."""
    excess = record.steps.costs - (record.job.minimum or 0.0)
    first = np.searchsorted(-excess, -np.asarray(precisions, dtype=float), side="left")
    return np.append(record.steps.evaluations.astype(float), np.inf)[first]


# --- success ----------------------------------------------------------------------------------


def wilson(successes: int, runs: int) -> IntervalEstimate:
    """A success rate with Wilson's score interval, right also for none and for all of them.

    Wilson 1927, doi 10.1080/01621459.1927.10502953; recommended by Brown, Cai and DasGupta 2001,
    doi 10.1214/ss/1009213286.
    """
    if not runs:
        return NOTHING
    ends = binomtest(successes, runs).proportion_ci(LEVEL, method="wilson")
    return IntervalEstimate(successes / runs, float(ends.low), float(ends.high))


def success_rate(records: Sequence[Record]) -> IntervalEstimate:
    """The share of runs that met their target; nothing where there was none to meet."""
    if any(r.job.target is None for r in records):
        return NOTHING
    return wilson(sum(r.reached for r in records), len(records))


def met(record: Record, precision: float | None = None) -> float:
    """Evaluations until a run met a precision, or its job's own target; inf where it did not."""
    if precision is not None:
        return float(hits(record, [precision])[0])
    at = record.steps.reached(record.job.target) if record.job.target is not None else None
    return math.inf if at is None else float(at)


# --- curves ----------------------------------------------------------------------------------


def ecdf(records: Iterable[Record], targets: Targets = TARGETS) -> StepCurve:
    """The share of (problem, target, repeat) triples that one method met within so much effort.

    The effort is evaluations per dimension. Every problem weighs the same, whatever its number
    of repeats. More and Wild 2009, doi 10.1137/080724083; Hansen et al. 2021,
    doi 10.1080/10556788.2020.1808977.

    Args:
        records: Runs of one method.
        targets: Precisions above the minimum (costs, where that is not known).
    """
    by = _by_problem(records)
    at, weight = [np.empty(0)], [np.empty(0)]
    for problem, runs in by.items():
        aims = _aims(targets, problem)
        at += [hits(r, aims) / len(r.x) for r in runs]
        weight += [np.full(len(aims), 1 / (len(by) * len(runs) * len(aims)))] * len(runs)
    x, w = np.concatenate(at), np.concatenate(weight)
    efforts, index = np.unique(x[np.isfinite(x)], return_inverse=True)
    rise = np.bincount(index, w[np.isfinite(x)], minlength=len(efforts))
    return StepCurve(efforts, np.minimum(np.cumsum(rise), 1.0))


def ecdf_band(records: Iterable[Record], grid: ArrayLike, targets: Targets = TARGETS) -> Array:
    """The interval about one method's `ecdf` at each point of a grid, drawn again as in `area`.

    Args:
        records: Runs of one method.
        grid: Evaluations per dimension, shape (k,).
        targets: Precisions above the minimum (costs, where that is not known).

    Returns:
        Its lower and upper end, shape (2, k); nan where every problem has one run only.
    """
    by, at = _by_problem(records), np.asarray(grid, dtype=float)
    shares = [
        np.array([
            np.searchsorted(np.sort(hits(r, aims) / len(r.x)), at, side="right") / len(aims)
            for r in runs
        ])
        for problem, runs in by.items()
        for aims in [_aims(targets, problem)]
    ]  # fmt: skip
    rng = labelled_rng("band", next(iter(by.values()))[0].job.algorithm, *by)
    drawn = np.mean([resamples(len(s), rng, BAND) @ s / len(s) for s in shares], axis=0)
    ends = _percents(*map(len, shares))
    return np.full((2, at.size), np.nan) if ends is None else np.quantile(drawn, ends, axis=0)


def limits_of(records: Iterable[Record]) -> dict[str, float]:
    """For each problem, evaluations per dimension that every run on it was allowed."""
    by = _by_problem(records)
    return {name: min(map(allowed, runs)) for name, runs in by.items()}


def allowed(record: Record) -> float:
    """Evaluations per dimension that a run might have spent."""
    return record.job.budget / len(record.x)


def area(
    records: Iterable[Record],
    targets: Targets = TARGETS,
    limits: Mapping[str, float] | None = None,
) -> IntervalEstimate:
    """The area under one method's `ecdf`: 1 if all is met at once, 0 if nothing ever is.

    The integral over log10(evaluations per dimension) from 0, which is one evaluation per
    dimension, to the problem's limit, divided by the length of that stretch; what was met
    earlier counts from its beginning. With one limit for all problems this is exactly the area
    under the curve. Each target met thus counts by the share of the stretch that was left: the
    mean of 1 - log10(evaluations/dim) / log10(limit) over the triples, 0 where never met.

    The interval resamples runs within each problem, with all the targets of a run together: the
    runs are independent, their targets are not, and the problems were chosen, not drawn.

    Args:
        records: Runs of one method.
        targets: Precisions above the minimum (costs, where that is not known).
        limits: Evaluations per dimension by problem: `limits_of` all that is compared.
    """
    by = _by_problem(records)
    limits = limits_of(r for runs in by.values() for r in runs) if limits is None else limits
    if not by or min(limits[problem] for problem in by) <= 1:
        return NOTHING
    gains = [
        np.array([_gain(r, _aims(targets, problem), limits[problem]) for r in runs])
        for problem, runs in by.items()
    ]
    algorithm = next(iter(by.values()))[0].job.algorithm
    rng = labelled_rng("area", algorithm, *by)
    drawn = np.mean([resamples(len(g), rng) @ g / len(g) for g in gains], axis=0)
    return percentile(float(np.mean([g.mean() for g in gains])), drawn, *map(len, gains))


def _gain(record: Record, aims: Array, limit: float) -> float:
    effort = np.maximum(hits(record, aims) / len(record.x), 1.0)
    return float(np.maximum(1.0 - np.log10(effort) / math.log10(limit), 0.0).mean())


def convergence(
    records: Sequence[Record],
    grid: ArrayLike,
    *,
    over: Literal["evaluations", "rounds"] = "evaluations",
    above_minimum: bool = False,
) -> Array:
    """Lower quartile, median and upper quartile of the best cost so far; shape (3, len(grid)).

    A run that has ended keeps its last value; before its first finite cost it has inf. At a jump
    the quantile is the mean of both sides (definition 2 of Hyndman and Fan 1996,
    doi 10.1080/00031305.1996.10473566), so it is inf, never nan, where it falls on such a run.

    Args:
        records: Runs of one cell, at least one.
        grid: Evaluations done, or rounds begun, at which to look.
        over: Which of them.
        above_minimum: Precision above the minimum in place of cost.
    """
    curves = np.array([_best_at(r, np.asarray(grid), over, above_minimum) for r in records])
    lower, upper = (
        np.quantile(sign * curves, q, axis=0, method="inverted_cdf")
        for sign, q in ((1, [0.25, 0.5, 0.75]), (-1, [0.75, 0.5, 0.25]))
    )
    middle: Array = lower / 2 - upper / 2
    return middle


def _best_at(record: Record, grid: Array, over: str, above_minimum: bool) -> Array:
    steps = record.steps
    at = steps.rounds if over == "rounds" else steps.evaluations
    costs = steps.costs - ((above_minimum and record.job.minimum) or 0.0)
    return np.append(costs, np.inf)[np.searchsorted(at, grid, side="right") - 1]


def ratios(times: ArrayLike) -> Array:
    """Each method's time as a multiple of the best on that problem; inf where it failed.

    Dolan and More 2002, doi 10.1007/s101070100263.

    Args:
        times: Such as ERT, shape (problems, methods), inf for a failure, nan for no runs. A
            problem that some method has not been run on is left out.
    """
    measured = np.asarray(times, dtype=float)
    measured = measured[~np.isnan(measured).any(axis=1)]
    best = measured.min(axis=1, keepdims=True, initial=np.inf)
    out: Array = np.full_like(measured, np.inf)
    np.divide(measured, best, out=out, where=np.isfinite(best))
    return out


def profile(times: ArrayLike) -> list[StepCurve]:
    """Performance profiles: the share of problems solved within so many times the best's time.

    Dolan and More 2002, doi 10.1007/s101070100263. A problem that nobody solved counts among the
    problems all the same.

    Args:
        times: As in `ratios`.

    Returns:
        A curve for each method over the ratio, from 1.
    """
    curves = []
    for mine in ratios(times).T:
        at, count = np.unique(mine[np.isfinite(mine)], return_counts=True)
        curves.append(StepCurve(at, np.cumsum(count) / max(len(mine), 1)))
    return curves


# --- what they share -------------------------------------------------------------------------


def place(record: Record) -> tuple[tuple[str, str], int]:
    """Where a record stands among the others: by cell, then by repeat."""
    return record.job.cell, record.job.repeat


def _by_problem(records: Iterable[Record]) -> dict[str, list[Record]]:
    by: dict[str, list[Record]] = {}
    for record in sorted(records, key=place):
        by.setdefault(record.job.problem, []).append(record)
    return by


def _aims(targets: Targets, problem: str) -> Array:
    return targets.get(problem, TARGETS) if isinstance(targets, Mapping) else targets


def labelled_rng(*labels: str) -> Rng:
    """A generator seeded by labels."""
    return np.random.default_rng([zlib.crc32(label.encode()) for label in labels])


def resamples(runs: int, rng: Rng, size: int = RESAMPLES) -> Array:
    """How often each run is drawn in each resample; shape (size, runs)."""
    return rng.multinomial(runs, np.full(runs, 1 / runs), size=size).astype(float)


def percentile(value: float, drawn: Array, *runs: int) -> IntervalEstimate:
    """The interval between percentiles of what was drawn; with one run there is none."""
    ends = _percents(*runs)
    if ends is None:
        return IntervalEstimate(value, math.nan, math.nan)
    low, high = np.quantile(drawn, ends, method="inverted_cdf")
    return IntervalEstimate(value, float(low), float(high))


def _percents(*runs: int) -> tuple[float, float] | None:
    """Which percentiles to take, moved outwards where runs are few.

    Percentiles alone are too narrow by sqrt(1 - 1/n) and know of no t: Hesterberg 2015, section
    4, doi 10.1080/00031305.2015.1089789.
    """
    n = min(runs)
    if n == 1:
        return None
    factor = math.sqrt(n / (n - 1)) * stdtrit(sum(runs) - len(runs), (1 + LEVEL) / 2)
    return float(ndtr(-factor)), float(ndtr(factor))
