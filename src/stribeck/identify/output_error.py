"""Identification by output error: the misfit is that of simulated motions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from ..rig.simulated import as_simulated
from ..space import Array
from .adequacy.advice import with_effects
from .adequacy.effects import effects
from .adequacy.equation_error import equation_error
from .adequacy.generalisation import held_out_violations, neighbour_violations
from .arithmetic import exact_enough
from .combinations import Combination, combinations
from .conditions import Violation, lowered, sentences
from .constants_report import borrowed, with_rulings
from .data_check import data_violations, trained_samples
from .data_split import DataSplit
from .exact_constants import Slopes, exact_constants, exact_slopes
from .fit_warnings import misfit_violations, output_error_warnings
from .free_constants import (
    FreeConstantsProblem,
    Ruling,
    rulings,
    stated_by_logs,
    with_free_constants,
)
from .initial_state import FreeStartProblem
from .log_spread import LogSpreads, log_spreads, spread_over_logs
from .motion_delay import delay_violations
from .multistart import Optimum, Progress, multistart
from .other_loss import other_loss_violations
from .parameters import Parameters
from .position_drift import drift_violations
from .problem import MotionProblem
from .refinement import MANY, settled
from .result import Fit
from .score import held_out, scores
from .search_settings import SearchSettings, sticks_and_slips
from .segment import SegmentSplit, recordings_of, split_segments
from .single_logs import answers_alone, single_logs
from .sliding_check import mark_never_slid
from .slip_by_slip import by_slip_where_needed, fitted_spreads, scatter_sentence, settled_slips
from .uncertainty.assessment import Uncertainty, uncertainty
from .uncertainty.estimates import (
    Estimate,
    bound_warnings,
    correlation_warnings,
    estimates,
    resting,
    without_partners,
)
from .uncertainty.residuals import Residuals

#: Rows that profiles may evaluate: half as many as the search did, so that where a motion takes
#: long to simulate the intervals do not take longer than the answer, and at least so many for each
#: parameter; but never more than the first.
PROFILES, PROFILED = 6_000, 400


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
    optimum, settling = _slips_settled(optimum)
    optimum, answers, alone = _searched_alone(optimum, settings)
    optimum, spent = _with_constants(optimum, settings)
    spent += settling + alone
    uncertain, interrupted = _profiled(optimum, len(parameters.free), settings, draws)
    uncertain = replace(uncertain, rows=uncertain.rows + spent)
    if interrupted:
        optimum = _interrupted(optimum)
    try:
        optimum, uncertain, violations = exact_enough(
            optimum, uncertain, lambda o: _profiled(o, len(parameters.free), settings, draws)[0]
        )
    except KeyboardInterrupt:
        optimum, violations = _interrupted(optimum), []
    fit = output_error_fit(optimum, uncertain, data, segments, violations, answers)
    return replace(fit, warnings=(*scatter_sentence(parameters, scattered), *fit.warnings))


def _slips_settled(optimum: Optimum) -> tuple[Optimum, int]:
    """The optimum with its slips' breakaway weighed as it scatters there, and rows spent."""
    problem = optimum.problem
    if optimum.interrupted or not isinstance(problem, MotionProblem) or problem.weights is None:
        return optimum, 0
    try:
        best = float(problem(optimum.x[None])[0])
        starts = [(optimum.x, best), *((d.x, d.cost) for d in optimum.search.polished[1:])]
        problem, x, spent = settled_slips(problem, starts)
    except KeyboardInterrupt:
        return _interrupted(optimum), 0
    return replace(optimum, problem=problem, x=x), spent


def _searched_alone(
    optimum: Optimum, settings: SearchSettings
) -> tuple[Optimum, dict[int, Array], int]:
    """The answers of single logs where they may be elsewhere, and rows spent."""
    if optimum.interrupted:
        return optimum, {}, 0
    try:
        return optimum, *answers_alone(optimum, settings)
    except KeyboardInterrupt:
        return _interrupted(optimum), {}, 0


