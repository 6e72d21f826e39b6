"""The force that a model makes of a filtered log, as a signal over its samples, and its slope."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

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


def slope_over_time(log: Log, model: Signal, at: Samples) -> Array:
    """The slope of a modelled force over time at some samples, of neighbours that count alone.

    Across a reversal, where samples do not count, the force of friction steps: that is no slope
    of what a delay would move.
    """
    rows = np.arange(at.start, at.stop) if isinstance(at, slice) else at
    before, after = np.maximum(rows - 1, 0), np.minimum(rows + 1, len(log) - 1)
    before = np.where(log.unsure[before], rows, before)
    after = np.where(log.unsure[after], rows, after)

    def modelled(samples: Samples) -> Array:
        return np.asarray(model(samples) + log.known_at(samples))

    if isinstance(at, slice):
        first = max(at.start - 1, 0)
        force = modelled(slice(first, min(at.stop + 1, len(log))))
        rise = force[after - first] - force[before - first]
    else:
        rise = modelled(after) - modelled(before)
    return np.asarray(rise * log.rate / np.maximum(after - before, 1))
