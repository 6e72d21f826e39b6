"""Lengths and walls of the unit cube, in which every method moves."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..errors import InputError
from ..space import Array, Rng, Space

Coordinates = Literal["unit", "raw"]
Walls = Literal["clip", "reflect"]
Neighbours = Literal["within", "at"]


def widths(space: Space, coordinates: Coordinates) -> Array:
    """How long each side of the cube is for the method, shape (dim,).

    With "unit" every side is 1 and a length such as R is a fraction of the range. With "raw" a
    side is the parameter's range, so that a length is in the parameters' own units.

    Raises:
        InputError: raw lengths over a logarithmic range, where they mean nothing.
    """
    if coordinates == "unit":
        return np.ones(space.dim)
    if logs := [p.name for p in space if p.log]:
        raise InputError(
            f"coordinates='raw' has no meaning on the log range of {', '.join(logs)}: use 'unit'"
        )
    return space.upper - space.lower


def inside(u: Array, walls: Walls) -> Array:
    """Points brought back into the cube: onto the wall they crossed, or mirrored by it."""
    if walls == "reflect":
        u = np.abs(u) % 2.0
        u = np.where(u > 1.0, 2.0 - u, u)
    at_least_0 = np.maximum(u, 0.0)
    return np.minimum(at_least_0, 1.0, out=at_least_0)


def neighbourhood(
    rng: Rng, centre: Array, reach: Array, n: int, walls: Walls, lie: Neighbours = "within"
) -> Array:
    """`n` points about `centre`, shape (n, dim).

    Uniform in the box of half-widths `reach`, or at that distance, in directions drawn there.
    """
    u = rng.random((n, len(centre)))
    u *= 2.0
    u -= 1.0
    if lie == "at":
        u /= np.linalg.norm(u, axis=1, keepdims=True)
    u *= reach
    u += centre
    return inside(u, walls)


def gaps(a: Array, b: Array) -> Array:
    """The ways from each of b (k, dim) to each of a (n, dim), shape (n, k, dim)."""
    # Repeated rows rather than a[:, None]: it is the long inner loop that makes this fast.
    return a.repeat(len(b), axis=0).reshape(len(a), *b.shape) - b


def squares(a: Array, b: Array) -> Array:
    """Squared distances from each of a (n, dim) to each of b (k, dim), (n, k), to 1e-15."""
    # One product of matrices: nothing of shape (n, k, dim) is ever made.
    norms_a, norms_b = np.einsum("nd,nd->n", a, a), np.einsum("kd,kd->k", b, b)
    gram: Array = a @ b.T
    gram *= -2.0
    gram += norms_a[:, None]
    gram += norms_b
    return gram
