"""The force that a model makes of a filtered log, as a signal over its samples."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...space import Array
from .rows import Log

if TYPE_CHECKING:
    from ...data.zero_phase import Samples, Signal
    from ...friction import Law
    from ...rig.balanced import BalancedRig


def friction_signal(rig: BalancedRig, law: Law, log: Log, p: Array) -> Signal:
    """Friction at samples, N (N m): of a law with states, what the whole log has made of them.

    Args:
        rig: Whose forces are balanced.
        law: Its friction.
        log: The motion.
        p: (k,) the law's parameters, then the rig's own.
    """
    if log.path is not None:
        loads = log.loads(log.clock, log.position[:])
        whole = rig.friction_along(law, p, log.path, loads)
        return lambda at: whole[at]

    def friction(at: Samples) -> Array:
        motion = log.motion(at)
        return rig.friction(law, p, motion.v, motion.loads)

    return friction


def force_signal(rig: BalancedRig, law: Law, log: Log, p: Array) -> Signal:
    """The force that a motion takes at samples, N (N m), as `friction_signal`."""
    friction = friction_signal(rig, law, log, p)

    def force(at: Samples) -> Array:
        return rig.force(law, p, *log.motion(at), friction(at))

    return force
