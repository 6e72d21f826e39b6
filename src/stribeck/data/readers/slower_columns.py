"""Columns that a logger writes in every k-th row alone, as drives do that record at two rates.

Their cells are empty between their samples, which are no gaps: each is a table of its own clock.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from .choice import Choice
from .raw_table import RawTable
from .repair import SHORT_GAP

#: From how many rows to a sample on a column is a slower one: below it, cells are missing.
_SLOWER = 2
#: Stamps are rounded where more than this share of them repeats the one before.
_ROUNDED = 0.3


class _Rows(NamedTuple):
    """Columns, and the rows that they are written in; of all rows None."""

    names: list[str]
    written: NDArray[np.intp] | None = None


def by_rate(
    table: RawTable, time: Choice | None, grid: str, wanted: Collection[str]
) -> tuple[RawTable, ...]:
    """A table taken apart into one for each set of rows that its columns are written in.

    Args:
        table: Of one clock.
        time: The column of times, if there is one.
        grid: The column on whose clock the others are brought: it keeps the column of times.
        wanted: The columns that become channels; the others stay with the faster ones.

    Returns:
        The table alone where no column is slower, or where its rows are not in order of time.
    """
    if time is None or time.column not in table.columns or time.column in table.text:
        return (table,)
    if isinstance(time.factor, str):  # it would have to go with the times of each
        return (table,)
    slower = _slower({n: a for n, a in table.columns.items() if n in wanted and n != time.column})
    if not slower:
        return (table,)
    t = time.values(table)
    if not np.isfinite(t).all() or (np.diff(t) < 0.0).any():
        return (table,)
    if np.mean(np.diff(t) == 0.0) > _ROUNDED:  # the rows tell the time between two stamps
        t = np.linspace(t[0], t[-1], len(t))
    apart = {name for rows in slower for name in rows.names}
    first = _Rows([n for n in table.columns if n not in apart])
    parts = [_part(table, t, rows, time.column, grid) for rows in (first, *slower)]
    whole = [part for part in parts if part.columns]
    return (replace(whole[0], notes=table.notes), *(replace(p, scalars={}) for p in whole[1:]))


def _part(table: RawTable, t: Array, rows: _Rows, time: str, grid: str) -> RawTable:
    """Some columns in the rows that they are written in, with the times of these."""
    names = {*rows.names, time} if grid in rows.names else {*rows.names} - {time}
    at = slice(None) if rows.written is None else rows.written
    columns = {n: a[at] for n, a in table.columns.items() if n in names}
    return replace(table, columns=columns, places=np.asarray(table.places)[at], t=t[at], notes=())


def _slower(columns: dict[str, Array]) -> list[_Rows]:
    """The columns that are slower ones, those that are written in the same rows together."""
    groups: dict[bytes, _Rows] = {}
    for name, values in columns.items():
        written = np.flatnonzero(~np.isnan(values))
        if _is_slower(written, len(values)):
            groups.setdefault(written.tobytes(), _Rows([], written)).names.append(name)
    return list(groups.values())


def _is_slower(written: NDArray[np.intp], count: int) -> bool:
    """Whether rows are those of a slower column, and not what gaps have left of one."""
    if len(written) < 2 or len(written) * _SLOWER > count + 1:  # noqa: PLR2004 - an interval
        return False
    steps = np.diff(written)
    step = int(np.median(steps))
    longest = max(int(steps.max()), int(written[0]), count - 1 - int(written[-1]))
    return step >= _SLOWER and longest <= step * (SHORT_GAP + 1)
