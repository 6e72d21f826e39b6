"""Parquet files as tables, read by a process of their own: a damaged file may end it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from .budget import CELL, ReadBudget
from .file_bytes import whole
from .log_file import Reader, ReadOptions, TablesInMemory
from .raw_table import RawTable, listed

if TYPE_CHECKING:
    from .parquet_process import ParquetContents

_PROGRAM = Path(__file__).with_name("parquet_process.py")
#: No traces of what ends it, and as many threads as numbers are written fast.
_ENVIRONMENT = {"RUST_BACKTRACE": "0", "POLARS_MAX_THREADS": "4", "OPENBLAS_NUM_THREADS": "1"}


def read_parquet(data: bytes) -> RawTable:
    """A Parquet file; times and durations in it count in seconds.

    Raises:
        InputError: it is broken, too large unpacked, or has no columns of numbers.
        RuntimeError: the program that reads it has an error.
    """
    if not (data.startswith(b"PAR1") and data.endswith(b"PAR1")):
        raise InputError("is not a whole Parquet file: copy or export it again")
    budget = ReadBudget(len(data))
    limits = str(budget.total), str(budget.total // CELL)
    process = subprocess.run(  # noqa: S603 - this Python, this package's own file
        [sys.executable, "-P", str(_PROGRAM), *limits],
        input=data,
        capture_output=True,
        env={**os.environ, **_ENVIRONMENT},
        check=False,
    )
    if process.returncode == 1:  # as Python ends on an error that a program does not foresee
        raise RuntimeError(process.stderr.decode(errors="replace"))
    if process.returncode:
        raise InputError(f"is a broken Parquet file, or unpacks to more than {budget.most}: copy "
                         "or export it again")  # fmt: skip
    line, _, numbers = process.stdout.partition(b"\n")
    contents: ParquetContents = json.loads(line)
    rows, names = contents["rows"], contents["columns"]
    budget.take_cells(rows, len(names) + len(contents["text"]))
    if len(numbers) != rows * len(names) * 8:
        raise InputError("is a broken Parquet file: copy or export it again")
    columns = dict(zip(names, np.frombuffer(numbers).reshape(len(names), rows), strict=True))
    columns |= {name: np.full(rows, np.nan) for name in contents["text"]}
    text = {name: (row, cell) for name, (row, cell) in contents["text"].items()}
    skipped = contents["skipped"]
    notes = (f"left out, not numbers: {listed(skipped)}",) if skipped else ()
    return RawTable(columns, np.arange(1, rows + 1), "row", text, {}, contents["units"], notes)


def _opens(_path: Path, head: bytes) -> bool:
    return head.startswith(b"PAR1")


def _open(path: Path, _options: ReadOptions) -> TablesInMemory:
    return TablesInMemory((read_parquet(whole(path)),))


READER = Reader("parquet", "Parquet", (".parquet", ".pq"), _opens, _open)
