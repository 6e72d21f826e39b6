"""An axis under a measured force below breakaway."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..constant import Constant, constant
from ..space import Array, Param
from .equation import FIRST, Equation, Input
from .experiments.offer import Course, Offer, OperatingRange
from .experiments.pushes import pushes
from .motion.drives import FORCE, ForceConstants
from .stepped import SteppedRig

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law
    from .motion.track import Track

#: Where a track has the force among its inputs, after normal load and temperature.
_FORCE = 2


@dataclass(frozen=True, eq=False)
class PreslidingRig(SteppedRig):
    """M dv/dt = F − offset − F_f; the measured force F is linear between samples.

    Bristles remember, so a motion is simulated from the start of its log; and what a first load
    has left behind shifts all that follows, so positions are compared up to a constant.
    """

    applied_force: bool = True
    history: bool = True
    floating: bool = True
    overtravel: float = 20.0

    kind: ClassVar[int] = FORCE
    held: ClassVar[tuple[bool, ...]] = (False,)

    def inputs(self, recording: Recording) -> tuple[Array, ...]:
        """The measured force."""
        force, known = self.needed_force(recording), recording.known_force
        return (force if known is None else force - known.values,)

    def with_constants(self, track: Track, recording: Recording) -> Track:
        """The track with the force as this rig's drive makes it."""
        track = super().with_constants(track, recording)
        if self.drive_chain is None:
            return track
        inputs = track.inputs.copy()
        inputs[_FORCE] = np.interp(track.t, recording.t, self.inputs(recording)[0])
        return track._replace(inputs=inputs)

    def coefficients(self, values: Mapping[str, Any]) -> ForceConstants:
        """Mass and offset."""
        return ForceConstants(values["M"], values["offset"])

    def experiments(self, axis: OperatingRange, seconds: float) -> Iterable[Offer]:
        """Sines of force below breakaway, and triangles just beyond it."""

        def travel(course: Course) -> float:
            track = self.course_track(course, axis.temperature)
            motion = self.move(axis.law, axis.p[None], track)
            return float(np.abs(motion.position - track.x0).max())

        return pushes(axis, travel, seconds)

    def equation(self, law: Law) -> Equation:
        """A mass under a force; F_f is friction."""
        del law
        return Equation(
            self.kind,
            "M a = force − offset − F_f",
            (Input("force", self.si_unit("force"), "of the drive on the axis", FIRST),),
            (),
            self.coefficients,
            own_step=True,
        )


_LAWS = ("lugre", "dahl", "elasto-plastic", "maxwell-slip", "gms")


def _tolerance(written: str) -> Constant:
    return constant("tolerance", 0.001, written, "way by which a step may be off", "docs/rigs.md")


_STEP = constant("step", 20.0, "ms", "longest step of the simulation", "docs/rigs.md")

PRESLIDING = PreslidingRig(
    name="presliding",
    doc="a linear axis under a measured force: ramps and sines below breakaway",
    cite="Newton's second law",
    scale="the measured force",
    constants=(_STEP, _tolerance("um")),
    params=(
        Param("M", 1e-3, 1e4, "kg", "M", True, doc="moving mass"),
        Param("offset", -100.0, 100.0, "N", "F_0", doc="constant force: weight, sensor offset"),
    ),
    laws=_LAWS,
    shows={"position": "um", "velocity": "mm/s"},
)

PRESLIDING_ROTARY = PreslidingRig(
    name="presliding-rotary",
    doc="a rotary axis under a measured torque: ramps and sines below breakaway",
    cite="Newton's second law",
    scale="the measured force",
    constants=(_STEP, _tolerance("urad")),
    params=(
        Param("M", 1e-5, 100.0, "kg", "J", True, doc="moment of inertia about the axis"),
        Param("offset", -10.0, 10.0, "N", "T_0", doc="constant torque: sensor offset"),
    ),
    laws=_LAWS,
    ranges={
        "sigma_0": (1.0, 1e7),
        "sigma_1": (0.0, 1e4),
        "F_S": (0.0, 100.0),
        "F_C": (0.0, 100.0),
        "F_V": (1e-3, 1e4),
        "v_s": (1e-4, 10.0),
        "W": (1e-3, 100.0),
        "d_1": (1e-7, 1e-2),
    },
    shows={"position": "mrad", "velocity": "mrad/s"},
    labels={"M": "J"},
    rotary=True,
)
