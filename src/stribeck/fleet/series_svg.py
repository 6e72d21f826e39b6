"""Pictures of a parameter over time as SVG in a page, in the colours of its theme."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable, Sequence

import numpy as np
from markupsafe import Markup, escape

from ..report import number
from ..report.format import unit_label
from ..space import Array
from .drift_verdict import ParameterDrift

#: Points of a sparkline, the last ones.
POINTS = 60
#: Its size and that of a picture, px.
_SPARK, _WIDE, _HIGH, _STRIP = (120, 26), 690, 190, 70
_LEFT, _RIGHT, _PAD = 56, 8, 8

_EPOCH = dt.datetime(1970, 1, 1)  # noqa: DTZ001 - as the table has times

Scale = Callable[[float], float]


def sparkline(values: Array, low: Array, high: Array) -> Markup:
    """Values in order with their intervals as a band; the last is a dot.

    Args:
        values: (n,).
        low: Lower ends, nan where there is none, (n,).
        high: Upper ends, (n,).
    """
    y, lower, upper = (np.asarray(a, dtype=float)[-POINTS:] for a in (values, low, high))
    lower, upper = (np.where(np.isfinite(a), a, y) for a in (lower, upper))
    width, height = _SPARK
    across = _scale(0.0, max(len(y) - 1, 1), 4.0, width - 4.0)
    up = _scale(float(lower.min()), float(upper.max()), height - 3.0, 3.0)
    x = [across(k) for k in range(len(y))]
    band = [*zip(x, map(up, upper), strict=True), *zip(x[::-1], map(up, lower[::-1]), strict=True)]
    line = list(zip(x, map(up, y), strict=True))
    said = f"{len(y)} values, {number(float(y.min()), 3)} to {number(float(y.max()), 3)}"
    return _svg(
        (width, height),
        said,
        f'<polygon class="band" points="{_points(band)}"/>',
        f'<polyline class="line" points="{_points(line)}"/>',
        f'<circle class="dot" cx="{line[-1][0]:.1f}" cy="{line[-1][1]:.1f}" r="2.5"/>',
    )


def drift_picture(p: ParameterDrift) -> Markup:
    """A parameter over time: estimates with intervals, alarms, and the charts below them.

    What is compared is filled; a chart stands between its limits.
    """
    rows = p.rows.filter(p.rows["when"].is_not_null())
    times = [_seconds(when) for when in rows["when"]]
    value, low, high = (rows[n].cast(float).to_numpy() for n in ("value", "low", "high"))
    low, high = (np.where(np.isfinite(a), a, value) for a in (low, high))
    across = _scale(min(times), max(times), _LEFT + 6.0, _WIDE - _RIGHT - 6.0)
    # Intervals that reach far beyond all values are cut off at the edge.
    span = max(float(np.ptp(value)), float(np.median(high - low)), 1e-12)
    ends = float(value.min()) - span, float(value.max()) + span
    least, most = max(float(low.min()), ends[0]), min(float(high.max()), ends[1])
    up = _scale(least, most, _HIGH - 22.0, float(_PAD))
    compared = dict(zip(p.compared["log"], range(len(p.compared)), strict=True))
    parts = [*_axis(up, least, most, unit_label(p.unit)), *_dates(across, min(times), max(times))]
    for alarm in p.alarms:
        since = (across(_seconds(change.since)) for change in alarm.changes[:1])
        parts += [_vertical(x, 0.0, _HIGH - 18.0, "rule") for x in since]
        at = across(_seconds(alarm.when))
        parts.append(_vertical(at, 0.0, _HIGH + _STRIP + 0.0, "alarm"))
    for t, v, bottom, top, log in zip(times, value, low, high, rows["log"], strict=True):
        x, kind = across(t), "dot" if log in compared else "out"
        y = [up(min(max(float(w), least), most)) for w in (v, bottom, top)]
        parts.append(_vertical(x, y[1], y[2], "bar"))
        parts.append(f'<circle class="{kind}" cx="{x:.1f}" cy="{y[0]:.1f}" r="3"/>')
    if p.chart is not None:
        strip = [across(_seconds(when)) for when in p.compared["when"]]
        parts += _charts(p, strip)
    height = _HIGH + (_STRIP if p.chart is not None else 0)
    alarms = f"; alarms on {', '.join(f'{a.when:%Y-%m-%d}' for a in p.alarms)}" * bool(p.alarms)
    said = f"{p.parameter} of {p.axis} in {p.unit} over {len(rows)} logs{alarms}"
    return _svg((_WIDE, height), said, *parts)


def _charts(p: ParameterDrift, x: Sequence[float]) -> list[str]:
    """CUSUM and EWMA as shares of their limits."""
    chart = p.chart
    if chart is None:
        return []
    middle, half = _HIGH + _STRIP / 2.0, _STRIP / 2.0 - 6.0
    shares = {
        "up": chart.up / chart.limits.cusum,
        "down": -chart.down / chart.limits.cusum,
        "ewma": chart.ewma / chart.limits.ewma,
    }
    limits = [
        f'<line class="rule" x1="{_LEFT}" x2="{_WIDE - _RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>'
        for y in (middle - half, middle + half)
    ]
    text = f'<text x="{_LEFT - 6}" y="{middle + 4:.0f}" text-anchor="end">charts</text>'
    return [*limits, text, *(_curve(name, s, x, middle, half) for name, s in shares.items())]


def _curve(name: str, shares: Array, x: Sequence[float], middle: float, half: float) -> str:
    known = [(a, s) for a, s in zip(x, shares.tolist(), strict=True) if np.isfinite(s)]
    points = [(a, middle - half * min(max(s, -1.15), 1.15)) for a, s in known]
    return f'<polyline class="{name}" points="{_points(points)}"/>'


def _axis(up: Scale, least: float, most: float, unit: str) -> list[str]:
    ticks = np.linspace(least, most, 4)
    lines = [
        f'<text x="{_LEFT - 6}" y="{up(float(v)) + 4:.1f}" text-anchor="end">{number(float(v), 3)}'
        "</text>"
        for v in ticks
    ]
    return [*lines, f'<text x="{_LEFT}" y="{_HIGH - 4}">{escape(unit)}</text>']


def _dates(across: Scale, first: float, last: float) -> list[str]:
    texts = []
    for share, anchor in ((0.0, "start"), (0.5, "middle"), (1.0, "end")):
        t = first + share * (last - first)
        x = across(t) + (60.0 if share == 0.0 else 0.0)
        day = (_EPOCH + dt.timedelta(seconds=round(t))).date()
        texts.append(f'<text x="{x:.1f}" y="{_HIGH - 4}" text-anchor="{anchor}">{day}</text>')
    return texts


def _seconds(when: dt.datetime) -> float:
    """A time of the table on the axis of times, whatever zone and summer time are here."""
    return (when - _EPOCH).total_seconds()


def _vertical(x: float, y1: float, y2: float, kind: str) -> str:
    return f'<line class="{kind}" x1="{x:.1f}" x2="{x:.1f}" y1="{y1:.1f}" y2="{y2:.1f}"/>'


def _scale(low: float, high: float, start: float, end: float) -> Scale:
    """A line that takes one interval to another; the middle where the first has no length."""
    if not high > low:
        return lambda _: 0.5 * (start + end)
    return lambda v: start + (v - low) / (high - low) * (end - start)


def _points(points: Sequence[tuple[float, float]]) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _svg(size: tuple[float, float], said: str, *parts: str) -> Markup:
    width, height = size
    head = f'<svg class="series" viewBox="0 0 {width:g} {height:g}" width="{width:g}" '
    text = (
        f'{head}height="{height:g}" role="img" aria-label="{escape(said)}">{"".join(parts)}</svg>'
    )
    return Markup(text)  # noqa: S704 - every text in it is escaped
