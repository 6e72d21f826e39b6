"""Measured and modelled motions, and loops of an applied force."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...space import Array
from ..contents.frame import Frame
from ..contents.schema import MotionRecord, Report
from ..format import number
from .plot import MIDDLE, TALL, Column, Group, Kind, Line, Panel, Plot, View

#: Motions that have a plot each; more share one.
APART = 3
#: A command that goes so many times as far as the axis is cut, with this much room beside the axis.
_FAR, _ROOM = 4.0, 0.08


def position_label(frame: Frame) -> str:
    """The axis of positions."""
    return f"{'Angle' if frame.rotary else 'Displacement'} / {frame.units.position}"


def force_label(frame: Frame, owner: str = "") -> str:
    """The axis of forces: the `motor`'s, or those `applied`."""
    quantity = "torque" if frame.rotary else "force"
    return f"{f'{owner} {quantity}'.strip().capitalize()} / {frame.units.force}"


def residual_unit(frame: Frame) -> str:
    """The unit of what the model leaves."""
    return frame.units.force if frame.road == "inverse" else frame.units.position


def part_name(m: MotionRecord) -> str:
    """What a motion is of, for people."""
    return "Training" if m.part == "training" else f"Held out {m.part}"


def finite(series: Column) -> Array:
    """What a series has, without its gaps."""
    return np.array([v for v in series if v is not None], dtype=float)


def extent(series: Column) -> float:
    """How far a series goes."""
    known = finite(series)
    return float(np.ptp(known)) if len(known) else 0.0


def fit_groups(report: Report) -> list[Group]:
    """Measured and modelled, each motion by itself if they are few."""
    plots = [_page_plots(Frame.of_report(report), m) for m in report.motions]
    if len(plots) <= APART:
        return [
            Group(f"fit-{k}", part_name(m), [_titled(p, f"fit-{k}", j) for j, p in enumerate(both)])
            for k, (m, both) in enumerate(zip(report.motions, plots, strict=True), 1)
        ]
    return [Group("fit", "Motion", together(plots, "fit"))] if plots else []


def _titled(plot: Plot, name: str, j: int) -> Plot:
    """A plot of one motion, called by it."""
    title = plot.views[0].name
    return replace(plot, id=f"{name}-{j}", title=f"{title}, {plot.title.lower()}" if j else title)


def together(plots: Sequence[Sequence[Plot]], name: str) -> list[Plot]:
    """Plots of the same kind as views of one; the panels are those of the fullest."""
    merged = []
    for j in range(len(plots[0])):
        full = max((kinds[j] for kinds in plots), key=lambda p: len(p.panels))
        views = [kinds[j].views[0] for kinds in plots]
        merged.append(replace(full, id=f"{name}-{j}", views=views))
    return merged


def _page_plots(frame: Frame, m: MotionRecord) -> list[Plot]:
    columns, lines = motion_lines(m, "line")
    panels = [Panel(quantity_label(frame), 3.0)]
    if m.velocity is not None:
        columns["velocity"] = m.velocity
        panels.append(Panel(f"Velocity / {frame.units.velocity}", 1.2))
        lines.append(Line("t", "velocity", "measured", "velocity", panel=1))
    if has_force(frame, m):
        add_force(frame, m, panels, columns, lines, 1.8, "line")
    name = f"{part_name(m)}: {m.label}"
    view = View(name, motion_alt(frame, m), columns, lines, list(m.unscored), ranges=command_cut(m))
    height = TALL if len(panels) > 1 else MIDDLE
    plots = [
        Plot("", "Measured and modelled", "Time / s", panels, [view], height, hover="x unified")
    ]
    if frame.applied and m.force is not None:
        force = force_label(frame, "applied")
        title = " against ".join(
            label.partition(" /")[0] for label in (force, position_label(frame).lower())
        )
        view = loop_view(frame, m, name)
        plots.append(Plot("", title, position_label(frame), [Panel(force)], [view]))
    return plots


def quantity_label(frame: Frame) -> str:
    """The axis of what is modelled: forces of a force balance, else positions."""
    return force_label(frame) if frame.road == "inverse" else position_label(frame)


def motion_lines(m: MotionRecord, kind: Kind) -> tuple[dict[str, Column], list[Line]]:
    """Command, measurement and model over time."""
    columns: dict[str, Column] = {"t": m.t, "measured": m.measured, "model": m.model}
    lines = [
        Line("t", "measured", "measured", "measured", kind, wide=True),
        Line("t", "model", "model", "model"),
    ]
    if m.command is not None:
        columns["command"] = m.command
        lines.insert(0, Line("t", "command", "command", "command", "dashes"))
    return columns, lines


def has_force(frame: Frame, m: MotionRecord) -> bool:
    """Whether there is a force to show over time."""
    return m.force is not None or (m.force_model is not None and not frame.applied)


def add_force(
    frame: Frame,
    m: MotionRecord,
    panels: list[Panel],
    columns: dict[str, Column],
    lines: list[Line],
    share: float,
    kind: Kind,
    title: str = "",
) -> None:
    """A panel of what drives the axis: measured, and of the model unless that is applied."""
    panel = len(panels)
    label = force_label(frame, "applied" if frame.applied else "motor")
    panels.append(Panel(label, share, title))
    if m.force is not None:
        columns["force"] = m.force
        lines.append(
            Line("t", "force", "measured", "measured", kind, panel=panel, same=True, wide=True)
        )
    if m.force_model is not None and not frame.applied:
        columns["force_model"] = m.force_model
        lines.append(Line("t", "force_model", "model", "model", panel=panel, same=True))


def motion_alt(frame: Frame, m: MotionRecord) -> str:
    """A motion in a sentence."""
    measured, residual, t = finite(m.measured), finite(m.residual), finite(m.t)
    unit = residual_unit(frame)
    quantity = "force" if frame.road == "inverse" else "angle" if frame.rotary else "position"
    text = (
        f"{part_name(m)}, {m.label}: over {number(float(np.ptp(t)), 4)} s the measured {quantity} "
        f"lies between {number(float(measured.min()), 4)} and {number(float(measured.max()), 4)} "
        f"{unit}"
    )
    if m.rms is None or not len(residual):
        return f"{text}."
    worst = float(np.abs(residual).max())
    return (
        f"{text}; the model is off by {number(m.rms, 3)} {unit} RMS, by {number(worst, 3)} {unit} "
        "at most."
    )


def command_cut(m: MotionRecord) -> dict[int, tuple[float, float]]:
    """Where a command goes far beyond the axis, the range of the axis."""
    reached = np.concatenate([finite(m.measured), finite(m.model)])
    wide, command = float(np.ptp(reached)), extent(m.command or [])
    if command <= _FAR * wide or wide == 0:
        return {}
    room = _ROOM * wide
    return {0: (float(reached.min()) - room, float(reached.max()) + room)}


def loop_view(frame: Frame, m: MotionRecord, name: str, kind: Kind = "line") -> View:
    """The applied force against displacement: what bristles make a loop."""
    unit = frame.units.position
    force = m.force or []
    alt = (
        f"{m.label}: the measured loop is {number(extent(m.measured), 3)} {unit} wide under "
        f"{number(extent(force), 3)} {frame.units.force} peak to peak, the model's "
        f"{number(extent(m.model), 3)} {unit}."
    )
    lines = [
        Line("measured", "force", "measured", "measured", kind, wide=True),
        Line("model", "force", "model", "model"),
    ]
    return View(name, alt, {"measured": m.measured, "model": m.model, "force": force}, lines)
