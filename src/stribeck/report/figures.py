"""The paper's figures, redrawn for a fit: what an engineer puts into a talk."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..identify.score import simulated
from ..rig.rig import Simulated
from ..units import unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..identify.found import Fit
    from ..identify.problem import Stretch
    from ..rig import Motion
    from ..space import Array

#: Names of the files that `draw` makes.
DRAWN = re.compile(
    r"(convergence|training(_\d+)?|holdout_.+|force(_\d+)?|friction|stribeck_curve)\.(png|svg)"
)

INK, MEASURED, MODEL, COMMAND, ACCENT = "#1b1f24", "#7a8794", "#c2410c", "#b8c0c8", "#1d4ed8"
_REPEATS = ("#c2410c", "#1d4ed8", "#0f766e", "#7c3aed", "#b45309", "#475569")
#: Dots per inch of a PNG, and of the clouds of points in an SVG.
DPI, RASTER_DPI = 160, 100
#: How every figure of the project looks.
STYLE: Any = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.grid": True,
    "grid.color": "#e5e9ed",
    "grid.linewidth": 0.7,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "lines.linewidth": 1.5,
    "svg.hashsalt": "stribeck",  # the same figure has the same bytes
    "svg.fonttype": "none",
}


def draw(fit: Fit, folder: Path) -> list[Path]:
    """Draw every figure that a fit has, as PNG and SVG, and return the files."""
    with mpl.rc_context(STYLE):
        figures = _simulation(fit) if fit.balance is None else _balance(fit)
        figures["stribeck_curve"] = stribeck_curve(fit)
        return [file for name, figure in figures.items() for file in save(figure, folder, name)]


def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write a figure as PNG and SVG."""
    figure.set_dpi(DPI)
    FigureCanvasAgg(figure)
    if (layout := figure.get_layout_engine()) is not None:
        layout.execute(figure)
        figure.set_layout_engine(None)  # else each file would be laid out, and drawn twice for it
        for axes in figure.axes:  # nor is there anything left for a title to evade
            if (title := axes.get_title("left")) and not axes.yaxis.get_offset_text().get_text():
                axes.set_title(title, loc="left", y=1.0)
    files = [folder / f"{name}.png", folder / f"{name}.svg"]
    figure.savefig(files[0], dpi=DPI, metadata={"Software": None})
    figure.savefig(files[1], dpi=RASTER_DPI, metadata={"Date": None, "Creator": None})
    return files


def _simulation(fit: Fit) -> dict[str, Figure]:
    motions = simulated(fit.parameters, fit.p, fit.train)
    figures = {"convergence": convergence(fit)}
    for k, (stretch, model) in enumerate(zip(fit.train, motions, strict=True), 1):
        name = "training" if len(fit.train) == 1 else f"training_{k}"
        figures[name] = motion(fit, stretch, model, f"Training: {_extent(fit, stretch)}")
    for held in fit.holdout:
        for k, (stretch, model) in enumerate(zip(held.stretches, held.motions, strict=True), 1):
            text = (held.within.text if held.within else "all").replace(":", "_")
            name = f"holdout_{text}" if len(held.stretches) == 1 else f"holdout_{text}_{k}"
            figures[name] = motion(fit, stretch, model, f"Held out: {_extent(fit, stretch)}")
    figures["friction"] = friction(fit)
    return figures


def convergence(fit: Fit) -> Figure:
    """J against evaluations, a line a repeat, with the baselines (figures 5a and 6a)."""
    figure, axes = _figure(6.4, 3.8)
    for k, (run, done) in enumerate(zip(fit.runs, fit.polished, strict=True)):
        best = run.trace.convergence()
        colour = _REPEATS[k % len(_REPEATS)]
        shown = np.isfinite(best)
        axes.plot(np.arange(1, len(best) + 1)[shown], best[shown], color=colour,
                  label=f"repeat {k + 1}: J = {done.cost:.3g} {fit.score.unit}")  # fmt: skip
        axes.plot(run.evaluations + done.evaluations, done.cost, "o", color=colour, ms=4)
    axes.axhline(fit.score.smooth, color=MEASURED, ls="--", lw=1)
    axes.annotate("best smooth motion, no stick-slip", (1, fit.score.smooth), (0, 4), ha="right",
                  xycoords=("axes fraction", "data"), textcoords="offset points",
                  color=MEASURED, fontsize=9)  # fmt: skip
    axes.set(xscale="log", yscale="log", title=f"Convergence of {fit.method}")
    axes.set(xlabel="Evaluations of J", ylabel=f"Best J / {fit.score.unit}")
    polished = any(done.evaluations for done in fit.polished)
    dot = "dot: after polishing" if polished else "dot: where it ended"
    axes.legend(title=dot, title_fontsize=8, fontsize=9)
    return figure


