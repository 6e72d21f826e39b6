"""A joint under PD control with feed-forward and known gains, and gravity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..constant import constant
from ..errors import InputError
from ..space import Array, Param
from .equation import FIRST, SECOND, THIRD, Equation, Input
from .motion.drives import JOINT, JointConstants, JointInputs
from .stepped import SteppedRig

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law
    from .motion.track import Track

#: Columns of a log that say the command's velocity and the feed-forward torque, if it has them.
_RATE, _AHEAD = "qd_cmd_rad_s", "tau_ff_Nm"
_HOLDS = (0.0, 1.0, 2.0)


@dataclass(frozen=True, eq=False)
class JointRig(SteppedRig):
    """J dw/dt = ff + gain (k_p (q_c − q) + k_d (w_c − w)) − g_sin sin q − g_cos cos q − g_0 − F_f.

    The torque of the drive is limited to +-limit. Without a column of the command's velocity,
    w_c is the command's slope; without a feed-forward column, ff is zero.

    A controller that runs as slowly as it logs holds the torque that it has computed: with
    `hold` = 1 until the next sample, with `hold` = 2 from the next sample until the one after.
    """

    kind: ClassVar[int] = JOINT
    held: ClassVar[tuple[bool, ...]] = (False, False, False)
    entry: ClassVar[int | None] = THIRD

    def inputs(self, recording: Recording) -> tuple[Array, ...]:
        """Command, its velocity, and the feed-forward torque."""
        if recording.command is None:
            raise InputError(
                f"{recording.label}: rig {self.name} needs the commanded angle: map a column to "
                "command"
            )
        rate = recording.extra.get(_RATE)
        if rate is None:
            rate = np.gradient(recording.command, recording.t)
        return recording.command, rate, recording.extra.get(_AHEAD, np.zeros(len(recording)))

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse a limit of nothing, and ways to hold a torque that there are not."""
        if not values["limit"] > 0:
            raise InputError(f"rig {self.name}: limit must be above zero")
        if values["hold"] not in _HOLDS:
            raise InputError(
                f"rig {self.name}: hold = {values['hold']:g}: it is 0 for a torque that follows "
                "the axis at all times, 1 for one held for a sample, 2 for one that acts a sample "
                "late"
            )

    def coefficients(self, values: Mapping[str, Any]) -> JointConstants:
        """Inertia, the gains that act, gravity, the limit, and how the torque is held."""
        return JointConstants(
            J=values["J"],
            k_p=values["gain"] * values["kp"],
            k_d=values["gain"] * values["kd"],
            g_sin=values["g_sin"],
            g_cos=values["g_cos"],
            g_0=values["g_0"],
            limit=values["limit"],
            hold=values["hold"],
        )

    @property
    def holds_force(self) -> bool:
        """Whether the torque is held from sample to sample."""
        return self["hold"] > 0

    def resting(self, track: Track, instant: float, position: float) -> Array:
        """Angle, command, its velocity and feed-forward at an instant; see `SimulatedRig`."""
        if self.holds_force:
            late = int(self["hold"]) - 1  # samples from which a torque is computed to its start
            k = int(np.searchsorted(track.t, instant, side="right")) - 1 - late
            inputs = track.inputs[:, max(k, 0)]
        else:
            inputs = np.array([np.interp(instant, track.t, values) for values in track.inputs])
        wish = JointInputs(*inputs)
        return np.array([position, wish.goal, wish.velocity, wish.torque])

    def pull(self, law: Law, p: Array, resting: Array) -> Array:
        """Torque of the drive less that of gravity, at angles q; see `SimulatedRig`."""
        c = self.constants_of_drive(law, p[:, len(law.params) :], np.empty(0))
        joint = JointConstants(*(column[:, None] for column in c.T[: len(JointConstants._fields)]))
        q, goal, velocity, ahead = resting.T
        torque = ahead + joint.k_p * (goal - q) + joint.k_d * velocity
        gravity = joint.g_sin * np.sin(q) + joint.g_cos * np.cos(q) + joint.g_0
        pull: Array = np.clip(torque, -joint.limit, joint.limit) - gravity
        return pull

    def equation(self, law: Law) -> Equation:
        """The joint and its loop; F_f is friction."""
        del law
        return Equation(
            self.kind,
            "J a = clip(feed_forward + gain (kp (command − q) + kd (command_velocity − v)), "
            "limit) − g_sin sin q − g_cos cos q − g_0 − F_f",
            (
                Input("command", self.si_unit("position"), "commanded angle", FIRST),
                Input("command_velocity", self.si_unit("velocity"), "its velocity", SECOND),
                Input(
                    "feed_forward",
                    self.si_unit("force"),
                    "torque added to the controller's",
                    THIRD,
                ),
            ),
            ("kp", "kd", "gain", "limit", "hold"),
            self.coefficients,
            own_step=True,
        )


_COLUMNS: dict[str, Any] = {
    "time": "t_s [s]",
    "position": "q_rad [rad]",
    "velocity": "qd_rad_s [rad/s]",
    "command": "q_cmd_rad [rad]",
    "force": "tau_meas_Nm [N m]",
}

JOINT_RIG = JointRig(
    name="joint",
    doc="a robot joint under PD control with feed-forward and known gains, with gravity",
    cite="Newton's second law; the law of the controller as its log states it",
    constants=(
        constant("kp", 100.0, "N m/rad", "position gain", "a choice: set your own", "example"),
        constant("kd", 5.0, "N m s/rad", "velocity gain", "a choice: set your own", "example"),
        constant("gain", 1.0, "", "share of the feedback that acts", "1: all of it", "standard"),
        constant("limit", 1000.0, "N m", "largest torque of the drive", "beyond any", "standard"),
        constant(
            "hold",
            0.0,
            "",
            "1: torque held from sample to sample, 2: and a sample late",
            "the controller",
        ),
        constant("step", 20.0, "ms", "longest step of the simulation", "docs/rigs.md"),
        constant("tolerance", 0.001, "mrad", "way by which a step may be off", "docs/rigs.md"),
    ),
    params=(
        Param("J", 1e-4, 10.0, "kg m**2", "J", True, doc="moment of inertia about the axis"),
        Param("g_sin", -20.0, 20.0, "N m", "g_s", doc="gravity that goes with sin q"),
        Param("g_cos", -20.0, 20.0, "N m", "g_c", doc="gravity that goes with cos q"),
        Param("g_0", -5.0, 5.0, "N m", "g_0", doc="constant torque: sensor offset, cables"),
    ),
    laws=(
        "stribeck",
        "stribeck-directional",
        "coulomb-viscous",
        "coulomb-viscous-directional",
    ),
    ranges={
        "F_S": (0.0, 10.0),
        "F_C": (0.0, 10.0),
        "F_V": (0.0, 20.0),
        "v_SS": (1e-4, 1.0),
    },
    shows={"position": "mrad", "velocity": "rad/s"},
    columns=_COLUMNS,
    rotary=True,
)
