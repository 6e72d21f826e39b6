"""By how much two clocks differ, from one signal that both files have.

The signals are laid over each other where their correlation is highest, and then window by window:
a straight line through the delays of the windows is the difference of the clocks and its rate.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...space import Array
from ..channels import LARGEST

#: Signals that correlate less are not one.
ALIKE = 0.95
#: Of the shorter signal at least so much is laid over the other.
_OVERLAP = 0.3
#: Lags whose correlation falls short of one by so many times what the best does are as good.
_AS_GOOD = 2.0
_STILL = 1e-6  # of the variances' product: nothing moves
_MOST = 1 << 17
_WINDOWS = 12
_FEWEST = 40
_STEPS = 8


class ClockDifference(NamedTuple):
    """What the second clock shows more than the first: `offset + rate * (t - middle)`.

    Args:
        offset: In the middle of what both have, s.
        rate: Of the second clock against the first, less 1.
        middle: On the first clock, s.
        offset_error: Standard error of the offset, s.
        rate_error: Standard error of the rate; infinite where it cannot be told.
        span: Length of what both have, s.
    """

    offset: float
    rate: float
    middle: float
    offset_error: float
    rate_error: float
    span: float

    def corrected(self, t: Array) -> Array:
        """Times of the second clock on the first."""
        shown = self.middle + self.offset
        return self.middle + (t - shown) / (1.0 + self.rate)

    @property
    def most(self) -> float:
        """The largest difference within what both have, s."""
        return abs(self.offset) + 0.5 * self.span * abs(self.rate)


def clock_difference(t: Array, a: Array, t_other: Array, b: Array) -> ClockDifference | None:
    """What the clock of `b` shows more than that of `a`; None where they are not one signal.

    Args:
        t: Times of the first, s, increasing (N,).
        a: The signal in the first file (N,).
        t_other: Times of the second (M,).
        b: The signal in the second (M,).
    """
    t, a = t[np.isfinite(a)], a[np.isfinite(a)]
    t_other, b = t_other[np.isfinite(b)], b[np.isfinite(b)]
    if max(np.abs(a).max(initial=0.0), np.abs(b).max(initial=0.0)) > LARGEST:
        return None
    if min(len(t), len(t_other)) < _FEWEST or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return None
    longest = max(t[-1] - t[0], t_other[-1] - t_other[0])
    step = max(*(float(np.median(np.diff(x))) for x in (t, t_other)), longest / _MOST)
    lag = _best_lag(t, a, t_other, b, step)
    return None if lag is None else _refined(t, a, t_other, b, lag)


def _best_lag(t: Array, a: Array, t_other: Array, b: Array, step: float) -> float | None:
    """Where the signals correlate best; of lags that are as good the one nearest to none."""
    grids = [x[0] + step * np.arange(int((x[-1] - x[0]) / step) + 1) for x in (t, t_other)]
    signals = [np.interp(g, x, y) for g, x, y in zip(grids, (t, t_other), (a, b), strict=True)]
    signals = [(y - y.mean()) / max(y.std(), 1e-300) for y in signals]
    n, m = map(len, signals)
    size = 1 << (n + m - 1).bit_length()

    def over(x: Array, y: Array) -> Array:
        """Sums of products over what both have, lag by lag from -(n - 1) to m - 1."""
        product = np.fft.irfft(np.conj(np.fft.rfft(x, size)) * np.fft.rfft(y, size), size)
        return np.asarray(np.concatenate([product[size - n + 1 :], product[:m]]))

    ones, others = np.ones(n), np.ones(m)
    count = np.maximum(over(ones, others), 1.0)
    means = over(signals[0], others) / count, over(ones, signals[1]) / count
    variance = (over(signals[0] ** 2, others) / count - means[0] ** 2) * (
        over(ones, signals[1] ** 2) / count - means[1] ** 2
    )
    enough = (count >= _OVERLAP * min(n, m)) & (count >= _FEWEST) & (variance > _STILL)
    if not enough.any():
        return None
    correlation = np.full(len(count), -1.0)
    covariance = over(*signals) / count - means[0] * means[1]
    correlation[enough] = covariance[enough] / np.sqrt(variance[enough])
    best = float(correlation.max())
    if best < ALIKE:
        return None
    lags = grids[1][0] - grids[0][0] + step * np.arange(-(n - 1), m)
    peaks = np.flatnonzero(
        (correlation >= 1.0 - _AS_GOOD * max(1.0 - best, 1e-6))
        & (correlation >= np.roll(correlation, 1))
        & (correlation >= np.roll(correlation, -1))
    )
    return float(lags[peaks[np.argmin(np.abs(lags[peaks]))]])


def _refined(t: Array, a: Array, t_other: Array, b: Array, lag: float) -> ClockDifference | None:
    since, until = max(t[0], t_other[0] - lag), min(t[-1], t_other[-1] - lag)
    rows = (t >= since) & (t <= until)
    count = min(_WINDOWS, int(rows.sum()) // _FEWEST)
    windows = np.array_split(np.flatnonzero(rows), count) if count else []
    delays = [
        (float(t[window].mean()), *delay)
        for window in windows
        if (delay := _delay(t[window], a[window], t_other, b, lag)) is not None
    ]
    if not delays:
        return None
    at, value, error = map(np.asarray, zip(*delays, strict=True))
    middle, span = 0.5 * (since + until), until - since
    if len(at) < 3:  # noqa: PLR2004 - a line and its scatter need three
        k = int(error.argmin())
        return ClockDifference(value[k], 0.0, middle, float(error[k]), np.inf, span)
    design = np.stack([np.ones(len(at)), at - middle], axis=1) / error[:, None]
    covariance = np.linalg.inv(design.T @ design)
    offset, rate = covariance @ design.T @ (value / error)
    misfit = design @ [offset, rate] - value / error
    scatter = max(1.0, float(misfit @ misfit) / (len(at) - 2))
    errors = np.sqrt(scatter * np.diag(covariance))
    return ClockDifference(
        float(offset), float(rate), middle, float(errors[0]), float(errors[1]), span
    )


def _delay(t: Array, a: Array, t_other: Array, b: Array, lag: float) -> tuple[float, float] | None:
    """The delay of `b` in a window and its standard error; None where nothing moves."""
    slope = np.gradient(b, t_other)
    delay = lag
    for _ in range(_STEPS):
        shifted, steep = (np.interp(t + delay, t_other, y) for y in (b, slope))
        design = np.stack([a, np.ones(len(a)), steep], axis=1)
        scale = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
        solution, _, rank, _ = np.linalg.lstsq(design / scale, shifted, rcond=1e-9)
        if rank < design.shape[1]:
            return None
        gain, level, change = solution / scale
        delay -= float(change)
        if abs(change) < 1e-9 * max(t[-1] - t[0], 1e-12):
            break
    residual = shifted - design @ [gain, level, change]
    inverse = np.linalg.inv((design / scale).T @ (design / scale))
    error = np.sqrt(inverse[2, 2] * residual @ residual / max(len(a) - 3, 1)) / scale[2]
    return (delay, max(float(error), 1e-12)) if np.isfinite(delay + error) else None