def motion(fit: Fit, stretch: Stretch, model: Motion, title: str) -> Figure:
    """Displacement, its residual, and motor force against time (figures 5 to 8, b and c)."""
    rig = fit.rig
    assert isinstance(rig, Simulated)  # noqa: S101 - only such rigs are simulated
    scale = unit(rig.shows.get("position", "m")).factor
    shown = rig.shows.get("position", "m")
    t, x = stretch.track.t, stretch.track.measured / scale
    simulated_x = model.position[0] / scale
    command = np.interp(t, stretch.track.knots_t, stretch.track.knots_x) / scale
    figure = Figure(figsize=(7.2, 6.2), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, sharex=True, height_ratios=[3, 1, 2])
    top.plot(t, command, color=COMMAND, ls="--", lw=1.2, label="command")
    top.plot(t, x, ".", color=MEASURED, rasterized=True, ms=2.5, label="measured")
    top.plot(t, simulated_x, color=MODEL, label="model")
    top.set(ylabel=f"Displacement / {shown}", title=title)
    top.legend(loc="best")
    counts = stretch.track.score > 0
    middle.plot(t[counts], (x - simulated_x)[counts], ".", color=MEASURED, rasterized=True, ms=2)
    middle.axhline(0, color=INK, lw=0.8)
    rms = float(np.sqrt(np.mean((x - simulated_x)[counts] ** 2)))
    middle.set(ylabel=f"Residual / {shown}", title=f"RMS {rms:.3g} {shown}")
    if not counts[0]:
        for axes in (top, middle, bottom):
            axes.axvspan(t[0], t[counts][0], color="#f1f4f6", zorder=0, label="not scored")
        top.legend(loc="best")
    rows = slice(stretch.begin, stretch.rows.stop)
    if stretch.recording.force is not None:
        bottom.plot(
            t,
            stretch.recording.force[rows],
            ".",
            color=MEASURED,
            rasterized=True,
            ms=2.5,
            label="measured",
        )
    bottom.plot(t, model.force[0], color=MODEL, label="model")
    bottom.set(xlabel="Time / s", ylabel="Motor force / N", title="Force exerted by the motor")
    return figure


def friction(fit: Fit) -> Figure:
    """Friction against velocity: the law and what the measured motion implies (figure 9)."""
    figure, axes = _figure(6.4, 4.2)
    points = [seen for s in fit.train if (seen := _measured_friction(fit, s)) is not None]
    points = points or [(np.array([-reach(fit), reach(fit)]), np.full(2, np.nan))]
    v = np.concatenate([a for a, _ in points])
    F = np.concatenate([b for _, b in points])
    scale = unit(fit.rig.shows.get("velocity", "m/s")).factor
    axes.plot(v / scale, F, ".", color=MEASURED, rasterized=True, ms=2.5, alpha=0.7,
              label="what the measured motion implies")  # fmt: skip
    low, high = min(v.min(), 0.0), max(v.max(), 0.0)
    _law_curve(fit, axes, low, high)
    axes.legend()
    axes.set(title="Friction against velocity")
    return figure


def stribeck_curve(fit: Fit) -> Figure:
    """The law itself, with its levels and its crossover marked (figure 4)."""
    figure, axes = _figure(6.4, 4.2)
    p = fit.p[: len(fit.law.params)]
    named = dict(zip(fit.law.names, p, strict=True))
    v_SS = max((named[n] for n in named if n.startswith("v_SS")), default=None)
    far = 8 * v_SS if v_SS is not None else reach(fit)
    force = _force_unit(fit)
    _law_curve(fit, axes, -far, far)
    scale = unit(fit.rig.shows.get("velocity", "m/s")).factor
    minus, plus = fit.law.levels(p)
    axes.plot([0, 0], [minus, plus], "o", color=MODEL, ms=5, mfc="white")
    for level, sign, drop in ((plus, "+", -10), (minus, "-", 6)):
        name = "breakaway" if v_SS is None else f"$F_{{S{sign}}}$ ="
        text = f"{name} {level:.4g} {force}"
        axes.annotate(text, (0, level), (10, drop), textcoords="offset points", color=MODEL, size=9)
    for way in (1, -1) if v_SS is not None else ():
        side = "+" if way > 0 else "-"
        F_C = named.get("F_C", named.get(f"F_C{side}", np.nan))
        F_V = named.get("F_V", named.get(f"F_V{side}", np.nan))
        v = np.array([0.0, way * far])
        axes.plot(v / scale, way * F_C + F_V * v, color=ACCENT, ls=":", lw=1.2)
        end = v[1] / scale, way * F_C + F_V * v[1]
        axes.annotate(f"$F_C$ = {F_C:.4g} {force}, slope $F_V$", end,
                      (0, 8 * way if way > 0 else -14), textcoords="offset points", color=ACCENT,
                      fontsize=9, ha="right" if way > 0 else "left")  # fmt: skip
    axes.set(title=f"{fit.law.name}: the identified curve")
    axes.margins(y=0.15)
    return figure


