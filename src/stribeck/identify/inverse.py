"""The inverse road: friction, mass and offset from the balance of a measured force.

For each sample, force = M a + F_f(v) + offset. Velocity and acceleration come from the filtered
position (`Filtering`), both sides are decimated in parallel, and what is linear in the parameters
is solved by least squares: the inverse dynamic identification model of M. Gautier, as used by the
EMPS report (Janot, Gautier, Brunot 2019). Parameters that shape the curve (v_SS, an exponent) are
searched around it by variable projection (Golub and Pereyra 1973, doi 10.1137/0710036).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..data.filtering import DECIMATION_GAIN, Filtering, decimate, even, kept, smooth
from ..errors import InputError
from ..rig.forced import Forced
from ..space import Array, Param, Space
from . import separable

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..data.recording import Recording
    from ..friction import Law

#: Samples of a log that count: a mask over them or a slice of them.
Rows = slice | Array

#: Beyond this, some parameter's error is mostly another one's (Belsley, Kuh, Welsch 1980).
COLLINEAR = 30.0
#: A relative error above this, percent, is told: the report's models leave 3 to 6.
UNEXPLAINED = 25.0
#: Rows per parameter below which standard errors are too small.
_FEW = 10
#: A row is at rest below this share of the top speed; worth a note if more than that share are.
_REST_SPEED, _REST_SHARE = 0.005, 0.1
#: Step of a shape parameter for the Jacobian, as a share of its value.
_STEP = 1e-4


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
        signals: One a log.
        notes: What was done to the logs or is doubtful about them, a sentence each.
    """

    relative_error: float
    residual_sd: float
    rows: int
    signals: tuple[Signals, ...] = field(repr=False)
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Balance(Prediction):
    """What a force balance found.

    Args:
        names: All parameters: the law's, then the rig's own.
        values: Theirs, SI, (k,).
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
    values: Array
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
        }

    def __getitem__(self, name: str) -> float:
        """A parameter's value, SI."""
        return float(self.values[self.names.index(name)])

    def standard_error(self, name: str) -> float:
        """A parameter's standard error, SI."""
        return float(self.standard_errors[self.names.index(name)])


def balance(
    recordings: Recording | Sequence[Recording],
    law: Law,
    rig: Forced,
    *,
    filtering: Filtering | None = None,
    params: Sequence[Param] | None = None,
    tied: Mapping[str, str] | None = None,
    rows: Sequence[Rows | None] | None = None,
) -> Balance:
    """Find a law's parameters and the rig's own from the measured force of one or several logs.

    Args:
        recordings: One or several logs of the axis; they are stacked.
        law: Any friction law.
        rig: The axis.
        filtering: How the logs are made ready; by default the rig's.
        params: Ranges and fixed values, in the order of `rig.parameters(law)`, which is the
            default. All ranges hold, and so does the law's `physical` order.
        tied: `{"F_V-": "F_V+"}` makes the first equal the second.
        rows: For each log, which of its samples count: a mask or a slice; None for all. Applied
            after filtering, so that filters see no edges.

    Raises:
        InputError: no measured force, too few rows, or nothing left to find.
    """
    wanted = _Wanted(law, rig, tuple(params or rig.parameters(law)), dict(tied or {}))
    logs = _logs(recordings, rig, filtering, rows)
    system = _System(wanted, logs)
    if len(system.y) <= len(wanted.free):
        raise InputError(
            f"{len(system.y)} rows cannot tell {len(wanted.free)} parameters: "
            "give more data, or decimate less"
        )
    p, at_bound = system.solved()
    W = system.jacobian(p)
    seen = system.judge(p)
    stopped = [i for i, at in enumerate(wanted.free) if wanted.names[at] in at_bound]
    covariance = separable.covariance(W, seen.residual_sd, stopped)
    residuals = system.y - system.predicted(p[None])[:, 0]
    robust = separable.sandwich(W, residuals, [len(log.t) for log in logs])
    errors, wide = np.full((2, len(p)), np.nan)
    errors[wanted.free] = np.sqrt(np.diag(covariance))
    wide[wanted.free] = np.fmax(errors[wanted.free], np.sqrt(np.diag(robust)))
    return Balance(
        relative_error=seen.relative_error,
        residual_sd=seen.residual_sd,
        rows=seen.rows,
        signals=seen.signals,
        notes=(*seen.notes, *_doubts(wanted, W, covariance, at_bound, seen.relative_error)),
        names=wanted.names,
        values=p,
        free=tuple(wanted.names[i] for i in wanted.free),
        standard_errors=errors,
        robust_errors=wide,
        covariance=covariance,
        condition=separable.condition(W),
        collinearity=separable.collinearity(W),
        at_bound=at_bound,
        jacobian=W,
        residuals=residuals,
    )


