"""A log as it was measured, before anything is identified: its channels with what `check` sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...data.gate import Fault
from ...data.gate.fault import SHOWN
from ...data.quality import GAP
from ...data.recording import Recording
from ...data.runs import runs
from ...data.segmentation import Segments
from ...space import Array
from ...units import unit
from ..contents.decimation import corners, rounded
from ..format import number, unit_label
from .plot import TALL, Column, Group, Line, Panel, Plot, View

#: Samples drawn of a log at most, points of the cloud, and marks of a kind.
MOST, CLOUD, MARKS = 8000, 2500, 1000
#: Steps of a position, or widths of its noise, over which a velocity is taken.
_STEPS = 14.0


@dataclass(frozen=True, eq=False)
class DrawnLog:
    """A log with what is marked in it.

    Args:
        recording: The log, mended.
        segments: Its strokes, rests and slips.
        faults: What is wrong with its channels.
    """

    recording: Recording
    segments: Segments
    faults: Sequence[Fault]

    def shown(self, channel: str) -> tuple[Array, str]:
        """A channel in the unit in which people read it, and that."""
        written = self.written(channel)
        values = self.velocity[0] if channel == "velocity" else getattr(self.recording, channel)
        return np.asarray(unit(written).from_si(values)), unit_label(written)

    def written(self, channel: str) -> str:
        """The unit in which people read a channel, as a file has it."""
        si = self.recording.si_unit(channel)
        return SHOWN.get(si, si)

    @cached_property
    def velocity(self) -> tuple[Array, float]:
        """As it was recorded, or the slope of the position over the seconds that go with it."""
        log, segments = self.recording, self.segments
        if log.velocity is not None:
            return log.velocity, 0.0
        pace = np.median([s.speed for s in segments.strokes]) if segments.strokes else 0.0
        fuzz = float(np.hypot(segments.noise, segments.step / 3.5))
        lag = int(np.ceil(_STEPS * fuzz / (float(pace) * log.dt))) if pace else 1
        lag = min(max(lag, 1), max(1, len(log) // 20))
        rows = np.arange(len(log))
        after, before = np.minimum(rows + lag, len(log) - 1), np.maximum(rows - lag, 0)
        slope = (log.position[after] - log.position[before]) / (log.t[after] - log.t[before])
        return slope, 2 * lag * log.dt

    @cached_property
    def gaps(self) -> list[tuple[float, float]]:
        """From when to when rows are missing, the longest ones, s."""
        t = self.recording.t
        steps = np.diff(t)
        long = np.flatnonzero(steps > GAP * np.median(steps))
        long = np.sort(long[np.argsort(-steps[long])][:MARKS])
        return [(float(t[k]), float(t[k + 1])) for k in long]

    def places(self, fault: Fault) -> list[tuple[float, float]]:
        """From when to when a fault is, s."""
        t = self.recording.t
        return [(float(t[a]), float(t[b - 1])) for a, b in zip(*runs(fault.rows), strict=True)]


def overview_groups(log: DrawnLog) -> list[Group]:
    """The channels over time, and the force over the velocity where there is one."""
    groups = [Group("log", "Log", [_channels_plot(log)])]
    if log.recording.force is not None:
        groups.append(Group("cover", "Force against velocity", [_cloud_plot(log)]))
    return groups


def _channels_plot(log: DrawnLog) -> Plot:
    """Position and command, velocity and force, one above the other."""
    recording, (x, length) = log.recording, log.shown("position")
    v, speed = log.shown("velocity")
    series = {"x": x, "v": v}
    panels = [Panel(f"{'Angle' if recording.rotary else 'Position'} / {length}", 2.6),
              Panel(f"Velocity / {speed}", 1.3)]  # fmt: skip
    seconds = log.velocity[1]
    name = "velocity" if not seconds else f"velocity, over {1e3 * seconds:.3g} ms"
    lines = [Line("t", "x", "measured", "position", wide=True),
             Line("t", "v", "repeat2", name, panel=1)]  # fmt: skip
    if recording.command is not None:
        series["command"] = np.asarray(unit(log.written("position")).from_si(recording.command))
        lines.insert(0, Line("t", "command", "command", "command", "dashes"))
    if recording.force is not None:
        series["F"], force = log.shown("force")
        panels.append(Panel(f"{'Torque' if recording.rotary else 'Force'} / {force}", 1.3))
        lines.append(Line("t", "F", "repeat3", "force", panel=2))
    columns = _thinned(log, series)
    marks = [_rests(log, x), _slips(log, x, length), *_strokes(log, x, length, speed)]
    for more, line in filter(None, [*marks, *_faults(log, x)]):
        columns |= more
        lines.append(line)
    view = View("log", _alt(log), columns, lines, spans=log.gaps, shaded="rows missing")
    height = TALL + 120 * (len(panels) - 2)
    return Plot("log-plot", "The log", "Time / s", panels, [view], height)


def _thinned(log: DrawnLog, series: dict[str, Array]) -> dict[str, Column]:
    """The lines by few samples that keep their extremes, broken where rows are missing."""
    t = log.recording.t
    rows = corners(list(series.values()), MOST)
    breaks = np.searchsorted(t[rows], [end for _, end in log.gaps])
    columns = {n: np.insert(a[rows], breaks, np.nan) for n, a in series.items()}
    times = np.insert(t[rows], breaks, [begin for begin, _ in log.gaps])
    return {"t": rounded(times, 7), **{n: rounded(a) for n, a in columns.items()}}


def _chained(parts: Sequence[tuple[float, float, float, float]]) -> tuple[Column, Column]:
    """Short lines (t, x, t, x) as one with gaps."""
    t = [value for a, _, b, _ in parts for value in (a, b, None)]
    x = [value for _, a, _, b in parts for value in (a, b, None)]
    return t, x


def _rests(log: DrawnLog, x: Array) -> tuple[dict[str, Column], Line] | None:
    t = log.recording.t
    rests = sorted(log.segments.rests, key=lambda r: t[r.start] - t[r.stop - 1])[:MARKS]
    if not rests:
        return None
    level = [float(x[r].mean()) for r in rests]
    parts = [(float(t[r.start]), y, float(t[r.stop - 1]), y)
             for r, y in zip(rests, level, strict=True)]  # fmt: skip
    at, y = _chained(parts)
    line = Line("rest_t", "rest_x", "ink", "rest", wide=True, silent=True)
    return {"rest_t": at, "rest_x": y}, line


def _slips(log: DrawnLog, x: Array, length: str) -> tuple[dict[str, Column], Line] | None:
    t = log.recording.t
    slips = sorted(log.segments.slips, key=lambda s: -abs(s.jump))[:MARKS]
    if not slips:
        return None
    scale = unit(log.written("position")).factor
    at: Column = [float(0.5 * (t[s.start] + t[s.stop])) for s in slips]
    y: Column = [float(0.5 * (x[s.start] + x[s.stop])) for s in slips]
    hover = [
        f"slip at {t[s.start]:.5g} s: {number(s.jump / scale, 3)} {length} in "
        f"{number(float(t[s.stop] - t[s.start]), 3)} s"
        for s in slips
    ]
    return {"slip_t": at, "slip_x": y}, Line("slip_t", "slip_x", "model", "slip", "points",
                                             hover=hover)  # fmt: skip


def _strokes(
    log: DrawnLog, x: Array, length: str, speed: str
) -> list[tuple[dict[str, Column], Line]]:
    t, strokes = log.recording.t, log.segments.strokes[:MARKS]
    if not strokes:
        return []
    middles = [(s.rows.start + s.rows.stop - 1) // 2 for s in strokes]
    scales = unit(log.written("position")).factor, unit(log.written("velocity")).factor
    hover = [
        f"stroke {k}, {'up' if s.direction > 0 else 'down'}: {number(s.travel / scales[0], 4)} "
        f"{length} at {number(s.speed / scales[1], 3)} {speed}"
        for k, s in enumerate(strokes, 1)
    ]
    columns: dict[str, Column] = {
        "stroke_t": [float(t[k]) for k in middles],
        "stroke_x": [float(x[k]) for k in middles],
    }
    ways = ["triangle-up" if s.direction > 0 else "triangle-down" for s in strokes]
    return [(columns, Line("stroke_t", "stroke_x", "accent", "stroke", "points", hover=hover,
                           symbols=ways))]  # fmt: skip


def _faults(log: DrawnLog, x: Array) -> list[tuple[dict[str, Column], Line]]:
    """What the gate tells, at its places: on the panel of its channel."""
    result: list[tuple[dict[str, Column], Line]] = []
    t, recording = log.recording.t, log.recording
    for k, fault in enumerate(log.faults):
        panel = {"velocity": 1, "force": 2}.get(fault.channel, 0)
        y = x if panel == 0 else log.shown(fault.channel)[0]
        if panel == 2 and recording.force is None:  # noqa: PLR2004 - the third panel
            continue
        first, last = runs(fault.rows)
        middles = ((first + last - 1) // 2)[:MARKS]
        columns: dict[str, Column] = {
            f"fault_t{k}": [float(t[i]) for i in middles],
            f"fault_y{k}": [float(y[i]) for i in middles],
        }
        line = Line(f"fault_t{k}", f"fault_y{k}", "repeat4", "finding", "rings", panel=panel,
                    same=k > 0, hover=[fault.sentence] * len(middles))  # fmt: skip
        result.append((columns, line))
    return result


def _cloud_plot(log: DrawnLog) -> Plot:
    """Force against velocity of the samples as they are: inertia and gravity are in it."""
    recording = log.recording
    (v, speed), (F, force) = log.shown("velocity"), log.shown("force")
    rows = np.unique(np.linspace(0, len(v) - 1, CLOUD).astype(int))
    kind = "torque" if recording.rotary else "force"
    alt = (
        f"{kind.capitalize()} from {number(float(F.min()), 4)} to {number(float(F.max()), 4)} "
        f"{force} at velocities from {number(float(v.min()), 4)} to {number(float(v.max()), 4)} "
        f"{speed}. Friction, inertia and gravity are all in it."
    )
    if recording.runs is not None:
        alt = f"{len(v)} runs at constant speed, each a mean."
    columns: dict[str, Column] = {"v": rounded(v[rows]), "F": rounded(F[rows])}
    line = Line("v", "F", "measured", "samples", "points" if len(rows) <= MARKS // 3 else "dots")
    view = View("cloud", alt, columns, [line])
    title, panel = f"{kind.capitalize()} against velocity", Panel(f"{kind.capitalize()} / {force}")
    return Plot("cover-plot", title, f"Velocity / {speed}", [panel], [view])


def run_groups(recording: Recording) -> list[Group]:
    """A table of steady speeds: force against velocity."""
    log = DrawnLog(recording, Segments(0.0, 0.0, 0.0, (), (), (), 0.0), ())
    return [Group("cover", "Force against velocity", [_cloud_plot(log)])]


def _alt(log: DrawnLog) -> str:
    def count(n: int, noun: str) -> str:
        return f"{n or 'no'} {noun}{'s' * (n != 1)}"

    segments, gaps = log.segments, len(log.gaps)
    parts = [count(len(segments.strokes), "stroke"), count(len(segments.rests), "rest"),
             count(len(segments.slips), "slip"), count(gaps, "gap")]  # fmt: skip
    return f"{', '.join(parts[:-1])} and {parts[-1]}."
