"""Repeats of a search and what contained laws lead to, refined; the best of all is the answer."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..errors import InputError
from ..optimize import Run, Search, steps
from ..rig.simulated import as_simulated
from ..space import Array
from .displaced_inertia import displaced_inertia
from .fit_warnings import NOISY, RIVAL, noise_floor
from .free_constants import FreeConstantsProblem
from .growing_span import growing_span
from .initial_state import FreeStartProblem, free_starts
from .nested_answers import Answers, contained, descended, nested_answers, richest, rigid_limit
from .parameters import WIDENINGS, Parameters
from .polish import Polished, polish, polish_run
from .problem import MotionProblem
from .refinement import MANY, Refined, restarted, turned
from .result import SearchRecord
from .ripple_orders import ripple_orders
from .search_settings import (
    CONFIRM,
    CONFIRM_ROUGH,
    POLISH,
    REPEATS,
    SearchSettings,
    confirmed,
    confirms,
    rough,
    sticks_and_slips,
)
from .segment import recordings_of
from .selection.nesting import carried, placed
from .valley import along_valley

#: Evaluations for each parameter and repeat below which a search is not worth its while.
FEWEST = 100
#: The share of J whose gain in wider default ranges calls for a new search, and how many searches
#: there may be in all.
MATERIAL, SEARCHES = 0.01, 3
#: The next best answer is descended from again, on all samples and by the final loss, if it is
#: worse there by no more than this share: before, the order of two answers may be another.
NEAR = 0.02
#: Evaluations a parameter of a descent by the other loss, or back from there; and how many times
#: as many a walk along a valley may take.
REFINE, VALLEY = 25, 4

#: Called with the searches after every step.
Progress = Callable[[Sequence[Search]], None]


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


def run_searches(
    problem: MotionProblem,
    searches: Sequence[Search],
    progress: Progress | None,
    enough: Callable[[Sequence[Search]], bool] | None = None,
    rests: Callable[[Search], bool] | None = None,
) -> tuple[list[Run], bool]:
    """Advance all searches together until they have ended, or until Ctrl-C.

    Args:
        problem: What they search.
        searches: Ready to run, or ended.
        progress: Called with them after every step.
        enough: Whether their answer is confirmed: then all end.
        rests: Whether one of them waits for the others.

    Returns:
        Their runs, and whether they were interrupted.

    Raises:
        InputError: no point that was tried could be simulated.
    """
    interrupted = False
    try:
        for _ in steps(problem, searches, rests):
            if progress is not None:
                progress(searches)
            if enough is not None and enough(searches):
                for search in searches:
                    search.cut("confirmed")
    except KeyboardInterrupt:
        if not all(len(s.trace) for s in searches):
            raise
        interrupted = True
    runs = [s.run() for s in searches]
    if not np.isfinite(min(r.cost for r in runs)):
        raise InputError(
            f"no parameter set in the search ranges could be simulated with law "
            f"{problem.parameters.law.name}: check the ranges and the rig's constants"
        )
    return runs, interrupted


def with_free_starts(problem: MotionProblem) -> MotionProblem | FreeStartProblem:
    """The problem with the start of each motion among its unknowns, if its rig needs that."""
    return FreeStartProblem(problem) if free_starts(problem) else problem


def multistart(
    problem: MotionProblem,
    settings: SearchSettings,
    progress: Progress | None = None,
    *,
    searches: int = SEARCHES,
    known: Sequence[Array] = (),
    answers: Answers | None = None,
) -> Optimum:
    """Search, polish each repeat, and refine the best: in its own loss, and with free starts.

    An answer at an end of a default range goes on beyond it; where that brings more than a little,
    the search is done anew in the wider ranges.

    Args:
        problem: Its J is minimised.
        settings: How.
        progress: Called with the searches after every step.
        searches: How often it may be done.
        known: Answers of a search in narrower ranges and of contained laws, free parameters, SI,
            (dim,) each: these laws are not searched again, and the optimum is no worse.
        answers: Of contained laws on fewer samples, as far as they were met; more are added.

    Raises:
        InputError: no parameter set could be simulated.
    """
    start_time, answers = time.perf_counter(), {} if answers is None else answers
    smooth = not sticks_and_slips(problem)
    searched = problem.thinned() if smooth and settings.memetic else problem
    runs, polished, evaluations, interrupted = _own(searched, settings, progress, smooth=smooth)
    done = known or interrupted or not smooth or _reached(settings, polished[0].cost)
    simple = None if done or not settings.memetic else richest(problem.parameters)
    below, least = 0, list(known)  # evaluations that are not of this law's budget
    if simple is not None:
        solve = partial(multistart, settings=settings, progress=progress, answers=answers)
        held, least, below, interrupted = _contained_answer(problem, simple, solve)
        searched = held if searched is problem else searched.over(held.parameters)
        problem = held
    answer = Refined(polished[0].x, polished[0].cost, 0, rivals=tuple(least))
    if smooth and settings.memetic and not interrupted:
        allowance = settings.budget * settings.repeats - evaluations
        answer, interrupted = _refined_answer(
            searched, answer, settings, progress, allowance, None if known else answers
        )
    evaluations += answer.evaluations
    seconds = time.perf_counter() - start_time
    allowance = settings.budget * settings.repeats - evaluations
    if interrupted or settings.polishing is False:
        allowance = 0
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
            ):
                known = (wider.x, *answer.rivals) if smooth and _rich(problem) else ()
                again = multistart(problem, left, progress, searches=searches - 1, known=known)
                return _after(again, below + evaluations + refined, seconds)
            cost = wider.cost
        if smooth and settings.memetic and allowance > refined:
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


def _own(
    problem: MotionProblem, settings: SearchSettings, progress: Progress | None, *, smooth: bool
) -> tuple[list[Run], list[Polished], int, bool]:
    """The repeats of a problem's own search and what polishing makes of them, the best first.

    With the evaluations, and whether Ctrl-C ended them.
    """
    near, rows = ([], 0) if smooth else _near_limit(problem, settings, progress)
    runs, interrupted = _repeated(problem, settings, progress, smooth=smooth, near=near)
    runs, polished, interrupted = _polished(problem, runs, settings, interrupted)
    rows += sum(r.evaluations for r in runs) + sum(d.evaluations for d in polished)
    return runs, polished, rows, interrupted


def _near_limit(
    problem: MotionProblem, settings: SearchSettings, progress: Progress | None
) -> tuple[list[Array], int]:
    """Points of a stick-slip problem near the answer of its law's rigid limit, SI; and the rows.

    None where there is no such law, a force balance shows the answer, or the search is another's.

    Raises:
        KeyboardInterrupt: Ctrl-C ended the search of that law.
    """
    limit, rig = rigid_limit(problem.parameters), as_simulated(problem.parameters.rig)
    if limit is None or rig.only_pushed or not settings.memetic or settings.settings:
        return [], 0
    optimum = multistart(MotionProblem(limit, problem.train), settings, progress)
    if optimum.interrupted:
        raise KeyboardInterrupt
    answer = optimum.problem.parameters
    p = answer.full(optimum.x[None, : len(answer.free)])[0]
    return carried(answer, p, problem.parameters), optimum.search.evaluations


def _contained_answer(
    problem: MotionProblem, simple: Parameters, solve: Callable[[MotionProblem], Optimum]
) -> tuple[MotionProblem, list[Array], int, bool]:
    """The answer of a contained law, searched as an identification with that law searches it.

    It ends at the same place, so that the richer law, which is given that, is never worse.

    Returns:
        The richer law's problem, in ranges that hold the answer; the answer there, SI, (dim,); the
        evaluations; and whether Ctrl-C ended the search.
    """
    optimum = solve(MotionProblem(simple, problem.train))
    answer, rich = optimum.problem.parameters, problem.parameters
    p = answer.full(optimum.x[None, : len(answer.free)])[0]
    wider = rich.reaching(placed(answer, p, rich))
    points = carried(answer, p, wider)
    return problem.over(wider), points, optimum.search.evaluations, optimum.interrupted


def _repeated(
    problem: MotionProblem, settings: SearchSettings, progress: Progress | None, *, smooth: bool,
    near: Sequence[Array] = (),
) -> tuple[list[Run], bool]:  # fmt: skip
    """The repeats; where those of a smooth problem, or of slips, confirm each other no more.

    Where a force balance or another law shows where the answer is, they descend from there; others
    only where that leaves more than noise.

    Those that have come to the best misfit and stayed there wait for the others, as long as more
    of them can be added. Where contained laws lead further there is one, and a brief one.
    """
    n = settings.repeats
    known = settings.from_points(problem, near) or settings.from_contact(problem)
    if known:
        runs, interrupted = run_searches(problem, known, progress)
        noise = noise_floor(problem.parameters.rig, recordings_of(problem.train))
        if interrupted or not rough(known, noise):
            return runs, interrupted
        rest = replace(settings, repeats=max(n - len(known), 1))
        others, interrupted = _drawn(problem, rest, progress, smooth=smooth)
        return [*runs, *others], interrupted
    return _drawn(problem, settings, progress, smooth=smooth)


def _drawn(
    problem: MotionProblem, settings: SearchSettings, progress: Progress | None, *, smooth: bool
) -> tuple[list[Run], bool]:
    """The repeats of a search that begins anywhere; see `_repeated`."""
    n = settings.repeats
    guided = smooth or problem.weights is not None
    if smooth and settings.memetic and _rich(problem):
        n = max(n // REPEATS, 1)
        searches = settings.searches(problem, smooth=smooth, n=n, brief=True)
        return run_searches(problem, searches, progress)
    if not (guided and settings.memetic) or n < CONFIRM:
        return run_searches(problem, settings.searches(problem, smooth=smooth, n=n), progress)
    most = n if problem.space.dim >= MANY else 2 * n  # there restarts around the answer follow
    searches = settings.searches(problem, smooth=smooth, n=most)
    noise = noise_floor(problem.parameters.rig, recordings_of(problem.train))
    active = agreeing = CONFIRM
    while True:
        begun = searches[:active]
        enough = partial(confirmed, noise=noise, repeats=agreeing)
        rests = partial(confirms, begun, noise) if active < most else None
        runs, interrupted = run_searches(problem, begun, progress, enough, rests)
        if interrupted or active == most:
            return runs, interrupted
        if enough(begun):
            if agreeing == CONFIRM_ROUGH or not rough(begun, noise):
                return runs, interrupted
            agreeing = CONFIRM_ROUGH
        active += 1


def _refined_answer(
    problem: MotionProblem, answer: Refined, settings: SearchSettings, progress: Progress | None,
    allowance: int, answers: Answers | None,
) -> tuple[Refined, bool]:  # fmt: skip
    """The answer of the repeats refined, or what others lead to where that is better.

    And whether Ctrl-C ended that. The others are the answer's rivals and those of contained laws;
    None: the rivals have these among them.

    Where there are both, descents from rivals are others: of two places the lower need not be the
    one that leads further.
    """
    if _reached(settings, answer.cost):
        return answer, False
    best, rivals = answer, list(answer.rivals)
    try:
        rich = _rich(problem)
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
                best = _along_valley(problem, end)
                spent += best.evaluations - end.evaluations
        best = replace(best, evaluations=spent)
        # The rest is for what follows: restarts, all samples, a lower knee, wider ranges.
        best = displaced_inertia(problem, best, (allowance - spent) // 2)
        best = ripple_orders(problem, best)
        grown = growing_span(problem, best)
        best = grown if grown.cost == best.cost else _along_valley(problem, grown)
        best = replace(best, rivals=tuple(rivals))
    except KeyboardInterrupt:
        return replace(best, rivals=answer.rivals), True
    return best, False


def _rich(problem: MotionProblem) -> bool:
    """Whether a problem has many parameters, and a law that contains others.

    Few evaluations for each of them lead from the answers of these to places that a search of the
    whole box meets by luck. (Of four repeats for bam-m6 on the XL330's logs, of 2,600 evaluations
    each, one ended at 44.3 mrad, the others at 66 to 98; descents from contained laws, 8,000 with
    those that led to these, ended at 42.6 and 44.0.)
    """
    return problem.space.dim >= MANY and bool(contained(problem.parameters))


def _reached(settings: SearchSettings, cost: float) -> bool:
    return settings.target is not None and cost <= settings.target


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
            best = _no_worse(problem, best, answer.rivals, allowance)
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
    """In many dimensions what an evolution strategy around an answer leads to.

    With its problem, whose ranges are wider where that is at their ends.
    """
    if problem.space.dim < MANY or _reached(settings, start.cost):
        return problem, start
    best = restarted(problem, Refined(start.x, start.cost, 0), settings.seed, allowance)
    end = Polished(best.x, best.cost, 0)
    problem, end = _widened(problem, end, allowance - best.evaluations)
    return problem, replace(end, evaluations=end.evaluations + best.evaluations)


def _no_worse(
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
    runs, interrupted = _repeated(problem, settings, progress, smooth=True)
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
    return _along_valley(problem, best)


def _along_valley(problem: MotionProblem, best: Refined) -> Refined:
    """A minimum, or a better one of its valley where its misfit is beyond the noise."""
    if best.cost > NOISY * noise_floor(problem.parameters.rig, recordings_of(problem.train)):
        end = along_valley(problem, best.x, best.cost, VALLEY * REFINE * problem.space.dim)
        best = replace(best, x=end.x, cost=end.cost, evaluations=best.evaluations + end.evaluations)
    return best


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
        parameters = problem.parameters.widened(polished.x)
        if parameters is None or spent >= allowance:
            break
        wider = problem.over(parameters)
        polished = polish(wider, polished.x, polished.cost, allowance - spent)
        problem, spent = wider, spent + polished.evaluations
    return problem, replace(polished, evaluations=spent)


def _polished(
    problem: MotionProblem, runs: Sequence[Run], settings: SearchSettings, interrupted: bool
) -> tuple[list[Run], list[Polished], bool]:
    """The runs and what polishing makes of them, the best first; True if Ctrl-C ended it."""
    allowance = 0 if interrupted else settings.polish_budget
    polished: list[Polished] = []
    try:
        for run in runs:
            polished.append(polish_run(problem, run, allowance))  # noqa: PERF401 - Ctrl-C keeps it
    except KeyboardInterrupt:
        interrupted = True
        polished += (polish_run(problem, r, 0) for r in runs[len(polished) :])
    order = sorted(range(len(runs)), key=lambda k: polished[k].cost)
    return [runs[k] for k in order], [polished[k] for k in order], interrupted
