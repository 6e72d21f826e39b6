"""Identification by output error: the misfit is that of simulated motions."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ..rig.simulated import as_simulated
from ..space import Array
from .arithmetic import Checked, exact_enough
from .data_split import DataSplit
from .free_constants import FreeConstantsProblem, with_free_constants
from .measured_state import with_states
from .multistart import Optimum, multistart
from .output_error_fit import output_error_fit
from .parameters import Parameters
from .problem import MotionProblem
from .refinement import MANY, settled
from .result import Fit
from .search_repeats import Progress
from .search_settings import SearchSettings, sticks_and_slips
from .segment import split_segments
from .single_logs import answers_alone
from .slip_by_slip import by_slip_where_needed, scatter_sentence, settled_slips
from .uncertainty.assessment import Uncertainty, uncertainty
from .uncertainty.residuals import Residuals
from .work import Work

#: Rows that profiles may evaluate: half as many as the search did, so that where a motion takes
#: long to simulate the intervals do not take longer than the answer, and at least so many for each
#: parameter; but never more than the first.
PROFILES, PROFILED = 6_000, 400
#: Rows for each parameter of the rough profiles of a search that was interrupted.
ROUGH = 4


def solve_output_error(
    parameters: Parameters,
    data: DataSplit,
    settings: SearchSettings,
    *,
    draws: int = 0,
    progress: Progress | None = None,
) -> Fit:
    """Identify by output error: search, polish, and profile the answer.

    Args:
        parameters: Of a law on a rig that is simulated.
        data: What to train on and to hold out.
        settings: How to search.
        draws: Data sets of a block bootstrap.
        progress: Called with the searches after every step.

    Raises:
        InputError: a range has no motion to simulate, or no parameter set could be simulated.
    """
    parameters, scattered = by_slip_where_needed(parameters, data)
    segments = split_segments(data, as_simulated(parameters.rig), parameters.objective)
    optimum = multistart(MotionProblem(parameters, segments.train), settings, progress)
    work = Work(optimum.interrupted)
    optimum = work.result(partial(_slips_settled, optimum), optimum)
    answers: dict[int, Array] = work.result(partial(answers_alone, optimum, settings), {})
    optimum = work.result(partial(_with_states, optimum), optimum)
    optimum = work.result(partial(_with_constants, optimum, settings), optimum)
    free = len(parameters.free)
    profile = partial(_profiled, free=free, settings=settings, draws=draws)
    whole: Uncertainty | None = work.result(partial(profile, optimum), None)
    uncertain = _roughly_profiled(optimum, free, work) if whole is None else whole
    checked = work.result(
        partial(exact_enough, optimum, uncertain, profile), Checked(optimum, uncertain)
    )
    fit = output_error_fit(checked, data, segments, work, answers)
    return replace(fit, warnings=(*scatter_sentence(parameters, scattered), *fit.warnings))


def _slips_settled(optimum: Optimum) -> tuple[Optimum, int]:
    """The optimum with its slips' breakaway weighed as it scatters there, and rows spent."""
    problem = optimum.problem
    if not isinstance(problem, MotionProblem) or problem.weights is None:
        return optimum, 0
    best = float(problem(optimum.x[None])[0])
    starts = [(optimum.x, best), *((d.x, d.cost) for d in optimum.search.polished[1:])]
    problem, x, spent = settled_slips(problem, starts)
    return replace(optimum, problem=problem, x=x), spent


def _with_states(optimum: Optimum) -> tuple[Optimum, int]:
    """The optimum with the states estimated in which its motions begin, and rows spent."""
    if not isinstance(optimum.problem, MotionProblem):
        return optimum, 0
    problem, x, spent = with_states(optimum.problem, optimum.x)
    return replace(optimum, problem=problem, x=x), spent


def _with_constants(optimum: Optimum, settings: SearchSettings) -> tuple[Optimum, int]:
    """The optimum with the uncertain constants that matter among its unknowns, and rows spent.

    In many dimensions it is refitted then: profiles that meet a better fit start all over.
    """
    if isinstance(optimum.problem, FreeConstantsProblem):
        return optimum, 0
    problem, x, spent = with_free_constants(optimum.problem, optimum.x)
    if settings.memetic and _rough(problem, optimum.problem):
        x, rows = settled(problem, x, settings.seed)
        spent += rows
    return replace(optimum, problem=problem, x=x), spent


def _rough(problem: Residuals, before: Residuals) -> bool:
    """Whether a smooth motion's problem has many unknowns and new ones among them."""
    new = problem is not before and problem.space.dim >= MANY
    return new and isinstance(before, MotionProblem) and not sticks_and_slips(before)


def _profiled(
    optimum: Optimum, free: int, settings: SearchSettings, draws: int
) -> tuple[Uncertainty, int]:
    """How well the first `free` parameters are known, and rows spent."""
    problem = optimum.problem
    uncertain = uncertainty(
        problem,
        optimum.x,
        among=free,
        budget=min(PROFILES, max(optimum.search.evaluations // 2, PROFILED * problem.space.dim)),
        keep=settings.polishing is False,
        draws=draws,
        seed=settings.seed,
        modes=[np.concatenate([mode, optimum.x[len(mode) :]]) for mode in optimum.modes],
    )
    return uncertain, uncertain.rows


def _roughly_profiled(optimum: Optimum, free: int, work: Work) -> Uncertainty:
    """The same of a search that was interrupted, as it is."""
    x = optimum.x
    rough = uncertainty(optimum.problem, x, among=free, budget=ROUGH * len(x), keep=True)
    work.rows += rough.rows
    return rough
