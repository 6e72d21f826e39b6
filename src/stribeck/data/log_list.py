"""Logs as callers give them: recordings, files and frames, one or several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from ..drive import DriveChain
from ..errors import InputError
from .frames import Frame
from .readers.opening import each_run
from .readers.read import read
from .recording import Recording

#: What is taken for a log.
Log: TypeAlias = Recording | str | Path | Frame
#: What is taken for one or several.
Logs: TypeAlias = Log | Sequence[Log]
#: Column by channel: a mapping, or the TOML file that has it.
Columns: TypeAlias = Mapping[str, Any] | str | Path | None
_FOR_FILES = "units and columns are for files and frames: a Recording has channels"


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
        logs: Recordings, which stay as they are; paths, which are read; folders of logs; frames.
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
        raise InputError(_FOR_FILES)
    chosen = columns or usual or None
    recordings = []
    for k, log in enumerate(every, 1):
        for run in each_run(log, chosen) if isinstance(log, str | Path) else [log]:
            name = f"log {k}" * (len(every) > 1)
            recordings.append(_recording(run, units, chosen, drive, lenient=not columns, name=name))
    return recordings


def recording_of(
    log: Log,
    *,
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    usual: Mapping[str, Any] | None = None,
    drive: DriveChain | None = None,
) -> Recording:
    """One log as a recording; the arguments are those of `log_list`.

    Raises:
        InputError: it cannot be used, or is a folder of several.
    """
    if (units or columns) and isinstance(log, Recording):
        raise InputError(_FOR_FILES)
    return _recording(log, units, columns or usual or None, drive, lenient=not columns)


def _recording(
    log: Log,
    units: Mapping[str, str] | None,
    columns: Columns,
    drive: DriveChain | None,
    *,
    lenient: bool,
    name: str = "",
) -> Recording:
    if isinstance(log, Recording):
        return log
    if isinstance(log, str | Path):
        return read(log, units=units, columns=columns, drive=drive, lenient=lenient)
    return Recording.of(log, units=units, columns=columns, drive=drive, lenient=lenient, name=name)
