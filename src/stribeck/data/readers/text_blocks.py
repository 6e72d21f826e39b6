"""A large text table, read a block of lines at a time: the columns that are asked for, no others.

Each block is a table of its own with the layout of the whole; what the words of a column are is one
rule for all blocks (`WordColumn`). So the samples are those of a whole read, in memory for the
columns that are asked for and one block. Lines are checked where they are read.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...space import Array
from .budget import ReadBudget
from .interval import BESIDE, Interval, cut
from .lines import Encoding, LineBlock, LinedFile, unpacked
from .log_file import Channel
from .raw_table import RawTable
from .text_columns import WordColumn
from .text_encoding import NO_TEXT, SNIFFED, UNMARKED, has_control
from .text_layout import TextLayout, text_layout
from .text_rows import TextRows, comment_mark
from .text_table import named, overrun_note, text_table, without_overruns

#: Files of more bytes are read in blocks of so many.
LARGE, BLOCK = 128 << 20, 8 << 20
#: Bytes at the begin of a block that show when it begins.
_FIRST = 1 << 14


class _TextColumns(NamedTuple):
    """Columns by their place, the line of each row, and how words became numbers."""

    values: dict[int, Array]
    lines: NDArray[np.int64] | range
    state: dict[int, WordColumn]


@dataclass(frozen=True, eq=False)
class BlockedText:
    """An open table.

    Args:
        file: Its lines.
        layout: Of it.
        comment: What lines that are no rows begin with.
        blocks: Of its rows.
        rows: In each block.
        names: Place of a column -> its name.
        channels: What is in it; their ends are those of the first and last block.
        text: Column that has words in one of these -> the place and the content of the first.
        problems: A sentence each.
    """

    file: LinedFile
    layout: TextLayout
    comment: str
    blocks: tuple[LineBlock, ...]
    rows: tuple[int, ...]
    names: Mapping[int, str]
    channels: tuple[Channel, ...] = ()
    text: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    lacking: str = ""

    def tables(self, names: Collection[str] | None = None) -> tuple[RawTable, ...]:
        """Samples of channels, of all if no names are given.

        Raises:
            InputError: a line is no row of the table, or they take too much memory.
        """
        return (self._table(self._places(names), range(len(self.blocks))),)

    def part(self, names: Collection[str], interval: Interval) -> tuple[RawTable, ...]:
        """Samples of channels in an interval of a column of times, and a few beside it.

        Raises:
            InputError: as `tables` does.
        """
        time = self._places([interval.column])
        starts = self._starts(time[0]) if time else None
        if starts is None:
            return self.tables(names)
        rows = np.concatenate([[0], np.cumsum(self.rows)])
        first = max(int(np.searchsorted(starts, interval.first)) - 1, 0)
        stop = max(int(np.searchsorted(starts, interval.last, side="right")), first + 1)
        first = int(np.searchsorted(rows, rows[first] - BESIDE, side="right")) - 1
        stop = int(np.searchsorted(rows, rows[stop] + BESIDE))
        chosen = range(max(first, 0), min(stop, len(self.blocks)))
        places = self._places({*names, interval.column})
        return (cut(self._table(places, chosen), interval),)

    def _places(self, names: Collection[str] | None) -> list[int]:
        return [i for i, name in self.names.items() if names is None or name in names]

    def _starts(self, time: int) -> Array | None:
        """The first instant of each block; None if they do not rise."""
        state = self._state([time])
        starts = []
        for block, text in self.file.each(self.blocks, _FIRST):
            values = self._rows_of(block, text).columns(state)[str(time)].to_numpy()
            finite = values[np.isfinite(values)]
            if not len(finite) or state[time].outdated or state[time].text is not None:
                return None
            starts.append(float(finite[0]))
        stamps = state[time].stamps
        rise = bool((np.diff(starts) > 0).all()) and not (stamps is not None and stamps.of_day)
        return np.array(starts) if rise else None

    def _state(self, places: Collection[int]) -> dict[int, WordColumn]:
        return {i: WordColumn(decimal_comma=self.layout.decimal_comma) for i in places}

    def _rows_of(self, block: LineBlock, text: bytes) -> TextRows:
        return TextRows(text, self.layout, self.comment, block.line)

    def _table(self, places: Collection[int], chosen: Sequence[int]) -> RawTable:
        ReadBudget(self.file.size).take_cells(sum(self.rows[k] for k in chosen), len(places))
        columns = self.columns(places, chosen)
        return text_table(columns.values, columns.lines, self.layout, columns.state, self.names)

    def columns(self, places: Collection[int], chosen: Sequence[int]) -> _TextColumns:
        """Columns over some blocks."""
        state = self._state(places)
        if chosen and chosen[0]:  # dates count from the first of the log
            for block, text in self.file.each(self.blocks[:1], _FIRST):
                self._rows_of(block, text).columns(state)
        while True:
            for column in state.values():
                column.restart()
            columns = self._in_state(state, chosen)
            if not any(column.outdated for column in state.values()):
                return columns

    def _in_state(self, state: dict[int, WordColumn], chosen: Sequence[int]) -> _TextColumns:
        count, at = sum(self.rows[k] for k in chosen), 0
        values = {i: np.empty(count) for i in state}
        lines = list[NDArray[np.int64] | range]()
        last = len(self.layout.heads) - 1  # shows that a line is too short
        read = state if last in state else {**state, **self._state([last])}
        blocks = [self.blocks[k] for k in chosen]
        for k, (block, text) in zip(chosen, self.file.each(blocks), strict=True):
            rows = self._rows_of(block, text)
            if rows.may_be_long(self.rows[k]):
                rows.refuse_long_rows()
            frame = rows.columns(read, at)
            if frame.height != self.rows[k]:
                raise InputError(
                    f"its rows behind line {block.line - 1} are not its lines: save it as plain CSV"
                )
            rows.refuse_short_rows(frame)
            part = slice(at, at + frame.height)
            for i, column in values.items():
                column[part] = frame[str(i)].to_numpy()
            lines.append(rows.places(frame.height))
            at = part.stop
        whole = {i: state[i].whole(v) for i, v in values.items()}
        return _TextColumns(whole, _chained(lines), state)


def _chained(parts: Sequence[NDArray[np.int64] | range]) -> NDArray[np.int64] | range:
    """The lines of blocks, one after another: a range where none is missing between."""
    ranges = [part for part in parts if isinstance(part, range)]
    if len(ranges) == len(parts) and all(a.stop == b.start for a, b in pairwise(ranges)):
        return range(ranges[0].start, ranges[-1].stop) if ranges else range(0)
    return np.concatenate([np.asarray(part) for part in parts])


def large_text(path: Path, block: int = BLOCK) -> BlockedText:
    """A text table whose samples are read when they are asked for.

    Args:
        path: Its path.
        block: Bytes that are read at a time.

    Raises:
        InputError: it is not text, or not a header with rows of numbers of one length below it.
    """
    for encoding in UNMARKED:
        with suppress(UnicodeDecodeError):
            return _opened(path, block, encoding)
    raise InputError(NO_TEXT)


def _opened(path: Path, block: int, otherwise: str) -> BlockedText:
    with unpacked(path) as opened:
        encoding = Encoding.of(opened.read(SNIFFED), otherwise)
    file = LinedFile(path, encoding, block)
    raw = file.head(8 * SNIFFED)  # the heads and the first rows, in characters of up to 4 bytes
    head = encoding.text(raw, torn=True)
    if has_control(head):
        raise InputError(NO_TEXT)
    head, _ = without_overruns(head)
    layout = text_layout(head)
    comment = comment_mark(head.split(b"\n", layout.first)[layout.first])
    blocks, rows = [], []
    for one, text in file.blocks(encoding.mark + encoding.after(raw, layout.first), layout):
        blocks.append(one)
        rows.append(TextRows(text, layout, comment, one.line).count())
    return _with_contents(BlockedText(file, layout, comment, tuple(blocks), tuple(rows), {}))


def _with_contents(log: BlockedText) -> BlockedText:
    """The same with its channels, as its first and last block show them."""
    last = len(log.blocks) - 1
    columns = log.columns(range(log.layout.width), sorted({0, last}))
    names = named(columns.values, log.layout, columns.state)
    table = text_table(columns.values, columns.lines, log.layout, columns.state, names)
    count = sum(log.rows)
    channels = [
        Channel(name, table.units.get(name), count, ends=_ends(values))
        for name, values in table.columns.items()
    ]
    problems = (*table.notes, *overrun_note(sum(b.overruns for b in log.blocks)))
    return replace(log, names=names, channels=tuple(channels), text=table.text, problems=problems)


def _ends(values: Array) -> tuple[float, float] | None:
    """The first and the last number."""
    finite = values[np.isfinite(values)]
    return (float(finite[0]), float(finite[-1])) if len(finite) else None
