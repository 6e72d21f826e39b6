"""What the controller of a position loop read, as the force of a log shows it.

A loop closes through its sensor: its force answers to the reading, with all of its noise, and is
held until the next. Where the axis rests nothing else moves, so that a log with the force beside
the reading tells: under such a loop the force flickers with the reading, and under one that goes by
the position itself it does not.
"""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING

import numpy as np

from ..data.segmentation import rests
from ..space import Array

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..data.recording import Recording

#: Samples at rest that tell, and longest hold that is looked for, in samples.
_FEWEST, _LONGEST = 200, 10
#: Share of the force's variance at rest that the flicker of the reading explains under such a loop,
#: and the gain that it then shows, as a share of the controller's.
_EXPLAINED, _GAIN = 0.3, (0.5, 1.5)
#: What the force may be off by while the axis moves, in multiples of what it is at rest: more is a
#: drive at its limits, or one that does not hold its force.
_OFF = 2.0
#: What sampling intervals may differ by, as a share of the usual one: rows are counted.
_UNEVEN = 0.5

Gains = tuple[float, float]
_known: weakref.WeakKeyDictionary[Recording, dict[Gains, Array | None]]
_known = weakref.WeakKeyDictionary()


def read_stretch(recording: Recording, gains: Gains) -> Array | None:
    """The stretch by which the controller of a log set its force, m, (N,).

    Held from one of its readings to the next. None where the log does not show that it went by its
    reading, or that its drive held what was asked of it.

    Args:
        recording: A log.
        gains: Of the controller at stretches above and below zero, N/m.
    """
    known = _known.setdefault(recording, {})
    if gains not in known:
        known[gains] = _read_stretch(recording, gains)
    return known[gains]


def _read_stretch(recording: Recording, gains: Gains) -> Array | None:
    if recording.force is None or recording.command is None:
        return None
    spans = np.diff(recording.t)
    still = [r for r in rests(recording) if r.stop - r.start > _LONGEST]
    usual = float(np.median(spans))
    if np.abs(spans - usual).max() > _UNEVEN * usual:
        return None
    if sum(r.stop - r.start for r in still) < _FEWEST:
        return None
    stretch = recording.command - recording.position
    flicker, best = _flicker(recording.force, still), None
    for rows in range(1, _LONGEST + 1):
        for first in range(rows):
            held = stretch[_samples(len(stretch), rows, first)]
            asked = np.where(held > 0.0, *gains) * held
            share, gain = _explained(flicker, _flicker(asked, still))
            if best is None or share > best[0]:
                best = share, gain, held, asked
    assert best is not None  # noqa: S101 - there are holds to look for
    share, gain, held, asked = best
    if share < _EXPLAINED or not _GAIN[0] < gain < _GAIN[1]:
        return None
    return held if _obeyed(recording.force, asked, still) else None


def _samples(n: int, rows: int, first: int) -> Array:
    """For each of n samples the last one at which a controller read that does every so many."""
    at: Array = np.maximum((np.arange(n) - first) // rows * rows + first, 0)
    return at


def _flicker(force: Array, still: Sequence[slice]) -> Array:
    """A force at rests, without the straight line that it follows in each."""
    parts = []
    for rest in still:
        k = np.linspace(-1.0, 1.0, rest.stop - rest.start)
        part = force[rest] - force[rest].mean()
        parts.append(part - k * (k @ part) / (k @ k))
    return np.concatenate(parts)


def _explained(flicker: Array, by: Array) -> tuple[float, float]:
    """The share of the variance of a flicker that another one explains, and the slope."""
    power, product = float(by @ by), float(by @ flicker)
    if not power > 0.0:
        return 0.0, 0.0
    return product**2 / (power * float(flicker @ flicker)), product / power


def _obeyed(force: Array, asked: Array, still: Sequence[slice]) -> bool:
    """Whether the force is in proportion to what was asked of it while the axis moves, too."""
    resting = np.zeros(len(force), dtype=bool)
    for rest in still:
        resting[rest] = True
    slope, level = np.polyfit(asked[resting], force[resting], 1)
    off = np.square(force - slope * asked - level)
    return bool(resting.all() or off[~resting].mean() <= _OFF**2 * off[resting].mean())
