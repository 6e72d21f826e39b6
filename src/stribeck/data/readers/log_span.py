"""When a log begins and ends, before its samples are read, and which of them a window needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from .budget import refuse_rows
from .choice import Choice
from .columns import Heads
from .interval import Interval
from .raw_table import RawTable


@dataclass(frozen=True)
class LogSpan:
    """The time that the rows of a log take.

    Args:
        column: Of times; empty where the log has a clock.
        first: The first instant, s.
        last: The last.
        ends: Both as the column has them.
        rows: Between them.
    """

    column: str
    first: float
    last: float
    ends: tuple[float, float]
    rows: int

    @classmethod
    def of(
        cls, heads: Heads, wanted: set[str], grid: str, chosen: Mapping[str, Choice]
    ) -> LogSpan | None:
        """That of columns, None if it is not known, or they have several clocks.

        Args:
            heads: Of the log.
            wanted: Names of the columns.
            grid: That on whose clock all are brought.
            chosen: Channel -> column.
        """
        base = heads.columns.get(grid)
        columns = [heads.columns[n] for n in wanted if n in heads.columns]
        if base is None or any((c.clock, c.count) != (base.clock, base.count) for c in columns):
            return None
        time = chosen.get("time")
        column, ends = "", base.span
        if time is not None:
            column = time.column
            ends = heads.columns[column].ends if column in heads.columns else None
        if ends is None or (time is not None and isinstance(time.factor, str)):
            return None
        first, last = ends
        if time is not None:
            first, last = time.values(RawTable({column: np.array(ends)}, np.arange(2))).tolist()
        return cls(column, first, last, ends, base.count) if first < last else None

    @property
    def seconds(self) -> float:
        """Its length."""
        return self.last - self.first

    def rows_in(self, window: tuple[float, float]) -> int:
        """About how many rows a window has, s from the begin of the log."""
        inside = min(window[1], self.seconds) - min(window[0], self.seconds)
        return round(self.rows * inside / self.seconds)

    def interval(self, window: tuple[float, float]) -> Interval:
        """A window, s from the begin, as the column of times has it.

        Raises:
            InputError: the log is over before it.
        """
        if window[0] > self.seconds:
            raise InputError(no_samples(window, 0, self.seconds))
        scale = (self.ends[1] - self.ends[0]) / self.seconds
        begin, end = (self.ends[0] + scale * t for t in window)
        return Interval(self.column, begin, end)

    def refuse_much(self, rows: int, columns: int) -> None:
        """Refuse more rows than fit in memory, and say how long a part of the log does.

        Raises:
            InputError: they are more.
        """
        refuse_rows(rows, columns, self.rows / self.seconds)


def no_samples(window: tuple[float, float], count: int, seconds: float) -> str:
    """That a window has no samples, or too few."""
    return f"{window[0]:g}s:{window[1]:g}s holds {count} samples: the log lasts {seconds:.4g} s"
