"""Logs as callers give them: recordings, files and frames, one or several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from ..drive import DriveChain
from ..errors import InputError
from .frames import Frame
from .readers.read import read
from .recording import Recording

#: What is taken for a log.
Log: TypeAlias = Recording | str | Path | Frame
#: What is taken for one or several.
Logs: TypeAlias = Log | Sequence[Log]
#: Column by channel: a mapping, or the TOML file that has it.
Columns: TypeAlias = Mapping[str, Any] | str | Path | None


def log_list(
    logs: Logs,
    *,
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    usual: Mapping[str, Any] | None = None,
    drive: DriveChain | None = None,
) -> list[Recording]:
    """One or several logs as recordings.

    Args:
        logs: Recordings, which stay as they are; paths, which are read; frames.
        units: Unit by column of files and frames, as `read` takes it.
        columns: Column by channel of files and frames, as `read` takes it.
        usual: The columns that a rig's logs have, which hold where `columns` says nothing, and
            need not be there.
        drive: The chain of the rig's drive.

    Raises:
        InputError: there is none, or one cannot be used.
    """
    several = isinstance(logs, Sequence) and not isinstance(logs, str)
    every: Sequence[Log] = logs if several else [logs]  # type: ignore[assignment, list-item]
    if not every:
        raise InputError("no recording was given")
    if (units or columns) and all(isinstance(log, Recording) for log in every):
        raise InputError("units and columns are for files and frames: a Recording has channels")
    chosen = columns or usual or None
    recordings = []
    for k, log in enumerate(every, 1):
        if isinstance(log, Recording):
            recordings.append(log)
        elif isinstance(log, str | Path):
            recordings.append(
                read(log, units=units, columns=chosen, drive=drive, lenient=not columns)
            )
        else:
            name = f"log {k}" if len(every) > 1 else ""
            recordings.append(
                Recording.of(
                    log, units=units, columns=chosen, drive=drive, lenient=not columns, name=name
                )
            )
    return recordings
