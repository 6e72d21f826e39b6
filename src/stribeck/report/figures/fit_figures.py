"""The figures of a fit: what an engineer puts into a talk."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from ...identify.score import simulated
from ...units import unit
from ..curve_data import balance_points, implied, local_quadratics, reach
from .curves import law_curve, law_figure
from .motions import APART, Traces, alone, loops, many, named, slips, traces
from .style import (
    ACCENT,
    COMMAND,
    DPI,
    INK,
    MEASURED,
    MODEL,
    RASTER_DPI,
    REPEATS,
    STYLE,
    force_unit,
    legend_above,
    one,
    save,
    shown,
    written,
)

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from ...identify.result import Fit

__all__ = [
    "ACCENT",
    "COMMAND",
    "DPI",
    "DRAWN",
    "INK",
    "MEASURED",
    "MODEL",
    "RASTER_DPI",
    "STYLE",
    "draw",
    "drawings",
    "local_quadratics",
    "reach",
    "save",
]

#: Names of the files that `draw` makes.
DRAWN = re.compile(
    r"(convergence|training(_\d+)?|holdout_.+|force(_\d+)?|friction|stribeck_curve|slips|loops)"
    r"\.(png|svg)"
)


def draw(fit: Fit, folder: Path) -> list[Path]:
    """Draw every figure that a fit has, as PNG and SVG, and return the files."""
    with mpl.rc_context(STYLE):
        return [file for name, drawn in drawings(fit).items() for file in save(drawn, folder, name)]


def drawings(fit: Fit) -> dict[str, Figure]:
    """Every figure that a fit has, by the name of its files."""
    with mpl.rc_context(STYLE):
        figures = _simulation(fit) if fit.balance is None else _balance(fit)
        figures["stribeck_curve"] = law_figure(fit)
        return figures


def _simulation(fit: Fit) -> dict[str, Figure]:
    motions = simulated(fit.parameters, fit.p, fit.train)
    trained = traces(fit, fit.train, motions)
    figures = {"convergence": convergence(fit)}
    figures |= _motions(fit, trained, "training", "Training")
    for held in fit.holdout:
        text = (held.within.text if held.within else "all").replace(":", "_")
        seen = traces(fit, held.segments, held.motions)
        figures |= _motions(fit, seen, f"holdout_{text}", "Held out")
    if fit.rig.applied_force:
        figures["loops"] = loops(fit.rig, trained)
    elif (chosen := slips(fit.rig, trained)) is not None:
        figures["slips"] = chosen
    if (points := friction(fit)) is not None:
        figures["friction"] = points
    return figures


def _motions(fit: Fit, seen: Sequence[Traces], name: str, what: str) -> dict[str, Figure]:
    """Few motions a figure each, many in one."""
    if len(seen) > APART:
        title = f"{what}: {len(seen)} motions"
        return {name: many(seen, title, named(fit.rig), written(shown(fit.rig, "position")))}
    return {
        name if len(seen) == 1 else f"{name}_{k}": alone(fit.rig, r, f"{what}: {r.label}")
        for k, r in enumerate(seen, 1)
    }


def convergence(fit: Fit) -> Figure:
    """J against evaluations, a line a repeat, with the baselines (figures 5a and 6a)."""
    figure, axes = one(6.4, 4.0)
    for k, (run, done) in enumerate(zip(fit.runs, fit.polished, strict=True)):
        best = run.trace.convergence()
        colour = REPEATS[k % len(REPEATS)]
        shown = np.isfinite(best)
        axes.plot(np.arange(1, len(best) + 1)[shown], best[shown], color=colour,
                  label=f"repeat {k + 1}: J = {done.cost:.3g} {fit.score.unit}")  # fmt: skip
        axes.plot(run.evaluations + done.evaluations, done.cost, "o", color=colour, ms=4)
    axes.axhline(fit.score.smooth, color=MEASURED, ls="--", lw=1)
    axes.annotate("best smooth motion, no stick-slip", (1, fit.score.smooth), (0, 4), ha="right",
                  xycoords=("axes fraction", "data"), textcoords="offset points",
                  color=MEASURED, fontsize=9)  # fmt: skip
    axes.set(xscale="log", yscale="log", title=f"Convergence of {fit.method}")
    axes.set_ylabel(f"Best J / {fit.score.unit}")
    polished = any(done.evaluations for done in fit.polished)
    axes.set_xlabel(f"Evaluations of J; dot: {'after polishing' if polished else 'where it ended'}")
    figure.legend(loc="outside upper right", ncols=min(3, len(fit.runs)), fontsize=9)
    return figure


def friction(fit: Fit) -> Figure | None:
    """Friction against velocity: the law and what the measured motion implies (figure 9).

    None where the rig cannot say what a motion implies.
    """
    if (points := implied(fit)) is None:
        return None
    v, F = points
    figure, axes = one(6.4, 4.4)
    scale = unit(shown(fit.rig, "velocity")).factor
    axes.plot(v / scale, F, ".", color=MEASURED, rasterized=True, ms=2.5, alpha=0.7,
              label="what the measured motion implies")  # fmt: skip
    law_curve(fit, axes, min(v.min(), 0.0), max(v.max(), 0.0))
    legend_above(figure, axes)
    axes.set(title="Friction against velocity")
    return figure


def _balance(fit: Fit) -> dict[str, Figure]:
    """The figures of a force balance: force and residual in time, and friction against speed."""
    assert fit.balance is not None  # noqa: S101 - drawn for such fits only
    figures = {}
    force = force_unit(fit.rig)
    signals = fit.balance.signals
    if len(signals) > APART:
        every = [
            Traces(log.label, log, b.t, b.measured, b.predicted, np.ones(len(b.t), dtype=bool))
            for log, b in zip(fit.recordings, signals, strict=True)
        ]
        title = (
            f"Force balance: {len(every)} logs, relative error {fit.balance.relative_error:.4g} %"
        )
        figures["force"] = many(every, title, f"Force / {force}", force)
    else:
        for k, (log, b) in enumerate(zip(fit.recordings, signals, strict=True), 1):
            figure = Figure(figsize=(7.2, 5.2), layout="constrained")
            top, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
            top.plot(b.t, b.measured, color=MEASURED, lw=1.4, label="measured")
            top.plot(b.t, b.predicted, color=MODEL, lw=1.0, label="model")
            top.set(ylabel=f"Force / {force}", title=f"Force balance: {log.label}")
            legend_above(figure, top)
            below.plot(b.t, b.measured - b.predicted, ".", color=MEASURED, rasterized=True, ms=2)
            below.axhline(0, color=INK, lw=0.8)
            below.set(xlabel="Time / s", ylabel=f"Residual / {force}")
            below.set_title(f"Relative error {fit.balance.relative_error:.4g} %")
            figures["force" if len(signals) == 1 else f"force_{k}"] = figure
    points, axes = one(6.4, 4.4)
    scale = unit(shown(fit.rig, "velocity")).factor
    v, F = balance_points(fit.balance)
    axes.plot(v / scale, F, ".", color=MEASURED, rasterized=True, ms=2, alpha=0.6,
              label="measured force less inertia and offset")  # fmt: skip
    law_curve(fit, axes, float(v.min()), float(v.max()))
    axes.set(title="Friction against velocity")
    legend_above(points, axes)
    return {**figures, "friction": points}
