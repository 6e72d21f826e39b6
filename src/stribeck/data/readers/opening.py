"""A log opened as its path, its caller and the map beside it say."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...errors import InputError
from .log_file import LogFile, Reader
from .log_map import LogMap, saved_map
from .registry import opened

_WINDOW = re.compile(r"(?P<file>.+)@(?P<since>[\d.]+)s:(?P<until>[\d.]+)s")


@dataclass(frozen=True)
class OpenedLog:
    """A log, and how it is to be read.

    Args:
        reader: Its format.
        log: The open file.
        map: How it is read.
        saved: Whether that is the map beside it.
    """

    reader: Reader
    log: LogFile
    map: LogMap
    saved: bool

    @property
    def heads(self) -> list[str]:
        """The names of its channels, by which it is known again."""
        return [c.name for c in self.log.channels]


def opened_as(file: Path, stated: LogMap, words: Mapping[str, Any], *, beside: bool) -> OpenedLog:
    """A log as the map beside it says, or else as is stated.

    Args:
        file: Without a window.
        stated: How the caller, or a rig, says that it is read, the words included.
        words: What the caller says of joint, rate and the like, which goes before any map.
        beside: Whether a map beside the log is looked for.

    Raises:
        InputError: the file is not there, of no format that is read, or broken.
    """
    reader, log = opened(file, stated.options())
    plain = OpenedLog(reader, log, stated, saved=False)
    saved = saved_map(file.parent, plain.heads) if beside else None
    if saved is None:
        return plain
    used = saved.with_words(words).driven(stated.drive)
    if used.options() != stated.options():
        reader, log = opened(file, used.options())
    return OpenedLog(reader, log, used, saved=True)


def windowed(path: Path) -> tuple[Path, tuple[float, float] | None]:
    """A path without the window that may follow it, and the window, s from the start.

    Raises:
        InputError: the window is empty.
    """
    match = _WINDOW.fullmatch(path.name)
    if match is None or path.exists():
        return path, None
    since, until = float(match["since"]), float(match["until"])
    if not since < until:
        raise InputError(f"{path.name}: from {since:g} s to {until:g} s is no time")
    return path.with_name(match["file"]), (since, until)
