"""Positions and commands in two units, as where a head says mm and the column has m."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .fault import Fault, shown_as

if TYPE_CHECKING:
    from ..recording import Recording

#: Factors between units that are taken for each other.
_FACTORS = {1e3: "mm and m", 180.0 / np.pi: "degrees and radians", 25.4: "inches and mm"}
#: How near to one of them the ratio of the spans is: one that overshoots or lags is nearer to 1.
_NEAR = 1.15
#: Both go together to this correlation.
_ALIKE = 0.9


def in_two_units(recording: Recording) -> list[Fault]:
    """A position that is its command times the factor between two units."""
    x, goal = recording.position, recording.command
    if goal is None or not (np.ptp(x) > 0 and np.ptp(goal) > 0):
        return []
    if np.corrcoef(x, goal)[0, 1] < _ALIKE:
        return []
    ratio = float(np.std(goal) / np.std(x))
    for factor, units in _FACTORS.items():
        if 1 / _NEAR < max(ratio, 1 / ratio) / factor < _NEAR:
            spans = (
                shown_as(recording, c, float(np.ptp(a)))
                for c, a in (("position", x), ("command", goal))
            )
            sentence = (
                f"position spans {' where its command spans '.join(spans)}, which are as far apart "
                f"as {units}: check the units of both"
            )
            rows = np.ones(len(x), dtype=bool)
            return [Fault("contradiction", "command", rows, ratio, sentence, harmful=False)]
    return []
