"""Columns of numbers as they stand in a file, before they have quantities or units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...space import Array


@dataclass(frozen=True, eq=False)
class RawTable:
    """What a file of any format comes down to.

    Args:
        columns: Head -> values (N,), NaN where a cell is empty.
        places: Where each row stands in the file, (N,); a range takes no memory.
        word: What a place is called: a line of text, a row of a table.
        text: Head -> place and content of the first cell that is no number, where there is one.
        scalars: Single numbers that the file keeps beside its columns.
        units: Units that the file states by type instead of in a head.
        notes: What was left out on the way, a sentence each.
        t: When each row was measured, s, (N,), if the format itself says so; None where a column
            has to.
        clock: What the clock of those times is called; tables of one name share it.
        began: The instant of t = 0, s since 1970, where the format says it.
        dates: Column of dates -> the instant of its 0, s since 1970; of times of day, since
            midnight.
    """

    columns: Mapping[str, Array]
    places: NDArray[np.int64] | range
    word: str = "row"
    text: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    scalars: Mapping[str, float] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    t: Array | None = None
    clock: str = ""
    began: float | None = None
    dates: Mapping[str, float] = field(default_factory=dict)

    def place(self, row: int) -> str:
        """How a message says where a row stands."""
        return f"{self.word} {self.places[row]}"


def listed(names: Mapping[str, object] | list[str], limit: int = 12) -> str:
    """Names for a message, not too many of them."""
    names = [shortened(name) for name in names]
    return ", ".join(names[:limit]) + (f" and {len(names) - limit} more" * (len(names) > limit))


def shortened(text: str, limit: int = 40) -> str:
    """A piece of somebody's file for a message: printable and short."""
    text = printable(text)
    return text if len(text) <= limit else f"{text[:limit]}..."


def printable(text: str) -> str:
    """The same in one line without control characters."""
    return "".join(c if c.isprintable() else " " for c in text).strip()


def unique_names(names: Sequence[str]) -> list[str]:
    """Names of which none stands twice: a second `Torque` is `Torque #2`."""
    taken: set[str] = set()
    last: dict[str, int] = {}  # numbers up to it are taken
    result = []
    for name in names:
        unique, k = name, last.get(name, 1)
        while unique and unique in taken:
            k += 1
            unique = f"{name} #{k}"
        taken.add(unique)
        last[name] = k
        result.append(unique)
    return result
