"""What the page shows of a log: its channels, what the gate finds, and its lines as pixels."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Sequence
from functools import cached_property
from math import isnan
from pathlib import Path
from typing import Any

import numpy as np

from ..data import Quality, Recording, check
from ..data.gate import faults, mended
from ..data.quality import seen_segments
from ..data.readers.log_contents import LogContents, contents
from ..data.readers.log_map import FILE
from ..data.segmentation import Segments
from ..report.figures.overview_plots import DrawnLog
from ..report.format import unit_label
from ..rig import Rig
from ..rig.lookup import rig_of_heads
from ..rig.simulated import SimulatedRig
from ..space import Array
from ..units import unit
from .pyramid import Pyramid, windowed
from .session_request import Request

#: Channels that are drawn, in order; marks of a kind at most; points of the scatter at most.
DRAWN = ("position", "command", "velocity", "force", "current", "temperature")
MARKS, CLOUD = 2000, 4000
#: Logs kept in memory.
KEPT = 4
#: Pixels of a plot at most.
WIDEST = 4000


class LogView:
    """A log, read, with what is drawn of it.

    Args:
        recording: The log.
    """

    def __init__(self, recording: Recording) -> None:
        self.recording = recording

    @cached_property
    def quality(self) -> Quality:
        """What `check` says of it."""
        return check(self.recording)

    @cached_property
    def drawn(self) -> DrawnLog:
        """It, mended, with its strokes, rests, slips and faults."""
        log = mended(self.recording)
        return DrawnLog(log, seen_segments(log), faults(log))

    @cached_property
    def recorded(self) -> dict[str, tuple[str, Pyramid]]:
        """Label of the unit, and values in it, by channel, as they were recorded."""
        log = DrawnLog(self.recording, Segments(0.0, 0.0, 0.0, (), (), (), 0.0), ())
        return _channels(log, [n for n in DRAWN if getattr(self.recording, n) is not None])

    @cached_property
    def channels(self) -> dict[str, tuple[str, Pyramid]]:
        """The same of the log mended, with a velocity of the position where none was recorded."""
        log = self.drawn
        there = [n for n in DRAWN if n == "velocity" or getattr(log.recording, n) is not None]
        return _channels(log, there)

    def _drawn(self, mended: bool) -> tuple[Array, dict[str, tuple[str, Pyramid]]]:
        """Times and channels of the log mended, or as recorded."""
        if mended:
            return self.drawn.recording.t, self.channels
        return self.recording.t, self.recorded

    def outline(self) -> dict[str, Any]:
        """What a first picture needs, at once: mended, where that is known already."""
        if self.recording.runs is not None:
            return {"span": None, "channels": {}, "mended": False}
        mended = "channels" in vars(self)
        t, channels = self._drawn(mended)
        return {
            "span": [float(t[0]), float(t[-1])],
            "channels": {n: label for n, (label, _) in channels.items()},
            "mended": mended,
        }

    def overview(self) -> dict[str, Any]:
        """All that the page shows of it but the lines."""
        quality = self.quality
        summary = {
            "file": quality.file,
            "lines": [list(line) for line in quality.lines()],
            "verdict": list(quality.verdict),
            "rig": quality.rig,
            "rig_reason": quality.rig_reason,
            "rows": quality.rows,
            "notes": list(quality.notes),
        }
        if self.recording.runs is not None:
            return summary | self.outline() | {"findings": [], "marks": {}}
        marks = self._marks()
        return summary | self.outline() | {"findings": self._findings(), "marks": marks}

    def _findings(self) -> list[dict[str, Any]]:
        return [
            {
                "channel": fault.channel,
                "sentence": fault.sentence,
                "harmful": fault.harmful,
                "places": self.drawn.places(fault)[:20],
            }
            for fault in self.drawn.faults
        ]

    def _marks(self) -> dict[str, Any]:
        log, segments = self.drawn.recording, self.drawn.segments
        t, x = log.t, self.channels["position"][1].values
        return {
            "rests": [
                [float(t[r.start]), float(t[r.stop - 1]), float(x[r].mean())]
                for r in segments.rests[:MARKS]
            ],
            "slips": [
                [float(t[s.start]), float(t[s.stop]), float(x[s.start]), float(x[s.stop])]
                for s in segments.slips[:MARKS]
            ],
            "strokes": [
                [float(t[s.rows.start]), float(t[s.rows.stop - 1]), int(s.direction)]
                for s in segments.strokes[:MARKS]
            ],
            "gaps": [list(gap) for gap in self.drawn.gaps],
        }

    def lines(self, since: float, until: float, pixels: int, mended: bool) -> dict[str, Any]:
        """Lines of a part of it, mended or as recorded, for a plot of some width."""
        pixels = min(max(pixels, 10), WIDEST)
        times, channels = self._drawn(mended)
        pyramids = {n: pyramid for n, (_, pyramid) in channels.items()}
        t, lines, exact = windowed(times, pyramids, since, until, pixels)
        return {"t": _numbers(t, 9), "lines": {n: _numbers(a, 6) for n, a in lines.items()},
                "exact": exact}  # fmt: skip

    def cloud(self, since: float, until: float) -> dict[str, Any] | None:
        """Force against velocity of a part of it; None without a force."""
        if "force" not in self.channels:
            return None
        t = self.drawn.recording.t
        first, last = np.searchsorted(t, [since, until])
        count = int(last - first)
        rows = first + np.unique(np.linspace(0, max(count - 1, 0), CLOUD).astype(np.intp))
        rows = rows[rows < len(t)]
        (speed, v), (force, F) = self.channels["velocity"], self.channels["force"]
        return {
            "velocity": _numbers(v.values[rows], 5),
            "force": _numbers(F.values[rows], 5),
            "units": [speed, force],
        }


def _channels(log: DrawnLog, names: Sequence[str]) -> dict[str, tuple[str, Pyramid]]:
    """Label of the unit, and values in it, of some channels of a log."""
    lines: dict[str, tuple[str, Pyramid]] = {}
    for name in names:
        values: Array
        if name in ("position", "velocity", "force"):
            values, label = log.shown(name)
        elif name == "command":
            written = log.written("position")
            values = np.asarray(unit(written).from_si(log.recording.command))
            label = unit_label(written)
        else:
            values, label = getattr(log.recording, name), unit_label(log.recording.si_unit(name))
        lines[name] = label, Pyramid(values)
    return lines


class LogViews:
    """Logs that were read lately, by how they were read.

    One thread reads at a time: two windows that show the same log read it once.
    """

    def __init__(self) -> None:
        self._views: OrderedDict[tuple[Any, ...], LogView] = OrderedDict()
        self._lock = threading.Lock()

    def view(self, request: Request, log: int) -> LogView:
        """A log of a session.

        Raises:
            InputError: as `read`.
        """
        key = request.path(log), request.reading, stamp(request.files[request.choices.logs[log].id])
        with self._lock:
            if key not in self._views:
                self._views[key] = LogView(request.recording(log))
                while len(self._views) > KEPT:
                    self._views.popitem(last=False)
            self._views.move_to_end(key)
            return self._views[key]


def stamp(log: Path) -> tuple[int, ...]:
    """What changes when a log does, the files in a folder, or the map of channels beside it."""
    inner = sorted(log.iterdir()) if log.is_dir() else []
    stats = [file.stat() for file in (log, *inner, log.parent / FILE) if file.exists()]
    return tuple(n for s in stats for n in (s.st_mtime_ns, s.st_ctime_ns, s.st_size))


def contents_table(result: LogContents, rig: str = "") -> dict[str, Any]:
    """What is in a log, for the page: its channels, and what would be taken for what.

    Args:
        result: It.
        rig: The kind of axis whose columns were taken; empty where heads or a map say it.
    """
    taken = {choice.column: channel for channel, choice in result.taken.items()}
    units = {c.column: c.unit.written for c in result.taken.values()} if rig else {}
    return {
        "file": result.file,
        "format": result.format,
        "problems": list(result.problems),
        "lacking": result.lacking,
        "as_rig": rig,
        "rig": rig_of_heads([c.name for c in result.channels]) if result.lacking else None,
        "channels": [
            {
                "name": c.name,
                "unit": c.unit or units.get(c.name),
                "count": c.count,
                "rate": c.rate,
                "constant": bool(c.constant),
                "taken": taken.get(c.name, ""),
                "guesses": list(result.guesses.get(c.name, ())),
            }
            for c in result.channels
        ],
    }


def log_contents(request: Request, log: int) -> dict[str, Any]:
    """What is in a log of a session, read as is chosen.

    Raises:
        InputError: as `contents`.
    """
    columns, of_rig = request.map, ""
    if columns is None and (rig := request.reading_rig) is not None and rig.columns:
        columns, of_rig = dict(rig.columns), request.choices.rig
    return contents_table(contents(request.path(log), columns=columns, **request.words), of_rig)


def stated_constants(rig: Rig | None, recording: Recording) -> dict[str, float]:
    """The constants of an axis that a log states itself, in the units that people see."""
    if not isinstance(rig, SimulatedRig):
        return {}
    units = {c.name: c.unit for c in rig.constants}
    stated = rig.stated(recording)
    return {n: float(unit(units[n]).from_si(v)) for n, v in stated.items() if n in units}


def _numbers(values: Array, digits: int) -> list[float | None]:
    """Values for JSON, null for nan, of as many digits as a plot needs."""
    return [None if isnan(v) else float(f"{v:.{digits}g}") for v in values.tolist()]
