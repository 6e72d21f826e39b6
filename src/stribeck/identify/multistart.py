"""Repeats of a search and what contained laws lead to, refined; the best of all is the answer."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ..optimize import Run, Search
from ..rig.simulated import as_simulated
from ..space import Array
from .fit_warnings import RIVAL
from .free_constants import FreeConstantsProblem
from .horizons import NearPlaces, evaluations_of, has_horizons, horizon_ends
from .initial_state import FreeStartProblem, free_starts
from .nested_answers import Answers, is_rich, richest, rigid_limit
from .parameters import WIDENINGS, Parameters
from .polish import Polished, polish
from .problem import MotionProblem
from .refined_answer import is_beyond_noise, no_worse, reached, refined_answer
from .refinement import MANY, Refined, explored
from .result import SearchRecord
from .search_repeats import Progress, polished_runs, repeated
from .search_settings import (
    POLISH,
    SearchSettings,
    sticks_and_slips,
)
from .selection.nesting import carried, placed

#: Evaluations for each parameter and repeat below which a search is not worth its while.
FEWEST = 100
#: The share of J whose gain in wider default ranges calls for a new search, and how many searches
#: there may be in all.
MATERIAL, SEARCHES = 0.01, 3


@dataclass(frozen=True, eq=False)
class Optimum:
    """Where a multistart ended.

    Args:
        problem: The problem that `x` minimises: with free starts and constants where these matter.
        x: Its free parameters, SI, and the starts and the constants after them.
        search: How it was searched for.
        spread: Standard deviation of the parameters over the repeats that explain the data
            equally well, SI, (dim,); nan where there is one.
        rivals: How many repeats those are.
        repeats: How many there were.
        interrupted: Whether Ctrl-C ended the search or the polishing.
        modes: Other minima that may explain the data as well: free parameters, SI.
    """

    problem: MotionProblem | FreeStartProblem | FreeConstantsProblem
    x: Array
    search: SearchRecord
    spread: Array
    rivals: int
    repeats: int
    interrupted: bool
    modes: tuple[Array, ...] = ()


def with_free_starts(problem: MotionProblem) -> MotionProblem | FreeStartProblem:
    """The problem with the start of each motion among its unknowns, if its rig needs that."""
    return FreeStartProblem(problem) if free_starts(problem) else problem


def multistart(
    problem: MotionProblem,
    settings: SearchSettings,
    progress: Progress | None = None,
    *,
    searches: int = SEARCHES,
    answers: Answers | None = None,
) -> Optimum:
    """Search, polish each repeat, and refine the best: in its own loss, and with free starts.

    An answer at an end of a default range goes on beyond it; where that brings more than a little,
    the search is done anew in the wider ranges. (A law of many parameters that contains others is
    explored from there instead.)

    Args:
        problem: Its J is minimised.
        settings: How.
        progress: Called with the searches after every step.
        searches: How often it may be done.
        answers: Of contained laws on fewer samples, as far as they were met; more are added.

    Raises:
        InputError: no parameter set could be simulated.
    """
    start_time, answers = time.perf_counter(), {} if answers is None else answers
    smooth = not sticks_and_slips(problem)
    refines = smooth and settings.memetic
    searched = problem.thinned() if refines else problem
    simple = richest(problem.parameters) if refines else None
    own = _own(searched, settings, progress, smooth=smooth, rich=simple is not None)
    problem, searched = _over(problem, searched, own.parameters)
    runs, polished, evaluations, interrupted = own.runs, own.polished, own.rows, own.interrupted
    below, least = 0, list[Array]()  # evaluations that are not of this law's budget
    if simple is not None and not (interrupted or reached(settings, polished[0].cost)):
        solve = partial(multistart, settings=settings, progress=progress, answers=answers)
        reaching, least, below, interrupted = _contained_answer(problem, simple, solve)
        problem, searched = _over(problem, searched, reaching)
    answer = Refined(polished[0].x, polished[0].cost, 0, rivals=tuple(least))
    if refines and not interrupted:
        allowance = settings.budget * settings.repeats - evaluations
        simpler = None if own.near else answers
        answer, interrupted = refined_answer(
            searched, answer, settings, progress, allowance, simpler
        )
    evaluations += answer.evaluations
    seconds = time.perf_counter() - start_time
    unspent = settings.budget * settings.repeats - evaluations
    allowance = 0 if interrupted or settings.polishing is False else unspent
    if problem.parameters.objective.loss == "absolute" and not interrupted:
        problem = problem.finer()
    refit = (problem is not searched and allowance > 1) or bool(least)
    around, stopped = _on_all_samples(problem, answer, allowance, refit=refit)
    best, cost, refined = around.x, around.cost, around.evaluations
    if stopped:
        interrupted, allowance = True, 0
    whole: MotionProblem | FreeStartProblem = problem
    try:
        if allowance > refined:
            start = Polished(best, cost, 0)
            problem, wider = _widened(problem, start, min(allowance - refined, POLISH))
            whole, best, refined = problem, wider.x, refined + wider.evaluations
            left = replace(settings, budget=max((allowance - refined) // settings.repeats, 1))
            if (
                searches > 1
                and left.budget >= FEWEST * problem.space.dim
                and wider.cost < (1 - MATERIAL) * cost
                and not (refines and is_rich(problem))
            ):
                again = multistart(problem, left, progress, searches=searches - 1)
                return _after(again, below + evaluations + refined, seconds)
            cost = wider.cost
        if refines and allowance > refined:
            start = Polished(best, cost, 0)
            problem, end = _restarted(problem, start, settings, allowance - refined)
            whole, best, refined = problem, end.x, refined + end.evaluations
        whole, best, rows = _started(problem, best, allowance - refined)
        refined += rows
    except KeyboardInterrupt:
        interrupted = True
    spread, rivals = _spread(polished, RIVAL * answer.cost)
    return Optimum(
        whole,
        best,
        SearchRecord(
            settings.method_on(problem),
            settings.seed,
            tuple(runs),
            tuple(polished),
            below + evaluations + refined,
            seconds,
            "interrupted" if interrupted else runs[0].ended,
        ),
        spread,
        rivals,
        len(runs),
        interrupted,
        answer.modes,
    )


def _spread(polished: Sequence[Polished], level: float) -> tuple[Array, int]:
    """Standard deviation, SI, (dim,), of the repeats no worse than a level; and their number."""
    near = [d.x for d in polished if d.cost <= level]
    deviation: Array = np.std(near, axis=0, ddof=1) if len(near) > 1 else polished[0].x * np.nan
    return deviation, len(near)


class _OwnSearch(NamedTuple):
    """What a problem's own search met.

    Args:
        parameters: Those of the problem, in ranges that hold it.
        runs: Its repeats, the best first.
        polished: What polishing makes of them.
        rows: Evaluations in all.
        near: Whether they began at places near the answer.
        interrupted: Whether Ctrl-C ended it.
    """

    parameters: Parameters
    runs: list[Run]
    polished: list[Polished]
    rows: int
    near: bool
    interrupted: bool


def _own(
    problem: MotionProblem, settings: SearchSettings, progress: Progress | None, *, smooth: bool,
    rich: bool,
) -> _OwnSearch:  # fmt: skip
    """The repeats of a problem's own search.

    Its law may be `rich`: contain one of many parameters.
    """
    begin = _near(problem, settings, progress, smooth=smooth, rich=rich)
    problem = problem.over(begin.parameters)
    if begin.interrupted:
        progress = _interrupt
    runs, interrupted = repeated(problem, settings, progress, smooth=smooth, near=begin.places)
    runs, polished, interrupted = polished_runs(problem, runs, settings, interrupted)
    rows = sum(r.evaluations for r in runs) + sum(d.evaluations for d in polished)
    rows += begin.evaluations
    return _OwnSearch(begin.parameters, runs, polished, rows, bool(begin.places), interrupted)


def _interrupt(searches: Sequence[Search]) -> None:
    """End searches that have looked where they begin."""
    del searches
    raise KeyboardInterrupt


def _near(
    problem: MotionProblem, settings: SearchSettings, progress: Progress | None, *, smooth: bool,
    rich: bool,
) -> NearPlaces:  # fmt: skip
    """Places near the answer where a search may begin.

    For a smooth motion under a rich law the ends of descents over longer and longer horizons; for
    others the answer of the law's rigid limit. No places where neither applies, where the budget is
    too small for horizons, where the axis is only pushed, or where the method is not memetic or has
    settings of its own.

    Raises:
        KeyboardInterrupt: Ctrl-C ended the search of the rigid limit.
    """
    nowhere = NearPlaces(problem.parameters, [], 0)
    if not settings.memetic or settings.settings:
        return nowhere
    if smooth:
        affordable = settings.budget >= evaluations_of(problem)
        if rich and affordable and has_horizons(problem):
            return horizon_ends(problem, settings, progress)
        return nowhere
    limit, rig = rigid_limit(problem.parameters), as_simulated(problem.parameters.rig)
    if limit is None or rig.only_pushed:
        return nowhere
    optimum = multistart(MotionProblem(limit, problem.train), settings, progress)
    if optimum.interrupted:
        raise KeyboardInterrupt
    answer = optimum.problem.parameters
    p = answer.full(optimum.x[None, : len(answer.free)])[0]
    places = carried(answer, p, problem.parameters)
    return NearPlaces(problem.parameters, places, optimum.search.evaluations)


def _contained_answer(
    problem: MotionProblem, simple: Parameters, solve: Callable[[MotionProblem], Optimum]
) -> tuple[Parameters, list[Array], int, bool]:
    """The answer of a contained law, searched as an identification with that law searches it.

    It ends at the same place, so that the richer law, which is given that, is never worse.

    Returns:
        The richer law's parameters, in ranges that hold the answer; the answer there, SI, (dim,);
        the evaluations; and whether Ctrl-C ended the search.
    """
    optimum = solve(MotionProblem(simple, problem.train))
    answer, rich = optimum.problem.parameters, problem.parameters
    p = answer.full(optimum.x[None, : len(answer.free)])[0]
    wider = rich.reaching(placed(answer, p, rich))
    points = carried(answer, p, wider)
    return wider, points, optimum.search.evaluations, optimum.interrupted


def _over(
    problem: MotionProblem, searched: MotionProblem, parameters: Parameters
) -> tuple[MotionProblem, MotionProblem]:
    """A problem and the one on fewer samples, or the same, over other search ranges."""
    other = problem.over(parameters)
    return other, other if searched is problem else searched.over(parameters)


def _on_all_samples(
    problem: MotionProblem, answer: Refined, allowance: int, *, refit: bool
) -> tuple[Refined, bool]:
    """An answer refitted on all samples; and whether Ctrl-C ended that.

    A log at a tipping point may tip on fewer samples, and not on all.
    """
    best = Refined(answer.x, answer.cost, 0)
    try:
        if refit:
            end = polish(problem, best.x, None, min(allowance, POLISH))
            best = Refined(end.x, end.cost, end.evaluations)
            best = no_worse(problem, best, answer.rivals, allowance)
    except KeyboardInterrupt:
        return best, True
    return best, False


def _started(
    problem: MotionProblem, x: Array, allowance: int
) -> tuple[MotionProblem | FreeStartProblem, Array, int]:
    """An answer with the starts of the motions where their rig needs these; and the rows."""
    free = with_free_starts(problem)
    if not isinstance(free, FreeStartProblem) or allowance <= 0:
        return problem, x, 0
    end = polish(free, np.concatenate([x, free.nominal]), None, min(allowance, POLISH))
    return free, end.x, end.evaluations


def _restarted(
    problem: MotionProblem, start: Polished, settings: SearchSettings, allowance: int
) -> tuple[MotionProblem, Polished]:
    """In many dimensions what is explored around an answer.

    With its problem, whose ranges are wider where that is at their ends.
    """
    if problem.space.dim < MANY or reached(settings, start.cost):
        return problem, start
    rough = is_beyond_noise(problem, start.cost)
    best = Refined(start.x, start.cost, 0)
    problem, best = explored(problem, best, settings.seed, allowance, valley=rough)
    end = Polished(best.x, best.cost, 0)
    problem, end = _widened(problem, end, allowance - best.evaluations)
    return problem, replace(end, evaluations=end.evaluations + best.evaluations)


def _after(optimum: Optimum, evaluations: int, seconds: float) -> Optimum:
    """An optimum with what an earlier search has cost."""
    search = optimum.search
    total = replace(
        search, evaluations=search.evaluations + evaluations, seconds=search.seconds + seconds
    )
    return replace(optimum, search=total)


def _widened(
    problem: MotionProblem, polished: Polished, allowance: int
) -> tuple[MotionProblem, Polished]:
    """The problem with default ranges so wide that its answer sits at none of their ends.

    At most so often widened that a range has grown a thousandfold.
    """
    spent = 0
    for _ in range(WIDENINGS):
        wider = problem.widened(polished.x)
        if wider is None or spent >= allowance:
            break
        polished = polish(wider, polished.x, polished.cost, allowance - spent)
        problem, spent = wider, spent + polished.evaluations
    return problem, replace(polished, evaluations=spent)
