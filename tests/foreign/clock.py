"""Signals between their samples, and how many steps a sample lasts."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from . import compiled

Array = NDArray[Any]


def steps_in(span: float, h: float) -> int:
    """Steps of h in a span of time, which has to hold a whole number of them.

    Raises:
        ValueError: it does not.
    """
    count = round(span / h)
    if count < 1 or abs(count * h - span) > 1e-6 * span:
        raise ValueError(f"{span} s is no whole number of steps of {h} s")
    return count


@compiled
def segment(t: float, k: int, times: Array) -> int:
    """The last knot at or before t, from k on; the last but one at the end."""
    while k + 2 < len(times) and t >= times[k + 1] - 1e-12:
        k += 1
    return k


@compiled
def line(t: float, k: int, times: Array, values: Array) -> float:
    """A signal that is a straight line between its samples."""
    share = (t - times[k]) / (times[k + 1] - times[k])
    return float(values[k] + share * (values[k + 1] - values[k]))
