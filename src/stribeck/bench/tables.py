"""A campaign's tables: who succeeds, at what price, and who is better than whom."""

from __future__ import annotations

import itertools
import math
import operator
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from statistics import median_low

import numpy as np

from ..errors import InputError
from ..report import DASH, Cell, Table, grouped
from ..space import Array
from .comparison import Comparison, compare, compare_over_problems, holm
from .record import Job, Record
from .running_time import ert
from .statistics import (
    LEVEL,
    TARGETS,
    Cells,
    IntervalEstimate,
    Targets,
    algorithms_of,
    allowed,
    area,
    cells,
    compared,
    ecdf,
    limits_of,
    precision,
    problems_of,
    ratios,
    success_rate,
)

# --- how intervals are written ---------------------------------------------------------------


def interval(estimate: IntervalEstimate, digits: int = 4) -> str:
    """A number and its interval: "1,234 (1,100 to 1,400)", "∞ (at least 3,210)"."""
    shown, low, high = (grouped(v, digits) for v in (estimate.value, estimate.low, estimate.high))
    if DASH in {shown, low, high}:
        return shown
    if math.isinf(estimate.high):
        return f"{shown} (at least {low})"
    return f"{shown} ({low} to {high})"


def _estimate(estimate: IntervalEstimate, text: str | None = None) -> Cell:
    if math.isnan(estimate.value):
        return Cell(DASH)
    ends = {"low": estimate.low, "high": estimate.high}
    parts = {} if math.isnan(estimate.low) else ends
    return Cell(text or interval(estimate), estimate.value, parts)


def _fixed(estimate: IntervalEstimate) -> Cell:
    shown = (f"{v:.2f}" for v in (estimate.value, estimate.low, estimate.high))
    text = "{} ({} to {})".format(*shown)
    return _estimate(estimate, text.partition(" ")[0] if "nan" in text else text)


# --- the tables ------------------------------------------------------------------------------

_INTERVALS = f"Intervals of {LEVEL:.0%}".replace("%", " %")


def summary(records: Iterable[Record], jobs: Sequence[Job] = ()) -> Table:
    """Every cell: successes, expected running time, and what a run took.

    Args:
        records: Of one campaign, in any order.
        jobs: The campaign's jobs: the order of the rows, and how many runs there will be.
    """
    results = cells(records, jobs)
    planned = Counter(job.cell for job in jobs)
    rows = [
        (
            Cell.label(problem),
            Cell.label(algorithm),
            _runs(len(runs), planned[problem, algorithm]),
            _success(runs),
            _estimate(ert(runs)),
            _over(runs, lambda r: r.evaluations, np.median),
            _over(runs, lambda r: r.search_rounds, np.mean),
            _over([r for r in runs if r.entrapments is not None], _entrapments, np.mean),
            _over(runs, lambda r: r.seconds, np.mean, digits=3),
        )
        for (problem, algorithm), runs in results.items()
    ]
    return Table(
        "Success and effort",
        (
            *("problem", "method", "runs", "success", "ERT"),
            *("evaluations", "rounds", "entrapments", "seconds"),
        ),
        tuple(rows),
        f"{_INTERVALS}: success by Wilson, ERT by bootstrap over runs. ERT: evaluations of all "
        "runs, up to the target where it was met, divided by the successes; a run that failed "
        "counts with what it spent, whether its budget or its method ended it. Evaluations: "
        "median spent by a run. Rounds, entrapments and seconds: mean of a run. Entrapments: how "
        "often tabu search went back or began anew; a deadlock that only narrows the radius is "
        f"none.{_repeating(results)}{_budgets(results)}",
    )


