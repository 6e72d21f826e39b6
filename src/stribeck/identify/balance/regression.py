"""A force balance as a regression: the rows of all logs, and what the model predicts for them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ...friction.orders import Order, orders
from ...rig.balanced import as_balanced
from ...space import Array, Space
from ..parameters import Parameters
from . import variable_projection
from .filtered_columns import FilteredColumns
from .modelled_force import friction_under
from .rows import Log

if TYPE_CHECKING:
    from ...data.zero_phase import Samples, Signal

#: Step of a shape parameter for the Jacobian, as a share of its value.
_STEP = 1e-4
#: Shapes of the curve whose columns are kept, and numbers in all of them at most.
SHAPES, NUMBERS = 16, 1 << 24
#: Numbers at most in columns before they are filtered, of which those of the last shape are kept.
UNFILTERED = 1 << 18


class System:
    """Logs and a model: the stacked balance y = f(p), affine in the linear parameters.

    Args:
        parameters: Which parameters are free, on a rig with a measured force.
        logs: The filtered logs.
        prior: Rows over the linear parameters, (m, linear), whose products with them are taken to
            be as far from zero as a row of the data from the model; none by default.

    `free` are the places of the free parameters in a complete set, `linear` of those that the
    force is linear in, `shape` of those that shape the friction curve.
    """

    def __init__(self, parameters: Parameters, logs: list[Log], prior: Array | None = None) -> None:
        self.parameters, self.logs = parameters, logs
        self.rig, self.law = as_balanced(parameters.rig), parameters.law
        self.filtering = self.rig.filtering_of(self.law)
        linear = {q.name for q in self.rig.own(self.law)} | set(self.law.linear)
        self.free = parameters.free_places
        self.linear = [i for i in self.free if parameters.every[i].name in linear]
        self.shape = [i for i in self.free if i not in self.linear]
        self.y = stacked([log.force for log in logs])
        self.prior = np.zeros((0, len(self.linear))) if prior is None else prior
        self._kept: dict[bytes, tuple[Array, Array]] = {}
        self._filtered = [FilteredColumns() for _ in logs]
        self._limits = self._linear_limits()
        self._orders = [
            (self.shape.index(i), self.shape.index(j))
            for i, j in orders(self.law, nonlinear=True)
            if self.law.states and i in self.shape and j in self.shape
        ]

    @property
    def samples(self) -> int:
        """Of all logs, before they are decimated."""
        return sum(len(log) for log in self.logs)

    def full(self, linear: Array, shape: Array) -> Array:
        """(n, linear) and (n, shape) values to (n, k) complete sets."""
        x = np.empty((len(linear), len(self.free)))
        x[:, [self.free.index(i) for i in self.linear]] = linear
        x[:, [self.free.index(i) for i in self.shape]] = shape
        return self.parameters.full(x)

    def _linear_limits(self) -> tuple[Array, Array, list[Order]]:
        """Bounds of the linear parameters and the orders among them, by place in `linear`."""
        params, fixed = self.parameters.every, self.parameters.fixed
        lower = np.array([q.lower for q in params])
        upper = np.array([q.upper for q in params])
        linear_orders = []
        for i, j in orders(self.law):
            if i in self.linear and j in self.linear:
                linear_orders.append((self.linear.index(i), self.linear.index(j)))
            elif i in self.linear and params[j].name in fixed:
                lower[i] = max(lower[i], fixed[params[j].name])
            elif j in self.linear and params[i].name in fixed:
                upper[j] = min(upper[j], fixed[params[i].name])
        return lower[self.linear], upper[self.linear], linear_orders

    def predicted(self, p: Array) -> Array:
        """(n, k) complete sets to (rows, n) forces.

        They are affine in the linear parameters, whose columns are kept, so that logs are filtered
        once for a shape of the curve; sets that hold other values than the fixed ones are not.
        """
        shapes, linear = p[:, self.shape], p[:, self.linear]
        alike = np.array_equal(self.parameters.full(p[:, self.free]), p)
        alike = alike and bool((shapes == shapes[:1]).all()) and len(p) > 0
        if alike and (self.is_kept(shapes[0]) or len(p) > len(self.linear)):
            W, base = self.columns(shapes[0])
            forces: Array = np.einsum("mj,ij->mi", W, linear)
            forces += base[:, None]
            return forces
        return self._predicted(p)

    def _predicted(self, p: Array) -> Array:
        return stacked([log.thin(self._forces(log, p)) for log in self.logs])

    def _forces(self, log: Log, p: Array) -> Signal:
        own = len(self.law.params)
        frictions = {row[:own].tobytes(): friction_under(self.rig, self.law, log, row) for row in p}

        def forces(at: Samples) -> Array:
            motion = log.motion(at)
            rubs = {key: friction(at, motion) for key, friction in frictions.items()}
            rows = [self.rig.force(self.law, row, *motion, rubs[row[:own].tobytes()]) for row in p]
            return np.array(rows).T

        return forces

    def at_lags(self, lags: Array) -> Array:
        """The force that was measured so many seconds later than the motion, (rows, lags)."""
        return stacked([log.thin(partial(_force_at_lags, log, lags)) for log in self.logs])

    @property
    def known(self) -> Array:
        """The known force that is taken off the measured one, (rows,)."""
        return stacked([log.thin(partial(_known, log)) for log in self.logs])

    def least_squares(self, force: Array, p: Array) -> float:
        """The least sum of squares about a force, (rows,), for the shape of a complete set."""
        W, base = self.columns(p[self.shape])
        x, _ = self._bounded(W, force - base)
        return float(np.sum((force - base - W @ x) ** 2))

    def columns(self, shape: Array) -> tuple[Array, Array]:
        """The regressor of the linear parameters at given shape ones, and what is without them."""
        key = shape.tobytes()
        if key not in self._kept:
            x = np.vstack([np.zeros(len(self.linear)), np.eye(len(self.linear))])
            f = self._renewed(self.full(x, np.tile(shape, (len(x), 1))))
            most = int(np.clip(NUMBERS // f.size, 1, SHAPES)) if f.size else 1
            while len(self._kept) >= most:
                self._kept.pop(next(iter(self._kept)))
            base = f[:, 0]
            f[:, 1:] -= base[:, None]
            self._kept[key] = f[:, 1:], base
        return self._kept[key]

    def _renewed(self, p: Array) -> Array:
        """As `_predicted`, but what is as it was for the last shape is not filtered again.

        An inertial or a viscous force, say, is the same for every shape.
        """
        if self.samples * len(p) > UNFILTERED:
            return self._predicted(p)
        columns = [
            before.renewed(log, self._forces(log, p)(slice(0, len(log))))
            for log, before in zip(self.logs, self._filtered, strict=True)
        ]
        self._filtered = columns
        return stacked([c.thin for c in columns]).copy()

    def is_kept(self, shape: Array) -> bool:
        """Whether the regressor at given shape parameters is at hand."""
        return shape.tobytes() in self._kept

    def solved(self, start: Array | None = None) -> tuple[Array, dict[str, str]]:
        """The best complete set, and what stops each stopped parameter.

        Args:
            start: Complete sets near it, (n, k) or (k,); by default a grid.
        """
        names = self.parameters.names
        ends: dict[str, str] = {}
        shape = np.empty(0)
        if self.shape:
            space = Space(tuple(self.parameters.every[i] for i in self.shape))
            u_start = None
            if start is not None:
                u_start = space.encode(np.atleast_2d(start)[:, self.shape])
            u = variable_projection.search(
                lambda u: self._residuals(self._ordered(space.decode(u[None])[0])),
                space.dim,
                u_start,
                polished=1 if self.law.states else variable_projection.POLISHED,
            )
            shape = self._ordered(space.decode(u[None])[0])
            ends = {n: "lower" for n, s in zip(space.names, u, strict=True) if s < 1e-4}  # noqa: PLR2004
            ends |= {n: "upper" for n, s in zip(space.names, u, strict=True) if s > 1 - 1e-4}
            ends |= {
                space.names[i]: space.names[j] for i, j in self._orders if shape[i] == shape[j]
            }
        x, stops = self._linear(shape)
        for i, stop in stops.items():
            stop_name = stop if isinstance(stop, str) else names[self.linear[stop]]
            ends[names[self.linear[i]]] = stop_name
        return self.full(x[None], shape[None])[0], ends

    def _ordered(self, shape: Array) -> Array:
        """Shape parameters of which none is below one that it may not fall below."""
        for i, j in self._orders:
            shape[i] = max(shape[i], shape[j])
        return shape

    def _linear(self, shape: Array) -> tuple[Array, dict[int, Any]]:
        W, base = self.columns(shape)
        return self._bounded(W, self.y - base)

    def _bounded(self, W: Array, y: Array) -> tuple[Array, dict[int, Any]]:
        """The linear parameters nearest to a force and to what is known beforehand."""
        if len(self.prior):
            W, y = np.vstack([W, self.prior]), np.append(y, np.zeros(len(self.prior)))
        return variable_projection.bounded(W, y, *self._limits)

    def _residuals(self, shape: Array) -> Array:
        W, base = self.columns(shape)
        x, _ = self._bounded(W, self.y - base)
        residuals: Array = self.y - base - (W * x).sum(axis=1)
        return np.append(residuals, self.prior @ x) if len(self.prior) else residuals

    @property
    def free_prior(self) -> Array:
        """The rows of `prior` over all free parameters, (m, free)."""
        rows = np.zeros((len(self.prior), len(self.free)))
        rows[:, [self.free.index(i) for i in self.linear]] = self.prior
        return rows

    def jacobian(self, p: Array) -> Array:
        """Slopes of the prediction, (rows, free); those of shape by central differences.

        Where the force is linear in all of them it is the kept regressor itself, read-only.
        """
        if self.linear == self.free:
            W = self.columns(p[self.shape])[0].view()
            W.setflags(write=False)
            return W
        J = np.empty((len(self.y), len(self.free)))
        if self.linear:
            J[:, [self.free.index(i) for i in self.linear]] = self.columns(p[self.shape])[0]
        for i in self.shape:
            step = _STEP * (abs(p[i]) or 1.0) * np.array([[1.0], [-1.0]])
            shifted = np.repeat(p[None, self.free], 2, axis=0)
            shifted[:, [self.free.index(i)]] += step
            f = self.predicted(self.parameters.full(shifted))
            J[:, self.free.index(i)] = (f[:, 0] - f[:, 1]) / (2 * step[0, 0])
        return J


def accelerations(logs: Sequence[Log]) -> Array:
    """The accelerations of logs as a balance has them, thinned like the force, (rows,)."""

    def of_log(log: Log) -> Array:
        return log.thin(lambda at: log.motion(at).a)

    return stacked([of_log(log) for log in logs])


def stacked(parts: Sequence[Array]) -> Array:
    """The rows of all logs, (rows, ...); of a single one no copy."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _force_at_lags(log: Log, lags: Array, at: Samples) -> Array:
    """The raw force later by some lags, (len(at), lags), and its ends beyond them.

    By cubics through four samples: a straight line between two lowers noise half way between them,
    which reads as a delay that explains more.
    """
    rows = np.arange(at.start, at.stop) if isinstance(at, slice) else at
    columns = np.empty((len(rows), len(lags)))
    for column, lag in zip(columns.T, lags, strict=True):
        whole, s = divmod(float(lag) * log.rate, 1.0)
        weights = (
            -s * (1 - s) * (2 - s) / 6,
            (1 - s * s) * (2 - s) / 2,
            s * (1 + s) * (2 - s) / 2,
            -s * (1 - s * s) / 6,
        )
        first = rows + (int(whole) - 1)
        column[:] = sum(
            weight * log.raw.take(first + k, mode="clip") for k, weight in enumerate(weights)
        )
    return np.asarray((columns.T - log.known_at(at)).T)


def _known(log: Log, at: Samples) -> Array:
    return np.broadcast_to(log.known_at(at), log.clock[at].shape)
