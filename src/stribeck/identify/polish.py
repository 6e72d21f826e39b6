"""The last step of a fit: bounded least squares on the residuals, from where a search ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..optimize import rms
from ..optimize.box import Box
from ..optimize.descents import Descents
from ..optimize.lockstep import AskTell, Counted, lockstep
from ..optimize.moves import silent
from ..optimize.trust_region import least_squares
from ..space import Array

if TYPE_CHECKING:
    from ..optimize import Run, Trace
    from ..optimize.lockstep import ShowsResiduals
    from .problem import MotionProblem

#: Places of a search that are polished at most, and rounds each must be able to afford.
MOST_STARTS, FEWEST_ROUNDS = 8, 5


@dataclass(frozen=True, eq=False)
class Polished:
    """Where least squares ended.

    Args:
        x: Free parameters, SI.
        cost: J there.
        evaluations: Of the residuals, each row counted.
    """

    x: Array
    cost: float
    evaluations: int


def elite(trace: Trace, most: int, apart: float = 0.3) -> tuple[Array, Array]:
    """The best points of a search that lie apart from each other in the unit cube, best first.

    A stick-slip misfit has many basins; the best point of a search may sit in a poor one.
    Returns the points, (k, dim), and their costs, (k,).
    """
    order = np.argsort(trace.f, kind="stable")
    order = order[np.isfinite(trace.f[order])]
    chosen: list[int] = []
    while len(order) and len(chosen) < most:
        chosen.append(int(order[0]))
        order = order[np.linalg.norm(trace.u[order] - trace.u[order[0]], axis=1) > apart]
    return trace.u[chosen].copy(), trace.f[chosen].copy()


def polish_run(problem: MotionProblem, run: Run, allowance: int) -> Polished:
    """Polish the elite of a search, the allowance dealt out evenly, and return the best."""
    if allowance < 1 or not np.isfinite(run.cost):
        return Polished(run.x, run.cost, 0)
    most = allowance // (FEWEST_ROUNDS * (problem.space.dim + 1))
    u, costs = elite(run.trace, min(max(most, 1), MOST_STARTS))
    polished = [
        polish(problem, x, float(J), allowance // len(u))
        for x, J in zip(problem.space.decode(u), costs, strict=True)
    ]
    best = min(polished, key=lambda d: d.cost)
    return Polished(best.x, best.cost, sum(d.evaluations for d in polished))


def polish(problem: ShowsResiduals, x: Array, start: float | None, allowance: int) -> Polished:
    """Improve a point by trust-region least squares inside the search box.

    Args:
        problem: Its residuals are minimised.
        x: Where to start, free parameters, SI.
        start: J there; None where it is not known, as of a point of another problem.
        allowance: Rows of the cost that may be evaluated; with none the point stays.
    """
    space = problem.space
    if start is None and allowance <= space.dim + 1:
        return Polished(x, float(rms(problem.residuals(x[None]))[0]), 1)
    if start is not None and (allowance <= space.dim + 1 or not np.isfinite(start)):
        return Polished(x, start, 0)
    counted = Counted(problem, allowance)
    descent = least_squares(space.encode(x[None])[0], Box(space))
    lockstep(counted, [AskTell("polishing", space, descent)])
    best, cost = counted.best()
    if start is not None and not cost < start:
        return Polished(x, start, counted.rows)
    return Polished(best, cost, counted.rows)


def best_descent(
    problem: ShowsResiduals, points: Array, rounds: tuple[tuple[int, int], ...]
) -> Polished:
    """Where descents from several points end: all begin, and the best go on.

    Args:
        problem: Its residuals are minimised.
        points: Where they start, free parameters, SI, (n, dim).
        rounds: See `Descents`.
    """
    space = problem.space
    descents = Descents(lambda _: space.encode(points), rounds)
    counted = Counted(problem, sum(n * rows for n, rows in rounds) * space.dim + len(points))
    rng = np.random.default_rng(0)  # nothing is drawn
    lockstep(counted, [AskTell("descents", space, descents.moves(space, rng, silent))])
    return Polished(*counted.best(), counted.rows)
