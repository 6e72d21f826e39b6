"""Least squares that is linear in most parameters: bounds, order relations, honest errors.

What is linear is solved for exactly at each value of what is not, so a search sees the few shape
parameters alone (variable projection: Golub and Pereyra 1973, doi 10.1137/0710036).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import Literal

import numpy as np
from numba import float64
from numpy.lib.stride_tricks import sliding_window_view

from ...compile_cache import compiled
from ...friction.orders import Order
from ...space import Array
from ..uncertainty.covariance import first_below_zero, long_run_variance
from ..uncertainty.residuals import parts

#: Starts along each axis by the number of shape parameters, and how many are polished.
_LEVELS, _MORE, POLISHED = {1: 16, 2: 6}, 3, 3
#: Rows that are triangularised at once.
_BLOCK = 1 << 18
#: How far from the edges of the cube a given start is kept.
_INSIDE = 1e-3
#: A direction is blind if it moves the prediction by less than this share of what the best seen
#: one does, columns scaled to one length.
_BLIND = 1e-9


def bounded(
    W: Array, y: Array, lower: Array, upper: Array, orders: Sequence[Order] = ()
) -> tuple[Array, dict[int, Literal["lower", "upper"] | int]]:
    """The x that minimises ||y − W x|| within bounds and orders, and what stops it.

    Args:
        W: (rows, k).
        y: (rows,).
        lower: (k,); -inf for none.
        upper: (k,).
        orders: Pairs (i, j) with x_i >= x_j; no i appears twice, nor as a j.

    Returns:
        x (k,), and for each parameter at an edge `lower`, `upper` or the j it rests on.
    """
    from scipy.optimize import lsq_linear  # noqa: PLC0415 - slow to import

    lengths = _lengths(W)
    R, y = _reduced(W, y, lengths)  # what follows is small
    R *= lengths
    x: Array = np.linalg.lstsq(R / lengths, y, rcond=None)[0] / lengths
    if (x >= lower).all() and (x <= upper).all() and all(x[i] >= x[j] for i, j in orders):
        return x, {}
    # In place of x_i stands its height over x_j, which is only bounded from below by zero.
    stack, low, high = np.eye(len(x)), lower.copy(), upper.copy()
    for i, j in orders:
        stack[i, j] = 1.0
        low[i], high[i] = 0.0, upper[i] - lower[j]
        high[j] = min(high[j], upper[i])
    system = R @ stack
    lengths = _lengths(system)
    fit = lsq_linear(system / lengths, y, bounds=(low * lengths, high * lengths), method="bvls")
    resting_on = dict(orders)
    stops: dict[int, Literal["lower", "upper"] | int] = {}
    for i, side in enumerate(fit.active_mask):
        if side < 0:
            stops[i] = resting_on.get(i, "lower")
        elif side > 0:
            stops[i] = "upper"
    z = fit.x / lengths
    for i, stop in stops.items():
        z[i] = high[i] if stop == "upper" else low[i]
    return np.clip(stack @ z, lower, upper), stops


def _triangle(columns: Array) -> Array:
    """The R of A = QR by Householder reflections; rows of zeros where A has too few.

    The columns of A, (k, rows), are overwritten. A tall, thin matrix is too little work for a
    threaded library: with busy cores its threads wait for each other a hundred times longer than
    this takes.
    """
    k, n = columns.shape
    R = np.zeros((k, k))
    for j in range(min(k, n)):
        v = columns[j]
        square = 0.0
        for i in range(j, n):
            square += v[i] * v[i]
        R[j, j] = -np.copysign(np.sqrt(square), v[j])
        reflect = square - R[j, j] * v[j]  # half the squared length of the reflector
        v[j] -= R[j, j]
        for m in range(j + 1, k):
            w = columns[m]
            along = 0.0
            for i in range(j, n):
                along += v[i] * w[i]
            share = along / reflect if reflect > 0.0 else 0.0
            for i in range(j, n):
                w[i] -= share * v[i]
            R[j, m] = w[j]
    return R


_compiled = compiled(float64[:, ::1](float64[:, ::1]))(_triangle)


def triangle(A: Array) -> Array:
    """The R of A = QR, (k, k); of many rows a block at a time, whose R are stacked."""
    if len(A) > _BLOCK:
        starts = range(0, len(A), _BLOCK)
        return triangle(np.vstack([triangle(A[k : k + _BLOCK]) for k in starts]))
    R: Array = _compiled(np.array(A.T, dtype=float, order="C"))
    return R


def least_squares(W: Array, y: Array) -> Array:
    """The x of least ||y − W x||, (k,), with copies of no more than a block of rows."""
    lengths = _lengths(W)
    R, z = _reduced(W, y, lengths)
    x: Array = np.linalg.lstsq(R, z, rcond=None)[0] / lengths
    return x


def _reduced(W: Array, y: Array, lengths: Array) -> tuple[Array, Array]:
    """Equations, (k, k) and (k,), with the solution of W, columns divided by lengths, and y."""
    blocks = (slice(k, k + _BLOCK) for k in range(0, max(len(W), 1), _BLOCK))
    T = triangle(np.vstack([triangle(np.column_stack([W[b] / lengths, y[b]])) for b in blocks]))
    return T[:-1, :-1], T[:-1, -1]


def search(
    residuals: Callable[[Array], Array],
    dim: int,
    start: Array | None = None,
    *,
    polished: int = POLISHED,
) -> Array:
    """The point of the unit cube with the least sum of squared residuals.

    A grid of starts, the same each time, or those given, (n, dim); the best are polished by bounded
    least squares. In one dimension and in two they are the grid's minima alone, so that no two of
    them are neighbours, which lead to one place more often than not.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 - slow to import

    n = _LEVELS.get(dim, _MORE)
    grid = np.array(list(product((np.arange(n) + 0.5) / n, repeat=dim)))
    if start is not None:
        grid = np.clip(start, _INSIDE, 1 - _INSIDE)
    costs = np.array([np.sum(residuals(u) ** 2) for u in grid])
    best: Array = grid[np.argmin(costs)]
    least = float(costs.min())
    order = np.argsort(costs, kind="stable")
    if start is None and dim in _LEVELS:
        order = order[_minima(costs.reshape((n,) * dim)).ravel()[order]]
    for first in grid[order[:polished]]:
        fit = least_squares(residuals, first, bounds=(0.0, 1.0), xtol=1e-10, ftol=1e-12, gtol=1e-12)
        if 2 * fit.cost < least:
            best, least = np.asarray(fit.x), 2 * float(fit.cost)
    return best


