"""The controller of a rig, in the loop that a compensator adds to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law
    from ..space import Array
    from .motion.track import Track


def per_newton(law: Law, p: Array) -> float:
    """The command per unit of force of a controller that commands a force."""
    del law, p
    return 1.0


@dataclass(frozen=True, eq=False)
class Controller:
    """A closed loop as the implicit stepper runs it, and where a compensator's output enters it.

    Args:
        drive: Kind of drive, of `motion.track`.
        entry: Which of the drive's inputs the compensator's output is added to.
        step: Longest step, s.
        tolerance: Way by which a step may be off, m or rad.
        track: The track of a recording's command, from rest at its start.
        constants: Constants of the drive, (n, WIDTH), of a law, (n, k) parameter sets, SI, and
            a track.
        command_per_force: The command for a unit of force or torque at the axis, of a law and a
            (k,) parameter set.
        friction: Coulomb friction of the drive, which takes its share of a command, N or N m.
    """

    drive: int
    entry: int
    step: float
    tolerance: float
    track: Callable[[Recording], Track]
    constants: Callable[[Law, Array, Track], Array]
    command_per_force: Callable[[Law, Array], float] = per_newton
    friction: float = 0.0
