"""A force that came through a drive chain: what gear and screw lose, by the way that power goes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..space import Array
from .filtering import Filtering, even, smooth

if TYPE_CHECKING:
    from ..drive import DriveChain
    from .recording import Recording


def through(recording: Recording, chain: DriveChain, column: str = "") -> Recording:
    """A log whose force is a drive's signal times the gain of its chain, with the losses.

    Args:
        recording: The log, its force at the axis without losses.
        chain: Its chain.
        column: The signal's head, for the note.

    Raises:
        InputError: it has no force, or one that a chain has been applied to.
    """
    if recording.drive is not None:
        raise InputError(
            f"{recording.label}: its force came through a drive chain already: apply it once"
        )
    if recording.force is None:
        raise InputError(
            f"{recording.label}: no column is the drive's {chain.signal.text}: map it, as in "
            f'force = "head [{chain.signal.unit}]"'
        )
    notes = (*recording.notes, chain.sentence(column))
    driven = replace(recording, drive=chain, notes=notes)
    if not chain.lossy:
        return driven
    return replace(driven, force=recording.force * losses(driven, chain))


def losses(recording: Recording, chain: DriveChain) -> Array:
    """What gear and screw of a chain make of each sample of a log's force, (N,)."""
    if recording.force is None:
        return np.ones(len(recording))
    return chain.losses(recording.force, _velocity(recording))


def _velocity(recording: Recording) -> Array:
    """The velocity of a log, recorded or of its low-passed position, (N,)."""
    if recording.velocity is not None:
        return recording.velocity
    log = even(recording, np.zeros(len(recording)))
    velocity = smooth(log.position, log.rate, Filtering())[1]
    return np.interp(recording.t, log.t, velocity)
