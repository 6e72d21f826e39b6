"""A force balance as a regression: the parameters wanted, and what the model makes of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...errors import InputError
from ...friction import Law
from ...friction.orders import Order, orders
from ...rig.balanced import BalancedRig
from ...space import Array, Param, Space
from . import variable_projection
from .rows import Log

#: Step of a shape parameter for the Jacobian, as a share of its value.
_STEP = 1e-4


@dataclass(frozen=True, eq=False)
class Wanted:
    """Which parameters are to be found, and how a complete set follows from them."""

    law: Law
    rig: BalancedRig
    params: tuple[Param, ...]
    tied: Mapping[str, str]

    def __post_init__(self) -> None:
        self.rig.check_law(self.law)
        for a, b in self.tied.items():
            if a not in self.names or b not in self.names or a == b or b in self.tied:
                raise InputError(f"{a} cannot be tied to {b}")
        if not self.free:
            raise InputError(f"law {self.law.name}: no parameter is left to be found")

    @cached_property
    def names(self) -> tuple[str, ...]:
        """All parameters, the law's and then the rig's own."""
        return tuple(q.name for q in self.params)

    @cached_property
    def free(self) -> list[int]:
        """Places of those to be found."""
        return [i for i, q in enumerate(self.params) if q.fixed is None and q.name not in self.tied]

    @cached_property
    def linear(self) -> list[int]:
        """Places of the free ones that the force is linear in."""
        own = {q.name for q in self.rig.own(self.law)}
        return [i for i in self.free if self.names[i] in own or self.names[i] in self.law.linear]

    @cached_property
    def shape(self) -> list[int]:
        """Places of the free ones that shape the curve."""
        return [i for i in self.free if i not in self.linear]

    @cached_property
    def lower(self) -> Array:
        """Lower ends of all ranges, (k,)."""
        return np.array([q.lower for q in self.params])

    @cached_property
    def upper(self) -> Array:
        """Upper ends of all ranges, (k,)."""
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

    def limits(self) -> tuple[Array, Array, list[Order]]:
        """Bounds of the linear parameters and the orders among them, by place in `linear`."""
        lower, upper = self.lower.copy(), self.upper.copy()
        among = []
        for i, j in orders(self.law):
            if i in self.linear and j in self.linear:
                among.append((self.linear.index(i), self.linear.index(j)))
            elif i in self.linear and (fixed := self.params[j].fixed) is not None:
                lower[i] = max(lower[i], fixed)
            elif j in self.linear and (fixed := self.params[i].fixed) is not None:
                upper[j] = min(upper[j], fixed)
        return lower[self.linear], upper[self.linear], among


class System:
    """Logs and a model: the stacked balance y = f(p), affine in the linear parameters."""

    def __init__(self, wanted: Wanted, logs: list[Log]) -> None:
        self.wanted, self.logs = wanted, logs
        self.y = np.concatenate([log.force for log in logs])
        self._limits = wanted.limits()

    def predicted(self, p: Array) -> Array:
        """(n, k) complete sets to (rows, n) forces."""
        w = self.wanted
        return np.concatenate(
            [
                log.thin(
                    np.column_stack([w.rig.force(w.law, row, log.v, log.a, log.loads) for row in p])
                )
                for log in self.logs
            ]
        )

    def at_lag(self, lag: float) -> Array:
        """The force that was measured `lag` seconds later than the motion, (rows,)."""
        return np.concatenate(
            [log.thin(np.interp(log.clock + lag, log.clock, log.raw)) for log in self.logs]
        )

    def columns(self, shape: Array) -> tuple[Array, Array]:
        """The regressor of the linear parameters at given shape ones, and what is without them."""
        w = self.wanted
        at = [*w.linear, *w.shape]
        x = np.vstack([np.zeros(len(w.linear)), np.eye(len(w.linear))])
        x = np.hstack([x, np.tile(shape, (len(x), 1))])
        f = self.predicted(w.full(x, at))
        return f[:, 1:] - f[:, :1], f[:, 0]

    def solved(self, near: Array | None = None) -> tuple[Array, dict[str, str]]:
        """The best complete set (near one, if given), and what stops each stopped parameter."""
        w = self.wanted
        ends: dict[str, str] = {}
        shape = np.empty(0)
        if w.shape:
            space = Space(tuple(w.params[i] for i in w.shape))
            start = None if near is None else space.encode(near[None, w.shape])[0]
            u = variable_projection.search(
                lambda u: self._left(space.decode(u[None])[0]), space.dim, start
            )
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
        return variable_projection.bounded(W, self.y - base, *self._limits)

    def _left(self, shape: Array) -> Array:
        W, base = self.columns(shape)
        x, _ = variable_projection.bounded(W, self.y - base, *self._limits)
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
