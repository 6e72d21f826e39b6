"""Strokes of an axis whose position is commanded."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .offer import HOLD, Offer, OperatingRange, course

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

#: Speeds of strokes, as multiples of the log's mean one.
SPEEDS = (0.2, 0.5, 2.0)


def commanded_strokes(axis: OperatingRange, seconds: float) -> Iterator[Offer]:
    """Strokes over the travel of the logs, short ones, and a staircase.

    Args:
        axis: The axis; its position is commanded.
        seconds: How long each takes.
    """
    low, high, pace = axis.low, axis.high, axis.pace
    ends = f"between {axis.place(low)} and {axis.place(high)}"

    def offer(name: str, words: str, t: Sequence[float], x: Sequence[float]) -> Offer:
        return Offer(name, words, [course(axis, t, x)])

    for times in SPEEDS:
        v = times * pace
        yield offer(f"strokes × {times:g}", f"strokes {ends} at {axis.rate(v)}",
                    *_there_and_back(low, high, [v], seconds))  # fmt: skip
    several = [s * pace for s in (0.1, 0.3, 1.0, 2.0)]
    yield offer("several speeds", f"strokes {ends} at {axis.listed('velocity', several)}",
                *_there_and_back(low, high, several, seconds))  # fmt: skip
    third = (high - low) / 3
    yield offer("reversals", f"short strokes between {axis.place(low + third)} and "
                f"{axis.place(high - third)} at {axis.rate(0.3 * pace)}",
                *_there_and_back(low + third, high - third, [0.3 * pace], seconds))  # fmt: skip
    steps = np.concatenate([np.linspace(low, high, 6), np.linspace(high, low, 6)[1:]])
    dwell = (seconds - HOLD) / (len(steps) - 1)
    move = min(0.5 * dwell, (high - low) / 5 / pace)
    t, x = [0.0, HOLD], [steps[0], steps[0]]
    for step in steps[1:]:
        t += [t[-1] + move, t[-1] + dwell]
        x += [step, step]
    yield offer("staircase", f"from {axis.place(low)} to {axis.place(high)} and back in steps of "
                f"{axis.place((high - low) / 5)}, {dwell:.2g} s each", t, x)  # fmt: skip


def _there_and_back(
    low: float, high: float, pace: Sequence[float], seconds: float
) -> tuple[list[float], list[float]]:
    """Knots of strokes between two ends for `seconds`, each speed an equal share of the time."""
    t, x = [0.0, HOLD], [low, low]
    goal = high
    for k, speed in enumerate(pace, 1):
        until = HOLD + (seconds - HOLD) * k / len(pace)
        while t[-1] < until * (1 - 1e-9):
            step = min(abs(goal - x[-1]) / speed, until - t[-1])
            t.append(t[-1] + step)
            x.append(x[-1] + np.sign(goal - x[-1]) * speed * step)
            if abs(x[-1] - goal) < 1e-9 * abs(high - low):
                goal = low if goal == high else high
    return t, x
