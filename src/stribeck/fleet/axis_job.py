"""An axis at a time as work for an engine, and the record of what came of it."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, Self

from ..data.readers.log_map import FILE as MAP_FILE
from ..data.readers.log_path import LogPath
from ..errors import InputError
from .manifest import Manifest, rig_path, stated_table
from .manifest_row import ManifestRow
from .row_pattern import found_paths

#: The module whose `record_text` runs these jobs.
RUNNER = "stribeck.fleet.axis_run"
_WILD = frozenset("*?")
_STATUSES = ("done", "refused", "failed")


def axis_jobs(manifest: Manifest) -> Iterator[AxisJob]:
    """The jobs of a manifest, in its order.

    Raises:
        InputError: a map of columns or a drive cannot be read, or no log can be called so.
    """
    folder, tables = manifest.folder, dict[str, Any]()

    def table(name: str, value: Any) -> Any:
        if value is None:
            return None
        if (key := f"{name} {value!r}") not in tables:
            tables[key] = stated_table(name, value, folder)
        return tables[key]

    for row in manifest.rows:
        logs = _logs_of(row, folder)
        maps = tuple(known for path in _maps_beside(logs) if (known := _known(path))[1] is not None)
        stated = row.model_dump(mode="json", exclude_defaults=True, exclude={"columns", "drive"})
        rig = rig_path(row.rig, folder)
        yield AxisJob(
            row=stated,
            logs=tuple(map(_known, logs)),
            rig=_known(rig) if rig != row.rig else (rig, None, None),
            columns=table("columns", row.columns),
            drive=table("drive", row.drive),
            maps=maps,
        )


@dataclass(frozen=True, eq=False)
class AxisJob:
    """One identification. Its text holds all that its record depends on.

    A log, and the file of a rig, is known by its path, size and time of change: what was changed
    is identified anew.

    Args:
        row: The row of the manifest: its columns with their values, as JSON has them.
        logs: The logs: path, size in bytes and time of change in ns; null where there is none.
        rig: Rig as `rig_named` takes it, with size and time of change of its file.
        columns: Table of `[columns]` and the like, as `read` takes it.
        drive: Table of the drive's chain.
        maps: Maps of columns that lie beside the logs, each with size and time of change.
    """

    row: Mapping[str, Any]
    logs: tuple[tuple[str, int | None, int | None], ...]
    rig: tuple[str, int | None, int | None]
    columns: Mapping[str, Any] | None
    drive: Mapping[str, Any] | None
    maps: tuple[tuple[str, int | None, int | None], ...] = ()

    @cached_property
    def text(self) -> str:
        """The job as canonical JSON: equal jobs have equal texts."""
        fields = {
            "runner": RUNNER,
            "row": self.row,
            "logs": self.logs,
            "rig": self.rig,
            "columns": self.columns,
            "drive": self.drive,
            **({"maps": self.maps} if self.maps else {}),
        }
        return json.dumps(fields, sort_keys=True, separators=(",", ":"))

    @cached_property
    def key(self) -> str:
        """The job's identity: a digest of its text."""
        return hashlib.sha256(self.text.encode()).hexdigest()[:32]

    @property
    def labels(self) -> tuple[str, str, str]:
        """(machine, axis, when)."""
        return self.machine, self.row["axis"], self.row.get("when") or ""

    @property
    def machine(self) -> str:
        """The machine of the axis."""
        machine: str = self.row.get("machine", "-")
        return machine

    @classmethod
    def parse(cls, text: str) -> Self:
        """The job whose `text` this is."""
        fields = json.loads(text)
        del fields["runner"]
        logs = tuple(map(tuple, fields.pop("logs")))
        maps = tuple(map(tuple, fields.pop("maps", ())))
        return cls(logs=logs, rig=tuple(fields.pop("rig")), maps=maps, **fields)

    @property
    def inputs_have_changed(self) -> bool:
        """Whether a log, a map beside it or the rig's file is no longer what the job names."""
        files = (*self.logs, *self.maps, *((self.rig,) if self.rig[1] is not None else ()))
        return any(_known(path) != (path, *state) for path, *state in files)

    def done(self, line: str) -> AxisRecord:
        """Its record, from its text.

        Raises:
            ValueError: it is not the record of this job.
        """
        record = AxisRecord.parse(line)
        if record.job.key != self.key:
            raise ValueError(f"the outcome of another job: {record.job.labels}")
        return record

    def failed(self, message: str) -> AxisRecord:
        """That it could not be run, for a reason that is none of the log's."""
        return AxisRecord(self, "failed", message)


