"""Channels that stand still: frozen for a stretch, or renewed more slowly than the log runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from ..outliers import apart
from ..repeated_samples import new_samples, renewal
from ..resolution import noise_of, step
from ..runs import runs
from .fault import Fault, mask, shown_as

if TYPE_CHECKING:
    from ..recording import Recording

#: Samples of one value that make a frozen stretch, and how many times as long it is as any other.
LONG, LONGER = 20, 5.0
#: Stretches that may be frozen, and share of the log that all of them take at least.
MOST, SHARE = 3, 0.005
#: The axis moves meanwhile, by so many steps and standard deviations and this share of its travel.
STEPS, SIGMAS, TRAVEL = 10.0, 20.0, 0.02
#: A channel never stands still whose noise is so many of its steps. An irregular clock makes noise
#: of fast motion, up to three steps on a real arm, so a position takes more.
_NOISY = {"position": 5.0, "force": 2.0}
#: A gap is so many times as long as nearly all intervals, and lacks so many rows.
_GAP, _ROWS = 3.5, 10


def frozen(recording: Recording) -> list[Fault]:
    """Position or force that stands still while the other channels move, a fault each."""
    channels = recording.channels()
    result = []
    for name in ("position", "force"):
        if name not in channels:
            continue
        stretches = [
            (a, b) for a, b in _standing(channels[name]) if _is_frozen(recording, name, a, b)
        ]
        rows = np.zeros(len(recording), dtype=bool)
        for a, b in stretches:
            rows[a:b] = True
        if rows.mean() < SHARE:
            continue
        spans = ", ".join(
            f"{recording.t[a]:.4g} to {recording.t[b - 1]:.4g} s" for a, b in stretches
        )
        value = shown_as(recording, name, float(channels[name][stretches[0][0]]))
        seconds = float(sum(recording.t[b - 1] - recording.t[a] for a, b in stretches))
        sentence = (
            f"{name} stands still at {value} while the other channels move ({spans}): train on "
            "ranges without it"
        )
        result.append(Fault("frozen", name, rows, seconds, sentence))
    return result


def _standing(y: Array) -> list[tuple[int, int]]:
    """The few stretches of one value that are far longer than all others."""
    starts, stops = runs(np.append(y[1:] == y[:-1], False))
    lengths = (stops - starts + 1).astype(float)
    if not len(lengths):
        return []
    order = np.argsort(lengths)[::-1]
    sizes = np.append(lengths[order], 1.0)
    k = apart(sizes, LONGER, MOST)
    return [(int(starts[i]), int(stops[i]) + 1) for i in order[:k] if lengths[i] >= LONG]


def _flickers(y: Array, a: int, steps: float) -> bool:
    """Whether noise would have changed what stands still; an idle drive shows zero, though."""
    jumps = np.abs(np.diff(y))
    q = step(y) or float(jumps[jumps > 0].min(initial=np.inf))
    return bool(noise_of(y) > steps * q and y[a] != 0)


def _lives(recording: Recording, name: str, a: int, b: int) -> bool:
    """Whether any other channel changes over a stretch: a logger may repeat a whole row."""
    others = [y for other, y in recording.channels().items() if other != name]
    return not others or any(np.ptp(y[a:b]) > 0 for y in others)


def _resumes(y: Array, a: int, b: int) -> bool:
    """Whether a stretch lies inside the log and is left by a leap that catches up."""
    if a == 0 or b >= len(y):
        return False
    steps = np.abs(np.diff(y))
    usual = float(np.quantile(steps[steps > 0], 0.9))
    return bool(abs(y[b] - y[b - 1]) > 2 * usual)


def _is_frozen(recording: Recording, name: str, a: int, b: int) -> bool:
    """Whether a channel should have changed over a stretch in which it stands still.

    A force while the axis moves, by its noise or as it leaps afterwards; a position while its
    recorded velocity goes on, or by its noise while any other channel changes.
    """
    y = recording.channels()[name]
    moves = any(np.ptp(w[a:b]) > least for w, least in _witnesses(recording, name))
    flickers = _flickers(y, a, _NOISY[name])
    if name == "position" and flickers and _lives(recording, name, a, b):
        return True
    return moves and ((flickers and name == "force") or _resumes(y, a, b))


def _witnesses(recording: Recording, name: str) -> list[tuple[Array, float]]:
    """What shows that the axis moves while a channel stands still, and by how much it must."""
    x = recording.position
    least = STEPS * step(x) + SIGMAS * noise_of(x) + TRAVEL * float(np.ptp(x))
    if name == "position":
        return [] if recording.velocity is None else [(_travelled(recording), least)]
    return [(x, least)]


def _travelled(recording: Recording) -> Array:
    """The integral of the recorded velocity."""
    assert recording.velocity is not None  # noqa: S101 - of logs that have it
    v = recording.velocity
    return np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(recording.t))])


def held(recording: Recording) -> list[Fault]:
    """Position or force that repeats each value for some samples, a fault each."""
    channels = recording.channels()
    result = []
    for name in ("position", "force"):
        if name not in channels:
            continue
        if not (period := renewal(recording.t, channels[name])):
            continue
        samples = period / recording.dt
        sentence = (
            f"{name} repeats its values: it is renewed every {period * 1e3:.3g} ms, about "
            f"{samples:.1f} samples, so it is {0.5 * (period - recording.dt) * 1e3:.3g} ms late on "
            "average: log at the rate of its sensor"
        )
        result.append(Fault("held", name, ~new_samples(channels[name]), period, sentence))
    return result


def gaps(recording: Recording) -> list[Fault]:
    """Times without samples, one fault for all."""
    dt = np.diff(recording.t)
    if dt.max(initial=0.0) <= _GAP * recording.dt:
        return []
    # What a log on an irregular clock leaves out now and then is its sampling.
    usual = float(np.quantile(dt, 0.99))
    far = np.flatnonzero(dt > _GAP * max(usual, recording.dt))
    far = far[dt[far] > _ROWS * recording.dt]
    if not len(far):
        return []
    longest = int(far[np.argmax(dt[far])])
    rows: NDArray[np.bool_] = mask(len(recording), np.concatenate([far, far + 1]))
    share = float(dt[far].sum() / (recording.t[-1] - recording.t[0]))
    sentence = (
        f"no samples for {dt[longest]:.3g} s after {recording.t[longest]:.4g} s"
        + (f", {len(far)} gaps in all" if len(far) > 1 else "")
        + f", {share:.1%} of the time: nothing is known of the motion there"
    )
    return [Fault("gap", "time", rows, float(dt[far].sum()), sentence, harmful=False)]
