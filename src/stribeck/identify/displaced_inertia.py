"""Descents from displaced inertias, for laws with states.

A mass swings on its bristles. Its inertia sets the phase of every swing, so that J has a minimum
wherever the swings of the model fall on those of the log again: along the inertia alone, and close
to each other. A search in all parameters ends in one of them; here the others are visited.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .polish import polish
from .refinement import Refined

if TYPE_CHECKING:
    from ..space import Array
    from .problem import MotionProblem

#: Parameters that stand for inertia, on any rig.
INERTIA = frozenset({"M", "J", "armature"})
#: Factors from one inertia to the next: over the whole range, and then as far as one of these about
#: the best; evaluations of each descent, a parameter.
WIDE, CLOSE, ROWS = 2.5, 1.12, 12


def displaced_inertia(problem: MotionProblem, best: Refined, allowance: int) -> Refined:
    """The best of the descents from displaced inertias, and of where they begin.

    Args:
        problem: Its J is minimised.
        best: The answer so far.
        allowance: Evaluations of the residuals in all.
    """
    axes = [k for k, name in enumerate(problem.space.names) if name in INERTIA]
    if not problem.parameters.law.states or not axes:
        return best
    limit = best.evaluations + allowance
    for axis in axes:
        param = problem.space.params[axis]
        low, high = max(param.lower, 1e-9 * param.upper), param.upper
        count = int(np.log(high / low) / np.log(WIDE))
        best = _descended(problem, best, axis, np.geomspace(low, high, count), limit)
        reach = np.arange(1.0, np.log(WIDE) / np.log(CLOSE))
        near = best.x[axis] * CLOSE ** np.concatenate([-reach[::-1], reach])
        best = _descended(problem, best, axis, near[(near > low) & (near < high)], limit)
    return best


def _descended(
    problem: MotionProblem, best: Refined, axis: int, inertias: Array, limit: int
) -> Refined:
    """The best of descents from an answer with other values of one parameter, and of itself."""
    spent, x, cost = best.evaluations, best.x, best.cost
    starts = np.repeat(best.x[None], len(inertias), axis=0)
    starts[:, axis] = inertias
    for start in starts:
        rows = min(ROWS * (problem.space.dim + 1), limit - spent - 1)
        if rows <= problem.space.dim + 1:
            break
        end = polish(problem, start, float(problem(start[None])[0]), rows)
        spent += 1 + end.evaluations
        if end.cost < cost:
            x, cost = end.x, end.cost
    return Refined(x, cost, spent, best.other)