def solutions(records: Iterable[Record], jobs: Sequence[Job] = ()) -> Table:
    """Every cell: average, least, greatest and standard deviation of the final cost.

    Args:
        records: Of one campaign, in any order.
        jobs: The campaign's jobs: the order of the rows, and how many runs there will be.
    """
    planned, results = Counter(job.cell for job in jobs), cells(records, jobs)
    minima: dict[str, set[float | None]] = {}
    for job in (*jobs, *(r.job for runs in results.values() for r in runs)):
        minima.setdefault(job.problem, set()).add(job.minimum)
    moving = {problem for problem, known in minima.items() if len(known) > 1}
    rows = []
    for (problem, algorithm), runs in results.items():
        value = precision if problem in moving else _cost
        rows.append(
            (
                Cell.label(problem),
                Cell.label(algorithm),
                _runs(len(runs), planned[problem, algorithm]),
                *(_over(runs, value, f, digits=7) for f in (np.mean, np.min, np.max)),
                _over(runs, value, _deviation),
            )
        )
    above = f" Above the minimum, which differs from run to run: {_few(moving)}." if moving else ""
    return Table(
        "Final cost",
        ("problem", "method", "runs", "average", "min", "max", "std"),
        tuple(rows),
        "Std is the sample's, with n - 1. A run ends at its target: how far below it a success "
        f"came to lie says little.{above}",
    )


def comparisons(
    records: Iterable[Record], jobs: Sequence[Job] = (), *, reference: str | None = None
) -> Table:
    """Every two methods on every problem: is one better, how sure is it, and by how much.

    Args:
        records: Of one campaign, in any order.
        jobs: The campaign's jobs: the order of the rows.
        reference: Only this method against each of the others.

    Raises:
        InputError: there is no such reference.
    """
    results = cells(records, jobs)
    tests = [
        (problem, a, b, compare(results.get((problem, a), []), results.get((problem, b), [])))
        for problem in problems_of(results)
        for a, b in _pairings(results, reference)
    ]
    adjusted = holm([c.p for *_, c in tests])
    rows = [
        (
            Cell.label(problem),
            Cell.label(a),
            Cell.label(b),
            _test(c),
            Cell.number(c.p, 2),
            Cell.number(float(p), 2),
            _fixed(c.effect),
            _better(a, b, float(p), c.effect.value),
        )
        for (problem, a, b, c), p in zip(tests, adjusted, strict=True)
    ]
    return Table(
        "Comparisons on each problem",
        ("problem", "first", "second", "test", "p", "p (Holm)", "A12", "better"),
        tuple(rows),
        "A success is better than a failure; successes rank by evaluations, failures by final "
        "cost (above the minimum, where it is known). Paired: signed ranks (Pratt) of runs on the "
        "same instance; unpaired: rank sum (Mann-Whitney), where all repeats are on one function. "
        "A12: chance that a run of the first is better than one of the second, ties half. "
        f"{_INTERVALS}. Holm over the tests of this table, "
        f"{int(np.isfinite(adjusted).sum())} in all; better: Holm's p below "
        f"{1 - LEVEL:.2f}; a dash there says that no difference is shown, not that there is none."
        f"{_repeating(results)}{_budgets(results)}",
    )


def overall(
    records: Iterable[Record], jobs: Sequence[Job] = (), *, reference: str | None = None
) -> Table:
    """Every two methods over all problems, each problem one pair.

    Args:
        records: Of one campaign, in any order.
        jobs: The campaign's jobs: the order of the rows.
        reference: Only this method against each of the others.

    Raises:
        InputError: there is no such reference.
    """
    results = cells(records, jobs)
    pairings = _pairings(results, reference)
    effects = [_effects(results, a, b) for a, b in pairings]
    p = [compare_over_problems(e) for e in effects]
    rows = []
    for (a, b), e, raw, adjusted in zip(pairings, effects, p, holm(p), strict=True):
        typical = float(np.median(e)) if e else math.nan
        won, lost = sum(v > 1 / 2 for v in e), sum(v < 1 / 2 for v in e)
        rows.append(
            (
                Cell.label(a),
                Cell.label(b),
                Cell.number(len(e)),
                Cell.number(won),
                Cell.number(lost),
                Cell.number(raw, 2),
                Cell.number(float(adjusted), 2),
                Cell(f"{typical:.2f}", typical) if e else Cell(DASH),
                _better(a, b, float(adjusted), typical),
            )
        )
    return Table(
        "Comparisons over problems",
        ("first", "second", "problems", "won", "lost", "p", "p (Holm)", "median A12", "better"),
        tuple(rows),
        "Signed ranks (Pratt) of A12 - 1/2, each problem one pair; with k problems p cannot fall "
        f"below 2^(1-k). Holm over this table; better: Holm's p below {1 - LEVEL:.2f}. The "
        "problems are taken as independent: where a function counts several times, in several "
        f"dimensions or beside its twin, p is too small.{_budgets(results)}",
    )


