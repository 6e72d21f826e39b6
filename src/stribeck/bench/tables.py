"""A campaign's tables, and the four forms a table is written in."""

from __future__ import annotations

import csv
import io
import itertools
import math
import operator
import re
import textwrap
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median_low
from typing import Self, TypeAlias

import numpy as np

from ..errors import InputError
from ..space import Array
from .comparison import Comparison, compare, compare_over_problems, holm
from .record import Job, Record
from .statistics import (
    LEVEL,
    TARGETS,
    Cells,
    Estimate,
    Targets,
    algorithms_of,
    allowed,
    area,
    cells,
    compared,
    ecdf,
    ert,
    limits_of,
    precision,
    problems_of,
    ratios,
    success_rate,
)

DASH = "–"
#: Powers of ten for which a number is written out, and not as 1.2e-9.
WRITTEN_OUT = range(-3, 6)
Value: TypeAlias = float | str | None


@dataclass(frozen=True)
class Cell:
    """What stands in one place of a table.

    Args:
        text: As it is shown.
        value: In full; None where there is none.
        parts: Further values that the text shows, such as an interval's ends; in a CSV file
            each has a column of its own.
    """

    text: str
    value: Value = None
    parts: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, value: float, digits: int = 4) -> Self:
        """A number; nan says that there is none."""
        return cls(number(value, digits), None if math.isnan(value) else value)


@dataclass(frozen=True)
class Table:
    """A table.

    Args:
        title: What it shows, in one line.
        heads: The columns' heads.
        rows: As many cells a row as there are heads.
        note: What a reader must know to read it right.
    """

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""

    def plain(self) -> str:
        """For the terminal: columns aligned, numbers to the right."""
        lines = [self.heads, *([c.text for c in row] for row in self.rows)]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        sides = [str.rjust if numeric else str.ljust for numeric in self.numeric]
        shown = [
            "  ".join(side(t, w) for side, t, w in zip(sides, line, widths, strict=True)).rstrip()
            for line in lines
        ]
        rule = "  ".join("-" * w for w in widths)
        end = [textwrap.fill(line, 100) for line in self._end]
        return "\n".join([self.title, "", shown[0], rule, *shown[1:], *end]) + "\n"

    def markdown(self) -> str:
        """For a page in Markdown, as GitHub reads tables."""
        marks = ["---:" if numeric else "---" for numeric in self.numeric]
        lines = [
            list(map(_in_markdown, self.heads)),
            marks,
            *([_in_markdown(c.text) for c in row] for row in self.rows),
        ]
        body = [f"| {' | '.join(line)} |" for line in lines]
        end = list(map(_in_markdown, self._end))
        return "\n".join([f"**{_in_markdown(self.title)}**", "", *body, *end]) + "\n"

    def latex(self) -> str:
        """For a paper: a `table` that needs no package."""
        columns = "".join("r" if numeric else "l" for numeric in self.numeric)
        body = [" & ".join(_cell_in_latex(c) for c in row) + r" \\" for row in self.rows]
        lines = [
            r"\begin{table}",
            rf"\caption{{{_in_latex(self.title)}}}",
            rf"\begin{{tabular}}{{{columns}}}",
            r"\hline",
            " & ".join(map(_in_latex, self.heads)) + r" \\",
            r"\hline",
            *body,
            r"\hline",
            r"\end{tabular}",
            *([rf"\par {_in_latex(self.note)}"] if self.note else []),
            r"\end{table}",
        ]
        return "\n".join(lines) + "\n"

    def csv(self) -> str:
        """For other programs: values in full, every part in a column of its own."""
        parts = [
            list(dict.fromkeys(name for cell in column for name in cell.parts))
            for column in zip(*self.rows, strict=True)
        ] or [[] for _ in self.heads]
        named = list(zip(self.heads, parts, strict=True))
        out = io.StringIO()
        write = csv.writer(out, lineterminator="\n").writerow
        write([f"{head} {name}".rstrip() for head, names in named for name in ("", *names)])
        for row in self.rows:
            both = zip(row, parts, strict=True)
            write([v for c, names in both for v in (c.value, *(c.parts.get(n) for n in names))])
        return out.getvalue()

    @property
    def numeric(self) -> list[bool]:
        """Which columns are of numbers, and stand to the right."""
        columns = zip(*self.rows, strict=True) if self.rows else [()] * len(self.heads)
        return [
            any(isinstance(c.value, (int, float)) for c in column)
            and not any(isinstance(c.value, str) for c in column)
            for column in columns
        ]

    @property
    def _end(self) -> list[str]:
        return ["", self.note] if self.note else []


#: The forms by the ending of their file.
FORMS = {"txt": Table.plain, "md": Table.markdown, "tex": Table.latex, "csv": Table.csv}


# --- how numbers are written -----------------------------------------------------------------


