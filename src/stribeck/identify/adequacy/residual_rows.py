"""Residual forces of a fit, row by row, beside the motion in which they occurred."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from ..uncertainty.covariance import correlation_time
from .bins import BINS, between, bin_of

#: A row slides if its speed is above this share of the top speed and its neighbours go its way.
SLIDING = 0.01
#: A block is as long as this many correlation times, so that blocks hardly know of each other.
FORGETFUL = 8.0
#: Fewest blocks, of fewer chance cannot be told from a pattern; and most, for speed.
FEWEST, MOST_BLOCKS = 24, 96
#: Fewest rows.
ROWS = 5 * BINS


@dataclass(frozen=True, eq=False)
class ResidualRows:
    """Residual forces, and what they may depend on; SI, rows of a log in order of time.

    Args:
        log: Which log a row is of, (rows,).
        t: Time, (rows,).
        position: (rows,).
        velocity: (rows,).
        acceleration: (rows,).
        residual: Measured less modelled force, (rows,).
        jacobian: Slopes of the modelled force over the free parameters, (rows, free).
        names: Of the free parameters.
        values: Theirs, SI, (free,).
        half_widths: Half the length of their intervals, SI, (free,).
        other: Velocity as measured, where the others are of the model's motion: a row counts only
            if both slide the same way, (rows,).
        reach: Rows to each side that a filter mixes with one.
        sampling: What sampling leaves at most of the force of a model that is right, (rows, any).
        pace: Speed below which it does not slide, SI; a share of the top speed if that is more.
        thinned: Acceleration thinned as the force is, by which its inertia is known, (rows,); the
            acceleration itself where None.
        noisier: Thinned acceleration, residual and jacobian of all rows with the error of the
            motion added once more, by chance, several times; None where the motion has none.
        place: Of each row among those, (rows,).
    """

    log: NDArray[np.intp]
    t: Array
    position: Array
    velocity: Array
    acceleration: Array
    residual: Array
    jacobian: Array = field(repr=False)
    names: tuple[str, ...]
    values: Array
    half_widths: Array
    other: Array | None = None
    pace: float = 0.0
    reach: int = 1
    sampling: Array | None = field(default=None, repr=False)
    thinned: Array | None = field(default=None, repr=False)
    noisier: Callable[[], Iterator[tuple[Array, Array, Array]]] | None = None
    place: NDArray[np.int32] | None = field(default=None, repr=False)

    def __len__(self) -> int:
        return len(self.t)

    @property
    def direction(self) -> Array:
        """Sign of the velocity, (rows,)."""
        direction: Array = np.sign(self.velocity)
        return direction

    @property
    def inertial(self) -> Array:
        """Acceleration that a force of inertia is in proportion to, (rows,)."""
        return self.acceleration if self.thinned is None else self.thinned

    @property
    def logs(self) -> tuple[int, ...]:
        """Rows of each log, in order."""
        return tuple(np.unique(self.log, return_counts=True)[1].tolist())

    @cached_property
    def since(self) -> Array:
        """Time since the first row of the log, s, (rows,)."""
        _, which = np.unique(self.log, return_inverse=True)
        first = np.full(int(which.max(initial=-1)) + 1, np.inf)
        np.minimum.at(first, which, self.t)
        since: Array = self.t - first[which]
        return since

    def variable(self, name: str) -> Array:
        """What a residual may depend on, by name, (rows,)."""
        values = {
            "speed": self.velocity,
            "position": self.position,
            "time": self.since,
            "acceleration": self.acceleration,
        }
        chosen: Array = values[name]
        return chosen

    def rows(self, chosen: NDArray[np.bool_]) -> ResidualRows:
        """The rows that are chosen."""
        arrays = ("log", "t", "position", "velocity", "acceleration", "residual", "jacobian")
        columns = {name: getattr(self, name)[chosen] for name in arrays}
        for name in ("other", "sampling", "thinned", "place"):
            values = getattr(self, name)
            columns[name] = None if values is None else values[chosen]
        return replace(self, **columns)

    def without_error(self, of: Callable[[ResidualRows], Array]) -> Array:
        """What something of the rows would be without the error of the motion.

        Args:
            of: It: sums of products of columns, which grow with the square of that error.
        """
        first: Array = of(self)
        more = [of(rows) for rows in self._with_more_error()]
        return 2.0 * first - np.mean(more, axis=0) if more else first

    def _with_more_error(self) -> Iterator[ResidualRows]:
        """The rows with the error of the motion added once more, by chance, several times."""
        if self.noisier is None or self.place is None:
            return
        for thinned, residual, jacobian in self.noisier():
            at = self.place
            yield replace(self, thinned=thinned[at], residual=residual[at], jacobian=jacobian[at])

    def sliding(self) -> ResidualRows:
        """The rows in which the axis slides, and has and will as far as a filter reaches.

        A filter that mixes the two sides of a reversal leaves a residual there that is its own.
        """
        pace = max(self.pace, SLIDING * float(np.abs(self.velocity).max()))
        direction = np.where(np.abs(self.velocity) > pace, self.direction, 0.0)
        if self.other is not None:
            direction[direction * self.other <= pace] = 0.0
        same = direction != 0
        for k in range(1, self.reach + 1):
            alike = (direction[k:] == direction[:-k]) & (self.log[k:] == self.log[:-k])
            same[k:] &= alike
            same[:-k] &= alike
            same[:k] = same[-k:] = False
        return self.rows(same)


def blocks(rows: ResidualRows) -> NDArray[np.intp]:
    """The block of each row: consecutive rows of a log, long enough to forget the block before.

    How long noise remembers is seen in what is left once every pattern has been taken out.
    """
    left = rows.residual
    for name in ("speed", "position", "time", "acceleration"):
        which = bin_of(rows.variable(name))
        left = left - between(left, which)
        left = left - rows.direction * between(left * rows.direction, which)
    length = int(np.ceil(FORGETFUL * correlation_time(left, rows.logs)))
    length = max(min(length, len(rows) // FEWEST), len(rows) // MOST_BLOCKS, 1)
    result = np.zeros(len(rows), dtype=np.intp)
    first = offset = 0
    for n in rows.logs:
        count = max(round(n / length), 1)
        result[offset : offset + n] = first + np.arange(n) * count // n
        first += count
        offset += n
    return result
