"""Strokes of an axis with a measured force: other speeds, reversals, loads.

The axis is taken to follow: a force balance asks what force a motion takes, not how it came about.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...space import Array
from .offer import Exposure, ImposedMotion, Offer, OperatingRange

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

#: Shares of the greatest speed in the log.
SEVERAL = (0.01, 0.03, 0.1, 0.3, 1.0)
SLOW = (0.002, 0.005, 0.01, 0.02, 0.05)
FAST = (0.25, 0.5, 0.75, 1.0)
#: Share of the greatest acceleration that strokes take, so that speeds are constant for long.
GENTLE = 0.5
#: A load that differs by less than this share has one level; it is then also halved.
LEVEL = 0.1


def strokes(axis: OperatingRange, seconds: float) -> Iterator[Offer]:
    """Strokes at other speeds, turns, hard accelerations, and levels of the normal load.

    Args:
        axis: The axis, with its exposure.
        seconds: How long each takes.
    """
    assert axis.exposure is not None  # noqa: S101 - known where a force was measured
    exposure = axis.exposure
    top, gentle = axis.fastest, GENTLE * exposure.acceleration
    speeds = {
        "several speeds": ("strokes there and back at constant speeds of", SEVERAL),
        "slow speeds": ("slow strokes there and back at constant speeds of", SLOW),
        "fast speeds": ("long strokes there and back at constant speeds of", FAST),
    }
    for name, (words, shares) in speeds.items():
        pace = [s * top for s in shares]
        sentence = (
            f"{words} {axis.listed('velocity', pace)}, {seconds / len(pace):.2g} s at each, "
            f"from {axis.place(axis.low)}"
        )
        yield _offer(name, sentence, _shuttle(axis, pace, gentle, seconds))
    yield _one_speed(axis, exposure, seconds)
    yield _reversals(axis, seconds)
    yield _offer(
        "hard accelerations",
        f"speed up to {axis.rate(top)} and stop again as hard as the log does, there and back, "
        "without pause",
        _shuttle(axis, [top], exposure.acceleration, seconds, shortest=True),
    )
    if exposure.normal is not None:
        yield _levels(axis, exposure, seconds)


def _one_speed(axis: OperatingRange, exposure: Exposure, seconds: float) -> Offer:
    v = 0.5 * axis.fastest
    words = f"strokes there and back at {axis.rate(v)}, from {axis.place(axis.low)}"
    motion = _shuttle(axis, [v], GENTLE * exposure.acceleration, seconds)
    return _offer("one speed", words, motion)


def _reversals(axis: OperatingRange, seconds: float) -> Offer:
    """A slow sine, which dwells near rest and turns often."""
    peak = 0.1 * axis.fastest
    reach = min(0.25 * (axis.high - axis.low), peak * seconds / 20)
    w = peak / reach
    t = _clock(axis, seconds)
    motion = 0.5 * (axis.low + axis.high) - reach * np.cos(w * t), peak * np.sin(w * t)
    words = (
        f"a sine of ±{axis.place(reach)} about the middle, {2 * np.pi / w:.2g} s a turn, so "
        f"{axis.rate(peak)} at most"
    )
    return _offer("slow sine", words, (*motion, peak * w * np.cos(w * t)))


def _levels(axis: OperatingRange, exposure: Exposure, seconds: float) -> Offer:
    assert exposure.normal is not None  # noqa: S101 - asked before
    low, high = exposure.normal
    if high - low < LEVEL * high:
        low = 0.5 * high
    levels = np.linspace(low, high, 4)
    pace = [s * axis.fastest for s in (0.1, 0.3, 1.0)]
    shuttle = [_shuttle(axis, pace, GENTLE * exposure.acceleration, seconds / len(levels))] * len(
        levels
    )
    q, v, a = (np.concatenate([part[k] for part in shuttle]) for k in range(3))
    share = len(shuttle[0][0])
    normal = np.repeat(levels, share)
    listed = ", ".join(f"{v:.3g}" for v in levels)
    words = (
        f"strokes there and back at {', '.join(axis.rate(v) for v in pace)}, at normal loads of "
        f"{listed} (SI) one after the other"
    )
    return _offer("load levels", words, (q, v, a), normal)


def _clock(axis: OperatingRange, seconds: float) -> Array:
    clock: Array = axis.interval * np.arange(max(int(seconds / axis.interval), 10), dtype=float)
    return clock


def _shuttle(
    axis: OperatingRange,
    pace: Sequence[float],
    hard: float,
    seconds: float,
    *,
    shortest: bool = False,
) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration of strokes from the lower end and back.

    Each speed has an equal share of the time. Strokes are as long as the travel and the time
    allow, or as short as the speed does.
    """
    parts = []
    for speed in pace:
        t = _clock(axis, seconds / len(pace))
        share = float(t[-1]) + axis.interval
        travel = axis.high - axis.low
        top = min(speed, np.sqrt(0.9 * travel * hard))
        least = 2 * top / hard
        longest = travel / top + top / hard
        length = max(least, min(share / 2, least if shortest else longest))
        count = max(2, 2 * round(share / (2 * length)))
        length = share / count
        top = min(top, 0.5 * hard * length)
        phase = t % length
        sign = np.where((t // length).astype(int) % 2 == 0, 1.0, -1.0)
        v = np.minimum(top, hard * np.minimum(phase, length - phase))
        a = np.where(v < top, np.where(phase < length / 2, hard, -hard), 0.0)
        parts.append(np.array([sign * v, sign * a]))
    v, a = np.concatenate(parts, axis=1)
    q = axis.low + axis.interval * np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]))])
    return np.clip(q, axis.low, axis.high), v, a


def _offer(
    name: str, words: str, motion: tuple[Array, Array, Array], normal: Array | None = None
) -> Offer:
    return Offer(name, words, motion=ImposedMotion(*motion, normal))
