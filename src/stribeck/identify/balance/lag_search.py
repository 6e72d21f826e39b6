"""The sum of squares of a force balance over the time between force and motion.

The force of a log is moved against the motion by whole rows, and the balance solved anew for each
lag. What that takes are sums over the rows: those of the motion change with the lag at the ends of
a log alone, and those with the force are a correlation, so that all lags together cost little more
than one. Parts of the data may each have a lag of their own, with one set of parameters.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...data.filtering import decimate
from ...space import Array

if TYPE_CHECKING:
    from .balance import Balance
    from .rows import Log

#: A sum of squares of columns is taken as singular below this share of its diagonal.
_RIDGE = 1e-9
#: A column of length one of which a lag leaves less than this share of its square has been moved
#: out of the log: what sums that were taken off each other still hold of it is rounding.
_GONE = 1e-12
#: Parts are moved in turn, each so often.
_SWEEPS = 3


@dataclass(frozen=True, eq=False)
class LagSums:
    """Sums over the rows of a part at each lag; columns are those of the linear parameters.

    Args:
        gram: Of the columns with each other, (lags, k, k).
        cross: Of the columns with the force, (lags, k).
        square: Of the force with itself, (lags,).
        rows: How many rows there are, (lags,).
        moved_out: Sum of squares, about its mean, of the force that a lag moves beyond the first
            or the last row of its log, (lags,). A lag that leaves nothing to explain of the only
            start of a motion does not explain it.
    """

    gram: Array
    cross: Array
    square: Array
    rows: Array
    moved_out: Array

    def __add__(self, other: LagSums) -> LagSums:
        return LagSums(
            self.gram + other.gram,
            self.cross + other.cross,
            self.square + other.square,
            self.rows + other.rows,
            self.moved_out + other.moved_out,
        )

    def at(self, k: int) -> LagSums:
        """The sums at one lag, for all to be added to."""
        return LagSums(self.gram[k], self.cross[k], self.square[k], self.rows[k], self.moved_out[k])

    def left(self) -> Array:
        """What is left of the force per row, with what is moved out of the log, (lags,)."""
        return np.asarray(self.variance() + self.moved_out / np.maximum(self.rows, 1))

    def variance(self) -> Array:
        """Mean square that the columns leave of the force, (lags,); inf where too few rows are."""
        k = self.cross.shape[-1]
        diagonal = np.einsum("...ii->...i", self.gram)
        seen = (diagonal > _GONE) & np.asarray(self.rows > k)[..., None]
        scale = np.where(seen, 1.0 / np.sqrt(np.where(seen, diagonal, 1.0)), 0.0)
        scaled = self.gram * scale[..., :, None] * scale[..., None, :]
        scaled += np.where(seen, _RIDGE, 1.0)[..., None] * np.eye(k)
        right = self.cross * scale
        x = np.linalg.solve(scaled, right[..., None])[..., 0]
        squares = np.maximum(self.square - (x * right).sum(axis=-1), 0.0)
        return np.asarray(np.where(self.rows > k, squares / np.maximum(self.rows - k, 1), np.inf))


def lag_sums(solution: Balance, lags: Array, parts: NDArray[np.intp]) -> list[LagSums]:
    """The sums of each part of the rows.

    Args:
        solution: A solved balance.
        lags: By how much later the force was measured, s, evenly spaced, (lags,).
        parts: Number of the part of each row, from 0, (rows,).
    """
    W, rest = columns(solution)
    rest = rest + solution.system.known  # that stays with the motion
    y = solution.system.y
    count = int(parts.max()) + 1
    totals: list[LagSums | None] = [None] * count
    first = 0
    for log in solution.system.logs:
        own = slice(first, first + len(log.t))
        first = own.stop
        for part in np.unique(parts[own]):
            rows = np.flatnonzero(parts[own] == part)
            sums = _sums(log, rows, W[own][rows], rest[own][rows], lags)
            sums = replace(sums, moved_out=_moved_out(log, y[own], rows, lags))
            before = totals[part]
            totals[part] = sums if before is None else before + sums
    return [sums for sums in totals if sums is not None]


def columns(solution: Balance) -> tuple[Array, Array]:
    """Columns of one length of what is free, (rows, k), and the force that they are not asked for.

    Those of a parameter that a bound stopped count, too: at another lag it may be free of it.
    """
    system = solution.system
    W = solution.jacobian
    linear = [k for k, i in enumerate(system.free) if i in system.linear]
    shape = [
        k for k, i in enumerate(system.free)
        if i not in system.linear and np.isfinite(solution.covariance[k, k])
    ]  # fmt: skip
    p = solution.values.copy()
    p[system.linear] = 0.0
    used = W[:, linear + shape]
    lengths = np.linalg.norm(used, axis=0)
    used = used if lengths.all() else used[:, lengths > 0]
    used /= lengths[lengths > 0]
    return used, system.predicted(p[None])[:, 0]


def _sums(log: Log, rows: NDArray[np.intp], W: Array, rest: Array, lags: Array) -> LagSums:
    """The sums of some rows of one log."""
    force = decimate(log.raw, log.factor)
    m, k = len(force), W.shape[1]
    at = np.flatnonzero(log.counts)[rows]
    moved = np.rint(lags * log.row_rate).astype(int)
    Z = np.zeros((m, k + 2))
    Z[at, :k], Z[at, k], Z[at, k + 1] = W, rest, 1.0
    G = _products(Z, moved)
    with_force = _correlations(Z.T, force, moved)
    with_square = _correlations(Z[None, :, k + 1], force**2, moved)[:, 0]
    return LagSums(
        G[:, :k, :k],
        with_force[:, :k] - G[:, :k, k],
        with_square - 2.0 * with_force[:, k] + G[:, k, k],
        G[:, k + 1, k + 1],
        np.zeros(len(moved)),
    )


def _moved_out(log: Log, y: Array, rows: NDArray[np.intp], lags: Array) -> Array:
    """What a part of some rows of a log with the forces y loses at either end of the log, (lags,).

    Of parts between the ends nothing leaves the log.
    """
    total, last = np.zeros(len(lags)), len(y) - 1
    early = np.searchsorted(log.t, log.t[0] + lags)
    late = len(y) - np.searchsorted(log.t, log.t[-1] + lags, side="right")
    ends = [(y, early)] if rows[0] == 0 else []
    ends += [(y[::-1], late)] if rows[-1] == last else []
    for force, count in ends:
        sums, squares = (np.append(0.0, np.cumsum(power))[count] for power in (force, force**2))
        total += squares - sums**2 / np.maximum(count, 1)
    return total


def _products(Z: Array, moved: NDArray[np.intp]) -> Array:
    """Sums of products of columns over the rows whose force lies in the log, (lags, k, k).

    These are all rows but as many at one end as the force is moved by.
    """
    most = min(int(np.abs(moved).max(initial=0)), len(Z))
    k = Z.shape[1]
    whole = np.einsum("ij,ik->jk", Z, Z)
    first, last = (
        np.concatenate([np.zeros((1, k, k)), np.cumsum(end[:, :, None] * end[:, None], axis=0)])
        for end in (Z[:most], Z[: len(Z) - most - 1 : -1])
    )
    gone = np.minimum(np.abs(moved), most)
    return np.asarray(whole - np.where((moved > 0)[:, None, None], last[gone], first[gone]))


def _correlations(columns: Array, force: Array, moved: NDArray[np.intp]) -> Array:
    """Sums of z[t] force[t + lag] over t of columns z, (k, n): zero beyond the ends, (lags, k)."""
    from scipy.fft import irfft, next_fast_len, rfft  # noqa: PLC0415 - slow to import

    n = next_fast_len(len(force) + int(np.abs(moved).max(initial=0)), real=True)
    spectrum = rfft(force, n)
    sums = np.empty((len(moved), len(columns)))
    for own, z in zip(sums.T, columns, strict=True):
        product = np.conj(rfft(z, n))
        product *= spectrum
        own[:] = irfft(product, n)[np.mod(moved, n)]
    return sums


def best_lags(sums: list[LagSums], start: int) -> list[int]:
    """For each part the lag, by its place, with which all parts leave least, from one for all."""
    places = [start] * len(sums)
    for _ in range(_SWEEPS):
        before = list(places)
        for i, own in enumerate(sums):
            others = [s.at(places[j]) for j, s in enumerate(sums) if j != i]
            total = own
            for other in others:
                total = total + other
            left = total.left()
            least = int(np.argmin(left))
            if left[least] < left[places[i]]:
                places[i] = least
        if places == before:
            break
    return places