def number(value: float | None, digits: int = 4) -> str:
    """A number with so many significant digits: "1,234", "0.0123", "1.2e-9", "∞", or a dash."""
    if value is None or math.isnan(value):
        return DASH
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if value == 0 or (isinstance(value, int) and abs(value) < 10**6):
        return f"{value:,.0f}"
    power = int(f"{value:.{digits - 1}e}".partition("e")[2])
    if power not in WRITTEN_OUT:
        mantissa, _, exponent = f"{value:.{min(digits, 4) - 1}e}".partition("e")
        return f"{mantissa}e{int(exponent)}"
    return f"{value:,.{max(digits - 1 - power, 0)}f}"


def interval(estimate: Estimate, digits: int = 4) -> str:
    """A number and its interval: "1,234 (1,100 to 1,400)", "∞ (at least 3,210)"."""
    shown, low, high = (number(v, digits) for v in (estimate.value, estimate.low, estimate.high))
    if DASH in {shown, low, high}:
        return shown
    if math.isinf(estimate.high):
        return f"{shown} (at least {low})"
    return f"{shown} ({low} to {high})"


def _estimate(estimate: Estimate, text: str | None = None) -> Cell:
    if math.isnan(estimate.value):
        return Cell(DASH)
    ends = {"low": estimate.low, "high": estimate.high}
    parts = {} if math.isnan(estimate.low) else ends
    return Cell(text or interval(estimate), estimate.value, parts)


def _fixed(estimate: Estimate) -> Cell:
    shown = (f"{v:.2f}" for v in (estimate.value, estimate.low, estimate.high))
    text = "{} ({} to {})".format(*shown)
    return _estimate(estimate, text.partition(" ")[0] if "nan" in text else text)


def _label(text: str) -> Cell:
    return Cell(text, text)


def _in_markdown(text: str) -> str:
    return re.sub(r"([\\`*_|<>\[\]])", r"\\\1", text)


_LATEX = {
    "\\": r"\textbackslash{}",
    **{c: f"\\{c}" for c in "&%$#_{}"},
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": "$<$",
    ">": "$>$",
    "∞": r"$\infty$",
    "–": "--",
}  # fmt: skip


def _in_latex(text: str) -> str:
    return "".join(_LATEX.get(c, c) for c in text)


def _cell_in_latex(cell: Cell) -> str:
    if isinstance(cell.value, str):
        return _in_latex(cell.text)
    marked = re.split(r"(-?\d[\d,]*(?:\.\d+)?e-?\d+|-(?:\d[\d,]*(?:\.\d+)?|∞))", cell.text)
    return "".join(_math(t) if i % 2 else _in_latex(t) for i, t in enumerate(marked))


def _math(token: str) -> str:
    mantissa, _, power = token.replace("∞", r"\infty").partition("e")
    return f"${mantissa}\\times10^{{{power}}}$" if power else f"${mantissa}$"


# --- the tables ------------------------------------------------------------------------------

_INTERVALS = f"Intervals of {LEVEL:.0%}".replace("%", " %")


def summary(records: Iterable[Record], jobs: Sequence[Job] = ()) -> Table:
    """Every cell: successes, expected running time, and what a run took.

    Args:
        records: Of one campaign, in any order.
        jobs: The campaign's jobs: the order of the rows, and how many runs there will be.
    """
    found = cells(records, jobs)
    planned = Counter(job.cell for job in jobs)
    rows = [
        (
            _label(problem),
            _label(algorithm),
            _runs(len(runs), planned[problem, algorithm]),
            _success(runs),
            _estimate(ert(runs)),
            _over(runs, lambda r: r.evaluations, np.median),
            _over(runs, lambda r: r.search_rounds, np.mean),
            _over([r for r in runs if r.entrapments is not None], _entrapments, np.mean),
            _over(runs, lambda r: r.seconds, np.mean, digits=3),
        )
        for (problem, algorithm), runs in found.items()
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
        f"none.{_repeating(found)}{_budgets(found)}",
    )


