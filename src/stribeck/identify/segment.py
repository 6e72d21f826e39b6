"""Segments of recordings, made ready to be simulated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..data.departures import Departure, SlipOnset, departures
from ..data.ranges import Range, Window, inner, start_of, windows
from ..data.repeated_samples import is_new
from ..data.resolution import noise
from ..data.segmentation import Segments, segment
from ..errors import InputError
from ..rig.motion.track import Track, extremes
from ..rig.simulated import SimulatedRig
from ..space import Array
from .held_onset import held_onset
from .loss import SQUARES, Objective

if TYPE_CHECKING:
    from ..data.recording import Recording
    from .data_split import DataSplit

#: A segment of fewer samples says nothing of a motion.
_FEWEST = 4
#: A way back below this share of the travel is none, and below so many standard deviations of the
#: noise, of which thousands of samples have both ends.
_TRAVEL, _NOISE = 0.1, 10.0
#: A slip is simulated from so many samples before it is seen to begin.
_LEAD = 6
#: So many times as long as slips are by their median, a motion is a slide: how it goes on after
#: that tells little of its onset, and hides it.
_LONGEST = 3.0
#: Share of its way over which a slip is at its beginning.
_EARLY = 0.25


@dataclass(frozen=True, eq=False)
class Segment:
    """One segment of a recording, ready to be simulated.

    Args:
        recording: Where it comes from.
        rows: The samples that count.
        begin: The sample at which the simulation starts; at or before `rows`.
        track: Command, samples and measured positions from `begin` to the end of `rows`.
        still: Samples before `rows` at which the axis rests where it starts; none as a rule
            where a simulation starts in motion.
        onset: When its one slip begins, where each has a breakaway of its own; else None.
        start_directions: In which another state at the start would move the residuals, orthonormal,
            (samples that count, k), where these are taken out of them; else None.
    """

    recording: Recording
    rows: slice
    begin: int
    track: Track
    still: slice
    onset: SlipOnset | None = None
    start_directions: Array | None = None

    @property
    def direction(self) -> int:
        """+1 if the axis went rightward over it, else -1."""
        x = self.recording.position
        return 1 if x[self.rows.stop - 1] >= x[self.rows.start] else -1


def directions_of(passed: Sequence[Segment]) -> frozenset[int]:
    """The directions, +1 and -1, in which an axis goes over a tenth of its travel or more."""
    positions = [s.recording.position[s.rows] for s in passed]
    share = _TRAVEL * max(float(np.ptp(x)) for x in positions)
    least = [max(share, _NOISE * noise(s.recording)) for s in passed]
    return frozenset(
        direction
        for direction in (1, -1)
        for x, way in zip(positions, least, strict=True)
        if float(np.max(direction * x - np.minimum.accumulate(direction * x))) > way
    )


def segments(
    recordings: Sequence[Recording],
    rig: SimulatedRig,
    part: Range | None,
    objective: Objective = SQUARES,
) -> list[Segment]:
    """The segments of a range in all recordings, each from the last rest before it.

    Args:
        recordings: The logs.
        rig: How its motions start: at rest, from the measured state, or with the log.
        part: The range; None for all.
        objective: Whether a new segment starts at every rest, or each slip is one.

    Raises:
        InputError: no recording passes the range, or the axis never rests where it must.
    """
    result: list[Segment] = []
    missing: list[InputError] = []
    for recording in recordings:
        try:
            result += _segments(recording, rig, part, objective)
        except InputError as error:
            missing.append(error)
    if not result:
        raise missing[0]
    return result


@dataclass(frozen=True, eq=False)
class SegmentSplit:
    """The segments of a data split, ready to be simulated.

    Args:
        train: Those to train on.
        holdout: Each range that is held out, with its segments.
    """

    train: tuple[Segment, ...]
    holdout: tuple[tuple[Range, tuple[Segment, ...]], ...]


def split_segments(data: DataSplit, rig: SimulatedRig, objective: Objective) -> SegmentSplit:
    """The segments of a rig's logs.

    Args:
        data: The logs and their ranges.
        rig: How its motions start.
        objective: Whether a new segment starts at every rest, or each slip is one.

    Raises:
        InputError: a range has no segment, or a log has none in any range.
    """
    logs = data.recordings
    train = [s for r in data.train or (None,) for s in segments(logs, rig, r, objective)]
    holdout = [(r, tuple(segments(logs, rig, r, objective))) for r in data.holdout]
    used = {
        id(s.recording) for part in (train, *(held_out for _, held_out in holdout)) for s in part
    }
    for log in logs:
        if id(log) not in used:
            for held_range in data.ranges or (None,):
                segments([log], rig, held_range)  # raises the reason
    return SegmentSplit(tuple(train), tuple(holdout))


def recordings_of(segments: Sequence[Segment]) -> list[Recording]:
    """The recordings that segments come from, each once."""
    return list({id(s.recording): s.recording for s in segments}.values())


def _segments(
    recording: Recording, rig: SimulatedRig, part: Range | None, objective: Objective
) -> list[Segment]:
    rig.check_turning(recording)
    segmentation = segment(recording)
    result = []
    for window in windows(recording, part, segmentation):
        passage = _Passage(recording, rig, part, segmentation, window)
        if objective.by_slip:
            result += _slips(passage)
        elif objective.restart:
            result += _from_rests(passage)
        elif rig.from_rest:
            result.append(_from_rest(passage))
        else:
            result.append(_from_state(recording, rig, window))
    return [
        replace(s, track=track)
        for s in result
        for track in rig.readings(s.track, recording, slice(s.begin, s.rows.stop))
    ]


@dataclass(frozen=True, eq=False)
class _Passage:
    """A log's way through a range.

    Args:
        recording: The log.
        rig: How its motions start.
        part: The range; None for all.
        segmentation: Motions and rests of the log.
        window: Where the log passes the range.
    """

    recording: Recording
    rig: SimulatedRig
    part: Range | None
    segmentation: Segments
    window: Window

    @property
    def within(self) -> str:
        """The range, as a sentence goes on with it."""
        return f" in {self.part.text}" if self.part else ""


def _from_rest(passage: _Passage) -> Segment:
    start = start_of(passage.segmentation, passage.window)
    if start is None:
        before = " or before it" if passage.part else ""
        raise InputError(
            f"{passage.recording.label}: the axis never rests{passage.within}{before}, so there is "
            "no state to simulate from: this rig is for logs with stick-slip"
        )
    return _resting(passage.recording, passage.rig, start.rest, start.rows)


def _from_rests(passage: _Passage) -> list[Segment]:
    """From each rest in a window to the next: where it landed counts, how it went on does not."""
    rows = passage.window.rows
    rests = [r for r in map(inner, passage.segmentation.rests) if _in(r, rows)]
    ends = [*(r.start for r in rests), rows.stop]
    legs = [
        (rest, slice(a, b))
        for rest, (a, b) in zip(rests, pairwise(ends), strict=True)
        if b - a >= _FEWEST
    ]
    if not legs:
        raise InputError(
            f"{passage.recording.label}: the axis never rests{passage.within}, so there is no rest "
            "to start from"
        )
    return [_resting(passage.recording, passage.rig, rest, leg) for rest, leg in legs]


def _slips(passage: _Passage) -> list[Segment]:
    """The motions of a window, each from the rest before it until it has come to rest again."""
    recording, rig, segmentation = passage.recording, passage.rig, passage.segmentation
    rows, result = passage.window.rows, []
    motions = list(departures(recording, segmentation))
    begins = [
        max((m.rest.start + m.start) // 2, m.start - max(_LEAD, m.stop - m.leaving))
        for m in motions
    ]
    ends = [*begins, rows.stop][1 : len(motions) + 1]
    longest = _LONGEST * float(np.median([m.stop - m.start for m in motions] or [0]))
    for m, begin, end in zip(motions, begins, ends, strict=True):
        still = inner(slice(m.rest.start, m.start + 1))
        samples = slice(begin, min(m.stop, end, rows.stop, m.start + int(longest)))
        if not (rows.start <= begin and m.leaving < samples.stop and still.start < still.stop):
            continue
        x0 = float(recording.position[still].mean())
        score = _counting(recording, rig)[samples].astype(float)
        track = _short(rig.track(recording, samples, x0, score))._replace(v0=0.0)
        track = rig.as_read(track, recording, samples)
        resolved = 0.5 * segmentation.step
        resolved += 2.0 * segmentation.noise / float(np.sqrt(still.stop - still.start))
        onset = replace(_onset(recording, rig, samples, m, x0), uncertain=resolved)
        if track.stretch.size:
            onset = held_onset(rig, track, onset, 0.5 * (onset.before + onset.after))
        result.append(Segment(recording, samples, begin, track, slice(begin, begin), onset))
    if not result:
        raise InputError(
            f"{recording.label}: the axis never breaks away from a rest{passage.within}: there is "
            "no slip to simulate"
        )
    return result


def _onset(
    recording: Recording, rig: SimulatedRig, rows: slice, m: Departure, x0: float
) -> SlipOnset:
    """When a motion begins, by the samples over which it is simulated.

    At the instant from which its first quarter goes with the square of time, as motion under a
    force does that drops at breakaway; under a held force, at the sample nearest to it.
    """
    t, x, start, leaving = recording.t, recording.position, m.start, m.leaving
    direction = 1 if x[leaving] > x0 else -1
    way = direction * (x[leaving : rows.stop] - x0)
    early = way[: max(int(np.argmax(way > _EARLY * way.max())), 1)]
    since = t[leaving : leaving + len(early)]
    span, instant = float(t[start + 1] - t[start]), 0.5 * float(t[start] + t[start + 1])
    seconds = float(since[-1] - t[start])
    if len(early) > 2:  # noqa: PLR2004 - a line takes three points to be better than its middle
        slope, intercept = np.polyfit(since - since[0], np.sqrt(np.maximum(early, 0.0)), 1)
        if slope > 0:
            instant = float(np.clip(since[0] - intercept / slope, t[rows.start] + span, since[0]))
    if rig.holds_force:
        at = max(int(np.searchsorted(t, instant - 0.5 * span)), rows.start + 1)
        return SlipOnset(float(t[at - 1]), float(t[at]), x0, direction, seconds)
    return SlipOnset(instant - 0.5 * span, instant + 0.5 * span, x0, direction, seconds)


def _short(track: Track) -> Track:
    """A track without the command before and after its samples."""
    first = max(int(np.searchsorted(track.knots_t, track.t[0], side="right")) - 1, 0)
    last = int(np.searchsorted(track.knots_t, track.t[-1], side="left")) + 1
    knots_t, knots_x = (np.ascontiguousarray(a[first:last]) for a in (track.knots_t, track.knots_x))
    return track._replace(knots_t=knots_t, knots_x=knots_x, extremes=extremes(knots_x))


def _in(rest: slice, rows: slice) -> bool:
    return bool(rows.start <= rest.start < rest.stop <= rows.stop)


def _resting(recording: Recording, rig: SimulatedRig, rest: slice, rows: slice) -> Segment:
    """A segment that starts at a rest, whose mean is its position."""
    samples = slice(rest.start, rows.stop)
    score = _counting(recording, rig)[samples] & (
        np.arange(samples.start, samples.stop) >= rows.start
    )
    x0 = float(recording.position[rest].mean())
    track = rig.track(recording, samples, x0, score.astype(float))._replace(v0=0.0)
    return Segment(
        recording, rows, rest.start, track, slice(rest.start, min(rest.stop, rows.start))
    )


def _from_state(recording: Recording, rig: SimulatedRig, window: Window) -> Segment:
    """A segment from the measured state at its start, or from the start of the log."""
    rows = window.rows
    begin = 0 if rig.history else rows.start
    samples = slice(begin, rows.stop)
    score = _counting(recording, rig)[samples] & (np.arange(begin, rows.stop) >= rows.start)
    x0 = float(recording.position[begin])
    track = rig.track(recording, samples, x0, score.astype(float))
    return Segment(recording, rows, begin, track, slice(begin, begin))


def _counting(recording: Recording, rig: SimulatedRig) -> NDArray[np.bool_]:
    """Which samples may count: not those that a sensor holds, where a rig has such a sensor."""
    return is_new(recording) if rig.holds else np.ones(len(recording), dtype=bool)
