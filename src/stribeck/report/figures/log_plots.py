"""The logs as measured: strokes, rests and slips."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..contents.frame import Frame
from ..contents.schema import LogRecord, Report, SlipRecord
from ..format import number
from .motion_plots import position_label
from .plot import Column, Group, Line, Panel, Plot, View


def log_group(report: Report) -> Group | None:
    """The logs as measured; None where none of them moves."""
    moving = [log for log in report.logs if log.strokes or log.rests]
    if not moving:
        return None
    frame = Frame.of_report(report)
    views = [_view(log, frame) for log in moving]
    plot = Plot("log-plot", "Stick and slip", "Time / s", [Panel(position_label(frame))], views)
    return Group("log", "Log", [plot])


def _view(log: LogRecord, frame: Frame) -> View:
    length, speed = frame.units.position, frame.units.velocity
    columns: dict[str, Column] = {"t": log.t, "x": log.position}
    lines = [Line("t", "x", "measured", "measured", wide=True)]
    if log.command is not None:
        columns["command"] = log.command
        lines.insert(0, Line("t", "command", "command", "command", "dashes"))
    if log.rests:
        columns["rest_t"], columns["rest_x"] = _chained(
            [((r.start, r.stop), (r.level, r.level)) for r in log.rests]
        )
        lines.append(Line("rest_t", "rest_x", "ink", "rest", wide=True))
    if log.strokes:
        middles = [0.5 * (s.start + s.stop) for s in log.strokes]
        columns["stroke_t"], columns["stroke_x"] = middles, _positions(log, middles)
        hover = [
            f"stroke {k}: {'up' if s.direction > 0 else 'down'}\n"
            f"{s.start:.5g} to {s.stop:.5g} s\n"
            f"{number(s.travel, 4)} {length} at {number(s.speed, 3)} {speed}"
            for k, s in enumerate(log.strokes, 1)
        ]
        ways = ["triangle-up" if s.direction > 0 else "triangle-down" for s in log.strokes]
        lines.append(
            Line("stroke_t", "stroke_x", "accent", "stroke", "points", hover=hover, symbols=ways)
        )
    if log.slips:
        columns["slip_t"], columns["slip_x"] = _chained(
            [((s.start, s.stop), (s.begin, s.end)) for s in log.slips]
        )
        columns["middle_t"] = [0.5 * (s.start + s.stop) for s in log.slips]
        columns["middle_x"] = [0.5 * (s.begin + s.end) for s in log.slips]
        lines.append(Line("slip_t", "slip_x", "model", "slip", silent=True))
        hover = [_slip(k, s, frame) for k, s in enumerate(log.slips, 1)]
        lines.append(
            Line("middle_t", "middle_x", "model", "slip", "points", hover=hover, same=True)
        )
    return View(log.label, _alt(log, frame), columns, lines)


def _slip(k: int, s: SlipRecord, frame: Frame) -> str:
    return (
        f"slip {k}: starts at {s.start:.5g} s\njump {number(s.jump, 4)} {frame.units.position} in "
        f"{number(s.stop - s.start, 3)} s\ngreatest speed {number(s.speed, 3)} "
        f"{frame.units.velocity}"
    )


def _alt(log: LogRecord, frame: Frame) -> str:
    def count(n: int, noun: str) -> str:
        return f"{n or 'no'} {noun}{'s' * (n != 1)}"

    parts = [count(len(log.strokes), "stroke"), count(len(log.rests), "rest")]
    text = f"{', '.join(parts)} and {count(len(log.slips), 'slip')}"
    if log.slips:
        jump = float(np.median([abs(s.jump) for s in log.slips]))
        lasting = float(np.median([s.stop - s.start for s in log.slips]))
        text += f", the median slip {number(jump, 3)} {frame.units.position} in {lasting:.3g} s"
    return f"{log.label}: {text}."


def _chained(
    parts: Sequence[tuple[tuple[float, float], tuple[float, float]]],
) -> tuple[Column, Column]:
    """Short lines as one with gaps."""
    x = [v for (a, b), _ in parts for v in (a, b, None)]
    y = [v for _, (a, b) in parts for v in (a, b, None)]
    return x, y


def _positions(log: LogRecord, times: Sequence[float]) -> list[float]:
    """The position at some times."""
    known = [(t, x) for t, x in zip(log.t, log.position, strict=True) if None not in {t, x}]
    t, x = np.array(known, dtype=float).T
    positions: list[float] = np.interp(times, t, x).tolist()
    return positions
