"""Force balance: friction, mass and offset from the balance of a measured force.

For each sample, force = M a + F_f(v) + offset. Velocity and acceleration come from the filtered
position (`Filtering`), both sides are decimated in parallel, and what is linear in the parameters
is solved by least squares: the inverse dynamic identification model of M. Gautier, as used by the
EMPS report (Janot, Gautier, Brunot 2019). Parameters that shape the curve (v_SS, an exponent) are
searched around it by variable projection (Golub and Pereyra 1973, doi 10.1137/0710036).

A law with states is driven along the measured motion, rests and reversals included
(`rig.measured_path`), and searched from what the spectrum of the contact shows (`state_starts`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...data.filtering import Filtering
from ...errors import InputError
from ...space import Array
from ...wording import option
from . import variable_projection
from .curve_prior import with_knots, with_prior
from .modelled_force import friction_under
from .position_waves import wave_start
from .regression import System
from .rows import Log, Rows, filtered_logs
from .settled_rows import settled
from .state_starts import state_starts, within_force

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ...data.zero_phase import Samples
    from ..parameters import Parameters

__all__ = ["Balance", "Prediction", "Rows", "Signals", "balance", "validate"]

#: Beyond this, some parameter's error is mostly another one's (Belsley, Kuh, Welsch 1980).
COLLINEAR = 30.0
#: A relative error above this, percent, explains nothing: no parameter counts as identified,
#: however small its standard error, and no delay is certain.
NOTHING = 50.0
#: Rows per parameter below which standard errors are too small.
_FEW = 10


@dataclass(frozen=True, eq=False)
class Signals:
    """One log's force balance, for figures; SI, (rows,) each, decimation's gain divided out.

    Args:
        t: Time.
        velocity: Filtered.
        acceleration: Filtered.
        measured: Measured force.
        predicted: Force of the model.
        friction: Measured force less M a and offset: points to draw beside the friction curve.
    """

    t: Array
    velocity: Array
    acceleration: Array
    measured: Array
    predicted: Array
    friction: Array


@dataclass(frozen=True, eq=False)
class Prediction:
    """How well parameters explain a log's force.

    Args:
        relative_error: 100 ||measured − predicted|| / ||measured||, percent.
        residual_sd: Standard deviation of the residual, N (N m), after decimation.
        rows: Rows compared.
        notes: What was done to the logs or is doubtful about them, a sentence each.
        system: The balance that was solved, or that the parameters are held against.
        values: The parameters, the law's, then the rig's own, SI, (k,).
    """

    relative_error: float
    residual_sd: float
    rows: int
    notes: tuple[str, ...]
    system: System = field(repr=False)
    values: Array

    @cached_property
    def signals(self) -> tuple[Signals, ...]:
        """For figures, one a log."""
        return tuple(_signals(self.system, log, self.values) for log in self.system.logs)


@dataclass(frozen=True, eq=False)
class Balance(Prediction):
    """What a force balance found.

    Args:
        names: All parameters: the law's, then the rig's own.
        free: Names of those that were found; the others were fixed or tied.
        standard_errors: (k,), those of the report: residual_sd² (WᵀW)⁻¹, as if residuals were
            white, so too small where the model leaves something out. inf where the data cannot
            see the parameter or a bound has set it, nan where it was fixed or tied.
        robust_errors: (k,), the same for residuals as correlated as they are (Newey and West
            1987, doi 10.2307/1913610), never below `standard_errors`. On the EMPS log they are
            two to seven times those.
        covariance: Of the free parameters; inf and nan in the rows of such parameters.
        condition: Condition number of the regressor W in SI, as the literature prints it.
        collinearity: The same with columns of one length, which no unit can change: above 30,
            some parameter stands in for another.
        at_bound: What a parameter was stopped by: `lower`, `upper`, or the parameter that it may
            not fall below.
        jacobian: d predicted / d free, (rows, free), after decimation.
        residuals: Measured less predicted, (rows,), after decimation.
    """

    names: tuple[str, ...]
    free: tuple[str, ...]
    standard_errors: Array
    robust_errors: Array
    covariance: Array = field(repr=False)
    condition: float
    collinearity: float
    at_bound: Mapping[str, str]
    jacobian: Array = field(repr=False)
    residuals: Array = field(repr=False)

    def figures(self) -> dict[str, float]:
        """What the literature prints beside a force balance, percent and SI."""
        return {
            "relative_error_percent": self.relative_error,
            "residual_sd": self.residual_sd,
            "condition": self.condition,
            "collinearity": self.collinearity,
            "rows": float(self.rows),
            **{
                f"{name} {log.label}": value
                for log in self.system.logs
                for name, value in log.figures.items()
            },
        }

    def __getitem__(self, name: str) -> float:
        """A parameter's value, SI."""
        return float(self.values[self.names.index(name)])

    def standard_error(self, name: str) -> float:
        """A parameter's standard error, SI."""
        return float(self.standard_errors[self.names.index(name)])


