"""The program that reads a Parquet file for `parquet.read_parquet`: bytes in, numbers out.

    python -P parquet_process.py BYTES CELLS < log.parquet

Polars ends its process when a damaged page makes it ask for more memory than there is, and prints
where it was. So it runs in a process of its own, under a limit of `BYTES` of memory. That prints
one line of JSON, `ParquetContents`, and then the numbers of its columns, float64, one after the
other: none where they are more than `CELLS`. It exits with `REFUSED` if the file is at fault.
"""

from __future__ import annotations

import io
import json
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
import polars as pl

#: Memory that the threads of polars take beside what they read: bytes.
THREADS = 128 << 20
#: The exit status for a file that cannot be read; 1 is that of an error in this program.
REFUSED = 3
_TICKS = {"ms": 1e3, "us": 1e6, "ns": 1e9}


class ParquetContents(TypedDict):
    """What a Parquet file has beside its numbers.

    Attributes:
        rows: How many rows.
        columns: The names of the columns that are numbers or times, in the file's order.
        units: The units of those that are times.
        text: Name -> (row, cell) of the first cell of a column of text; (0, "") for all columns
            of text where the table is beyond the limit.
        skipped: The names of all others.
    """

    rows: int
    columns: list[str]
    units: dict[str, str]
    text: dict[str, tuple[int, str]]
    skipped: list[str]


def main() -> None:
    """Read standard input, write the contents and the numbers."""
    limit, cells = map(int, sys.argv[1:])
    data = sys.stdin.buffer.read()
    _limit_memory(THREADS + limit)
    try:
        _write(pl.scan_parquet(io.BytesIO(data)), cells)
    except (
        pl.exceptions.PolarsError,
        pl.exceptions.PanicException,
        OSError,
        ValueError,
        MemoryError,
    ):
        sys.exit(REFUSED)


def _limit_memory(more: int) -> None:
    """No more bytes than these beside what this process has already; on Linux alone."""
    with suppress(ImportError, ValueError, OSError):
        import resource  # noqa: PLC0415 - there is none on Windows

        pages = int(Path("/proc/self/statm").read_text().split()[5])
        hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
        resource.setrlimit(resource.RLIMIT_DATA, (pages * resource.getpagesize() + more, hard))


def _write(lazy: pl.LazyFrame, cells: int) -> None:
    schema = lazy.collect_schema()
    rows = int(lazy.select(pl.len()).collect().item())
    times = {n for n, t in schema.items() if t in (pl.Datetime, pl.Duration)}
    columns = [n for n, t in schema.items() if t.is_numeric() or t == pl.Boolean or n in times]
    words = [n for n, t in schema.items() if t == pl.String]
    fits = rows * (len(columns) + len(words)) <= cells
    text = {name: first for name in words if (first := _first(lazy, name) if fits else (0, ""))}
    used = {*columns, *text}
    contents = ParquetContents(
        rows=rows,
        columns=columns,
        units=dict.fromkeys(sorted(times), "s"),
        text=text,
        skipped=[n for n in schema if n not in used],
    )
    frame = lazy.select(columns).collect() if fits else None
    output = sys.stdout.buffer
    output.write(json.dumps(contents).encode() + b"\n")
    for series in frame.iter_columns() if frame is not None else ():
        output.write(_floats(series).tobytes())


def _first(lazy: pl.LazyFrame, name: str) -> tuple[int, str] | None:
    """The row and the text of the first cell of a column that is not empty."""
    series = lazy.select(name).collect().to_series()
    row = series.is_not_null().arg_max()
    return (row, str(series[row])) if row is not None and series[row] is not None else None


def _floats(series: pl.Series) -> np.ndarray[Any, np.dtype[np.float64]]:
    values = series.to_physical().cast(pl.Float64).to_numpy()
    if isinstance(series.dtype, pl.Datetime | pl.Duration):
        values = values / _TICKS[series.dtype.time_unit]
    return np.asarray(values, dtype=float)


if __name__ == "__main__":
    main()
