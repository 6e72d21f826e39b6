"""The figures of a campaign: convergence, success rates and their cost by method."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from ..report.figures.style import INK, MEASURED, STYLE, save
from .record import Job, Record
from .running_time import ert
from .statistics import (
    TARGETS,
    Cells,
    IntervalEstimate,
    StepCurve,
    Targets,
    algorithms_of,
    area,
    cells,
    compared,
    ecdf,
    ecdf_band,
    limits_of,
    problems_of,
    profile,
    success_rate,
)
from .statistics import convergence as quartiles

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..space import Array

#: Colours that the colour-blind can tell apart (Okabe and Ito 2008; three of Tol's after those).
COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00",
    "#56b4e9", "#1b1f24", "#882255", "#999933", "#332288",
)  # fmt: skip
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.3)), (0, (6, 1.5, 1, 1.5)))
MARKERS = "osD^vPX<>phd8H"
#: Problems on one figure; more of them are split by dimension, and then by number.
PANELS = 24
#: Points of a line.
POINTS = 160
#: More methods than this have the legend beside the lines and no label at each.
LABELLED = 12

Over = Literal["evaluations", "rounds"]


@dataclass(frozen=True, eq=False)
class CampaignFigure:
    """A figure, and what it says in words.

    Args:
        name: Its file's name, without suffix.
        title: What it is of.
        caption: How to read it.
        figure: The figure.
    """

    name: str
    title: str
    caption: str
    figure: Figure = field(repr=False)


@dataclass(frozen=True)
class Look:
    """How a method is drawn, the same in every figure."""

    colour: str
    dash: Any
    marker: str

    def line(self) -> dict[str, Any]:
        """Keywords for a line."""
        return {"color": self.colour, "ls": self.dash, "lw": 1.7}


def looks(methods: Sequence[str]) -> dict[str, Look]:
    """A look for every method: variants of one (`bts`, `bts-restart`) share their colour."""
    families: dict[str, list[str]] = {}
    for method in methods:
        families.setdefault(method.split("-", maxsplit=1)[0], []).append(method)
    assigned: dict[str, Look] = {}
    for k, members in enumerate(families.values()):
        for j, method in enumerate(members):
            dash = DASHES[(j + 2 * (k // 5 + k // 10)) % len(DASHES)]  # twice the colours, no twins
            marker = MARKERS[len(assigned) % len(MARKERS)]
            assigned[method] = Look(COLOURS[k % len(COLOURS)], dash, marker)
    return {method: assigned[method] for method in methods}


def figures(
    records: Iterable[Record], jobs: Sequence[Job] = (), targets: Targets = TARGETS
) -> list[CampaignFigure]:
    """Every figure that the records of a campaign have.

    Args:
        records: The records.
        jobs: The campaign's jobs: they set the order of problems and methods.
        targets: Precisions above the minimum that the ECDF looks at.
    """
    planned = cells(records, jobs)
    results = {cell: runs for cell, runs in planned.items() if runs}
    if not results:
        return []
    with mpl.rc_context(STYLE):
        return [
            *ecdfs(planned, targets),
            *success(results),
            *evaluations(results),
            *profiles(planned),
            *convergence(results, over="evaluations"),
            *convergence(results, over="rounds"),
        ]


def draw(drawn: Iterable[CampaignFigure], folder: Path) -> list[Path]:
    """Write figures as PNG and SVG, and return the files."""
    with mpl.rc_context(STYLE):
        return [file for figure in drawn for file in save(figure.figure, folder, figure.name)]


# --- Convergence -----------------------------------------------------------------------------


def convergence(results: Cells, *, over: Over) -> Iterator[CampaignFigure]:
    """Best cost against evaluations or search rounds: the paper's figure 1."""
    chosen = {c: runs for c, runs in results.items() if max(_end(r, over) for r in runs) > 1}
    methods = _by_result(chosen)
    style = looks(algorithms_of(results))
    what = "evaluations" if over == "evaluations" else "search rounds"
    for suffix, problems in _pages(chosen):
        figure, panels = _panels(len(problems), 3.1, 2.5)
        for axes, problem in zip(panels, problems, strict=True):
            runs = {m: chosen[problem, m] for m in methods if (problem, m) in chosen}
            _converge(axes, runs, style, over)
            axes.set_title(problem)
        _common(figure, what.capitalize(), _height(chosen, problems))
        _legend(figure, [m for m in methods if any((p, m) in chosen for p in problems)], style)
        yield CampaignFigure(
            f"convergence_{over}{suffix}",
            f"Convergence over {what}{_sheet(suffix)}",
            f"Best cost so far against {what}, a panel a problem: the median run and, shaded, "
            "the middle half of the runs. A run that has ended keeps its last value. The dashed "
            "line is the target. The legend begins with the method that ends lowest.",
            figure,
        )


