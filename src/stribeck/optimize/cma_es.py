"""Covariance matrix adaptation: a neighbourhood whose radius and shape adapt to the costs.

An evolution strategy that learns the matrix which turns a round cloud of neighbours into one that
fits the landscape (Beyer and Sendhoff 2017, doi 10.1109/TEVC.2017.2680320, which simplifies the
covariance matrix adaptation of Hansen and Ostermeier; rates as in Hansen 2016, arXiv 1604.00772).
It uses the order of the costs alone.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from ..space import Array, Rng
from .moves import Moves, Note

#: It ends when the cloud is this narrow, or its best costs have differed by no larger share for a
#: while.
NARROW, LEVEL = 1e-9, 1e-13
#: It ends, too, when this many times the rounds that it takes to see a level brought nothing.
LONG = 6


def cma_es(centre: Array, R: float, N: int, rng: Rng, note: Note) -> Moves[tuple[Array, float]]:
    """Search around a point of the unit cube until the neighbourhood has shrunk to nothing.

    Args:
        centre: Where, (dim,).
        R: First radius: the standard deviation of the neighbours' distance in a coordinate.
        N: Neighbours a round, from 4.
        rng: Source of the neighbours.
        note: Takes what every batch asks for.

    Returns:
        The best point it met, and its cost.
    """
    dim, half = len(centre), N // 2
    w = np.log((N + 1) / 2) - np.log(np.arange(1, half + 1))
    w /= w.sum()
    mass = 1.0 / float(w @ w)
    c_s = (mass + 2.0) / (mass + dim + 5.0)
    c_1 = 2.0 / ((dim + 1.3) ** 2 + mass)
    c_w = min(1.0 - c_1, 2.0 * (mass - 2.0 + 1.0 / mass) / ((dim + 2.0) ** 2 + mass))
    damp = 1.0 + c_s + 2.0 * max(0.0, np.sqrt((mass - 1.0) / (dim + 1.0)) - 1.0)
    expected = np.sqrt(dim) * (1.0 - 1.0 / (4.0 * dim) + 1.0 / (21.0 * dim**2))
    patience = 10 + 30 * dim // N
    M, s = np.eye(dim), np.zeros(dim)
    recent: deque[float] = deque(maxlen=patience)  # the least cost of each round
    best, least, idle = centre, np.inf, 0
    while True:
        note(asks="neighbours", radius=R)
        z = rng.standard_normal((N, dim))
        turned = z @ M.T
        proposed = centre + R * turned
        inside = np.minimum(np.maximum(proposed, 0.0), 1.0)
        costs = yield inside
        k = int(costs.argmin())
        recent.append(float(costs[k]))
        idle += 1
        if costs[k] < least:
            best, least, idle = inside[k].copy(), float(costs[k]), 0
        ranked = np.argsort(_with_penalty(costs, proposed - inside, R), kind="stable")[:half]
        z, turned = z[ranked], turned[ranked]
        centre = np.minimum(np.maximum(centre + R * (w @ turned), 0.0), 1.0)
        s = (1.0 - c_s) * s + np.sqrt(mass * c_s * (2.0 - c_s)) * (w @ z)
        M = (
            (1.0 - 0.5 * (c_1 + c_w)) * M
            + 0.5 * c_1 * np.outer(M @ s, s)
            + 0.5 * c_w * ((w[:, None] * turned).T @ z)
        )
        R *= float(np.exp(min(1.0, c_s / damp * (np.sqrt(s @ s) / expected - 1.0))))
        width = R * float(np.sqrt((M**2).sum(axis=1).max()))
        if idle > LONG * patience or not NARROW < width < np.inf or _level(recent):
            return best, least


def _with_penalty(costs: Array, outside: Array, R: float) -> Array:
    """Costs for the ranking: what was proposed outside pays for the way back."""
    if not outside.any():
        return costs
    runs = costs[np.isfinite(costs)]
    spread = float(np.ptp(runs)) if len(runs) else 1.0
    paid: Array = costs + (spread + 1e-300) * (outside**2).sum(axis=1) / R**2
    return paid


def _level(recent: deque[float]) -> bool:
    """Whether the rounds looked at brought all the same, or nothing that could be run."""
    low, high = min(recent), max(recent)
    return len(recent) == recent.maxlen and not high - low > LEVEL * abs(low)
