"""A fit with its slopes, and where they say that the other parameters go if one is moved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...errors import InputError
from ...optimize.box import Box
from ...optimize.lockstep import AskTell, Counted, lockstep
from ...optimize.trust_region import Iterate, with_slopes
from ...space import Array
from .residuals import Residuals, orders_of

#: Half-width of the region, in the unit cube, that the linear model is asked about.
REACH = 0.5


def box_of(problem: Residuals) -> Box:
    """The box of a problem's parameters, with the orders that its law has them keep."""
    return Box(problem.space, orders_of(problem))


def linearised(counted: Counted, box: Box, x: Array) -> Iterate:
    """A fit, SI, (dim,), with its slopes.

    Raises:
        InputError: it cannot be run there, or there are too few rows or evaluations.
    """
    u = box.orderly(box.u(np.asarray(x, dtype=float)))
    r = counted.residuals(box.x(u)[None])[0]
    if not np.isfinite(r).all():
        raise InputError("the fit cannot be run at its own parameters: fit again before this")
    if len(r) <= box.dim:
        raise InputError(f"{len(r)} rows cannot tell {box.dim} parameters: give more data")
    if counted.left < box.dim + 1:
        raise InputError(f"a budget of {counted.budget} rows is too small to take slopes: raise it")
    iterate = replace(Iterate.at(u, r), own=True)
    (best,) = lockstep(counted, [AskTell("slopes", box.space, with_slopes(iterate))])
    return best or iterate


def predicted(iterate: Iterate, box: Box, k: int, move: float) -> tuple[Array, float]:
    """Where the linear model has the others if coordinate k moves, and the sum of squares there."""
    return _best_others(iterate, box, k, move, iterate.r)


def compensated(iterate: Iterate, box: Box, k: int, move: float) -> Array:
    """Where they make up for a move of coordinate k, (dim,), and for nothing else.

    Residuals beside the fit promise gains along weak slopes that no step may keep. A move that
    follows such a promise leads away whatever its length; this one is as short as the move.
    """
    return _best_others(iterate, box, k, move, np.zeros_like(iterate.r))[0]


def _best_others(iterate: Iterate, box: Box, k: int, move: float, r: Array) -> tuple[Array, float]:
    """The others of least squares if coordinate k moves, of residuals r before the move."""
    u = iterate.u.copy()
    u[k] = min(max(u[k] + move, 0.0), 1.0)
    u = box.orderly(u, k)
    moved = iterate.moved(u, r + np.einsum("i,im->m", u - iterate.u, iterate.J))
    s, promise = moved.step(box, others(box.dim, k), REACH)
    return box.orderly(u + s, k), moved.squares - promise


def others(dim: int, k: int) -> list[int]:
    """All coordinates but one."""
    return [i for i in range(dim) if i != k]
