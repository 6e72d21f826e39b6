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
_TO_1601 = 11_644_473_600.0
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


class StampForm(NamedTuple):
    """How a column writes dates or times of day.

    Args:
        form: As polars has it.
        first: The first of them, ns since 1970 or since midnight.
        of_day: Whether they are times of day.
        zone: By how much their zone is ahead of universal time, s.
    """

    form: str
    first: int
    of_day: bool
    zone: float

    @property
    def origin(self) -> float:
        """The first, s, as `Instants` has it."""
        return self.first * 1e-9 - self.zone

    def since_first(self, words: pl.Series) -> Array | None:
        """Time from its first, s, (N,), nan for an empty cell; None if a word differs."""
        words = _bare(words)
        ticks = _ticks(words, self.form, of_day=self.of_day)
        if ticks.null_count() > words.null_count():
            return None
        return np.asarray((ticks - self.first).to_numpy(), dtype=float) * 1e-9


def stamp_forms(words: pl.Series) -> list[StampForm]:
    """The forms of dates and times of day in which the first of some words can be read."""
    bare = _bare(words).drop_nulls().head(1)
    if bare.len() == 0 or (":" not in str(bare[0]) and "T" not in str(bare[0])):
        return []
    zone = _ZONE.search(str(_stripped(words).drop_nulls()[0]))
    every = [(form, False) for form in _FORMATS] + [(form, True) for form in _TIMES]
    ticks = [(form, of_day, _ticks(bare, form, of_day=of_day)) for form, of_day in every]
    return [
        StampForm(form, int(first[0]), of_day, 0.0 if of_day else _offset(zone))
        for form, of_day, first in ticks
        if first.null_count() == 0
    ]


def instants(words: pl.Series) -> Instants | None:
    """The dates or times of day in words; None if they are none.

    Times of day that go back went past midnight.
    """
    for form in stamp_forms(words):
        t = form.since_first(words)
        if t is not None:
            return Instants(past_midnight(t) if form.of_day else t, form.origin)
    return None


def _stripped(words: pl.Series) -> pl.Series:
    return words.str.strip_chars().str.strip_chars('"').str.strip_chars()


def _bare(words: pl.Series) -> pl.Series:
    """Words without blanks, quotes and zone, empty ones null."""
    import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

    words = _stripped(words).str.replace(_ZONE.pattern, "").str.replace(",", ".", literal=True)
    return pl.select(pl.when(words != "").then(words)).to_series()


def _ticks(words: pl.Series, form: str, *, of_day: bool) -> pl.Series:
    """Instants, ns since 1970 or since midnight, null for what is not of the form."""
    if of_day:
        return words.str.to_time(form, strict=False).to_physical()
    return words.str.to_datetime(form, time_unit="ns", strict=False).to_physical()


def _offset(zone: re.Match[str] | None) -> float:
    """By how much a zone is ahead of universal time, s."""
    if zone is None or zone[0] == "Z":
        return 0.0
    sign, hours, minutes = zone["sign"], zone["hours"], zone["minutes"]
    return (-1.0 if sign == "-" else 1.0) * (3600.0 * int(hours) + 60.0 * int(minutes))


def past_midnight(t: Array) -> Array:
    """Times of day that go on after midnight, s; nan stays."""
    finite = np.flatnonzero(np.isfinite(t))
    if not len(finite):
        return t
    backwards = np.diff(t[finite], prepend=t[finite[0]]) < -0.5 * _DAY
    result = t.copy()
    result[finite] += _DAY * np.cumsum(backwards)
    return result