def ranking(
    records: Iterable[Record], jobs: Sequence[Job] = (), *, targets: Targets = TARGETS
) -> Table:
    """The methods by the area under their ECDF, best first.

    Those meant for every problem are compared, on the problems that each of them has been run
    on so far; a method meant for some only, or without a run, stands last, with dashes.

    Args:
        records: Of one campaign, in any order.
        jobs: The campaign's jobs.
        targets: Precisions above the minimum (costs, where that is not known).
    """
    results = cells(records, jobs)
    names, problems = algorithms_of(results), problems_of(results)
    present, shared = compared(results)
    runs = {a: [r for p in shared for r in results[p, a]] for a in present}
    limits = limits_of(itertools.chain(*runs.values()))
    areas = {a: area(runs[a], targets, limits) for a in present}
    times = ratios(
        [[ert(results[p, a]).value for a in present] for p in shared] or np.empty((0, 0))
    )
    best, solved = _shares(times, len(present))
    order = sorted(present, key=lambda a: -np.nan_to_num(areas[a].value, nan=-1.0))
    rows = [
        (
            Cell.number(place),
            Cell.label(a),
            _fixed(areas[a]),
            Cell.number(_met(runs[a], targets, limits), 3),
            _success([r for r in runs[a] if r.job.target is not None]),
            Cell.number(float(best[present.index(a)]), 2),
            Cell.number(float(solved[present.index(a)]), 2),
        )
        for place, a in enumerate(order, start=1)
    ]
    none = Cell(DASH)
    rows += [(none, Cell.label(a), none, none, none, none, none) for a in names if a not in present]
    return Table(
        "Ranking",
        ("rank", "method", "area", "targets met", "success", "fastest", "solved"),
        tuple(rows),
        f"On {len(shared)} of {len(problems)} problems; methods meant for fewer are not ranked. "
        "Area under the ECDF of evaluations per dimension, log axis, from one to the least "
        "budget of a method ranked; 1 is best; targets met: where it ends. "
        f"{_INTERVALS}, for other runs on these problems and not for other problems: area by "
        "bootstrap over runs, success by Wilson. Where areas' intervals overlap the "
        f"order is not sure. Of the problems with a target ({len(times)}), fastest is the share on "
        "which its ERT is the least, solved that "
        f"on which at least one run met it.{_repeating(results)}{_budgets(results)}",
    )


# --- cells -----------------------------------------------------------------------------------


def _runs(done: int, planned: int) -> Cell:
    if done >= planned:
        return Cell(f"{done}", done)
    return Cell(f"{done} of {planned}", done, {"planned": planned})


def _success(runs: Sequence[Record]) -> Cell:
    rate = success_rate(runs)
    if math.isnan(rate.value):
        return Cell(DASH)
    text = f"{sum(r.reached for r in runs)}/{len(runs)}"
    return _estimate(rate, f"{text} ({100 * rate.low:.0f} to {100 * rate.high:.0f} %)")


def _over(
    runs: Sequence[Record],
    value: Callable[[Record], float],
    statistic: Callable[[Array], float],
    *,
    digits: int = 4,
) -> Cell:
    if not runs:
        return Cell(DASH)
    return Cell.number(float(statistic(np.array([value(r) for r in runs], dtype=float))), digits)


