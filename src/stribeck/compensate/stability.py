"""Steady sliding under a compensator: the eigenvalues of the loop about a speed.

The loop is linear about steady sliding: a mass on the controller's damping and stiffness, with the
slope of friction over speed as a damper, or as what undoes one where friction falls. From sample
to sample it maps (x, v) and what the controller keeps to the next of these; sliding is stable
where the greatest eigenvalue of this map lies within the unit circle. A compensator with feedback
adds scale times the model's slope at the measured velocity, a difference of two positions, held
for a sample.

That tells of small disturbances alone. Beside stable sliding there may be a limit cycle, into
which a kick, a start or a reversal throws the axis: simulated motions show these (`limit_cycle`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import expm

if TYPE_CHECKING:
    from ..friction import Law
    from ..rig.controller import LinearLoop
    from ..space import Array

#: Up to which scale the edge of stability is looked for, and how near it is told.
_MOST, _NEAR = 3.0, 1e-3
#: Share of a speed over which the slope of friction is taken.
_SPAN = 1e-3
#: Rows of the state.
_X, _V, _LAST_X, _LATE = range(4)


@dataclass(frozen=True)
class Sliding:
    """Steady sliding at a speed.

    Args:
        speed: m/s or rad/s, with the direction as its sign.
        slope: Of friction over speed, N s/m or N m s/rad; below 0 where it falls.
        damping: Of loop and friction together, the same.
        stable: Whether it is without compensation.
        edge: The scale at which feedback makes it unstable (where it is stable without) or stable
            (where it is not); None where no scale up to 3 does.
    """

    speed: float
    slope: float
    damping: float
    stable: bool
    edge: float | None


def sliding(loop: LinearLoop, law: Law, p: Array, speed: float, h: float) -> Sliding:
    """Steady sliding of an axis whose compensator believes its own law.

    Args:
        loop: The loop without friction.
        law: Friction.
        p: Its parameters, (k,).
        speed: m/s or rad/s, signed.
        h: Sample time, s.
    """
    around = speed * np.array([1.0 - _SPAN, 1.0 + _SPAN])
    slope = float(np.diff(law.friction(around, p))[0] / (2.0 * _SPAN * speed))
    step = flow(loop, slope, h)
    stable = radius(loop, step, 0.0, h) <= 1.0
    low, high = 0.0, _MOST
    if (radius(loop, step, slope * high, h) <= 1.0) == stable:
        edge = None
    else:
        while high - low > _NEAR:
            middle = 0.5 * (low + high)
            same = (radius(loop, step, slope * middle, h) <= 1.0) == stable
            low, high = (middle, high) if same else (low, middle)
        edge = high
    return Sliding(speed, slope, loop.damping + slope, stable, edge)


def flow(loop: LinearLoop, slope: float, h: float) -> Array:
    """How position, velocity and a force that is held go on to the next sample, (3, 3).

    Args:
        loop: The loop without friction.
        slope: Of friction over speed.
        h: Sample time, s.
    """
    held = loop.hold > 0
    damping = slope if held else slope + loop.damping
    stiffness = 0.0 if held else loop.stiffness
    rates = np.zeros((3, 3))
    rates[0, 1] = 1.0
    rates[1] = np.array([-stiffness, -damping, 1.0]) / loop.mass
    step: Array = expm(rates * h)
    return step


def radius(loop: LinearLoop, step: Array, added: float, h: float) -> float:
    """The greatest eigenvalue from sample to sample, as a magnitude.

    Args:
        loop: The loop without friction.
        step: Its `flow`.
        added: Of the compensator's output over the measured velocity.
        h: Sample time, s.
    """
    force = np.zeros(4)  # what is held over the sample, of x, v, the last x and the late force
    force[_X], force[_LAST_X] = added / h, -added / h
    control = np.zeros(4)
    if loop.hold > 0:
        control[_X], control[_V] = -loop.stiffness, -loop.damping
        control += force
        force = np.eye(4)[_LATE] if loop.hold > 1 else control
    whole = np.zeros((4, 4))
    whole[:2, :2] = step[:2, :2]
    whole[:2] += np.outer(step[:2, 2], force)
    whole[_LAST_X, _X] = 1.0
    whole[_LATE] = control
    return float(np.abs(np.linalg.eigvals(whole)).max())