def balance(
    recordings: Recording | Sequence[Recording],
    parameters: Parameters,
    *,
    filtering: Filtering | None = None,
    rows: Sequence[Rows | None] | None = None,
    start: Array | None = None,
) -> Balance:
    """Find a law's parameters and the rig's own from the measured force of one or several logs.

    Args:
        recordings: One or several logs of the axis; they are stacked.
        parameters: Of a law on a rig with a measured force. All ranges hold, and so does the law's
            `physical` order.
        filtering: How the logs are filtered; by default the rig's way.
        rows: For each log, which of its samples count: a mask or a slice; None for all. Applied
            after filtering, so that filters see no edges.
        start: (k,) a set, SI, from which the parameters that shape the curve are searched; by
            default from a grid over their ranges, or from what the residual shows of waves over
            position (`position_waves`).

    Raises:
        InputError: no measured force, too few rows, or nothing left to find.
    """
    return solved(System(parameters, filtered_logs(recordings, parameters, filtering, rows)), start)


def solved(system: System, start: Array | None = None) -> Balance:
    """The balance of filtered logs, as `balance`.

    Args:
        system: The logs and the model.
        start: As of `balance`.

    Raises:
        InputError: too few rows.
    """
    system = with_knots(system)
    parameters = system.parameters
    if len(system.y) <= len(system.free):
        raise InputError(_too_few(system))
    if start is None and system.law.states:
        system = System(within_force(system), system.logs)
        parameters, start = system.parameters, state_starts(system)
    elif start is None:
        start = wave_start(system)
    system = with_prior(system)
    p, at_bound = system.solved(start)
    if system.law.states and (fewer := settled(system, p)) is not system:
        system = fewer
        p, at_bound = system.solved(p)
    free, names = system.free, parameters.names
    W = system.jacobian(p)
    predicted = prediction(system, p)
    # Of the shape of a curve that has no drop the data say nothing: no end of a range stopped it.
    unseen = {names[i] for k, i in enumerate(free) if i in system.shape and not W[:, k].any()}
    at_bound = {n: stop for n, stop in at_bound.items() if n not in unseen}
    stopped = [i for i, place in enumerate(free) if names[place] in at_bound]
    beside = np.vstack([W, system.free_prior])
    covariance = variable_projection.covariance(beside, predicted.residual_sd, stopped)
    residuals = system.y - system.predicted(p[None])[:, 0]
    logs = [len(log.t) for log in system.logs]
    robust = np.sqrt(variable_projection.robust_variances(W, residuals, logs, system.free_prior))
    errors, wide = np.full((2, len(p)), np.nan)
    errors[free] = np.sqrt(np.diag(covariance))
    wide[free] = np.fmax(errors[free], robust)
    return Balance(
        relative_error=predicted.relative_error,
        residual_sd=predicted.residual_sd,
        rows=predicted.rows,
        notes=(
            *predicted.notes,
            *_warnings(system, W, covariance, at_bound),
        ),
        system=system,
        values=p,
        names=names,
        free=tuple(q.name for q in parameters.free),
        standard_errors=errors,
        robust_errors=wide,
        covariance=covariance,
        condition=variable_projection.condition(W),
        collinearity=variable_projection.collinearity(W),
        at_bound=at_bound,
        jacobian=W,
        residuals=residuals,
    )


