"""The identified law: its curve with band and cloud, its loops, its levels under load."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...data.steady_runs import MOST
from ...units import unit
from ..contents.frame import Frame
from ..contents.law_curve import friction_under, greatest_load, law_parameters, loads
from ..contents.schema import LawRecord, Report
from ..format import number
from .motion_plots import extent, finite, position_label
from .plot import Column, Group, Kind, Line, Note, Panel, Plot, Rule, View

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...identify.result import Fit

#: A level below this share of a figure's range is next to its axis.
_LOW = 0.12
#: Room above and below the curve for the names of its levels, as a share of its range.
_ROOM = 0.15
#: The speeds of a curve under load.
_SPEEDS = 300


# --- on the page and in print --------------------------------------------------------------------


def curve_plot(frame: Frame, law: LawRecord, title: str, *, cloud: bool = True) -> Plot:
    """Friction against velocity: the law, its band, and what the measurements imply (figure 9).

    Args:
        frame: Of the fit.
        law: What is drawn of it.
        title: What stands above.
        cloud: Whether what the measurements imply is shown too.
    """
    columns: dict[str, Column] = {}
    bands: list[Line] = []
    curves: list[Line] = []
    name = f"law: {frame.law}"
    for k, side in enumerate(law.curve):
        v, F, low, high = (f"{column}_{k}" for column in ("v", "F", "low", "high"))
        columns |= {v: side.velocity, F: side.friction}
        if side.low is not None and side.high is not None:
            columns |= {low: side.low, high: side.high}
            bands.append(Line(v, high, "model", "95 % band", "band", low=low, same=k > 0))
        if side.seen:
            curves.append(Line(v, F, "model", name, same=len(curves) > 0, wide=True))
        else:
            curves.append(Line(v, F, "model", f"{name}, not seen this way", "dashes"))
    clouds = []
    if cloud and finite(law.cloud_velocity).size:
        columns |= {"v": law.cloud_velocity, "F": law.cloud_friction}
        source = "measured force less inertia and offset"
        if frame.road == "simulation":
            source = "what the measured motion implies"
        kind: Kind = "dots" if len(law.cloud_velocity) > MOST else "points"
        clouds = [Line("v", "F", "measured", source, kind)]
    lines = [*bands, *clouds, *curves]
    if clouds and clouds[0].kind == "points":
        lines = [*bands, *curves, *clouds]
    view = View("curve", _curve_alt(frame, law), columns, lines,
                levels=[Rule(0.0)], verticals=[Rule(0.0)])  # fmt: skip
    speed = f"Velocity / {frame.units.velocity}"
    return Plot("friction-curve", title, speed, [Panel(_force(frame))], [view], 440)


def loops_plot(frame: Frame, law: LawRecord) -> Plot:
    """The loops of slow strokes to and fro, of a law with states."""
    length = frame.units.position
    columns: dict[str, Column] = {}
    lines = []
    for k, curve in enumerate(law.loops):
        columns |= {f"x{k}": curve.x, f"y{k}": curve.y}
        lines.append(Line(f"x{k}", f"y{k}", ("model", "accent")[k % 2], curve.name))
    greatest = float(np.abs(finite(law.loops[0].y)).max())
    alt = (
        f"Slow strokes over {number(extent(law.loops[0].x), 3)} {length} at "
        f"{number(law.pace or 0.0, 2)} {length}/s reach ±{number(greatest, 4)} "
        f"{frame.units.force}."
    )
    return Plot("friction-loops", "Slow strokes to and fro", position_label(frame),
                [Panel(_force(frame))], [View("loops", alt, columns, lines)])  # fmt: skip


def loads_plot(frame: Frame, law: LawRecord) -> Plot:
    """Friction against load, at rest and at speed."""
    columns: dict[str, Column] = {}
    lines = []
    for k, curve in enumerate(law.loads):
        columns |= {f"x{k}": curve.x, f"y{k}": curve.y}
        kind: Kind = "line" if curve.name.endswith("at rest") else "dashes"
        lines.append(Line(f"x{k}", f"y{k}", f"repeat{k}", curve.name, kind))
    ends = "; ".join(
        f"{c.name}, from {number(finite(c.y)[0], 3)} to {number(finite(c.y)[-1], 3)}"
        for c in law.loads
    )
    most = finite(law.loads[0].x)[-1]
    greatest = f"{number(most, 3)} {law.load.partition(' / ')[2]}".rstrip()
    alt = f"Friction in {frame.units.force} as the load grows to {greatest}: {ends}."
    return Plot("friction-loads", "Friction against load", law.load, [Panel(_force(frame))],
                [View("loads", alt, columns, lines)])  # fmt: skip


def friction_groups(report: Report) -> list[Group]:
    """The law on the page: its curve, its loops, its levels under load."""
    frame, law = Frame.of_report(report), report.law
    title = "Steady sliding" if law.loops else "Friction against velocity"
    if law.loads:
        title += ", without load"
    plots = [curve_plot(frame, law, title)]
    if law.loops:
        plots.append(loops_plot(frame, law))
    if law.loads:
        plots.append(loads_plot(frame, law))
    return [Group(p.id, p.title, [p]) for p in plots]


def _force(frame: Frame) -> str:
    return f"Friction / {frame.units.force}"


def _curve_alt(frame: Frame, law: LawRecord) -> str:
    force = frame.units.force
    sides = []
    for side in law.curve:
        v, F = finite(side.velocity), finite(side.friction)
        ends = ""
        if side.low is not None and side.high is not None:
            low, high = finite(side.low)[-1], finite(side.high)[-1]
            ends = f" (95 % from {number(low, 4)} to {number(high, 4)})"
        ends += "" if side.seen else ", which no training data have seen"
        sides.append(
            f"{number(F[0], 4)} {force} next to rest and {number(F[-1], 4)} {force}{ends} at "
            f"{number(v[-1], 3)} {frame.units.velocity}"
        )
    return f"Friction of the identified law is {'; '.join(sides)}."


# --- in print ------------------------------------------------------------------------------------


def near_rest(fit: Fit, fast: float) -> float:
    """As far as a curve shows its levels and their crossover, m/s (rad/s).

    Args:
        fit: The fit.
        fast: The greatest speed of the data.
    """
    p = dict(zip(fit.law.names, law_parameters(fit), strict=True))
    v_SS = max((p[n] for n in p if n.startswith("v_SS")), default=None)
    return fast if v_SS is None else min(max(8 * v_SS, 0.05 * fast), max(fast, v_SS))


def levels_plot(fit: Fit, frame: Frame, law: LawRecord) -> Plot:
    """The law next to rest, with its levels and its viscous line named (figure 4)."""
    plot = curve_plot(frame, law, f"{fit.law.name}: the identified curve", cloud=False)
    (view,) = plot.views
    columns = dict(view.columns)
    lines = [line for line in view.lines if line.kind != "band"]  # it may be wider than all levels
    p = law_parameters(fit)
    named = dict(zip(fit.law.names, p, strict=True))
    static = any(n.startswith("v_SS") for n in named)
    force = fit.rig.si_unit("force")
    scale = unit(fit.rig.unit_shown("velocity")).factor
    if fit.law.directional:
        plus = law.curve[0]
        v = finite(plus.velocity)
        columns |= {"mirror_v": (-v).tolist(),
                    "mirror_F": (-fit.law.friction(v * scale, p)).tolist()}  # fmt: skip
        mirror = Line("mirror_v", "mirror_F", "measured", "the + side, mirrored", "dashes")
        lines.append(mirror)
    minus_level, plus_level = fit.law.levels(p)
    columns |= {"rest_v": [0.0, 0.0], "rest_F": [float(minus_level), float(plus_level)]}
    lines.append(Line("rest_v", "rest_F", "model", "levels at rest", "rings", same=True))
    span = max(float(np.abs(finite(side.friction)).max()) for side in law.curve)
    notes = []
    for side, level, way in zip(law.curve, (plus_level, minus_level), (1, -1), strict=False):
        sign = "+" if way > 0 else "-"
        F_C = named.get("F_C", named.get(f"F_C{sign}", np.nan)) if static else np.nan
        F_V = named.get("F_V", named.get(f"F_V{sign}", np.nan))
        low = _LOW * span > F_C  # its name would lie on the axis, were it below its level
        if level:
            name = f"F_{{S{sign}}} =" if static else "breakaway"
            away = 13 if low and abs(level) - F_C < _LOW * span else 0
            notes.append(_level_note(f"{name} {level:.4g} {force}", level, way, "model", away=away))
        if np.isfinite(F_C + F_V):
            far = finite(side.velocity)[-1]
            columns |= {f"line_v{sign}": [0.0, far],
                        f"line_F{sign}": [way * F_C, way * F_C + F_V * far * scale]}  # fmt: skip
            lines.append(
                Line(f"line_v{sign}", f"line_F{sign}", "accent", "viscous", "dotted", same=True)
            )
            text = f"F_C = {F_C:.4g} {force}, slope F_V"
            notes.append(_level_note(text, way * F_C, way, "accent", outside=low))
    reached = np.concatenate([finite(columns[line.y]) for line in lines])
    least, most = float(reached.min()), float(reached.max())
    room = _ROOM * (most - least)
    shown = View(view.name, view.alt, columns, lines, levels=view.levels, verticals=view.verticals,
                 ranges={0: (least - room, most + room)}, notes=notes)  # fmt: skip
    return Plot("", plot.title, plot.x, plot.panels, [shown], 420)


def _level_note(
    text: str, level: float, way: int, role: str, *, outside: bool = True, away: float = 0.0
) -> Note:
    """The name of a level beside the axis, where no law has its curve: upper left, lower right.

    Args:
        text: The name.
        level: The level.
        way: +1 for v > 0, −1 for v < 0.
        role: What it is drawn as.
        outside: Whether it stands on the far side of its level, seen from zero.
        away: By how much farther, CSS pixels.
    """
    above = outside == (way > 0)
    return Note(0.0, float(level), text, role, "left" if way > 0 else "right", above, away)


def load_curves_plot(fit: Fit, frame: Frame, fast: float) -> Plot:
    """The curve of a law under no load, half and all of the greatest load of the data."""
    p, most = law_parameters(fit), greatest_load(fit)
    scale = unit(fit.rig.unit_shown("velocity")).factor
    normal = "normal" in fit.law.loads
    v = np.concatenate([[0.0], fast * np.geomspace(1e-4, 1.0, _SPEEDS)])
    way = next(iter(loads(fit.law).values()))
    columns: dict[str, Column] = {"v": (v / scale).tolist()}
    lines, notes = [], []
    for k, (share, role) in enumerate(((0.0, "measured"), (0.5, "accent"), (1.0, "model"))):
        F = [friction_under(fit.law, p, s, way, share * most) for s in v]
        size = f"{share * most:.3g} {'' if normal else fit.rig.si_unit('force')}".strip()
        name = size if share else "no load"
        columns[f"F{k}"] = F
        lines.append(Line("v", f"F{k}", role, name, same=True))
        notes.append(Note(float(v[-1] / scale), F[-1], name, role, "left", above=True))
    view = View("curves", "", columns, lines, ranges=_from_zero(columns, lines), notes=notes)
    title = "Curve" if normal else "Curve, motor against load"
    x = f"Velocity / {frame.units.velocity}"
    return Plot("", title, x, [Panel(_force(frame))], [view], 460)


def _from_zero(columns: dict[str, Column], lines: Sequence[Line]) -> dict[int, tuple[float, float]]:
    most = max(float(finite(columns[line.y]).max()) for line in lines)
    return {0: (0.0, 1.08 * most)} if most > 0 else {}
