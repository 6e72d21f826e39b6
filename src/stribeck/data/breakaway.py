"""Breakaway of force ramps, and the stiffness of a contact below it.

A ramp of force on a resting axis ends in sliding, but not at one force: before it slides, the axis
creeps, and where creep ends is a matter of definition. Two are given. The first knows neither the
force nor the stiffness: sliding begins where the axis first moves twice as fast as it does on
average over the ramp. The second is one of stiffness: it begins where the slope of position over
force is a hundred times that of the ramp's beginning. They differ by the half of a newton metre in
fifteen where the axis creeps a long way, and that is what one such number is worth.

What an axis does in cycles of force below breakaway gives the stiffness of the contact: the slope
of the line between the tips of settled cycles. The sigma_0 of a law is the slope out of rest, which
small cycles approach and larger ones fall short of. Some authors call half of it sigma_0, the
amplitude of the force over the peak-to-peak position; no law here means that.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..space import Array
from .resolution import noise, step
from .runs import runs
from .segmentation import turns

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .recording import Recording

#: A ramp keeps this close to a line, as a share of its span (or three standard deviations of the
#: force's noise), takes this share of its log and of the monotone stretch it lies in.
_LINE, _SHARE, _MOST = 0.005, 0.1, 0.75
#: Force turns once it has come back by this share of its range.
_BACK = 0.1
#: Sliding begins at this multiple of the ramp's mean speed. A ramp whose speed never is so many
#: times the mean has not broken away.
_PACE, _BROKEN = 2.0, 15.0
#: Speed is taken over this share of the ramp, or over so many steps of the sensor at mean speed if
#: that is longer, but never over more than the second share.
_WINDOW, _STEPS, _WIDEST = 0.01, 0.1, 0.05
#: By stiffness: how many times as compliant, and which part of the ramp counts as its beginning.
_COMPLIANT, _BEGINNING = 100.0, (0.1, 0.5)
#: Cycles: fewest, how alike their peaks, and how far force and position go together.
_CYCLES, _ALIKE, _SPRING = 2, 0.1, 0.6
#: Presliding is a matter of micrometres and milliradians.
PRESLIDING = {False: 1e-3, True: 0.02}
#: A log without sliding travels no more than five times that.
STILL = {False: 5e-3, True: 0.1}


@dataclass(frozen=True)
class Breakaway:
    """One ramp of force, and where the axis broke away in it. SI, signs as measured.

    Args:
        rows: Its samples.
        rate: Its slope, N/s (N m/s).
        reached: Force at its end.
        by_speed: Force at which sliding begins by the axis' speed; None if it never does.
        by_stiffness: The same by the compliance of the contact.
    """

    rows: slice
    rate: float
    reached: float
    by_speed: float | None
    by_stiffness: float | None

    @property
    def levels(self) -> tuple[float, ...]:
        """What the two definitions give, none if the axis did not break away."""
        return tuple(x for x in (self.by_speed, self.by_stiffness) if x is not None)


@dataclass(frozen=True)
class Presliding:
    """Cycles of force below breakaway, and how stiff the contact is. SI.

    Args:
        cycles: Settled ones, from the second on.
        amplitude: Of the force.
        travel: Peak-to-peak position over these cycles.
    """

    cycles: int
    amplitude: float
    travel: float

    @property
    def stiffness(self) -> float:
        """Slope of the line between the tips of the loop: at most the sigma_0 of a law."""
        return 2 * self.amplitude / self.travel

    @property
    def half(self) -> float:
        """Amplitude of the force over peak-to-peak position; some authors call it sigma_0."""
        return self.amplitude / self.travel


@dataclass(frozen=True)
class Level:
    """The breakaway of several ramps one way.

    Args:
        direction: +1 or -1.
        values: By speed, one a ramp that broke away, positive.
        low: Least of all ramps and both definitions.
        high: Greatest.
        censored: What ramps reached without breaking away.
    """

    direction: int
    values: tuple[float, ...]
    low: float
    high: float
    censored: tuple[float, ...]

    @property
    def mean(self) -> float:
        """Mean of `values`; nan if no ramp broke away."""
        return float(np.mean(self.values)) if self.values else float("nan")


def ramps(recording: Recording) -> tuple[Breakaway, ...]:
    """The force ramps of a log, in order; none if force was not measured.

    A ramp is a straight rise (or fall) away from zero of a tenth of the log and more, which ends in
    sliding; one that does not counts in a log without any, where all travel is presliding.
    """
    slopes = [_breakaway(recording, rows) for rows in _straight(recording)]
    still = float(np.ptp(recording.position)) <= STILL[recording.rotary]
    return tuple(b for b in slopes if still or b.by_speed is not None)


def levels(recordings: Sequence[Recording]) -> tuple[Level, ...]:
    """The breakaway levels of all ramps in some logs, one a direction.

    Raises:
        InputError: no log has a ramp.
    """
    breakaways = [b for log in recordings for b in ramps(log)]
    if not breakaways:
        named = recordings[0].label if recordings else "no recording"
        raise InputError(f"{named}: no ramp of a measured force was found")
    levels = []
    for direction in (1, -1):
        mine = [b for b in breakaways if b.rate * direction > 0]
        magnitudes = [abs(x) for b in mine for x in b.levels]
        values = tuple(abs(b.by_speed) for b in mine if b.by_speed is not None)
        if mine:
            low, high = (
                (min(magnitudes), max(magnitudes)) if magnitudes else (float("nan"), float("nan"))
            )
            missed = tuple(abs(b.reached) for b in mine if b.by_speed is None)
            levels.append(Level(direction, values, low, high, missed))
    return tuple(levels)


def presliding(recording: Recording) -> Presliding | None:
    """The contact's stiffness from cycles of force below breakaway; None where there are none."""
    u, x = recording.force, recording.position
    if u is None or not np.ptp(u) > 0:
        return None
    at = turns(u, _BACK * float(np.ptp(u)))[1:-1]  # not the ends
    if len(at) < 2 * _CYCLES or len(at) > len(u) / 8:
        return None
    peaks = u[at]
    middle, amplitude = (peaks[::2].mean() + peaks[1::2].mean()) / 2, float(np.ptp(u)) / 2
    if np.any(np.abs(np.abs(peaks - middle) - amplitude) > _ALIKE * amplitude):
        return None
    period = 2 * float(np.median(np.diff(recording.t[at])))
    settled = recording.t >= recording.t[0] + period
    travel = float(np.ptp(x[settled]))
    if not 0 < travel <= PRESLIDING[recording.rotary]:
        return None
    if np.corrcoef(u[settled], x[settled])[0, 1] < _SPRING:
        return None
    cycles = round((recording.t[-1] - recording.t[0]) / period) - 1
    return Presliding(cycles, amplitude, travel)