def _cost(record: Record) -> float:
    return record.cost


def _entrapments(run: Record) -> float:
    return run.entrapments or 0


def _met(runs: Sequence[Record], targets: Targets, limits: Mapping[str, float]) -> float:
    """The share of (problem, precision, repeat) met within the limits."""
    shares = []
    for problem, limit in limits.items():
        curve = ecdf([r for r in runs if r.job.problem == problem], targets)
        within = int(np.searchsorted(curve.at, limit, side="right"))
        shares.append(float(curve.share[within - 1]) if within else 0.0)
    return float(np.mean(shares)) if shares else math.nan


def _budgets(results: Cells) -> str:
    """Which methods were allowed fewer or more evaluations than most: a sentence, if any."""
    budgets: dict[str, dict[str, float]] = {}
    for (problem, algorithm), runs in results.items():
        if runs:
            budgets.setdefault(problem, {})[algorithm] = min(map(allowed, runs))
    most = {problem: median_low(by.values()) for problem, by in budgets.items()}
    less, more = (
        {a for p, by in budgets.items() for a, budget in by.items() if differs(budget, most[p])}
        for differs in (operator.lt, operator.gt)
    )
    parts = [f"{_few(a)} {word} evaluations" for a, word in ((less, "fewer"), (more, "more")) if a]
    return f" Allowed other budgets than most: {'; '.join(parts)}." if parts else ""


def _repeating(results: Cells) -> str:
    """Which methods repeat one run over and over: a sentence, if any."""
    again = {a for (_, a), runs in results.items() if _is_one(runs)}
    return (
        f" Nothing in {_few(again)} is random: on a function that does not change the runs are one "
        "run repeated, which intervals and tests take for many."
        if again
        else ""
    )


def _is_one(runs: Sequence[Record]) -> bool:
    """Whether a cell's runs, on one function, are all the same."""
    return len(runs) > 1 and all(
        (r.job.surface, r.x, r.evaluations) == (runs[0].job.surface, runs[0].x, runs[0].evaluations)
        and np.array_equal(r.steps.evaluations, runs[0].steps.evaluations)
        and np.array_equal(r.steps.costs, runs[0].steps.costs)
        for r in runs
    )


def _few(names: Iterable[str], most: int = 6) -> str:
    """Names for a note."""
    known = sorted(names)
    return ", ".join(known[:most]) + (f" and {len(known) - most} more" * (len(known) > most))


def _deviation(costs: Array) -> float:
    known = len(costs) > 1 and np.isfinite(costs).all()
    return float(np.std(costs, ddof=1)) if known else math.nan


def _pairings(results: Cells, reference: str | None) -> list[tuple[str, str]]:
    names = algorithms_of(results)
    if reference is None:
        return list(itertools.combinations(names, 2))
    if reference not in names:
        raise InputError(f"no method {reference!r} to compare with: there are {', '.join(names)}")
    return [(reference, name) for name in names if name != reference]


def _effects(results: Cells, first: str, second: str) -> list[float]:
    both = [
        (results[problem, first], results[problem, second])
        for problem in problems_of(results)
        if results.get((problem, first)) and results.get((problem, second))
    ]
    return [compare(a, b).effect.value for a, b in both]


def _test(comparison: Comparison) -> Cell:
    if math.isnan(comparison.p):
        return Cell(DASH, "")
    m, n = comparison.runs
    return Cell.label(f"paired, {m}" if comparison.paired else f"unpaired, {m} and {n}")


def _better(first: str, second: str, p: float, effect: float) -> Cell:
    sure = p < 1 - LEVEL and effect != 1 / 2
    return Cell.label(first if effect > 1 / 2 else second) if sure else Cell(DASH, "")


def _shares(times: Array, methods: int) -> tuple[Array, Array]:
    if not len(times):
        return np.full(methods, math.nan), np.full(methods, math.nan)
    return (times == 1).mean(axis=0), np.isfinite(times).mean(axis=0)