@dataclass(frozen=True, eq=False)
class AxisRecord:
    """What is kept of an identification. All of it but `seconds` is a pure function of the job.

    Args:
        job: Which.
        status: `done`; `refused`, where the log cannot be used as the row says; `failed`, where
            the work ended for a reason that is none of the log's: it is tried again next time.
        reason: Why it is not done, in one line.
        card: The card, as JSON has it, without the seconds of its search.
        motion: The fields of a `SpeedRange`; None where nothing moves.
        seconds: Wall-clock time of reading and identifying.
    """

    job: AxisJob
    status: Literal["done", "refused", "failed"]
    reason: str = ""
    card: Mapping[str, Any] | None = None
    motion: Mapping[str, Any] | None = None
    seconds: float = 0.0

    @property
    def text(self) -> str:
        """The record as one line of JSON; numbers come back bit for bit."""
        return json.dumps({**vars(self), "job": self.job.text}, separators=(",", ":"))

    @classmethod
    def parse(cls, text: str) -> Self:
        """The record whose `text` this is.

        Raises:
            ValueError: it is none; also TypeError and KeyError.
        """
        fields = json.loads(text)
        record = cls(**{**fields, "job": AxisJob.parse(fields["job"])})
        if record.status not in _STATUSES or (record.status == "done") is (record.card is None):
            raise ValueError(f"no record has status {record.status!r} and card {record.card!r:.20}")
        return record


def _logs_of(row: ManifestRow, folder: Path) -> list[str]:
    try:
        return _logs(row.log, folder)
    except InputError as error:
        raise InputError(f"axis {row.axis}: {error}") from error


def _logs(log: str, folder: Path) -> list[str]:
    """The paths of a row's logs; a wildcard stands for those that there are."""
    if not _WILD & set(log):
        return [str(_absolute(log, folder))]
    files, window = log, ""
    if (match := LogPath.of(log)).written:
        files, window = log.removesuffix(match.written), match.written
    pattern = Path(files)
    root, relative = (
        (Path(pattern.anchor), pattern.relative_to(pattern.anchor))
        if pattern.is_absolute()
        else (folder, pattern)
    )
    return sorted(f"{path.absolute()}{window}" for path in found_paths(root, str(relative)))


def _absolute(log: str, folder: Path) -> str:
    """A log by its full path, its window as it stands."""
    return str((folder / log).absolute())


def _maps_beside(logs: Sequence[str]) -> list[str]:
    """Where maps of these logs' columns would lie."""
    folders = set[Path]()
    for log in logs:
        with suppress(OSError, InputError):
            folders |= {file.parent for file in LogPath.of(log).files}
    return sorted(str(folder / MAP_FILE) for folder in folders)


def _known(path: str) -> tuple[str, int | None, int | None]:
    """A path with size and time of change of what lies there, of a folder those of its files.

    What must not be read is as good as not there.
    """
    try:
        files = [f for each in LogPath.of(path).files for f in _inside(each)]
        stats = [f.stat() for f in files]
        if not all(os.access(f, os.R_OK) for f in files):
            return path, None, None
    except (OSError, InputError):
        return path, None, None
    if not stats:
        return path, None, None
    return path, sum(s.st_size for s in stats), max(s.st_mtime_ns for s in stats)


def _inside(path: Path) -> list[Path]:
    return [f for f in sorted(path.rglob("*")) if f.is_file()] if path.is_dir() else [path]
