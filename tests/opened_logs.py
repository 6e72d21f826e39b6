"""A log as its reader opens it, for the tests of formats."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from stribeck.data.readers.log_file import LogFile, ReadOptions
from stribeck.data.readers.raw_table import RawTable
from stribeck.data.readers.registry import opened
from stribeck.space import Array


def log_of(path: Path, **options: Any) -> tuple[str, LogFile]:
    """The name of its reader, and the open file."""
    reader, log = opened(path, ReadOptions(**options))
    return reader.name, log


def table_of(log: LogFile, name: str) -> RawTable:
    """The table of a channel that is asked for alone: it holds nothing else."""
    (table,) = (t for t in log.tables([name]) if name in t.columns)
    assert list(table.columns) == [name]
    return table


def table_with(log: LogFile, name: str) -> RawTable:
    """The whole table that a channel stands in."""
    (table,) = (t for t in log.tables() if name in t.columns)
    return table


def times(table: RawTable) -> Array:
    """The times of a table whose format has a clock, s."""
    assert table.t is not None
    return table.t
