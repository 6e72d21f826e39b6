"""The parameters by another loss: where a model leaves something out, losses weigh it differently.

If residuals are noise, squares and absolute errors lead to the same parameters within their
intervals. Where the model leaves something out they need not, and an interval that one refit by the
other loss leaves says nothing of what the model lacks.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import TYPE_CHECKING

import numpy as np

from ..rig.rig import shown_in
from ..space import Array, Param
from .conditions import Violation
from .initial_state import FreeStartProblem, started_at_each
from .polish import polish
from .problem import MotionProblem

if TYPE_CHECKING:
    from .parameters import Parameters
    from .uncertainty.estimates import Estimate

#: Evaluations of the refit for each parameter.
ROWS = 15


def other_loss_violations(
    problem: MotionProblem | FreeStartProblem, x: Array, judged: Sequence[Estimate]
) -> tuple[list[Violation], int]:
    """The intervals that a refit by the other loss leaves; and the rows evaluated.

    Args:
        problem: The problem solved, its constants as they were estimated.
        x: The fit, SI, (dim,); starts stay where they are.
        judged: Its estimates, as in `parameters.every`.
    """
    parameters, dim = problem.parameters, len(problem.parameters.free)
    if isinstance(problem, FreeStartProblem):
        motion = copy(problem.problem)
        motion.train = started_at_each(motion.train, x[dim:])
    else:
        motion = problem
    other = motion.by_other_loss()
    if parameters.objective.loss == "squares":
        other = other.finer()  # as a fit by absolute errors ends
    start = float(other(x[None, :dim])[0])
    refit = polish(other, x[:dim], start, ROWS * dim)
    values = parameters.full(refit.x[None])[0]
    left = {
        q.name: _told(parameters, q, e, v)
        for q, e, v in zip(parameters.every, judged, values.tolist(), strict=True)
        if e.verdict != "fixed" and not _within(e, v)
    }
    if not left:
        return [], 1 + refit.evaluations
    loss = "squares" if parameters.objective.loss == "absolute" else "absolute"
    sentence = (
        f"--loss {loss} puts {', '.join(left.values())} outside the interval: the model leaves "
        "out something that the two losses weigh differently; trust neither value, or use a law "
        "that has it"
    )
    return [Violation("model", sentence, frozenset(left))], 1 + refit.evaluations


def _told(parameters: Parameters, q: Param, e: Estimate, value: float) -> str:
    unit = parameters.rig.unit_of(q)
    at, low, high = (f"{float(shown_in(parameters.rig, q, v)):.4g}" for v in (value, e.low, e.high))
    return f"{e.name} at {at} {unit}".rstrip() + f" ({low} to {high})"


def _within(e: Estimate, value: float) -> bool:
    slack = 1e-9 * max(abs(e.low), abs(e.high), abs(e.value), np.finfo(float).tiny)
    return e.low - slack <= value <= e.high + slack
