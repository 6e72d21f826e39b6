"""The last steps of a search: the other loss and back, and a restart around the best answer.

Where a misfit is rough, a descent ends in the first hollow. The minimum of another loss over the
same residuals lies beside the one that is sought, but its hollows lie elsewhere: a descent to there
and back leaves most of them. In many dimensions an evolution strategy, which knows no slopes,
starts around the answer, and descents follow it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.random import SeedSequence

from ..optimize.cma_es import cma_es
from ..optimize.lockstep import AskTell, Counted, ShowsResiduals, lockstep
from ..optimize.moves import silent
from ..space import Array
from .free_constants import FreeConstantsProblem
from .initial_state import FreeStartProblem
from .polish import Polished, polish
from .problem import MotionProblem
from .valley import along_valley

#: Turns through the other loss, and the share of J below which a turn brought nothing.
TURNS, GAIN = 3, 0.01
#: Evaluations a parameter that a walk along a valley may take.
VALLEY = 100
#: From so many parameters on there are rounds of an evolution strategy around the answer: its first
#: standard deviation over the unit cube in turn, evaluations a parameter, how many rounds at most,
#: the share of J that a round brings if it is of use, and how many in a row may be of none.
MANY, RADII, ROUND, ROUNDS, WORTH, IDLE = 10, (0.05, 0.1), 150, 6, 1e-3, 1


@dataclass(frozen=True, eq=False)
class Refined:
    """Where a refinement ended.

    Args:
        x: Free parameters, SI.
        cost: J there.
        evaluations: Of the residuals, each row counted.
        other: The minimum of the other loss that was met first, SI; None where none was.
        modes: Other minima that may explain the data as well, SI.
        rivals: Other answers: of the laws that the problem's law contains, and what was passed over
            for this one, SI.
    """

    x: Array
    cost: float
    evaluations: int
    other: Array | None = None
    modes: tuple[Array, ...] = ()
    rivals: tuple[Array, ...] = ()


def refined_in_turn(problem: MotionProblem, x: Array, cost: float, allowance: int) -> Refined:
    """Descend by the loss, then by the other one and back, as long as that brings something.

    Args:
        problem: Its J is minimised.
        x: Where to start, SI, (dim,).
        cost: J there.
        allowance: Evaluations of the residuals.
    """
    first = polish(problem, x, cost, allowance)
    return turned(problem, first.x, first.cost, allowance, first.evaluations)


def turned(
    problem: MotionProblem, x: Array, cost: float, allowance: int, spent: int = 0
) -> Refined:
    """From a minimum by the other loss and back, as long as that brings something.

    Args:
        problem: Its J is minimised.
        x: The minimum, SI, (dim,).
        cost: J there.
        allowance: Evaluations of one descent.
        spent: Evaluations so far.
    """
    other_problem = problem.by_other_loss()
    other: Array | None = None
    for _ in range(TURNS):
        there = polish(other_problem, x, None, allowance)
        other = there.x if other is None else other
        back = polish(problem, there.x, None, allowance)
        spent += there.evaluations + back.evaluations
        gain = 1 - back.cost / cost
        if gain > 0:
            x, cost = back.x, back.cost
        if not gain > GAIN:
            break
    return Refined(x, cost, spent, other)


def lower_in_valley(problem: MotionProblem, best: Refined, allowance: float = np.inf) -> Refined:
    """A minimum, or a better one of its valley, with so many more evaluations at most."""
    rows = int(min(VALLEY * problem.space.dim, allowance))
    end = along_valley(problem, best.x, best.cost, rows)
    spent = best.evaluations + end.evaluations
    return replace(best, x=end.x, cost=end.cost, evaluations=spent)


def explored(
    problem: MotionProblem, best: Refined, seed: int, allowance: int, *, valley: bool
) -> tuple[MotionProblem, Refined]:
    """In many dimensions what walks along its valley and an evolution strategy lead to, in turn.

    On all samples a misfit has hollows that it has not on fewer, so that a valley is walked again.

    Args:
        problem: Its J is minimised.
        best: The answer.
        seed: Of the draws.
        allowance: Evaluations in all.
        valley: Whether to walk; where noise is all that is left of a misfit, its floor is smooth.

    Returns:
        The problem, default ranges as wide as a valley is followed, and the answer.
    """
    limit = best.evaluations + allowance
    for _ in range(TURNS):
        before = best.cost
        if valley:
            problem, best = _beyond_ranges(problem, best, limit)
        walked = best.cost
        best = restarted(problem, best, seed, limit - best.evaluations)
        at_an_end = best.cost < walked and problem.widened(best.x) is not None
        if not (valley and (at_an_end or best.cost < (1 - GAIN) * before)):
            break
    return problem, best


def _beyond_ranges(
    problem: MotionProblem, best: Refined, limit: int
) -> tuple[MotionProblem, Refined]:
    """A minimum, or a better one of its valley, followed as long as it leads beyond a range."""
    lower = True
    while lower:
        problem, before = problem.widened(best.x) or problem, best.cost
        best = lower_in_valley(problem, best, limit - best.evaluations)
        lower = best.cost < before and problem.widened(best.x) is not None
    return problem, best


def restarted(problem: MotionProblem, best: Refined, seed: int, allowance: int) -> Refined:
    """Rounds of an evolution strategy around an answer, each with descents after it.

    Args:
        problem: Its J is minimised.
        best: The answer.
        seed: Of the draws.
        allowance: Evaluations in all.
    """
    dim, spent = problem.space.dim, best.evaluations
    limit, idle = spent + allowance, 0
    for k, child in enumerate(SeedSequence(seed, spawn_key=(dim,)).spawn(ROUNDS)):
        rows = min(ROUND * dim, limit - spent)
        if rows < 2 * dim or idle == IDLE:
            break
        around = _around(problem, best.x, RADII[k % len(RADII)], child, rows)
        spent += around.evaluations
        before = best.cost
        if around.cost < before:
            best = refined_in_turn(
                problem, around.x, around.cost, max(min(40 * dim, limit - spent), 1)
            )
            spent += best.evaluations
        idle = 0 if best.cost < (1 - WORTH) * before else idle + 1
    return replace(best, evaluations=spent)


def settled(
    problem: MotionProblem | FreeStartProblem | FreeConstantsProblem, x: Array, seed: int
) -> tuple[Array, int]:
    """A good fit, SI, (dim,), refitted where its problem has got further unknowns; and the rows.

    Args:
        problem: With all its unknowns.
        x: The fit before.
        seed: Of the draws.
    """
    dim = problem.space.dim
    child = SeedSequence(seed, spawn_key=(dim, 1))
    around = _around(problem.thinned(), x, RADII[0], child, ROUND * dim)
    refit = polish(problem, around.x, None, 40 * dim)
    return refit.x, around.evaluations + refit.evaluations


def _around(
    problem: ShowsResiduals, x: Array, radius: float, seed: SeedSequence, rows: int
) -> Polished:
    """The best point that an evolution strategy around a point meets, or the point itself."""
    counted = Counted(problem, rows)
    (centre,) = problem.space.encode(x[None])
    start = float(counted(x[None])[0])
    population = 2 * (4 + int(3 * np.log(len(x))))  # twice the usual one: the misfit is rough
    moves = cma_es(centre, radius, population, np.random.default_rng(seed), silent)
    lockstep(counted, [AskTell("restart", problem.space, moves)])
    best, cost = counted.best()
    return Polished(best, cost, counted.rows) if cost < start else Polished(x, start, counted.rows)
