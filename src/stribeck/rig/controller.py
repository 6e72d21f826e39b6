"""The controller of a rig, in the loop that a compensator adds to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .motion.drives import SLIDE, AxisConstants, SlideConstants

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law
    from ..space import Array
    from .motion.track import Track


def per_newton(law: Law, p: Array) -> float:
    """The command per unit of force of a controller that commands a force."""
    del law, p
    return 1.0


class LinearLoop(NamedTuple):
    """A closed loop without friction, for small motions: mass, damping, stiffness, SI.

    Args:
        mass: kg or kg m^2.
        damping: N s/m or N m s/rad.
        stiffness: N/m or N m/rad.
        hold: 0 if the controller's force follows the axis at all times, 1 if it is held from
            sample to sample, 2 if it acts a sample late.
    """

    mass: float
    damping: float
    stiffness: float
    hold: int = 0

    @property
    def period(self) -> float:
        """Of its undamped swing, s; nothing where no stiffness pulls it back."""
        return 2 * np.pi * float(np.sqrt(self.mass / self.stiffness)) if self.stiffness > 0 else 0.0


@dataclass(frozen=True, eq=False)
class Controller:
    """A closed loop as the implicit stepper runs it, and where a compensator's output enters it.

    Args:
        drive: Kind of drive, of `motion.track`.
        entry: Which of the drive's inputs the compensator's output is added to.
        step: Longest step, s.
        tolerance: Way by which a step may be off, m or rad.
        track: The track of a recording's command, from rest at its start.
        constants: Constants of the drive, (n, constants), of a law, (n, k) parameter sets, SI, and
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

    def linear(self, law: Law, p: Array, track: Track) -> LinearLoop:
        """The loop of a (k,) parameter set, without friction, limits and gravity.

        A slide bed has the softer of its two directions.
        """
        row = self.constants(law, p[None], track)[0]
        if self.drive == SLIDE:
            bed = SlideConstants(*row[: len(SlideConstants._fields)])
            softer = min(bed.k_hat_plus + bed.k_spring_plus, bed.k_hat_minus + bed.k_spring_minus)
            return LinearLoop(bed.m + bed.inertia, bed.damping, softer)
        from .motion.drive_force import loop_gains  # noqa: PLC0415 - compiled code that others need not load

        axis = AxisConstants(*row[: len(AxisConstants._fields)])
        _, stiffness, damping = loop_gains(row)
        return LinearLoop(axis.M, damping, stiffness, int(axis.hold))
