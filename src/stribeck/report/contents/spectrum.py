"""What is left of a fit in frequency and in time lag: whether it is noise or a pattern."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...identify.uncertainty.covariance import autocovariance

if TYPE_CHECKING:
    from ...space import Array

#: A gap of so many sampling intervals ends a part; shorter ones are bridged.
_GAP = 10.0
#: Samples below which there is nothing to see, and spans that are averaged where there are many.
FEWEST, _SPANS = 64, 8
_LONGEST = 4096


def longest_even(t: Array, y: Array) -> tuple[float, Array] | None:
    """The longest unbroken part of a signal at even times: (interval in s, values).

    Args:
        t: Times, s, (N,); nan in gaps.
        y: The signal, (N,).

    Returns:
        None where no part has FEWEST samples.
    """
    dt = np.diff(t)
    finite = dt[np.isfinite(dt)]
    if len(finite) < FEWEST:
        return None
    step = float(np.median(finite))
    with np.errstate(invalid="ignore"):
        breaks = np.flatnonzero(~(dt <= _GAP * step) | ~np.isfinite(y[1:]) | ~np.isfinite(y[:-1]))
    edges = np.concatenate([[0], breaks + 1, [len(t)]])
    k = int(np.diff(edges).argmax())
    part = slice(int(edges[k]), int(edges[k + 1]))
    if part.stop - part.start < FEWEST:
        return None
    times = np.arange(t[part.start], t[part.stop - 1] + 0.5 * step, step)
    return step, np.interp(times, t[part], y[part])


def power_density(y: Array, step: float) -> tuple[Array, Array]:
    """One-sided power spectral density by Welch's method (1967, doi 10.1109/TAU.1967.1161901).

    Hann windows that overlap by half, each less its mean.

    Args:
        y: Values at even times, (N,).
        step: Their interval, s.

    Returns:
        Frequencies, Hz, and the density, unit of y squared per Hz.
    """
    from scipy.signal import welch  # noqa: PLC0415 - slow to import

    width = min(len(y), _LONGEST, max(FEWEST, 2 ** int(np.log2(2 * len(y) / (_SPANS + 1)))))
    f, power = welch(y, 1.0 / step, "hann", width, detrend="constant")
    return np.asarray(f), np.asarray(power)


def autocorrelation(y: Array) -> Array:
    """The correlation of a signal with itself at lags 0, 1, 2 ... N - 1 samples."""
    products = autocovariance(y - y.mean(), len(y))
    return products / products[0] if products[0] > 0 else np.zeros(len(y))
