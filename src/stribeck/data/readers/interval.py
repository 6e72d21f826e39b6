"""Some time of a log, and the rows of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .raw_table import RawTable

#: Rows beside those of an interval that are read as well: repairs look at neighbours.
BESIDE = 16


@dataclass(frozen=True)
class Interval:
    """Some time of a log.

    Args:
        column: Of times, of which there is one where a log has no clock; empty for its clock.
        first: Its begin, as the column has it, or s on the clock.
        last: Its end.
    """

    column: str
    first: float
    last: float


def cut(table: RawTable, interval: Interval) -> RawTable:
    """The rows of a table in an interval and a few beside it, in arrays of their own."""
    t = table.columns[interval.column] if interval.column else table.t
    if t is None:
        return table
    inside = np.flatnonzero((t >= interval.first) & (t <= interval.last))
    first, last = (int(inside[0]), int(inside[-1])) if len(inside) else (0, -1)
    rows = slice(max(first - BESIDE, 0), last + 1 + BESIDE * bool(len(inside)))
    return replace(
        table,
        columns={name: values[rows].copy() for name, values in table.columns.items()},
        places=table.places[rows],
        t=None if table.t is None else table.t[rows].copy(),
    )
