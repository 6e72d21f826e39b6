"""Measured and modelled motions as figures: one log, many logs, single slips, presliding loops."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..motion_traces import Traces, stuck_slips, traces, whole
from .style import (
    COMMAND,
    INK,
    MEASURED,
    MODEL,
    force_unit,
    legend_above,
    short,
    shown,
    thinned,
    written,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from ...rig import Rig

__all__ = [
    "APART",
    "FEWEST",
    "MOST",
    "SLIPS",
    "Traces",
    "alone",
    "loops",
    "many",
    "named",
    "slips",
    "stuck_slips",
    "traces",
]

#: Motions that have a figure each; more share one.
APART = 3
#: Motions in a figure at most; of more, those with the greatest errors are shown.
MOST = 24
#: Slips shown, and how many there must be to be worth a figure.
SLIPS, FEWEST = 6, 3
#: Spans that a line of a large and of a small diagram is drawn by.
_FINE, _COARSE = 2000, 300
#: Room beside a line, as a share of its range; a command that goes so many times as far is cut.
_ROOM, _FAR = 0.1, 4.0


def named(rig: Rig) -> str:
    """The axis of positions."""
    return f"{'Angle' if rig.rotary else 'Displacement'} / {written(shown(rig, 'position'))}"


def alone(rig: Rig, on: Traces, title: str) -> Figure:
    """Displacement, its residual, and motor force against time (figures 5 to 8, b and c)."""
    figure = Figure(figsize=(7.2, 6.4), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, sharex=True, height_ratios=[3, 1, 2])
    if on.command is not None:
        top.plot(*thinned(on.t, on.command, _FINE), color=COMMAND, ls="--", lw=1.2, label="command")
    top.plot(on.t, on.measured, ".", color=MEASURED, rasterized=True, ms=2.5, label="measured")
    top.plot(*thinned(on.t, on.model, _FINE), color=MODEL, label="model")
    top.set(ylabel=named(rig), title=title)
    left = on.residual[on.scored]
    middle.plot(on.t[on.scored], left, ".", color=MEASURED, rasterized=True, ms=2)
    middle.axhline(0, color=INK, lw=0.8)
    length = written(shown(rig, "position"))
    middle.set(ylabel=f"Residual / {length}", title=f"RMS {on.rms:.3g} {length}")
    if not on.scored[0]:
        for axes in (top, middle, bottom):
            first = on.t[on.scored][0]
            axes.axvspan(on.t[0], first, color="#f1f4f6", zorder=0, label="not scored")
    _forces(rig, bottom, on)
    figure.align_ylabels((top, middle, bottom))
    legend_above(figure, top)
    return figure


def _forces(rig: Rig, axes: Axes, on: Traces) -> None:
    """What drives the axis: measured, and as the model has it, unless the one is the other."""
    if on.force is not None:
        axes.plot(on.t, on.force, ".", color=MEASURED, rasterized=True, ms=2.5)
    what = "torque" if rig.rotary else "force"
    if on.force_model is not None and not rig.applied_force:
        axes.plot(*thinned(on.t, on.force_model, _FINE), color=MODEL)
    axes.set(xlabel="Time / s")
    who = f"Applied {what}" if rig.applied_force else f"Motor {what}"
    axes.set(ylabel=f"{who} / {force_unit(rig)}")
    axes.set_title(
        f"{who}, measured" if rig.applied_force else f"{what.capitalize()} exerted by the motor"
    )


#: Inches: a small diagram with its strip of residuals, the room between and about them.
_WIDE, _HIGH, _STRIP, _GAP = 2.35, 1.45, 0.42, 0.08
_BETWEEN, _BELOW, _LEFT, _ABOVE, _FOOT, _RIGHT = 0.62, 0.62, 0.85, 0.78, 0.55, 0.15


def many(on: Sequence[Traces], title: str, quantity: str, length: str) -> Figure:
    """Small multiples: each motion, measured and modelled, over a strip of its residual.

    Positions have a scale each; all strips have the same, so that errors can be compared.

    Args:
        on: The motions; of more than MOST, those with the greatest errors are drawn.
        title: Of the figure.
        quantity: Label of the upper diagrams.
        length: Its unit.
    """
    kept = sorted(range(len(on)), key=lambda k: -on[k].rms)[:MOST]
    drawn = [on[k] for k in sorted(kept)]
    if len(drawn) < len(on):
        title += f": the {MOST} of {len(on)} with the greatest errors"
    across = 4 if len(drawn) > 6 else min(3, len(drawn))  # noqa: PLR2004 - a matter of taste
    down = -(-len(drawn) // across)
    cell = _HIGH + _GAP + _STRIP
    width = _LEFT + across * _WIDE + (across - 1) * _BETWEEN + _RIGHT
    height = _ABOVE + down * cell + (down - 1) * _BELOW + _FOOT
    figure = Figure(figsize=(width, height))
    worst = max(float(np.abs(r.residual[r.scored]).max()) for r in drawn)
    for k, r in enumerate(drawn):
        x = _LEFT + (k % across) * (_WIDE + _BETWEEN)
        y = height - _ABOVE - (k // across) * (cell + _BELOW) - cell
        place = (x / width, (y + _STRIP + _GAP) / height, _WIDE / width, _HIGH / height)
        top = figure.add_axes(place)
        strip = figure.add_axes((x / width, y / height, _WIDE / width, _STRIP / height), sharex=top)
        _small(top, strip, r)
        strip.set_ylim(-1.08 * worst, 1.08 * worst)
        strip.tick_params(labelleft=k % across == 0)
    figure.text(_LEFT / width, 1 - 0.14 / height, title, weight="bold", size=12, va="top")
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper right", ncols=3, fontsize=9.5,
                  bbox_to_anchor=(1 - _RIGHT / width, 1 - 0.02 / height))  # fmt: skip
    figure.text((_LEFT + 0.0) / width, 0.1 / height, "Time / s", size=10)
    above = f"{quantity}; below each: residual / {length}, on one scale"
    figure.text(0.14 / width, 0.5, above, size=10, rotation=90, va="center")
    return figure


def _small(top: Axes, strip: Axes, r: Traces) -> None:
    if r.command is not None:
        top.plot(*thinned(r.t, r.command, _COARSE), color=COMMAND, ls="--", lw=1, label="command")
    top.plot(*thinned(r.t, r.measured, _COARSE), color=MEASURED, lw=2.6, label="measured")
    top.plot(*thinned(r.t, r.model, _COARSE), color=MODEL, lw=1.1, label="model")
    left = np.where(r.scored, r.residual, np.nan)
    strip.plot(*thinned(r.t, left, _COARSE), color=MODEL, lw=0.9)
    strip.axhline(0, color=INK, lw=0.6)
    if r.command is not None:  # what was measured fills the diagram, however far a command goes
        reached = np.concatenate([r.measured, r.model])
        low, high = float(np.nanmin(reached)), float(np.nanmax(reached))
        room = _ROOM * max(high - low, 1e-12)
        low, high = low - room, high + room
        first, last = float(np.nanmin(r.command)) - room, float(np.nanmax(r.command)) + room
        if last - first <= _FAR * (high - low):
            low, high = min(low, first), max(high, last)
        top.set_ylim(low, high)
    name = short(r.label, 22)
    top.set_title(name, loc="left", fontsize=8.5, pad=4)
    top.set_title(f"RMS {r.rms:.3g}", loc="right", fontsize=8.5, fontweight="normal", pad=4)
    top.tick_params(labelbottom=False, labelsize=8)
    strip.tick_params(labelsize=8)
    top.yaxis.set_major_locator(MaxNLocator(4))
    strip.yaxis.set_major_locator(MaxNLocator(2, symmetric=True))
    top.xaxis.set_major_locator(MaxNLocator(5))


def slips(rig: Rig, on: Sequence[Traces]) -> Figure | None:
    """Some slips, drawn large: the greatest of each of six groups in the order of time.

    None where there are too few to choose from.
    """
    seen = [
        (k, slip)
        for k, r in enumerate(on)
        for slip in stuck_slips(r.log)
        if whole(r, float(r.log.t[slip.start]), float(r.log.t[slip.stop]))
    ]
    if len(seen) < FEWEST:
        return None
    groups = np.array_split(np.arange(len(seen)), min(SLIPS, len(seen)))
    picked = [seen[max(group, key=lambda i: abs(seen[i][1].jump))] for group in groups]
    across = 3
    figure = Figure(figsize=(8.4, 0.7 + 2.3 * -(-len(picked) // across)), layout="constrained")
    places = list(figure.subplots(-(-len(picked) // across), across, squeeze=False).flat)
    for axes, (k, slip) in zip(places, picked, strict=False):
        r = on[k]
        t0, t1 = float(r.log.t[slip.start]), float(r.log.t[slip.stop])
        about = np.flatnonzero(np.abs(2 * r.t - t0 - t1) <= 3 * (t1 - t0))
        near = slice(about[0], about[-1] + 1)  # with the gaps
        t = r.t[near] - t0
        if r.command is not None:
            axes.plot(t, r.command[near], color=COMMAND, ls="--", lw=1.2, label="command")
        axes.plot(t, r.measured[near], ".-", color=MEASURED, lw=0.8, ms=4, label="measured")
        axes.plot(t, r.model[near], color=MODEL, label="model")
        reached = np.concatenate([r.measured[near], r.model[near]])
        low, high = float(np.nanmin(reached)), float(np.nanmax(reached))
        axes.set_ylim(low - 0.2 * (high - low), high + 0.2 * (high - low))
        axes.set_title(f"{_log(on, r)}at {t0:.4g} s", fontsize=9)
        axes.tick_params(labelsize=8)
        axes.yaxis.set_major_locator(MaxNLocator(5))
    for axes in places[len(picked) :]:
        axes.remove()
    figure.supylabel(named(rig), fontsize=10)
    figure.supxlabel("Time since the axis broke away / s", fontsize=10)
    figure.suptitle(
        f"{len(picked)} of {len(seen)} slips", x=0.01, ha="left", fontsize=11, weight="bold"
    )
    legend_above(figure, places[0])
    return figure


def _log(on: Sequence[Traces], r: Traces) -> str:
    """The name of the log where there are several."""
    return "" if len({id(other.log) for other in on}) == 1 else f"{short(r.log.label, 20)}, "


def loops(rig: Rig, on: Sequence[Traces]) -> Figure:
    """The applied force against displacement: what bristles make a loop, measured and modelled."""
    drawn = sorted(range(len(on)), key=lambda k: -on[k].rms)[:SLIPS]
    across = min(3, len(drawn))
    down = -(-len(drawn) // across)
    size = (6.4, 4.6) if across == 1 else (2.0 + 2.9 * across, 1.0 + 2.6 * down)
    figure = Figure(figsize=size, layout="constrained")
    places = list(figure.subplots(down, across, squeeze=False).flat)
    for axes, k in zip(places, sorted(drawn), strict=False):
        r = on[k]
        assert r.force is not None  # noqa: S101 - such rigs are driven by it
        axes.plot(r.measured, r.force, ".", color=MEASURED, ms=3, rasterized=True, label="measured")
        axes.plot(r.model, r.force, color=MODEL, lw=1.2, label="model")
        axes.set_title(f"{short(r.label, 34)}: RMS {r.rms:.3g} {written(shown(rig, 'position'))}"
                       if across == 1 else short(r.label, 30))  # fmt: skip
        axes.set(xlabel=named(rig))
        axes.set(ylabel=f"Applied {'torque' if rig.rotary else 'force'} / {force_unit(rig)}")
    for axes in places[len(drawn) :]:
        axes.remove()
    legend_above(figure, places[0])
    return figure
