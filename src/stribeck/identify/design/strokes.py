"""What an axis with a measured force can do next: strokes of other speeds, reversals, loads.

The axis is taken to follow: a force balance asks what force a motion takes, not how it came about.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...friction import LOADS
from ...rig.balanced import as_balanced
from ...space import Array
from .experiment import Experiment
from .proposals import MARGIN, Left

if TYPE_CHECKING:
    from .operating_range import Axis

#: Where position, temperature and normal load stand among the loads.
_NORMAL, _POSITION, _TEMPERATURE = (LOADS.index(n) for n in ("normal", "position", "temperature"))
#: Shares of the greatest speed in the log.
SEVERAL = (0.01, 0.03, 0.1, 0.3, 1.0)
SLOW = (0.002, 0.005, 0.01, 0.02, 0.05)
FAST = (0.25, 0.5, 0.75, 1.0)
#: Share of the greatest acceleration that strokes take, so that speeds are constant for long.
GENTLE = 0.5
#: A load that differs by less than this share has one level; it is then also halved.
LEVEL = 0.1


@dataclass(frozen=True, eq=False)
class Loads:
    """What an axis with a measured force was exposed to, SI.

    Args:
        acceleration: Greatest acceleration, but for the odd sample.
        normal: Least and greatest normal load; None where there is none.
        temperature: Mean, K; 0 where it was not recorded.
    """

    acceleration: float
    normal: tuple[float, float] | None
    temperature: float


def strokes(axis: Axis, seen: Loads, seconds: float, left: Left) -> list[Experiment]:
    """Candidates of an axis with a measured force.

    Args:
        axis: The axis.
        seen: Its loads.
        seconds: How long each takes.
        left: Takes what was left out, and why.
    """
    found = []
    for experiment in _offers(axis, seen, seconds):
        predicted = experiment.predict(axis.x[None])
        if not predicted.size:
            left.append((experiment.name, "all of it is slower than the balance uses"))
            continue
        force = float(np.abs(predicted).max())
        if not np.isfinite(force):
            left.append((experiment.name, "the model cannot be run there"))
        elif force > MARGIN * axis.force:
            left.append(
                (
                    experiment.name,
                    f"it takes {axis.push(force)}, the log shows {axis.push(axis.force)} at most",
                )
            )
        else:
            found.append(experiment)
    return found


def _offers(axis: Axis, seen: Loads, seconds: float) -> Iterator[Experiment]:
    top, gentle = axis.fastest, GENTLE * seen.acceleration
    said = {
        "several speeds": ("strokes there and back at constant speeds of", SEVERAL),
        "slow speeds": ("slow strokes there and back at constant speeds of", SLOW),
        "fast speeds": ("long strokes there and back at constant speeds of", FAST),
    }
    for name, (words, shares) in said.items():
        pace = [s * top for s in shares]
        listed = ", ".join(axis.rate(v).split()[0] for v in pace[:-1])
        told = (
            f"{words} {listed} and {axis.rate(pace[-1])}, {seconds / len(pace):.2g} s at each, "
            f"from {axis.place(axis.low)}"
        )
        yield _made(axis, seen, name, told, _shuttle(axis, pace, gentle, seconds))
    yield _one_speed(axis, seen, seconds)
    yield _reversals(axis, seen, seconds)
    yield _made(
        axis,
        seen,
        "hard accelerations",
        f"speed up to {axis.rate(top)} and stop again as hard as the log does, there and back, "
        "without pause",
        _shuttle(axis, [top], seen.acceleration, seconds, shortest=True),
    )
    if seen.normal is not None:
        yield _levels(axis, seen, seconds)


def _one_speed(axis: Axis, seen: Loads, seconds: float) -> Experiment:
    v = 0.5 * axis.fastest
    words = f"strokes there and back at {axis.rate(v)}, from {axis.place(axis.low)}"
    motion = _shuttle(axis, [v], GENTLE * seen.acceleration, seconds)
    return _made(axis, seen, "one speed", words, motion)


def _reversals(axis: Axis, seen: Loads, seconds: float) -> Experiment:
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
    return _made(axis, seen, "slow sine", words, (*motion, peak * w * np.cos(w * t)))


def _levels(axis: Axis, seen: Loads, seconds: float) -> Experiment:
    assert seen.normal is not None  # noqa: S101 - asked before
    low, high = seen.normal
    if high - low < LEVEL * high:
        low = 0.5 * high
    levels = np.linspace(low, high, 4)
    pace = [s * axis.fastest for s in (0.1, 0.3, 1.0)]
    one = [_shuttle(axis, pace, GENTLE * seen.acceleration, seconds / len(levels))] * len(levels)
    q, v, a = (np.concatenate([part[k] for part in one]) for k in range(3))
    share = len(one[0][0])
    normal = np.repeat(levels, share)
    listed = ", ".join(f"{v:.3g}" for v in levels)
    words = (
        f"strokes there and back at {', '.join(axis.rate(v) for v in pace)}, at normal loads of "
        f"{listed} (SI) one after the other"
    )
    return _made(axis, seen, "load levels", words, (q, v, a), normal)


def _clock(axis: Axis, seconds: float) -> Array:
    clock: Array = axis.interval * np.arange(max(int(seconds / axis.interval), 10), dtype=float)
    return clock


def _shuttle(
    axis: Axis, pace: Sequence[float], hard: float, seconds: float, *, shortest: bool = False
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
        many = max(2, 2 * round(share / (2 * length)))
        length = share / many
        top = min(top, 0.5 * hard * length)
        within = t % length
        sign = np.where((t // length).astype(int) % 2 == 0, 1.0, -1.0)
        v = np.minimum(top, hard * np.minimum(within, length - within))
        a = np.where(v < top, np.where(within < length / 2, hard, -hard), 0.0)
        parts.append(np.array([sign * v, sign * a]))
    v, a = np.concatenate(parts, axis=1)
    q = axis.low + axis.interval * np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]))])
    return np.clip(q, axis.low, axis.high), v, a


def _made(
    axis: Axis,
    seen: Loads,
    name: str,
    words: str,
    motion: tuple[Array, Array, Array],
    normal: Array | None = None,
) -> Experiment:
    q, v, a = motion
    rig = as_balanced(axis.parameters.rig)
    loads = np.zeros((len(v), len(LOADS)))
    loads[:, _POSITION], loads[:, _TEMPERATURE] = q, seen.temperature
    if normal is not None:
        loads[:, _NORMAL] = normal
    elif seen.normal is not None:
        loads[:, _NORMAL] = np.mean(seen.normal)
    keep = (np.abs(v) >= rig.filtering.slowest) & (v != 0)
    v, a, loads = (np.ascontiguousarray(part[keep]) for part in (v, a, loads))

    def predict(x: Array) -> Array:
        full = axis.parameters.full(x[:, : len(axis.x)])
        return np.array([rig.force(axis.parameters.law, p, v, a, loads) for p in full])

    seconds = axis.interval * len(q)
    return Experiment(name, words, seconds, predict, axis.noise, axis.inflation)
