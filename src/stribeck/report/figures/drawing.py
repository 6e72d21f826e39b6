"""Plots as figures for print, drawn by matplotlib."""

from __future__ import annotations

import re
from io import BytesIO
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..contents.decimation import corners
from .style import COLOURS, DPI, STYLE, legend_above

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from ...space import Array
    from .plot import Column, Kind, Line, Plot, View

#: CSS pixels of an inch of a printed figure, and its widths in inches: with one panel, with more.
_PIXELS, _WIDTH, _WIDE = 100, 6.4, 7.2
#: Samples of a line that is drawn large, and small.
_FINE, _COARSE = 8000, 1200
#: Inches of a small diagram: its width, the height of its only panel, of the first of several and
#: of the others, the room between panels, between cells and at the edges.
_CELL, _ONLY, _FIRST, _OTHER, _GAP = 2.35, 1.9, 1.45, 0.42, 0.08
_BETWEEN, _BELOW, _LEFT, _ABOVE, _FOOT, _RIGHT = 0.62, 0.62, 0.85, 0.78, 0.55, 0.15
#: Entries of a legend in one line.
_ONE_LINE = 4
_SHADE = "#f1f4f6"
_SYMBOLS = {"triangle-up": "^", "triangle-down": "v"}


class PrintedFigure(Figure):
    """A figure of matplotlib that shows itself in a notebook, whatever is imported there."""

    def _repr_png_(self) -> bytes:
        buffer = BytesIO()
        with mpl.rc_context(STYLE):
            self.savefig(buffer, format="png", dpi=DPI)
        return buffer.getvalue()


def draw(plot: Plot) -> Figure:
    """A plot of one view: its panels one above the other."""
    (view,) = plot.views
    width = _WIDTH if len(plot.panels) == 1 else _WIDE
    figure = PrintedFigure(figsize=(width, plot.height / _PIXELS), layout="constrained")
    axes = _stack(figure, plot)
    _fill(axes, plot, view, _FINE)
    axes[0].set_title(plot.title)
    figure.align_ylabels(axes)
    entries = sum(not line.same for line in view.lines)
    legend_above(figure, axes[0], 3 if entries > _ONE_LINE else None)
    return figure


