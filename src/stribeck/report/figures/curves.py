"""The identified law as a figure: its curve, its loop if it has states, its budget under load."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ...units import unit
from ..curve_data import greatest_load, loads, loop, own, reach, sides, stroke, under
from .style import ACCENT, INK, MEASURED, MODEL, force_unit, legend_above, one, shown, written

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...identify.result import Fit
    from ...space import Array

__all__ = [
    "bristles",
    "budget",
    "law_curve",
    "law_figure",
    "loop",
    "own",
    "reach",
    "stribeck_curve",
    "under",
]

#: A level below this share of a figure's range is next to its axis.
_LOW = 0.12


def law_figure(fit: Fit) -> Figure:
    """The figure that suits a law: with states, under load, or a curve with its levels."""
    if fit.law.states:
        return bristles(fit)
    if any(load in ("drive", "external", "normal") for load in fit.law.loads):
        return budget(fit)
    return stribeck_curve(fit)


def stribeck_curve(fit: Fit) -> Figure:
    """The law itself, with its levels and its crossover marked (figure 4)."""
    figure, axes = one(6.4, 4.2)
    p = own(fit)
    named = dict(zip(fit.law.names, p, strict=True))
    v_SS = max((named[n] for n in named if n.startswith("v_SS")), default=None)
    fast = reach(fit)
    far = fast if v_SS is None else min(max(8 * v_SS, 0.05 * fast), max(fast, v_SS))
    force = force_unit(fit.rig)
    law_curve(fit, axes, -far, far)
    scale = unit(shown(fit.rig, "velocity")).factor
    if fit.law.directional:
        v = np.concatenate([[0.0], far * np.geomspace(1e-4, 1.0, 400)])
        axes.plot(-v / scale, -fit.law.friction(v, p), color=MEASURED, lw=1, ls="--",
                  label="the + side, mirrored")  # fmt: skip
        legend_above(figure, axes)
    minus, plus = fit.law.levels(p)
    axes.plot([0, 0], [minus, plus], "o", color=MODEL, ms=5, mfc="white")
    span = max(float(np.abs(line.get_ydata()).max()) for line in axes.get_lines()[:2])
    for level, way in ((plus, 1), (minus, -1)):
        sign = "+" if way > 0 else "-"
        F_C = named.get("F_C", named.get(f"F_C{sign}", np.nan)) if v_SS is not None else np.nan
        F_V = named.get("F_V", named.get(f"F_V{sign}", np.nan))
        low = _LOW * span > F_C  # its name would lie on the axis, were it below its level
        if level:
            name = "breakaway" if v_SS is None else f"$F_{{S{sign}}}$ ="
            up = 13 if low and abs(level) - F_C < _LOW * span else 0
            _aside(axes, f"{name} {level:.4g} {force}", level, way, MODEL, outside=True, up=up)
        if np.isfinite(F_C + F_V):
            v = np.array([0.0, way * far])
            axes.plot(v / scale, way * F_C + F_V * v, color=ACCENT, ls=":", lw=1.2)
            text = f"$F_C$ = {F_C:.4g} {force}, slope $F_V$"
            _aside(axes, text, way * F_C, way, ACCENT, outside=low)
    axes.set(title=f"{fit.law.name}: the identified curve")
    axes.margins(y=0.15)
    return figure


def _aside(
    axes: Axes, text: str, level: float, way: int, colour: str, *, outside: bool, up: float = 0
) -> None:
    """The name of a level beside the axis, where no law has its curve: upper left, lower right.

    Args:
        axes: Where.
        text: The name.
        level: The level.
        way: +1 for v > 0, −1 for v < 0.
        colour: Of the text.
        outside: Whether it stands on the far side of its level, seen from zero.
        up: By how much farther, points.
    """
    above = outside == (way > 0)
    axes.annotate(text, (0, level), (-10 * way, up * way), textcoords="offset points",
                  color=colour, size=9, ha="right" if way > 0 else "left",
                  va="bottom" if above else "top")  # fmt: skip


def bristles(fit: Fit) -> Figure:
    """A law with states: steady sliding, and the loops of slow strokes to and fro."""
    figure = Figure(figsize=(9.6, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    fast, p = reach(fit), own(fit)
    law_curve(fit, left, -fast, fast)
    left.set(title="Steady sliding")
    way, pace = stroke(fit)
    length, scale = shown(fit.rig, "position"), unit(shown(fit.rig, "position")).factor
    for share, colour, text in ((1.0, MODEL, "to and fro"), (0.35, ACCENT, "a third as far")):
        x, F = loop(fit.law, p, share * way, pace)
        right.plot(x / scale, F, color=colour, lw=1.6, label=text)
    right.axhline(0, color=INK, lw=0.8)
    right.axvline(0, color=INK, lw=0.8)
    angle = "Angle" if fit.rig.rotary else "Displacement"
    right.set(xlabel=f"{angle} / {written(length)}", ylabel=f"Friction / {force_unit(fit.rig)}")
    right.set_title(f"Slow strokes, {pace / scale:.2g} {written(length)}/s")
    figure.suptitle(
        f"{fit.law.name}: the identified law", x=0.01, ha="left", fontsize=12, weight="bold"
    )
    legend_above(figure, right)
    return figure


def budget(fit: Fit) -> Figure:
    """A law under load: its curve at three loads, and its level against the load."""
    figure = Figure(figsize=(9.6, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    p, fast, most = own(fit), reach(fit), greatest_load(fit)
    scale = unit(shown(fit.rig, "velocity")).factor
    force = force_unit(fit.rig)
    normal = "normal" in fit.law.loads
    v = np.concatenate([[0.0], fast * np.geomspace(1e-4, 1.0, 300)])
    ways = loads(fit.law)
    across = np.linspace(0.0, most, 200)
    first = next(iter(ways.values()))
    for share, colour in ((0.0, MEASURED), (0.5, ACCENT), (1.0, MODEL)):
        curve = [under(fit.law, p, s, first, share * most) for s in v]
        text = f"{share * most:.3g} {'' if normal else force}".strip()
        left.plot(v / scale, curve, color=colour, lw=1.8)
        left.annotate(text if share else "no load", (v[-1] / scale, curve[-1]), (0, 5), size=9,
                      textcoords="offset points", color=colour, ha="right")  # fmt: skip
    left.set(xlabel=f"Velocity / {written(shown(fit.rig, 'velocity'))}")
    left.set(ylabel=f"Friction / {force}")
    left.set_title("Curve" if normal else "Curve, motor against load", fontsize=10)
    moving = f"at {fast / scale:.3g} {written(shown(fit.rig, 'velocity'))}"
    lines: dict[str, Array] = {}
    for text, way in ways.items():
        F = np.array([[under(fit.law, p, u, way, x) for x in across] for u in (0.0, fast)])
        same = next((t for t, other in lines.items() if np.allclose(other, F)), None)
        if same is not None:  # two lines on one another have one name
            lines[f"{same.removesuffix(' alone')} or {text}"] = lines.pop(same)
        else:
            lines[text] = F
    for (text, F), style in zip(lines.items(), ("-", "--", ":"), strict=False):
        for k, colour in enumerate((MODEL, ACCENT)):
            label = f"{text}, {moving if k else 'at rest'}"
            right.plot(across, F[k], color=colour, ls=style, lw=1.6, label=label)
    what = "Normal load" if normal else f"{'Torque' if fit.rig.rotary else 'Force'} / {force}"
    right.set(xlabel=what)
    right.set_title("Level against load", fontsize=10)
    left.set_ylim(bottom=0)
    handles, labels = right.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(lines), fontsize=9)
    figure.suptitle(
        f"{fit.law.name}: friction under load", x=0.01, ha="left", fontsize=12, weight="bold"
    )
    return figure


def law_curve(fit: Fit, axes: Axes, low: float, high: float) -> None:
    """The law between two speeds, with a jump at rest."""
    p = own(fit)
    scale = unit(shown(fit.rig, "velocity")).factor
    label: str | None = f"law: {fit.law.name}"
    for v in sides(low, high):
        axes.plot(v / scale, fit.law.friction(v, p), color=MODEL, lw=2, label=label)
        label = None
    axes.axhline(0, color=INK, lw=0.8)
    axes.axvline(0, color=INK, lw=0.8)
    axes.set(xlabel=f"Velocity / {written(shown(fit.rig, 'velocity'))}")
    axes.set(ylabel=f"Friction / {force_unit(fit.rig)}")
