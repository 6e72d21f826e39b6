"""Feather and other Arrow IPC files, by polars: only the columns that are asked for are read."""

from __future__ import annotations

from pathlib import Path

from .frame_log import frame_log
from .isolated import IsolatedFormat
from .log_file import Reader, ReadOptions
from .sliced_log import SlicedLog

LIBRARIES = ("polars",)
_MAGIC = b"ARROW1"


def library_log(path: Path, _options: ReadOptions) -> SlicedLog:
    """An Arrow IPC file, in a process of its own: a damaged one can end that."""
    import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

    return frame_log(pl.scan_ipc(path))


_FORMAT = IsolatedFormat("feather", LIBRARIES, "a Feather file", extra="")


def _opens(_path: Path, head: bytes) -> bool:
    return head.startswith(_MAGIC)


READER = Reader(
    "feather", "Feather, Arrow IPC", (".feather", ".arrow", ".ipc"), _opens, _FORMAT.open
)
