"""Residuals over a box of parameters.

The same for every law, both roads and any search method.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...friction.orders import orders
from ...space import Array, Space

#: By which share of what moves a residual it may be off by arithmetic alone.
ROUNDING = 1e-8


class Residuals(Protocol):
    """Measured less modelled, for many parameter sets at once.

    Six attributes are optional. `logs` is a tuple with the rows of each log or stretch, in
    order: nothing correlates across them (default: all rows are one log). `priors` is how many of
    the rows, the last ones, are no data: each is a parameter less what is known of it beforehand,
    over the standard deviation of that, times the noise of the data (default: none). `dofs` has
    the degrees of freedom of parameters that a few observations of their own determine, by name.
    `orders` is a tuple of pairs (i, j) of free parameters with x_i >= x_j. `physical(x)` says,
    (n,), which of the points (n, dim) mean something. `rounding` is by how much a residual may be
    off by arithmetic alone (default: 1e-8 of what a parameter's whole range moves one).
    """

    @property
    def space(self) -> Space:
        """The free parameters, SI, with their ranges."""

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points, SI, to (n, N) residuals; nan where a point cannot be run."""


def logs_of(problem: Residuals, rows: int) -> tuple[int, ...]:
    """How many rows each log has, in order; those of priors are not among them.

    Raises:
        InputError: the problem's logs do not add up to its rows.
    """
    logs: Sequence[int] | None = getattr(problem, "logs", None)
    rows -= priors_of(problem)
    if logs is None:
        return (rows,)
    if sum(logs) != rows:
        raise InputError(f"logs of {sum(logs)} rows in all, but {rows} residuals: count them again")
    return tuple(int(n) for n in logs if n)


def priors_of(problem: Residuals) -> int:
    """How many of the rows, the last ones, are priors."""
    return int(getattr(problem, "priors", 0))


def dofs_of(problem: Residuals) -> Array:
    """The degrees of freedom of each parameter, (dim,); inf for those that all rows determine."""
    by_name: Mapping[str, float] = getattr(problem, "dofs", {})
    return np.array([by_name.get(name, np.inf) for name in problem.space.names])


def rounding_of(problem: Residuals, slopes: Array) -> float:
    """By how much a residual may be off by arithmetic alone.

    Args:
        problem: Whose residuals these are.
        slopes: Over the unit cube, (dim, N).
    """
    return float(getattr(problem, "rounding", ROUNDING * np.abs(slopes).max(initial=0.0)))


def parts(series: Array, logs: Sequence[int]) -> list[Array]:
    """Rows (..., N) cut into their logs."""
    ends = np.cumsum([0, *logs]).tolist()
    return [series[..., a:b] for a, b in pairwise(ends)]


def orders_of(problem: Residuals) -> tuple[tuple[int, int], ...]:
    """Pairs (i, j) of free parameters for which x_i >= x_j must hold, asked of the law if any."""
    pairs_given: Sequence[tuple[int, int]] | None = getattr(problem, "orders", None)
    if pairs_given is not None:
        return tuple(pairs_given)
    parameters: Any = getattr(problem, "parameters", None)
    if parameters is None or not hasattr(parameters, "law"):
        return ()
    at = {q.name: i for i, q in enumerate(parameters.free)}
    names = [parameters.tied.get(q.name, q.name) for q in parameters.law.params]
    pairs = ((names[i], names[j]) for i, j in orders(parameters.law, nonlinear=True))
    return tuple(dict.fromkeys((at[a], at[b]) for a, b in pairs if a in at and b in at))


def physical(problem: Residuals, x: Array) -> NDArray[np.bool_]:
    """Which points (n, dim), SI, mean something; all of them where nobody says."""
    allowed: Any = getattr(problem, "physical", None)
    if allowed is not None:
        return np.asarray(allowed(x), dtype=bool)
    parameters: Any = getattr(problem, "parameters", None)
    if parameters is None or not hasattr(parameters, "law"):
        return np.ones(len(x), dtype=bool)
    law = parameters.law
    return np.asarray(law.physical(parameters.full(x)[:, : len(law.params)]), dtype=bool)
