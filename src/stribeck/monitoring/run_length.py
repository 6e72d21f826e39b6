"""Average run lengths of control charts, by integral equations, and the limits that give one.

The run length is how many values a chart of independent standard normal values takes until it
raises an alarm. Its average L(s) from a state s of the chart solves a Fredholm equation of the
second kind, here by Gauss-Legendre quadrature (Nyström).

CUSUM, S_i = max(0, S_{i-1} + z_i - k), alarm at S_i > h (Page 1954, doi 10.1093/biomet/41.1-2.100;
the equation: Goel and Wu 1971, doi 10.1080/00401706.1971.10488777). Of its two sides together
1/L = 1/L_up + 1/L_down (Kemp 1961).

EWMA, Z_i = (1 - l) Z_{i-1} + l z_i, alarm at |Z_i| > c sqrt(l / (2 - l)) (Roberts 1959; the
equation: Crowder 1987, doi 10.1080/00401706.1987.10488267).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from ..space import Array

#: Nodes of the quadrature: of an interval of length 10, seven to a standard deviation of z.
_NODES = 72
#: The least limit, where every other value raises an alarm.
_LEAST = 0.05
_SQRT_2PI = math.sqrt(2.0 * math.pi)


def cusum_run_length(k: float, h: float, shift: float = 0.0) -> float:
    """Average run length of both sides of a CUSUM from zero.

    Args:
        k: Allowance, standard deviations.
        h: Limit, standard deviations.
        shift: Mean of the values, standard deviations.
    """
    sides = (_cusum_side(k, h, shift), _cusum_side(k, h, -shift))
    return 1.0 / sum(1.0 / side for side in sides)


def _cusum_side(k: float, h: float, shift: float) -> float:
    """Average run length of the side that adds values up, from zero.

    L(s) = 1 + L(0) P(z < k - s) + int_0^h L(x) p(x + k - s) dx, z normal about the shift.
    """
    x, weights = _quadrature(0.0, h)
    states = np.concatenate([[0.0], x])
    kernel = np.empty((len(states), len(states)))
    kernel[:, 0] = ndtr(k - states - shift)
    kernel[:, 1:] = weights * _density(x + k - states[:, None] - shift)
    lengths = np.linalg.solve(np.eye(len(states)) - kernel, np.ones(len(states)))
    return float(lengths[0])


def ewma_run_length(share: float, limit: float, shift: float = 0.0) -> float:
    """Average run length of an EWMA from zero.

    L(u) = 1 + 1/l int L(y) p((y - (1 - l) u) / l) dy between the limits.

    Args:
        share: l, the weight of the newest value.
        limit: c, in standard deviations that Z has in the long run.
        shift: Mean of the values, standard deviations.
    """
    end = limit * math.sqrt(share / (2.0 - share))
    y, weights = _quadrature(-end, end)
    states = np.concatenate([[0.0], y])
    kernel = weights * _density((y - (1.0 - share) * states[:, None]) / share - shift) / share
    lengths = np.linalg.solve(np.eye(len(y)) - kernel[1:], np.ones(len(y)))
    return float(1.0 + kernel[0] @ lengths)


@cache
def cusum_limit(k: float, run_length: float) -> float:
    """The limit h at which both sides of a CUSUM run so long on average while nothing changes."""
    return _limit(lambda h: cusum_run_length(k, h), run_length)


@cache
def ewma_limit(share: float, run_length: float) -> float:
    """The limit c at which an EWMA runs so long on average while nothing changes."""
    return _limit(lambda c: ewma_run_length(share, c), run_length)


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


def _quadrature(low: float, high: float) -> tuple[Array, Array]:
    """Nodes and weights between two ends."""
    nodes, weights = _unit_quadrature()
    half = 0.5 * (high - low)
    return low + half * (nodes + 1.0), half * weights


@cache
def _unit_quadrature() -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    return nodes, weights


def _density(z: Array) -> Array:
    return np.asarray(np.exp(-0.5 * np.square(z)) / _SQRT_2PI)
