"""A log in memory as a raw table: a frame of polars or pandas, a dict of columns, a named array.

A frame is known by what it answers to (`columns` and `frame[name]`): neither library is imported.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Protocol, TypeAlias

import numpy as np

from ..errors import InputError
from ..space import Array
from .readers.raw_table import RawTable, shortened

#: How a cell that is missing is written.
_MISSING = frozenset({"", "None", "nan", "NaN", "NaT", "<NA>", "null"})


class DataFrame(Protocol):
    """Columns by name: a frame of polars or pandas, and what is like them."""

    @property
    def columns(self) -> Any:
        """The names of the columns."""

    def __getitem__(self, name: Any, /) -> Any:
        """A column."""


#: What is taken for a log in memory.
Frame: TypeAlias = DataFrame | Mapping[str, Any] | np.ndarray[Any, Any]


def frame_table(frame: Frame) -> RawTable:
    """A frame as the readers of files have a table; its rows are counted from 0.

    Times of day and durations become seconds, a number beside the columns of a dict a constant
    column, and an index that has a name or is of times a column.

    Args:
        frame: Columns of equal length.

    Raises:
        InputError: this is no frame, or its columns differ in length.
    """
    columns: dict[str, Array] = {}
    scalars: dict[str, float] = {}
    text: dict[str, tuple[str, str]] = {}
    known: dict[str, str] = {}
    notes: list[str] = []
    for name, values in _named(frame):
        if name in columns or name in scalars:
            raise InputError(f"two columns are called {shortened(name)}: rename one")
        if np.ndim(values) == 0:
            if isinstance(values, (int, float, np.number)):
                scalars[name] = float(values)
            else:
                notes.append(f"{shortened(name)} left out: it is no column")
            continue
        cells, unit, first, note = _column(name, values)
        columns[name] = cells
        known |= {name: unit} if unit else {}
        text |= {name: (f"row {first[0]}", first[1])} if first else {}
        notes += [note] if note else []
    rows = _rows(columns)
    return RawTable(columns, np.arange(rows), "row", text, scalars, known, tuple(notes))


def _named(frame: Frame) -> Iterator[tuple[str, Any]]:
    """Name and values of each column."""
    if isinstance(frame, Mapping):
        yield from ((str(name), values) for name, values in frame.items())
        return
    if isinstance(frame, np.ndarray):
        if not frame.dtype.names:
            raise InputError(f"an array of shape {frame.shape} has no names of columns: give a "
                             'dict such as {"t": t, "x": x}')  # fmt: skip
        yield from ((name, frame[name]) for name in frame.dtype.names)
        return
    if hasattr(frame, "collect"):
        raise InputError("the frame is lazy: give frame.collect()")
    names = getattr(frame, "columns", None)
    if names is None or not hasattr(frame, "__getitem__"):
        raise InputError(f"no log, but of type {type(frame).__name__}: give a path, a Recording, "
                         "a DataFrame or a dict of columns")  # fmt: skip
    names = list(names)
    if len(set(map(str, names))) < len(names):
        twice = next(str(n) for n in names if [*map(str, names)].count(str(n)) > 1)
        raise InputError(f"two columns are called {shortened(twice)}: rename one")
    if (index := _index(frame)) and index[0] not in map(str, names):
        yield index
    yield from ((str(name), frame[name]) for name in names)


def _index(frame: Any) -> tuple[str, Any] | None:
    """The index of a frame that has one, where it is more than the number of its row."""
    index = getattr(frame, "index", None)
    if index is None or not hasattr(index, "dtype") or type(index).__name__ == "RangeIndex":
        return None
    if index.name is not None:
        return str(index.name), index
    return ("time", index) if _timed(_array(index)).dtype.kind in "mM" else None


def _column(name: str, values: Any) -> tuple[Array, str, tuple[int, str] | None, str]:
    """Numbers of a column, its unit if its type says it, the first cell of text, and a note."""
    unit = str(values.units) if hasattr(values, "magnitude") and hasattr(values, "units") else ""
    cells = _array(getattr(values, "magnitude", values))
    if cells.ndim != 1:
        raise InputError(f"column {shortened(name)} has the shape {cells.shape}: give one axis of "
                         "it")  # fmt: skip
    if cells.dtype.kind == "O":
        cells = _timed(cells)
    if cells.dtype.kind in "mM":
        seconds, note = _seconds(name, cells)
        return seconds, "s", None, note
    if cells.dtype.kind in "biuf":
        return np.asarray(cells, dtype=float), unit, None, ""
    numbers, first = _numbers(cells)
    return numbers, unit, first, ""


def _array(values: Any) -> np.ndarray[Any, Any]:
    """The values of a column, whatever holds them."""
    return np.asarray(values.to_numpy() if hasattr(values, "to_numpy") else values)


def _timed(cells: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Cells that are times of day or durations by themselves, as an array of such."""
    first = next((c for c in cells if str(c) not in _MISSING), None)
    for attribute, kind in (("timestamp", "datetime64[ns]"), ("total_seconds", "timedelta64[ns]")):
        if hasattr(first, attribute):
            seconds = [
                getattr(c, attribute)() if hasattr(c, attribute) else math.nan for c in cells
            ]
            whole = np.array([round(1e9 * s) if math.isfinite(s) else None for s in seconds])
            return whole.astype(kind)
    return cells


def _seconds(name: str, cells: np.ndarray[Any, Any]) -> tuple[Array, str]:
    """Times of day as seconds from the first, durations as they are."""
    missing = np.isnat(cells)
    if cells.dtype.kind == "M" and not missing.all():
        first = cells[~missing][0]
        note = f"{shortened(name)} counts from {np.datetime_as_string(first, unit='ms')}"
        cells = cells - first
    else:
        note = ""
    seconds = cells / np.timedelta64(1, "s") if cells.dtype.kind == "m" else np.zeros(len(cells))
    return np.where(missing, np.nan, seconds), note


def _numbers(cells: np.ndarray[Any, Any]) -> tuple[Array, tuple[int, str] | None]:
    """Cells of any type as numbers, NaN where one is missing; and the first that is text."""
    numbers, first = np.full(len(cells), np.nan), None
    for row, cell in enumerate(cells):
        try:
            numbers[row] = float(cell)
        except (TypeError, ValueError):
            if first is None and str(cell) not in _MISSING:
                first = row, str(cell)
    return numbers, first


def _rows(columns: Mapping[str, Array]) -> int:
    """How many rows all columns have.

    Raises:
        InputError: there are no columns, or one has another length than the first.
    """
    if not columns:
        raise InputError("the frame has no columns")
    first, *others = columns
    for name in others:
        if len(columns[name]) != len(columns[first]):
            raise InputError(
                f"columns {shortened(first)} and {shortened(name)} have {len(columns[first])} and "
                f"{len(columns[name])} rows: cut them to one length"
            )
    return len(columns[first])
