"""JSON logs as tables: a list of records, an object that has one list, or a record a line.

Records are decoded one by one: as Python objects, all of them would take twenty times the file.
"""

from __future__ import annotations

import json
import math
import re
from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...text_file import unique
from .budget import ReadBudget, refuse_many
from .file_bytes import whole
from .log_file import Reader, ReadOptions, TablesInMemory
from .raw_table import RawTable, listed, shortened

_BLANKS = " \t\n\r"
_BLANK = re.compile(f"[{_BLANKS}]*")
_BEGINS = re.compile(rb"(?:\xef\xbb\xbf)?\s*(?:\{\s*(?:\"|$)|\[\s*(?:[\[{]|$))")
#: A record on a line of its own, and another below it.
_LINES = re.compile(r"\s*\{[^\n]*\}[ \t\r]*\n\s*\{")
_LIST = 400  # bytes of a list of ten numbers, and of its place in another
_NONE = 'has no list of records such as [{"t": 0.0, "x": 1.2}, ...]'
#: Whole numbers from here on are no measurements, and most are no floating-point numbers.
_BEYOND = 1 << 1000


def read_json(data: bytes) -> RawTable:
    """`[{"t": 0.0, "x": 1.2}, ...]`, or the same as a member of an object.

    Numbers and true or false beside the list hold for the whole log: they are its scalars. A
    value that is missing or null is an empty cell.

    Raises:
        InputError: it is no JSON, a name stands twice in an object, it has no list of records with
            numbers in them, or too many names or lists.
    """
    budget = ReadBudget(len(data))
    budget.take(_LIST * data.count(b"["), "its lists")
    try:
        text = data.decode(json.detect_encoding(data), "surrogatepass")
        lines = _LINES.match(text) is not None
        scalars, records = _of_lines(_Decoder(text)) if lines else _document(_Decoder(text))
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise InputError("is no JSON, or not all of it: copy or export it again") from error
    if records is None:
        raise InputError(_NONE)
    notes = [
        f"{shortened(n)} is the text {shortened(v)}, not a number: it was left out"
        for n, v in scalars.items()
        if isinstance(v, str) and _means_a_number(v)
    ]
    numbers = {n: float(v) for n, v in scalars.items() if _number(v)}
    budget.take_cells(records.rows, len(records.cells) + len(numbers))
    return _table(records, numbers, notes)


