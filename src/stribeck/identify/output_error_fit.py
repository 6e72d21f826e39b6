"""The fit that a solution by output error makes: scored, validated and judged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING

from ..space import Array
from .adequacy.advice import with_effects
from .adequacy.effects import Effects, effects
from .adequacy.equation_error import equation_error
from .adequacy.generalisation import held_out_violations
from .adequacy.neighbours import neighbour_violations
from .combinations import Combination, combinations
from .conditions import Violation, lowered, sentences
from .constants_report import borrowed, with_rulings
from .contested_values import contested_by_motion, value_slopes
from .data_check import data_violations, trained_samples
from .delay_advice import with_delay
from .exact_constants import Slopes, exact_constants, exact_slopes
from .fit_warnings import (
    misfit_violations,
    noise_floor,
    output_error_warnings,
    shared_directions,
)
from .free_constants import FreeConstantsProblem, Ruling, rulings, stated_by_logs
from .hidden_play import hidden_play
from .initial_state import FreeStartProblem
from .log_spread import LogSpreads, log_spreads, spread_over_logs
from .motion_delay import MotionDelay, motion_delay
from .multistart import Optimum
from .other_loss import other_loss_violations
from .position_drift import drift_violations
from .ratios import Ratio, proportional, ratios
from .result import Fit
from .score import HeldOut, Score, held_out, scores
from .segment import SegmentSplit, recordings_of
from .single_logs import single_logs
from .sliding_check import mark_never_slid
from .slip_by_slip import fitted_spreads
from .tipping import tipping_violations
from .uncertainty.assessment import Uncertainty
from .uncertainty.estimates import (
    Estimate,
    bound_warnings,
    correlation_warnings,
    estimates,
    resting,
    without_levels_of_an_unseen_drop,
    without_partners,
)

if TYPE_CHECKING:
    from ..data.recording import Recording
    from .arithmetic import Checked
    from .data_split import DataSplit
    from .parameters import Parameters
    from .problem import MotionProblem
    from .segment import Segment
    from .work import Work


@dataclass(frozen=True, eq=False)
class _SolvedProblem:
    """A least-misfit parameter set, and the motions that it was fitted to.

    Args:
        optimum: Where the search ended.
        uncertain: How well its parameters are known.
        problem: The motion problem, its uncertain constants as they were estimated.
        x: The solution in it, SI: free parameters, and the starts of motions where these are free.
        p: The complete parameter set, SI, (k,).
        train: The segments trained on, from the starts estimated.
        score: Misfit there.
    """

    optimum: Optimum
    uncertain: Uncertainty
    problem: MotionProblem | FreeStartProblem
    x: Array
    p: Array
    train: tuple[Segment, ...]
    score: Score

    @property
    def parameters(self) -> Parameters:
        return self.problem.parameters

    @property
    def logs(self) -> list[Recording]:
        return recordings_of(self.train)

    @property
    def correlation(self) -> Array:
        """Of the free parameters' estimates, (dim, dim)."""
        dim = len(self.parameters.free)
        return self.uncertain.correlation[:dim, :dim]


@dataclass(frozen=True, eq=False)
class _Judgement:
    """The estimates of a solved problem with their verdicts, and what these rest on.

    Args:
        estimates: As in `parameters.every`.
        violations: Conditions that do not hold.
        effects: What the residual forces show; None where the rig cannot say.
        combinations: Sums of a parameter and a constant that are known better.
        differing: What the logs give one by one.
        slopes: Of the parameters over exact constants and values set.
        ratios: Of parameters that an uncertain scale of all forces leaves as they are.
    """

    estimates: tuple[Estimate, ...]
    violations: tuple[Violation, ...]
    effects: Effects | None
    combinations: tuple[Combination, ...]
    differing: LogSpreads
    slopes: Slopes
    ratios: tuple[Ratio, ...]


