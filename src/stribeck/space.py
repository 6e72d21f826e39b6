"""A bounded search space and its map to the unit cube."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator

Array = NDArray[np.float64]
Rng = np.random.Generator


def contiguous(values: ArrayLike) -> Array:
    """Numbers as compiled code takes them: floats, one beside the other."""
    return np.ascontiguousarray(values, dtype=float)


#: Widths of a range that can be searched.
_NARROWEST, _WIDEST = 1e-100, 1e100


@dataclass(frozen=True, slots=True)
class Param:
    """One scalar to be found: its name, its range and its unit, in SI.

    Args:
        name: What it is called in tables, cards and on the command line.
        lower: Least value, in `unit`.
        upper: Greatest value, in `unit`; above `lower`.
        unit: SI unit.
        symbol: How a figure prints it (matplotlib mathtext); the name if empty.
        log: Whether the range is searched on a logarithmic scale; needs `lower` > 0.
        fixed: The value it holds unless somebody frees it; None for a parameter to be found.
        doc: Its meaning in half a line.
    """

    name: str
    lower: float
    upper: float
    unit: str = ""
    symbol: str = ""
    log: bool = False
    fixed: float | None = None
    doc: str = ""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.lower) and math.isfinite(self.upper)):
            raise InputError(f"{self.name}: range {self.lower}:{self.upper} is not finite")
        if not self.lower < self.upper:
            raise InputError(f"{self.name}: lower {self.lower} is not below upper {self.upper}")
        if not _NARROWEST <= self.upper - self.lower <= _WIDEST:
            raise InputError(
                f"{self.name}: range {self.lower:g}:{self.upper:g} cannot be searched: a range is "
                f"from {_NARROWEST:g} to {_WIDEST:g} wide"
            )
        if self.log and 0 < self.lower < _NARROWEST:
            raise InputError(
                f"{self.name}: range {self.lower:g}:{self.upper:g} begins below {_NARROWEST:g}"
            )
        if self.log and self.lower <= 0:
            raise InputError(f"{self.name}: a log range needs lower > 0, got {self.lower}")


@dataclass(frozen=True)
class Space:
    """Parameters in order. Searches see the unit cube; costs see physical values (SI)."""

    params: tuple[Param, ...]

    def __post_init__(self) -> None:
        names = [p.name for p in self.params]
        if not names:
            raise InputError("a space needs at least one parameter")
        if doubled := {n for n in names if names.count(n) > 1}:
            raise InputError(f"parameter named twice: {', '.join(sorted(doubled))}")

    def __iter__(self) -> Iterator[Param]:
        return iter(self.params)

    @property
    def dim(self) -> int:
        """How many parameters there are."""
        return len(self.params)

    @property
    def names(self) -> tuple[str, ...]:
        """Their names, in order."""
        return tuple(p.name for p in self.params)

    @cached_property
    def lower(self) -> Array:
        """Lower bounds, shape (dim,)."""
        return np.array([p.lower for p in self.params])

    @cached_property
    def upper(self) -> Array:
        """Upper bounds, shape (dim,)."""
        return np.array([p.upper for p in self.params])

    @cached_property
    def _range(self) -> Array:
        return self.upper - self.lower

    @cached_property
    def _log(self) -> NDArray[np.intp]:
        return np.flatnonzero([p.log for p in self.params])

    @cached_property
    def _exact(self) -> bool:
        # Sums and products round monotonically: if the corner does not pass `upper`, no point does.
        return not self._log.size and bool((self.lower + self._range <= self.upper).all())

    def sample(self, rng: Rng, n: int) -> Array:
        """`n` points uniform in the unit cube, shape (n, dim)."""
        return rng.random((n, self.dim))

    def decode(self, u: Array, *, inside: bool = False) -> Array:
        """(n, dim) points of the unit cube to (n, dim) physical values, never outside the box.

        Args:
            u: The points.
            inside: Whether they are known to be in the cube.
        """
        x = u * self._range
        x += self.lower
        if self._log.size:
            ratio = self.upper[self._log] / self.lower[self._log]
            x[:, self._log] = self.lower[self._log] * ratio ** u[:, self._log]
        if not (self._exact and (inside or in_cube(u))):
            np.minimum(np.maximum(x, self.lower, out=x), self.upper, out=x)
        return x

    def encode(self, x: Array) -> Array:
        """(n, dim) physical values to (n, dim) points of the unit cube, clipped into it."""
        u = (x - self.lower) / self._range
        if self._log.size:
            lower, upper = self.lower[self._log], self.upper[self._log]
            inside = np.clip(x[:, self._log], lower, upper)
            u[:, self._log] = np.log(inside / lower) / np.log(upper / lower)
        return np.minimum(np.maximum(u, 0.0), 1.0)


def in_cube(u: Array) -> bool:
    """Whether these are all points of the unit cube; nan is not."""
    # On a small array, argmin is several times as fast as min. It finds nan, too.
    return u.size == 0 or bool(u.item(u.argmin()) >= 0.0 and u.item(u.argmax()) <= 1.0)


def box(bounds: Space | Array | list[tuple[float, float]]) -> Space:
    """A space from (dim, 2) bounds, with parameters named x1, x2, ...

    Raises:
        InputError: the bounds are not pairs of finite numbers, lower below upper.
    """
    if isinstance(bounds, Space):
        return bounds
    try:
        pairs = np.asarray(bounds, dtype=float)
    except (TypeError, ValueError):
        raise InputError(
            f"bounds must be (lower, upper) pairs of numbers, got {bounds!r}"
        ) from None
    if pairs.ndim != 2 or pairs.shape[1] != 2:  # noqa: PLR2004 - a pair has two ends
        raise InputError(f"bounds must be (lower, upper) pairs, got shape {pairs.shape}")
    return Space(tuple(Param(f"x{i}", lo, hi) for i, (lo, hi) in enumerate(pairs.tolist(), 1)))
