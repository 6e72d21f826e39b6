"""What is in a log: its channels, and what would be taken for what."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...space import Array
from .choice import Choice, known_unit
from .columns import Heads
from .heads import meanings, take_apart
from .log_file import Channel, LogFile, timing
from .log_map import LogMap
from .log_path import LogPath
from .opening import opened_as
from .raw_table import printable
from .steady_table import chosen_columns


@dataclass(frozen=True)
class LogContents:
    """What is in a log.

    Args:
        file: Its name.
        format: Name of its reader.
        channels: All of them, with the rate and span of a column of times where one is known.
        taken: Channel of an axis -> the column that is taken for it.
        guesses: Column that is not taken -> the channels that its name may mean.
        problems: What was left out, looks wrong or is open, a sentence each.
        lacking: Why no recording can be made of it as it is, empty if one can.
    """

    file: str
    format: str
    channels: tuple[Channel, ...]
    taken: Mapping[str, Choice]
    guesses: Mapping[str, tuple[str, ...]]
    problems: tuple[str, ...]
    lacking: str = ""


def contents(
    path: str | Path | Sequence[str | Path],
    *,
    columns: Mapping[str, Any] | str | Path | None = None,
    joint: str | None = None,
    rate: float | None = None,
    time_unit: str | None = None,
    stamp: str | None = None,
    episode: str | None = None,
    subtract: str | None = None,
) -> LogContents:
    """What is in a log of any format of `readers`; the arguments are those of `read`.

    Raises:
        InputError: it is not there, of no format that is read, or broken.
    """
    words = {"joint": joint, "rate": rate, "time_unit": time_unit, "stamp": stamp,
             "episode": episode, "subtract": subtract}  # fmt: skip
    stated = LogMap.of(columns).with_words(words)
    file = replace(LogPath.of(path), window=None, written="")
    try:
        opened = opened_as(file, stated, words, beside=columns is None)
    except InputError as error:
        raise InputError(printable(f"{file.name}: {error}")) from error
    log, used = opened.log, opened.map
    timed = any(c.clock for c in log.channels) or used.rate is not None
    taken: Mapping[str, Choice] = {}
    lacking, notes = log.lacking, list[str]()
    guesses: dict[str, tuple[str, ...]] = {}
    try:
        heads = Heads.of(log, used.joint, {}, timed=timed, drive=used.drive)
        guesses = {n: _guesses(heads, n) for n in heads.bare}
        taken, notes = chosen_columns(heads, opened.columns)
    except InputError as error:
        lacking = lacking or str(error)
    columns_taken = {c.column for c in taken.values()}
    guesses = {n: g for n, g in guesses.items() if g and n not in columns_taken}
    channels = tuple(
        replace(c, unit=c.unit or _written_unit(c.name))
        for c in _timed(log, taken.get("time"), used.rate)
    )
    texts = [
        f"{name} has text: {cell[:20]!r} in {place}" for name, (place, cell) in log.text.items()
    ]
    problems = (*log.problems, *texts, *notes)
    return LogContents(
        opened.path.name, opened.reader.name, channels, taken, guesses, problems, lacking
    )


def _guesses(heads: Heads, name: str) -> tuple[str, ...]:
    """The channels that a column may be by its name, and by its unit where that fits any."""
    head = heads.head(name)
    named = tuple(meanings(head))
    fitting = tuple(
        channel
        for channel in named
        if head.unit
        and (u := heads.known(channel, head.unit))
        and u.dimension in heads.kinds(channel)
    )
    return fitting or named


def _written_unit(name: str) -> str | None:
    """The unit in a head, None if what stands there is none."""
    written = take_apart(name).unit
    return written if written is not None and known_unit("", written) else None


def _timed(log: LogFile, time: Choice | None, rate: float | None) -> tuple[Channel, ...]:
    """Channels with rate and span where a column of times, or the caller, says them."""
    if all(c.clock for c in log.channels if not c.constant):
        return log.channels
    t: Array | None = None
    if time is not None:
        (table,) = log.tables({time.column})
        t = time.values(table)
        t = t[np.isfinite(t)]
        t = t - t[0] if time.dated and len(t) else t
    elif rate is not None:
        t = np.arange(max(c.count for c in log.channels)) / rate
    if t is None:
        return log.channels
    pace, span = timing(t)
    most = max((c.count for c in log.channels if not c.constant), default=0)
    return tuple(
        c if c.clock or c.constant else replace(c, rate=_rate(c, pace, span, most), span=span)
        for c in log.channels
    )


def _rate(
    channel: Channel, pace: float | None, span: tuple[float, float] | None, most: int
) -> float | None:
    """Samples a second of a column: of one with few samples, as many as it has in the log."""
    if span is None or span[1] <= span[0] or 2 * channel.count > most + 1:
        return pace
    return float(f"{max(channel.count - 1, 0) / (span[1] - span[0]):.4g}") or None