def _minima(costs: Array) -> Array:
    """Which points of a grid no neighbour is below, diagonal ones included."""
    around = sliding_window_view(np.pad(costs, 1, constant_values=np.inf), (3,) * costs.ndim)
    least = around.min(axis=tuple(range(-costs.ndim, 0)))
    return np.asarray(costs <= least)


def covariance(W: Array, sd: float, stopped: Sequence[int] = ()) -> Array:
    """sd² (WᵀW)⁻¹, (k, k): inf on the diagonal and nan beside it for what W cannot see.

    The same for parameters `stopped` by a bound: there the data did not set the value, and how
    the sum of squares curves does not say how far off it may be.
    """
    lengths = _lengths(W)
    _, s, Vt = np.linalg.svd(triangle(W) / lengths)
    identified = s > _BLIND * max(s[0], np.finfo(float).tiny)
    part: Array = Vt[identified].T / s[identified]
    C: Array = np.asarray(sd**2 * (part @ part.T) / np.outer(lengths, lengths))
    blind = (np.abs(Vt[~identified]) > np.sqrt(_BLIND)).any(axis=0) | ~W.any(axis=0)
    blind[list(stopped)] = True
    C[blind], C[:, blind] = np.nan, np.nan
    C[blind, blind] = np.inf
    return C


def robust_variances(
    W: Array, residuals: Array, lengths: Sequence[int], prior: Array | None = None
) -> Array:
    """Variances of least squares estimates whose residuals correlate from row to row, (k,).

    The estimator of Newey and West (1987, doi 10.2307/1913610), with Bartlett weights over twice
    the lag at which the residuals' autocorrelation first falls below zero. nan where W is blind.

    Args:
        W: (rows, k).
        residuals: (rows,).
        lengths: Rows of each log, in order: nothing correlates across logs.
        prior: Rows of what is known beforehand, (m, k), each as uncertain as a row is noisy.
    """
    bread = covariance(W if prior is None else np.vstack([W, prior]), 1.0)
    identified = np.isfinite(np.diag(bread))
    inner = np.where(identified, bread, 0.0)[identified]
    reach = 2 * first_below_zero(residuals, lengths)
    variances: Array = np.full(len(bread), np.nan)
    for i, row in zip(np.flatnonzero(identified), inner, strict=True):
        moves = W @ row  # one at a time: of a long log each takes as much as a channel
        moves *= residuals
        total = float(long_run_variance(parts(moves[None], lengths), reach)[0])
        variances[i] = total * len(W) / (len(W) - W.shape[1])
    if prior is not None:
        moves = inner @ prior.T
        white = float(residuals @ residuals) / (len(W) - W.shape[1])
        variances[identified] += white * np.square(moves).sum(axis=1)
    return variances


def condition(W: Array) -> float:
    """Ratio of the largest to the least singular value; inf if W is singular."""
    return _ratio(triangle(W))


def collinearity(W: Array) -> float:
    """`condition` with columns of one length, so that no unit changes it."""
    return _ratio(triangle(W) / _lengths(W))


def _ratio(R: Array) -> float:
    """Of the largest to the least singular value; inf where that is 0."""
    s = np.linalg.svd(R, compute_uv=False)
    return float(s[0] / s[-1]) if s[-1] > 0 else float("inf")


def _lengths(W: Array) -> Array:
    lengths = np.sqrt(np.einsum("ij,ij->j", W, W))
    return np.asarray(np.where(lengths > 0, lengths, 1.0), dtype=float)
