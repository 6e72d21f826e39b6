"""LVM, the text of LabVIEW and SignalExpress (National Instruments), by its published format.

A head of `key<separator>value` lines ends with `***End_of_Header***`; then each segment has a head
of its own, with a value for each channel (samples, unit, X0, Delta_X), a row of names, and samples
that have a column of times, one for each channel, or none.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...space import Array
from ...wording import option
from .arrays import TimedSeries, by_times
from .budget import ReadBudget, refuse_many
from .cells import number_columns
from .file_bytes import whole
from .log_file import Reader, ReadOptions, TablesInMemory
from .raw_table import printable, unique_names
from .text_encoding import utf8

_BEGINS = b"LabVIEW Measurement"
_END = re.compile(rb"(?m)^\*\*\*End_of_Header\*\*\*[^\n]*\n?")
_NEXT = re.compile(rb"(?m)^Channels[\t,]")
_NAMES = re.compile(rb"(?m)^X_Value[^\n]*\n")
_TIME, _COMMENT = "X_Value", "Comment"
#: No start of a log is so late, and no step of it so long: s.
LONGEST = 1e12


@dataclass(frozen=True)
class _LvmSegment:
    """A segment of the file.

    Args:
        heads: Key -> cells, the first of which is the key.
        names: Cells of the row of names.
        samples: The lines below it.
        line: Of the first of these, from 1.
    """

    heads: dict[str, list[str]]
    names: list[str]
    samples: bytes
    line: int

    def cell(self, key: str, column: int, channel: int) -> str:
        """What a row of the head says of a channel: in its column, or in the order of channels."""
        cells = self.heads.get(key, [])
        if column < len(cells) and cells[column]:
            return cells[column]
        filled = [c for c in cells[1:] if c]
        return filled[channel] if channel < len(filled) else ""

    def number(self, key: str, column: int, channel: int) -> float | None:
        """The same as a number."""
        try:
            return float(self.cell(key, column, channel).replace(",", "."))
        except ValueError:
            return None


def _opens(_path: Path, head: bytes) -> bool:
    return head.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(_BEGINS)


def _open(path: Path, options: ReadOptions) -> TablesInMemory:
    data = utf8(whole(path))
    separator = b"," if re.search(rb"(?mi)^Separator[\t,]+Comma", data[: 1 << 12]) else b"\t"
    segments = list(_segments(data, separator.decode()))
    if not segments:
        raise InputError("its heads do not end, or no samples follow: export it again")
    number, notes = _chosen(segments, options.episode)
    segment = segments[number]
    rows = segment.samples.count(b"\n") + 1
    ReadBudget(len(data)).take_cells(rows, len(segment.names))
    tables = by_times(_series(segment, separator.decode()), segment.line)
    if not tables:
        raise InputError("has heads and no samples")
    return TablesInMemory(tuple(tables), notes)


READER = Reader(
    "lvm",
    "LVM, text of LabVIEW and SignalExpress (National Instruments)",
    (".lvm", ".txt"),
    _opens,
    _open,
)


def _segments(data: bytes, separator: str) -> Iterator[_LvmSegment]:
    """Those that have names and samples."""
    ends = [m.span() for m in _END.finditer(data)]
    refuse_many(len(ends), "segments")
    begin = 0
    for k, (stop, start) in enumerate(ends):
        until = ends[k + 1][0] if k + 1 < len(ends) else len(data)
        heads = _heads(data[begin:stop], separator)
        if names := _NAMES.search(data, start, until):
            following = _NEXT.search(data, names.end(), until)
            until = following.start() if following else until
            line = data.count(b"\n", 0, names.end()) + 1
            cells = [printable(c) for c in names[0].decode(errors="replace").split(separator)]
            yield _LvmSegment(heads, cells, data[names.end() : until].strip(b"\n"), line)
            begin = until
        # else: the head of the file, which goes on in that of its first segment


def _heads(text: bytes, separator: str) -> dict[str, list[str]]:
    rows = (line.split(separator) for line in text.decode(errors="replace").split("\n"))
    return {row[0].strip(): [c.strip() for c in row] for row in rows if row[0].strip()}


def _chosen(segments: list[_LvmSegment], part: str | None) -> tuple[int, tuple[str, ...]]:
    """Which segment is read, from 0, and a word on the others."""
    count = len(segments)
    if part is not None:
        if not part.isdecimal() or not 1 <= int(part) <= count:
            raise InputError(f"has no segment {printable(part)[:20]}: there are 1 to {count}")
        return int(part) - 1, ()
    following = option("columns", {"episode": "2"})
    note = f"has {count} segments: the first is read; {following} takes the next"
    return 0, (note,) if count > 1 else ()


def _series(segment: _LvmSegment, separator: str) -> Iterator[TimedSeries]:
    """The channels of a segment with their times."""
    frame = number_columns(segment.samples, len(segment.names), separator)
    columns = [np.asarray(s.to_numpy(), dtype=float) for s in frame.iter_columns()]
    numbered = [i for i, name in enumerate(segment.names) if name and name not in (_TIME, _COMMENT)]
    names = unique_names([segment.names[i] for i in numbered])
    for channel, (i, name) in enumerate(zip(numbered, names, strict=True)):
        before = max((k for k in range(i) if segment.names[k] == _TIME), default=None)
        rows = np.flatnonzero(np.isfinite(columns[i]))
        if len(rows) == 0:
            continue
        rows = np.arange(rows[-1] + 1)
        written = np.full(len(rows), np.nan) if before is None else columns[before][rows]
        t = _times(segment, written, i, channel)
        if t is not None:
            unit = segment.cell("Y_Unit_Label", i, channel)
            yield TimedSeries(name, t, columns[i][rows], printable(unit))


def _times(segment: _LvmSegment, written: Array, column: int, channel: int) -> Array | None:
    """Times of samples: as written, else from the first by the step in the head."""
    if np.isfinite(written).all():
        return written
    step = segment.number("Delta_X", column, channel)
    start = segment.number("X0", column, channel) or 0.0
    if step is None or not 0.0 < step < LONGEST or not abs(start) < LONGEST:
        return None
    return start + step * np.arange(float(len(written)))
