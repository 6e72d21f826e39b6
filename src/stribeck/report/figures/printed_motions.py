"""Motions as they are printed: one over its residual, many small ones, single slips, loops."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..contents.frame import Frame
from ..contents.motion_traces import MotionTraces, covers, stuck_slips
from ..contents.schema import MotionRecord
from ..format import abbreviated
from .motion_plots import (
    add_force,
    command_cut,
    finite,
    force_label,
    has_force,
    loop_view,
    motion_alt,
    motion_lines,
    position_label,
    quantity_label,
    residual_unit,
)
from .plot import Column, Line, Panel, Plot, Rule, View

#: Motions in a printed figure at most; of more, those with the greatest errors are shown.
MOST = 24
#: Slips printed, and how many there must be to be worth a figure.
SLIPS, FEWEST = 6, 3
#: Room above and below a slip, and above the residuals of many motions, as shares of their range.
_SLIP_ROOM, _RESIDUAL_ROOM = 0.2, 0.08


def motion_plot(frame: Frame, m: MotionRecord, title: str, remark: str = "") -> Plot:
    """A motion, its residual, and the force of the motor over time (figures 5 to 8, b and c).

    Args:
        frame: Of the fit.
        m: The motion.
        title: What stands above.
        remark: What stands above the residual; its RMS by default.
    """
    columns, lines = motion_lines(m, "dots" if frame.road == "simulation" else "line")
    unit = residual_unit(frame)
    columns |= {"residual_t": m.residual_t, "residual": m.residual}
    lines.append(Line("residual_t", "residual", "measured", "measured", "dots", panel=1, same=True))
    panels = [
        Panel(quantity_label(frame), 3.0),
        Panel(
            f"Residual / {unit}",
            1.5 if frame.road == "inverse" else 1.0,
            remark or f"RMS {m.rms or 0.0:.3g} {unit}",
        ),
    ]
    if has_force(frame, m):
        quantity = "torque" if frame.rotary else "force"
        heading = f"{quantity.capitalize()} exerted by the motor"
        if frame.applied:
            heading = f"Applied {quantity}, measured"
        add_force(frame, m, panels, columns, lines, 2.0, "dots", heading)
    view = View(title, motion_alt(frame, m), columns, lines, list(m.unscored),
                levels=[Rule(0.0, panel=1)], ranges=command_cut(m))  # fmt: skip
    height = 640 if len(panels) > 2 else 520  # noqa: PLR2004
    return Plot("", title, "Time / s", panels, [view], height)


def many_plot(records: Sequence[MotionRecord], title: str, quantity: str, length: str) -> Plot:
    """Each motion, measured and modelled, over a strip of its residual.

    Positions have a scale each; all strips have the same, so that errors can be compared.

    Args:
        records: The motions; of more than MOST, those with the greatest errors are drawn.
        title: Of the figure.
        quantity: Label of the upper diagrams.
        length: Its unit.
    """
    kept = sorted(range(len(records)), key=lambda k: -(records[k].rms or 0.0))[:MOST]
    drawn = [records[k] for k in sorted(kept)]
    if len(drawn) < len(records):
        title += f": the {MOST} of {len(records)} with the greatest errors"
    residuals = [finite(m.residual) for m in drawn]
    worst = max((float(np.abs(r).max()) for r in residuals if len(r)), default=0.0)
    edge = (1 + _RESIDUAL_ROOM) * worst or 1.0
    views = []
    for m in drawn:
        columns, lines = motion_lines(m, "line")
        columns |= {"residual_t": m.residual_t, "residual": m.residual}
        lines.append(Line("residual_t", "residual", "model", "residual", panel=1, same=True))
        views.append(
            View(
                abbreviated(m.label, 22), "", columns, lines,
                levels=[Rule(0.0, panel=1)], ranges={**command_cut(m), 1: (-edge, edge)},
                remark=f"RMS {m.rms or 0.0:.3g}",
            )
        )  # fmt: skip
    panels = [Panel(quantity, 3.0), Panel(f"residual / {length}, on one scale", 1.0)]
    return Plot("", title, "Time / s", panels, views)


def slips_plot(frame: Frame, motions: Sequence[MotionTraces]) -> Plot | None:
    """Some slips: the greatest of each of six groups in the order of time.

    None where there are too few to choose from.
    """
    slips = [
        (r, slip)
        for r in motions
        for slip in stuck_slips(r.log)
        if covers(r, float(r.log.t[slip.start]), float(r.log.t[slip.stop]))
    ]
    if len(slips) < FEWEST:
        return None
    groups = np.array_split(np.arange(len(slips)), min(SLIPS, len(slips)))
    chosen = [slips[max(group, key=lambda i: abs(slips[i][1].jump))] for group in groups]
    several = len({id(r.log) for r in motions}) > 1
    views = []
    for r, slip in chosen:
        start, stop = float(r.log.t[slip.start]), float(r.log.t[slip.stop])
        log = f"{abbreviated(r.log.label, 20)}, " if several else ""
        views.append(_slip_view(r, start, stop, f"{log}at {start:.4g} s"))
    title = f"{len(chosen)} of {len(slips)} slips from rest to rest"
    x = "Time since the axis broke away / s"
    return Plot("", title, x, [Panel(position_label(frame))], views)


def _slip_view(r: MotionTraces, start: float, stop: float, name: str) -> View:
    """A slip with as much time before and after it."""
    inside = np.flatnonzero(np.abs(2 * r.t - start - stop) <= 3 * (stop - start))
    rows = slice(inside[0], inside[-1] + 1)  # with the gaps
    columns: dict[str, Column] = {
        "t": (r.t[rows] - start).tolist(),
        "measured": r.measured[rows].tolist(),
        "model": r.model[rows].tolist(),
    }
    lines = [
        Line("t", "measured", "measured", "measured", "marks"),
        Line("t", "model", "model", "model"),
    ]
    if r.command is not None:
        columns["command"] = r.command[rows].tolist()
        lines.insert(0, Line("t", "command", "command", "command", "dashes"))
    reached = np.concatenate([r.measured[rows], r.model[rows]])
    low, high = float(np.nanmin(reached)), float(np.nanmax(reached))
    room = _SLIP_ROOM * (high - low)
    return View(name, "", columns, lines, ranges={0: (low - room, high + room)})


def applied_loops_plot(frame: Frame, records: Sequence[MotionRecord]) -> Plot:
    """The applied force against displacement, of the motions with the greatest errors."""
    worst = sorted(range(len(records)), key=lambda k: -(records[k].rms or 0.0))[:SLIPS]
    unit = frame.units.position
    views = []
    for m in (records[k] for k in sorted(worst)):
        name = abbreviated(m.label, 30)
        if len(worst) == 1:
            name = f"{abbreviated(m.label, 34)}: RMS {m.rms or 0.0:.3g} {unit}"
        views.append(loop_view(frame, m, name, "dots"))
    panel = Panel(force_label(frame, "applied"))
    return Plot("", views[0].name, position_label(frame), [panel], views, 460)
