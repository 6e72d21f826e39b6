"""Identification by force balance: the misfit is that of the measured force."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...data.alignment import Delay
from ...data.freed_memory import release
from ...data.ranges import Range
from ...data.recording import Recording
from ...errors import InputError
from ...space import Array
from ..adequacy.advice import recurrence_violations, with_effects
from ..adequacy.effects import Effects, effects
from ..adequacy.generalisation import held_out_violations
from ..adequacy.neighbours import neighbour_violations
from ..conditions import lowered, sentences
from ..contested_values import contested
from ..data_split import DataSplit
from ..exact_constants import Slopes, exact_constants, scale
from ..held_out_scope import held_out_scope
from ..log_spread import LogPart, LogSpreads, log_spreads, spread_over_logs
from ..parameters import Parameters
from ..ratios import proportional, ratios
from ..result import Fit, SearchRecord
from ..score import HeldOut, Score
from ..uncertainty.assessment import Uncertainty, uncertainty
from ..uncertainty.estimates import (
    Estimate,
    bound_warnings,
    correlation_warnings,
    estimates,
)
from . import balance
from .balance import Balance
from .balance_rows import balance_rows
from .checks import BalanceChecks, check_balance
from .constant_slopes import constant_slopes, with_tolerances
from .contested_force import SetValues, set_values
from .counted_twice import twice_violations
from .force_residuals import BalanceResiduals
from .known_load import load_notes
from .known_mass import calibration, mass_violations
from .noisier_balance import NoisierBalance
from .one_way import moves_one_way, one_way_violations, without_offset
from .regression import System
from .sensor_bias import SensorBias, sensor_bias
from .synchronisation import synchronised
from .training_rows import counting
from .velocity_source import VelocitySource

#: What the misfit of a force balance is called.
MISFIT = "the force error"


def solve_balance(
    parameters: Parameters,
    data: DataSplit,
    *,
    draws: int = 0,
    delay: Delay = "auto",
    velocity: VelocitySource = "auto",
) -> Fit:
    """Solve the force balance of one or several logs, profile and check it.

    Args:
        parameters: Of a law on a rig with a measured force.
        data: What to train on and to hold out.
        draws: Data sets of a block bootstrap.
        delay: Of the force after the motion; see `synchronised`.
        velocity: Where it comes from; see `with_velocity`.

    Raises:
        InputError: no measured force, a range without motion, or too few rows.
    """
    return fit_with_set_values(
        parameters, draws, lambda asked, drawn: _solved(asked, data, drawn, delay, velocity)
    )


def _solved(
    parameters: Parameters, data: DataSplit, draws: int, delay: Delay, velocity: VelocitySource
) -> SolvedLogs:
    """The force balance of `solve_balance` with all that its fit is judged by."""
    synchrony = synchronised(parameters, data, delay, velocity)
    if moves_one_way(synchrony.solved.system):
        without = without_offset(parameters)
        if without is not parameters:
            synchrony = synchronised(without, data, delay, velocity)
    parameters = synchrony.solved.system.parameters
    solved = synchrony.solved
    residuals = BalanceResiduals(solved.system)
    x = solved.values[parameters.free_places]
    uncertain = uncertainty(residuals, x, keep=True, draws=draws).without_rows()
    noisier = NoisierBalance(solved, synchrony.recordings, synchrony.rows)
    bias = sensor_bias(solved, synchrony.recordings, noisier)
    slopes = constant_slopes(
        solved,
        lambda p: balance.balance(
            synchrony.recordings, p, rows=synchrony.rows, start=solved.values
        ),
    )
    differing = log_spreads(
        parameters,
        log_parts(synchrony.recordings, solved, x),
        solved.robust_errors[parameters.free_places],
    )
    checks = check_balance(synchrony, differing, bias)

    def seen(judged: Sequence[Estimate]) -> Effects:
        release(solved.system.samples)
        return effects(balance_rows(solved, judged, bias, noisier))

    return SolvedLogs(
        synchrony.data, synchrony.recordings, solved, residuals, uncertain, checks, slopes,
        differing, seen, bias,
    )  # fmt: skip


def log_parts(recordings: Sequence[Recording], solved: Balance, x: Array) -> list[LogPart]:
    """The logs of a balance, each by itself, at its solution x."""
    system = solved.system
    return [
        LogPart(recording, BalanceResiduals(System(system.parameters, [log], system.prior)), x)
        for recording, log in zip(recordings, system.logs, strict=True)
    ]


@dataclass(frozen=True, eq=False)
class SolvedLogs:
    """A solved force balance with all that its fit is judged by.

    Args:
        data: What was trained on and held out.
        recordings: The logs trained on, as they were balanced.
        solved: Their balance.
        residuals: The problem of its residuals.
        uncertain: Profiles of its parameters.
        checks: The faults of the logs, and errors that allow for them.
        slopes: Of the parameters over the constants of the rig.
        differing: What the logs give one by one.
        effects: What the residual shows of what the model leaves out, of the estimates.
        bias: What the error of the motion has moved the estimates by; None where by nothing.
        set_values: What it owes to the parameters that are set.
    """

    data: DataSplit
    recordings: tuple[Recording, ...]
    solved: Balance
    residuals: BalanceResiduals
    uncertain: Uncertainty
    checks: BalanceChecks
    slopes: Slopes
    differing: LogSpreads
    effects: Callable[[Sequence[Estimate]], Effects]
    bias: SensorBias | None = None
    set_values: SetValues = field(default_factory=SetValues)


def fit_with_set_values(
    parameters: Parameters, draws: int, solve: Callable[[Parameters, int], SolvedLogs]
) -> Fit:
    """The fit of a force balance, the parameters that are set held against its logs.

    Args:
        parameters: As they were asked for.
        draws: Data sets of a block bootstrap.
        solve: Solves the balance of these or others, with so many draws.
    """
    logs = solve(parameters, draws)
    values = set_values(parameters, logs.solved, lambda freed: balance_fit(solve(freed, 0)))
    return balance_fit(replace(logs, set_values=values))


def balance_fit(logs: SolvedLogs) -> Fit:
    """The fit of a solved force balance: scored, validated and judged."""
    data, recordings, bias = logs.data, logs.recordings, logs.bias
    solved = logs.solved if bias is None else bias.without(logs.solved)
    residuals, uncertain, checks = logs.residuals, logs.uncertain, logs.checks
    slopes, differing = logs.slopes, logs.differing
    parameters, p, stops = solved.system.parameters, solved.values, solved.at_bound
    ends = {n: at for n, at in stops.items() if at in ("lower", "upper")}
    others = {n: at for n, at in stops.items() if n not in ends}
    unwidened = estimates(
        parameters,
        logs.solved.values,
        uncertain,
        errors=solved.standard_errors[parameters.free_places],
        ends=ends,
        resting=others,
        misfit=MISFIT,
    )
    widened = checks.widened(parameters, logs.solved, unwidened)
    if bias is not None:
        widened = bias.moved(widened, parameters.every)
    judged, between = spread_over_logs(parameters, widened, differing)
    unscaled, judged = judged, with_tolerances(parameters, judged, slopes)
    seen = logs.effects(judged)
    unscaled, _ = with_effects(parameters, unscaled, seen, recordings)
    judged, inadequate = with_effects(parameters, judged, seen, recordings)
    misloaded, loaded = load_notes(parameters, recordings, differing)
    scaled = proportional(parameters, p, slopes)
    score = _score(solved)
    holdout = tuple(_held_out(parameters, p, data.recordings, r) for r in data.holdout)
    contests = {
        violation: value
        for value in logs.set_values.freed
        if (violation := contested(parameters, value, judged)) is not None
    }
    explained = inadequate if any(value.adequate for value in contests.values()) else ()
    violations = (
        *contests,
        *one_way_violations(parameters),
        *checks.violations,
        *(() if bias is None else bias.violations(logs.solved, judged)),
        *between,
        *inadequate,
        *recurrence_violations(parameters, judged, seen),
        *neighbour_violations(parameters, recordings),
        *twice_violations(solved),
        *mass_violations(parameters, judged, scaled),
        *misloaded,
        *held_out_violations(score, holdout),
    )
    judged = lowered(parameters, judged, violations)
    correlation = _correlation(solved.covariance)
    label = parameters.rig.label
    warnings = [
        *sentences([v for v in violations if v not in explained]),
        *bound_warnings(judged),
        *(
            f"{label(n)} was stopped by {label(at)}: the data would have it below"
            for n, at in others.items()
        ),
        *correlation_warnings(parameters, correlation),
        *exact_constants(parameters, judged, {**slopes, **logs.set_values.slopes}),
        *scale(parameters.rig),
        *calibration(parameters, unscaled),
        *loaded,
        *uncertain.notes(parameters, MISFIT),
        *solved.notes,
    ]
    return Fit(
        parameters=parameters,
        p=p,
        estimates=judged,
        correlation=correlation,
        score=score,
        holdout=holdout,
        search=SearchRecord("least squares", None, (), (), 0, 0.0, "solved"),
        train=(),
        train_ranges=data.train,
        recordings=recordings,
        warnings=tuple(dict.fromkeys(warnings)),
        uncertainty=uncertain,
        residuals=residuals,
        balance=solved,
        violations=violations,
        effects=seen,
        delay=data.delay,
        differing=differing,
        ratios=ratios(parameters, unscaled, correlation, scaled),
    )


def _correlation(covariance: Array) -> Array:
    """The correlation that a covariance holds; 0 where the data see nothing of a parameter."""
    spread = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation: Array = covariance / np.outer(spread, spread)
    correlation[~np.isfinite(correlation)] = 0.0
    np.fill_diagonal(correlation, 1.0)
    return correlation


def balance_scores(parameters: Parameters, p: Array, log: Recording, part: Range | None) -> Score:
    """The relative error of the force of a parameter set (SI) on a log or a range of it."""
    return _held_out(parameters, p, [log], part).score


def _held_out(
    parameters: Parameters, p: Array, logs: Sequence[Recording], part: Range | None
) -> HeldOut:
    chosen, rows = counting(logs, [] if part is None else [part])
    try:
        prediction = balance.validate(chosen, parameters, p, rows=rows)
    except InputError as error:
        if part is None:
            raise
        raise InputError(f"range {part.text}: {error}") from error
    scope = held_out_scope(
        ((log, slice(None) if r is None else r) for log, r in zip(chosen, rows, strict=True)),
        parameters.rig,
    )
    return HeldOut(part, _score(prediction), (), (), scope)


def _score(prediction: balance.Prediction) -> Score:
    nan = float("nan")
    return Score("relative_error", prediction.relative_error, "%", nan, nan, prediction.rows)
