"""The force that a model makes of a filtered log, as a signal over its samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ...space import Array
from .rows import FilteredMotion, Log

if TYPE_CHECKING:
    from ...data.zero_phase import Samples, Signal
    from ...friction import Law
    from ...rig.balanced import BalancedRig


def friction_signal(rig: BalancedRig, law: Law, log: Log, p: Array) -> Signal:
    """Friction at samples, as `friction_under`, of which the motion is not at hand."""
    friction = friction_under(rig, law, log, p)
    return lambda at: friction(at, log.motion(at))


def friction_under(
    rig: BalancedRig, law: Law, log: Log, p: Array
) -> Callable[[Samples, FilteredMotion], Array]:
    """Friction at samples under their motion, N (N m): with states, what the log has made of them.

    Args:
        rig: Whose forces are balanced.
        law: Its friction.
        log: The motion.
        p: (k,) the law's parameters, then the rig's own.
    """
    if log.path is not None:
        loads = log.loads(log.clock, log.position[:])
        whole = rig.friction_along(law, p, log.path, loads)
        return lambda at, _: whole[at]
    return lambda _, motion: rig.friction(law, p, motion.v, motion.loads)


def force_signal(rig: BalancedRig, law: Law, log: Log, p: Array) -> Signal:
    """The force that a motion takes at samples, N (N m), as `friction_under`."""
    friction = friction_under(rig, law, log, p)

    def force(at: Samples) -> Array:
        motion = log.motion(at)
        return rig.force(law, p, *motion, friction(at, motion))

    return force