def validate(
    recordings: Recording | Sequence[Recording],
    law: Law,
    rig: Forced,
    p: Array,
    *,
    filtering: Filtering | None = None,
    rows: Sequence[Rows | None] | None = None,
) -> Prediction:
    """How well given parameters explain the force of other logs, through the same filtering.

    Args:
        recordings: One or several logs.
        law: The friction law.
        rig: The axis.
        p: (k,) the law's parameters, then the rig's own, SI.
        filtering: As for `balance`.
        rows: As for `balance`.
    """
    wanted = _Wanted(law, rig, rig.parameters(law), {})
    system = _System(wanted, _logs(recordings, rig, filtering, rows))
    return system.judge(np.asarray(p, dtype=float))


@dataclass(frozen=True, eq=False)
class _Log:
    """A log made ready: v and a at its full rate, t and force at the rows that count."""

    v: Array
    a: Array
    factor: int
    counts: NDArray[np.bool_]
    t: Array
    force: Array
    notes: tuple[str, ...]

    def thin(self, x: Array) -> Array:
        """Full-rate columns (N, ...) decimated, and only the rows that count."""
        thinned: Array = decimate(x, self.factor)[self.counts]
        return thinned

    def pick(self, x: Array) -> Array:
        """The samples of a full-rate signal at the rows, as they are."""
        picked: Array = x[kept(len(x), self.factor)][self.counts]
        return picked


def _logs(
    recordings: Recording | Sequence[Recording],
    rig: Forced,
    filtering: Filtering | None,
    rows: Sequence[Rows | None] | None,
) -> list[_Log]:
    logs = list(recordings) if isinstance(recordings, Sequence) else [recordings]
    if not logs:
        raise InputError("no recording was given")
    rows = [None] * len(logs) if rows is None else rows
    if len(rows) != len(logs):
        raise InputError(f"rows are given for {len(rows)} of {len(logs)} recordings")
    filtering = filtering or rig.filtering
    made = [_log(r, rig, filtering, w) for r, w in zip(logs, rows, strict=True)]
    if sum(len(log.t) for log in made) < 2:  # noqa: PLR2004 - a spread needs two
        raise InputError(f"{logs[0].label}: no rows are left: widen the range or drop less")
    return made


def _log(recording: Recording, rig: Forced, filtering: Filtering, rows: Rows | None) -> _Log:
    log = even(recording, rig.measured(recording))
    first, last = filtering.edges(log.rate)
    factor = filtering.factor(log.rate)
    inner = slice(first, len(log.t) - last)
    if len(log.t[inner]) < _FEW * max(factor, 3):
        raise InputError(
            f"{recording.label}: {len(log.t)} samples at {log.rate:.4g} Hz are too few to filter: "
            "the force balance needs a longer log"
        )
    _, v, a = (x[inner] for x in smooth(log.position, log.rate, filtering))
    wanted = np.zeros(len(recording), dtype=bool)
    wanted[slice(None) if rows is None else rows] = True
    thin = kept(len(v), factor)
    counts = (wanted[log.nearest] & log.known)[inner][thin]
    counts &= np.abs(v[thin]) >= filtering.slowest
    t, force = log.t[inner][thin][counts], decimate(log.force[inner], factor)[counts]
    notes = log.notes + _rests(recording.label, np.abs(v[thin][counts]))
    return _Log(v, a, factor, counts, t, force, notes)


