"""Parquet, by polars: only the columns that are asked for are unpacked."""

from __future__ import annotations

from pathlib import Path

from ...errors import InputError
from .frame_log import frame_log
from .isolated import IsolatedFormat
from .log_file import Reader, ReadOptions
from .sliced_log import SlicedLog

LIBRARIES = ("polars",)
_MAGIC = b"PAR1"


def library_log(path: Path, _options: ReadOptions) -> SlicedLog:
    """A Parquet file, in a process of its own: a damaged page can end that.

    Raises:
        InputError: its end is not there.
    """
    import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

    with path.open("rb") as file:
        file.seek(-min(len(_MAGIC), path.stat().st_size), 2)
        if file.read() != _MAGIC:
            raise InputError("is not a whole Parquet file: copy or export it again")
    return frame_log(pl.scan_parquet(path))


_FORMAT = IsolatedFormat("parquet", LIBRARIES, "a Parquet file", extra="")


def _opens(_path: Path, head: bytes) -> bool:
    return head.startswith(_MAGIC)


READER = Reader("parquet", "Parquet", (".parquet", ".pq"), _opens, _FORMAT.open)
