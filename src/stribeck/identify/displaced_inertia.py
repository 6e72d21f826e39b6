"""Descents from displaced inertias, for laws with states.

A mass swings on its bristles. Its inertia sets the phase of every swing, so that J has a minimum
wherever the swings of the model fall on those of the log again: along the inertia alone, and close
to each other. A search in all parameters ends in one of them; here the others are visited. Those
that explain the data about as well belong to what is known of the parameters: profiles start there,
too.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from typing import TYPE_CHECKING

import numpy as np

from .polish import Polished, polish
from .refinement import Refined

if TYPE_CHECKING:
    from ..space import Array
    from .problem import MotionProblem

#: Parameters that stand for inertia, on any rig.
INERTIA = frozenset({"M", "J", "armature"})
#: Factors from one inertia to the next, away from the best: over the whole range, then as far as
#: one of these, and then the same again; evaluations of each descent, a parameter.
FACTORS, ROWS = (2.5, 1.12, 1.03), 12
#: A minimum is another one whose inertia differs by this share; it may explain the data as well if
#: its misfit is greater by no more than this one; and so many are kept.
APART, NEAR, MODES = 0.01, 0.005, 8

_COST = attrgetter("cost")


def displaced_inertia(problem: MotionProblem, best: Refined, allowance: int) -> Refined:
    """The best of the descents from displaced inertias, and of where they begin.

    Its `modes` are the others of about the same misfit.

    Args:
        problem: Its J is minimised.
        best: The answer so far.
        allowance: Evaluations of the residuals in all.
    """
    axes = [k for k, name in enumerate(problem.space.names) if name in INERTIA]
    if not problem.parameters.law.states or not axes:
        return best
    for axis in axes:
        param = problem.space.params[axis]
        low, high = max(param.lower, 1e-9 * param.upper), param.upper
        first = Polished(best.x, best.cost, 0)
        ends, reach = [first], high / low
        for factor in FACTORS:
            steps = np.arange(1.0, np.log(reach) / np.log(factor))
            inertias = first.x[axis] * factor ** np.concatenate([-steps[::-1], steps])
            inside = inertias[(inertias > low) & (inertias < high)]
            ends += _descended(problem, first.x, axis, inside, allowance - _spent(ends))
            first, reach = min(ends, key=_COST), factor
        spent, allowance = _spent(ends), allowance - _spent(ends)
        modes = (*best.modes, *_modes(ends, axis))
        best = Refined(first.x, first.cost, best.evaluations + spent, best.other, modes)
    return best


def _spent(ends: Sequence[Polished]) -> int:
    return sum(end.evaluations for end in ends)


def _descended(
    problem: MotionProblem, x: Array, axis: int, inertias: Array, allowance: int
) -> list[Polished]:
    """Where descents from an answer with other values of one parameter end.

    Args:
        problem: Its J is minimised.
        x: The answer, SI, (dim,).
        axis: Which parameter.
        inertias: Its values, SI.
        allowance: Evaluations of all descents.
    """
    ends: list[Polished] = []
    for inertia in inertias:
        rows = min(ROWS * (problem.space.dim + 1), allowance - _spent(ends))
        if rows <= problem.space.dim + 1:
            break
        start = x.copy()
        start[axis] = inertia
        ends.append(polish(problem, start, None, rows))
    return ends


def _modes(ends: Sequence[Polished], axis: int) -> list[Array]:
    """Minima beside the best that cost about as much, the best first, each inertia once."""
    order = sorted(ends, key=_COST)
    chosen = order[:1]
    for end in order[1:]:
        new = all(abs(end.x[axis] - c.x[axis]) > APART * c.x[axis] for c in chosen)
        if new and end.cost <= (1 + NEAR) * order[0].cost and len(chosen) <= MODES:
            chosen.append(end)
    return [end.x for end in chosen[1:]]
