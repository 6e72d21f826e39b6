"""Several files of one run as one log, all of their clocks brought onto one."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import InputError
from .clock_difference import ClockDifference, clock_difference
from .column_map import Entry
from .heads import meanings, take_apart
from .log_file import Channel, LogFile, Reader, ReadOptions
from .log_path import BETWEEN
from .raw_table import RawTable, shortened
from .registry import opened
from .run_clocks import (
    CommonClock,
    FileClock,
    certain,
    clocks_sentence,
    difference_sentence,
    overlap,
    shifts,
    strangers,
)
from .run_file import RunFile


@dataclass(frozen=True, eq=False)
class JoinedRun:
    """An open run of several files.

    Args:
        files: Its files.
        clocks: Of each.
        common: The clock of each on that of the run.
        problems: How the clocks were joined, and what is wrong in a file, a sentence each.
        lacking: Why they cannot be joined; empty if they can.
    """

    files: tuple[RunFile, ...]
    clocks: tuple[FileClock, ...]
    common: tuple[CommonClock, ...]
    problems: tuple[str, ...] = ()
    lacking: str = ""

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Those of all files, in their order, constants last."""
        every: list[Channel] = []
        for file, clock, common in zip(self.files, self.clocks, self.common, strict=True):
            first, last = common.times(np.array(clock.span))
            every += file.channels((float(first), float(last)), clock.interval)
        return tuple(sorted(every, key=lambda c: c.constant))

    @property
    def text(self) -> Mapping[str, tuple[str, str]]:
        """Where columns of text begin to be that."""
        return {
            file.names[n]: (f"{file.name}, {place}", cell)
            for file in self.files
            for n, (place, cell) in file.log.text.items()
        }

    def tables(self, names: Collection[str] | None = None) -> tuple[RawTable, ...]:
        """Samples of channels on the clock of the run, but for columns of times."""
        result = []
        for file, common in zip(self.files, self.common, strict=True):
            wanted = {own for own, name in file.names.items() if names is None or name in names}
            wanted -= {file.time.column} if file.time is not None else set()
            for table in file.tables(wanted) if wanted else ():
                called = file.called(table, wanted)
                if called.columns or called.scalars:
                    t = None if table.t is None else common.times(table.t)
                    result.append(replace(called, t=t))
        return tuple(result)


def opened_run(
    paths: Sequence[Path],
    options: ReadOptions,
    time: Entry | None = None,
    units: Mapping[str, str] | None = None,
) -> tuple[Reader, JoinedRun]:
    """The files of a run, and what they are together; clocks that do not go together are told.

    Args:
        paths: Its files.
        options: Of all of them.
        time: The column of times of those that have it, as a map says it.
        units: Unit by column, where the heads do not say it.

    Raises:
        InputError: one of them is not there, of no format that is read, or broken.
    """
    places = [path.resolve() for path in paths]
    if twice := next((p.name for p in paths if places.count(p.resolve()) > 1), ""):
        raise InputError(f"{twice} stands twice: name each file of a run once")
    taken: set[str] = set()
    files, formats = [], []
    for k, path in enumerate(paths, 1):
        try:
            reader, log = opened(path, options)
            names = _names(log, k, taken)
            files.append(RunFile.of(path.name, log, names, options, time, units or {}))
        except InputError as error:
            text = str(error).removeprefix(f"{path.name}: ")
            raise type(error)(f"{path.name}: {text}") from error
        formats.append(reader)
    named = replace(formats[0], name=BETWEEN.join(f.name for f in formats))
    return named, _joined(tuple(files))


def _names(log: LogFile, k: int, taken: set[str]) -> dict[str, str]:
    """What its channels are called in the run: one that is taken has its file's number before."""
    names = {c.name: c.name if c.name not in taken else f"{k}/{c.name}" for c in log.channels}
    taken.update(names.values())
    return names


class _Signal(NamedTuple):
    """A signal that two files have, and what it says about their clocks."""

    name: str
    difference: ClockDifference


def _joined(files: tuple[RunFile, ...]) -> JoinedRun:
    """The run of these files."""
    files = tuple(file.timed_by(files) for file in files)
    problems = [f"{file.name}: {p}" for file in files for p in file.log.problems]
    if lacking := next((file.lacking for file in files if file.lacking), ""):
        none = tuple(FileClock(file.name, (0.0, 0.0), 0.0) for file in files)
        return JoinedRun(files, none, (CommonClock(0.0),) * len(files), tuple(problems), lacking)
    clocks = tuple(file.clock() for file in files)
    common = [CommonClock(shift) for shift in shifts(clocks)]
    first, sentences = files[0], list[str]()
    for k, other in enumerate(files[1:], 1):
        signal = _common_signal(first, common[0], other, common[k])
        if signal is None:
            lacking = lacking or strangers(clocks[0], clocks[k])
            continue
        corrected = certain(signal.difference, clocks[k])
        if corrected or clocks[0].counts != clocks[k].counts:
            common[k] = replace(common[k], difference=signal.difference)
        sentences.append(difference_sentence(clocks[0], clocks[k], *signal, corrected=corrected))
    own = [k for k, file in enumerate(files) if file.beside is None]
    if len(sentences) < len(own) - 1:
        sentences.append("a drift of clocks shows only where two files have a signal in common")
    both, apart = overlap(clocks, common)
    lacking = lacking or apart
    if len(own) > 1 and not lacking:
        chosen = [clocks[k] for k in own], [common[k] for k in own]
        sentences.insert(0, clocks_sentence(*chosen, both))
    sentences += _renamed(files)
    sentences += [
        f"{shortened(f.name)} says no times: its {f.rows} rows are at those of "
        f"{shortened(f.beside.name)}"
        for f in files
        if f.beside is not None
    ]
    return JoinedRun(files, clocks, tuple(common), (*sentences, *problems), lacking)


def _renamed(files: Sequence[RunFile]) -> list[str]:
    """A sentence on each channel that has not its own name, but for times."""
    return [
        f"{shortened(own)} of {shortened(file.name)} is called {shortened(name)} here"
        for file in files
        for own, name in file.names.items()
        if own != name and (file.time is None or own != file.time.column)
    ]


def _common_signal(
    first: RunFile, one: CommonClock, other: RunFile, two: CommonClock
) -> _Signal | None:
    """The signal in both whose clocks it tells best; None if they have none."""
    signals = []
    for name in first.names:
        if name not in other.names or "time" in meanings(take_apart(name)):
            continue
        (t, a), (t_other, b) = first.signal(name), other.signal(name)
        difference = clock_difference(one.times(t), a, two.times(t_other), b)
        if difference is not None:
            signals.append(_Signal(name, difference))
    return min(signals, key=lambda s: s.difference.offset_error, default=None)
