"""Parquet files as tables."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from ...errors import InputError
from .raw_table import LARGEST, RawTable, shortened


def read_parquet(data: bytes) -> RawTable:
    """A Parquet file; times and durations in it count in seconds.

    Raises:
        InputError: it is broken, too large unpacked, or has no columns of numbers.
    """
    import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

    if not (data.startswith(b"PAR1") and data.endswith(b"PAR1")):
        raise InputError("is not a whole Parquet file: copy or export it again")
    try:
        lazy = pl.scan_parquet(io.BytesIO(data))
        schema = lazy.collect_schema()
        rows = lazy.select(pl.len()).collect().item()
        _bound(rows * 8 * len(schema))
        frame = lazy.collect()
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError, ValueError) as error:
        raise InputError("is a broken Parquet file: copy or export it again") from error
    columns, text, units, skipped = {}, {}, {}, []
    for series in frame.iter_columns():
        if series.dtype.is_numeric() or series.dtype == pl.Boolean:
            columns[series.name] = _floats(series)
        elif series.dtype in (pl.Datetime, pl.Duration):
            columns[series.name] = _floats(series.to_physical()) / _ticks(series.dtype)
            units[series.name] = "s"
        elif series.dtype == pl.String and (cells := series.drop_nulls()).len():
            columns[series.name] = np.full(len(series), np.nan)
            text[series.name] = (int(series.is_not_null().arg_max() or 0), str(cells[0]))
        else:
            skipped.append(shortened(series.name))
    notes = (f"left out, not numbers: {', '.join(skipped)}",) if skipped else ()
    return RawTable(columns, np.arange(1, frame.height + 1), "row", text, {}, units, notes)


def _floats(series: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    import polars as pl  # noqa: PLC0415 - as above

    return np.asarray(series.cast(pl.Float64).to_numpy(), dtype=float)


def _ticks(dtype: Any) -> float:
    return {"ms": 1e3, "us": 1e6, "ns": 1e9}[dtype.time_unit]


def _bound(size: float) -> None:
    if size > LARGEST:
        raise InputError(f"unpacks to {size / 2**30:.3g} GiB, more than 2 GiB: cut it into parts")