def _too_few(system: System) -> str:
    """Why the rows cannot tell the parameters, and what gives more."""
    log, rows, count = system.logs[0], len(system.y), len(system.free)
    if log.weight is not None:
        many, more = f"{rows} runs", "give more of them"
    else:
        many, more = (
            f"{rows} rows, one every {1 / log.row_rate:.3g} s,",
            "widen the range, log more motion",
        )
    return (
        f"{log.label}: {many} cannot tell {count} parameters: {more}, or hold parameters with "
        f"{option('fixed')}"
    )


def validate(
    recordings: Recording | Sequence[Recording],
    parameters: Parameters,
    p: Array,
    *,
    filtering: Filtering | None = None,
    rows: Sequence[Rows | None] | None = None,
) -> Prediction:
    """How well given parameters explain the force of other logs, through the same filtering.

    Args:
        recordings: One or several logs.
        parameters: Rig and law; which of them are free is of no account.
        p: (k,) the law's parameters, then the rig's own, SI.
        filtering: As for `balance`.
        rows: As for `balance`.
    """
    system = System(parameters, filtered_logs(recordings, parameters, filtering, rows))
    p = np.asarray(p, dtype=float)
    return prediction(settled(system, p) if system.law.states else system, p)


def prediction(system: System, p: Array) -> Prediction:
    """How well a complete set explains the logs."""
    residuals = system.y - system.predicted(p[None])[:, 0]
    size = float(np.linalg.norm(system.y))
    return Prediction(
        relative_error=100 * float(np.linalg.norm(residuals)) / size if size > 0 else float("inf"),
        residual_sd=float(np.std(residuals, ddof=1)),
        rows=len(system.y),
        notes=tuple(note for log in system.logs for note in log.notes),
        system=system,
        values=p,
    )


def _signals(system: System, log: Log, p: Array) -> Signals:
    rig, law = system.rig, system.law

    friction = friction_under(rig, law, log, p)

    def forces(at: Samples) -> Array:
        motion = log.motion(at)
        rub = friction(at, motion)
        model = rig.force(law, p, *motion, rub)
        return np.column_stack([model, model - rub])

    gain = log.gain
    predicted, inertial = log.thin(forces).T / gain
    measured = log.force / gain
    return Signals(
        t=log.t,
        velocity=log.pick(log.v),
        acceleration=log.pick(log.a),
        measured=measured,
        predicted=predicted,
        friction=measured - inertial,
    )


def _warnings(
    system: System, W: Array, covariance: Array, at_bound: Mapping[str, str]
) -> list[str]:
    """What a reader must know about the estimates, a sentence each."""
    label, free = system.rig.label, system.parameters.free
    names = [label(q.name) for q in free]
    warnings = [
        f"{name} cannot be identified from this data"
        for q, name, variance in zip(free, names, np.diag(covariance), strict=True)
        if not np.isfinite(variance) and q.name not in at_bound
    ]
    identified = [i for i in range(len(names)) if np.isfinite(covariance[i, i])]
    if identified and (degree := variable_projection.collinearity(W[:, identified])) > COLLINEAR:
        warnings.append(
            f"the data hardly tells the parameters apart (scaled condition number {degree:.3g}): "
            "their standard errors say how far each may be off"
        )
    # Intervals of a table of steady speeds are Student's.
    if len(W) < _FEW * len(names) and any(log.weight is None for log in system.logs):
        warnings.append(f"{len(W)} rows for {len(names)} parameters: standard errors are too small")
    return warnings
