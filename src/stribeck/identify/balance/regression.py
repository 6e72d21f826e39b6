"""A force balance as a regression: the rows of all logs, and what the model predicts for them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...friction.orders import Order, orders
from ...rig.balanced import as_balanced
from ...space import Array, Space
from ..parameters import Parameters
from . import variable_projection
from .rows import Log

#: Step of a shape parameter for the Jacobian, as a share of its value.
_STEP = 1e-4


class System:
    """Logs and a model: the stacked balance y = f(p), affine in the linear parameters.

    Args:
        parameters: Which parameters are free, on a rig with a measured force.
        logs: The filtered logs.

    `free` are the places of the free parameters in a complete set, `linear` of those that the
    force is linear in, `shape` of those that shape the friction curve.
    """

    def __init__(self, parameters: Parameters, logs: list[Log]) -> None:
        self.parameters, self.logs = parameters, logs
        self.rig, self.law = as_balanced(parameters.rig), parameters.law
        linear = {q.name for q in self.rig.own(self.law)} | set(self.law.linear)
        self.free = parameters.free_places
        self.linear = [i for i in self.free if parameters.every[i].name in linear]
        self.shape = [i for i in self.free if i not in self.linear]
        self.y = np.concatenate([log.force for log in logs])
        self._limits = self._linear_limits()

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
        """(n, k) complete sets to (rows, n) forces."""
        rig, law = self.rig, self.law
        return np.concatenate(
            [
                log.thin(
                    np.column_stack([rig.force(law, row, log.v, log.a, log.loads) for row in p])
                )
                for log in self.logs
            ]
        )

    def at_lag(self, lag: float) -> Array:
        """The force that was measured `lag` seconds later than the motion, (rows,)."""
        return np.concatenate([log.thin(log.net(lag)) for log in self.logs])

    @property
    def known(self) -> Array:
        """The known force that is taken off the measured one, (rows,)."""
        return np.concatenate(
            [log.thin(np.broadcast_to(log.known, log.v.shape)) for log in self.logs]
        )

    def least_squares(self, force: Array, p: Array) -> float:
        """The least sum of squares about a force, (rows,), for the shape of a complete set."""
        W, base = self.columns(p[self.shape])
        x, _ = variable_projection.bounded(W, force - base, *self._limits)
        return float(np.sum((force - base - W @ x) ** 2))

    def columns(self, shape: Array) -> tuple[Array, Array]:
        """The regressor of the linear parameters at given shape ones, and what is without them."""
        x = np.vstack([np.zeros(len(self.linear)), np.eye(len(self.linear))])
        f = self.predicted(self.full(x, np.tile(shape, (len(x), 1))))
        return f[:, 1:] - f[:, :1], f[:, 0]

    def solved(self, start: Array | None = None) -> tuple[Array, dict[str, str]]:
        """The best complete set (near one, if given), and what stops each stopped parameter."""
        names = self.parameters.names
        ends: dict[str, str] = {}
        shape = np.empty(0)
        if self.shape:
            space = Space(tuple(self.parameters.every[i] for i in self.shape))
            u_start = None if start is None else space.encode(start[None, self.shape])[0]
            u = variable_projection.search(
                lambda u: self._residuals(space.decode(u[None])[0]), space.dim, u_start
            )
            shape = space.decode(u[None])[0]
            ends = {n: "lower" for n, s in zip(space.names, u, strict=True) if s < 1e-4}  # noqa: PLR2004
            ends |= {n: "upper" for n, s in zip(space.names, u, strict=True) if s > 1 - 1e-4}
        x, stops = self._linear(shape)
        for i, stop in stops.items():
            stop_name = stop if isinstance(stop, str) else names[self.linear[stop]]
            ends[names[self.linear[i]]] = stop_name
        return self.full(x[None], shape[None])[0], ends

    def _linear(self, shape: Array) -> tuple[Array, dict[int, Any]]:
        W, base = self.columns(shape)
        return variable_projection.bounded(W, self.y - base, *self._limits)

    def _residuals(self, shape: Array) -> Array:
        W, base = self.columns(shape)
        x, _ = variable_projection.bounded(W, self.y - base, *self._limits)
        residuals: Array = self.y - base - (W * x).sum(axis=1)
        return residuals

    def jacobian(self, p: Array) -> Array:
        """Slopes of the prediction, (rows, free); those of shape by central differences."""
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
