"""Leaps of a position from one sample to the next, further than any motion of the log makes.

A leap is what stands apart: it departs from the speed around it at least four times as far as
anything else in the log does, or it is three times as fast as the fastest motion. In 190 recordings
of real axes, stick-slip sampled at 12 Hz among them, these ratios stay below 2.7 and 2.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ...space import Array
from ..outliers import MOST, SHARE, SIGMAS, STEPS, largest
from ..resampling import GAP
from ..resolution import noise_of, step

if TYPE_CHECKING:
    from ..recording import Recording

#: How far leaps stand apart: in their departure from the speed around them, and in speed.
DEPARTURE, SPEED = 4.0, 3.0
#: A leap is larger than this share of the whole travel: a smaller one hardly moves an estimate.
LEAST = 1e-3
#: Share of the leaps that must go against the motion, as wraps do; noise at the edge makes others.
MOSTLY = 0.6
#: Samples about a leap whose speeds are compared, and the widest stray of an outlier.
_AROUND, WIDEST = 3, 3
#: Samples that are worked on at once.
_BLOCK = 1 << 14
#: Comparisons that put the median of seven in the middle (Devillard 1998, Fast median search).
_NETWORK = (
    (0, 5), (0, 3), (1, 6), (2, 4), (0, 1), (3, 5), (2, 6), (2, 3), (3, 6), (4, 5), (1, 4),
    (1, 3), (3, 4),
)  # fmt: skip


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


_LEAPS: WeakKeyDictionary[Recording, Leaps] = WeakKeyDictionary()


def leaps(recording: Recording) -> Leaps:
    """The leaps of a log's position, in order of time."""
    if recording not in _LEAPS:
        _LEAPS[recording] = _leaps(recording)
    return _LEAPS[recording]


def _leaps(recording: Recording) -> Leaps:
    t, x = recording.t, recording.position
    tolerance = max(STEPS * step(x) + SIGMAS * noise_of(x), LEAST * float(np.ptp(x)))
    most = max(MOST, int(SHARE * (len(x) - 1)))
    departs = largest(_departures(t, x), DEPARTURE, most)
    fast = np.diff(t)
    np.divide(np.abs(np.diff(x)), np.maximum(fast, 0.5 * recording.dt, out=fast), out=fast)
    speeding = largest(fast, SPEED, most)
    found = _sized(recording, np.union1d(departs, speeding).astype(np.intp), tolerance)
    kept = ~_is_slip(recording, x, found.at, speeding, tolerance)
    return Leaps(found.at[kept], found.size[kept], found.speed[kept], tolerance)


def _sized(recording: Recording, at: NDArray[np.intp], tolerance: float) -> Leaps:
    """Those after some samples that are leaps by their size."""
    t, x = recording.t, recording.position
    dt, around = t[at + 1] - t[at], _speed_around(t, x, at)
    size = x[at + 1] - x[at] - around * dt
    kept = (np.abs(size) > tolerance) & (dt <= GAP * recording.dt)  # what moves in a gap is no leap
    return Leaps(at[kept], size[kept], around[kept], tolerance)


def turns(recording: Recording) -> Leaps:
    """The steps of an angle by more than half a turn, however many.

    Of an axis that turns fast they are too many to stand apart. None where most do not lead against
    a motion that is seen: an axis that steps to and fro has such steps, too.
    """
    at = np.flatnonzero(np.abs(np.diff(recording.position)) > np.pi)
    found = _sized(recording, at, leaps(recording).tolerance)
    against = np.sign(found.size) * found.speed * recording.dt < -found.tolerance
    some = len(against) > 0 and bool(np.mean(against) >= MOSTLY)
    return found if some else Leaps(at[:0], found.size[:0], found.speed[:0], found.tolerance)


def _departures(t: Array, x: Array) -> Array:
    """How far each sample departs from the speed about it, (N - 1,)."""
    n = len(x) - 1
    off = np.empty(n)
    for k in range(0, n, _BLOCK):
        at = slice(k, min(k + _BLOCK, n))
        first, last = max(at.start - _AROUND, 0), min(at.stop + _AROUND, n)
        dt, d = np.diff(t[first : last + 1]), np.diff(x[first : last + 1])
        own = slice(at.start - first, at.stop - first)
        edges = (_AROUND - own.start, _AROUND - (last - at.stop))
        windows = sliding_window_view(np.pad(d / dt, edges, mode="edge"), 2 * _AROUND + 1)
        off[at] = np.abs(d[own] - middle_of_seven(windows) * dt[own])
    return off


def middle_of_seven(rows: Array) -> Array:
    """The median of each row, (N, 7) to (N,), by an optimal network of comparisons."""
    columns: list[Array] = list(rows.T)
    for i, j in _NETWORK:
        low = np.minimum(columns[i], columns[j])
        columns[i], columns[j] = low, np.maximum(columns[i], columns[j])
    middle: Array = columns[3]
    return middle


def _speed_around(t: Array, x: Array, at: NDArray[np.intp]) -> Array:
    """The median speed about some samples."""
    about = np.clip(at[:, None] + np.arange(-_AROUND, _AROUND + 1), 0, len(x) - 2)
    return np.asarray(np.median((x[about + 1] - x[about]) / (t[about + 1] - t[about]), axis=1))


def _is_slip(
    recording: Recording, x: Array, at: NDArray[np.intp], speeding: NDArray[np.intp], fuzz: float
) -> NDArray[np.bool_]:
    """Which leaps lead from rest to rest, as slips of an axis do that is sampled slowly.

    Not where all else moves three times as slowly or more, or where a leap takes the axis
    away from its command, or to the origin: no slip does.
    """
    slips = np.zeros(len(at), dtype=bool)
    if not len(at):
        return slips
    n, span = len(x), float(np.ptp(x))
    steps = np.diff(x)
    steps[at] = 0.0
    moves = float(np.ptp(np.cumsum(steps))) > 2 * fuzz
    for k, i in enumerate(at):
        a, b = max(i - _AROUND, 0), min(i + 1 + _AROUND, n - 1)
        still = abs(x[i] - x[a]) <= fuzz and abs(x[b] - x[i + 1]) <= fuzz
        if not still or (moves and i in speeding):
            continue
        back = abs(x[i + 1]) <= fuzz < 0.1 * span < abs(x[i])
        slips[k] = not back and not _leaves_command(recording, x, int(i))
    return slips


def _leaves_command(recording: Recording, x: Array, i: int) -> bool:
    goal = recording.command
    if goal is None:
        return False
    off = abs(goal[i + 1] - x[i + 1]) - abs(goal[i] - x[i])
    return bool(off > 0.5 * abs(x[i + 1] - x[i]))
