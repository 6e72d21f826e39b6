"""The plots of a fit's page, said in what they show: lines by role and kind, not by colour."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...space import Array
from ..terminal import number
from .plot import LOW, MIDDLE, SMALL, TALL, Group, Plot, View, line
from .schema import LogRecord, MotionRecord, ProfileRecord, Report, Series, SlipRecord

#: Motions that have a plot each; of more there is one plot, and a list to pick from.
APART = 3
#: A command that goes so many times as far as the axis is cut, with this much room about the rest.
_FAR, _ROOM = 4.0, 0.08
#: Places between two of a profile, and how high profiles are drawn, thresholds.
_BETWEEN, _HIGH = 8, 2.6
#: The correlation below which residuals count as unrelated.
_UNRELATED = 0.2


def log_group(report: Report) -> Group | None:
    """The logs as measured: strokes, rests and slips; None where none of them moves."""
    seen = [log for log in report.logs if log.strokes or log.rests]
    if not seen:
        return None
    views = [_log_view(log, report) for log in seen]
    plot = Plot("log-plot", "Stick and slip", "Time / s", [(_position(report), 1.0)], views)
    return Group("log", "Log", [plot])


def _log_view(log: LogRecord, report: Report) -> View:
    length, speed = report.units.position, report.units.velocity
    columns: dict[str, Any] = {"t": log.t, "x": log.position}
    lines = [line("t", "x", "measured", name="measured", wide=True)]
    if log.command is not None:
        columns["command"] = log.command
        lines.insert(0, line("t", "command", "command", kind="dashes", name="command"))
    if log.rests:
        columns["rest_t"], columns["rest_x"] = _chain(
            [((r.start, r.stop), (r.level, r.level)) for r in log.rests]
        )
        lines.append(line("rest_t", "rest_x", "ink", name="rest", wide=True))
    if log.strokes:
        at = [0.5 * (s.start + s.stop) for s in log.strokes]
        columns["stroke_t"], columns["stroke_x"] = at, _read(log, at)
        told = [
            f"stroke {k}: {'up' if s.direction > 0 else 'down'}\n"
            f"{s.start:.5g} to {s.stop:.5g} s\n"
            f"{number(s.travel, 4)} {length} at {number(s.speed, 3)} {speed}"
            for k, s in enumerate(log.strokes, 1)
        ]
        ways = ["triangle-up" if s.direction > 0 else "triangle-down" for s in log.strokes]
        lines.append(
            line("stroke_t", "stroke_x", "accent", kind="points", name="stroke", hover=told,
                 symbols=ways)
        )  # fmt: skip
    if log.slips:
        columns["slip_t"], columns["slip_x"] = _chain(
            [((s.start, s.stop), (s.begin, s.end)) for s in log.slips]
        )
        columns["middle_t"] = [0.5 * (s.start + s.stop) for s in log.slips]
        columns["middle_x"] = [0.5 * (s.begin + s.end) for s in log.slips]
        lines.append(line("slip_t", "slip_x", "model", name="slip", silent=True))
        told = [_slip(k, s, report) for k, s in enumerate(log.slips, 1)]
        lines.append(
            line("middle_t", "middle_x", "model", kind="points", name="slip", hover=told, same=True)
        )
    return View(log.label, _log_alt(log, report), columns, lines)


def _slip(k: int, s: SlipRecord, report: Report) -> str:
    return (
        f"slip {k}: starts at {s.start:.5g} s\njump {number(s.jump, 4)} {report.units.position} in "
        f"{number(s.stop - s.start, 3)} s\ngreatest speed {number(s.speed, 3)} "
        f"{report.units.velocity}"
    )


def _log_alt(log: LogRecord, report: Report) -> str:
    def count(n: int, what: str) -> str:
        return f"{n or 'no'} {what}{'s' * (n != 1)}"

    parts = [count(len(log.strokes), "stroke"), count(len(log.rests), "rest")]
    said = f"{', '.join(parts)} and {count(len(log.slips), 'slip')}"
    if log.slips:
        jump = float(np.median([abs(s.jump) for s in log.slips]))
        lasting = float(np.median([s.stop - s.start for s in log.slips]))
        said += f", the median slip {number(jump, 3)} {report.units.position} in {lasting:.3g} s"
    return f"{log.label}: {said}."


def _chain(parts: Sequence[tuple[tuple[float, float], tuple[float, float]]]) -> tuple[Any, Any]:
    """Short lines as one with gaps."""
    x = [v for (a, b), _ in parts for v in (a, b, None)]
    y = [v for _, (a, b) in parts for v in (a, b, None)]
    return x, y


def _read(log: LogRecord, at: Sequence[float]) -> list[float]:
    """The position at some times."""
    good = [(t, x) for t, x in zip(log.t, log.position, strict=True) if None not in {t, x}]
    t, x = np.array(good, dtype=float).T
    found: list[float] = np.interp(at, t, x).tolist()
    return found


def _position(report: Report) -> str:
    return f"{'Angle' if report.rotary else 'Displacement'} / {report.units.position}"


def _force(report: Report, who: str) -> str:
    what = "torque" if report.rotary else "force"
    return f"{f'{who} {what}'.strip().capitalize()} / {report.units.force}"


def part_of(m: MotionRecord) -> str:
    """What a motion is of, for people."""
    return "Training" if m.part == "training" else f"Held out {m.part}"


def fit_groups(report: Report) -> list[Group]:
    """Measured and modelled, each motion by itself if they are few."""
    plots = [_fit_plots(report, m) for m in report.motions]
    if len(plots) <= APART:
        return [
            Group(f"fit-{k}", part_of(m), [_own(p, f"fit-{k}", j) for j, p in enumerate(made)])
            for k, (m, made) in enumerate(zip(report.motions, plots, strict=True), 1)
        ]
    return [Group("fit", "Motion", _together(plots, "fit"))] if plots else []


def _own(plot: Plot, name: str, j: int) -> Plot:
    """A plot of one motion, called by it."""
    title = plot.views[0].name
    return replace(plot, id=f"{name}-{j}", title=f"{title}, {plot.title.lower()}" if j else title)


def _together(plots: Sequence[Sequence[Plot]], name: str) -> list[Plot]:
    """Plots of the same kind as views of one; the panels are those of the fullest."""
    made = []
    for j in range(len(plots[0])):
        full = max((own[j] for own in plots), key=lambda p: len(p.panels))
        views = [own[j].views[0] for own in plots]
        made.append(replace(full, id=f"{name}-{j}", views=views))
    return made


def _fit_plots(report: Report, m: MotionRecord) -> list[Plot]:
    columns: dict[str, Any] = {"t": m.t, "measured": m.measured, "model": m.model}
    lines = [
        line("t", "measured", "measured", name="measured", wide=True),
        line("t", "model", "model", name="model"),
    ]
    balance = report.road == "inverse"
    panels = [(_force(report, "") if balance else _position(report), 3.0)]
    ranges = {}
    if m.command is not None:
        columns["command"] = m.command
        lines.insert(0, line("t", "command", "command", kind="dashes", name="command"))
        ranges = _cut(m)
    if m.velocity is not None:
        columns["velocity"] = m.velocity
        panels.append((f"Velocity / {report.units.velocity}", 1.2))
        lines.append(line("t", "velocity", "measured", panel=1, name="velocity"))
    if m.force is not None or (m.force_model is not None and not report.applied):
        panels.append((_force(report, "applied" if report.applied else "motor"), 1.8))
        if m.force is not None:
            columns["force"] = m.force
            lines.append(
                line("t", "force", "measured", panel=1, name="measured", same=True, wide=True)
            )
        if m.force_model is not None and not report.applied:
            columns["force_model"] = m.force_model
            lines.append(line("t", "force_model", "model", panel=1, name="model", same=True))
    name = f"{part_of(m)}: {m.label}"
    view = View(name, _fit_alt(report, m), columns, lines, list(m.unscored), ranges=ranges)
    height = TALL if len(panels) > 1 else MIDDLE
    title = "Measured and modelled"
    made = [Plot("", title, "Time / s", panels, [view], height, hover="x unified")]
    if report.applied and m.force is not None:
        loop = [
            line("measured", "force", "measured", name="measured", wide=True),
            line("model", "force", "model", name="model"),
        ]
        unit = report.units.position
        width = _span(m.measured)
        alt = (
            f"{m.label}: the measured loop is {number(width, 3)} {unit} wide under "
            f"{number(_span(m.force), 3)} {report.units.force} peak to peak, the model's "
            f"{number(_span(m.model), 3)} {unit}."
        )
        kept = {n: columns[n] for n in ("measured", "model", "force")}
        title = " against ".join(
            said.partition(" /")[0]
            for said in (_force(report, "applied"), _position(report).lower())
        )
        made.append(
            Plot("", title, _position(report), [(_force(report, "applied"), 1.0)],
                 [View(name, alt, kept, loop)])
        )  # fmt: skip
    return made


def _fit_alt(report: Report, m: MotionRecord) -> str:
    seen, left = values(m.measured), values(m.residual)
    t = values(m.t)
    unit = report.units.force if report.road == "inverse" else report.units.position
    what = "force" if report.road == "inverse" else "angle" if report.rotary else "position"
    said = (
        f"{part_of(m)}, {m.label}: over {number(float(np.ptp(t)), 4)} s the measured {what} lies "
        f"between {number(float(seen.min()), 4)} and {number(float(seen.max()), 4)} {unit}"
    )
    if m.rms is None or not len(left):
        return f"{said}."
    worst = float(np.abs(left).max())
    return (
        f"{said}; the model is off by {number(m.rms, 3)} {unit} RMS, by {number(worst, 3)} {unit} "
        "at most."
    )


def _cut(m: MotionRecord) -> dict[int, tuple[float, float]]:
    """Where a command goes far beyond the axis, the range of the axis."""
    seen = np.concatenate([values(m.measured), values(m.model)])
    wide, command = float(np.ptp(seen)), _span(m.command or [])
    if command <= _FAR * wide or wide == 0:
        return {}
    room = _ROOM * wide
    return {0: (float(seen.min()) - room, float(seen.max()) + room)}


def _span(series: Series) -> float:
    seen = values(series)
    return float(np.ptp(seen)) if len(seen) else 0.0


def values(series: Series) -> Array:
    """What a series has, without its gaps."""
    return np.array([v for v in series if v is not None], dtype=float)


def residual_group(report: Report) -> Group | None:
    """What the model leaves: in time, in frequency, against itself."""
    plots = [_residual_plots(report, m) for m in report.motions if values(m.residual).size]
    if not plots:
        return None
    together = _together(plots, "residual")
    drawn = [p for p in together if any(values(v.columns["y"]).size for v in p.views)]
    return Group("residual", "Residual of", drawn)


def _residual_plots(report: Report, m: MotionRecord) -> list[Plot]:
    unit = report.units.force if report.road == "inverse" else report.units.position
    name, left = f"{part_of(m)}: {m.label}", values(m.residual)
    t = values(m.residual_t)
    k = int(np.abs(left).argmax())
    alt = (
        f"{name}: RMS {number(m.rms or 0.0, 3)} {unit}; the largest error, "
        f"{number(float(left[k]), 3)} {unit}, is at {number(float(t[min(k, len(t) - 1)]), 5)} s."
    )
    zero = [{"y": 0.0, "role": "ink"}]
    in_time = View(name, alt, {"x": m.residual_t, "y": m.residual},
                   [line("x", "y", "measured", name="measured − model")], levels=zero)  # fmt: skip
    f, density = values(m.frequency), values(m.density)
    good = density > 0
    f, density = f[good], density[good]
    in_frequency, own = _empty(name), _empty(name)
    if len(f):
        share = np.cumsum(density) / density.sum()
        half = float(f[np.searchsorted(share, 0.5)])
        level = float(density.sum() * (f[1] - f[0]) / (f[-1])) if len(f) > 1 else float(density[0])
        alt = (
            f"{name}: half of the residual's power lies below {number(half, 3)} Hz, of up to "
            f"{number(float(f[-1]), 4)} Hz; the dashed line is white noise of the same power."
        )
        columns = {"x": f.tolist(), "y": density.tolist(),
                   "white_x": [float(f[0]), float(f[-1])], "white_y": [level, level]}  # fmt: skip
        lines = [
            line("x", "y", "model", name="residual"),
            line("white_x", "white_y", "ink", kind="dashes", name="white noise"),
        ]
        in_frequency = View(name, alt, columns, lines)
    lag, correlation = values(m.lag), values(m.correlation)
    if len(lag) > 1 and m.counted:
        below = np.flatnonzero(correlation < _UNRELATED)
        edge = 1.96 / np.sqrt(m.counted)
        until = (
            f"falls below {_UNRELATED:g} after {number(float(lag[below[0]]), 3)} s"
            if len(below)
            else f"stays above {_UNRELATED:g} as far as it is shown"
        )
        alt = (
            f"{name}: the correlation of the residual with itself {until}; of white noise 95 % "
            f"would lie within ±{edge:.2g}."
        )
        own = View(name, alt, {"x": m.lag, "y": m.correlation},
                   [line("x", "y", "model", name="residual")],
                   levels=[*zero, *({"y": s * edge, "role": "ink", "dash": True}
                                    for s in (-1.0, 1.0))])  # fmt: skip
    return [
        Plot("", "Residual in time", "Time / s", [(f"Residual / {unit}", 1.0)], [in_time], LOW),
        Plot("", "Residual in frequency", "Frequency / Hz",
             [(f"Density / ({unit})² Hz⁻¹", 1.0)], [in_frequency], LOW, log=True),
        Plot("", "Residual against itself", "Lag / s", [("Autocorrelation", 1.0)], [own], LOW),
    ]  # fmt: skip


def _empty(name: str) -> View:
    return View(name, "The residual is too short for this.", {"x": [], "y": []}, [])


def friction_groups(report: Report) -> list[Group]:
    """The law: its curve with band and cloud, its loops, its levels under load."""
    law, made = report.law, []
    columns: dict[str, Any] = {"v": law.cloud_velocity, "F": law.cloud_friction}
    lines = []
    for k, side in enumerate(law.curve):
        names = [f"{what}_{k}" for what in ("v", "F", "low", "high")]
        columns |= {names[0]: side.velocity, names[1]: side.friction}
        if side.low is not None and side.high is not None:
            columns |= {names[2]: side.low, names[3]: side.high}
            lines.append(
                line(names[0], names[3], "model", kind="band", low=names[2], name="95 % band",
                     same=k > 0)
            )  # fmt: skip
    if values(law.cloud_velocity).size:
        said = "measured force less inertia and offset"
        if report.road == "simulation":
            said = "what the measured motion implies"
        lines.append(line("v", "F", "measured", kind="dots", name=said))
    lines += [
        line(f"v_{k}", f"F_{k}", "model", name=f"law: {report.card.law}", same=k > 0, wide=True)
        for k in range(len(law.curve))
    ]
    axes = [{"y": 0.0, "role": "ink"}]
    view = View("curve", _curve_alt(report), columns, lines, levels=axes,
                verticals=[{"x": 0.0, "role": "ink"}])  # fmt: skip
    title = "Steady sliding" if law.loops else "Friction against velocity"
    speed, force = f"Velocity / {report.units.velocity}", f"Friction / {report.units.force}"
    if law.loads:
        title += ", without load"
    plots = [Plot("friction-curve", title, speed, [(force, 1.0)], [view], 440)]
    if law.loops:
        plots.append(_loops_plot(report, force))
    if law.loads:
        plots.append(_loads_plot(report, force))
    made += [Group(p.id, p.title, [p]) for p in plots]
    return made


def _loops_plot(report: Report, force: str) -> Plot:
    law, unit = report.law, report.units.position
    columns: dict[str, Any] = {}
    lines = []
    for k, curve in enumerate(law.loops):
        columns |= {f"x{k}": curve.x, f"y{k}": curve.y}
        lines.append(line(f"x{k}", f"y{k}", ("model", "accent")[k % 2], name=curve.name))
    greatest = float(np.abs(values(law.loops[0].y)).max())
    alt = (
        f"Slow strokes over {number(_span(law.loops[0].x), 3)} {unit} at "
        f"{number(law.pace or 0.0, 2)} {unit}/s reach ±{number(greatest, 4)} {report.units.force}."
    )
    return Plot("friction-loops", "Slow strokes to and fro", _position(report), [(force, 1.0)],
                [View("loops", alt, columns, lines)])  # fmt: skip


def _loads_plot(report: Report, force: str) -> Plot:
    law = report.law
    columns: dict[str, Any] = {}
    lines = []
    for k, curve in enumerate(law.loads):
        columns |= {f"x{k}": curve.x, f"y{k}": curve.y}
        still = curve.name.endswith("at rest")
        lines.append(
            line(f"x{k}", f"y{k}", f"repeat{k}", kind="line" if still else "dashes",
                 name=curve.name)
        )  # fmt: skip
    said = "; ".join(
        f"{c.name}, from {number(values(c.y)[0], 3)} to {number(values(c.y)[-1], 3)}"
        for c in law.loads
    )
    most = values(law.loads[0].x)[-1]
    unit = law.load.partition(" / ")[2]
    grown = f"{number(most, 3)} {unit}".rstrip()
    alt = f"Friction in {report.units.force} as the load grows to {grown}: {said}."
    return Plot("friction-loads", "Friction against load", law.load, [(force, 1.0)],
                [View("loads", alt, columns, lines)])  # fmt: skip


def _curve_alt(report: Report) -> str:
    law, force = report.law, report.units.force
    said = []
    for side in law.curve:
        v, F = values(side.velocity), values(side.friction)
        ends = ""
        if side.low is not None and side.high is not None:
            low, high = values(side.low)[-1], values(side.high)[-1]
            ends = f" (95 % from {number(low, 4)} to {number(high, 4)})"
        said.append(
            f"{number(F[0], 4)} {force} next to rest and {number(F[-1], 4)} {force}{ends} at "
            f"{number(v[-1], 3)} {report.units.velocity}"
        )
    return f"Friction of the identified law is {'; '.join(said)}."


def profile_groups(report: Report) -> list[Group]:
    """One small plot for each parameter."""
    return [_profile(k, p) for k, p in enumerate(report.profiles, 1) if len(p.values) > 1]


def _profile(k: int, p: ProfileRecord) -> Group:
    at, rises = values(p.values), values(p.rises)
    fine = np.unique(np.concatenate([
        np.linspace(a, b, _BETWEEN, endpoint=False)
        for a, b in itertools.pairwise(at)
    ] + [at[-1:]]))  # fmt: skip
    roots = np.interp(fine, at, np.sqrt(np.maximum(rises, 0.0)))
    columns = {
        "x": [float(f"{x:.7g}") for x in fine],
        "y": [float(f"{z * z:.4g}") for z in roots],
        "at": p.values,
        "rise": p.rises,
    }
    lines = [
        line("x", "y", "model", name=p.name, silent=True),
        line("at", "rise", "model", kind="points", name="refitted", small=True),
    ]
    ends = [{"x": x, "role": "accent", "dash": True} for x in (p.low, p.high) if x is not None]
    unit = f" {p.unit}".rstrip()
    low, high = (number(np.nan if x is None else x, 4) for x in (p.low, p.high))
    alt = f"{p.name} = {number(p.value)}{unit}, 95 % from {low} to {high}{unit}."
    high_end = min(max(float(rises.max()) * 1.08, 1.3), _HIGH)
    view = View(p.name, alt, columns, lines,
                levels=[{"y": 1.0, "role": "ink", "dash": True}],
                verticals=[{"x": p.value, "role": "ink"}, *ends],
                ranges={0: (-0.05 * high_end, high_end)})  # fmt: skip
    axis = f"{p.name} / {p.unit}" if p.unit else p.name
    plot = Plot(f"profile-{k}", p.name, axis, [("Rise / threshold", 1.0)], [view], SMALL)
    return Group(f"profile-group-{k}", p.name, [plot])


def convergence_group(report: Report) -> Group | None:
    """The best misfit against evaluations, a line a repeat."""
    runs = [run for run in report.runs if run.at]
    if not runs:
        return None
    columns: dict[str, Any] = {}
    lines = []
    unit = report.card.objective.unit
    for k, run in enumerate(runs):
        best = values(run.best)
        columns |= {f"x{k}": [*run.at, run.evaluations], f"y{k}": [*best.tolist(), best[-1]]}
        role = f"repeat{k % 6}"
        lines.append(line(f"x{k}", f"y{k}", role, kind="steps", name=f"repeat {k + 1}"))
        if run.polishing and run.cost is not None:
            columns |= {f"end_x{k}": [run.evaluations + run.polishing], f"end_y{k}": [run.cost]}
            lines.append(
                line(f"end_x{k}", f"end_y{k}", role, kind="points", name="polished", same=True)
            )
    smooth = report.card.objective.baselines.get("smooth")
    levels = []
    if smooth is not None and smooth > 0:
        levels = [{"y": smooth, "role": "ink", "dash": True, "name": "best smooth motion"}]
    ends = ", ".join(
        f"repeat {k} ended at {number(run.cost if run.cost is not None else np.nan, 4)} {unit} "
        f"after {run.evaluations + run.polishing:,}"
        for k, run in enumerate(runs[:6], 1)
    )
    alt = f"Best misfit against evaluations: {ends}."
    plot = Plot("convergence-plot", "Convergence", "Evaluations", [(f"Best misfit / {unit}", 1.0)],
                [View("convergence", alt, columns, lines, levels=levels)], log=True)  # fmt: skip
    return Group("convergence-group", "Convergence", [plot])
