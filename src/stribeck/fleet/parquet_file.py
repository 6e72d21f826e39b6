"""A Parquet file in this process, and no line on the terminal of how a damaged one fails."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock

import polars as pl

#: Standard error, and who has it: it is one for all threads.
_ERRORS, _TURN = 2, Lock()


def parquet_frame(file: Path) -> pl.DataFrame:
    """All rows of a file, without what names of folders above it say.

    Raises:
        PolarsError, PanicException: it is damaged.
        OSError: it cannot be opened.
    """
    with _untold():
        return pl.read_parquet(file, hive_partitioning=False, glob=False)


@contextmanager
def _untold() -> Iterator[None]:
    """Keep from the terminal what is written there by something that then fails.

    A library in Rust that panics writes so, with its stack, from whichever thread it is in, before
    an exception comes to Python. What is written by something that does not fail is passed on.
    """
    with _TURN, tempfile.TemporaryFile() as written:
        if sys.stderr is not None:
            sys.stderr.flush()
        try:
            errors = os.dup(_ERRORS)
        except OSError:  # there is none, so nothing is told
            yield
            return
        os.dup2(written.fileno(), _ERRORS)
        try:
            yield
        finally:
            os.dup2(errors, _ERRORS)
            os.close(errors)
        written.seek(0)
        with os.fdopen(os.dup(_ERRORS), "wb") as told:
            shutil.copyfileobj(written, told)
