"""The last step of a fit: bounded least squares on the residuals, from where a search ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from ..space import Array

if TYPE_CHECKING:
    from ..optimize import Run, Trace
    from .problem import MotionProblem

#: Step of the finite differences, as a share of a parameter's range: its effect on the motion
#: is far above the integration error and far below the noise.
STEP = 1e-4
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
    done = [
        polish(problem, x, float(J), allowance // len(u))
        for x, J in zip(problem.space.decode(u), costs, strict=True)
    ]
    best = min(done, key=lambda d: d.cost)
    return Polished(best.x, best.cost, sum(d.evaluations for d in done))


def polish(problem: MotionProblem, x: Array, start: float, allowance: int) -> Polished:
    """Improve a point by trust-region least squares inside the search box.

    Args:
        problem: Its residuals are minimised.
        x: Where to start, free parameters, SI.
        start: J there.
        allowance: Rows of the cost that may be evaluated; with none the point stays.
    """
    space, dim = problem.space, problem.space.dim
    rounds = (allowance - 1) // (dim + 1)  # one is for the cost of the answer
    if rounds < 1 or not np.isfinite(start):
        return Polished(x, start, 0)
    spent = 0
    last = np.empty(0), np.empty(0)  # where the residuals were asked for last, and what they were

    def residuals(u: Array) -> Array:
        nonlocal spent, last
        spent += 1
        last = u.copy(), problem.residuals(space.decode(u[None]))[0]
        return last[1]

    def slopes(u: Array) -> Array:
        nonlocal spent
        known = last[1] if np.array_equal(u, last[0]) else residuals(u)
        spent += dim
        return jacobian(problem, u, known)

    u = np.clip(space.encode(x[None])[0], 1e-6, 1 - 1e-6)
    try:
        found = least_squares(
            residuals,
            u,
            slopes,
            bounds=(0.0, 1.0),
            method="trf",
            max_nfev=rounds,
            xtol=1e-7,
            ftol=1e-9,
        )
    except ValueError:  # a neighbour that cannot be simulated: the search's answer stands
        return Polished(x, start, spent)
    better = space.decode(np.clip(found.x, 0.0, 1.0)[None])
    cost = float(problem(better)[0])
    spent += 1
    if not cost < start:
        return Polished(x, start, spent)
    return Polished(better[0], cost, spent)


def jacobian(problem: MotionProblem, u: Array, residuals: Array) -> Array:
    """Slopes of the residuals at a point of the unit cube, (samples, dim), in one call."""
    step = np.where(u + STEP <= 1.0, STEP, -STEP)
    beside = problem.residuals(problem.space.decode(u + np.diag(step)))
    slopes: Array = ((beside - residuals) / step[:, None]).T
    return slopes
