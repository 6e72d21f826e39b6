"""Average run lengths of control charts, by Markov chains, and the limits that give one.

The run length is how many values a chart of independent standard normal values takes until it
raises an alarm. The states of a chart are cut into cells; from the probabilities P of a step from
one cell into another, the average lengths are L = 1 + P L (Brook and Evans 1972,
doi 10.1093/biomet/59.3.539).

CUSUM, S_i = max(0, S_{i-1} + z_i - k), alarm at S_i > h (Page 1954, doi 10.1093/biomet/41.1-2.100).
Of its two sides together 1/L = 1/L_up + 1/L_down (Kemp 1961).

EWMA, Z_i = (1 - l) Z_{i-1} + l z_i, alarm at |Z_i| > c sqrt(l / (2 - l)) (Roberts 1959).

A value counts for at most w, so that no value alone raises an alarm where w is small enough: then
an outlier is none (the aim of the robust CUSUM of Lucas and Crosier 1982, Communications in
Statistics 11, 2669).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from ..space import Array

#: Cells of a chart's states, an odd number: of an EWMA the middle one is about zero.
_CELLS = 121
#: The least limit, where every other value raises an alarm.
_LEAST = 0.05


def cusum_run_length(k: float, h: float, shift: float = 0.0, most: float = math.inf) -> float:
    """Average run length of both sides of a CUSUM from zero.

    Args:
        k: Allowance, standard deviations.
        h: Limit, standard deviations.
        shift: Mean of the values, standard deviations.
        most: w, for which a value counts at most, standard deviations.
    """
    sides = (_cusum_side(k, h, s, most) for s in (shift, -shift))
    return 1.0 / sum(1.0 / side for side in sides)


def _cusum_side(k: float, h: float, shift: float, most: float) -> float:
    """Average run length of the side that adds values up, from zero.

    The lowest cell is about zero, half as wide, and takes in all that is below.
    """
    width = h / (_CELLS - 0.5)
    states = width * np.arange(_CELLS)
    ends = np.append(-math.inf, states + 0.5 * width)
    return float(_run_lengths(ends - states[:, None] + k, shift, most)[0])


def ewma_run_length(
    share: float, limit: float, shift: float = 0.0, most: float = math.inf
) -> float:
    """Average run length of an EWMA from zero.

    Args:
        share: l, the weight of the newest value.
        limit: c, in standard deviations that Z has in the long run.
        shift: Mean of the values, standard deviations.
        most: w, for which a value counts at most, standard deviations.
    """
    ends = limit * math.sqrt(share / (2.0 - share)) * np.linspace(-1.0, 1.0, _CELLS + 1)
    states = 0.5 * (ends[1:] + ends[:-1])
    values = (ends - (1.0 - share) * states[:, None]) / share
    return float(_run_lengths(values, shift, most)[_CELLS // 2])


def _run_lengths(ends: Array, shift: float, most: float) -> Array:
    """Average run length from each cell, (m,).

    Args:
        ends: The values that take the chart from a cell to the ends of the cells, (m, m + 1).
        shift: Mean of the values.
        most: For which a value counts at most.
    """
    below = ndtr(ends - shift)
    below[ends >= most] = 1.0
    below[ends < -most] = 0.0
    return np.asarray(np.linalg.solve(np.eye(len(ends)) - np.diff(below), np.ones(len(ends))))


@cache
def cusum_limit(k: float, run_length: float, part: float = math.inf) -> float:
    """The limit h at which both sides of a CUSUM run so long on average while nothing changes.

    Args:
        k: Allowance, standard deviations.
        run_length: How long.
        part: What a value adds at most, as a part of h: w = k + part h.
    """
    return _limit(lambda h: cusum_run_length(k, h, most=k + part * h), run_length)


@cache
def ewma_limit(share: float, run_length: float, most: float = math.inf) -> float:
    """The limit c at which an EWMA runs so long on average while nothing changes."""
    return _limit(lambda c: ewma_run_length(share, c, most=most), run_length)


def _limit(length: Callable[[float], float], run_length: float) -> float:
    """Where an average run length that grows with the limit is as wanted."""

    def excess(limit: float) -> float:
        return math.log(length(limit) / run_length)

    low, high = _LEAST, 1.0
    if excess(low) >= 0:
        return low
    while excess(high) < 0:
        low, high = high, 1.5 * high
    return float(brentq(excess, low, high, xtol=1e-6))
