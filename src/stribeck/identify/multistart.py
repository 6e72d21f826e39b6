"""Independent repeats of a search, each polished by least squares; the best one is the answer."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from numbers import Integral
from typing import Any

import numpy as np
from numpy.random import SeedSequence

from ..data.segmentation import segment
from ..errors import InputError
from ..optimize import Algorithm, MemeticTabuSearch, Run, Search, Target, configure, steps
from ..space import Array
from .fit_warnings import RIVAL
from .free_constants import FreeConstantsProblem
from .initial_state import FreeStartProblem, free_starts
from .polish import Polished, polish, polish_run
from .problem import MotionProblem
from .result import SearchRecord

#: Evaluations a repeat may spend by default, and what polishing may take of them: a quarter at
#: most.
BUDGET, POLISH = 8_000, 2_400
REPEATS = 3
#: Evaluations for each parameter and repeat below which a search is not worth its while.
FEWEST = 100
#: How often default ranges are widened in a row, the share of J whose gain there calls for a new
#: search, and how many searches there may be in all.
WIDENINGS, MATERIAL, SEARCHES = 10, 0.01, 3
#: Evaluations a parameter after which `mbts` has settled, if they brought nothing better: in
#: stick-slip, where a misfit has many basins, and where motions are smooth.
SETTLE, SETTLE_SMOOTH = 200, 60
#: Fewer slips a log are no stick-slip.
SLIPS = 5

#: Called with the searches after every step.
Progress = Callable[[Sequence[Search]], None]


@dataclass(frozen=True)
class SearchSettings:
    """How an identification searches.

    Args:
        method: Name of the search method.
        settings: Its settings, where they are not the method's own.
        seed: Seed of all repeats.
        budget: Evaluations of the cost for each repeat, polishing included.
        repeats: Independent searches.
        target: J at which a search stops.
        polishing: Whether least squares polishes what a search ended with; None: unless the
            method does so itself.

    Raises:
        InputError: a number is not whole, or too small.
    """

    method: str = MemeticTabuSearch.name
    settings: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0
    budget: int = BUDGET
    repeats: int = REPEATS
    target: float | None = None
    polishing: bool | None = None

    def __post_init__(self) -> None:
        for name, least in (("budget", 1), ("repeats", 1), ("seed", 0)):
            value = getattr(self, name)
            if not isinstance(value, Integral) or value < least:
                raise InputError(f"{name} must be a whole number >= {least}, got {value!r}")

    @property
    def polish_budget(self) -> int:
        """Evaluations of each repeat that are kept for polishing."""
        polishes_itself = self.polishing is None and self.method == MemeticTabuSearch.name
        if polishes_itself or self.polishing is False:
            return 0
        return min(POLISH, self.budget // 4)

    def searches(self, problem: MotionProblem) -> list[Search]:
        """The repeats, ready to run."""
        algorithm = self._algorithm(problem)
        stops = [] if self.target is None else [Target(self.target)]
        budget = self.budget - self.polish_budget
        return [
            Search(problem.space, algorithm, budget=budget, seed=s, stops=stops)
            for s in SeedSequence(self.seed).spawn(self.repeats)
        ]

    def _algorithm(self, problem: MotionProblem) -> Algorithm:
        settle = SETTLE if _sticks_and_slips(problem) else SETTLE_SMOOTH
        defaults = {"settle": settle} if self.method == MemeticTabuSearch.name else {}
        return configure(self.method, **defaults | dict(self.settings))


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
    """

    problem: MotionProblem | FreeStartProblem | FreeConstantsProblem
    x: Array
    search: SearchRecord
    spread: Array
    rivals: int
    repeats: int
    interrupted: bool