def _straight(recording: Recording) -> Iterator[slice]:
    """The straight stretches of force, as slices of samples."""
    u = recording.force
    if u is None or not np.ptp(u) > 0:
        return
    t, fuzz = recording.t, 3 * _noise_of(u)
    for a, b in pairwise(turns(u, _BACK * float(np.ptp(u))).tolist()):
        segment, times = u[a : b + 1], t[a : b + 1]
        span = abs(float(segment[-1] - segment[0]))
        lag = max(1, len(segment) // 20)
        if len(segment) < _SHARE * len(u) or not span > 0:
            continue
        slope = float(np.median((segment[lag:] - segment[:-lag]) / (times[lag:] - times[:-lag])))
        level = segment - slope * times
        on_line = np.abs(level - np.median(level)) <= max(_LINE * span, fuzz)
        first, last = _longest(on_line)
        run = abs(float(segment[last] - segment[first]))
        rises = abs(segment[last]) > abs(segment[first]) and run > _BACK * float(np.ptp(u))
        if rises and last - first >= max(_SHARE * len(u), _MOST * len(segment)):
            yield slice(a + first, a + last + 1)


def _noise_of(u: Array) -> float:
    third = np.diff(u, 3)
    return float(np.median(np.abs(third)) / 0.6745 / np.sqrt(20))


def _longest(inside: NDArray[np.bool_]) -> tuple[int, int]:
    """First and last place of the longest run of True."""
    starts, stops = runs(inside)
    if not len(starts):
        return 0, 0
    k = int(np.argmax(stops - starts))
    return int(starts[k]), int(stops[k]) - 1


def _breakaway(recording: Recording, rows: slice) -> Breakaway:
    assert recording.force is not None  # noqa: S101 - it has ramps
    t, u = recording.t[rows], recording.force[rows]
    direction = 1.0 if u[-1] > u[0] else -1.0
    x = direction * recording.position[rows]
    rate = float((u[-1] - u[0]) / (t[-1] - t[0]))
    resolution = float(np.hypot(step(recording.position), 3.5 * noise(recording)))
    speed, half = _speed(t, x, resolution)
    inner = slice(half, len(t) - half)
    end = _end(t, x, speed, half, resolution)
    by_speed = by_stiffness = None
    if end is not None:
        pace = float(x[end] - x[0]) / float(t[end] - t[0])
        by_speed = float(u[inner][np.argmax(speed > _PACE * pace)])
        by_stiffness = _by_stiffness(x, direction * u, speed / abs(rate), inner, abs(by_speed))
    return Breakaway(rows, rate, float(u[-1]), by_speed,
                     None if by_stiffness is None else direction * by_stiffness)  # fmt: skip


def _end(t: Array, x: Array, speed: Array, half: int, resolution: float) -> int | None:
    """Up to which sample a ramp's mean speed is taken; None if the axis never breaks away.

    All of it, unless it slides for so long that sliding makes the mean: then only until it is
    first fifteen times as fast as on average until then.
    """
    travelled, passed = (a[half : len(x) - half] - a[0] for a in (x, t))
    broken = speed * passed >= _BROKEN * np.maximum(travelled, 10 * resolution)
    broken[: int(_SHARE * len(broken))] = False
    mean_speed = (x[-1] - x[0]) / (t[-1] - t[0])
    if speed.max() >= _BROKEN * mean_speed > 0:
        return len(x) - 1
    return int(np.argmax(broken)) + half if broken.any() else None


def _speed(t: Array, x: Array, resolution: float) -> tuple[Array, int]:
    """Central differences over a window that noise and steps of the sensor do not fill."""
    span = float(t[-1] - t[0])
    pace = float(x[-1] - x[0]) / span
    window = max(_WINDOW * span, _STEPS * resolution / pace if pace > 0 else 0.0)
    half = max(1, round(min(window, _WIDEST * span) / span * (len(t) - 1) / 2))
    return (x[2 * half :] - x[: -2 * half]) / (t[2 * half :] - t[: -2 * half]), half


def _by_stiffness(
    x: Array, u: Array, compliance: Array, inner: slice, start: float
) -> float | None:
    """Where compliance is a hundred times that of the ramp's beginning, which it defines itself."""
    level = start
    for _ in range(10):
        low, high = (share * level for share in _BEGINNING)
        at = (u > low) & (u < high)
        if at.sum() < 3:  # noqa: PLR2004 - a slope takes some
            return None
        first = float(np.polyfit(u[at], x[at], 1)[0])
        yielded = compliance > _COMPLIANT * first
        if not first > 0 or not yielded.any():
            return None
        before, level = level, float(u[inner][np.argmax(yielded)])
        if level == before:
            break
    return level