def _with_constants(optimum: Optimum, settings: SearchSettings) -> tuple[Optimum, int]:
    """The optimum with the uncertain constants that matter among its unknowns, and rows spent.

    In many dimensions it is refitted then: profiles that meet a better fit start all over.
    """
    if optimum.interrupted or isinstance(optimum.problem, FreeConstantsProblem):
        return optimum, 0
    try:
        problem, x, spent = with_free_constants(optimum.problem, optimum.x)
        if settings.memetic and _rough(problem, optimum.problem):
            x, rows = settled(problem, x, settings.seed)
            spent += rows
    except KeyboardInterrupt:
        return _interrupted(optimum), 0
    return replace(optimum, problem=problem, x=x), spent


def _rough(problem: Residuals, before: Residuals) -> bool:
    """Whether a smooth motion's problem has many unknowns and new ones among them."""
    new = problem is not before and problem.space.dim >= MANY
    return new and isinstance(before, MotionProblem) and not sticks_and_slips(before)


def _interrupted(optimum: Optimum) -> Optimum:
    search = replace(optimum.search, ended="interrupted")
    return replace(optimum, search=search, interrupted=True)


def _profiled(
    optimum: Optimum, free: int, settings: SearchSettings, draws: int
) -> tuple[Uncertainty, bool]:
    """How well the first `free` parameters are known, and whether Ctrl-C cut that short.

    Then the profiles have the budget of a rough estimate.
    """
    problem, x = optimum.problem, optimum.x
    budget = min(PROFILES, max(optimum.search.evaluations // 2, PROFILED * problem.space.dim))
    keep = settings.polishing is False
    if not optimum.interrupted:
        try:
            uncertain = uncertainty(
                problem, x, among=free, budget=budget, keep=keep, draws=draws, seed=settings.seed
            )
        except KeyboardInterrupt:
            pass
        else:
            return uncertain, False
    return uncertainty(problem, x, among=free, budget=4 * len(x), keep=True), True


def _refits(
    optimum: Optimum, uncertain: Uncertainty, judged: Sequence[Estimate], *, rough: bool
) -> tuple[list[Violation], int]:
    """What refits with a drift, a delay or another loss tell of a fit; and the rows evaluated.

    Args:
        optimum: Where the search ended.
        uncertain: Its `x` is the solution.
        judged: The estimates.
        rough: Whether the misfit is beyond the noise: only then the other loss is tried.
    """
    problem, x = optimum.problem, uncertain.x
    if isinstance(problem, FreeConstantsProblem):
        problem, x = problem.at(x)
    looks = [drift_violations(problem, x, judged), delay_violations(problem, x, judged)]
    if rough:
        runs = optimum.search.runs
        looks.append(other_loss_violations(optimum.problem, uncertain.x, judged, runs))
    return [v for told, _ in looks for v in told], sum(rows for _, rows in looks)


def output_error_fit(
    optimum: Optimum,
    uncertain: Uncertainty,
    data: DataSplit,
    segments: SegmentSplit,
    arithmetic: Sequence[Violation],
    answers: Mapping[int, Array] = MappingProxyType({}),
) -> Fit:
    """The fit of a least-misfit parameter set: scored, validated and judged.

    Args:
        optimum: Where the search ended.
        uncertain: How well its parameters are known; its `x` is the solution.
        data: What was trained on and held out.
        segments: The same as segments.
        arithmetic: What is to be told of the arithmetic; see `exact_enough`.
        answers: What a search has for single logs; see `answers_alone`.
    """
    problem, x = optimum.problem, uncertain.x
    ruled: list[Ruling] = []
    sums: tuple[Combination, ...] = ()
    if isinstance(problem, FreeConstantsProblem):
        ruled = rulings(problem, x, uncertain.profiles.quick.curvature)
        try:
            sums, spent = ((), 0) if optimum.interrupted else combinations(problem, ruled, x)
            uncertain = replace(uncertain, rows=uncertain.rows + spent)
        except KeyboardInterrupt:
            optimum = _interrupted(optimum)
        problem, x = problem.at(x)
    parameters, dim = problem.parameters, len(problem.parameters.free)
    p = parameters.full(x[None, :dim])[0]
    motion = problem.at(x)[0] if isinstance(problem, FreeStartProblem) else problem
    train = motion.train
    score = scores(parameters, p, train)
    judged = estimates(
        parameters,
        p,
        uncertain,
        optimum.spread,
        resting=resting(problem, x),
    )
    optimum, differing = _log_by_log(optimum, problem, x, uncertain.errors[:dim], answers)
    uncertain = replace(uncertain, rows=uncertain.rows + differing.rows)
    judged, between = spread_over_logs(parameters, judged, differing)
    trained = trained_samples(data.recordings, segments.train)
    misfit = misfit_violations(
        parameters, score, data.recordings, judged, optimum.rivals, optimum.repeats
    )
    violations = [
        *arithmetic,
        *data_violations(parameters.rig, data.recordings, trained),
        *misfit,
        *between,
    ]
    if not optimum.interrupted:
        try:
            told, spent = _refits(optimum, uncertain, judged, rough=bool(misfit))
            violations += told
            uncertain = replace(uncertain, rows=uncertain.rows + spent)
        except KeyboardInterrupt:
            optimum = _interrupted(optimum)
    judged = mark_never_slid(parameters, judged, recordings_of(train))
    judged = with_rulings(parameters, judged, ruled)
    slopes: Slopes = {}
    if not optimum.interrupted:
        slopes, spent = exact_slopes(problem, x)
        uncertain = replace(uncertain, rows=uncertain.rows + spent)
    rows = None if optimum.interrupted else equation_error(parameters, p, train, judged)
    seen = None if rows is None else effects(rows)
    judged, inadequate = with_effects(parameters, judged, seen, recordings_of(train))
    holdout = tuple(held_out(parameters, p, r, s) for r, s in segments.holdout)
    violations += [
        *inadequate,
        *neighbour_violations(parameters, recordings_of(train)),
        *held_out_violations(score, holdout),
    ]
    judged = lowered(parameters, judged, violations)
    correlation = uncertain.correlation[:dim, :dim]
    judged = without_partners(parameters, judged, correlation)
    interrupted = "interrupted: the search, its polishing or its intervals had not ended"
    return Fit(
        parameters=parameters,
        p=p,
        estimates=judged,
        correlation=correlation,
        score=score,
        holdout=holdout,
        search=optimum.search,
        train=train,
        train_ranges=data.train,
        recordings=data.recordings,
        warnings=(
            *([interrupted] if optimum.search.ended == "interrupted" else []),
            *sentences(violations),
            *bound_warnings(judged),
            *borrowed(optimum.problem),
            *exact_constants(parameters, judged, slopes, stated_by_logs(problem)),
            *correlation_warnings(parameters, correlation),
            *output_error_warnings(
                parameters, score, segments, data.recordings, optimum.rivals, optimum.repeats
            ),
            *uncertain.notes(parameters),
        ),
        uncertainty=uncertain,
        residuals=optimum.problem,
        violations=tuple(violations),
        effects=seen,
        delay=data.delay,
        combinations=sums,
        breakaway=fitted_spreads(parameters, p, train, uncertain.profiles),
        differing=differing,
    )


def _log_by_log(
    optimum: Optimum,
    problem: MotionProblem | FreeStartProblem,
    x: Array,
    errors: Array,
    answers: Mapping[int, Array],
) -> tuple[Optimum, LogSpreads]:
    """What the logs give one by one at a fit; and the optimum, interrupted if that was."""
    if optimum.interrupted:
        return optimum, LogSpreads()
    try:
        return optimum, log_spreads(problem.parameters, single_logs(problem, x, answers), errors)
    except KeyboardInterrupt:
        return _interrupted(optimum), LogSpreads()
