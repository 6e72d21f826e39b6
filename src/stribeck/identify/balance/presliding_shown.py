"""Whether a log shows how a contact bends before it slides, from its motion and spectrum alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...units import unit
from ..conditions import Violation
from .state_starts import contact_spectrum

if TYPE_CHECKING:
    from ...space import Array
    from .regression import System
    from .rows import Log

#: Strokes that show the rise of friction after a reversal, and rows of each within it.
_STROKES, _ROWS = 3, 2
#: Friction rises within twice the way by which half of it has yielded.
_RISE = 2.0
#: Units of what says how stiff a contact is.
_OF_BENDING = ("m", "rad", "N/m", "N m/rad", "A/m", "A/rad")


def stiffness_unseen(system: System) -> list[Violation]:
    """Sentences on stiffnesses that logs cannot show, whatever fit is made of them.

    Friction rises within micrometres of a reversal. The logs show how if the sensor resolves that
    way, and if there are rows within it after several reversals.
    """
    law, every = system.law, system.parameters.every
    own = len(law.params)
    names = frozenset(
        every[i].name for i in system.shape if i < own and every[i].unit in _OF_BENDING
    )
    paths = [log.path for log in system.logs if log.path is not None]
    if not names or not paths or law.starts is None:
        return []
    rise = _RISE * contact_spectrum(system).way
    error = max(path.error for path in paths)
    shown = unit("mrad" if system.rig.rotary else "um")
    way, off = (f"{float(shown.from_si(x)):.2g} {shown.written}" for x in (rise, 2 * error))
    if rise <= 2 * error:
        text = (
            f"friction rises within {way} of a reversal, and positions may be off by {off}: the "
            "stiffness cannot be known beyond that: record a finer position"
        )
        return [Violation("data", text, names)]
    strokes = sum(int(np.sum(_rows_within(log, rise) >= _ROWS)) for log in system.logs)
    if strokes >= _STROKES:
        return []
    times = "never" if not strokes else "once" if strokes == 1 else "twice"
    text = (
        f"the motion {times} dwells within {way} of a reversal, in which friction rises: the "
        "stiffness cannot be known: record slow reversals of some such ways"
    )
    return [Violation("data", text, names)]


def _rows_within(log: Log, way: float) -> Array:
    """How many rows of each stroke lie within a way of the reversal it began with."""
    if log.path is None:
        return np.zeros(0)
    heading = log.path.heading
    stroke = np.cumsum(np.diff(heading, prepend=heading[:1]) != 0)
    travel = np.cumsum(np.abs(log.path.way))
    begun = travel[np.searchsorted(stroke, np.arange(stroke[-1] + 1))]
    after = travel - begun[stroke]
    within = (after > 0) & (after < way)
    rows = log.places[within[log.places]]
    return np.bincount(stroke[rows], minlength=int(stroke[-1]) + 1).astype(float)
