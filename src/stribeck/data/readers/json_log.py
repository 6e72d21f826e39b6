"""JSON logs as tables: a list of records, or an object that has one list of records in it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...errors import InputError
from .raw_table import RawTable, shortened

#: Columns of a log.
MOST_COLUMNS = 10_000


def read_json(data: bytes) -> RawTable:
    """`[{"t": 0.0, "x": 1.2}, ...]`, or the same as a member of an object.

    Numbers and true or false beside the list hold for the whole log: they are its scalars. A
    value that is missing or null is an empty cell.

    Raises:
        InputError: it is no JSON, or has no list of records with numbers in them.
    """
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise InputError("is no JSON, or not all of it: copy or export it again") from error
    scalars: Mapping[str, Any] = {}
    if isinstance(document, Mapping):
        lists = [name for name, value in document.items() if _records(value)]
        if len(lists) > 1:
            raise InputError(
                f"has more than one list of records, {shortened(lists[0])} and "
                f"{shortened(lists[1])}: keep one"
            )
        scalars, document = document, document[lists[0]] if lists else None
    if not _records(document):
        raise InputError('has no list of records such as [{"t": 0.0, "x": 1.2}, ...]')
    table = _table(document, {n: float(v) for n, v in scalars.items() if _number(v)})
    notes = [
        f"{shortened(n)} is the text {shortened(v)}, not a number: it was left out"
        for n, v in scalars.items()
        if isinstance(v, str) and _means_a_number(v)
    ]
    return replace(table, notes=(*table.notes, *notes)) if notes else table


def _records(value: object) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(r, Mapping) for r in value)


def _means_a_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _number(value: object) -> bool:
    return isinstance(value, bool | float) or (isinstance(value, int) and abs(value) < 1 << 1000)


def _table(records: list[Mapping[str, Any]], scalars: dict[str, float]) -> RawTable:
    names = dict.fromkeys(name for r in records for name in r)
    if len(names) > MOST_COLUMNS:  # a cell for every record and name may be more than fits
        raise InputError(
            f"has {len(names):,} names in its records, and {MOST_COLUMNS:,} is the most: is each "
            "record a sample?"
        )
    columns: dict[str, np.ndarray[Any, Any]] = {}
    text: dict[str, tuple[int, str]] = {}
    skipped: list[str] = []
    for name in names:
        values = np.full(len(records), math.nan)
        for row, record in enumerate(records):
            cell = record.get(name)
            if _number(cell):
                values[row] = cell
            elif isinstance(cell, str):
                text.setdefault(name, (row, cell))
            elif cell is not None and name not in skipped:
                skipped.append(name)
        if name not in skipped:
            columns[name] = values
    if not any(not np.isnan(c).all() for c in columns.values()):
        raise InputError("its records have no numbers in them")
    notes = (f"left out, not numbers: {', '.join(map(shortened, skipped))}",) if skipped else ()
    numbers = np.arange(1, len(records) + 1)
    return RawTable(columns, numbers, "record", text, scalars, {}, notes)
