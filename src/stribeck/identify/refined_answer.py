"""The answer of a search refined, or what others lead to where that is better."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..space import Array
from .displaced_inertia import displaced_inertia
from .fit_warnings import NOISY, noise_floor
from .growing_span import growing_span
from .nested_answers import Answers, descended, is_rich, nested_answers
from .polish import polish
from .problem import MotionProblem
from .refinement import Refined, lower_in_valley, turned
from .ripple_orders import ripple_orders
from .search_repeats import Progress, repeated
from .search_settings import POLISH, SearchSettings
from .segment import recordings_of

#: The next best answer is descended from again, on all samples and by the final loss, if it is
#: worse there by no more than this share: before, the order of two answers may be another.
NEAR = 0.02
#: Evaluations a parameter of a descent by the other loss, or back from there.
REFINE = 25


def refined_answer(
    problem: MotionProblem, answer: Refined, settings: SearchSettings, progress: Progress | None,
    allowance: int, answers: Answers | None,
) -> tuple[Refined, bool]:  # fmt: skip
    """The answer of the repeats refined, or what others lead to where that is better.

    And whether Ctrl-C ended that. The others are the answer's rivals and those of contained laws;
    None: the rivals have these among them.

    Where there are both, descents from rivals are others: of two places the lower need not be the
    one that leads further.
    """
    if reached(settings, answer.cost):
        return answer, False
    best, rivals = answer, list(answer.rivals)
    try:
        rich = is_rich(problem)
        if not rich:
            best = _deepened(problem, answer.x, answer.cost)
        spent, groups = best.evaluations, [rivals.copy()]
        if answers is not None:
            solve = partial(_solved, settings=settings, progress=progress)
            nested, rows = nested_answers(problem, solve, answers)
            spent += rows
            groups.insert(0, nested)
            rivals += nested
        if rich:  # the search's own answer is as little refined as the others
            groups[0].append(answer.x)
            rivals.append(answer.x)
        for starts in filter(None, groups):
            end = descended(problem, starts)
            spent += end.evaluations
            rivals.append((best if end.cost < best.cost else end).x)
            if end.cost < best.cost:
                best = _lower_in_valley(problem, end)
                spent += best.evaluations - end.evaluations
        best = replace(best, evaluations=spent)
        # The rest is for what follows: restarts, all samples, a lower knee, wider ranges.
        best = displaced_inertia(problem, best, (allowance - spent) // 2)
        best = ripple_orders(problem, best)
        grown = growing_span(problem, best)
        best = grown if grown.cost == best.cost else _lower_in_valley(problem, grown)
        best = replace(best, rivals=tuple(rivals))
    except KeyboardInterrupt:
        return replace(best, rivals=answer.rivals), True
    return best, False


def reached(settings: SearchSettings, cost: float) -> bool:
    """Whether J is at the target, so that nothing better is asked for."""
    return settings.target is not None and cost <= settings.target


def no_worse(
    problem: MotionProblem, best: Refined, rivals: Sequence[Array], allowance: int
) -> Refined:
    """An answer, or what the best of its rivals leads to where that is better on all samples."""
    if not rivals:
        return best
    costs, spent = problem(np.array(rivals)), best.evaluations + len(rivals)
    k = int(np.nanargmin(costs)) if np.isfinite(costs).any() else 0
    if costs[k] < (1 + NEAR) * best.cost:
        end = polish(problem, rivals[k], None, min(allowance - spent, POLISH))
        spent += end.evaluations
        if end.cost < best.cost:
            best = Refined(end.x, end.cost, spent)
    return replace(best, evaluations=spent)


def _solved(problem: MotionProblem, settings: SearchSettings, progress: Progress | None) -> Refined:
    """The answer of a law that contains no other.

    Raises:
        KeyboardInterrupt: Ctrl-C ended the search.
    """
    runs, interrupted = repeated(problem, settings, progress, smooth=True)
    if interrupted:
        raise KeyboardInterrupt
    run = min(runs, key=lambda r: r.cost)
    spent = sum(r.evaluations for r in runs)
    return _deepened(problem, run.x, run.cost, spent)


def _deepened(problem: MotionProblem, x: Array, cost: float, spent: int = 0) -> Refined:
    """The minimum below a place, or a better one by way of the other loss or along its valley."""
    allowance = REFINE * problem.space.dim
    first = polish(problem, x, cost, allowance)
    best = turned(problem, first.x, first.cost, allowance, spent + first.evaluations)
    return _lower_in_valley(problem, best)


def _lower_in_valley(problem: MotionProblem, best: Refined) -> Refined:
    """A minimum, or a better one of its valley where its misfit is beyond the noise."""
    rough = is_beyond_noise(problem, best.cost)
    return lower_in_valley(problem, best) if rough else best


def is_beyond_noise(problem: MotionProblem, cost: float) -> bool:
    """Whether a misfit is more than the noise of the logs, so that minima may lie in a row."""
    return cost > NOISY * noise_floor(problem.parameters.rig, recordings_of(problem.train))
