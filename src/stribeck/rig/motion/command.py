"""The command of an axis: linear between its knots."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numba import float64, int64, types
from numpy.typing import NDArray

from ...compile_cache import compiled
from ...errors import InputError
from ...space import Array, contiguous

if TYPE_CHECKING:
    from ...data.recording import Recording

_F1 = types.Array(float64, 1, "C", readonly=True)

#: A dropped knot moves the command by at most this share of its range.
KNOT_TOLERANCE = 1e-6
#: A motion goes one way if it does so by more than this share of a log's range, and by more than so
#: many times the root mean square of its way from sample to sample, which noise does not.
WAY, BEYOND_NOISE = 0.2, 10.0


@dataclass(frozen=True, eq=False)
class Drive:
    """A command x_i(t), linear between knots and constant before the first and after the last.

    Args:
        t: Knot times, s, increasing, (K,).
        x: Commanded position at the knots, m, (K,).
    """

    t: Array
    x: Array

    def __call__(self, t: Array) -> Array:
        """The command at any times."""
        return np.interp(t, self.t, self.x)

    @classmethod
    def sampled(cls, t: Array, x: Array, tolerance: float = KNOT_TOLERANCE) -> Drive:
        """The command of a log, with the samples dropped that lie on a line between others.

        Args:
            t: s, (N,).
            x: m or rad, (N,).
            tolerance: What a dropped sample may change, as a share of the range of x.
        """
        t, x = contiguous(t), contiguous(x)
        keep = _corners(t, x, tolerance * max(float(np.ptp(x)), 1e-12))
        return cls(t[keep], x[keep])

    @classmethod
    def of(cls, recording: Recording, ramp_speed: float = 0.0, first: int = 50) -> Drive:
        """A recording's command: its column, or else the paper's ramp.

        Without a command column the ramp starts at the mean of the first 50 positions (section
        4.3, step 1) and runs at `ramp_speed` m/s; at 0, at the mean speed of the recording.
        """
        if recording.command is not None:
            return cls.sampled(recording.t, recording.command)
        t, x = recording.t, recording.position
        speed = ramp_speed or float(np.polyfit(t, x, 1)[0])
        return cls.line(t[0], float(x[:first].mean()), t[-1], speed)

    @classmethod
    def line(cls, start: float, x: float, stop: float, speed: float) -> Drive:
        """A ramp from x at `speed` between two times."""
        return cls(np.array([start, stop]), np.array([x, x + speed * (stop - start)]))

    @classmethod
    def path(cls, points: list[float], speed: float, *, hold: float = 0.0) -> Drive:
        """From point to point at one speed, m/s, holding `hold` seconds at both ends.

        Raises:
            InputError: the speed is not above zero, or two points in a row are the same.
        """
        if not speed > 0:
            raise InputError(f"speed {speed} is not above zero")
        t, x = [0.0], [points[0]]
        if hold > 0:
            t, x = [0.0, hold], [points[0], points[0]]
        for a, b in pairwise(points):
            if a == b:
                raise InputError("a path needs points that differ")
            t.append(t[-1] + abs(b - a) / speed)
            x.append(b)
        if hold > 0:
            t.append(t[-1] + hold)
            x.append(x[-1])
        return cls(np.array(t), np.array(x))


def ways(x: Array, reach: float) -> tuple[bool, bool]:
    """Whether a motion goes up, and whether it goes down.

    Args:
        x: m or rad, (N,).
        reach: The range of the log, m or rad.
    """
    rise = float((x - np.minimum.accumulate(x)).max(initial=0.0))
    fall = float((np.maximum.accumulate(x) - x).max(initial=0.0))
    step = float(np.sqrt(np.square(np.diff(x)).sum() / max(len(x) - 1, 1)))
    least = max(WAY * reach, BEYOND_NOISE * step)
    return rise > least, fall > least


@compiled(int64[::1](_F1, _F1, float64), error_model="python")
def _corners(t: Array, x: Array, tolerance: float) -> NDArray[np.int64]:
    """Samples to keep so that a line between two kept ones misses none by more than tolerance.

    From each kept sample the cone of slopes that passes every later sample narrows as it goes;
    when it closes, the sample before becomes the next knot.
    """
    keep = np.empty(len(t), dtype=np.int64)
    keep[0] = 0
    n = 1
    start, low, high = 0, -np.inf, np.inf
    i = 1
    while i < len(t):
        dt = t[i] - t[start]
        slope = (x[i] - x[start]) / dt
        if not (low <= slope <= high):
            start = i - 1
            keep[n] = start
            n += 1
            low, high = -np.inf, np.inf
            continue
        low = max(low, (x[i] - tolerance - x[start]) / dt)
        high = min(high, (x[i] + tolerance - x[start]) / dt)
        i += 1
    if len(t) > 1:
        keep[n] = len(t) - 1
        n += 1
    return keep[:n].copy()
