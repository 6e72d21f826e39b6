"""How a log is read: which column is which channel, and what its file does not say."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, cast

from ...draft import Draft
from ...drive import DriveChain
from ...errors import InputError
from ...text_file import toml_value
from .column_map import Entry, mapping, toml_table
from .log_file import ReadOptions
from .raw_table import printable, shortened

#: Maps beside logs, for those with the heads that they name.
FILE = "stribeck.columns.toml"
#: What a map says beside columns and a drive, as `read` takes it.
WORDS = ("joint", "rate", "time_unit", "stamp", "episode", "subtract")
_STAMPS = ("header", "log")


@dataclass(frozen=True)
class LogMap:
    """How a log is read.

    Args:
        columns: Channel -> column, for those that the heads do not tell.
        joint: The joint whose columns are taken.
        rate: Of a log without times, Hz.
        time_unit: Of times whose unit the format leaves open.
        stamp: Which time of a message counts; None for the usual one.
        episode: Which of several logs in a file or folder is read.
        subtract: The column of a known force, a rigid-body torque say, that is taken off the force.
        drive: The chain from what the drive recorded to the force at the axis.
    """

    columns: Mapping[str, Entry] = field(default_factory=dict)
    joint: str | None = None
    rate: float | None = None
    time_unit: str | None = None
    stamp: Literal["header", "log"] | None = None
    episode: str | None = None
    subtract: str | None = None
    drive: DriveChain | None = None

    @classmethod
    def of(cls, source: Mapping[str, Any] | str | Path | None) -> LogMap:
        """A map as people write it: channels and columns, or `columns` beside other words.

        ```toml
        joint = "2"
        rate = 500
        [columns]
        position = "q [rad]"
        ```

        Raises:
            InputError: the file is missing or not TOML, or a word or value makes no sense.
        """
        if source is None:
            return cls()
        if isinstance(source, Mapping):
            name, table = "columns", source
        else:
            name, table = toml_table(Path(source))
        words = {w: table[w] for w in WORDS if w in table}
        chain = _chain(table["drive"], f"{name}: drive") if "drive" in table else None
        named = bool(words or chain or "columns" in table)
        if named and (others := [k for k in table if k not in (*WORDS, "columns", "drive")]):
            raise InputError(f"{name}: {shortened(str(others[0]))} stands beside other words: put "
                             "channels into a table columns")  # fmt: skip
        rest = table.get("columns", {}) if named else table
        if not isinstance(rest, Mapping):
            raise InputError(f'{name}: columns must be a table such as position = "x [mm]"')
        if not rest and not words and chain is None:
            raise InputError(f'{name}: the mapping is empty: write position = "x [mm]", say')
        return cls(mapping(rest, name), **_checked(name, words), drive=chain)

    def table(self) -> dict[str, Any]:
        """The map as `of` reads it."""
        words = {w: getattr(self, w) for w in WORDS if getattr(self, w) is not None}
        chain = {} if self.drive is None else {"drive": self.drive.table()}
        return {**words, "columns": dict(self.columns), **chain}

    def with_words(self, words: Mapping[str, Any]) -> LogMap:
        """The same with what a caller says of joint, rate, unit of time and the like.

        Raises:
            InputError: one of them makes no sense.
        """
        return replace(self, **_checked("", {w: v for w, v in words.items() if v is not None}))

    def driven(self, drive: DriveChain | Mapping[str, Any] | None) -> LogMap:
        """The same with the chain of a drive, or its table.

        Raises:
            InputError: the map has another one, or a table is no chain.
        """
        if drive is None:
            return self
        chain = drive if isinstance(drive, DriveChain) else DriveChain.of_table(drive)
        if self.drive is not None and self.drive != chain:
            raise InputError("the rig and the map of its logs both state a drive: state it once")
        return replace(self, drive=chain)

    def options(self) -> ReadOptions:
        """What a reader needs of it to open a file."""
        return ReadOptions(self.rate, self.time_unit, self.stamp or "header", self.episode)


def _chain(table: object, place: str) -> DriveChain:
    if not isinstance(table, Mapping):
        raise InputError(f'{place} must be a table: [drive], signal = "A rms", say')
    return DriveChain.of_table(table, place)


def _checked(name: str, words: Mapping[str, Any]) -> dict[str, Any]:
    name = f"{name}: " * bool(name)
    rate, stamp = words.get("rate"), words.get("stamp")
    numeric = isinstance(rate, int | float) and not isinstance(rate, bool)
    if rate is not None and not (numeric and 0.0 < float(rate) < math.inf):
        raise InputError(f"{name}rate: give a number of Hz above 0")
    if stamp is not None and stamp not in _STAMPS:
        raise InputError(f"{name}stamp: give {' or '.join(_STAMPS)}")
    for word in ("joint", "time_unit", "episode", "subtract"):
        if not isinstance(words.get(word, ""), str):
            raise InputError(f"{name}{word}: give text in quotes")
    return dict(words)


def saved_maps(folder: Path) -> list[tuple[list[str], LogMap]]:
    """The maps that a folder has, each with the heads of its logs.

    Raises:
        InputError: the file with the maps is broken.
    """
    entries = _saved(folder / FILE)
    return [
        (entry.get("heads", []), LogMap.of({k: v for k, v in entry.items() if k != "heads"}))
        for entry in entries
    ]


def save_map(folder: Path, heads: Sequence[str], used: LogMap) -> Path:
    """Keep a map beside logs, in place of an older one for the same heads.

    Raises:
        InputError: the file with the maps is broken.
    """
    file = folder / FILE
    others = [e for e in _saved(file) if e.get("heads") != list(heads)]
    entries = [*others, {"heads": list(heads), **used.table()}]
    text = "\n".join(f"[[log]]\n{_toml(entry)}" for entry in entries)
    draft = Draft(folder)  # on a full disk the maps that there are stay
    try:
        (draft.files / FILE).write_text(
            f"# Which column is which channel, for logs with these heads.\n{text}", encoding="utf-8"
        )
    except BaseException:
        draft.discard()
        raise
    draft.publish()
    return file


def _saved(file: Path) -> list[Mapping[str, Any]]:
    if not file.is_file():
        return []
    _, table = toml_table(file)
    entries = table.get("log", [])
    if not isinstance(entries, list) or not all(isinstance(e, Mapping) for e in entries):
        raise InputError(f"{printable(file.name)}: its maps are not tables [[log]]: delete it")
    return cast("list[Mapping[str, Any]]", entries)


def _toml(entry: Mapping[str, Any]) -> str:
    return "".join(f"{k} = {toml_value(v)}\n" for k, v in entry.items())