def _rests(label: str, speed: Array) -> tuple[str, ...]:
    share = float(np.mean(speed < _REST_SPEED * speed.max())) if len(speed) else 0.0
    if share <= _REST_SHARE:
        return ()
    said = f"{share:.0%} of the rows are at or near rest, where friction is not that of slip"
    return (f"{label}: {said}: drop them with Filtering(slowest=...)",)


@dataclass(frozen=True, eq=False)
class _Wanted:
    """Which parameters are to be found, and how a complete set follows from them."""

    law: Law
    rig: Forced
    params: tuple[Param, ...]
    tied: Mapping[str, str]

    def __post_init__(self) -> None:
        for a, b in self.tied.items():
            if a not in self.names or b not in self.names or a == b or b in self.tied:
                raise InputError(f"{a} cannot be tied to {b}")
        if not self.free:
            raise InputError(f"law {self.law.name}: no parameter is left to be found")

    @cached_property
    def names(self) -> tuple[str, ...]:
        return tuple(q.name for q in self.params)

    @cached_property
    def free(self) -> list[int]:
        return [i for i, q in enumerate(self.params) if q.fixed is None and q.name not in self.tied]

    @cached_property
    def linear(self) -> list[int]:
        own = {q.name for q in self.rig.own(self.law)}
        return [i for i in self.free if self.names[i] in own or self.names[i] in self.law.linear]

    @cached_property
    def shape(self) -> list[int]:
        return [i for i in self.free if i not in self.linear]

    @cached_property
    def lower(self) -> Array:
        return np.array([q.lower for q in self.params])

    @cached_property
    def upper(self) -> Array:
        return np.array([q.upper for q in self.params])

    def full(self, x: Array, at: list[int]) -> Array:
        """(n, len(at)) values of some free parameters to (n, k) sets; the other free ones are 0."""
        p = np.zeros((len(x), len(self.params)))
        for i, q in enumerate(self.params):
            p[:, i] = 0.0 if q.fixed is None else q.fixed
        p[:, at] = x
        for a, b in self.tied.items():
            p[:, self.names.index(a)] = p[:, self.names.index(b)]
        return p

    def limits(self) -> tuple[Array, Array, list[separable.Order]]:
        """Bounds of the linear parameters and the orders among them, by place in `linear`."""
        lower, upper = self.lower.copy(), self.upper.copy()
        among = []
        for i, j in separable.orders(self.law):
            if i in self.linear and j in self.linear:
                among.append((self.linear.index(i), self.linear.index(j)))
            elif i in self.linear and (fixed := self.params[j].fixed) is not None:
                lower[i] = max(lower[i], fixed)
            elif j in self.linear and (fixed := self.params[i].fixed) is not None:
                upper[j] = min(upper[j], fixed)
        return lower[self.linear], upper[self.linear], among