def output_error_fit(
    checked: Checked,
    data: DataSplit,
    segments: SegmentSplit,
    work: Work,
    answers: Mapping[int, Array] = MappingProxyType({}),
) -> Fit:
    """The fit of a least-misfit parameter set: scored, validated and judged.

    Args:
        checked: Where the search ended, how well its parameters are known (its `x` is the
            solution), and what is to be told of the arithmetic.
        data: What was trained on and held out.
        segments: The same as segments.
        work: What has been spent so far; once interrupted, the fit is judged without what takes
            further simulations.
        answers: What a search has for single logs; see `answers_alone`.
    """
    optimum, uncertain, arithmetic = checked
    solved = _solved(optimum, uncertain)
    parameters, p = solved.parameters, solved.p
    holdout = tuple(held_out(parameters, p, r, s) for r, s in segments.holdout)
    judgement = _judged(solved, data, arithmetic, holdout, answers, work)
    search = optimum.search
    if work.interrupted:
        search = replace(search, ended="interrupted")
    return Fit(
        parameters=parameters,
        p=p,
        estimates=judgement.estimates,
        correlation=solved.correlation,
        score=solved.score,
        holdout=holdout,
        search=search,
        train=solved.train,
        train_ranges=data.train,
        recordings=data.recordings,
        warnings=_warnings(solved, judgement, data, segments, interrupted=work.interrupted),
        uncertainty=replace(uncertain, rows=work.rows),
        residuals=optimum.problem,
        violations=judgement.violations,
        effects=judgement.effects,
        delay=data.delay,
        combinations=judgement.combinations,
        ratios=judgement.ratios,
        breakaway=fitted_spreads(parameters, p, solved.train, uncertain.profiles),
        differing=judgement.differing,
    )


def _solved(optimum: Optimum, uncertain: Uncertainty) -> _SolvedProblem:
    problem, x = optimum.problem, uncertain.x
    if isinstance(problem, FreeConstantsProblem):
        problem, x = problem.at(x)
    motion = problem.at(x)[0] if isinstance(problem, FreeStartProblem) else problem
    parameters = problem.parameters
    p = parameters.full(x[None, : len(parameters.free)])[0]
    score = scores(parameters, p, motion.train)
    return _SolvedProblem(optimum, uncertain, problem, x, p, motion.train, score)


def _judged(
    solved: _SolvedProblem,
    data: DataSplit,
    arithmetic: Sequence[Violation],
    holdout: Sequence[HeldOut],
    answers: Mapping[int, Array],
    work: Work,
) -> _Judgement:
    optimum, parameters, logs = solved.optimum, solved.parameters, solved.logs
    problem, x, score = solved.problem, solved.x, solved.score
    ruled, sums = _ruled(solved, work)
    judged = estimates(
        parameters, solved.p, solved.uncertain, optimum.spread, resting=resting(problem, x)
    )
    differing = work.result(partial(_log_by_log, solved, answers), LogSpreads())
    judged, between = spread_over_logs(parameters, judged, differing)
    misfit = misfit_violations(
        parameters, score, data.recordings, judged, optimum.rivals, optimum.repeats
    )
    refits: list[Violation] = work.result(partial(_refits, solved, judged, rough=bool(misfit)), [])
    late: MotionDelay | None = work.result(
        partial(motion_delay, problem, x, judged, data.delay_known), None
    )
    judged, sums, delayed = with_delay(problem, judged, sums, late)
    trained = trained_samples(data.recordings, solved.train)
    violations = [
        *arithmetic,
        *data_violations(parameters.rig, data.recordings, trained),
        *misfit,
        *between,
        *refits,
        *delayed,
    ]
    judged = mark_never_slid(parameters, judged, logs)
    judged = with_rulings(parameters, judged, ruled)
    slopes: Slopes = work.result(partial(exact_slopes, problem, x), {})
    slopes = {**slopes, **work.result(partial(value_slopes, problem, x), {})}
    left_over = work.result(partial(_left_over, solved, judged), None)
    judged, inadequate = with_effects(parameters, judged, left_over, logs)
    violations += [
        *inadequate,
        *neighbour_violations(parameters, logs),
        *held_out_violations(score, holdout),
    ]
    scaled = proportional(parameters, solved.p, _slopes(ruled))
    of_scale = ratios(parameters, judged, solved.correlation, scaled, common=True)
    judged = lowered(parameters, judged, violations)
    judged = without_partners(parameters, judged, solved.correlation)
    judged = without_levels_of_an_unseen_drop(parameters, judged)
    return _Judgement(judged, tuple(violations), left_over, sums, differing, slopes, of_scale)


