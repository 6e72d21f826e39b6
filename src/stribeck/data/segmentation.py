"""Where an axis strokes, rests and slips.

One idea serves all of it: *a band and a pace*. The band is as wide as a position that does not
change may be written down: 2.5 quantisation steps (a level between two counts that creeps by one)
and 6 standard deviations of noise. The pace is the mean speed of the stroke, of the command where
there is one. **An axis rests while it stays inside a band for as long as it would take to cross it
at a fifth of its pace.** Where a sensor is so fine that noise sets no limit, the band is at least
what a twentieth of the pace crosses in two sampling intervals, so that creep counts as rest. No
threshold has a unit: scale time, position or both, and the same samples rest. The top of a smooth
turn, where a pendulum swings back, is no rest, and neither is a value that a slow sensor repeats or
a coarse one keeps while the recorded velocity goes on. A log that never leaves its band rests
throughout.

A slip leads from one rest to the next, further than a band and on average at least 1.5 times as
fast as the pace; a stroke that is followed smoothly between two reversals is therefore none, and
neither is a swing, which passes the level at which it comes to rest by half its way and more.

Limits: what is shorter than the band's crossing time is not seen, and where strokes have plateaus
of very different speeds and there is no rest, a plateau under a fifth of its stroke's mean speed
reads as rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numba import boolean, float64, int64, types
from numpy.typing import NDArray

from ..compile_cache import compiled
from ..space import Array
from .repeated_samples import renewal
from .resolution import noise_of, step
from .runs import slices

if TYPE_CHECKING:
    from .recording import Recording

_STEPS, _SIGMAS = 2.5, 6.0
#: A rest is slower than the first share of the pace (than the second where the sensor is so fine
#: that noise sets no limit), a slip faster than the third.
_SLOW, _CREEP, _DASH = 0.2, 0.05, 1.5
#: A rest lasts for so many values of a sensor that holds them; one that stalls, for fewer than so
#: many.
_RENEWALS, _STALL = 3.0, 20.0
#: Samples of a recorded velocity that show that an axis goes on.
_TELLING = 5
#: A motion that leaves the way between two rests by this share of it swings; a slip sticks where it
#: first stops.
_SWING = 0.5
#: A parabola explains a turn to so many times the sensor's own error and this share of its depth.
_SMOOTH, _OFF, _FEWEST = 1.5, 0.1, 3
#: A reversal counts once the axis has come back by this share of its range.
_BACK = 0.05


@dataclass(frozen=True)
class Stroke:
    """A run in one direction.

    Args:
        rows: The samples it spans.
        direction: +1 or -1.
        travel: What it covers, m or rad, positive.
        speed: Its mean speed, m/s or rad/s, positive.
    """

    rows: slice
    direction: int
    travel: float
    speed: float


@dataclass(frozen=True)
class Slip:
    """A jump from one rest to the next.

    Args:
        start: The last sample at the old level.
        stop: The first sample at the new level.
        jump: New level minus old, m or rad, signed.
        peak_speed: Its greatest speed, m/s or rad/s, positive.
    """

    start: int
    stop: int
    jump: float
    peak_speed: float


@dataclass(frozen=True, eq=False)
class Segments:
    """What `segment` finds.

    Args:
        noise: Standard deviation of the position noise, m or rad, beside quantisation.
        step: Quantisation step of the position, 0 if there is none to be seen.
        band: How far a position at rest may wander, m or rad.
        strokes: Runs in one direction.
        rests: Stuck stretches, as slices of samples.
        slips: Jumps between rests.
        stuck: Share of the time spent in rests.
    """

    noise: float
    step: float
    band: float
    strokes: tuple[Stroke, ...]
    rests: tuple[slice, ...]
    slips: tuple[Slip, ...]
    stuck: float


def strokes(recording: Recording) -> tuple[Stroke, ...]:
    """Runs in one direction, of the command if it was recorded, of the position elsewhere.

    A reversal counts once it is larger than the noise and than 5 % of the range. Standstill at
    the ends of a run is not part of it.
    """
    return segment(recording).strokes


def rests(recording: Recording) -> tuple[slice, ...]:
    """Stuck stretches, in order, as slices of samples."""
    return segment(recording).rests


def slips(recording: Recording) -> tuple[Slip, ...]:
    """Jumps from one rest to the next, in order."""
    return segment(recording).slips


def segment(recording: Recording) -> Segments:
    """Noise, strokes, rests and slips of a recording, all at once."""
    t, x = recording.t, recording.position
    q = step(x)
    sd = noise_of(x)
    band = max(_STEPS * q + _SIGMAS * sd, 1e-6 * float(np.ptp(x)))
    lead, width = (x, band) if recording.command is None else _led(recording.command)
    strokes = _strokes(t, lead, width) or _strokes(t, x, band)
    if float(np.ptp(x)) <= 2 * band:
        return Segments(sd, q, band, tuple(strokes), (slice(0, len(t)),), (), 1.0)
    pace = _pace(strokes, t, x)
    tolerance = np.maximum(band, 2 * _CREEP * pace * recording.dt)
    duration = tolerance / np.maximum(_SLOW * pace, np.finfo(float).tiny)
    period = renewal(t, x)
    resting = _still(t, x, tolerance, np.maximum(duration, _RENEWALS * period))
    fuzz = float(np.hypot(sd, q / np.sqrt(12)))
    stuck = [
        rest
        for rest in _rests(x, resting, band)
        if not (_turns_in(t, x, rest, band, fuzz) or _goes_on(recording, rest, band, period))
    ]
    jumps = _slips(t, x, stuck, band, pace, sd, q)
    share = sum(t[r.stop - 1] - t[r.start] for r in stuck) / (t[-1] - t[0])
    return Segments(sd, q, band, tuple(strokes), tuple(stuck), tuple(jumps), float(share))


def turns(values: Array, drop: float) -> NDArray[np.int64]:
    """Samples where a channel turns, its ends included: extremes left by at least `drop`."""
    rows: NDArray[np.int64] = _turns(np.ascontiguousarray(values), drop)
    return rows


def _led(command: Array) -> tuple[Array, float]:
    q = step(command)
    return command, _STEPS * q + _SIGMAS * noise_of(command)


def _strokes(t: Array, x: Array, fuzz: float) -> list[Stroke]:
    extent = float(np.ptp(x))
    if extent <= 2 * fuzz:
        return []
    drop = max(2 * fuzz, _BACK * extent)
    turns = _turns(x, drop)
    strokes = []
    for a, b in pairwise(turns.tolist()):
        path = x[a : b + 1]
        travel = abs(float(path[-1] - path[0]))
        edge = max(fuzz, 1e-3 * travel)
        first = int(np.flatnonzero(np.abs(path - path[0]) <= edge)[-1])
        last = int(np.flatnonzero(np.abs(path - path[-1]) <= edge)[0])
        if first < last and travel > drop:
            rows = slice(int(a) + first, int(a) + last + 1)
            speed = abs(path[last] - path[first]) / (t[a + last] - t[a + first])
            strokes.append(Stroke(rows, 1 if path[-1] > path[0] else -1, travel, float(speed)))
    return strokes


def _pace(strokes: list[Stroke], t: Array, x: Array) -> Array:
    """The mean speed of the stroke at hand (between strokes, of the one before), (N,)."""
    if not strokes:
        return np.full(len(t), float(np.ptp(x) / (t[-1] - t[0])))
    starts = np.array([r.rows.start for r in strokes])
    index = np.searchsorted(starts, np.arange(len(t)), side="right") - 1
    return np.array([r.speed for r in strokes])[np.maximum(index, 0)]


def _rests(x: Array, resting: NDArray[np.bool_], band: float) -> list[slice]:
    """Still stretches, those joined that only an outlier keeps apart."""
    rests: list[slice] = []
    for run in slices(resting):
        rest = slice(run.start, run.stop + 1)
        if rests and _same(x, rests[-1], rest, band):
            rest = slice(rests.pop().start, run.stop + 1)
        rests.append(rest)
    return rests


def _goes_on(recording: Recording, rest: slice, band: float, period: float) -> bool:
    """Whether the recorded velocity goes on while a sensor repeats values or is too coarse to tell.

    Over long stays it must go one way, faster than a rest may be, for more than half of the time,
    the ends apart: its delay, flicker and offset move no axis.
    """
    v, t = recording.velocity, recording.t
    if v is None:
        return False
    if t[rest.stop - 1] - t[rest.start] < _STALL * period:
        return abs(float(np.trapezoid(v[rest], t[rest]))) > band
    edge = (rest.stop - rest.start) // 4
    inner = slice(rest.start + edge, rest.stop - edge)
    if inner.stop - inner.start < _TELLING:
        return False
    fast = np.abs(v[inner]) > _SLOW * float(np.sqrt(np.mean(v**2)))
    mostly = abs(float(np.mean(np.sign(v[inner]) * fast))) > 1 / 2
    return mostly and abs(float(np.trapezoid(v[inner], t[inner]))) > band / 4


def _turns_in(t: Array, x: Array, rest: slice, band: float, fuzz: float) -> bool:
    """Whether a stay is the top of a smooth turn, as of a pendulum, and no rest: it is not flat.

    A parabola explains it and half as much on either side of it, where the axis leaves to the side
    that it came from.
    """
    wide = max((rest.stop - rest.start) // 2, _FEWEST)
    first, last = rest.start - wide, rest.stop + wide
    if first < 0 or last > len(x):
        return False
    level = _level(x[rest])
    come, go = _level(x[first : rest.start]) - level, _level(x[rest.stop : last]) - level
    if come * go <= 0 or min(abs(come), abs(go)) < band / 2:
        return False
    u = (t[first:last] - t[first]) / (t[last - 1] - t[first]) - 0.5
    W = np.column_stack([np.ones(len(u)), u, u**2])
    y = x[first:last] - level
    r = y - W @ np.linalg.lstsq(W, y, rcond=None)[0]
    return float(np.sqrt(np.mean(r**2))) <= _SMOOTH * fuzz + _OFF * min(abs(come), abs(go))


def _same(x: Array, before: slice, after: slice, band: float) -> bool:
    a, b = _level(x[before][-_FEW:]), _level(x[after][:_FEW])
    gap = x[before.stop : after.start]
    small = len(gap) == 0 or float(np.max(np.abs(gap - a))) <= 2 * band
    return before.stop < after.start and abs(b - a) <= band / 2 and small


_FEW = 50  # samples that a level is taken from


def _level(x: Array) -> float:
    return float(np.median(x))


def _slips(
    t: Array, x: Array, stuck: list[slice], band: float, pace: Array, sd: float, q: float
) -> list[Slip]:
    slips = []
    for before, after in pairwise(stuck):
        level, next_level = _level(x[before][-_FEW:]), _level(x[after][:_FEW])
        jump = next_level - level
        start, stop = _edges(x, before, after, level, next_level, 2 * sd + q)
        span = float(t[stop] - t[start])
        fast = abs(jump) > band and abs(jump) > _DASH * pace[start : stop + 1].max() * span
        if fast and not _swings(x[start : after.start], level, next_level):
            slips.append(
                Slip(
                    start,
                    stop,
                    jump,
                    _peak(t, x, start, stop, abs(jump), float(np.hypot(sd, q / 3.5))),
                )
            )
    return slips


def _swings(way: Array, level: float, next_level: float) -> bool:
    """Whether a motion passes one of its ends by a good part of the way between them."""
    low, high = min(level, next_level), max(level, next_level)
    past = max(low - float(way.min()), float(way.max()) - high) if len(way) else 0.0
    return past > _SWING * (high - low)


def _edges(
    x: Array, before: slice, after: slice, level: float, next_level: float, tolerance: float
) -> tuple[int, int]:
    """The last sample near the old level and the first near the new one, about the crossing."""
    first, last = max(before.start, before.stop - 1 - _FEW), min(after.stop, after.start + 1 + _FEW)
    travel = x[first:last]
    half = np.flatnonzero((travel - (level + next_level) / 2) * np.sign(next_level - level) > 0)
    middle = int(half[half >= 1][0]) if (half >= 1).any() else len(travel) // 2
    departing = np.flatnonzero(np.abs(travel[:middle] - level) <= tolerance)
    arriving = np.flatnonzero(np.abs(travel[middle:] - next_level) <= tolerance)
    start = first + (int(departing[-1]) if len(departing) else 0)
    stop = first + middle + (int(arriving[0]) if len(arriving) else len(travel) - middle - 1)
    return start, max(stop, start + 1)


def _peak(t: Array, x: Array, start: int, stop: int, jump: float, fuzz: float) -> float:
    """Greatest speed over a lag at which noise makes a twentieth of it."""
    lag = min(max(1, int(np.ceil(28 * fuzz / jump * (stop - start)))), stop - start)
    travel, times = x[start : stop + 1], t[start : stop + 1]
    return float(np.max(np.abs(travel[lag:] - travel[:-lag]) / (times[lag:] - times[:-lag])))


_FLOATS = types.Array(float64, 1, "C", readonly=True)


@compiled(boolean[::1](_FLOATS, _FLOATS, _FLOATS, _FLOATS))
def _still(t: Array, x: Array, band: Array, duration: Array) -> NDArray[np.bool_]:
    """Which intervals between samples lie in a stay of at least `duration` inside `band`.

    The window's extremes are kept in two queues of falling candidates, so that the whole is
    linear in the samples.
    """
    n = len(t)
    resting = np.zeros(n - 1, dtype=np.bool_)
    low, high = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    l0 = l1 = h0 = h1 = 0
    first = marked = 0
    for i in range(n):
        while l1 > l0 and x[low[l1 - 1]] >= x[i]:
            l1 -= 1
        low[l1] = i
        l1 += 1
        while h1 > h0 and x[high[h1 - 1]] <= x[i]:
            h1 -= 1
        high[h1] = i
        h1 += 1
        while x[high[h0]] - x[low[l0]] > band[i]:
            first += 1
            if low[l0] < first:
                l0 += 1
            if high[h0] < first:
                h0 += 1
        if t[i] - t[first] >= duration[i] and i - first > 1:
            for j in range(max(first, marked), i):
                resting[j] = True
            marked = i
    return resting


@compiled(int64[::1](_FLOATS, float64))
def _turns(x: Array, drop: float) -> NDArray[np.int64]:
    """Samples where the signal turns, its ends included: extremes left by at least `drop`."""
    turns = np.empty(len(x) + 1, dtype=np.int64)
    n = 0
    top = bottom = 0
    direction = 0
    for i in range(len(x)):
        if x[i] > x[top]:
            top = i
        if x[i] < x[bottom]:
            bottom = i
        if direction >= 0 and x[top] - x[i] > drop:
            turns[n] = top
            n += 1
            direction, bottom = -1, i
        elif direction <= 0 and x[i] - x[bottom] > drop:
            turns[n] = bottom
            n += 1
            direction, top = 1, i
    turns[n] = top if direction > 0 else bottom
    return turns[: n + 1]
