"""The paper's five test surfaces (Table 1), in any dimension, and their twins.

A twin is a surface shifted and rotated by a seed. Two of the five have their optimum in the
middle of the box and three are sums over the coordinates: methods that are drawn to the middle,
or that walk along the axes, find them by that accident, and do not find their twins.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache, reduce
from itertools import islice, product
from typing import Any

import numpy as np
from numpy.random import SeedSequence, default_rng

from ..errors import InputError
from ..space import Array, Rng, Space, box

#: Most variables a surface may have: with some more, Shubert's product overflows.
MOST_VARIABLES = 256
#: Most optima that a surface lists.
MOST_OPTIMA = 5000


@dataclass(frozen=True, eq=False)
class Surface:
    """A test function on the cube [-half, half]^dim: a Problem that knows its answer.

    Args:
        name: The paper's abbreviation, with the dimension unless it is 2: "RF", "RF-d5".
        title: Its full name.
        dim: How many variables it has.
        half: The box is [-half, half] in every coordinate.
        J_min: The cost at or below which the paper ends a search.
        minimum: The least value in the box.
        ceiling: A value it does not exceed in the box; a twin's is that of its original.
        optima: Where it is least, shape (k, dim), read-only. All places, or, where these are more
            than `MOST_OPTIMA`, those of them nearest the middle.
        function: (dim, n) coordinates to (n,) values, each from its own column alone.
    """

    name: str
    title: str
    dim: int
    half: float
    J_min: float
    minimum: float
    ceiling: float
    optima: Array = field(repr=False)
    function: Callable[[Array], Array] = field(repr=False)

    def __post_init__(self) -> None:
        self.optima.setflags(write=False)

    @property
    def space(self) -> Space:
        """The search space."""
        return box([(-self.half, self.half)] * self.dim)

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) points to (n,) values; rows are independent, bit for bit."""
        return self.function(np.ascontiguousarray(x.T))


def surface(name: str, dim: int | None = None, twin: int | None = None) -> Surface:
    """A surface of Table 1, always the same object, or a twin of it; the last 256 twins are kept.

    RF, SchF and ShuF extend to any number of variables; BF and SF are of two by definition.
    J_min is Table 1's, but for ShuF, whose least value hangs on the dimension: there it is as
    close to the least value, relative to its size, as Table 1's is in two dimensions.

    Args:
        name: "BF", "RF", "SF", "SchF" or "ShuF".
        dim: How many variables; None for Table 1's two.
        twin: None for the surface itself, or the seed of its shift and rotation (`Moved`).

    Raises:
        InputError: there is no such surface.
    """
    dim = 2 if dim is None else dim
    if name not in _FAMILIES:
        raise InputError(f"no surface {name!r}: there are {', '.join(_FAMILIES)}")
    if not _whole(dim) or not 1 <= dim <= MOST_VARIABLES:
        raise InputError(f"{name}: dim is a whole number from 1 to {MOST_VARIABLES}, got {dim!r}")
    if name in _OF_TWO and dim != 2:  # noqa: PLR2004 - of two variables
        raise InputError(f"{name} is a function of 2 variables, not of {dim}")
    if twin is not None and (not _whole(twin) or twin < 0):
        raise InputError(f"{name}: twin is a seed, a whole number from 0, got {twin!r}")
    return _declared(name, dim) if twin is None else _moved(name, dim, twin)


def _whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


@cache
def _declared(name: str, dim: int) -> Surface:
    return _FAMILIES[name](dim)


@lru_cache(maxsize=256)
def _moved(name: str, dim: int, twin: int) -> Surface:
    return _twin(_declared(name, dim), twin)


# ---- Table 1 -----------------------------------------------------------------------------------
# Rows are added and multiplied one by one: NumPy's own sums take another order when there is but
# one point.


def bohachevsky(x: Array) -> Array:
    """BF of Table 1; 1 - cos 2a is written 2 sin^2 a, so that rounding never gets below 0."""
    a, b = x
    waves = 0.6 * np.sin(1.5 * np.pi * a) ** 2 + 0.8 * np.sin(2 * np.pi * b) ** 2
    cost: Array = a**2 + 2 * b**2 + waves
    return cost


