"""Least and greatest values of a channel over runs of rows: what a plot of ten million needs.

A picture is a thousand pixels wide. Of each pixel's rows only the extremes show, so only they
travel; levels of a pyramid, each coarser by a factor, give them without a walk through all rows.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..space import Array

#: Rows of a level that one of the next stands for, and entries below which there is no next.
FACTOR, SMALLEST = 8, 4096


class Pyramid:
    """The extremes of one channel on every level.

    Args:
        values: The channel, (N,), finite.
    """

    def __init__(self, values: Array) -> None:
        self.values = values

    @cached_property
    def levels(self) -> list[tuple[Array, Array]]:
        """(least, greatest) of runs of FACTOR, FACTOR^2, ... rows; the last run may be short."""
        levels = []
        low = high = self.values
        while len(low) > SMALLEST:
            starts = np.arange(0, len(low), FACTOR)
            low, high = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
            levels.append((low, high))
        return levels

    def extremes(self, edges: NDArray[np.intp]) -> tuple[Array, Array]:
        """Least and greatest value between neighbouring edges.

        Args:
            edges: Rows, (m + 1,), increasing, whole numbers; the last is behind its rows.

        Returns:
            Two arrays (m,). Where runs of a coarser level straddle an edge, rows of less than an
            eighth of the shortest interval to either side count, too.
        """
        shortest = int(np.diff(edges).min())
        level, span = 0, 1
        while level < len(self.levels) and span * FACTOR * FACTOR <= shortest:
            level, span = level + 1, span * FACTOR
        low, high = (self.values, self.values) if level == 0 else self.levels[level - 1]
        starts = np.minimum(edges[:-1] // span, len(low) - 1)
        end = -(-int(edges[-1]) // span)
        return np.minimum.reduceat(low[:end], starts), np.maximum.reduceat(high[:end], starts)


def windowed(
    t: Array, channels: dict[str, Pyramid], since: float, until: float, pixels: int
) -> tuple[Array, dict[str, Array], bool]:
    """What a plot of a part of a log draws.

    Args:
        t: Times, (N,), s, increasing.
        channels: Channels by name, each of N values.
        since: Where the plot begins, s.
        until: Where it ends, s.
        pixels: Its width.

    Returns:
        Times, lines by name, and whether they are the very samples; otherwise each pixel has two
        points, its extremes in the order in which the line passes them. Where rows are missing,
        a line has nan.
    """
    first = max(int(np.searchsorted(t, since, "right")) - 1, 0)
    last = min(int(np.searchsorted(t, until, "left")) + 1, len(t))
    last = max(last, min(first + 2, len(t)))
    if last - first <= 2 * pixels:
        rows = np.arange(first, last)
        lines = {n: np.asarray(p.values[rows], dtype=float) for n, p in channels.items()}
        return *_broken(t[rows], lines), True
    edges = np.linspace(first, last, pixels + 1).astype(np.intp, copy=False)
    middle = (edges[:-1] + edges[1:]) // 2
    times = np.stack([t[edges[:-1]], t[middle]], axis=1).ravel()
    lines = {}
    for name, pyramid in channels.items():
        low, high = pyramid.extremes(edges)
        rising = pyramid.values[edges[1:] - 1] >= pyramid.values[edges[:-1]]
        pair = np.where(rising[:, None], np.stack([low, high], 1), np.stack([high, low], 1))
        lines[name] = pair.ravel()
    return *_broken(times, lines), False


def _broken(t: Array, lines: dict[str, Array]) -> tuple[Array, dict[str, Array]]:
    """Lines with a nan where times are far more apart than usual."""
    if len(t) < 3:  # noqa: PLR2004 - two points have one interval
        return t, lines
    steps = np.diff(t)
    breaks = np.flatnonzero(steps > 3.0 * np.median(steps)) + 1
    if not len(breaks) or len(breaks) > len(t) // 4:
        return t, lines
    between = 0.5 * (t[breaks - 1] + t[breaks])
    return np.insert(t, breaks, between), {
        n: np.insert(a, breaks, np.nan) for n, a in lines.items()
    }
