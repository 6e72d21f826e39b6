"""What a held-out range tests: how long and how far the axis moves in it, how often it slips."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from ..data.recording import Recording
from ..data.segmentation import segment
from ..rig import Rig
from ..units import unit
from .uncertainty.sensor_noise import sensor_noise

#: An axis does not move in a range in which its position varies by less than so many times the
#: noise of its sensor, as of what was trained on.
RESTING = 1.5


class Scope(NamedTuple):
    """What a range tests.

    Args:
        text: In words.
        moves: Whether the axis moves in it; if not, it tests nothing.
    """

    text: str
    moves: bool


def held_out_scope(pieces: Iterable[tuple[Recording, Any]], rig: Rig) -> Scope:
    """What pieces of logs test.

    Args:
        pieces: Each log with its rows that count: a slice or a mask.
        rig: In whose unit travel is said.
    """
    seconds, travel, slips, moves = 0.0, 0.0, 0, False
    for recording, rows in pieces:
        t, x = recording.t[rows], recording.position[rows]
        if len(t) < 2:  # noqa: PLR2004 - a motion needs two
            continue
        moves |= bool(np.std(x) > RESTING * sensor_noise(recording))
        seconds += float(t[-1] - t[0])
        travel = max(travel, float(np.ptp(x)))
        slips += sum(
            bool(recording.t[s.stop] > t[0] and recording.t[s.start] < t[-1])
            for s in segment(recording).slips
        )
    if not moves:
        return Scope("nothing: the axis does not move in it", moves=False)
    shown = rig.unit_shown("position")
    text = f"{seconds:.3g} s, {unit(shown).from_si(travel):.3g} {shown} of travel"
    return Scope(f"{text}, {slips} slip{'s' * (slips != 1)}" if slips else text, moves=True)