def _converge(axes: Axes, runs: Mapping[str, list[Record]], style: Mapping[str, Look],
              over: Over) -> None:  # fmt: skip
    every = [r for records in runs.values() for r in records]
    above = all(r.job.minimum is not None for r in every)
    target = _target(every[0], above)
    lowest = min(r.cost - (r.job.minimum or 0.0) * above for r in every)
    floor = _floor(every, target) if above else None
    for k, (method, records) in enumerate(runs.items()):
        end = max(_end(r, over) for r in records)
        grid = np.unique(np.geomspace(1, end, POINTS).astype(int))
        low, middle, high = quartiles(records, grid, over=over, above_minimum=above)
        if floor is not None:
            low, middle, high = (np.maximum(q, floor) for q in (low, middle, high))
        low, middle, high = (np.where(np.isfinite(q), q, np.nan) for q in (low, middle, high))
        look = style[method]
        axes.fill_between(grid, low, high, color=look.colour, alpha=0.13, lw=0)
        every_nth = max(1, len(grid) // 4)
        mark = (k * every_nth // max(1, len(runs)), every_nth)
        axes.plot(grid, middle, **look.line(), marker=look.marker, ms=3.5, markevery=mark,
                  gid=f"median:{method}")  # fmt: skip
        axes.plot(grid[-1:], middle[-1:], look.marker, color=look.colour, ms=4.5, mfc="white")
    if target is not None:
        axes.axhline(target, color=MEASURED, ls="--", lw=1, zorder=1)
    axes.set_xscale("log")
    if above or lowest > 0:
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(LogLocator(numticks=6))
        axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_locator(LogLocator(numticks=7))


def _floor(every: Sequence[Record], target: float | None) -> float:
    """The least precision that is drawn: a cost at the minimum itself has no logarithm."""
    aims = [v for r in every if (v := r.cost - (r.job.minimum or 0.0)) > 0]
    least = min(aims, default=1e-16)
    return max(min(least, target or least), (target or least) * 1e-3, 1e-16)


def _target(record: Record, above: bool) -> float | None:
    if record.job.target is None:
        return None
    at = record.job.target - (record.job.minimum or 0.0) * above
    return at if at > 0 or not above else None


def _end(record: Record, over: Over) -> int:
    return record.evaluations if over == "evaluations" else sum(record.rounds.values())


def _height(results: Cells, problems: Sequence[str]) -> str:
    known = {
        r.job.minimum is not None for (p, _), runs in results.items() if p in problems for r in runs
    }
    if known == {True}:
        return "Best cost above the minimum"
    return "Best cost" if known == {False} else "Best cost (above the minimum where known)"


def _by_result(results: Cells) -> list[str]:
    """Methods, the one whose median ends lowest first: by mean rank over the problems."""
    ranks: dict[str, list[float]] = {m: [] for m in algorithms_of(results)}
    for problem in problems_of(results):
        ends = {m: _middle(results[problem, m]) for m in ranks if (problem, m) in results}
        values = np.array(list(ends.values()))
        for method, end in ends.items():
            better, equal = (values < end).sum(), (values == end).sum()
            ranks[method].append(float(better + (equal - 1) / 2) / len(values))
    return sorted(ranks, key=lambda m: float(np.mean(ranks[m])))


def _middle(runs: Sequence[Record]) -> float:
    return float(np.median([r.cost for r in runs]))


# --- Shares of targets -----------------------------------------------------------------------


def ecdfs(results: Cells, targets: Targets = TARGETS) -> Iterator[CampaignFigure]:
    """Share of (problem, target, repeat) solved against evaluations per dimension."""
    style = looks(algorithms_of(results))
    methods, problems = compared(results)
    if not problems:
        return
    by = {m: [r for p in problems for r in results[p, m]] for m in methods}
    limits = limits_of(r for runs in by.values() for r in runs)
    areas = {m: area(runs, targets, limits).value for m, runs in by.items()}
    order = sorted(by, key=lambda m: -areas[m] if math.isfinite(areas[m]) else 0.0)
    dims = sorted({len(r.x) for runs in by.values() for r in runs})
    parts: list[int | None] = [None, *dims] if len(dims) > 1 else [None]
    if len(parts) == 1:
        figure, panels = _panels(1, 6.6, 3.6)
    else:
        figure, panels = _panels(len(parts), 4.2, 3.1, columns=2)
    for axes, dim in zip(panels, parts, strict=True):
        runs_of = {m: [r for r in by[m] if dim in {None, len(r.x)}] for m in order}
        _shares(axes, runs_of, style, targets, limits)
        axes.set_title("All problems" if dim is None else f"{dim} dimensions")
    if len(parts) == 1 and len(order) <= LABELLED:
        _label_ends(panels[0], order, style, areas)
    else:
        _legend(figure, order, style, areas)
    _common(figure, "Evaluations / dimension", "Share of targets met")
    yield CampaignFigure(
        "ecdf",
        "Share of targets met",
        "Share of all (problem, target precision, run) triples met within so many evaluations per "
        "dimension; higher and further left is better. Shaded: 95 % bootstrap interval over runs. "
        "The dotted line is the least budget that all methods had. The number beside a name is the "
        "area under its curve up to there, between 0 and 1, and sets the order."
        + _not_drawn(results, methods, problems),
        figure,
    )


def _shares(axes: Axes, runs_of: Mapping[str, list[Record]], style: Mapping[str, Look],
            targets: Targets, limits: Mapping[str, float]) -> None:  # fmt: skip
    high_end = max(r.evaluations / len(r.x) for runs in runs_of.values() for r in runs)
    low_end = min(1.0, *(1 / len(r.x) for runs in runs_of.values() for r in runs))
    grid = np.geomspace(low_end, high_end, POINTS)
    for k, (method, runs) in enumerate(runs_of.items()):
        curve, look = ecdf(runs, targets), style[method]
        x, y = _steps(curve, low_end, high_end)
        low, high = ecdf_band(runs, grid, targets)
        axes.fill_between(grid, low, high, color=look.colour, alpha=0.12, lw=0, step="post")
        axes.plot(x, y, **look.line(), drawstyle="steps-post", gid=f"share:{method}")
        at = grid[[int((0.3 + 0.6 * (k + 0.5) / len(runs_of)) * (POINTS - 1))]]
        axes.plot(at, _at(curve, at), look.marker, color=look.colour, ms=5, mec="white", mew=0.6)
    problems = {r.job.problem for runs in runs_of.values() for r in runs}
    axes.axvline(min(limits[p] for p in problems), color=INK, ls=":", lw=1)
    axes.set(xscale="log", ylim=(0, 1.005), xlim=(low_end, max(high_end, 2 * low_end)))
    axes.yaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")


def profiles(results: Cells) -> Iterator[CampaignFigure]:
    """Dolan and More's performance profiles of the expected running times."""
    chosen, problems = compared(results)
    times = np.array([[ert(results[p, m]).value for m in chosen] for p in problems])
    times = times.reshape(len(problems), len(chosen))
    aimed = int((~np.isnan(times).any(axis=1)).sum())
    if aimed < 2 or len(chosen) < 2:  # noqa: PLR2004 - nothing to compare
        return
    curves = dict(zip(chosen, profile(times), strict=True))
    style = looks(algorithms_of(results))
    high_end = 1.3 * max((float(c.at[-1]) for c in curves.values() if len(c.at)), default=10.0)
    order = sorted(chosen, key=lambda m: -_log_area(curves[m], high_end))
    figure, (axes,) = _panels(1, 6.6, 3.3)
    for method in order:
        x, y = _steps(curves[method], 1.0, high_end)
        axes.plot(x, y, **style[method].line(), drawstyle="steps-post", gid=f"profile:{method}")
        at = curves[method]
        axes.plot(at.at, at.share, style[method].marker, color=style[method].colour, ms=4)
    axes.set(xscale="log", xlim=(0.97, high_end), ylim=(0, 1.03))
    axes.set(xlabel="Expected evaluations, as a multiple of the best method's on the problem")
    axes.set(ylabel="Share of problems", title="Performance profile")
    axes.yaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
    if len(order) <= LABELLED:
        _label_ends(axes, order, style)
    else:
        _legend(figure, order, style)
    yield CampaignFigure(
        "profile",
        "Performance profile",
        "Share of problems on which a method's expected evaluations to the target are within so "
        "many times those of the best method there; the left end says how often it is itself the "
        "best, the right end how many problems it solves at all."
        + _not_drawn(results, chosen, problems),
        figure,
    )


def _steps(curve: StepCurve, low_end: float, high_end: float) -> tuple[Array, Array]:
    """A curve from its left end to the right one, for drawstyle "steps-post"."""
    first = float(_at(curve, np.array([low_end]))[0])
    inner = (curve.at > low_end) & (curve.at <= high_end)
    last = float(_at(curve, np.array([high_end]))[0])
    x = np.concatenate([[low_end], curve.at[inner], [high_end]])
    return x, np.concatenate([[first], curve.share[inner], [last]])


def _at(curve: StepCurve, x: Array) -> Array:
    share = np.concatenate([[0.0], curve.share])
    out: Array = share[np.searchsorted(curve.at, x, side="right")]
    return out


def _log_area(curve: StepCurve, high_end: float) -> float:
    x, y = _steps(curve, 1.0, high_end)
    return float((np.diff(np.log(x)) * y[:-1]).sum())


# --- Rates and times -------------------------------------------------------------------------


def success(results: Cells) -> Iterator[CampaignFigure]:
    """Success rates with their intervals."""
    rates = {cell: success_rate(runs) for cell, runs in results.items()}
    rates = {cell: rate for cell, rate in rates.items() if math.isfinite(rate.value)}

    def percent(axes: Axes) -> None:
        axes.set_xlim(-0.04, 1.04)
        axes.set_xticks([0, 0.5, 1.0], ["0", "50 %", "100 %"])

    for suffix, figure in _dots(rates, "Share of runs that met the target", percent):
        yield CampaignFigure(
            f"success{suffix}",
            f"Success rates{_sheet(suffix)}",
            "Share of runs that met the target, with its 95 % interval (Wilson).",
            figure,
        )


def evaluations(results: Cells) -> Iterator[CampaignFigure]:
    """Expected running times with their intervals."""
    times = {cell: ert(runs) for cell, runs in results.items()}
    times = {cell: time for cell, time in times.items() if not math.isnan(time.value)}

    def logarithmic(axes: Axes) -> None:
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(numticks=5))
        axes.xaxis.set_minor_formatter(NullFormatter())

    label = "Expected evaluations to the target"
    for suffix, figure in _dots(times, label, logarithmic):
        yield CampaignFigure(
            f"evaluations{suffix}",
            f"Expected evaluations to the target{_sheet(suffix)}",
            "Expected running time: evaluations of all runs over the number of runs that met the "
            "target, which is what restarting until success costs. Bars: 95 % bootstrap interval. "
            "An open triangle at the right: no run met the target; its bar begins at the least "
            "time that the runs leave possible.",
            figure,
        )


def _dots(
    estimates: Mapping[tuple[str, str], IntervalEstimate], label: str, scale: Callable[[Axes], None]
) -> Iterator[tuple[str, Figure]]:
    """Estimates as dots with bars: a panel a problem, a row a method."""
    methods, style = algorithms_of(estimates), looks(algorithms_of(estimates))
    for suffix, problems in _pages(estimates):
        columns = len(problems) if len(problems) <= 5 else 4  # noqa: PLR2004 - the paper's five
        figure, panels = _panels(
            len(problems),
            2.2,
            0.75 + 0.19 * len(methods),
            share=True,
            columns=columns,
        )
        edge = _edge(e for (p, _), e in estimates.items() if p in problems)
        for axes, problem in zip(panels, problems, strict=True):
            scale(axes)
            rows = {m: e for m in methods if (e := estimates.get((problem, m))) is not None}
            for method, e in rows.items():
                _dot(axes, methods.index(method), e, style[method], edge)
            axes.set_title(problem)
            axes.set_yticks(range(len(methods)), methods)
            axes.set_ylim(len(methods) - 0.4, -0.6)
            axes.tick_params(axis="y", length=0)
        _common(figure, label, "")
        yield suffix, figure


def _edge(estimates: Iterable[IntervalEstimate]) -> float:
    """Where what is infinite is drawn."""
    ends = [v for e in estimates for v in (e.value, e.low, e.high) if math.isfinite(v)]
    return 2.0 * max(ends, default=1.0)


def _dot(axes: Axes, row: int, e: IntervalEstimate, look: Look, edge: float) -> None:
    low, high = (v if math.isfinite(v) else w for v, w in ((e.low, e.value), (e.high, edge)))
    if math.isnan(e.high):
        low = high = e.value
    low, high, value = (min(v, edge) for v in (low, high, e.value))
    axes.plot([low, high], [row, row], color=look.colour, lw=2, solid_capstyle="butt", alpha=0.55)
    if math.isfinite(e.value):
        axes.plot(value, row, look.marker, color=look.colour, ms=5.5, mec="white", mew=0.6,
                  gid="estimate")  # fmt: skip
    else:
        axes.plot(edge, row, ">", color=look.colour, ms=6, mfc="white", gid="never")


# --- Sheets ----------------------------------------------------------------------------------


def _not_drawn(results: Cells, methods: Sequence[str], problems: Sequence[str]) -> str:
    out = [m for m in algorithms_of(results) if m not in methods]
    text = f" Not meant for every problem, hence not drawn: {', '.join(out)}." if out else ""
    if len(problems) < len(every := problems_of(results)):
        text += f" Drawn for {len(problems)} of {len(every)} problems: the others lack runs so far."
    return text


def _pages(results: Iterable[tuple[str, str]]) -> Iterator[tuple[str, list[str]]]:
    """Problems by the sheet: (suffix of the file's name, labels)."""
    problems = problems_of(results)
    for k in range(0, len(problems), PANELS):
        suffix = f"_{k // PANELS + 1}" if len(problems) > PANELS else ""
        yield suffix, problems[k : k + PANELS]


def _sheet(suffix: str) -> str:
    return f", sheet {suffix[1:]}" if suffix else ""


def _panels(
    n: int, width: float, height: float, *, share: bool = False, columns: int = 3
) -> tuple[Figure, list[Axes]]:
    """So many panels on a sheet, in rows."""
    if n > 3 * columns:
        columns += 1
    columns = min(n, columns)
    rows = math.ceil(n / columns)
    if share:
        height -= 0.2  # one axis of numbers for a whole column
    width = max(width * columns + 0.6, 5.2)
    figure = Figure(figsize=(width, height * rows + 0.9), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.06, h_pad=0.08)  # type: ignore[union-attr, call-arg]
    grid = figure.subplots(rows, columns, squeeze=False, sharex=share, sharey=share)
    for axes in grid.flat[:n]:
        axes.set_axisbelow(True)
    for axes in grid.flat[n:]:
        axes.set_axis_off()
    for axes in grid.flat[max(0, n - columns) : n]:  # the lowest of each column
        axes.tick_params(labelbottom=True)
    return figure, list(grid.flat[:n])


def _common(figure: Figure, x: str, y: str) -> None:
    figure.supxlabel(x, fontsize=10)
    figure.supylabel(y, fontsize=10)


def _legend(
    figure: Figure,
    methods: Sequence[str],
    style: Mapping[str, Look],
    values: Mapping[str, float] | None = None,
) -> None:
    handles = [
        Line2D([], [], **style[m].line(), marker=style[m].marker, ms=4,
               label=m if values is None else f"{m}  {values[m]:.2f}")
        for m in methods
    ]  # fmt: skip
    free = [axes for axes in figure.axes if not axes.axison]
    if free:
        columns = math.ceil(len(handles) / 12)
        free[0].legend(handles=handles, loc="center left", ncols=columns, handlelength=3.2)
        return
    columns = min(len(handles), max(2, int(figure.get_figwidth() / 1.6)))
    figure.legend(handles=handles, loc="outside upper center", ncols=columns, fontsize=9,
                  handlelength=3.2)  # fmt: skip


def _label_ends(
    axes: Axes, methods: Sequence[str], style: Mapping[str, Look],
    values: Mapping[str, float] | None = None,
) -> None:  # fmt: skip
    """Each line's name at its right end, moved apart where they would overlap."""
    lines = {str(line.get_gid()).partition(":")[2]: line for line in axes.lines if line.get_gid()}
    ends = {m: float(np.asarray(lines[m].get_ydata())[-1]) for m in methods if m in lines}
    low, high = axes.get_ylim()
    gap = 0.062 * (high - low)
    order = sorted(ends, key=lambda m: (ends[m], -list(methods).index(m)))
    places = np.array([ends[m] for m in order])
    for _ in range(200):  # neighbours push one another apart
        overlap = np.maximum(gap - np.diff(places), 0.0)
        if overlap.max(initial=0.0) < 1e-3 * gap:
            break
        places[:-1] -= overlap / 2
        places[1:] += overlap / 2
        places += max(0.0, low - places[0] + gap / 4) - max(0.0, places[-1] - high + gap / 4)
    for method, place in zip(order, places, strict=True):
        look = style[method]
        text = method if values is None else f"{method}  {values[method]:.2f}"
        axes.annotate(
            text,
            (1.0, ends[method]),
            (34, 0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            alpha=0.0,
            fontsize=9,
        )  # room for the layout
        axes.annotate("", (1.0, ends[method]), (1.035, place), xycoords=("axes fraction", "data"),
                      textcoords=("axes fraction", "data"),
                      arrowprops={"arrowstyle": "-", "color": look.colour, "lw": 0.8})  # fmt: skip
        axes.plot([1.04, 1.085], [place, place], transform=axes.get_yaxis_transform(),
                  clip_on=False, **look.line())  # fmt: skip
        axes.annotate(text, (1.095, place), xycoords=("axes fraction", "data"), va="center",
                      color=INK, fontsize=9)  # fmt: skip
    if values is not None:
        axes.annotate("area", (1.095, 1.03), xycoords="axes fraction", fontsize=9,
                      color=MEASURED, va="bottom")  # fmt: skip
