"""Arrays by name as tables: those that are as long as each other belong together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from ...space import Array
from .raw_table import RawTable


def matrix_names(name: str, width: int) -> tuple[str, ...]:
    """Of the columns of a matrix: its own and their number, from 1."""
    return (name,) if width == 1 else tuple(f"{name}_{i}" for i in range(1, width + 1))


def by_length(
    columns: Mapping[str, Array],
    units: Mapping[str, str] | None = None,
    scalars: Mapping[str, float] | None = None,
) -> tuple[RawTable, ...]:
    """A table for each length; single numbers are with the longest."""
    tables: dict[int, dict[str, Array]] = {}
    for name, values in columns.items():
        tables.setdefault(len(values), {})[name] = values
    if scalars and not tables:
        tables[0] = {}
    longest = max(tables, default=0)
    return tuple(
        RawTable(
            series,
            np.arange(1, count + 1),
            "row",
            scalars=(scalars or {}) if count == longest else {},
            units={n: u for n, u in (units or {}).items() if n in series},
        )
        for count, series in tables.items()
    )


class TimedSeries(NamedTuple):
    """A channel with times of its own.

    Args:
        name: Of the channel.
        t: Times, s, (N,).
        values: (N,).
        unit: As the file states it; empty if it does not.
    """

    name: str
    t: Array
    values: Array
    unit: str = ""


def by_times(
    series: Iterable[TimedSeries], first_line: int = 1, word: str = "line"
) -> list[RawTable]:
    """A table for each clock: channels of equal times share one."""
    clocks: list[list[TimedSeries]] = []
    for one in series:
        same = (c for c in clocks if np.array_equal(c[0].t, one.t))
        if clock := next(same, None):
            clock.append(one)
        else:
            clocks.append([one])
    return [
        RawTable(
            {s.name: s.values for s in clock},
            np.arange(len(clock[0].t)) + first_line,
            word,
            units={s.name: s.unit for s in clock if s.unit},
            t=clock[0].t,
            clock=f"clock {k}",
        )
        for k, clock in enumerate(clocks, 1)
    ]
