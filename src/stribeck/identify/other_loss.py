"""The parameters by another loss: where a model leaves something out, losses weigh it differently.

If residuals are noise, squares and absolute errors lead to the same parameters within their
intervals. Where the model leaves something out they need not, and an interval that one refit by the
other loss leaves says nothing of what the model lacks.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..rig.rig import shown_in
from ..space import Array, Param, Space
from ..wording import option
from .conditions import Violation
from .free_constants import FreeConstantsProblem
from .initial_state import FreeStartProblem
from .polish import best_descent, elite, polish
from .problem import MotionProblem

if TYPE_CHECKING:
    from ..optimize import Run
    from .parameters import Parameters
    from .uncertainty.estimates import Estimate

#: Evaluations of a refit for each parameter, from how many places there is one, and how many
#: places of each search are considered.
ROWS, STARTS, PLACES = 15, 4, 8
#: How many of them take part in each round, and its evaluations for each parameter.
ROUNDS = ((STARTS, 4), (2, 4), (1, ROWS - 8))


def other_loss_violations(
    problem: MotionProblem | FreeStartProblem | FreeConstantsProblem,
    x: Array,
    judged: Sequence[Estimate],
    runs: Sequence[Run] = (),
) -> tuple[list[Violation], int]:
    """The intervals that a refit by the other loss leaves; and the rows evaluated.

    Args:
        problem: The problem solved, its uncertain constants among the unknowns.
        x: The fit, SI, (dim,); starts of motions stay where they are.
        judged: Its estimates, as in `parameters.every`.
        runs: The searches: what is a second best minimum of one loss may be the best of the other,
            so that refits start from good places of these, too.
    """
    parameters = problem.parameters
    dim = len(parameters.free)
    other, start = _by_other_loss(problem, x)
    visited = [_places(problem, run) for run in runs]
    points = np.array([start, *(np.concatenate([x, start[dim:]]) for xs in visited for x in xs)])
    fewer, rows = other.thinned(), ROWS * len(start)
    costs = fewer(points)
    order = np.argsort(costs, kind="stable")[:STARTS]
    refit = best_descent(fewer, points[order], ROUNDS)
    spent = len(points) + refit.evaluations
    if fewer is not other:
        refit = polish(other, refit.x, None, rows)
        spent += refit.evaluations
    spent += isinstance(problem, FreeConstantsProblem)  # the noise that its priors are weighed by
    values = parameters.full(refit.x[None, :dim])[0]
    left = {
        q.name: _told(parameters, q, e, v)
        for q, e, v in zip(parameters.every, judged, values.tolist(), strict=True)
        if e.verdict != "fixed" and not _within(e, v)
    }
    if not left:
        return [], spent
    loss = "squares" if parameters.objective.loss == "absolute" else "absolute"
    sentence = (
        f"{option('loss', loss)} puts {', '.join(left.values())} outside the interval: the model "
        "leaves out something that the two losses weigh differently; trust neither value, or use "
        "a law that has it"
    )
    return [Violation("model", sentence, frozenset(left))], spent


def _places(problem: MotionProblem | FreeStartProblem | FreeConstantsProblem, run: Run) -> Array:
    """Good places of a search that lie apart from each other, SI, (n, free)."""
    u, _ = elite(run.trace, PLACES)
    places: Array = Space(problem.parameters.free).decode(u)
    return places


def _by_other_loss(
    problem: MotionProblem | FreeStartProblem | FreeConstantsProblem, x: Array
) -> tuple[MotionProblem | FreeConstantsProblem, Array]:
    """The problem by the other loss, and the fit in it: parameters, and constants if any."""
    free = problem.problem if isinstance(problem, FreeConstantsProblem) else problem
    dim, k = len(problem.parameters.free), len(free.space.params)
    motion = free.at(x[:k])[0] if isinstance(free, FreeStartProblem) else free
    other = motion.by_other_loss()
    if problem.parameters.objective.loss == "squares":
        other = other.finer()  # as a fit by absolute errors ends
    if not isinstance(problem, FreeConstantsProblem):
        return other, x[:dim]
    at, _ = FreeConstantsProblem(other, problem.constants, problem.noise).at(
        np.concatenate([x[:dim], x[k:]])
    )
    noise = float(at(x[None, :dim])[0])
    whole = FreeConstantsProblem(other, problem.constants, noise)
    return whole, np.concatenate([x[:dim], x[k:]])


def _told(parameters: Parameters, q: Param, e: Estimate, value: float) -> str:
    unit = parameters.rig.unit_of(q)
    at, low, high = (f"{float(shown_in(parameters.rig, q, v)):.4g}" for v in (value, e.low, e.high))
    return f"{e.name} at {at} {unit}".rstrip() + f" ({low} to {high})"


def _within(e: Estimate, value: float) -> bool:
    slack = 1e-9 * max(abs(e.low), abs(e.high), abs(e.value), np.finfo(float).tiny)
    return e.low - slack <= value <= e.high + slack