class _Decoder:
    """A JSON text and the place up to which it is decoded."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self._decoder = json.JSONDecoder(object_pairs_hook=unique)

    def next(self) -> str:
        """The next character that is not blank, empty at the end."""
        if self.text[self.at : self.at + 1] in _BLANKS:  # as the end is
            self.at = _end(_BLANK.match(self.text, self.at))
        return self.text[self.at : self.at + 1]

    def value(self) -> Any:
        """The value that begins here."""
        self.next()
        value, self.at = self._decoder.raw_decode(self.text, self.at)
        return value

    def name(self) -> str:
        """The text that begins here.

        Raises:
            ValueError: something else does.
        """
        if self.next() != '"':
            raise ValueError(self.at)
        return str(self.value())

    def entries(self, closing: str) -> Iterator[None]:
        """One step for each entry of the list or object that begins here, up to its `closing`."""
        self.at += 1
        if self.next() != closing:
            yield
            while self.next() == ",":
                self.at += 1
                yield
        self.take(closing)

    def take(self, character: str) -> None:
        """Go past a character.

        Raises:
            ValueError: another one stands there.
        """
        if self.next() != character:
            raise ValueError(self.at)
        self.at += 1


def _end(match: re.Match[str] | None) -> int:
    assert match is not None  # noqa: S101 - blanks match nothing, too
    return match.end()


@dataclass
class _Records:
    """The cells of a list of records, by name.

    Args:
        rows: How many records.
        cells: Name -> the rows that have a number there, and the numbers.
        text: Name -> (row, cell) of the first text.
        skipped: The names of what is neither, as keys.
    """

    rows: int = 0
    cells: dict[str, tuple[array[int], array[float]]] = field(default_factory=dict)
    text: dict[str, tuple[int, str]] = field(default_factory=dict)
    skipped: dict[str, None] = field(default_factory=dict)

    def add(self, record: Mapping[str, Any]) -> None:
        row, self.rows = self.rows, self.rows + 1
        for name, cell in record.items():
            column = self.cells.get(name)
            if column is None:
                column = self.cells[name] = array("q"), array("d")
                refuse_many(len(self.cells), "names in its records")
            if _number(cell):
                rows, values = column
                rows.append(row)
                values.append(cell)
            elif isinstance(cell, str):
                self.text.setdefault(name, (row, cell))
            elif cell is not None:
                self.skipped[name] = None


def _document(decoder: _Decoder) -> tuple[dict[str, Any], _Records | None]:
    """The members of the outermost object that are no lists, and the one list of records."""
    scalars: dict[str, Any] = {}
    lists: dict[str, _Records] = {}
    opening = decoder.next()
    if opening == "[":
        if records := _records(decoder):
            lists[""] = records
    elif opening == "{":
        names: list[tuple[str, None]] = []
        for _ in decoder.entries("}"):
            name = decoder.name()
            names.append((name, None))
            decoder.take(":")
            if decoder.next() != "[":
                scalars[name] = decoder.value()
            elif records := _records(decoder):
                lists[name] = records
        unique(names)
    else:
        decoder.value()
    if decoder.next():
        raise ValueError(decoder.at)
    if len(lists) > 1:
        first, second, *_ = lists
        raise InputError(
            f"has more than one list of records, {shortened(first)} and {shortened(second)}: "
            "keep one"
        )
    return scalars, next(iter(lists.values()), None)


def _of_lines(decoder: _Decoder) -> tuple[dict[str, Any], _Records | None]:
    """Records one below the other."""
    records = _Records()
    while decoder.next():
        try:
            entry = decoder.value()
        except InputError as error:
            raise InputError(f"record {records.rows + 1}: {error}") from error
        if not isinstance(entry, Mapping):
            raise InputError(f"record {records.rows + 1} is no object: a record is one")
        records.add(entry)
    return {}, records


def _records(decoder: _Decoder) -> _Records | None:
    """The list that begins here, None where not all that it has are records."""
    records: _Records | None = _Records()
    for number, _ in enumerate(decoder.entries("]"), 1):
        try:
            entry = decoder.value()
        except InputError as error:
            raise InputError(f"record {number}: {error}") from error
        if not isinstance(entry, Mapping):
            records = None
        elif records is not None:
            records.add(entry)
    return records if records is not None and records.rows else None


def _means_a_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _number(value: object) -> bool:
    return isinstance(value, bool | float) or (isinstance(value, int) and abs(value) < _BEYOND)


def _table(records: _Records, scalars: dict[str, float], notes: list[str]) -> RawTable:
    columns: dict[str, np.ndarray[Any, Any]] = {}
    for name, (rows, values) in records.cells.items():
        if name not in records.skipped:
            columns[name] = np.full(records.rows, math.nan)
            columns[name][np.frombuffer(rows, dtype=np.int64)] = np.frombuffer(values)
    if not any(not np.isnan(c).all() for c in columns.values()):
        raise InputError("its records have no numbers in them")
    if records.skipped:
        notes = [f"left out, not numbers: {listed(list(records.skipped))}", *notes]
    numbers = np.arange(1, records.rows + 1)
    text = {n: (f"record {numbers[row]}", cell) for n, (row, cell) in records.text.items()}
    return RawTable(columns, numbers, "record", text, scalars, {}, tuple(notes))


def _opens(_path: Path, head: bytes) -> bool:
    return _BEGINS.match(head) is not None


def _open(path: Path, _options: ReadOptions) -> TablesInMemory:
    return TablesInMemory((read_json(whole(path)),))


READER = Reader(
    "json",
    "JSON: a list of records, alone or in an object, or a record a line",
    (".json", ".jsonl", ".ndjson"),
    _opens,
    _open,
)