def solutions(records: Iterable[Record], jobs: Sequence[Job] = ()) -> Table:
    """Every cell: average, least, greatest and standard deviation of the final cost.

    Args:
        records: Of one campaign, in any order.
        jobs: The campaign's jobs: the order of the rows, and how many runs there will be.
    """
    planned, found = Counter(job.cell for job in jobs), cells(records, jobs)
    minima: dict[str, set[float | None]] = {}
    for job in (*jobs, *(r.job for runs in found.values() for r in runs)):
        minima.setdefault(job.problem, set()).add(job.minimum)
    moving = {problem for problem, known in minima.items() if len(known) > 1}
    rows = []
    for (problem, algorithm), runs in found.items():
        value = precision if problem in moving else _cost
        rows.append(
            (
                _label(problem),
                _label(algorithm),
                _runs(len(runs), planned[problem, algorithm]),
                *(_over(runs, value, of, digits=7) for of in (np.mean, np.min, np.max)),
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
    found = cells(records, jobs)
    made = [
        (problem, a, b, compare(found.get((problem, a), []), found.get((problem, b), [])))
        for problem in problems_of(found)
        for a, b in _pairings(found, reference)
    ]
    adjusted = holm([c.p for *_, c in made])
    rows = [
        (
            _label(problem),
            _label(a),
            _label(b),
            _test(c),
            Cell.of(c.p, 2),
            Cell.of(float(p), 2),
            _fixed(c.effect),
            _better(a, b, float(p), c.effect.value),
        )
        for (problem, a, b, c), p in zip(made, adjusted, strict=True)
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
        f"{_repeating(found)}{_budgets(found)}",
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
    found = cells(records, jobs)
    pairings = _pairings(found, reference)
    effects = [_effects(found, a, b) for a, b in pairings]
    p = [compare_over_problems(e) for e in effects]
    rows = []
    for (a, b), e, raw, adjusted in zip(pairings, effects, p, holm(p), strict=True):
        typical = float(np.median(e)) if e else math.nan
        won, lost = sum(v > 1 / 2 for v in e), sum(v < 1 / 2 for v in e)
        rows.append(
            (
                _label(a),
                _label(b),
                Cell.of(len(e)),
                Cell.of(won),
                Cell.of(lost),
                Cell.of(raw, 2),
                Cell.of(float(adjusted), 2),
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
        f"dimensions or beside its twin, p is too small.{_budgets(found)}",
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
    found = cells(records, jobs)
    names, problems = algorithms_of(found), problems_of(found)
    present, shared = compared(found)
    runs = {a: [r for p in shared for r in found[p, a]] for a in present}
    limits = limits_of(itertools.chain(*runs.values()))
    areas = {a: area(runs[a], targets, limits) for a in present}
    times = ratios([[ert(found[p, a]).value for a in present] for p in shared] or np.empty((0, 0)))
    best, solved = _shares(times, len(present))
    order = sorted(present, key=lambda a: -np.nan_to_num(areas[a].value, nan=-1.0))
    rows = [
        (
            Cell.of(place),
            _label(a),
            _fixed(areas[a]),
            Cell.of(_met(runs[a], targets, limits), 3),
            _success([r for r in runs[a] if r.job.target is not None]),
            Cell.of(float(best[present.index(a)]), 2),
            Cell.of(float(solved[present.index(a)]), 2),
        )
        for place, a in enumerate(order, start=1)
    ]
    none = Cell(DASH)
    rows += [(none, _label(a), none, none, none, none, none) for a in names if a not in present]
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
        f"on which at least one run met it.{_repeating(found)}{_budgets(found)}",
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
    of: Callable[[Array], float],
    *,
    digits: int = 4,
) -> Cell:
    if not runs:
        return Cell(DASH)
    return Cell.of(float(of(np.array([value(r) for r in runs], dtype=float))), digits)


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


def _budgets(found: Cells) -> str:
    """Who was allowed less or more than most on some problem: a sentence, if anybody."""
    given: dict[str, dict[str, float]] = {}
    for (problem, algorithm), runs in found.items():
        if runs:
            given.setdefault(problem, {})[algorithm] = min(map(allowed, runs))
    most = {problem: median_low(by.values()) for problem, by in given.items()}
    less, more = (
        {a for p, by in given.items() for a, budget in by.items() if differs(budget, most[p])}
        for differs in (operator.lt, operator.gt)
    )
    said = [f"{_few(a)} {word} evaluations" for a, word in ((less, "fewer"), (more, "more")) if a]
    return f" Allowed other budgets than most: {'; '.join(said)}." if said else ""


def _repeating(found: Cells) -> str:
    """Whose runs are one run over and over: a sentence, if anybody's."""
    again = {a for (_, a), runs in found.items() if _is_one(runs)}
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


def _pairings(found: Cells, reference: str | None) -> list[tuple[str, str]]:
    names = algorithms_of(found)
    if reference is None:
        return list(itertools.combinations(names, 2))
    if reference not in names:
        raise InputError(f"no method {reference!r} to compare with: there are {', '.join(names)}")
    return [(reference, name) for name in names if name != reference]


def _effects(found: Cells, first: str, second: str) -> list[float]:
    both = [
        (found[problem, first], found[problem, second])
        for problem in problems_of(found)
        if found.get((problem, first)) and found.get((problem, second))
    ]
    return [compare(a, b).effect.value for a, b in both]


def _test(made: Comparison) -> Cell:
    if math.isnan(made.p):
        return Cell(DASH, "")
    m, n = made.runs
    return _label(f"paired, {m}" if made.paired else f"unpaired, {m} and {n}")


def _better(first: str, second: str, p: float, effect: float) -> Cell:
    sure = p < 1 - LEVEL and effect != 1 / 2
    return _label(first if effect > 1 / 2 else second) if sure else Cell(DASH, "")


def _shares(times: Array, methods: int) -> tuple[Array, Array]:
    if not len(times):
        return np.full(methods, math.nan), np.full(methods, math.nan)
    return (times == 1).mean(axis=0), np.isfinite(times).mean(axis=0)