def _law_curve(fit: Fit, axes: Axes, low: float, high: float) -> None:
    p = fit.p[: len(fit.law.params)]
    written = fit.rig.shows.get("velocity", "m/s")
    scale = unit(written).factor
    label: str | None = f"law: {fit.law.name}"
    for sign, end in ((1.0, high), (-1.0, low)):
        if sign * end > 0:
            v = np.concatenate([[sign * 0.0], end * np.geomspace(1e-4, 1.0, 400)])
            axes.plot(v / scale, fit.law.friction(v, p), color=MODEL, lw=2, label=label)
            label = None
    axes.axhline(0, color=INK, lw=0.8)
    axes.axvline(0, color=INK, lw=0.8)
    axes.set(xlabel=f"Velocity / {written.replace('mm/s', 'mm s⁻¹')}")
    axes.set(ylabel=f"Friction / {_force_unit(fit)}")


def reach(fit: Fit) -> float:
    """The greatest speed of the training data, m/s (rad/s)."""
    if fit.balance is not None:
        return max(float(np.abs(b.velocity).max()) for b in fit.balance.signals)
    motions = simulated(fit.parameters, fit.p, fit.train)
    return max(float(np.abs(m.velocity).max()) for m in motions)


def _force_unit(fit: Fit) -> str:
    return "N m" if fit.recordings[0].rotary else "N"


def _measured_friction(fit: Fit, stretch: Stretch) -> tuple[Array, Array] | None:
    """Velocity and friction in slip as the measurement implies them.

    Velocity and acceleration by local quadratics over a tenth of a second or nine new samples,
    whichever is longer. None if the rig cannot say or the stretch is too short.
    """
    rig, on = fit.rig, stretch.track
    assert isinstance(rig, Simulated)  # noqa: S101 - only such rigs are simulated
    counts = on.score > 0
    t, x = on.t[counts], on.measured[counts]
    dt = float(np.median(np.diff(t)))
    grid = np.arange(t[0], t[-1], dt)
    x = np.interp(grid, t, x)
    width = max(9, 2 * int(0.05 / dt) + 1)
    if len(grid) <= width:
        return None
    smooth, v, a = local_quadratics(x, width, dt)
    inner = slice(width // 2, len(grid) - width // 2)
    e = np.interp(grid[inner], on.knots_t, on.knots_x) - smooth
    F = rig.friction(fit.law, fit.p, e, v, a)
    if F is None:
        return None
    # A window that reaches into a rest mixes both; only those wholly inside a slip are drawn.
    fast = np.pad(np.abs(v) > 0.05 * np.abs(v).max(), width // 2, mode="symmetric")
    moving = np.lib.stride_tricks.sliding_window_view(fast, width).all(axis=1)
    return v[moving], F[moving]


def local_quadratics(x: Array, width: int, dt: float) -> tuple[Array, Array, Array]:
    """Value, slope and curvature at the middle of every window of `width` samples (odd).

    The least-squares parabola of each window (Savitzky and Golay 1964, doi 10.1021/ac60214a047);
    scipy.signal has it too, for half a second of start-up.
    """
    at = (np.arange(width) - width // 2) * dt
    rows = np.linalg.pinv(np.vander(at, 3, increasing=True))
    value, slope, half = (np.convolve(x, row[::-1], mode="valid") for row in rows)
    return value, slope, 2.0 * half


def _balance(fit: Fit) -> dict[str, Figure]:
    """The figures of a force balance: force and residual in time, and friction against speed."""
    assert fit.balance is not None  # noqa: S101 - drawn for such fits only
    figures = {}
    force = _force_unit(fit)
    for k, (log, b) in enumerate(zip(fit.recordings, fit.balance.signals, strict=True), 1):
        figure = Figure(figsize=(7.2, 5.2), layout="constrained")
        top, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
        top.plot(b.t, b.measured, color=MEASURED, lw=1.4, label="measured")
        top.plot(b.t, b.predicted, color=MODEL, lw=1.0, label="model")
        top.set(ylabel=f"Force / {force}", title=f"Force balance: {log.label}")
        top.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2)
        below.plot(b.t, b.measured - b.predicted, ".", color=MEASURED, rasterized=True, ms=2)
        below.axhline(0, color=INK, lw=0.8)
        below.set(xlabel="Time / s", ylabel=f"Residual / {force}")
        below.set_title(f"Relative error {fit.balance.relative_error:.4g} %")
        figures["force" if len(fit.recordings) == 1 else f"force_{k}"] = figure
    points, axes = _figure(6.4, 4.2)
    scale = unit(fit.rig.shows.get("velocity", "m/s")).factor
    v = np.concatenate([b.velocity for b in fit.balance.signals])
    F = np.concatenate([b.friction for b in fit.balance.signals])
    axes.plot(v / scale, F, ".", color=MEASURED, rasterized=True, ms=2, alpha=0.6,
              label="measured force less inertia and offset")  # fmt: skip
    _law_curve(fit, axes, float(v.min()), float(v.max()))
    axes.set(title="Friction against velocity")
    axes.legend()
    return {**figures, "friction": points}


def _figure(width: float, height: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots()


def _extent(fit: Fit, stretch: Stretch) -> str:
    shown = fit.rig.shows.get("position", "m")
    scale = unit(shown).factor
    x = stretch.recording.position[stretch.rows]
    way = "rightward" if stretch.direction > 0 else "leftward"
    return f"{way}, {x[0] / scale:.0f} to {x[-1] / scale:.0f} {shown}"
