"""A walk along the valley of a misfit, where minima lie in a row.

Parameters that nearly replace each other make a misfit a valley. Where a model leaves something
out, its floor is rough: a search ends in one of many minima that differ by a hundredth, and its
repeats, which all end in the widest, confirm each other there. From such a minimum one parameter
after the other, those first that lead along the flattest directions, is moved through its range
step by step, the others following; where the floor falls again a descent begins. Steps take a few
evaluations each, as the slopes come along corrected.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..optimize.lockstep import AskTell, Counted, lockstep
from ..optimize.moves import Detailed, Moves, SpentError
from ..optimize.trust_region import minimise
from .polish import Polished, polish
from .uncertainty.linearisation import box_of, linearised, others, predicted

if TYPE_CHECKING:
    from ..optimize.box import Box
    from ..optimize.moves import Answer
    from ..optimize.trust_region import Iterate
    from ..space import Array
    from .problem import MotionProblem

#: A step along the valley, as a share of the search range; evaluations of the refit after it; and
#: what share of the sum of squares is worth one.
STEP, ROWS, WORTH = 0.08, 6, 1e-4
#: The floor is followed up to this many times the misfit of the minimum.
HIGHEST = 1.3
#: Evaluations of a descent for each parameter, and the share of J below which a walk brought
#: nothing.
DESCENT, GAIN = 25, 1e-4
#: How often a walk may begin anew, from a better minimum; and one in how many parameters leads.
WALKS, LEADS = 4, 3


def along_valley(problem: MotionProblem, x: Array, cost: float, allowance: int) -> Polished:
    """The best minimum of the valley that a minimum lies in, and the evaluations.

    Args:
        problem: Its J is minimised.
        x: The minimum, SI, (dim,).
        cost: J there.
        allowance: Evaluations of the residuals in all.
    """
    box, counted = box_of(problem), Counted(problem, allowance)
    for _ in range(WALKS):
        if counted.left <= 2 * (box.dim + 1):
            break
        end = _lower(counted, box, x, cost)
        if end is None:
            break
        x, cost = end.x, end.cost
    return Polished(x, cost, counted.rows)


def _lower(counted: Counted, box: Box, x: Array, cost: float) -> Polished | None:
    """A lower minimum that a walk leads to, by the first of the parameters that lead to one."""
    start = linearised(counted, box, x)
    for lead in _leads(start):
        walks = [AskTell("valley", box.space, _floor(start, box, lead, s)) for s in (-1, 1)]
        hollows = [hollow for floor in lockstep(counted, walks) for hollow in _hollows(floor or [])]
        if not hollows or counted.left <= box.dim + 1:
            continue
        lowest = min(hollows, key=lambda place: place.cost)
        end = polish(counted, box.x(lowest.u), None, min(DESCENT * box.dim, counted.left))
        if end.cost < (1 - GAIN) * cost:
            return end
    return None


def _leads(start: Iterate) -> list[int]:
    """The parameters that move most along the flattest directions, each once."""
    _, vectors = np.linalg.eigh(np.einsum("im,jm->ij", start.J, start.J))
    leads: list[int] = []
    for direction in np.abs(vectors.T[: -(-len(start.u) // LEADS)]):
        direction[leads] = 0.0
        leads.append(int(direction.argmax()))
    return leads


def _floor(start: Iterate, box: Box, lead: int, sign: int) -> Moves[list[Iterate]]:
    """Places of the valley's floor to one side of a minimum, which is the first of them."""
    place: Iterate | None = start
    floor = [start.without_slopes()]
    try:
        while place is not None and 0.0 <= place.u[lead] + sign * STEP <= 1.0:
            place = yield from _next(place, box, lead, sign * STEP)
            if place is None or place.cost > HIGHEST * start.cost:
                break
            floor.append(place.without_slopes())
    except SpentError:  # what has been seen counts
        pass
    return floor


def _next(place: Iterate, box: Box, lead: int, move: float) -> Moves[Iterate | None]:
    """The floor a step on; None where it cannot be run."""
    u, _ = predicted(place, box, lead, move)
    answer: Answer = yield Detailed(u[None])
    if answer.residuals is None or not np.isfinite(answer.costs[0]):
        return None
    R = answer.residuals[0]
    there = place.corrected(u - place.u, R).moved(u, R)
    there, _ = yield from minimise(
        there, box, others(box.dim, lead), tolerance=WORTH, rows=ROWS, rest="corrected"
    )
    return there


def _hollows(floor: list[Iterate]) -> list[Iterate]:
    """Where the floor has fallen and does not fall further."""
    costs = [place.cost for place in floor] + [np.inf]
    return [
        floor[k]
        for k in range(1, len(floor))
        if costs[k] < costs[k - 1] and costs[k] <= costs[k + 1]
    ]
