"""Logs as callers give them: recordings, files and frames, one or several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from ..drive import DriveChain
from ..errors import ChoiceError, InputError
from ..wording import option
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
    subtract: str | None = None,
    drive: DriveChain | None = None,
) -> list[Recording]:
    """One or several logs as recordings.

    Args:
        logs: Recordings, which stay as they are; paths, which are read; folders of logs; frames.
        units: Unit by column of files and frames, as `read` takes it.
        columns: Column by channel of files and frames, as `read` takes it.
        usual: The columns that a rig's logs have, which hold where `columns` says nothing, and
            need not be there.
        subtract: The column of a known force that is taken off the force, as `read` takes it.
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
    reading = _LogOptions(units, columns, usual, subtract, drive)
    recordings = []
    for k, log in enumerate(every, 1):
        for run in each_run(log, reading.columns) if isinstance(log, str | Path) else [log]:
            name = f"log {k}" * (len(every) > 1)
            recordings.append(reading.recording(run, name))
    return recordings


def recording_of(
    log: Log,
    *,
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    usual: Mapping[str, Any] | None = None,
    subtract: str | None = None,
    drive: DriveChain | None = None,
) -> Recording:
    """One log as a recording; the arguments are those of `log_list`.

    Raises:
        InputError: it cannot be used, or is a folder of several.
    """
    if (units or columns) and isinstance(log, Recording):
        raise InputError(_FOR_FILES)
    return _LogOptions(units, columns, usual, subtract, drive).recording(log)


class _LogOptions:
    """How logs are read; the arguments are those of `log_list`."""

    def __init__(
        self,
        units: Mapping[str, str] | None,
        columns: Columns,
        usual: Mapping[str, Any] | None,
        subtract: str | None,
        drive: DriveChain | None,
    ) -> None:
        self.columns = columns or usual or None
        self._of_rig = bool(usual) and not columns
        self._subtract = subtract or (usual or {}).get("subtract")
        self._options: dict[str, Any] = {
            "units": units,
            "columns": self.columns,
            "subtract": subtract,
            "drive": drive,
            "lenient": not columns,
        }

    def recording(self, log: Log, name: str = "") -> Recording:
        """A log as a recording; a frame is called by a name."""
        if isinstance(log, Recording):
            less = self._subtract if log.known_force is None else None
            return log if less is None else log.less(less)
        try:
            if isinstance(log, str | Path):
                return read(log, **self._options)
            return Recording.of(log, **self._options, name=name)
        except ChoiceError as error:
            if not self._of_rig:
                raise
            example = option("columns", {"position": "q [rad]"})
            raise ChoiceError(
                f"{error} (the rig has that mapping: say another, as in {example})"
            ) from error
