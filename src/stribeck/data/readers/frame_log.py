"""A lazy frame of polars as a log: its columns of numbers and times, lists taken apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .arrays import matrix_names
from .budget import WIDEST
from .interval import Interval
from .log_file import Channel
from .raw_table import RawTable, listed
from .sliced_log import SlicedLog, SlicedRows

if TYPE_CHECKING:
    import polars as pl

_TICKS = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def frame_log(
    lazy: pl.LazyFrame,
    elements: Mapping[str, Sequence[str]] | None = None,
    units: Mapping[str, str] | None = None,
) -> SlicedLog:
    """The columns of a frame that are numbers, times or lists of numbers.

    Args:
        lazy: Read by column.
        elements: Column of lists -> names of the channels that its elements are. Lists of a
            length that neither this nor their type says are left out.
        units: Column -> unit, where the file says it.
    """
    import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

    schema = lazy.collect_schema()
    rows = int(lazy.select(pl.len()).collect().item())
    units = dict(units or {})
    units |= {n: "s" for n, kind in schema.items() if isinstance(kind, pl.Datetime | pl.Duration)}
    expressions: dict[str, pl.Expr] = {}
    skipped = []
    text = {}
    for name, kind in schema.items():
        if kind.is_numeric() or kind == pl.Boolean or name in units:
            expressions[name] = _seconds(name, kind)
        elif isinstance(kind, pl.List | pl.Array):
            taken = _elements(name, kind, (elements or {}).get(name, ()))
            expressions |= taken
            skipped += [] if taken else [name]
        elif kind == pl.String and (cell := _first_text(lazy, name, rows)):
            text[name] = cell
        elif kind != pl.Null:
            skipped.append(name)

    places = {n: (f"row {row + 1}", cell) for n, (row, cell) in text.items()}

    def empty(wanted: Sequence[str]) -> RawTable:
        return RawTable(
            dict.fromkeys(wanted, np.empty(0)),
            np.empty(0, np.int64),
            "row",
            {n: place for n, place in places.items() if n in wanted},
            units={n: u for n, u in units.items() if n in wanted},
        )

    def pieces(wanted: Sequence[str], part: range) -> Iterator[SlicedRows]:
        if part:
            kept = [expressions[n].alias(n) for n in wanted if n in expressions]
            frame = lazy.slice(part.start, len(part)).select(kept).collect()
            columns: dict[str, Any] = {s.name: s.to_numpy() for s in frame.iter_columns()}
            yield SlicedRows(None, columns | {n: np.full(len(part), np.nan) for n in wanted
                                              if n in text})  # fmt: skip

    def find(interval: Interval) -> range:
        inside = pl.col("t").is_between(interval.first, interval.last)
        times = lazy.select(expressions[interval.column].alias("t")).with_row_index("row")
        ends = times.filter(inside).select(pl.col("row").min(), pl.col("row").max().alias("last"))
        first, last = ends.collect(engine="streaming").row(0)
        return range(0) if first is None else range(first, last + 1)

    ends = _ends(lazy, expressions, rows)
    channels = [Channel(n, units.get(n), rows, ends=ends.get(n)) for n in (*expressions, *text)]
    problems = (f"left out, not numbers: {listed(skipped)}",) if skipped else ()
    return SlicedLog(tuple(channels), empty, pieces, problems=problems, text=places, find=find)


def _ends(
    lazy: pl.LazyFrame, expressions: Mapping[str, pl.Expr], rows: int
) -> dict[str, tuple[float, float]]:
    """First and last number of columns, where both are numbers."""
    if not (rows and expressions):
        return {}
    kept = [expression.alias(n) for n, expression in expressions.items()]
    outer = [lazy.slice(k, 1).select(kept).collect().row(0) for k in (0, rows - 1)]
    pairs = zip(expressions, *outer, strict=True)
    return {
        n: (float(a), float(b))
        for n, a, b in pairs
        if a is not None and b is not None and np.isfinite([a, b]).all()
    }


def _seconds(name: str, kind: Any) -> pl.Expr:
    import polars as pl  # noqa: PLC0415 - as above

    column = pl.col(name)
    if isinstance(kind, pl.Datetime | pl.Duration):
        return column.to_physical().cast(pl.Float64) * _TICKS[kind.time_unit]
    return column.cast(pl.Float64)


def _elements(name: str, kind: Any, names: Sequence[str]) -> dict[str, pl.Expr]:
    """The elements of lists whose length is known before any is read."""
    import polars as pl  # noqa: PLC0415 - as above

    if not (kind.inner.is_numeric() or kind.inner == pl.Boolean):
        return {}
    column = pl.col(name)
    if isinstance(kind, pl.Array):
        column, width = column.arr.to_list(), kind.size
        names = names if len(names) == width else matrix_names(name, width)
    if not 0 < len(names) <= WIDEST:
        return {}
    return {
        head: column.list.get(i, null_on_oob=True).cast(pl.Float64) for i, head in enumerate(names)
    }


def _first_text(lazy: pl.LazyFrame, name: str, rows: int) -> tuple[int, str] | None:
    """The row and the text of the first cell of a column that is not empty."""
    import polars as pl  # noqa: PLC0415 - as above

    if rows == 0:
        return None
    filled = lazy.select(pl.col(name).is_not_null().arg_true().first()).collect().item()
    row = int(filled or 0)
    cell = lazy.slice(row, 1).select(name).collect().item()
    return None if cell is None else (row, str(cell)[:200])