def draw_row(title: str, plots: Sequence[Plot], *, share_y: bool = False) -> Figure:
    """Plots of one panel and one view beside one another, under one title."""
    height = max(plot.height for plot in plots) / _PIXELS
    figure = PrintedFigure(figsize=(4.8 * len(plots), height), layout="constrained")
    row = figure.subplots(1, len(plots), sharey=share_y, squeeze=False)[0]
    for axes, plot in zip(row, plots, strict=True):
        _fill([axes], plot, plot.views[0], _FINE)
        axes.set_title(plot.title, fontsize=10)
        axes.set(xlabel=plot.x, ylabel=plot.panels[0].label)
    if share_y:
        for axes in row[1:]:
            axes.set_ylabel("")
    figure.suptitle(title, x=0.01, ha="left", fontsize=12, weight="bold")
    handles, labels = (
        [h for axes in row for h in axes.get_legend_handles_labels()[k]] for k in (0, 1)
    )
    named = dict(zip(labels, handles, strict=True))
    figure.legend(named.values(), named, loc="outside lower center", fontsize=9,
                  ncols=-(-len(named) // 2) if len(named) > 3 else 3)  # noqa: PLR2004  # fmt: skip
    return figure


def draw_views(plot: Plot, columns: int) -> Figure:
    """Small multiples: each view of a plot in a cell, its panels one above the other.

    Args:
        plot: The plot.
        columns: Cells side by side at most.
    """
    columns = min(columns, len(plot.views))
    rows = -(-len(plot.views) // columns)
    others = [_OTHER] * (len(plot.panels) - 1)
    heights = [_FIRST if others else _ONLY, *others]
    cell = sum(heights) + _GAP * (len(heights) - 1)
    width = _LEFT + columns * _CELL + (columns - 1) * _BETWEEN + _RIGHT
    height = _ABOVE + rows * cell + (rows - 1) * _BELOW + _FOOT
    figure = PrintedFigure(figsize=(width, height))
    for k, view in enumerate(plot.views):
        x = _LEFT + (k % columns) * (_CELL + _BETWEEN)
        top = height - _ABOVE - (k // columns) * (cell + _BELOW)
        stack: list[Axes] = []
        for high in heights:
            place = (x / width, (top - high) / height, _CELL / width, high / height)
            stack.append(figure.add_axes(place, sharex=stack[0] if stack else None))
            top -= high + _GAP
        _fill(stack, plot, view, _COARSE)
        _dress(stack, view, outer=k % columns == 0)
    _surround(figure, plot, width, height)
    return figure


def _stack(figure: Figure, plot: Plot) -> list[Axes]:
    shares = [panel.share for panel in plot.panels]
    grid = figure.subplots(len(shares), 1, sharex=True, squeeze=False, height_ratios=shares)
    stack = list(grid[:, 0])
    for axes, panel in zip(stack, plot.panels, strict=True):
        axes.set_ylabel(panel.label)
        if panel.title:
            axes.set_title(panel.title)
    stack[-1].set_xlabel(plot.x)
    return stack


def _dress(stack: Sequence[Axes], view: View, *, outer: bool) -> None:
    """The names and ticks of a small diagram."""
    stack[0].set_title(view.name, loc="left", fontsize=8.5, pad=4)
    stack[0].set_title(view.remark, loc="right", fontsize=8.5, fontweight="normal", pad=4)
    for panel, axes in enumerate(stack):
        axes.tick_params(labelbottom=panel == len(stack) - 1, labelsize=8)
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.yaxis.set_major_locator(MaxNLocator(2, symmetric=True) if panel else MaxNLocator(4))
        if panel:
            axes.tick_params(labelleft=outer)


def _surround(figure: Figure, plot: Plot, width: float, height: float) -> None:
    """Title, legend and axes that small diagrams share."""
    figure.text(_LEFT / width, 1 - 0.14 / height, plot.title, weight="bold", size=12, va="top")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper right", ncols=3, fontsize=9.5,
                  bbox_to_anchor=(1 - _RIGHT / width, 1 - 0.02 / height))  # fmt: skip
    figure.text(_LEFT / width, 0.1 / height, plot.x, size=10)
    first, *others = (panel.label for panel in plot.panels)
    vertical = "; below each: ".join([first, *others])
    figure.text(0.14 / width, 0.5, vertical, size=10, rotation=90, va="center")


def _fill(stack: Sequence[Axes], plot: Plot, view: View, most: int) -> None:
    """Draw a view into the axes of its panels."""
    for line in view.lines:
        _line(stack[line.panel], view, line, most)
    for k, (start, stop) in enumerate(view.spans):
        for axes in stack:
            axes.axvspan(start, stop, color=_SHADE, zorder=0, label="" if k else view.shaded)
    _rules(stack, view)
    _notes(stack[0], view)
    for panel, ends in view.ranges.items():
        stack[panel].set_ylim(*ends)
    if plot.log:
        for axes in stack:
            axes.set(xscale="log", yscale="log")


def _rules(stack: Sequence[Axes], view: View) -> None:
    for level in view.levels:
        axes = stack[level.panel]
        axes.axhline(level.at, color=_colour(level.role), lw=0.8, ls="--" if level.dash else "-")
        if level.name:
            axes.annotate(level.name, (1, level.at), (0, 4), xycoords=("axes fraction", "data"),
                           textcoords="offset points", ha="right", color=_colour(level.role),
                           fontsize=9)  # fmt: skip
    for vertical in view.verticals:
        for axes in stack:
            axes.axvline(vertical.at, color=_colour(vertical.role), lw=0.8,
                         ls=":" if vertical.dash else "-")  # fmt: skip


def _notes(axes: Axes, view: View) -> None:
    for note in view.notes:
        way = 1 if note.y >= 0 else -1
        away = (-10 if note.side == "left" else 10, note.away * way)
        axes.annotate(_mathematical(note.text), (note.x, note.y), away,
                       textcoords="offset points", color=_colour(note.role), size=9,
                       ha="right" if note.side == "left" else "left",
                       va="bottom" if note.above else "top")  # fmt: skip


def _line(axes: Axes, view: View, line: Line, most: int) -> None:
    x, y = _numbers(view.columns[line.x]), _numbers(view.columns[line.y])
    colour, label = _colour(line.role), "" if line.same else line.name
    if line.kind == "band":
        low = _numbers(view.columns[line.low or line.y])
        axes.fill_between(x, low, y, color=colour, alpha=0.18, lw=0, label=label)
        return
    if line.kind == "points" and line.symbols is not None:
        for symbol in sorted(set(line.symbols)):
            rows = np.array([s == symbol for s in line.symbols])
            axes.plot(x[rows], y[rows], _SYMBOLS.get(symbol, "o"), color=colour, ms=5, label=label)
            label = ""
        return
    if line.kind in ("line", "dashes", "dotted"):
        rows = corners([x, y], most)
        x, y = x[rows], y[rows]
    axes.plot(x, y, color=colour, label=label, **_look(line.kind, wide=line.wide))


def _look(kind: Kind, *, wide: bool) -> dict[str, Any]:
    """How matplotlib draws a kind of line."""
    looks: dict[Kind, dict[str, Any]] = {
        "line": {"lw": 2.2 if wide else 1.3},
        "dashes": {"ls": "--", "lw": 1.2},
        "dotted": {"ls": ":", "lw": 1.2},
        "steps": {"drawstyle": "steps-post", "lw": 1.5},
        "marks": {"ls": "-", "marker": ".", "lw": 0.8, "ms": 4},
        "dots": {"ls": "", "marker": ".", "ms": 2.5, "alpha": 0.8, "rasterized": True},
        "points": {"ls": "", "marker": "o", "ms": 4},
        "rings": {"ls": "", "marker": "o", "ms": 5, "mfc": "white"},
    }
    return looks[kind]


def _colour(role: str) -> str:
    return COLOURS[role][0]


def _numbers(column: Column) -> Array:
    """A column as numbers; nan where it has none."""
    return np.array(column, dtype=float)


def _mathematical(text: str) -> str:
    """Letters with indices as matplotlib sets them."""
    return re.sub(r"[A-Za-z]_(\{[^}]*\}|\w)", r"$\g<0>$", text)
