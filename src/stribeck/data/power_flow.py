"""What gear and screw of a drive lose, by the way that power goes through them."""

from __future__ import annotations

import numpy as np

from ..drive import DriveChain
from ..space import Array

#: Seconds, and samples at least, to each side over which a direction of motion is taken.
_REACH, _LEAST = 5e-3, 2


def loss_factors(
    chain: DriveChain, t: Array, position: Array, velocity: Array | None, force: Array
) -> Array:
    """What losses make of each sample of a force at the axis, (N,); 1 where none are stated.

    Args:
        chain: The drive's.
        t: Time, s, (N,).
        position: (N,).
        velocity: As it was recorded, (N,); else the direction is that of the position.
        force: Without losses, (N,).
    """
    if not chain.lossy:
        return np.ones(len(t))
    return chain.losses(force, _direction(t, position) if velocity is None else velocity)


def _direction(t: Array, position: Array) -> Array:
    """A velocity that need not be smooth: the change of position to both sides, (N,)."""
    reach = max(_LEAST, round(_REACH / float(np.median(np.diff(t)))))
    rows = np.arange(len(t))
    after, before = np.minimum(rows + reach, len(t) - 1), np.maximum(rows - reach, 0)
    change: Array = position[after] - position[before]
    return change
