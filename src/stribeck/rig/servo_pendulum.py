"""A pendulum on a position-controlled servo, with gravity, whose torque can be switched off."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..constant import constant
from ..errors import InputError
from ..space import Array, Param
from .equation import FIRST, SECOND, THIRD, Equation, Input
from .experiments.offer import Offer, OperatingRange
from .experiments.servo_goals import servo_goals
from .motion.drives import SERVO, ServoConstants
from .stepped import SteppedRig

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law

#: What a log may say of its own run, by the name of its column; the rig's constants elsewhere.
_OF_THE_RUN = {"mass": "m", "length": "l", "kp": "kp", "vin": "vin"}
#: The column that says whether the servo drives; it always does where a log has none.
_ENABLED = "torque_enable"


@dataclass(frozen=True, eq=False)
class ServoPendulum(SteppedRig):
    """J dw/dt = k_t V / R − k_t² w / R − m g l sin(q + q_offset) − F_f, J = m l² + armature.

    V = vin clip(duty kp (goal − q), ±1); while the torque is switched off, no current flows and
    the motor neither drives nor brakes. The load of a law is the motor's torque, with the voltage
    that its rotation induces, and the torque of gravity.
    """

    kind: ClassVar[int] = SERVO
    held: ClassVar[tuple[bool, ...]] = (False, True, True)
    entry: ClassVar[int | None] = THIRD
    run_columns: ClassVar[Mapping[str, str]] = _OF_THE_RUN

    def inputs(self, recording: Recording) -> tuple[Array, ...]:
        """Goal, whether the servo drives, and volts that are added to its own."""
        if recording.command is None:
            raise InputError(
                f"{recording.label}: rig {self.name} needs the goal of the servo: map a column to "
                "command"
            )
        n = len(recording)
        return recording.command, recording.extra.get(_ENABLED, np.ones(n)), np.zeros(n)

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse a run without mass, length, gain or voltage."""
        for name in _OF_THE_RUN.values():
            if not 0 < values[name] < np.inf:
                raise InputError(f"rig {self.name}: {name} = {values[name]} cannot be simulated")

    def coefficients(self, values: Mapping[str, Any]) -> ServoConstants:
        """The constants of its servo and of gravity."""
        k_t, R = values["k_t"], values["R"]
        return ServoConstants(
            J=values["m"] * values["l"] ** 2 + values["armature"],
            per_volt=k_t / R,
            damping=k_t**2 / R,
            weight=values["m"] * values["g"] * values["l"],
            q_offset=values["q_offset"],
            stiffness=values["vin"] * values["kp"] * values["duty"],
            volts_max=values["vin"],
        )

    def experiments(self, axis: OperatingRange, seconds: float) -> Iterable[Offer]:
        """Sines, a chirp, other gains, a dropped and a heavier pendulum."""
        run = self.run_constants(axis.logs[0]).tolist()
        return servo_goals(axis, dict(zip(self.run_columns, run, strict=True)), self["g"], seconds)

    def command_per_force(self, law: Law, p: Array) -> float:
        """Volts for a newton metre, R / k_t."""
        k_t, R = p[len(law.params) : len(law.params) + 2]
        return float(R / k_t)

    def equation(self, law: Law) -> Equation:
        """The pendulum and its servo; F_f is friction."""
        del law
        return Equation(
            self.kind,
            "(m l² + armature) a = torque_on (k_t V/R − k_t² v/R) − m g l sin(q + q_offset) "
            "− F_f, V = clip(vin duty kp (goal − q) + added_voltage, vin)",
            (
                Input("goal", "rad", "goal of the servo", FIRST),
                Input("torque_on", "", "above 0.5: the servo drives", SECOND, 1.0, held=True),
                Input("added_voltage", "V", "added to the servo's voltage", THIRD, held=True),
            ),
            ("m", "l", "kp", "vin", "duty", "g"),
            self.coefficients,
            own_step=True,
        )


_BAM = "M. Duclusaud et al., Extended Friction Models (2025), arXiv 2410.08650; Rhoban/bam"
_LOG = "the log, where it says so, else BAM's pendulum"
_COLUMNS: dict[str, Any] = {
    "time": "timestamp [s]",
    "position": "position [rad]",
    "velocity": "speed [rad/s]",
    "command": "goal_position [rad]",
    "voltage": "input_volts [V]",
    "temperature": "temp [degC]",
}

SERVO_PENDULUM = ServoPendulum(
    name="servo-pendulum",
    doc="a pendulum on a position-controlled servo whose torque can be switched off",
    cite=_BAM,
    constants=(
        constant("m", 0.49, "kg", "mass at the end of the pendulum", _LOG, "the paper"),
        constant("l", 0.1, "m", "its distance from the shaft", _LOG, "the paper"),
        constant("kp", 400.0, "", "gain of the servo, in its own counts", _LOG, "the paper"),
        constant("vin", 7.4, "V", "supply voltage", _LOG, "the paper"),
        constant("duty", 4096 / (2 * np.pi) / (256 * 885), "1/rad",
                 "share of the supply voltage for an error of 1 rad at kp = 1", _BAM, "the paper"),
        constant("g", 9.80665, "m/s**2", "gravity", "standard value", "standard"),
        constant("step", 20.0, "ms", "longest step of the simulation", "docs/rigs.md"),
        constant("tolerance", 0.001, "mrad", "way by which a step may be off", "docs/rigs.md"),
    ),
    params=(
        Param("k_t", 0.1, 1.0, "N m/A", "k_t", True, doc="torque constant"),
        Param("R", 1.0, 20.0, "ohm", "R", True, doc="resistance of the winding"),
        Param("armature", 1e-4, 1e-2, "kg m**2", "J_a", True, doc="inertia of rotor and gears"),
        Param("q_offset", -0.1, 0.1, "rad", "q_0", doc="minus the angle at which it hangs"),
    ),
    laws=("coulomb-viscous", "stribeck", "stribeck-free", *(f"bam-m{i}" for i in range(1, 7))),
    ranges={
        "F_S": (0.0, 0.1),
        "F_C": (0.0, 0.05),
        "F_V": (0.0, 0.05),
        "v_SS": (0.1, 10.0),
        "K_c": (0.0, 0.05),
        "K_v": (0.0, 0.05),
        "K_cs": (0.0, 0.05),
        "w_s": (0.1, 10.0),
        "alpha": (0.5, 10.0),
        **dict.fromkeys(("K_l", "K_ls", "K_m", "K_e", "K_ms", "K_es"), (0.0, 0.6)),
        **dict.fromkeys(("K_mq", "K_eq"), (0.0, 1.0)),
    },
    shows={"position": "mrad", "velocity": "rad/s", "q_offset": "mrad"},
    columns=_COLUMNS,
    rotary=True,
)  # fmt: skip
