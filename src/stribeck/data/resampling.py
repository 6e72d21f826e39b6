"""A channel at instants that are not those of its samples.

A straight line between two samples loses (w h)^2 / 12 of a tone w on the mean, h the interval, and
a mass that is read from it as much: 1 % at an eighteenth of the sampling rate. A polynomial through
six samples loses less than a thousandth up to an eighth of it. The mean over an interval of a
slower clock loses (w h)^2 / 24, which differences of such means show and give back.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..space import Array
from .zero_phase import BLOCK

#: Samples that a polynomial goes through: three to each side, but at the ends.
_NODES = 6
#: An interval of more than this many is a gap: what lies in it was not measured.
GAP = 3.5
#: Of an interval that is shorter than this share of the others the noise would be a slope.
_SHORTEST = 0.5
#: Second and fourth differences of means over an interval that are taken off for the values in its
#: middle, exact for polynomials of degree 5; and how far an interval may be off the others for it.
_SHARPER, _EVEN = (1 / 24, -3 / 640), 0.1


def interpolated(at: Array, t: Array, values: Array) -> Array:
    """A channel at other instants: on polynomials of degree 5, on lines where these lack samples.

    Lines are straight, as of `numpy.interp`, which holds the first and the last value beyond the
    ends: they are taken beside a gap, samples that all but coincide, and those that are not finite.
    No value lies beyond the least and the greatest that were measured, nor off these between two
    samples there: where a sensor was at its limit, it is there still.

    Args:
        at: Instants, s, rising, (n,).
        t: Those of the samples, s, rising, (N,).
        values: The samples, (N,).

    Returns:
        (n,).
    """
    result = np.asarray(np.interp(at, t, values), dtype=float)
    if len(t) < _NODES or not len(at):
        return result
    even, lowest, highest = _even(t, values), np.fmin.reduce(values), np.fmax.reduce(values)
    limited = (values == lowest) | (values == highest)
    flat = np.append(limited[1:] & (values[1:] == values[:-1]), False)
    for k in range(0, len(at), BLOCK):
        block = slice(k, min(k + BLOCK, len(at)))
        between = np.searchsorted(t, at[block], side="right") - 1
        first = np.clip(between - _NODES // 2 + 1, 0, len(even) - 1)
        inside = (between >= 0) & (at[block] < t[-1]) & even[first] & (at[block] > t[between])
        inside &= ~flat[between]
        if inside.any():
            smooth = _polynomial(at[block][inside], t, values, first[inside])
            lines = result[block][inside]
            smooth = np.where(np.isfinite(smooth), np.clip(smooth, lowest, highest), lines)
            result[block][inside] = smooth
    return result


def averaged(grid: Array, t: Array, values: Array) -> Array:
    """A channel on a slower clock, so that little from above half its rate folds down.

    What the means over the interval around each instant lose of what is slower is given back where
    these intervals are even.

    Args:
        grid: The slower clock, s, rising, (n,).
        t: Instants of the samples, s, rising, (N,).
        values: The samples, (N,), finite.

    Returns:
        (n,).
    """
    middles = 0.5 * (grid[1:] + grid[:-1])
    edges = np.concatenate([[grid[0] - (middles[0] - grid[0])], middles,
                            [grid[-1] + (grid[-1] - middles[-1])]])  # fmt: skip
    edges = np.clip(edges, t[0], t[-1])
    width = np.diff(edges)
    means = np.where(
        width > 0.0,
        np.diff(interpolated(edges, t, integral(t, values))) / np.where(width > 0.0, width, 1.0),
        np.interp(grid, t, values),
    )
    off = _uneven(width)
    apart = _uneven(np.diff(grid))
    off[1:] |= apart
    off[:-1] |= apart
    return np.clip(_sharpened(means, off), values.min(), values.max())


def integral(t: Array, values: Array) -> Array:
    """Of a channel up to each sample, (N,): of polynomials of degree 3, where uneven by trapezia.

    Args:
        t: Instants of the samples, s, rising, (N,).
        values: The samples, (N,), finite.
    """
    areas = np.diff(t) * (values[1:] + values[:-1]) / 2.0
    if len(t) > 3:  # noqa: PLR2004 - as a polynomial of degree 3 takes
        even = ~_uneven(np.diff(t))
        inner = even[:-2] & even[1:-1] & even[2:]
        bend = values[3:] - values[2:-1] - values[1:-2] + values[:-3]
        areas[1:-1] -= np.where(inner, np.diff(t)[1:-1] * bend / 24.0, 0.0)
    return np.concatenate([[0.0], np.cumsum(areas)])


def _uneven(intervals: Array) -> NDArray[np.bool_]:
    """Intervals that are not as long as most, (N,)."""
    median = float(np.median(intervals))
    return np.abs(intervals - median) > _EVEN * median


def _sharpened(means: Array, off: NDArray[np.bool_]) -> Array:
    """Values in the middle of intervals, (N,), from means over them; means beside uneven ones."""
    reach = len(_SHARPER)
    if len(means) <= 2 * reach:
        return means
    loss, n = np.zeros(len(means)), len(means) - 2 * reach
    difference = means
    for k, weight in enumerate(_SHARPER, 1):
        difference = np.diff(difference, 2)
        loss[reach:-reach] += weight * difference[reach - k : reach - k + n]
    for k in range(2 * reach + 1):
        loss[reach:-reach][off[k : k + n]] = 0.0
    return means - loss


def _even(t: Array, values: Array) -> NDArray[np.bool_]:
    """From which samples on six follow each other evenly and are numbers, (N - 5,)."""
    interval = np.diff(t)
    median = float(np.median(interval))
    good = (interval >= _SHORTEST * median) & (interval <= GAP * median) & (interval > 0.0)
    finite = np.isfinite(values)
    good &= finite[1:] & finite[:-1]
    n = len(t) - _NODES + 1
    return np.asarray(np.logical_and.reduce([good[k : k + n] for k in range(_NODES - 1)]))


def _polynomial(at: Array, t: Array, values: Array, first: NDArray[np.intp]) -> Array:
    """Newton's polynomials through six samples, (n,).

    Args:
        at: Instants, (n,).
        t: Those of all samples.
        values: These.
        first: The first of the samples for each instant, (n,).
    """
    start, place = np.unique(first, return_inverse=True)
    rows = start + np.arange(_NODES)[:, None]
    nodes, divided = t[rows], values[rows]
    for order in range(1, _NODES):
        divided[order:] = (divided[order:] - divided[order - 1 : -1]) / (
            nodes[order:] - nodes[:-order]
        )
    result = divided[-1][place]
    for order in range(_NODES - 2, -1, -1):
        result = result * (at - nodes[order][place]) + divided[order][place]
    return np.asarray(result)
