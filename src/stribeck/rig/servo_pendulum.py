"""A pendulum on a position-controlled servo, with gravity, whose torque can be switched off."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .composed import ComposedRig, settings
from .experiments.offer import Offer, OperatingRange
from .experiments.servo_goals import servo_goals
from .parts import part_named


@dataclass(frozen=True, eq=False)
class ServoPendulum(ComposedRig):
    """J dw/dt = k_t V / R − k_t² w / R − m g l sin(q + q_offset) − F_f, J = m l² + armature.

    V = vin clip(duty kp (goal − q), ±1); while the torque is switched off, no current flows and
    the motor neither drives nor brakes. The load of a law is the motor's torque, with the voltage
    that its rotation induces, and the torque of gravity.
    """

    def experiments(self, axis: OperatingRange, seconds: float) -> Iterable[Offer]:
        """Sines, a chirp, other gains, a dropped and a heavier pendulum."""
        run = self.run_constants(axis.logs[0]).tolist()
        return servo_goals(axis, dict(zip(self.run_columns, run, strict=True)), self["g"], seconds)


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

_PWM, _VOLTAGE = part_named("controller", "pwm"), part_named("motor", "voltage")
_PENDULUM = part_named("load", "pendulum")

SERVO_PENDULUM = ServoPendulum.compose(
    name="servo-pendulum",
    rotary=True,
    doc="a pendulum on a position-controlled servo whose torque can be switched off",
    cite=_BAM,
    parts=(
        _PWM.with_coefficients(
            _PWM["kp"].known(400.0, _LOG, "the paper"),
            _PWM["vin"].known(7.4, _LOG, "the paper"),
            _PWM["duty"].known(
                4096 / (2 * np.pi) / (256 * 885), _BAM, "the paper",
                doc="share of the supply voltage for an error of 1 rad at kp = 1",
            ),
        ),
        _VOLTAGE.with_coefficients(
            _VOLTAGE["k_t"].searched(0.1, 1.0),
            _VOLTAGE["R"].searched(1.0, 20.0),
            _VOLTAGE["armature"].searched(1e-4, 1e-2),
        ),
        part_named("transmission", "rigid"),
        _PENDULUM.with_coefficients(
            _PENDULUM["m"].known(0.49, _LOG, "the paper", doc="mass at the end of the pendulum"),
            _PENDULUM["l"].known(0.1, _LOG, "the paper"),
            _PENDULUM["q_offset"].searched(-0.1, 0.1),
            _PENDULUM["g"].known(9.80665, "standard value", "standard"),
        ),
    ),
    constants=settings("mrad"),
    # What a log may say of its own run.
    run_columns={"mass": "m", "length": "l", "kp": "kp", "vin": "vin"},
    laws=("coulomb-viscous", "stribeck", "stribeck-free", *(f"bam-m{i}" for i in range(1, 7))),
    ranges={
        "F_S": (0.0, 0.1),
        "F_C": (0.0, 0.05),
        "F": (0.0, 0.1),
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
)  # fmt: skip
