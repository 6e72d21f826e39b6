"""How parameters were found: the profile of each, and the convergence of the searches."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from ..contents.schema import ProfileRecord, Report, RunRecord
from ..format import number, unit_label
from .motion_plots import finite
from .plot import MIDDLE, SMALL, Column, Group, Line, Panel, Plot, Rule, View

#: Points between two of a profile, and how high profiles are drawn, thresholds.
_BETWEEN, _HIGH = 8, 2.6


def profile_groups(report: Report) -> list[Group]:
    """One small plot for each parameter."""
    return [_profile(k, p) for k, p in enumerate(report.profiles, 1) if len(p.values) > 1]


def _profile(k: int, p: ProfileRecord) -> Group:
    values, rises = finite(p.values), finite(p.rises)
    fine = np.unique(np.concatenate([
        np.linspace(a, b, _BETWEEN, endpoint=False)
        for a, b in itertools.pairwise(values)
    ] + [values[-1:]]))  # fmt: skip
    roots = np.interp(fine, values, np.sqrt(np.maximum(rises, 0.0)))
    columns: dict[str, Column] = {
        "x": [float(f"{x:.7g}") for x in fine],
        "y": [float(f"{z * z:.4g}") for z in roots],
        "at": p.values,
        "rise": p.rises,
    }
    lines = [
        Line("x", "y", "model", p.name, silent=True),
        Line("at", "rise", "model", "refitted", "rings"),
    ]
    ends = [Rule(x, "accent", dash=True) for x in (p.low, p.high) if x is not None]
    unit = f" {unit_label(p.unit)}".rstrip()
    low, high = number(p.low, 4), number(p.high, 4)
    alt = f"{p.name} = {number(p.value)}{unit}, 95 % from {low} to {high}{unit}."
    top = min(max(float(rises.max()) * 1.08, 1.3), _HIGH)
    view = View(p.name, alt, columns, lines, levels=[Rule(1.0, dash=True)],
                verticals=[Rule(p.value), *ends], ranges={0: (-0.05 * top, top)})  # fmt: skip
    axis = f"{p.name} / {unit_label(p.unit)}" if p.unit else p.name
    plot = Plot(f"profile-{k}", p.name, axis, [Panel("Rise / threshold")], [view], SMALL)
    return Group(f"profile-group-{k}", p.name, [plot])


def convergence_plot(
    records: Sequence[RunRecord], unit: str, smooth: float | None, *, printed: bool = False
) -> Plot | None:
    """The best misfit against evaluations, a line a repeat (figures 5a and 6a).

    Args:
        records: The repeats.
        unit: Of the misfit.
        smooth: The misfit of the best smooth motion, where there is one.
        printed: Whether the legend has the misfit at which each repeat ended, and a dot its end.
    """
    unit = unit_label(unit)
    runs = [run for run in records if run.at]
    if not runs:
        return None
    columns: dict[str, Column] = {}
    lines = []
    for k, run in enumerate(runs):
        best = finite(run.best)
        columns |= {f"x{k}": [*run.at, run.evaluations], f"y{k}": [*best.tolist(), best[-1]]}
        role, name = f"repeat{k % 6}", f"repeat {k + 1}"
        if printed and run.cost is not None:
            name += f": J = {run.cost:.3g} {unit}"
        lines.append(Line(f"x{k}", f"y{k}", role, name, "steps"))
        if (run.polishing or printed) and run.cost is not None:
            columns |= {f"end_x{k}": [run.evaluations + run.polishing], f"end_y{k}": [run.cost]}
            lines.append(Line(f"end_x{k}", f"end_y{k}", role, "polished", "points", same=True))
    levels = []
    if smooth is not None and smooth > 0:
        name = f"best smooth motion{', no stick-slip' if printed else ''}"
        levels = [Rule(smooth, dash=True, name=name)]
    ends = ", ".join(
        f"repeat {k} ended at {number(run.cost, 4)} {unit} after "
        f"{run.evaluations + run.polishing:,}"
        for k, run in enumerate(runs[:6], 1)
    )
    alt = f"Best misfit against evaluations: {ends}."
    view = View("convergence", alt, columns, lines, levels=levels)
    panel = Panel(f"Best {'J' if printed else 'misfit'} / {unit}")
    return Plot("convergence-plot", "Convergence", "Evaluations", [panel], [view], MIDDLE, log=True)


def convergence_group(report: Report) -> Group | None:
    """The same for the page."""
    score = report.card.objective
    plot = convergence_plot(report.runs, score.unit, score.baselines.get("smooth"))
    return None if plot is None else Group("convergence-group", "Convergence", [plot])