def _slopes(ruled: Sequence[Ruling]) -> Slopes:
    """Slopes of parameters over constants, by the names of both."""
    slopes: dict[str, dict[str, float]] = {}
    for r in ruled:
        slopes.setdefault(r.constant, {})[r.parameter] = r.slope
    return slopes


def _ruled(solved: _SolvedProblem, work: Work) -> tuple[list[Ruling], tuple[Combination, ...]]:
    """How uncertain constants move the parameters, and sums with these that are known better."""
    problem, uncertain = solved.optimum.problem, solved.uncertain
    if not isinstance(problem, FreeConstantsProblem):
        return [], ()
    ruled = rulings(problem, uncertain.x, uncertain.profiles.quick.curvature)
    return ruled, work.result(partial(combinations, problem, ruled, uncertain.x), ())


def _log_by_log(solved: _SolvedProblem, answers: Mapping[int, Array]) -> tuple[LogSpreads, int]:
    """What the logs give one by one; and the rows evaluated."""
    parameters = solved.parameters
    parts = single_logs(solved.problem, solved.x, answers)
    errors = solved.uncertain.errors[: len(parameters.free)]
    differing = log_spreads(parameters, parts, errors)
    return differing, differing.rows


def _refits(
    solved: _SolvedProblem, judged: Sequence[Estimate], *, rough: bool
) -> tuple[list[Violation], int]:
    """What refits and motions beside it tell; and the rows evaluated.

    Args:
        solved: The fit.
        judged: The estimates.
        rough: Whether the misfit is beyond the noise: only then the other loss is tried, and logs
            that tip are looked for.
    """
    problem, x, optimum = solved.problem, solved.x, solved.optimum
    refits = [
        contested_by_motion(
            optimum.problem,
            solved.uncertain.x,
            judged,
            noise_floor(solved.parameters.rig, solved.logs),
        ),
        drift_violations(problem, x, judged),
    ]
    motion = problem.at(x)[0] if isinstance(problem, FreeStartProblem) else problem
    refits.append(hidden_play(motion, x[: len(motion.parameters.free)], rough=rough))
    if rough:
        refits.append(
            other_loss_violations(optimum.problem, solved.uncertain.x, judged, optimum.search.runs)
        )
        refits.append(tipping_violations(problem, x))
    return [v for violations, _ in refits for v in violations], sum(rows for _, rows in refits)


def _left_over(solved: _SolvedProblem, judged: Sequence[Estimate]) -> tuple[Effects | None, int]:
    """What the forces that the model leaves over go with; and no row of the residuals."""
    forces = equation_error(solved.parameters, solved.p, solved.train, judged)
    return None if forces is None else effects(forces), 0


def _warnings(
    solved: _SolvedProblem,
    judgement: _Judgement,
    data: DataSplit,
    segments: SegmentSplit,
    *,
    interrupted: bool,
) -> tuple[str, ...]:
    parameters, judged, optimum = solved.parameters, judgement.estimates, solved.optimum
    unfinished = (
        "interrupted: the search, its polishing, its intervals or their checks had not ended"
    )
    stated = stated_by_logs(solved.problem)
    shared = shared_directions(parameters, segments.train)
    rough = any(v.condition == "model" for v in judgement.violations)
    return (
        *([unfinished] if interrupted else []),
        *(shared if rough else []),
        *sentences(judgement.violations),
        *bound_warnings(judged),
        *borrowed(optimum.problem),
        *exact_constants(parameters, judged, judgement.slopes, stated),
        *correlation_warnings(parameters, solved.correlation),
        *output_error_warnings(
            parameters, solved.score, segments, data.recordings, optimum.rivals, optimum.repeats
        ),
        *([] if rough else shared),
        *solved.uncertain.notes(parameters),
    )
