"""How far the friction of one trained law lies from another's within the motion of the data.

A law matters by the friction that it changes. Its gain in misfit does not show that: it is in
proportion to the noise of the sensor, so that a quiet sensor makes a great gain of nothing, and a
noisy one hides a tenth of the friction.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..balance.modelled_force import friction_signal
from ..score import simulated

if TYPE_CHECKING:
    from ...space import Array
    from ..balance.balance import Balance
    from .trained_law import TrainedLaw

#: The change is the greatest one but for this share of the samples that move.
_ODD = 0.01
#: A speed below this share of the greatest one is no motion.
_MOVING = 1e-3


def friction_change(simple: TrainedLaw, rich: TrainedLaw) -> float:
    """The greatest change of friction from one law to the other, as a share of its mean size.

    Over the speeds, loads, positions and temperatures of the training data where a force is
    balanced; over the speeds of the richer law's motion, and at rest in its directions, where a
    motion is simulated. nan where the laws' friction is no function of these: with inner states,
    or with loads in a simulated motion.
    """
    if simple.balance is not None and rich.balance is not None:
        ours, theirs = (_balanced(law.balance) for law in (simple, rich) if law.balance)
        return _share(ours, theirs)
    laws = (simple.parameters.law, rich.parameters.law)
    if not all(law.static for law in laws):
        return float("nan")
    motions = simulated(rich.parameters, rich.p, rich.train)
    v = np.concatenate([m.velocity.ravel() for m in motions])
    v = v[np.abs(v) > _MOVING * np.abs(v).max()]
    rest = [sign * 0.0 for sign in (1.0, -1.0) if (sign * v > 0).any()]
    curves = [
        [law.friction(speeds, trained.p[: len(law.params)]) for speeds in (v, np.array(rest))]
        for law, trained in zip(laws, (simple, rich), strict=True)
    ]
    (ours, level), (theirs, other) = curves
    at_rest = float(np.max(np.abs(level - other), initial=0.0)) / float(np.mean(np.abs(theirs)))
    return max(_share(ours, theirs), at_rest)


def _balanced(solved: Balance) -> Array:
    """What a balance makes of friction, offset and the like, (rows,): no inertia."""
    system, p = solved.system, solved.values
    motions = [log.motion(log.places) for log in system.logs]
    frictions = [friction_signal(system.rig, system.law, log, p)(log.places) for log in system.logs]
    return np.concatenate([
        system.rig.force(system.law, p, m.v, np.zeros(len(m.v)), m.loads, friction)
        for m, friction in zip(motions, frictions, strict=True)
    ])  # fmt: skip


def _share(ours: Array, theirs: Array) -> float:
    size = float(np.mean(np.abs(theirs)))
    greatest = float(np.quantile(np.abs(ours - theirs), 1 - _ODD))
    return greatest / size if size > 0 else float("inf" if greatest > 0 else 0.0)
