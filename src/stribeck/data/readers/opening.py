"""A log opened as its path, its caller and the map beside it say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ...errors import InputError
from .column_map import Entry
from .joined_run import JoinedRun, opened_run
from .log_file import LogFile, Reader
from .log_folder import runs
from .log_map import LogMap, saved_maps
from .log_path import LogPath
from .raw_table import listed
from .registry import opened


@dataclass(frozen=True)
class OpenedLog:
    """A log, and how it is to be read.

    Args:
        path: Its files; of a folder those in it.
        reader: Its format.
        log: The open file.
        map: How it is read.
        saved: Whether that is the map beside it.
    """

    path: LogPath
    reader: Reader
    log: LogFile
    map: LogMap
    saved: bool

    @property
    def heads(self) -> list[str]:
        """The names of its channels, by which it is known again."""
        return [c.name for c in self.log.channels]

    @property
    def columns(self) -> Mapping[str, Entry]:
        """Channel -> column, of those that are still to be chosen; a run's times are."""
        times = {"time"} if isinstance(self.log, JoinedRun) else set()
        return {c: entry for c, entry in self.map.columns.items() if c not in times}

    def complete(self, chosen: Mapping[str, Entry]) -> LogMap:
        """The map with all columns that were chosen."""
        times = {c: e for c, e in self.map.columns.items() if c not in self.columns}
        return replace(self.map, columns={**times, **chosen})


def opened_as(
    path: LogPath,
    stated: LogMap,
    words: Mapping[str, Any],
    *,
    beside: bool,
    units: Mapping[str, str] | None = None,
) -> OpenedLog:
    """A log as the map beside it says, or else as is stated.

    Args:
        path: Of a file, of the files of a run, or of a folder.
        stated: How the caller, or a rig, says that it is read, the words included.
        words: What the caller says of joint, rate and the like, which goes before any map.
        beside: Whether a map beside the log is looked for.
        units: Unit by column, where the heads do not say it.

    Raises:
        InputError: a file is not there, of no format that is read, or broken; a folder has
            several runs.
    """
    path = replace(path, files=_one_run(path.files, stated))
    maps = saved_maps(path.files[0].parent) if beside else []
    several = [m for _, m in maps if m.episode is not None] if stated.episode is None else []
    try:
        plain = _opened(path, stated, units)
    except InputError:
        if not several:
            raise
        plain = None  # it has several logs, of which a map may name one
    for heads, saved in maps:
        if plain is not None and heads == plain.heads:
            used = saved.with_words(words).driven(stated.drive)
            return _opened(path, used, units, saved=True, plain=plain)
    for saved in several:
        used = saved.with_words(words).driven(stated.drive)
        try:
            opened_so = _opened(path, used, units, saved=True)
        except InputError:  # it has no such log
            continue
        if any(heads == opened_so.heads for heads, m in maps if m is saved):
            return opened_so
    return plain or _opened(path, stated, units)


def _opened(
    path: LogPath,
    used: LogMap,
    units: Mapping[str, str] | None,
    *,
    saved: bool = False,
    plain: OpenedLog | None = None,
) -> OpenedLog:
    """A log as a map says; `plain` is the same as another did, if it is open so already."""
    files, options = path.files, used.options()
    retimed = len(files) > 1 and "time" in used.columns
    if plain is not None and not retimed and options == plain.map.options():
        return replace(plain, map=used, saved=saved)
    if len(files) == 1:
        reader, log = opened(files[0], options)
        return OpenedLog(path, reader, log, used, saved)
    run_reader, run = opened_run(files, options, used.columns.get("time"), units or {})
    return OpenedLog(path, run_reader, run, used, saved)


def _one_run(files: tuple[Path, ...], used: LogMap) -> tuple[Path, ...]:
    if len(files) > 1:
        return files
    every = runs(files[0], used.options())
    if len(every) > 1:
        names = listed([file.name for (file,) in every], 5)
        raise InputError(f"is a folder of {len(every)} runs ({names}): name one of them")
    return every[0]


def each_run(path: str | Path, columns: Any = None) -> list[str | Path]:
    """The runs that a path stands for: itself, or the logs of a folder that has several.

    Args:
        path: As `read` takes it.
        columns: The same.

    Raises:
        InputError: a folder has no logs, or it cannot be told which are of one run.
    """
    log = LogPath.of(path)
    if len(log.files) > 1:
        return [path]
    try:
        every = runs(log.files[0], LogMap.of(columns).options())
    except InputError as error:
        raise InputError(f"{log.files[0].name}: {error}") from error
    if len(every) == 1:
        return [path]
    return [file.with_name(file.name + log.written) for (file,) in every]