def rastrigin(x: Array) -> Array:
    """RF of Table 1; 1 - cos 2a is written 2 sin^2 a, so that rounding never gets below 0."""
    return _total(x**2 + 20 * np.sin(np.pi * x) ** 2)


# Table 1's matrix a_ij: the holes of the second row follow one another along the first.
_HOLES = np.arange(-32.0, 33.0, 16.0)


def foxholes(x: Array) -> Array:
    """Shekel's foxholes, SF of Table 1."""
    square = (x[:, :, None] - _HOLES) ** 2
    along, across = square**2 * square
    sixth = (across[:, :, None] + along[:, None, :]).reshape(-1, 25)
    holes: Array = (1.0 / (np.arange(1, 26) + sixth)).sum(axis=1)
    return 1.0 / (1.0 / 500.0 + holes)


def schwefel(x: Array) -> Array:
    """SchF of Table 1, with the |x| that its print lost: sin sqrt|x|."""
    return _total(418.9829 - x * np.sin(np.sqrt(np.abs(x))))


def shubert(x: Array) -> Array:
    """ShuF of Table 1: a product of one and the same sum in each coordinate."""
    factors: Array = sum((i * np.cos((i + 1) * x + i) for i in range(2, 6)), np.cos(2 * x + 1))
    return reduce(np.multiply, factors)


def _total(rows: Iterable[Array]) -> Array:
    return reduce(np.add, rows)


def _bohachevsky(dim: int) -> Surface:
    return Surface("BF", "Bohachevsky", dim, 2.0, J_min=1e-9, minimum=0.0, ceiling=12.0,
                   optima=np.zeros((1, dim)), function=bohachevsky)  # fmt: skip


def _rastrigin(dim: int) -> Surface:
    return Surface(_label("RF", dim), "Rastrigin", dim, 2.0, J_min=1e-8, minimum=0.0,
                   ceiling=22.261458884805925 * dim,
                   optima=np.zeros((1, dim)), function=rastrigin)  # fmt: skip


def _foxholes(dim: int) -> Surface:
    return Surface("SF", "Shekel's foxholes", dim, 40.0, J_min=0.9990,
                   minimum=0.9980038377944502, ceiling=500.0,
                   optima=np.array([[-31.97833483565697, -31.978334837300796]]),
                   function=foxholes)  # fmt: skip


def _schwefel(dim: int) -> Surface:
    # The least of 418.9829 - x sin sqrt|x|: the printed constant is a little too great, and the
    # rest counts once a coordinate. x sin sqrt|x| is odd, so the greatest value mirrors the least.
    remainder = 1.2727566293696535e-05
    return Surface(_label("SchF", dim), "Schwefel", dim, 500.0, J_min=1e-1, minimum=remainder * dim,
                   ceiling=(2 * 418.9829 - remainder) * dim,
                   optima=np.full((1, dim), 420.96874635998205), function=schwefel)  # fmt: skip


# Greatest and least value of Shubert's sum of one coordinate, and where; it repeats every 2 pi.
_HIGH, _HIGH_AT = 14.508007927195033, -0.8003211004719731
_LOW, _LOW_AT = -12.870885497725684, -1.425128428319761


def _shubert(dim: int) -> Surface:
    """ShuF: least where one factor is at its least and all others at their greatest.

    The product is negative with an odd number of negative factors; as |_LOW| < _HIGH, it is the
    farthest below 0 with one of them. Each coordinate has 3 periods: dim 3^dim places.
    """
    least = _LOW * _HIGH ** (dim - 1)
    return Surface(_label("ShuF", dim), "Shubert", dim, 10.0,
                   J_min=-186.73 * _HIGH ** (dim - 2), minimum=least, ceiling=_HIGH**dim,
                   optima=_shubert_optima(dim), function=shubert)  # fmt: skip


