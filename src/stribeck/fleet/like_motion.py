"""Which identifications of an axis may be compared: those of like motion, law, rig and load."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

#: What of a motion has to be alike, and the factor within which it is.
MOTION = ("speed_low", "speed_median", "speed_high", "travel")
FACTOR = 1.5
#: What has to be the same.
SAME = ("law", "rig", "load")


def kinds(rows: Sequence[Mapping[str, Any]], factor: float = FACTOR) -> list[int]:
    """The kind of each row, from 0 in the order in which they are met.

    A row is of the first kind whose first row it is like: later rows change nothing for those
    before them.

    Args:
        rows: Rows of a fleet's table, in the order of time.
        factor: Within which speeds and travel are alike.
    """
    leaders: list[Mapping[str, Any]] = []
    result = []
    for row in rows:
        alike = (k for k, leader in enumerate(leaders) if is_like(row, leader, factor))
        kind = next(alike, len(leaders))
        if kind == len(leaders):
            leaders.append(row)
        result.append(kind)
    return result


def is_like(row: Mapping[str, Any], other: Mapping[str, Any], factor: float) -> bool:
    """Whether two rows may be compared."""
    return all(row[name] == other[name] for name in SAME) and all(
        _within(row[name], other[name], factor) for name in MOTION
    )


def _within(a: float | None, b: float | None, factor: float) -> bool:
    if a is None or b is None or min(a, b) <= 0.0:  # of runs at constant speed, travel is 0
        return a == b
    return abs(math.log(a / b)) <= math.log(factor) + 1e-12
