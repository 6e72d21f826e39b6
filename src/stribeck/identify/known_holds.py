"""Slips under forces that are known to be held, among the segments of a fit."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .held_onset import held_onsets

if TYPE_CHECKING:
    from ..data.departures import SlipOnset
    from ..rig.simulated import SimulatedRig
    from .segment import Segment


def moved_holds(
    rig: SimulatedRig, segments: Sequence[Segment], late: Sequence[float]
) -> dict[int, SlipOnset]:
    """The onsets of slips under forces that are held, some seconds later, by their places."""
    groups = defaultdict[tuple[int, int], dict[int, float]](dict)
    for k, s in enumerate(segments):
        if s.onset is not None and s.onset.instant is not None:
            groups[id(s.recording), s.onset.direction][k] = s.onset.instant + late[k]
    moved: dict[int, SlipOnset] = {}
    for group in groups.values():
        slips = [segments[k] for k in group]
        tracks, onsets = [s.track for s in slips], [s.onset for s in slips if s.onset]
        placed = held_onsets(rig, tracks, onsets, np.array(list(group.values())))
        moved.update(zip(group, placed, strict=True))
    return moved


def is_held(segment: Segment) -> bool:
    """Whether a segment is a slip under a force that is known to be held."""
    return segment.onset is not None and segment.onset.instant is not None


def place_in_hold(segment: Segment) -> tuple[float, float] | None:
    """How long after the beginning of its hold a slip begins, and the length of the hold, s.

    None where no force is known to be held.
    """
    track, onset = segment.track, segment.onset
    if onset is None or onset.instant is None:
        return None
    at = int(np.searchsorted(track.t, onset.after))
    changes = np.flatnonzero(track.stretch[at:] != track.stretch[at])
    until = float(track.t[at + changes[0]] if len(changes) else track.t[-1])
    return onset.instant - onset.after, until - onset.after
