"""The gate: a log put right where that is certain, and what is left to tell."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

from .command_unit import in_two_units
from .contradictions import contradicted
from .discontinuities import broken, without_breaks, without_strays, without_wraps
from .plateaus import clipping
from .repeats import frozen, gaps, held

if TYPE_CHECKING:
    from ..recording import Recording
    from .fault import Fault

#: Samples below which nothing can be said about a log.
FEWEST = 30

_MENDED: WeakKeyDictionary[Recording, Recording] = WeakKeyDictionary()
_FAULTS: WeakKeyDictionary[Recording, tuple[Fault, ...]] = WeakKeyDictionary()


def mended(recording: Recording) -> Recording:
    """A log with what is certain put right and told in its notes; itself, if there is nothing.

    Single wild samples of position and force are replaced, wraps are unwrapped, and a log whose
    position breaks off (a reset, a jump, missing rows) is cut to its longest piece.
    """
    if recording in _MENDED:
        return _MENDED[recording]
    result, notes = recording, []
    if _is_motion(recording):
        for step in (without_wraps, without_strays, without_wraps, without_breaks):
            result, changes = step(result)
            notes += changes
    if notes:
        result = replace(result, notes=(*result.notes, *notes))
    _MENDED[recording] = _MENDED[result] = result
    return result


def faults(recording: Recording) -> tuple[Fault, ...]:
    """What is wrong with a log that has been mended, in the order of the table of kinds."""
    if recording not in _FAULTS:
        looks = (broken, contradicted, in_two_units, clipping, frozen, held, gaps)
        _FAULTS[recording] = (
            tuple(f for look in looks for f in look(recording)) if _is_motion(recording) else ()
        )
    return _FAULTS[recording]


def _is_motion(recording: Recording) -> bool:
    """Whether there are samples of a motion to look at, enough of them."""
    return len(recording) >= FEWEST and recording.runs is None
