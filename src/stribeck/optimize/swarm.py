"""A neighbourhood whose radius and shape adapt: where costs are rugged, slopes say nothing.

An evolution strategy that learns the matrix which turns a round cloud of neighbours into one that
fits the landscape (Beyer and Sendhoff 2017, doi 10.1109/TEVC.2017.2680320, which simplifies the
covariance matrix adaptation of Hansen and Ostermeier; rates as in Hansen 2016, arXiv 1604.00772).
It uses the order of the costs alone.
"""

from __future__ import annotations

import numpy as np

from ..space import Array, Rng
from .search import Moves, Note

#: It ends when the cloud is this narrow, or its best costs have differed by no larger share for a
#: while.
NARROW, LEVEL = 1e-9, 1e-13
#: How often that is looked at, rounds.
EVERY = 5


def adapt(centre: Array, R: float, N: int, rng: Rng, note: Note) -> Moves[None]:
    """Search around a point of the unit cube until the neighbourhood has shrunk to nothing.

    Args:
        centre: Where, (dim,).
        R: First radius: the standard deviation of the neighbours' distance in a coordinate.
        N: Neighbours a round, from 4.
        rng: Source of the neighbours.
        note: Told of every batch.
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
    least: list[float] = []
    while True:
        note(asks="neighbours", radius=R)
        z = rng.standard_normal((N, dim))
        way = z @ M.T
        wished = centre + R * way
        near = np.minimum(np.maximum(wished, 0.0), 1.0)
        costs = yield near
        least.append(float(costs.min()))
        ranked = np.argsort(_with_penalty(costs, wished - near, R), kind="stable")[:half]
        z, way = z[ranked], way[ranked]
        centre = np.minimum(np.maximum(centre + R * (w @ way), 0.0), 1.0)
        s = (1.0 - c_s) * s + np.sqrt(mass * c_s * (2.0 - c_s)) * (w @ z)
        M = (
            (1.0 - 0.5 * (c_1 + c_w)) * M
            + 0.5 * c_1 * np.outer(M @ s, s)
            + 0.5 * c_w * ((w[:, None] * way).T @ z)
        )
        R *= float(np.exp(min(1.0, c_s / damp * (np.sqrt(s @ s) / expected - 1.0))))
        if len(least) % EVERY == 0 and _over(
            least, R * np.sqrt((M**2).sum(axis=1).max()), patience
        ):
            return


def _with_penalty(costs: Array, outside: Array, R: float) -> Array:
    """Costs for the ranking: who wished to be outside pays for the way back."""
    if not outside.any():
        return costs
    runs = costs[np.isfinite(costs)]
    spread = float(np.ptp(runs)) if len(runs) else 1.0
    paid: Array = costs + (spread + 1e-300) * (outside**2).sum(axis=1) / R**2
    return paid


def _over(least: list[float], width: float, patience: int) -> bool:
    """Whether the cloud is narrow, its best costs level, or nothing better was met for long."""
    if not NARROW < width < np.inf:
        return True
    lately = least[-patience:]
    if len(least) > patience and max(lately) - min(lately) <= LEVEL * abs(min(lately)):
        return True
    long = 6 * patience
    return len(least) > 2 * long and min(least[-long:]) >= min(least[:-long])
