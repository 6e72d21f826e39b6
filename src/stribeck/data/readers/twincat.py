"""TwinCAT Scope's text export (Beckhoff): blocks of heads, then columns with times of their own.

A first block names the scope, its file and when the export begins, as FILETIME (100 ns since
1601); a second has a row for each property of the channels: name, type, sample time, unit, scale.
In both the first column of a group says what the row is; below it stand the times of the group, in
ms since the start of the export. Separator, decimal mark, a closing line `EOF` and whether channels
share a column of times are settings of the export.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ...space import Array
from .budget import ReadBudget
from .cells import number_columns
from .file_bytes import whole
from .log_file import Reader, ReadOptions, TablesInMemory
from .raw_table import RawTable, printable, shortened, unique_names
from .stamps import epoch
from .text_encoding import utf8

if TYPE_CHECKING:
    import polars as pl

_BEGINS = re.compile(r'"?Name"?([\t,; ])')
_START = "Starttime of export"
_BEGAN = re.compile(rb'(?m)^"?Starttime of export"?[\t,; ]+"?(\d{17,19})')
#: Properties of channels that are used, as the export heads their rows.
_NAME, _UNIT, _TYPE = "Name", "Unit", "Data-Type"
_SCALES = (("ScaleFactor", 1.0), ("Offset", 0.0), ("Unit ScaleFactor", 1.0), ("Unit Offset", 0.0))
_MILLISECOND = 1e-3
_HEAD_LINES = 200


@dataclass(frozen=True)
class _ScopeHeads:
    """The rows of properties.

    Args:
        rows: Property -> its cells, one a column.
        times: The columns that hold times.
        first: Line at which the samples begin, from 0.
    """

    rows: dict[str, list[str]]
    times: list[int]
    first: int

    @property
    def width(self) -> int:
        """How many columns there are."""
        return len(self.rows[_TYPE])


def _opens(_path: Path, head: bytes) -> bool:
    text = head.decode(errors="replace").removeprefix("\ufeff")
    return _BEGINS.match(text) is not None and _START in text


def _open(path: Path, _options: ReadOptions) -> TablesInMemory:
    data = whole(path)
    text = utf8(data)
    begins = _BEGINS.match(text[: 1 << 12].decode(errors="replace"))
    if begins is None:
        raise InputError("is a broken export of TwinCAT Scope: export it again")
    heads = _heads(text, begins[1])
    ReadBudget(len(data)).take_cells(text.count(b"\n") + 1 - heads.first, heads.width)
    frame = _numbers(text, heads, begins[1])
    tables = (replace(table, began=_began(text)) for table in _grouped(frame, heads))
    return TablesInMemory(tuple(tables), _told_scales(heads))


READER = Reader("twincat", "TwinCAT Scope, text export (Beckhoff)", (".csv", ".txt"), _opens, _open)


def _began(text: bytes) -> float | None:
    """When the export begins, s since 1970; None if that is no date."""
    start = _BEGAN.search(text[: 1 << 12])
    if start is None or (clock := epoch(count := float(start[1]))) is None:
        return None
    return count * clock.tick - clock.origin


def _heads(text: bytes, separator: str) -> _ScopeHeads:
    lines = text.split(b"\n", _HEAD_LINES)[:_HEAD_LINES]
    rows: dict[str, list[str]] = {}
    block = 0
    for i, line in enumerate(lines):
        words = line.decode(errors="replace").rstrip("\r")
        if not words.strip():
            block += bool(rows) and block == 1
            if block > 1:
                return _checked(rows, separator, i + 1)
            rows, block = {}, 1
            continue
        fields = _fields(words, separator)
        if (
            separator == " "
            and fields[0] == "Unit"
            and fields[1:2] in (["ScaleFactor"], ["Offset"])
        ):
            key = f"Unit {fields[1]}"  # two words: of each group
            fields = _fields(words.replace(key, key.replace(" ", "_")), separator)
            fields[0] = key
        rows[fields[0]] = fields
    raise InputError("its heads do not end: export it from TwinCAT Scope again")


def _checked(rows: dict[str, list[str]], separator: str, first: int) -> _ScopeHeads:
    """The rows at one width, names among them.

    Raises:
        InputError: there is none of types, from which columns are known.
    """
    types = rows.get(_TYPE, [])
    times = [i for i, cell in enumerate(types) if cell == _TYPE]
    if _NAME not in rows or not times or times[0] != 0:
        raise InputError("its heads name no channels: export it from TwinCAT Scope again")
    if separator == " ":
        rows[_NAME] = _joined_names(rows[_NAME], types)
        rows[_UNIT] = _without_kinds(rows.get(_UNIT, []))
    padded = {key: [*cells, *[""] * len(types)][: len(types)] for key, cells in rows.items()}
    return _ScopeHeads(padded, times, first)


def _fields(line: str, separator: str) -> list[str]:
    try:
        fields = next(csv.reader([line], delimiter=separator), [])
    except csv.Error:
        fields = line.split(separator)
    return [f.strip() for f in fields] or [""]


def _without_kinds(cells: list[str]) -> list[str]:
    """Units apart by blanks without the kinds in brackets that follow them: `V (Voltage)`."""
    return [c for i, c in enumerate(cells) if not (c.startswith("(") and c != "(None)" and i)]


def _joined_names(words: list[str], types: list[str]) -> list[str]:
    """Names apart by blanks, some with blanks in them: as many as there are types.

    The export tells equal names apart by ` (1)`, so that what stands before that stands alone
    elsewhere: both are put together. Where that is not enough columns go by their number.
    """
    names = list(words)
    while len(names) > len(types):
        at = next((i for i in range(len(names) - 1, 0, -1)
                   if re.fullmatch(r"\(\d+\)", names[i])), None)  # fmt: skip
        if at is None:
            break
        names[at - 1 : at + 1] = [f"{names[at - 1]} {names[at]}"]
        _join_alike(names, at - 1)
    if len(names) == len(types):
        return names
    return [t if t == _TYPE else f"column {i + 1}" for i, t in enumerate(types)]


def _join_alike(names: list[str], at: int) -> None:
    """Join to a name with a number the words before it that also stand before its bare name."""
    bare = names[at].rpartition(" (")[0]
    while True:
        alike = [i for i in range(1, at - 1) if names[i] == bare and names[i - 1] == names[at - 1]]
        if not alike:
            return
        word = names[at - 1]
        names[at - 1 : at + 1] = [f"{word} {names[at]}"]
        names[alike[0] - 1 : alike[0] + 1] = [f"{word} {bare}"]
        bare, at = f"{word} {bare}", at - 2


def _numbers(text: bytes, heads: _ScopeHeads, separator: str) -> pl.DataFrame:
    """The samples, null where a column has ended."""
    lines = text.split(b"\n", heads.first)
    if len(lines) <= heads.first:
        raise InputError("has heads and no samples")
    body = lines[-1].replace(b"\r", b"")
    body = re.sub(rb"\n?EOF\s*$", b"\n", body)
    return number_columns(body, heads.width, separator)


def _grouped(frame: pl.DataFrame, heads: _ScopeHeads) -> tuple[RawTable, ...]:
    """A table for each clock; groups of equal times share one."""
    names = unique_names([
        name or f"column {i + 1}" if i not in heads.times else ""
        for i, name in enumerate(heads.rows[_NAME])
    ])  # fmt: skip
    clocks: list[tuple[Array, dict[str, Array], dict[str, str]]] = []
    for start, stop in zip(heads.times, [*heads.times[1:], heads.width], strict=True):
        t = _MILLISECOND * _column(frame, start)
        rows = np.isfinite(t)
        t = t[rows]
        clock = next((c for c in clocks if np.array_equal(c[0], t)), None)
        if clock is None:
            clock = (t, {}, {})
            clocks.append(clock)
        for i in range(start + 1, stop):
            clock[1][names[i]] = _column(frame, i)[rows]
            if unit := _unit(heads.rows.get(_UNIT, [""] * heads.width)[i]):
                clock[2][names[i]] = unit
    if not any(len(t) for t, _, _ in clocks):
        raise InputError("has heads and no samples")
    return tuple(
        RawTable(
            columns,
            np.arange(len(t)) + heads.first + 1,
            "line",
            units=units,
            t=t,
            clock=f"clock {i}",
        )
        for i, (t, columns, units) in enumerate(clocks, 1)
        if columns
    )


def _column(frame: pl.DataFrame, i: int) -> Array:
    return np.asarray(frame[str(i)].to_numpy(), dtype=float)


def _unit(cell: str) -> str:
    """`mm/s (Velocity)` without the kind."""
    unit = cell.partition(" (")[0].strip()
    return "" if unit == "(None)" else unit


def _told_scales(heads: _ScopeHeads) -> tuple[str, ...]:
    """A sentence on each channel that the scope shows in another scale than it exports."""
    sentences = []
    for i in range(heads.width):
        cells = {key: _number(heads.rows[key][i]) for key, _ in _SCALES if key in heads.rows}
        other = [f"{k} {cells[k]:g}" for k, plain in _SCALES
                 if k in cells and cells[k] is not None and cells[k] != plain]  # fmt: skip
        if other and i not in heads.times:
            name = shortened(heads.rows[_NAME][i])
            sentences.append(
                f"{name} has {' and '.join(other)} in the scope; its values are as the file has "
                "them: map a factor if these are raw"
            )
    return tuple(sentences)


def _number(cell: str) -> float | None:
    try:
        return float(printable(cell).replace(",", "."))
    except ValueError:
        return None
