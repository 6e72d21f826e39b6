"""Stretches of a recording, named by where the axis was or by the clock: `112:295`, `10s:40s`."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from ..errors import InputError
from ..space import Array
from ..units import unit
from .segmentation import segment

if TYPE_CHECKING:
    from .recording import Recording
    from .segmentation import Segments

_END = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-z°µ]*)\s*")

#: A stretch of fewer samples says nothing about a motion.
FEWEST = 10


@dataclass(frozen=True)
class Range:
    """From one position to another, or from one time to another, SI.

    A range of positions means the strokes that run from `start` towards `stop`: `112:295` the
    rightward ones, `325:127` the leftward ones.

    Args:
        text: As it was written, without blanks.
        start: m, rad or s.
        stop: m, rad or s.
        timed: Whether both ends are times.
    """

    text: str
    start: float
    stop: float
    timed: bool

    @classmethod
    def parse(cls, text: str, shown: str) -> Self:
        """Read `A:B`; a number without a unit is a position in the unit `shown`.

        Raises:
            InputError: not two numbers, units that differ in kind, or an empty range.
        """
        ends = [_END.fullmatch(end) for end in text.split(":")]
        if len(ends) != 2 or not all(ends):  # noqa: PLR2004 - a range has two ends
            raise InputError(f"range {text!r}: write A:B, as 112:295 ({shown}) or 10s:40s")
        (a, unit_a), (b, unit_b) = (end.groups() for end in ends if end)
        try:
            first, second = unit(unit_a or unit_b or shown), unit(unit_b or unit_a or shown)
        except InputError as error:
            raise InputError(f"range {text!r}: {error}") from error
        kinds = {first.dimension, second.dimension}
        if len(kinds) > 1 or not kinds <= {"s", unit(shown).dimension}:
            raise InputError(f"range {text!r}: give both ends in {shown} or both in s")
        start, stop = float(first.to_si(float(a))), float(second.to_si(float(b)))
        timed = kinds == {"s"}
        if not (math.isfinite(start) and math.isfinite(stop)):
            raise InputError(f"range {text!r}: its ends must be finite numbers")
        if start == stop:
            raise InputError(f"range {text!r} is empty: give two ends that differ")
        if timed and start > stop:
            raise InputError(f"range {text!r} is empty: give the earlier time first")
        return cls("".join(text.split()), start, stop, timed)

    @property
    def direction(self) -> int:
        """+1 for a rightward, -1 for a leftward range of positions, 0 for a range of times."""
        return 0 if self.timed else (1 if self.stop > self.start else -1)


@dataclass(frozen=True)
class Window:
    """The samples of a range in one stroke.

    Args:
        rows: The samples.
        since: First sample of the stroke, or of the recording for a range of times.
    """

    rows: slice
    since: int


def windows(
    recording: Recording, bounds: Range | None, segments: Segments | None = None
) -> list[Window]:
    """The samples of a range: a window a stroke, or one for a range of times or for all (None).

    Raises:
        InputError: the range holds fewer than 10 samples.
    """
    if bounds is None:
        return [Window(slice(0, len(recording)), 0)]
    if bounds.timed:
        a, b = np.searchsorted(recording.t, [bounds.start, bounds.stop])
        matches = [Window(slice(int(a), int(b)), 0)]
    else:
        matches = [
            Window(rows, stroke.start)
            for stroke, direction in _reaches(segments or segment(recording), len(recording))
            if direction == bounds.direction
            and (rows := _between(recording.position, stroke, bounds)) is not None
        ]
    touched = sum(w.rows.stop - w.rows.start for w in matches)
    matches = [w for w in matches if w.rows.stop - w.rows.start >= FEWEST]
    if not matches and touched:
        raise InputError(
            f"{recording.label}: range {bounds.text} holds {touched} samples, {FEWEST} are needed: "
            "widen it"
        )
    if not matches:
        raise InputError(
            f"{recording.label}: range {bounds.text} holds no motion: {_extent(recording, bounds)}"
        )
    return matches


def _reaches(segments: Segments, n: int) -> list[tuple[slice, int]]:
    """The strokes with the standstill that follows each, so that together they cover the log."""
    begins = [0, *(s.rows.start for s in segments.strokes[1:])]
    ends = [*begins[1:], n]
    return [
        (slice(a, b), s.direction) for a, b, s in zip(begins, ends, segments.strokes, strict=False)
    ]


def _between(x: Array, stroke: slice, bounds: Range) -> slice | None:
    """From where a stroke enters a range of positions to where it leaves it."""
    travel = x[stroke] * bounds.direction
    start, stop = bounds.start * bounds.direction, bounds.stop * bounds.direction
    inside = np.flatnonzero(travel >= start)
    if not len(inside):
        return None
    passed = np.flatnonzero(travel[inside[0] :] > stop)
    end = inside[0] + passed[0] if len(passed) else len(travel)
    return slice(stroke.start + int(inside[0]), stroke.start + int(end))


def _extent(recording: Recording, bounds: Range) -> str:
    if bounds.timed:
        return f"its time runs from {recording.t[0]:g} to {recording.t[-1]:g} s"
    x = recording.position
    scale, written = (1.0, "rad") if recording.rotary else (1e3, "mm")
    side = "rightward" if bounds.direction > 0 else "leftward"
    return (
        f"its position runs from {x.min() * scale:.4g} to {x.max() * scale:.4g} {written} "
        f"and no {side} stroke passes there"
    )


@dataclass(frozen=True)
class Start:
    """Where a simulation of a window starts: at rest.

    Args:
        rest: The samples at rest; it starts at the first, and their mean is its position.
        rows: The samples of the window that can be simulated from there.
    """

    rest: slice
    rows: slice


def start_of(segments: Segments, window: Window) -> Start | None:
    """The rest to start from: the last one before the window in its stroke, else the first in it.

    Section 4.3, step 1, takes the mean of the first 50 samples as the position of rest. A range
    may begin in the middle of a slip, though: the state there is known only by simulating from
    the rest before it. And 50 noisy samples leave an error that shifts every slip in time, so all
    samples of that rest are used, but for its ends, which may still belong to a slip. Samples
    before the first rest of a stroke cannot be simulated and are left out. Returns None if the
    axis does not rest in the stroke.
    """
    rows = window.rows
    rests = [
        r
        for r in map(inner, segments.rests)
        if r.stop - r.start >= FEWEST and r.stop > window.since and r.start < rows.stop - FEWEST
    ]
    if not rests:
        return None
    before = [r for r in rests if r.start <= rows.start]
    rest = before[-1] if before else rests[0]
    return Start(rest, slice(max(rows.start, rest.start), rows.stop))


def inner(rest: slice) -> slice:
    """A rest without the tail of the slip before it and the onset of the next."""
    length = rest.stop - rest.start
    head = length // 4 if rest.start > 0 else 0
    return slice(rest.start + head, rest.stop - length // 8)
