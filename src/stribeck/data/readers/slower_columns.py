"""Columns that a logger writes in every k-th row alone, as tables of their own clock.

Drives and PLCs that record at two rates write one table at the faster one, and leave the cells of
the slower columns empty between their samples. Each such column is a channel with fewer samples,
and none with gaps: it has the times of its own rows.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from .choice import Choice
from .raw_table import RawTable
from .repair import SHORT_GAP

#: From how many rows to a sample on a column is a slower one: below it, cells are missing.
_SLOWER = 2


def by_rate(
    table: RawTable, time: Choice | None, grid: str, wanted: Collection[str]
) -> tuple[RawTable, ...]:
    """A table taken apart into one for each set of rows that its columns are written in.

    Args:
        table: Of one clock.
        time: The column of times, if there is one.
        grid: The column on whose clock the others are brought: it keeps the column of times.
        wanted: The columns that become channels; the others stay where every row is.

    Returns:
        The table alone where no column is slower, or where its rows are not in order of time.
    """
    if time is None or time.column not in table.columns or table.text:
        return (table,)
    rows: dict[bytes, tuple[NDArray[np.intp], list[str]]] = {}
    for name in table.columns:
        if name in wanted and name != time.column:
            written = _rows(table.columns[name])
            if written is not None:
                rows.setdefault(written.tobytes(), (written, []))[1].append(name)
    if not rows:
        return (table,)
    t = time.values(table)
    if not np.isfinite(t).all() or (np.diff(t) < 0.0).any():
        return (table,)
    slower = {name for _, names in rows.values() for name in names}
    groups = [(slice(None), [n for n in table.columns if n not in slower]), *rows.values()]
    tables = []
    for written, names in groups:
        kept = {*names, time.column} if grid in names else {*names} - {time.column}
        columns = {n: a[written] for n, a in table.columns.items() if n in kept}
        if columns:
            places = np.asarray(table.places)[written]
            tables.append(replace(table, columns=columns, t=t[written], places=places, notes=()))
    return (replace(tables[0], notes=table.notes), *(replace(t, scalars={}) for t in tables[1:]))


def _rows(values: Array) -> NDArray[np.intp] | None:
    """The rows in which a slower column is written; None of one that is no slower."""
    written = np.flatnonzero(~np.isnan(values))
    if len(written) < 2 or len(written) * _SLOWER > len(values) + 1:  # noqa: PLR2004 - an interval
        return None
    steps = np.diff(written)
    step = int(np.median(steps))
    ends = max(int(written[0]), len(values) - 1 - int(written[-1]))
    longest = step * (SHORT_GAP + 1)
    return written if step >= _SLOWER and max(int(steps.max()), ends) <= longest else None
