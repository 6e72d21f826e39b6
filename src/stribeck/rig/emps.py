"""EMPS: a ball-screw slide under cascade control, a benchmark with published reference models.

Its laws are found by force balance (the rig is `BalancedRig`); with its controller known, the whole
closed loop can be simulated too, which is how the report validates a model.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..constant import SMALLEST, Constant, constant
from ..data.filtering import Filtering
from ..errors import InputError
from ..space import Array, Param
from .balanced import BalancedRig
from .composition import POSITION, Block
from .controller import Controller
from .motion.axis_row import rows
from .motion.drives import (
    AXIS,
    CLOCKED,
    FEED_FORWARD,
    HELD,
    LATE,
    AxisInputs,
)
from .motion.track import Track
from .parts import part_named
from .parts.axis_of_parts import assembled
from .position_loop import goal_track
from .rig import Motion

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law

_REPORT = (
    "A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, "
    "Workshop on Nonlinear System Identification Benchmarks, Eindhoven 2019"
)

#: The parts of its loop: the amplifier's demand is a voltage, and its force gtau times that.
_CASCADE, _AMPLIFIER = part_named("controller", "cascade"), part_named("motor", "current")
_SLIDE = part_named("load", "mass")
#: Steps of the implicit stepper between two samples of the controller, and way by which one may
#: be off, m: finer ones move no velocity by more than 4e-9 m/s (tests/test_emps.py).
STEPS, TOLERANCE = 1, 1e-9

#: What is added to the voltage in the cross-test log, by its name there; V whatever the name says.
PULSES = "pulses_N"


@dataclass(frozen=True, eq=False)
class LoopMotion(Motion):
    """A simulated motion with its acceleration, which the report compares too.

    Args:
        acceleration: (n, N).
    """

    acceleration: Array


@dataclass(frozen=True, eq=False)
class Emps(BalancedRig):
    """The slide, its motor and its controller.

    At each sample k of its clock T the controller asks for the voltage

        u_k = clip(kv (kp (q_ref,k − q_k) − (q_k − q_k−2) / 2T), ±u_max) + pulses_k

    in which the velocity is a backward difference of the mean of two positions. The voltage is
    held for T from `delay` later on; force = gtau u, and M dv/dt = force − F_f − offset.
    """

    @property
    def composition(self) -> tuple[Block, ...]:
        """Its cascade, the motor whose voltage is logged, and the slide."""
        return (
            Block("controller", "cascade", "a loop of the position around one of the velocity",
                  "u = clip(kv (kp (command − q) − v), ±u_max)",
                  ("kp", "kv", "u_max", "T", "delay")),
            Block("motor", "voltage", "its force goes with the voltage, which the log has",
                  "F = gtau u", ("gtau",)),
            Block("load", "mass", "the slide on its ball screw", "M a = F − offset − F_f"),
            POSITION,
        )  # fmt: skip

    def measured(self, recording: Recording) -> Array:
        """The force of the drive, N: gtau times the voltage, or else its column."""
        if recording.voltage is not None:
            return self["gtau"] * recording.voltage
        return super().measured(recording)

    def simulate(self, law: Law, p: Array, recording: Recording) -> LoopMotion:
        """The closed loop under a recording's command, from the state in which the log starts.

        Args:
            law: Any friction law.
            p: (n, k) parameter sets: the law's parameters, then the rig's own.
            recording: Gives the command, the pulses if there were any, and the sample times.

        Raises:
            InputError: no command, or columns that are not this law's and rig's.
        """
        if not law.static:
            raise InputError(
                f"rig {self.name}: its loop is simulated with laws without states, loads and "
                f"terms, and {law.name} has some"
            )
        p = self.parameter_sets(law, p)
        if not 0 <= self["delay"] <= self["T"] or self["T"] <= 0:
            raise InputError(f"rig {self.name}: delay must lie between 0 and the controller's T")
        track = self._track(recording)
        mass, offset = self._mass_and_offset(law, p)
        clock = {"hold": CLOCKED, "T": self["T"], "difference": 1.0}
        cascade = self._loop(law, p, clock, start=track.given[0])
        from .motion.implicit import motions  # noqa: PLC0415 - compiled code that others need not load

        possible = (mass > 0.0) & np.isfinite(p).all(axis=1)  # the others stay nan
        q, v, F, a = np.full((4, len(p), len(track.t)), np.nan)
        q[possible], v[possible], F[possible] = motions(
            law, AXIS, p[possible, : len(law.params)], cascade[possible], track,
            self["T"] / STEPS, TOLERANCE,
        )  # fmt: skip
        for i in np.flatnonzero(possible):
            a[i] = self._acceleration(law, p[i], v[i], F[i] - offset[i])
        ticks, t = AxisInputs(*track.inputs).sampled > 0.0, recording.t - recording.t[0]
        x, speed, force, acceleration = (
            np.array([np.interp(t, track.t[ticks], row[ticks]) for row in part])
            for part in (q, v, F, a)
        )
        return LoopMotion(recording.t, x, speed, force, acceleration)

    def controller(self) -> Controller | None:
        """The cascade kv (kp (q_ref − q) − v) as position and velocity gains of a joint.

        Its velocity is the axis's own, not a difference.
        """
        if self.loop is not None:
            return super().controller()

        def constants(law: Law, p: Array, track: Track) -> Array:
            del track
            late = self["delay"] > 0.5 * self["T"]
            return self._loop(law, p, {"hold": LATE if late else HELD})

        track = partial(goal_track, with_velocity=False)
        return Controller(AXIS, FEED_FORWARD, self["T"], TOLERANCE, track, constants)

    def _loop(self, law: Law, p: Array, settings: Mapping[str, float], **fields: float) -> Array:
        """The constants of cascade, amplifier and slide, (n, constants)."""
        mass, offset = self._mass_and_offset(law, p)
        known = {
            "kp": self["kp"], "kv": self["kv"], "limit": self["u_max"], "k_t": self["gtau"],
            "M": mass, "offset": offset,
        }  # fmt: skip
        loop = assembled((_CASCADE, _AMPLIFIER, _SLIDE), {**known, **settings}, **fields)
        return rows(loop, len(p))

    @staticmethod
    def _mass_and_offset(law: Law, p: Array) -> tuple[Array, Array]:
        k = len(law.params)
        return p[:, k], np.zeros(len(p)) if law.directional else p[:, k + 1]

    def _track(self, recording: Recording) -> Track:
        """The loop's inputs and its start; given is the voltage in force before its first.

        The instants are the controller's samples and, where the delay is a part of T, those at
        which its voltage begins to act.
        """
        if recording.command is None:
            raise InputError(f"{recording.label}: rig {self.name} is simulated from a command")
        t, x, T, delay = recording.t - recording.t[0], recording.position, self["T"], self["delay"]
        # A hundredth of a tick more, because logs stamp their last sample with some jitter.
        ticks = T * np.arange(np.ceil(t[-1] / T - 0.01) + 1)
        instants = (0.0, delay) if 0.0 < delay < T else (0.0,)
        clock = np.add.outer(ticks, instants).ravel()[: len(instants) * (len(ticks) - 1) + 1]
        tick, place = np.divmod(np.arange(len(clock)), len(instants))
        pulses = recording.extra.get(PULSES, np.zeros(len(t)))
        nothing = np.zeros(len(clock))
        inputs = AxisInputs(
            normal=nothing,
            temperature=nothing,
            added=np.interp(ticks, t, pulses)[tick],
            goal=np.interp(ticks, t, recording.command)[tick],
            goal_velocity=nothing,
            feed_forward=nothing,
            enabled=nothing + 1.0,
            sampled=place == 0,
            late=(place == 0) & (delay > 0.0),
            external=nothing,
        )
        # The voltage in force before the controller's first, without pulses.
        volts_start = 0.0 if recording.voltage is None else recording.voltage[0] - pulses[0]
        return Track(
            clock, clock, clock, float(x[0]), clock, clock, np.zeros((3, 0)),
            v0=float((x[1] - x[0]) / (t[1] - t[0])), inputs=np.array(inputs, dtype=float),
            held=np.ones(len(inputs)), given=np.array([volts_start]),
        )  # fmt: skip

    def _acceleration(self, law: Law, p: Array, v: Array, net: Array) -> Array:
        """Acceleration under a net force, (N,): at rest friction balances it within its levels."""
        friction = np.where(v == 0.0, np.clip(net, *law.levels(p)), self.friction(law, p, v))
        acceleration: Array = (net - friction) / p[len(law.params)]
        return acceleration


def _constants() -> tuple[Constant, ...]:
    data = "DATA_EMPS.mat"
    return (
        constant(
            "kp", 160.18, "1/s", "gain of the position loop", data, "the paper", 0.0, least=0.0
        ),
        constant(
            "kv",
            243.45,
            "V s/m",
            "gain of the velocity loop",
            data,
            "the paper",
            0.0,
            least=0.0,
        ),
        constant(
            "gtau",
            35.15065188248547,
            "N/V",
            "force of the drive at a volt",
            data,
            "the paper",
            0.0,
            least=SMALLEST,
        ),
        constant(
            "u_max",
            10.0,
            "V",
            "saturation of the controller",
            "the report's simulation",
            least=SMALLEST,
        ),
        constant(
            "T",
            1.0,
            "ms",
            "clock of the controller, 1 kHz",
            "the report, section 2",
            least=SMALLEST,
        ),
        constant(
            "delay",
            1.0,
            "ms",
            "from sampling to the voltage acting, 0 to T",
            "the report's simulation; the logs themselves fit better with 0",
            least=0.0,
        ),
    )


_COLUMNS: dict[str, Any] = {
    "time": "t [s]",
    "position": "qm [m]",
    "command": "qg [m]",
    "voltage": "vir [V]",
    "force": {"column": "vir", "factor": "gtau", "unit": "N"},
}

EMPS = Emps(
    name="emps",
    doc="a ball-screw slide under cascade control, with published reference models",
    cite=_REPORT,
    constants=_constants(),
    params=(
        Param("M", 1.0, 1000.0, "kg", "M", doc="moving mass, the motor's inertia with it"),
        Param("offset", -100.0, 100.0, "N", "F_0", doc="constant force: amplifier offset"),
    ),
    laws=(
        "coulomb-viscous",
        "coulomb-viscous-directional",
        "stribeck",
        "stribeck-directional",
    ),
    ranges={
        "F_S": (0.0, 200.0),
        "F_C": (0.0, 200.0),
        "F": (0.0, 200.0),
        "F_V": (0.0, 5000.0),
        "v_SS": (1e-4, 0.1),
    },
    shows={"position": "mm", "velocity": "mm/s", "v_SS": "mm/s"},
    labels={"F_C": "F_c", "F_V": "F_v"},
    columns=_COLUMNS,
    filtering=Filtering(edge=(0.049, 0.0), reversals=True, accuracy=2),  # the report's
    scale="",
)
