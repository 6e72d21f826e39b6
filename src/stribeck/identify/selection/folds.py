"""Splits of logs into training and held-out parts, for a comparison of laws.

Samples of a log that are held out one by one tell nothing: each has neighbours that were trained
on. So whole logs are held out, or whole ranges of time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from ...data.ranges import FEWEST, Range, windows
from ...data.runs import slices, within
from ...data.segmentation import segment
from ...errors import InputError
from ...space import Array
from ...wording import option

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ...rig import Rig

Kind = Literal["hold-out", "logs", "strokes", "time", "runs"]
Mask = NDArray[np.bool_]

#: Logs from which on whole logs are held out.
_LOGS = 3
#: A way back below this share of the travel is none.
_TRAVEL = 0.1


@dataclass(frozen=True, eq=False)
class LogRange:
    """A part of a log: a range, or all of it where `within` is None; of a table, some runs."""

    recording: Recording
    within: Range | None
    runs: Mask | None = None

    def mask(self) -> Mask:
        """Which samples, (N,)."""
        if self.runs is not None:
            return self.runs
        counted = np.zeros(len(self.recording), dtype=bool)
        for window in windows(self.recording, self.within):
            counted[window.rows] = True
        return counted

    @property
    def label(self) -> str:
        """The log, and the range if there is one."""
        name = self.recording.label
        return name if self.within is None else f"{name} {self.within.text}"


def directions(parts: Sequence[LogRange]) -> frozenset[int]:
    """The directions, +1 and -1, in which parts of logs run over a tenth of their travel.

    Those of the runs where the logs are tables.
    """
    steady = [part for part in parts if part.recording.runs is not None]
    if steady:
        ways_of_runs = (np.unique(np.sign(_speeds(part)[part.mask()])) for part in steady)
        return frozenset(int(way) for ways in ways_of_runs for way in ways if way)
    ways = [
        (stroke.direction, float(np.ptp(part.recording.position[rows])))
        for part in parts
        for mask in [part.mask()]
        for stroke in segment(part.recording).strokes
        if (rows := np.flatnonzero(mask[stroke.rows]) + stroke.rows.start).size
    ]
    least = _TRAVEL * max((travel for _, travel in ways), default=0.0)
    return frozenset(direction for direction, travel in ways if travel > least)


@dataclass(frozen=True, eq=False)
class Split:
    """What one round trains on, and what it holds out; no sample is in both."""

    train: tuple[LogRange, ...]
    held: tuple[LogRange, ...]


@dataclass(frozen=True, eq=False)
class Splits:
    """All rounds of a comparison.

    Args:
        kind: What is held out: what was asked for, logs in turn, strokes in turn, parts of the
            time in turn, or runs of tables in turn.
        text: The same in words.
        whole: All that may be trained on: what the law that is recommended is fitted to.
        rounds: One for data that was held out on purpose, or one for each fold.
    """

    kind: Kind
    text: str
    whole: tuple[LogRange, ...]
    rounds: tuple[Split, ...]


def splits(
    logs: Sequence[Recording],
    rig: Rig,
    train: Sequence[Range],
    holdout: Sequence[Range],
    test: Sequence[Recording],
    folds: int,
) -> Splits:
    """Sort logs and ranges into rounds of training and holding out.

    Args:
        logs: To train on.
        rig: The axis.
        train: Ranges to train on; everything if there is none.
        holdout: Ranges to hold out.
        test: Whole logs to hold out.
        folds: Rounds where nothing was given to be held out.

    Raises:
        InputError: no log passes a range, hold-outs overlap what is trained on, or the logs are
            too short for so many folds.
    """
    whole = _portions(logs, train)
    if not (holdout or test):
        return _folded(logs, whole, rig, folds)
    if twice := [log for log in test if any(log is trained for trained in logs)]:
        raise InputError(f"{twice[0].label}: is trained on and tested: give it once")
    held_out = (*(_portions(logs, holdout) if holdout else ()), *_portions(test, []))
    for part in held_out:
        if any(_overlap(part, trained) for trained in whole):
            assert part.within is not None  # noqa: S101 - test logs are not trained on
            raise InputError(
                f"hold-out {part.within.text} overlaps the training data, so that its error says "
                f"nothing: give {option('train')} as well"
            )
    texts = [f"ranges {', '.join(r.text for r in holdout)}"] if holdout else []
    texts += [f"{len(test)} test log{'s' * (len(test) > 1)}"] if test else []
    return Splits("hold-out", " and ".join(texts), whole, (Split(whole, held_out),))


def _portions(logs: Sequence[Recording], ranges: Sequence[Range]) -> tuple[LogRange, ...]:
    """Each range in each log that passes it.

    Raises:
        InputError: a log passes none of the ranges, or a range is passed by no log.
    """
    if not ranges:
        return tuple(LogRange(log, None) for log in logs)
    parts: list[LogRange] = []
    refused: dict[int, InputError] = {}
    for part in ranges:
        before = len(parts)
        for log in logs:
            try:
                windows(log, part)
            except InputError as error:
                refused[id(log)] = error
            else:
                parts.append(LogRange(log, part))
        if len(parts) == before:
            raise refused[id(logs[0])]
    return tuple(parts)


def _overlap(a: LogRange, b: LogRange) -> bool:
    return a.recording is b.recording and bool((a.mask() & b.mask()).any())


def _folded(logs: Sequence[Recording], whole: tuple[LogRange, ...], rig: Rig, folds: int) -> Splits:
    if folds < 2:  # noqa: PLR2004 - with one fold, nothing is left to train on
        raise InputError(f"folds: give 2 or more, got {folds}")
    if any(log.runs is not None for log in logs):
        return _runs_in_turn(logs, whole, folds)
    if len(logs) >= _LOGS and _all_directions(logs, folds := min(folds, len(logs))):
        groups = [set(map(id, logs[k::folds])) for k in range(folds)]
        rounds = tuple(
            Split(
                tuple(p for p in whole if id(p.recording) not in group),
                tuple(p for p in whole if id(p.recording) in group),
            )
            for group in groups
        )
        text = f"{len(logs)} logs, each held out once in {folds} rounds"
        return Splits("logs", text, whole, rounds)
    masks = {id(log): np.zeros(len(log), dtype=bool) for log in logs}
    for p in whole:
        masks[id(p.recording)] |= p.mask()
    by_stroke = all(len(segment(log).strokes) >= 2 * folds for log in logs)
    rounds = tuple(
        Split(*_round(logs, masks, rig, folds, k, by_stroke=by_stroke)) for k in range(folds)
    )
    text = "whole strokes" if by_stroke else "a part of every stroke"
    return Splits("strokes" if by_stroke else "time", f"{text}, in {folds} rounds", whole, rounds)


def _runs_in_turn(logs: Sequence[Recording], whole: tuple[LogRange, ...], folds: int) -> Splits:
    """Of each direction every so many-th run in the order of speeds, so that none reaches far."""
    folds = min(folds, *(len(log) for log in logs))
    dealt = [_dealt(_speeds(part), folds) for part in whole]
    rounds = tuple(
        Split(
            tuple(LogRange(log, None, which != k) for log, which in zip(logs, dealt, strict=True)),
            tuple(LogRange(log, None, which == k) for log, which in zip(logs, dealt, strict=True)),
        )
        for k in range(folds)
    )
    return Splits("runs", f"runs in turn, in {folds} rounds", whole, rounds)


def _dealt(v: Array, folds: int) -> NDArray[np.intp]:
    """The round of each run, (N,)."""
    which = np.zeros(len(v), dtype=np.intp)
    for way in (v >= 0.0, v < 0.0):
        order = np.argsort(np.abs(v[way]), kind="stable")
        places = np.empty(len(order), dtype=np.intp)
        places[order] = np.arange(len(order)) % folds
        which[way] = places
    return which


def _speeds(part: LogRange) -> Array:
    velocity = part.recording.velocity
    return np.zeros(len(part.recording)) if velocity is None else velocity


def _all_directions(logs: Sequence[Recording], folds: int) -> bool:
    """Whether the logs left in every round run in all directions of those held out."""
    directions = [{s.direction for s in segment(log).strokes} for log in logs]
    for k in range(folds):
        held_out = set().union(*directions[k::folds])
        if held_out - set().union(*(w for i, w in enumerate(directions) if i % folds != k)):
            return False
    return True


def _round(
    logs: Sequence[Recording],
    masks: dict[int, Mask],
    rig: Rig,
    folds: int,
    k: int,
    *,
    by_stroke: bool,
) -> tuple[tuple[LogRange, ...], tuple[LogRange, ...]]:
    train: list[LogRange] = []
    held_out: list[LogRange] = []
    for log in logs:
        out = np.zeros(len(log), dtype=bool)
        for part in _parts(log, folds, k, by_stroke=by_stroke):
            out[part] = True
        base = masks[id(log)]
        train += _ranges(log, base & ~within(out, rig.filter_reach(log.dt)))
        held_out += _ranges(log, base & out)
    for purpose, parts in (("trained on", train), ("held out", held_out)):
        if not parts:
            raise InputError(
                f"{logs[0].label}: is too short for {folds} folds, so that nothing is {purpose}: "
                f"give fewer ({option('folds', 2)}), a range to hold out ({option('holdout')}), or "
                "longer logs"
            )
    return tuple(train), tuple(held_out)


def _parts(log: Recording, folds: int, k: int, *, by_stroke: bool) -> Iterator[slice]:
    """What fold k holds out of a log."""
    begins = [s.rows.start for s in segment(log).strokes[1:]]
    edges = [0, *begins, len(log)]
    if by_stroke:
        at = np.linspace(0, len(edges) - 1, folds + 1).round().astype(int)
        yield slice(edges[at[k]], edges[at[k + 1]])
        return
    for a, b in pairwise(edges):
        cut = np.linspace(a, b, folds + 1).round().astype(int)
        yield slice(int(cut[k]), int(cut[k + 1]))


def _ranges(log: Recording, mask: Mask) -> list[LogRange]:
    """The runs of a mask that are long enough, as ranges of time."""
    t = np.append(log.t, log.t[-1] + log.dt)
    ends = [(t[run.start], t[run.stop]) for run in slices(mask) if run.stop - run.start >= FEWEST]
    return [
        LogRange(log, Range(f"{a:.6g}s:{b:.6g}s", float(a), float(b), timed=True)) for a, b in ends
    ]
