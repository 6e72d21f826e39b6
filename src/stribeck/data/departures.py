"""Motions with which an axis breaks away from a rest: slips, and slides as long as one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..space import Array

if TYPE_CHECKING:
    from .recording import Recording
    from .segmentation import Segments

#: Samples that a level is taken from, and that a motion is followed for after it has landed, at
#: least.
_FEW, _LANDED = 50, 5


@dataclass(frozen=True)
class Departure:
    """A motion out of a rest.

    Args:
        rest: The samples at rest.
        start: The last one near their level.
        leaving: The first that is seen to have left it.
        stop: The end of the samples until it rests again: as long after it has landed as it took,
            at most until the next motion.
    """

    rest: slice
    start: int
    leaving: int
    stop: int


@dataclass(frozen=True)
class SlipOnset:
    """The beginning of a slip.

    Args:
        before: An instant at which the axis still bore what pulled at it, s.
        after: One at which it no longer did, s.
        position: Where it rested, m or rad.
        direction: Of the slip, +1 or -1.
        seconds: How long the axis took for the first part of its way, s.
        uncertain: How far from `position` it may have rested, by the steps and the noise of its
            sensor, m or rad.
        instant: When it begins, s, where a force is known that is held from sample to sample and
            flickers: `before` is then the sample at which the axis bore most, and `after` the one
            that broke it away. Else None: half-way between the two.
    """

    before: float
    after: float
    position: float
    direction: int
    seconds: float
    uncertain: float = 0.0
    instant: float | None = None


def departures(recording: Recording, segments: Segments) -> list[Departure]:
    """Every motion with which an axis breaks away from a rest: slips, and slides as long as one.

    What is both slower and shorter than slips are is creep, which begins below breakaway.
    """
    slips = segments.slips
    if not slips:
        return []
    least = float(np.median([abs(s.jump) for s in slips]))
    motions: list[Departure] = []
    for rest, after in zip(segments.rests, [*segments.rests[1:], None], strict=True):
        motion = _departure(recording.position, segments, rest, after)
        if motion is None:
            continue
        if motions:
            motions[-1] = replace(motions[-1], stop=min(motions[-1].stop, motion.start + 1))
        motions.append(motion)
    return [
        m
        for m in motions
        if m.leaving < m.stop
        and (
            any(m.rest.start <= s.start < m.leaving <= s.stop for s in slips)
            or np.ptp(recording.position[m.start : m.stop]) >= least
        )
    ]


def _departure(x: Array, segments: Segments, rest: slice, after: slice | None) -> Departure | None:
    """The motion out of a rest, until the axis has come to the one after; None if it has none."""
    near, level = 2 * segments.noise + segments.step, _median(x[rest][-_FEW:])
    first, end = max(rest.start, rest.stop - 1 - _FEW), len(x) if after is None else after.stop
    away = np.flatnonzero(np.abs(x[first:end] - level) > segments.band)
    away = away[away > 0]
    if not len(away):
        return None
    leaving = first + int(away[0])
    still = np.flatnonzero(np.abs(x[first:leaving] - level) <= near)
    start = first + (int(still[-1]) if len(still) else 0)
    if after is None:
        return Departure(rest, start, leaving, end)
    there = np.flatnonzero(np.abs(x[leaving:end] - _median(x[after][:_FEW])) <= near)
    landed = max(leaving + int(there[0]) if len(there) else after.start, leaving + 1)
    return Departure(rest, start, leaving, min(landed + max(landed - start, _LANDED), end))


def _median(x: Array) -> float:
    return float(np.median(x))