class _System:
    """Logs and a model: the stacked balance y = f(p), affine in the linear parameters."""

    def __init__(self, wanted: _Wanted, logs: list[_Log]) -> None:
        self.wanted, self.logs = wanted, logs
        self.y = np.concatenate([log.force for log in logs])
        self._limits = wanted.limits()

    def predicted(self, p: Array) -> Array:
        """(n, k) complete sets to (rows, n) forces."""
        w = self.wanted
        return np.concatenate(
            [
                log.thin(np.column_stack([w.rig.force(w.law, row, log.v, log.a) for row in p]))
                for log in self.logs
            ]
        )

    def columns(self, shape: Array) -> tuple[Array, Array]:
        """The regressor of the linear parameters at given shape ones, and what is without them."""
        w = self.wanted
        at = [*w.linear, *w.shape]
        x = np.vstack([np.zeros(len(w.linear)), np.eye(len(w.linear))])
        x = np.hstack([x, np.tile(shape, (len(x), 1))])
        f = self.predicted(w.full(x, at))
        return f[:, 1:] - f[:, :1], f[:, 0]

    def solved(self) -> tuple[Array, dict[str, str]]:
        """The best complete set, and what stops each parameter that is stopped."""
        w = self.wanted
        ends: dict[str, str] = {}
        shape = np.empty(0)
        if w.shape:
            space = Space(tuple(w.params[i] for i in w.shape))
            u = separable.search(lambda u: self._left(space.decode(u[None])[0]), space.dim)
            shape = space.decode(u[None])[0]
            ends = {n: "lower" for n, s in zip(space.names, u, strict=True) if s < 1e-4}  # noqa: PLR2004
            ends |= {n: "upper" for n, s in zip(space.names, u, strict=True) if s > 1 - 1e-4}
        x, stops = self._linear(shape)
        for i, stop in stops.items():
            other = stop if isinstance(stop, str) else w.names[w.linear[stop]]
            ends[w.names[w.linear[i]]] = other
        return w.full(np.hstack([x, shape])[None], [*w.linear, *w.shape])[0], ends

    def _linear(self, shape: Array) -> tuple[Array, dict[int, Any]]:
        W, base = self.columns(shape)
        return separable.bounded(W, self.y - base, *self._limits)

    def _left(self, shape: Array) -> Array:
        W, base = self.columns(shape)
        x, _ = separable.bounded(W, self.y - base, *self._limits)
        left: Array = self.y - base - (W * x).sum(axis=1)
        return left

    def jacobian(self, p: Array) -> Array:
        """Slopes of the prediction, (rows, free); those of shape by central differences."""
        w = self.wanted
        J = np.empty((len(self.y), len(w.free)))
        if w.linear:
            J[:, [w.free.index(i) for i in w.linear]] = self.columns(p[w.shape])[0]
        for i in w.shape:
            step = _STEP * (abs(p[i]) or 1.0) * np.array([[1.0], [-1.0]])
            near = np.repeat(p[None, w.free], 2, axis=0)
            near[:, [w.free.index(i)]] += step
            f = self.predicted(w.full(near, w.free))
            J[:, w.free.index(i)] = (f[:, 0] - f[:, 1]) / (2 * step[0, 0])
        return J

    def judge(self, p: Array) -> Prediction:
        """How well a complete set explains the logs."""
        left = self.y - self.predicted(p[None])[:, 0]
        size = float(np.linalg.norm(self.y))
        return Prediction(
            relative_error=100 * float(np.linalg.norm(left)) / size if size > 0 else float("inf"),
            residual_sd=float(np.std(left, ddof=1)),
            rows=len(self.y),
            signals=tuple(self._signals(log, p) for log in self.logs),
            notes=tuple(note for log in self.logs for note in log.notes),
        )

    def _signals(self, log: _Log, p: Array) -> Signals:
        rig, law = self.wanted.rig, self.wanted.law
        model, rub = rig.force(law, p, log.v, log.a), rig.friction(law, p, log.v)
        gain = 1.0 if log.factor == 1 else DECIMATION_GAIN
        rest, measured = log.thin(model - rub) / gain, log.force / gain
        return Signals(
            t=log.t,
            velocity=log.pick(log.v),
            acceleration=log.pick(log.a),
            measured=measured,
            predicted=log.thin(model) / gain,
            friction=measured - rest,
        )


def _doubts(
    wanted: _Wanted, W: Array, covariance: Array, at_bound: Mapping[str, str], error: float
) -> list[str]:
    """What a reader must know about the estimates, a sentence each."""
    label = wanted.rig.label
    names = [label(wanted.names[i]) for i in wanted.free]
    doubts = [
        f"{name} cannot be identified from this data"
        for at, name, variance in zip(wanted.free, names, np.diag(covariance), strict=True)
        if not np.isfinite(variance) and wanted.names[at] not in at_bound
    ]
    for name, stop in at_bound.items():
        where = f"the {stop} end of its range" if stop in ("lower", "upper") else label(stop)
        doubts.append(f"{label(name)} is stopped at {where}")
    seen = [i for i in range(len(names)) if np.isfinite(covariance[i, i])]
    if seen and (degree := separable.collinearity(W[:, seen])) > COLLINEAR:
        doubts.append(
            f"the data hardly tells the parameters apart (scaled condition number {degree:.3g}): "
            "their standard errors say how far each may be off"
        )
    if error > UNEXPLAINED:
        doubts.append(f"{error:.0f} % of the force is not explained by this model")
    if len(W) < _FEW * len(names):
        doubts.append(f"{len(W)} rows for {len(names)} parameters: standard errors are too small")
    return doubts
