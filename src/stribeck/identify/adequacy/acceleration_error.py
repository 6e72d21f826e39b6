"""Patterns of an inertia, judged without what the error of the acceleration makes of them.

Noise of the acceleration makes the inertia of slow strokes, which hardly accelerate, smaller than
that of fast ones: where one come after the other, it seems to change. Products of noisy columns
grow with the square of the noise, so that what they are without it is what they are less what the
same noise once more adds to them (corrected least squares: Fuller 1987, Measurement Error Models,
section 2.2; corrected scores: Nakamura 1990, doi 10.1093/biomet/77.1.127).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from .bins import clustered_probability
from .patterns import Pattern
from .remainder import Remainder

#: A column of which no more than this share is left without the error is that error.
_ERROR_ALONE = 0.01
#: Numbers in the patterns that are looked at together, at most.
_NUMBERS = 1 << 21


def without_motion_error(
    remainder: Remainder, patterns: Sequence[Pattern], block: NDArray[np.intp]
) -> tuple[list[float], list[float]]:
    """The share of a residual that each of some patterns explains, and its probability by chance.

    Args:
        remainder: Whose rows have the error of the motion once more.
        patterns: Of one column each, in proportion to the acceleration.
        block: The block of each row, (rows,), rising.
    """
    at_once = max(_NUMBERS // max(len(block), 1), 1)
    gains, chances = [], []
    for first in range(0, len(patterns), at_once):
        columns = np.column_stack([p.columns for p in patterns[first : first + at_once]])
        shares, by_chance = _judged(remainder, columns, block)
        gains += shares.tolist()
        chances += by_chance.tolist()
    return gains, chances


def _judged(remainder: Remainder, columns: Array, block: NDArray[np.intp]) -> tuple[Array, Array]:
    """The shares and the probabilities of columns, (rows, m), by one pass for each."""
    rows = remainder.source
    shapes = columns / np.where(rows.inertial == 0, np.inf, rows.inertial)[:, None]

    def without_error(of: Callable[[Array, Array, Array], Array]) -> Array:
        """What something would be of parameters' and patterns' columns and of the residual."""
        return rows.without_error(
            lambda r: of(
                np.column_stack([r.jacobian, remainder.columns]),
                shapes * r.inertial[:, None],
                r.residual,
            )
        )

    k = rows.jacobian.shape[1] + remainder.columns.shape[1]

    def products(known: Array, new: Array, left: Array) -> Array:
        of_known = known.T @ np.column_stack([known, new, left])
        of_new = [np.einsum("ij,ij->j", new, new), new.T @ left]
        return np.concatenate([of_known.ravel(), *of_new])

    every = without_error(products)
    ends = np.cumsum([k * (k + columns.shape[1] + 1), columns.shape[1]])
    mixed, lengths, inner = np.split(every, ends)
    of_known, with_new, with_left = np.split(mixed.reshape(k, -1), [k, -1], axis=1)
    scale = np.sqrt(np.maximum(np.diag(of_known), np.finfo(float).tiny))
    inverse = np.linalg.pinv(of_known / np.outer(scale, scale), rcond=1e-9, hermitian=True)
    inverse /= np.outer(scale, scale)
    along, values = inverse @ with_new, inverse @ with_left[:, 0]
    lengths = lengths - np.einsum("ij,ij->j", with_new, along)
    inner = inner - with_new.T @ values
    sizes = np.sqrt(np.einsum("ij,ij->j", columns, columns))
    lengths = np.where(lengths > _ERROR_ALONE * sizes**2, lengths, np.inf)
    weights = inner / lengths
    starts = np.flatnonzero(np.diff(block, prepend=-1))

    def scores(known: Array, new: Array, left: Array) -> Array:
        across = new - known @ along
        residual = (left - known @ values)[:, None] - weights * across
        return np.stack([
            np.add.reduceat(across * residual, starts, axis=0),
            np.add.reduceat(across * across, starts, axis=0),
        ])  # fmt: skip

    chances = clustered_probability(inner, *without_error(scores))
    left = remainder.rows.residual
    return inner * weights / float(left @ left), np.where(np.isfinite(lengths), chances, 1.0)
