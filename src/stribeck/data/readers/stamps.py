"""Dates: what clock a number counts on, and the seconds that words like `10:11:32.3` stand for."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...space import Array

if TYPE_CHECKING:
    import polars as pl

#: From 2000 to 2100, s since 1970.
_SINCE, _UNTIL = 946_684_800.0, 4_102_444_800.0
_TO_1601, _TO_1904 = 11_644_473_600.0, 2_082_844_800.0
#: Formats of words, each tried on a whole column.
_FORMATS = (
    "%Y-%m-%dT%H:%M:%S%.f", "%Y-%m-%d %H:%M:%S%.f", "%Y/%m/%d %H:%M:%S%.f",
    "%m/%d/%Y %H:%M:%S%.f", "%d/%m/%Y %H:%M:%S%.f", "%d.%m.%Y %H:%M:%S%.f",
    "%m/%d/%Y %I:%M:%S%.f %p", "%d-%b-%Y %H:%M:%S%.f", "%Y%m%dT%H%M%S%.f",
)  # fmt: skip
_TIMES = ("%H:%M:%S%.f", "%I:%M:%S%.f %p", "%M:%S%.f")
_DAY = 86_400.0
_ZONE = re.compile(r"(?:Z|(?P<sign>[+-])(?P<hours>\d{2}):?(?P<minutes>\d{2}))$")


@dataclass(frozen=True)
class Epoch:
    """A clock that counts from a date.

    Args:
        title: What it is called.
        tick: Length of a count, s.
        origin: Its zero, s before 1970.
    """

    title: str
    tick: float
    origin: float = 0.0


EPOCHS = (
    Epoch("Unix time in s", 1.0),
    Epoch("Unix time in ms", 1e-3),
    Epoch("Unix time in us", 1e-6),
    Epoch("Unix time in ns", 1e-9),
    Epoch("FILETIME, 100 ns since 1601", 1e-7, _TO_1601),
)


def epoch(count: float) -> Epoch | None:
    """The clock on which a number is a date of this century; no two have one in common."""
    return next((e for e in EPOCHS if _SINCE <= count * e.tick - e.origin <= _UNTIL), None)


class Instants(NamedTuple):
    """What words of dates or of times of day stand for.

    Args:
        t: s from the first, (N,); nan where a cell is empty.
        origin: The first, s since 1970 where the words are dates, without their zone local; s
            since midnight where they are times of day.
    """

    t: Array
    origin: float


def instants(words: pl.Series) -> Instants | None:
    """The dates or times of day in words; None if they are none.

    Times of day that go back went past midnight.
    """
    import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

    words = words.str.strip_chars().str.strip_chars('"').str.strip_chars()
    zoned = words.drop_nulls()
    zone = _ZONE.search(str(zoned[0])) if zoned.len() else None
    words = words.str.replace(_ZONE.pattern, "").str.replace(",", ".", literal=True)
    words = pl.select(pl.when(words != "").then(words)).to_series()
    filled = words.drop_nulls()
    if filled.len() == 0 or (":" not in str(filled[0]) and "T" not in str(filled[0])):
        return None
    for form in _FORMATS:
        stamps = filled.head(1).str.to_datetime(form, time_unit="ns", strict=False)
        if stamps.null_count() == 0:
            stamps = words.str.to_datetime(form, time_unit="ns", strict=False)
            if stamps.null_count() == words.null_count():
                since = _from_first(stamps.to_physical(), 1e-9)
                return Instants(since.t, since.origin - _offset(zone))
    for form in _TIMES:
        times = words.str.to_time(form, strict=False)
        if times.null_count() == words.null_count():
            since = _from_first(times.to_physical(), 1e-9)
            return Instants(_past_midnight(since.t), since.origin)
    return None


def _from_first(ticks: pl.Series, tick: float) -> Instants:
    first = int(ticks.drop_nulls()[0])
    return Instants(np.asarray((ticks - first).to_numpy(), dtype=float) * tick, first * tick)


def _offset(zone: re.Match[str] | None) -> float:
    """By how much a zone is ahead of universal time, s."""
    if zone is None or zone[0] == "Z":
        return 0.0
    sign, hours, minutes = zone["sign"], zone["hours"], zone["minutes"]
    return (-1.0 if sign == "-" else 1.0) * (3600.0 * int(hours) + 60.0 * int(minutes))


def _past_midnight(t: Array) -> Array:
    finite = np.flatnonzero(np.isfinite(t))
    backwards = np.diff(t[finite], prepend=t[finite[0]]) < -0.5 * _DAY
    result = t.copy()
    result[finite] += _DAY * np.cumsum(backwards)
    return result
