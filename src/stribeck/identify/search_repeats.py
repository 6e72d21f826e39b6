"""Repeats of a search, side by side until they confirm each other, and polished."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..errors import InputError
from ..optimize import Run, Search, steps
from ..space import Array
from .fit_warnings import noise_floor
from .nested_answers import is_rich
from .polish import Polished, polish_run
from .problem import MotionProblem
from .refinement import MANY
from .score import scores
from .search_settings import (
    CONFIRM,
    CONFIRM_ROUGH,
    REPEATS,
    SearchSettings,
    confirmed,
    confirms,
    rough,
)
from .segment import recordings_of

#: A model whose misfit is so much of that of an axis that never moves does not move either.
STANDS = 0.95
#: Called with the searches after every step.
Progress = Callable[[Sequence[Search]], None]


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


def repeated(
    problem: MotionProblem, settings: SearchSettings, progress: Progress | None, *, smooth: bool,
    near: Sequence[Array] = (),
) -> tuple[list[Run], bool]:  # fmt: skip
    """The repeats; where those of a smooth problem, or of slips, confirm each other no more.

    Where a force balance or another law shows where the answer is, they descend from there; others
    only where that leaves more than noise. Places near the answer of a smooth problem are of many
    descents over shorter horizons, and there are no others.

    Those that have come to the best misfit and stayed there wait for the others, as long as more
    of them can be added. Where contained laws lead further there is one, and a brief one.
    """
    n = settings.repeats
    known = settings.from_points(problem, near) or settings.from_contact(problem)
    if known:
        runs, interrupted = run_searches(problem, known, progress)
        noise = noise_floor(problem.parameters.rig, recordings_of(problem.train))
        if interrupted or (smooth and near) or not rough(known, noise):
            return runs, interrupted
        rest = replace(settings, repeats=max(n - len(known), 1))
        others, interrupted = _drawn(problem, rest, progress, smooth=smooth)
        return [*runs, *others], interrupted
    return _drawn(problem, settings, progress, smooth=smooth)


def _drawn(
    problem: MotionProblem, settings: SearchSettings, progress: Progress | None, *, smooth: bool
) -> tuple[list[Run], bool]:
    """The repeats of a search that begins anywhere; see `repeated`."""
    n = settings.repeats
    guided = smooth or problem.weights is not None
    if smooth and settings.memetic and is_rich(problem):
        n = max(n // REPEATS, 1)
        searches = settings.searches(problem, smooth=smooth, n=n, brief=True)
        return run_searches(problem, searches, progress)
    if not (guided and settings.memetic):
        return run_searches(problem, settings.searches(problem, smooth=smooth, n=n), progress)
    runs, interrupted = _until_confirmed(problem, settings, progress, smooth=smooth)
    if interrupted or not _stands(problem, runs):
        return runs, interrupted
    further = settings.from_little_friction(problem)
    if not further:
        return runs, interrupted
    moving, interrupted = run_searches(problem, further, progress)
    return [*runs, *moving], interrupted


def _stands(problem: MotionProblem, runs: Sequence[Run]) -> bool:
    """Whether the best of some runs hardly moves."""
    best = min(runs, key=lambda run: run.cost)
    p = problem.parameters.full(best.x[None])[0]
    score = scores(problem.parameters, p, problem.train)
    return bool(score.value >= STANDS * score.still)


def _until_confirmed(
    problem: MotionProblem, settings: SearchSettings, progress: Progress | None, *, smooth: bool
) -> tuple[list[Run], bool]:
    """Repeats of a smooth problem, or of slips, until they confirm each other."""
    n = settings.repeats
    if n < CONFIRM:
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


def polished_runs(
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
