"""The tracks of bacteria and tabu search over a surface: the paper's figure 2."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..report.figures.style import ACCENT, INK, MEASURED, MODEL, STYLE
from .campaign_figures import CampaignFigure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..optimize import Problem, Trace
    from ..space import Array


def movements(
    problem: Problem, trace: Trace, *, optima: Sequence[Sequence[float]] = (), title: str = ""
) -> CampaignFigure:
    """The tracks of a run on a surface of two variables: the paper's figure 2.

    Args:
        problem: A problem of two variables.
        trace: A run of a method with bacteria on it, tabu search after them or not. Of a run
            that began anew the last foraging stage is drawn, and what came after it.
        optima: Where the minimum is taken, physical values, shape (k, 2).
        title: What to write above.
    """
    tracks, path = foraging_tracks(problem, trace), tabu_path(problem, trace)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.6 if len(path) else 5.6, 5.0), layout="constrained")
        panels = figure.subplots(1, 2 if len(path) else 1, squeeze=False)[0]
        figure.get_layout_engine().set(h_pad=0.1)  # type: ignore[union-attr, call-arg]
        space = problem.space
        corners = space.decode(np.array([[0.0, 0.0], [1.0, 1.0]]))
        whole = (corners[0], corners[1])
        _contours(panels[0], problem, *whole)
        steps = int(np.isfinite(tracks[1:, 0, 0]).sum())
        for k in range(tracks.shape[1]):
            panels[0].plot(*tracks[:, k].T, color=MODEL, lw=0.8, alpha=0.8 if steps < 60 else 0.3)  # noqa: PLR2004
        if len(tracks):
            panels[0].plot(*tracks[0].T, "o", color=INK, ms=3.5, mfc="white", label="start")
            panels[0].plot(*tracks[-1].T, "o", color=MODEL, ms=3.5, label="last step")
        panels[0].set_title(f"{tracks.shape[1]} bacteria, {_counted(steps, 'chemotactic step')}")
        if len(path):
            _path(panels, problem, path, whole)
        for axes in panels:
            _optima(axes, optima)
        figure.legend(*_unique(panels), loc="outside lower center", ncols=5, fontsize=9)
        if title:
            figure.suptitle(title, x=0.01, ha="left", fontweight="bold", fontsize=12)
    return CampaignFigure(
        "movements",
        title or "Movements on the surface",
        "Tracks of the bacteria over the contours of the surface, a point a chemotactic step; "
        "the place where tabu search takes over, and its improving steps from there on, with the "
        "neighbourhood of that place enlarged.",
        figure,
    )


def foraging_tracks(problem: Problem, trace: Trace) -> Array:
    """Places of all cells at their start and after each tumble, shape (steps, cells, 2).

    The first batch of a chemotactic step has every cell, in order; the swims after it have some
    of them, and are left out. Where cells die and split, or are dispersed, there is a row of nan
    between, for none goes on from where it was.
    """
    starts = [0, *trace.ends[:-1]]
    begun = _foraging_from(trace)
    rows: list[Array] = []
    cut = False
    size = trace.ends[begun] - starts[begun]
    for note, start, end in list(zip(trace.notes, starts, trace.ends, strict=True))[begun:]:
        if note.get("stage") == "tabu":
            break
        first = not rows or "round" in note
        cut |= note.get("event") in {"reproduction", "dispersal"}
        if first and end - start == size:
            if cut:
                rows.append(np.full((size, 2), np.nan))
            rows.append(problem.space.decode(trace.u[start:end]))
            cut = False
    return np.array(rows).reshape(-1, size, 2)


def tabu_path(problem: Problem, trace: Trace) -> Array:
    """The hand-over point and the improvements of the tabu stage after it, shape (steps, 2)."""
    begun = _foraging_from(trace)
    starts = [0, *trace.ends[:-1]]
    after = [k for k, n in enumerate(trace.notes) if n.get("stage") == "tabu" and k > begun]
    if not after:
        return np.empty((0, 2))
    born, handed = starts[begun], starts[after[0]]
    at = [born + int(trace.f[born:handed].argmin())]
    for k in range(after[0], len(trace.notes)):
        best = starts[k] + int(trace.f[starts[k] : trace.ends[k]].argmin())
        if trace.f[best] < trace.f[at[-1]]:
            at.append(best)
    path: Array = problem.space.decode(trace.u[at])
    return path


def _foraging_from(trace: Trace) -> int:
    """The step at which the last foraging stage began that tabu search followed, or the first."""
    begun = [k for k, n in enumerate(trace.notes) if "start" in n]
    tabu = [k for k, n in enumerate(trace.notes) if n.get("stage") == "tabu"]
    followed = [k for k in begun if tabu and k < tabu[-1]]
    return (followed or begun or [0])[-1]


def _path(panels: Any, problem: Problem, path: Array, whole: tuple[Array, Array]) -> None:
    left, right = panels
    reach = 1.3 * np.abs(path - path[0]).max(axis=0).max() or 0.01 * float(np.ptp(whole))
    low = np.maximum(path[0] - reach, whole[0])
    high = np.minimum(path[0] + reach, whole[1])
    _contours(right, problem, low, high)
    for axes in panels:
        axes.plot(*path.T, "-", color=ACCENT, lw=1.3)
        axes.plot(*path[1:].T, ".", color=ACCENT, ms=4, label="tabu search")
        axes.plot(*path[0], "D", color=ACCENT, ms=6, mec="white", label="hand-over")
    box = np.array([low, [high[0], low[1]], high, [low[0], high[1]], low])
    left.plot(*box.T, color=INK, lw=0.8)
    right.set_title(f"Enlarged: tabu search, {_counted(len(path) - 1, 'improving step')}")


def _counted(n: int, what: str) -> str:
    return f"{n} {what}{'s' * (n != 1)}"


def _contours(axes: Axes, problem: Problem, low: Array, high: Array) -> None:
    x, y = (np.linspace(a, b, 241) for a, b in zip(low, high, strict=True))
    mesh = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    cost = problem(mesh).reshape(len(y), len(x))
    levels = np.unique(np.quantile(cost[np.isfinite(cost)], np.linspace(0.0, 1.0, 15)))
    axes.contourf(x, y, cost, levels=levels, cmap="Greys_r", alpha=0.35)
    axes.contour(x, y, cost, levels=levels, colors=MEASURED, linewidths=0.4, alpha=0.6)
    names = [f"{q.name} / {q.unit}" if q.unit else q.name for q in problem.space.params]
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel=names[0], ylabel=names[1])
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.set_box_aspect(1)
    axes.grid(visible=False)


def _optima(axes: Axes, optima: Sequence[Sequence[float]]) -> None:
    if len(optima):
        axes.plot(*np.array(optima, dtype=float).T, "*", color="#ffd92f", mec=INK, mew=0.8, ms=11,
                  ls="none", label="optimum", zorder=5)  # fmt: skip


def _unique(panels: Iterable[Axes]) -> tuple[list[Any], list[str]]:
    shown: dict[str, Any] = {}
    for axes in panels:
        handles, labels = axes.get_legend_handles_labels()
        shown |= dict(zip(labels, handles, strict=True))
    return list(shown.values()), list(shown)
