"""What is left of a fit in frequency and in time lag: whether it is noise or a pattern."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..space import Array

#: A gap of so many sampling intervals ends a stretch; shorter ones are bridged.
_GAP = 10.0
#: Samples below which there is nothing to see, and spans that are averaged where there are many.
FEWEST, _SPANS = 64, 8
_LONGEST = 4096


def even(t: Array, y: Array) -> tuple[float, Array] | None:
    """The longest unbroken stretch of a signal at even times: (interval in s, values).

    Args:
        t: Times, s, (N,); nan between stretches.
        y: The signal, (N,).

    Returns:
        None where no stretch has FEWEST samples.
    """
    dt = np.diff(t)
    good = dt[np.isfinite(dt)]
    if len(good) < FEWEST:
        return None
    step = float(np.median(good))
    with np.errstate(invalid="ignore"):
        breaks = np.flatnonzero(~(dt <= _GAP * step) | ~np.isfinite(y[1:]) | ~np.isfinite(y[:-1]))
    edges = np.concatenate([[0], breaks + 1, [len(t)]])
    k = int(np.diff(edges).argmax())
    part = slice(int(edges[k]), int(edges[k + 1]))
    if part.stop - part.start < FEWEST:
        return None
    at = np.arange(t[part.start], t[part.stop - 1] + 0.5 * step, step)
    return step, np.interp(at, t[part], y[part])


def welch(y: Array, step: float) -> tuple[Array, Array]:
    """One-sided power spectral density by Welch's method (1967, doi 10.1109/TAU.1967.1161901).

    Hann windows that overlap by half, each less its mean. scipy.signal has it too, for half a
    second of start-up.

    Args:
        y: Values at even times, (N,).
        step: Their interval, s.

    Returns:
        Frequencies, Hz, and the density, unit of y squared per Hz.
    """
    width = min(len(y), _LONGEST, max(FEWEST, 2 ** int(np.log2(2 * len(y) / (_SPANS + 1)))))
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(width) / width)
    spans = np.lib.stride_tricks.sliding_window_view(y, width)[:: width // 2]
    parts = np.fft.rfft(window * (spans - spans.mean(axis=1, keepdims=True)), axis=1)
    density: Array = (np.abs(parts) ** 2).mean(axis=0) * step / float(np.sum(window**2))
    density[1 : -1 if width % 2 == 0 else None] *= 2.0
    return np.arange(len(density)) / (width * step), density


def autocorrelation(y: Array) -> Array:
    """The correlation of a signal with itself at lags 0, 1, 2 ... N - 1 samples."""
    n = len(y)
    off = y - y.mean()
    power = np.abs(np.fft.rfft(off, 2 * n)) ** 2
    found: Array = np.fft.irfft(power)[:n]
    return found / found[0] if found[0] > 0 else np.zeros(n)