def _shubert_optima(dim: int) -> Array:
    """Those in the middle period first; these alone if all are too many."""
    at = np.where(np.eye(dim, dtype=bool), _LOW_AT, _HIGH_AT)
    listed = dim * 3**dim <= MOST_OPTIMA
    periods = islice(product((0, 1, -1), repeat=dim), None if listed else 1)
    shifts = 2 * np.pi * np.array(list(periods))
    places: Array = (shifts[:, None, :] + at).reshape(-1, dim)
    return places


def _label(name: str, dim: int) -> str:
    return name if dim == 2 else f"{name}-d{dim}"  # noqa: PLR2004 - Table 1's own


# ---- twins -------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Moved:
    """A surface's function, shifted and rotated.

    The twin at x is the surface at y = from_ + turn (x - to). The twin has the surface's box, and
    where y falls outside it, the twin is the surface at the nearest point of the wall plus a fee:
    per half width of the box between y and the wall, the whole range of the surface's values.
    A fee is never below 0, and 0 at the wall: no value is below the surface's least, and the twin
    is continuous.

    Args:
        own: The surface.
        turn: Proper rotation, shape (dim, dim).
        from_: The surface's optimum that is moved, shape (dim,).
        to: Where it goes, shape (dim,).
    """

    own: Surface
    turn: Array
    from_: Array
    to: Array

    def __call__(self, x: Array, /) -> Array:
        """(dim, n) coordinates to (n,) values, each from its own column alone."""
        own = self.own
        # Term by term: a matrix product adds in another order for other numbers of points.
        terms = (self.turn[:, j, None] * (x[j] - self.to[j]) for j in range(own.dim))
        y = self.from_[:, None] + _total(terms)
        wall = np.clip(y, -own.half, own.half)
        fee = (own.ceiling - own.minimum) / own.half * np.sqrt(_total((y - wall) ** 2))
        return own.function(wall) + fee

    def images(self, places: Array) -> Array:
        """Where the twin has what the surface has at places, shape (k, dim)."""
        moved: Array = self.to + (places - self.from_) @ self.turn
        return moved


def _twin(original: Surface, seed: int) -> Surface:
    """The surface with its optimum (the one nearest the middle) moved and the box turned.

    The optimum goes to a place uniform in the central 80 % of the box, by a rotation uniform
    among all. Different surfaces and dimensions draw differently from one seed.
    """
    rng = default_rng(
        SeedSequence(seed, spawn_key=(zlib.crc32(original.name.encode()), original.dim))
    )
    turn = rotation(rng, original.dim)
    to = 0.8 * original.half * (2 * rng.random(original.dim) - 1)
    nearest = np.argmin((original.optima**2).sum(axis=1))
    moved = Moved(original, turn, original.optima[nearest], to)
    images = moved.images(np.delete(original.optima, nearest, axis=0))
    images = images[(np.abs(images) <= original.half).all(axis=1)]
    return replace(
        original,
        name=f"{original.name}-twin{seed}",
        title=f"{original.title}, twin {seed}",
        optima=np.vstack([to, images]),
        function=moved,
    )


def rotation(rng: Rng, dim: int) -> Array:
    """A rotation (determinant 1) uniform among all, shape (dim, dim).

    The orthogonal factor of a Gaussian matrix whose triangular factor has a positive diagonal
    (Mezzadri 2007, Notices of the AMS 54:592), by Gram and Schmidt's steps: LAPACK's last bits
    hang on the machine's kernels and threads, and a twin should be the same everywhere.
    """
    rows: list[Array] = []
    for drawn in rng.standard_normal((dim, dim)):
        row = drawn
        for done in rows * 2:  # once leaves what rounding left
            row = row - (row * done).sum() * done
        rows.append(row / np.sqrt((row * row).sum()))
    turn = np.array(rows)
    turn[0] *= np.linalg.slogdet(turn).sign  # a reflection becomes a rotation
    return turn


_FAMILIES: dict[str, Callable[[int], Surface]] = {
    "BF": _bohachevsky,
    "RF": _rastrigin,
    "SF": _foxholes,
    "SchF": _schwefel,
    "ShuF": _shubert,
}
_OF_TWO = {"BF", "SF"}

#: The five of Table 1.
SURFACES: dict[str, Surface] = {name: surface(name) for name in _FAMILIES}
