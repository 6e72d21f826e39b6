"""What every question about uncertainty is asked of: residuals over a box of parameters.

The same for every law, both roads and any search method.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..space import Array, Space
from . import separable

if TYPE_CHECKING:
    from .regression import System

#: Shapes of the curve whose regressors are kept.
SHAPES = 16


class Residuals(Protocol):
    """Measured less modelled, for many parameter sets at once.

    Three attributes are optional. `logs` is a tuple with the rows of each log or stretch, in
    order: nothing correlates across them (default: all rows are one log). `orders` is a tuple
    of pairs (i, j) of free parameters with x_i >= x_j. `physical(x)` says, (n,), which of the
    points (n, dim) mean something.
    """

    @property
    def space(self) -> Space:
        """The free parameters, SI, with their ranges."""

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points, SI, to (n, N) residuals; nan where a point cannot be run."""


def logs_of(problem: Residuals, rows: int) -> tuple[int, ...]:
    """How many rows each log has, in order.

    Raises:
        InputError: the problem's logs do not add up to its rows.
    """
    logs: Sequence[int] | None = getattr(problem, "logs", None)
    if logs is None:
        return (rows,)
    if sum(logs) != rows:
        raise InputError(f"logs of {sum(logs)} rows in all, but {rows} residuals: count them again")
    return tuple(int(n) for n in logs if n)


def parts(series: Array, logs: Sequence[int]) -> list[Array]:
    """Rows (..., N) cut into their logs."""
    ends = np.cumsum([0, *logs]).tolist()
    return [series[..., a:b] for a, b in pairwise(ends)]


def orders_of(problem: Residuals) -> tuple[tuple[int, int], ...]:
    """Pairs (i, j) of free parameters for which x_i >= x_j must hold, asked of the law if any."""
    given: Sequence[tuple[int, int]] | None = getattr(problem, "orders", None)
    if given is not None:
        return tuple(given)
    made: Any = getattr(problem, "parameters", None)
    if made is None or not hasattr(made, "law"):
        return ()
    at = {q.name: i for i, q in enumerate(made.free)}
    names = [made.tied.get(q.name, q.name) for q in made.law.params]
    pairs = ((names[i], names[j]) for i, j in separable.orders(made.law, every=True))
    return tuple(dict.fromkeys((at[a], at[b]) for a, b in pairs if a in at and b in at))


def physical(problem: Residuals, x: Array) -> NDArray[np.bool_]:
    """Which points (n, dim), SI, mean something; all of them where nobody says."""
    asked: Any = getattr(problem, "physical", None)
    if asked is not None:
        return np.asarray(asked(x), dtype=bool)
    made: Any = getattr(problem, "parameters", None)
    if made is None or not hasattr(made, "law"):
        return np.ones(len(x), dtype=bool)
    return np.asarray(made.law.physical(made.full(x)[:, : len(made.law.params)]), dtype=bool)


class BalanceResiduals:
    """A force balance by its residuals: measured less predicted force, N (N m).

    Args:
        system: The stacked regression of a force balance.
    """

    def __init__(self, system: System) -> None:
        wanted = system.wanted
        self.space = Space(tuple(wanted.params[i] for i in wanted.free))
        self.logs = tuple(len(log.t) for log in system.logs)
        at = {k: i for i, k in enumerate(wanted.free)}
        self.orders = tuple(
            (at[i], at[j]) for i, j in separable.orders(wanted.law) if i in at and j in at
        )
        self._system = system
        self._linear = [wanted.free.index(i) for i in wanted.linear]
        self._shape = [wanted.free.index(i) for i in wanted.shape]
        self._known: dict[bytes, tuple[Array, Array]] = {}

    def physical(self, x: Array) -> NDArray[np.bool_]:
        """Which points the law allows."""
        wanted = self._system.wanted
        p = wanted.full(x, wanted.free)[:, : len(wanted.law.params)]
        return np.asarray(wanted.law.physical(p), dtype=bool)

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points to (n, rows) residuals; nan where the law does not allow a point."""
        good = self.physical(x)
        found = np.full((len(x), len(self._system.y)), np.nan)
        shapes = x[:, self._shape]
        for shape in np.unique(shapes[good], axis=0):
            rows = good & (shapes == shape).all(axis=1)
            found[rows] = self._shaped(shape, x[rows])
        return found

    def _shaped(self, shape: Array, x: Array) -> Array:
        """Residuals of points of one shape: affine in all else, so seldom predicted one by one."""
        system, key = self._system, shape.tobytes()
        if key not in self._known and len(x) <= len(self._linear):
            predicted = system.predicted(system.wanted.full(x, system.wanted.free))
            return np.ascontiguousarray(system.y - predicted.T)
        if key not in self._known:
            if len(self._known) >= SHAPES:
                self._known.pop(next(iter(self._known)))
            self._known[key] = system.columns(shape)
        W, base = self._known[key]
        return np.asarray(system.y - base - np.einsum("im,jm->ij", x[:, self._linear], W))
