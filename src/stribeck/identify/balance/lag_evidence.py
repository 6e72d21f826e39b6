"""How well a sum of squares tells a lag from another one, when all lags about it were tried.

About a minimum its curvature tells the error of a lag, and says nothing of whether that minimum is
one by chance: noise that is moved along a motion without starts and reversals fits it somewhere
better than where it is. So beyond a row the error is at least what the fall of the sum of squares
is worth: that of so many rows as the residuals are independent, by a chance that counts every lag
that lies as near (the correction of Bonferroni).

A lag also takes other samples of the force than the one that it is held against, as many as it is
long, and their noise is another one. Of d independent samples that are exchanged for others the
difference of the sums of squares over their variance has the standard deviation 2 sqrt(d), whatever
the lag explains.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtrc, ndtr, ndtri

from ...space import Array

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .lag_search import LagSums


def searched_errors(
    distance: Array,
    errors: Array,
    ratio: Array,
    effective: float,
    *,
    row: float,
    span: float,
    reach: float,
) -> Array:
    """Standard errors of lags, s, which count that others were tried, (k,).

    Args:
        distance: Of each lag from the one that it is held against, s, (k,).
        errors: By the curvature about it, s, (k,).
        ratio: Mean square of the residuals at the other lag by that at this one, (k,).
        effective: Rows over the time in which the residuals forget.
        row: From one lag to the next, s.
        span: How long a log is, s: a lag that long exchanges all samples.
        reach: How far was searched, s, and the most that an error is.
    """
    size = np.abs(distance)
    gain = effective * np.log(np.maximum(ratio, 1.0))
    exchanged = effective * np.minimum(size / span, 1.0)
    scatter = 2.0 * np.sqrt(np.maximum(exchanged, np.finfo(float).tiny))
    once = np.maximum(chdtrc(1.0, gain), ndtr(-gain / scatter))
    chance = np.minimum((1.0 + 2.0 * size / row) * once, 1.0)
    sigmas = np.abs(ndtri(0.5 * chance))  # inf where the chance is too small to be written
    least = size / np.maximum(sigmas, np.maximum(size / reach, np.finfo(float).tiny))
    return np.where(size > row, np.fmax(errors, least), errors)


def ratios(sums: Sequence[LagSums], places: Sequence[int], common: int) -> Array:
    """What is left of a row's square with each part at a common lag over that at its own, (parts,).

    1, which tells nothing, where a lag leaves too few rows to say.

    Args:
        sums: Of the parts at each lag.
        places: The lag of each part, by its place.
        common: The common one, by its place.
    """

    def variance(at: Sequence[int]) -> float:
        first, *others = (s.at(k) for s, k in zip(sums, at, strict=True))
        for other in others:
            first = first + other
        return float(first.left())

    moved = [[*places[:i], common, *places[i + 1 :]] for i in range(len(places))]
    left, own = np.array([variance(at) for at in moved]), variance(places)
    enough = np.isfinite(left) & np.isfinite(own)
    left, own = np.where(enough, left, 1.0), own if enough.any() else 1.0
    # nothing is left of a force that the model explains to rounding, at either lag
    float64 = np.finfo(float)
    least = max(own, float64.eps * left[enough].max(initial=0.0), float(float64.tiny))
    return np.where(enough, left / least, 1.0)
