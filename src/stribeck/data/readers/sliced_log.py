"""A log of which its format reads ranges of rows, so that no more than a piece is in memory."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ...space import Array
from .interval import BESIDE, Interval
from .log_file import Channel
from .raw_table import RawTable


class SlicedRows(NamedTuple):
    """Some rows of channels of one clock: their instants, s, if they have a clock, and samples."""

    t: Array | None
    columns: Mapping[str, Array]

    @property
    def rows(self) -> int:
        """How many."""
        return len(next(iter(self.columns.values())))


class TablePart(NamedTuple):
    """A table without its samples, and those of its rows that are wanted, from 0."""

    table: RawTable
    rows: range


@dataclass(frozen=True, eq=False)
class SlicedLog:
    """An open file.

    Args:
        channels: What is in it.
        empty: A table of channels of one clock without rows.
        pieces: Consecutive pieces of some of their rows.
        scalars: Single numbers.
        problems: What was left out, or looks wrong, a sentence each.
        text: Column of text -> the place and the content of its first cell that is no number.
        lacking: What has to be said before times are in s, and how.
        find: The rows whose times lie in an interval; where a format cannot say, their times are
            taken to rise and a few of them read.
    """

    channels: tuple[Channel, ...]
    empty: Callable[[Sequence[str]], RawTable]
    pieces: Callable[[Sequence[str], range], Iterator[SlicedRows]]
    scalars: Mapping[str, float] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    text: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    lacking: str = ""
    find: Callable[[Interval], range] | None = None

    def tables(self, names: Collection[str] | None = None) -> tuple[RawTable, ...]:
        """Samples of channels, a table a clock; of all channels if no names are given."""
        return tuple(
            filled(part, self.pieces(list(part.table.columns), part.rows))
            for part in self.parts(names)
        )

    def parts(
        self, names: Collection[str] | None = None, interval: Interval | None = None
    ) -> list[TablePart]:
        """Tables of channels, a clock each, and their rows in an interval and a few beside it."""
        clocks: dict[tuple[str, int], list[str]] = {}
        wanted = [c for c in self.channels if names is None or c.name in names]
        for c in wanted:
            if not c.constant:
                clocks.setdefault((c.clock, c.count), []).append(c.name)
        parts = [
            TablePart(self.empty(alike), self._rows(clock, alike, count, interval))
            for (clock, count), alike in clocks.items()
        ]
        scalars = {c.name: self.scalars[c.name] for c in wanted if c.constant}
        if not scalars:
            return parts
        if not parts:
            return [TablePart(RawTable({}, np.empty(0, np.int64), scalars=scalars), range(0))]
        longest = max(range(len(parts)), key=lambda k: len(parts[k].rows))
        table, rows = parts[longest]
        parts[longest] = TablePart(replace(table, scalars=scalars), rows)
        return parts

    def _rows(
        self, clock: str, names: Sequence[str], count: int, interval: Interval | None
    ) -> range:
        """The rows of an interval; all where their times are not known or not in order."""
        if interval is None or (interval.column not in names if interval.column else not clock):
            return range(count)
        if self.find is not None:
            inside = self.find(interval)
            return _about(inside.start, inside.stop, count) if inside else inside

        def instant(row: int) -> float:
            column = [interval.column] if interval.column else names[:1]
            piece = next(self.pieces(column, range(row, row + 1)))
            t = piece.columns[interval.column] if interval.column else piece.t
            return float("nan") if t is None else float(t[0])

        if not instant(0) <= instant(count - 1):
            return range(count)
        # An instant that is not known counts as one beyond: rows too many, never too few.
        first = bisect_left(range(count), interval.first, key=instant)
        stop = bisect_right(range(count), interval.last, key=instant)
        return _about(first, stop, count)


def _about(first: int, stop: int, count: int) -> range:
    return range(max(first - BESIDE, 0), min(stop + BESIDE, count))


def filled(part: TablePart, pieces: Iterator[SlicedRows]) -> RawTable:
    """A table with its samples, which come in pieces."""
    count, at = len(part.rows), 0
    table = part.table
    t = None if table.t is None else np.empty(count)
    columns = {name: np.empty(count) for name in table.columns}
    while at < count:
        piece = next(pieces)
        rows = slice(at, at + piece.rows)
        if t is not None:
            t[rows] = piece.t
        for name, values in columns.items():
            values[rows] = piece.columns[name]
        at = rows.stop
    places = range(part.rows.start + 1, part.rows.stop + 1)
    return replace(table, columns=columns, t=t, places=places)