def run_searches(
    problem: MotionProblem, searches: Sequence[Search], progress: Progress | None
) -> tuple[list[Run], bool]:
    """Advance all searches together until they have ended, or until Ctrl-C.

    Returns:
        Their runs, and whether they were interrupted.

    Raises:
        InputError: no point that was tried could be simulated.
    """
    interrupted = False
    try:
        for _ in steps(problem, searches):
            if progress is not None:
                progress(searches)
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
) -> Optimum:
    """Search, polish each repeat, and refine the best: in its own loss, and with free starts.

    An answer at an end of a default range goes on beyond it; where that brings more than a little,
    the search is done anew in the wider ranges.

    Args:
        problem: Its J is minimised.
        settings: How.
        progress: Called with the searches after every step.
        searches: How often it may be done.

    Raises:
        InputError: no parameter set could be simulated.
    """
    start_time = time.perf_counter()
    runs, interrupted = run_searches(problem, settings.searches(problem), progress)
    runs, polished, interrupted = _polished(problem, runs, settings, interrupted)
    seconds = time.perf_counter() - start_time
    evaluations = sum(r.evaluations for r in runs) + sum(d.evaluations for d in polished)
    allowance = 0 if interrupted else settings.budget * settings.repeats - evaluations
    if settings.polishing is False:
        allowance = 0
    if bent := problem.parameters.objective.loss == "absolute" and not interrupted:
        problem = problem.finer()
    best, refined = polished[0].x, 0
    try:
        if allowance >= 1:
            problem, wider = _widened(problem, polished[0], min(allowance, POLISH))
            best, refined, allowance = wider.x, wider.evaluations, allowance - wider.evaluations
            left = replace(settings, budget=max(allowance // settings.repeats, 1))
            if (
                searches > 1
                and left.budget >= FEWEST * problem.space.dim
                and wider.cost < (1 - MATERIAL) * polished[0].cost
            ):
                again = multistart(problem, left, progress, searches=searches - 1)
                return _after(again, evaluations + refined, seconds)
    except KeyboardInterrupt:
        interrupted = True
    whole: MotionProblem | FreeStartProblem = problem
    try:
        if bent and allowance > 1 and not interrupted:
            best, spent = _refined(problem, best, min(allowance, POLISH))
            refined, allowance = refined + spent, allowance - spent
        free = with_free_starts(problem)
        if allowance >= 1 and not interrupted and isinstance(free, FreeStartProblem):
            x = np.concatenate([best, free.nominal])
            best, spent = _refined(free, x, min(allowance, POLISH))
            whole, refined = free, refined + spent
    except KeyboardInterrupt:
        interrupted = True
    rivals = [d.x for d in polished if d.cost <= RIVAL * polished[0].cost]
    dim = problem.space.dim
    return Optimum(
        whole,
        best,
        SearchRecord(
            settings.method,
            settings.seed,
            tuple(runs),
            tuple(polished),
            evaluations + refined,
            seconds,
            "interrupted" if interrupted else runs[0].ended,
        ),
        np.std(rivals, axis=0, ddof=1) if len(rivals) > 1 else np.full(dim, np.nan),
        len(rivals),
        len(runs),
        interrupted,
    )


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


def _refined(
    problem: MotionProblem | FreeStartProblem, x: Array, allowance: int
) -> tuple[Array, int]:
    """A point polished on another problem than it was found on, and the evaluations spent."""
    cost = float(problem(x[None])[0])
    refined = polish(problem, x, cost, allowance - 1)
    return refined.x, refined.evaluations + 1


def _sticks_and_slips(problem: MotionProblem) -> bool:
    """Whether the axis sticks and slips in the training data, or elements of its law do."""
    if free_starts(problem) or problem.parameters.law.states > 1:
        return True
    logs = {id(s.recording): s.recording for s in problem.train}
    slips = {key: segment(log).slips for key, log in logs.items()}
    inside = (
        s.rows.start <= slip.start and slip.stop <= s.rows.stop
        for s in problem.train
        for slip in slips[id(s.recording)]
    )
    return bool(sum(inside) >= SLIPS * len(logs))
