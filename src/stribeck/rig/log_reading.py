"""A log read as the rig of its axis has its logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..data.readers.read import read
from ..data.recording import Recording
from .rig import Rig


def read_for(
    rig: Rig | None,
    log: str | Path | Sequence[str | Path],
    columns: Mapping[str, Any] | None,
    **words: Any,
) -> Recording:
    """A log whose columns are as is stated, or else as the rig says, through the rig's drive.

    Args:
        rig: The axis; None where it is not known yet.
        log: Where the log is, as `read` takes it.
        columns: How it is read, as `read` takes it; None where nothing is stated.
        words: What else `read` takes.

    Raises:
        InputError: as `read`.
    """
    usual = dict(rig.columns) if rig is not None and rig.columns else None
    return read(
        log,
        columns=usual if columns is None else columns,
        lenient=columns is None,
        others=() if rig is None else rig.further_columns,
        drive=None if rig is None else rig.chain,
        **words,
    )
