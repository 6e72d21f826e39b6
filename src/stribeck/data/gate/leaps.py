"""Leaps of a position from one sample to the next, further than any motion of the log makes.

A leap is what stands apart: it departs from the speed around it at least four times as far as
anything else in the log does, or it is three times as fast as the fastest motion. In 190 recordings
of real axes, stick-slip sampled at 12 Hz among them, these ratios stay below 2.7 and 2.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ...space import Array
from ..resolution import noise_of, step
from .fault import apart

if TYPE_CHECKING:
    from ..recording import Recording

#: How far leaps stand apart: in their departure from the speed around them, and in speed.
DEPARTURE, SPEED = 4.0, 3.0
#: Share of the samples that may leap, and how many may in any log.
SHARE, MOST = 0.02, 8
#: A leap is larger than so many steps and standard deviations of the sensor, and than this share of
#: the whole travel: a smaller one hardly moves an estimate.
STEPS, SIGMAS, LEAST = 3.0, 12.0, 1e-3
#: Beyond so many intervals nothing is known of the motion: what moves there is no leap.
GAP = 3.5
#: Samples about a leap whose speeds are compared, and the widest stray of an outlier.
_AROUND, WIDEST = 3, 3


@dataclass(frozen=True, eq=False)
class Leaps:
    """The leaps of a position.

    Args:
        at: Samples before each, in order.
        size: What each adds beside the motion around it, signed.
        speed: Of the motion around each, signed.
        tolerance: What noise and steps of the sensor alone may make.
    """

    at: NDArray[np.intp]
    size: Array
    speed: Array
    tolerance: float


def leaps(recording: Recording, x: Array) -> Leaps:
    """The leaps of a channel of positions, in order of time."""
    t = recording.t
    tolerance = max(STEPS * step(x) + SIGMAS * noise_of(x), LEAST * float(np.ptp(x)))
    dt, d = np.diff(t), np.diff(x)
    v = d / dt
    around = np.median(
        sliding_window_view(np.pad(v, _AROUND, mode="edge"), 2 * _AROUND + 1), axis=1
    )
    size = d - around * dt
    most = max(MOST, int(SHARE * len(d)))
    departs = _largest(np.abs(size), DEPARTURE, most)
    fast = np.abs(d) / np.maximum(dt, 0.5 * recording.dt)
    speeding = _largest(fast, SPEED, most)
    at = np.union1d(departs, speeding).astype(np.intp)
    at = at[(np.abs(size[at]) > tolerance) & (dt[at] <= GAP * recording.dt)]
    slip = _is_slip(recording, x, at, speeding, tolerance)
    keep = ~slip
    return Leaps(at[keep], size[at[keep]], around[at[keep]], tolerance)


def _largest(sizes: Array, ratio: float, most: int) -> NDArray[np.intp]:
    order = np.argsort(sizes)[::-1]
    return order[: apart(sizes[order], ratio, most)]


def _is_slip(
    recording: Recording, x: Array, at: NDArray[np.intp], speeding: NDArray[np.intp], fuzz: float
) -> NDArray[np.bool_]:
    """Which leaps lead from rest to rest, as slips of an axis do that is sampled slowly.

    Not where all else moves three times as slowly or more, or where a leap takes the axis
    away from its command, or to the origin: no slip does.
    """
    n = len(x)
    steps = np.diff(x)
    steps[at] = 0.0
    moves = float(np.ptp(np.cumsum(steps))) > 2 * fuzz
    slips = np.zeros(len(at), dtype=bool)
    for k, i in enumerate(at):
        a, b = max(i - _AROUND, 0), min(i + 1 + _AROUND, n - 1)
        still = abs(x[i] - x[a]) <= fuzz and abs(x[b] - x[i + 1]) <= fuzz
        if not still or (moves and i in speeding):
            continue
        back = abs(x[i + 1]) <= fuzz < 0.1 * float(np.ptp(x)) < abs(x[i])
        slips[k] = not back and not _leaves_command(recording, x, int(i))
    return slips


def _leaves_command(recording: Recording, x: Array, i: int) -> bool:
    goal = recording.command
    if goal is None:
        return False
    off = abs(goal[i + 1] - x[i + 1]) - abs(goal[i] - x[i])
    return bool(off > 0.5 * abs(x[i + 1] - x[i]))
