"""A log file as its reader opens it: what is in it, and samples of what is asked for."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, Protocol, runtime_checkable

import numpy as np

from ...space import Array
from .interval import Interval
from .raw_table import RawTable


@dataclass(frozen=True)
class Channel:
    """A series of a log, before its samples are read.

    Args:
        name: As the file has it, each name once.
        unit: As the file states it beside the name, None if it states none.
        count: Samples.
        clock: Channels of one clock were measured at the same instants.
        rate: Samples a second by the file's own clock, Hz; None if a column has to tell.
        span: First and last instant, s on that clock.
        ends: Its first and last number.
        constant: Whether it is one number that holds for the whole log.
        is_time: Whether its clock is made of it, so that it is no other channel.
    """

    name: str
    unit: str | None = None
    count: int = 0
    clock: str = ""
    rate: float | None = None
    span: tuple[float, float] | None = None
    ends: tuple[float, float] | None = None
    constant: bool = False
    is_time: bool = False


@dataclass(frozen=True)
class ReadOptions:
    """What a file may not say about itself.

    Args:
        rate: Of a log without times, Hz.
        time_unit: Of times whose unit the format leaves open.
        stamp: Which time of a message counts: its header's, or that of its log.
        episode: Which of several logs in a file or folder is read: its number, or its group.
    """

    rate: float | None = None
    time_unit: str | None = None
    stamp: Literal["header", "log"] = "header"
    episode: str | None = None


class LogFile(Protocol):
    """A file that a reader has opened."""

    @property
    def channels(self) -> tuple[Channel, ...]:
        """What is in it, in the order of the file, constants last."""

    @property
    def text(self) -> Mapping[str, tuple[str, str]]:
        """Column of text -> the place and the content of its first cell that is no number."""

    @property
    def problems(self) -> tuple[str, ...]:
        """What was left out, or looks wrong, a sentence each."""

    @property
    def lacking(self) -> str:
        """What has to be said before its times are in s, and how; empty if they are."""

    def tables(self, names: Collection[str] | None = None) -> tuple[RawTable, ...]:
        """Samples of channels, a table a clock; of all channels if no names are given.

        Raises:
            InputError: they are broken, or take more memory than the file's size allows.
        """


@runtime_checkable
class LogInParts(Protocol):
    """A `LogFile` of which a part can be read without the rest."""

    def part(self, names: Collection[str], interval: Interval) -> tuple[RawTable, ...]:
        """Samples of channels in an interval, and a few beside it; all where that is not known.

        Raises:
            InputError: as `tables` does.
        """


@dataclass(frozen=True)
class Reader:
    """A format of logs.

    Args:
        name: As people type it.
        title: What writes it, and what it is.
        suffixes: Its usual file extensions, in lower case with their dot.
        opens: Whether a path, with the first bytes of its file (none for a folder), is one.
        open: Opens it; an InputError says in one line why it cannot.
        extra: What is installed for it: `pip install "stribeck[EXTRA]"`; empty for nothing.
        library: What reads it, with its licence; empty for this package.
        folders: Whether a log of it is a folder.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    opens: Callable[[Path, bytes], bool]
    open: Callable[[Path, ReadOptions], LogFile]
    extra: str = ""
    library: str = ""
    folders: bool = False


@dataclass(frozen=True, eq=False)
class TablesInMemory:
    """A log whose samples are read as it is opened.

    Args:
        all_tables: A table a clock.
        notes: What was left out, or looks wrong, a sentence each.
        lacking: What has to be said before times are in s, and how.
    """

    all_tables: tuple[RawTable, ...]
    notes: tuple[str, ...] = ()
    lacking: str = ""

    @property
    def channels(self) -> tuple[Channel, ...]:
        """All columns, then all single numbers."""
        columns = [_channel(table, name) for table in self.all_tables for name in table.columns]
        constants = [
            Channel(name, table.units.get(name), 1, ends=(value, value), constant=True)
            for table in self.all_tables
            for name, value in table.scalars.items()
        ]
        return (*columns, *constants)

    @property
    def text(self) -> Mapping[str, tuple[str, str]]:
        """Where columns of text begin to be that."""
        return {name: place for table in self.all_tables for name, place in table.text.items()}

    @property
    def problems(self) -> tuple[str, ...]:
        """What the tables note."""
        return tuple(note for table in self.all_tables for note in table.notes) + self.notes

    def tables(self, names: Collection[str] | None = None) -> tuple[RawTable, ...]:
        """Those that have one of the channels, with these alone."""
        if names is None:
            return self.all_tables
        kept = [
            replace(
                table,
                columns={n: a for n, a in table.columns.items() if n in names},
                scalars={n: a for n, a in table.scalars.items() if n in names},
            )
            for table in self.all_tables
        ]
        return tuple(table for table in kept if table.columns or table.scalars)


def _channel(table: RawTable, name: str) -> Channel:
    values = table.columns[name]
    finite = np.flatnonzero(np.isfinite(values))
    ends = (float(values[finite[0]]), float(values[finite[-1]])) if len(finite) else None
    rate, span = (None, None) if table.t is None else timing(table.t)
    return Channel(name, table.units.get(name), len(finite), table.clock, rate, span, ends)


def timing(t: Array) -> tuple[float | None, tuple[float, float] | None]:
    """Samples a second, and the first and last instant, of times in s."""
    if len(t) == 0:
        return None, None
    intervals = np.diff(t)
    middle = float(np.median(intervals)) if len(intervals) else 0.0
    rate = float(f"{1.0 / middle:.9g}") if middle > 0.0 else None  # times are rounded, too
    return rate, (float(t[0]), float(t[-1]))
