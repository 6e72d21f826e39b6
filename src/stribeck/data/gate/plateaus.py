"""Channels that a limit cuts off: plateaus at an extreme, entered and left at full slope."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from ..resolution import noise_of, step, stretches
from ..runs import runs
from .cut_noise import SHARE, cut_noise
from .fault import Fault, shown_as

if TYPE_CHECKING:
    from ..recording import Recording

#: Channels that a sensor or an amplifier may cut off.
CHANNELS_CUT = ("position", "velocity", "force", "current", "voltage")
#: Samples of one value that make a plateau; slopes are taken over so many before and after.
LONG, _SLOPE = 5, (3, 100)
#: What a limit cuts off goes on for this share of the range at one pace: in none of four to eight
#: parts of it slower than the second share of the mean.
_ALONG, _PACE, _PARTS = 0.1, 0.4, (4, 8)
#: What is cut off is worth a word from this share of the range.
CUT = 0.02
#: A value that a channel takes more rarely than this many times its plateau's rows is a step.
_DISTINCT = 8
#: Samples by which most channels show that they take more values than that.
_FIRST = 1000
#: With noise on top: standard deviations of it that a plateau keeps within (but for so many samples
#: in a row), how many times the variance of white noise its means of five may have, its samples,
#: and the share of the log that may lie beyond. Forces of real axes that are flat by themselves
#: wander: 10 to 90 times the variance in 130 of them; what was cut off has 0.3 to 5 times.
_WITHIN, _STRAY, _WHITE, _BLOCK, _LONGER, _BEYOND = 5.0, 3, 6.0, 5, 15, 0.001
#: A force is flat by itself where the speed is: this ratio of speeds, ninetieth to tenth
#: percentile, shows that it is not.
_SPEEDS = 1.3


def clipping(recording: Recording) -> list[Fault]:
    """Channels that are cut off at the top or the bottom, a fault each."""
    result = []
    for name, values in recording.channels().items():
        if name not in CHANNELS_CUT:
            continue
        q = step(values)
        top, bottom = (_side(name, side, q) for side in _sides(values))
        if name == "force" and not (top | bottom).any():
            top, bottom = limits_below_noise(recording.t, recording.position, values)
        rows = top | bottom
        once = name not in ("position", "force") and len(runs(rows)[0]) == 1
        if not rows.any() or once:
            continue
        share = float(rows.mean())
        limits = [
            shown_as(recording, name, float(np.median(values[side])))
            for side in (bottom, top)
            if side.any()
        ]
        first, last = (float(recording.t[k]) for k in np.flatnonzero(rows)[[0, -1]])
        sentence = (
            f"{name} is cut off at {' and '.join(limits)} in {share:.1%} of the samples "
            f"({first:.4g} to {last:.4g} s): what lies beyond a sensor's limit was not measured; "
            "raise its range, or train on ranges that keep below it"
        )
        result.append(Fault("clipping", name, rows, share, sentence))
    return result


def _sides(values: Array) -> Iterator[Array]:
    """A channel, and the same upside down, so that both limits are upper ones."""
    yield values
    yield -values


def _side(name: str, y: Array, q: float) -> NDArray[np.bool_]:
    """The samples of a channel that its upper limit cuts off, with or without noise, (N,)."""
    rows = cut_off(y, q, abrupt=name == "position")
    return rows | cut_noise(y, q) if name == "force" else rows


def cut_off(y: Array, q: float, *, abrupt: bool = False) -> NDArray[np.bool_]:
    """The samples of a channel that its upper limit cuts off, (N,).

    Args:
        y: The channel.
        q: Its quantisation step.
        abrupt: Whether it may stay at an extreme by itself, as a position at rest does: then it
            must enter and leave its limit without slowing down.
    """
    none = np.zeros(len(y), dtype=bool)
    span = float(np.ptp(y))
    some = y[:: max(len(y) // _FIRST, 1)]
    if not span > 0 or (len(np.unique(some)) < _DISTINCT and len(np.unique(y)) < _DISTINCT):
        return none
    rows = _plateaus(y, y >= y.max() - 1e-9 * span, LONG, 3 * q + CUT * span, abrupt=abrupt)
    return rows if rows.mean() >= SHARE else none


def _plateaus(
    y: Array, at: NDArray[np.bool_], length: int, least: float, *, abrupt: bool = False
) -> NDArray[np.bool_]:
    """Runs at a limit, of so many samples, whose slopes about them would go on beyond it."""
    rows, span = np.zeros(len(y), dtype=bool), float(np.ptp(y))
    for a, b in zip(*runs(at), strict=True):
        n = int(np.clip((b - a) // 4, *_SLOPE))
        if b - a < length or a <= n or b + n >= len(y):
            continue
        rise, fall = (y[a - 1] - y[a - 1 - n]) / n, (y[b] - y[b + n]) / n
        # A curve of such slopes at its crossings rises by a quarter of slope times width above.
        if min(rise, fall) * (b - a) / 4 < least:
            continue
        if not abrupt or (_even(y[:a][::-1], span) and _even(y[b:], span)):
            rows[a:b] = True
    return rows


def _even(y: Array, span: float) -> bool:
    """Whether a channel falls from its start at one pace, neither starting slowly nor resting."""
    fallen = np.flatnonzero(y[0] - y >= _ALONG * span)
    if not len(fallen) or fallen[0] < _PARTS[0]:
        return False
    n = int(fallen[0])
    ends = np.linspace(0, n, min(n, _PARTS[1]) + 1).astype(int)
    falls = -np.diff(y[ends]) / np.diff(ends)
    return bool(falls.min() >= _PACE * (y[0] - y[n]) / n)


def limits_below_noise(t: Array, x: Array, y: Array) -> tuple[NDArray[np.bool_], ...]:
    """Plateaus of a channel at its upper and its lower limit with noise on top, (N,) each.

    Args:
        t: Times, (N,).
        x: The position, (N,).
        y: What drives the axis, (N,).
    """
    q, sd = step(y), noise_of(y)
    return tuple(_cut_below_noise(t, x, side, q, sd) for side in _sides(y))


def _cut_below_noise(t: Array, x: Array, y: Array, q: float, sd: float) -> NDArray[np.bool_]:
    """Plateaus with noise on top: nothing but white noise about one level near the extreme.

    A force that friction alone makes flat wanders by more than the noise of its sensor, or its
    axis moves at one speed.
    """
    none = np.zeros(len(y), dtype=bool)
    span = float(np.ptp(y))
    if not sd > 0:
        return none
    some = stretches(y)
    level = _mode(some[some >= np.quantile(some, 0.9)], sd)
    width = _WITHIN * sd + q
    if float(np.mean(y > level + width)) > _BEYOND:
        return none
    near = (y >= level - width) & (y <= level + width)
    for a, b in zip(*runs(~near), strict=True):
        near[a:b] = b - a <= _STRAY
    rows = _plateaus(y, near, _LONGER, 3 * q + 3 * sd + CUT * span)
    starts, stops = runs(rows)
    if len(starts) < 2 or rows.mean() < 2 * SHARE:  # noqa: PLR2004 - one may be chance
        return none
    white = [_whiteness(y[a:b], level, sd) for a, b in zip(starts, stops, strict=True)]
    lag = min(_LONGER, len(y) - 1)
    at = np.flatnonzero(rows[lag:]) + lag
    speed = np.abs(x[at] - x[at - lag]) / (t[at] - t[at - lag])
    slow, fast = np.quantile(speed, [0.1, 0.9]) if len(at) else (0.0, 0.0)
    return rows if float(np.median(white)) <= _WHITE and fast > _SPEEDS * slow else none


def _mode(y: Array, sd: float) -> float:
    """The densest level of some values, over windows of two standard deviations."""
    y = np.sort(y)
    ends = np.searchsorted(y, y + 2 * sd, side="right")
    k = int(np.argmax(ends - np.arange(len(y))))
    return float(np.median(y[k : ends[k]]))


def _whiteness(y: Array, level: float, sd: float) -> float:
    """Variance of means of five about a level, as a multiple of what white noise has."""
    inner = y[1:-1]
    n = len(inner) // _BLOCK * _BLOCK
    means = inner[:n].reshape(-1, _BLOCK).mean(axis=1)
    return float(np.mean((means - level) ** 2)) * _BLOCK / sd**2
