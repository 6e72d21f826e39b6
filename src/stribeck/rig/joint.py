"""A joint under PD control with feed-forward and known gains, and gravity."""

from __future__ import annotations

from typing import Any

from .composed import ComposedRig, settings
from .parts import part_named

_COLUMNS: dict[str, Any] = {
    "time": "t_s [s]",
    "position": "q_rad [rad]",
    "velocity": "qd_rad_s [rad/s]",
    "command": "q_cmd_rad [rad]",
    "force": "tau_meas_Nm [N m]",
}

#: Where gains come from that everybody has to set.
_CHOICE = "a choice: set your own"
_PD = part_named("controller", "pd")
_INERTIA = part_named("load", "inertia")

JOINT_RIG = ComposedRig.compose(
    name="joint",
    rotary=True,
    doc="a robot joint under PD control with feed-forward and known gains, with gravity",
    cite="Newton's second law; the law of the controller as its log states it",
    parts=(
        _PD.with_coefficients(
            _PD["kp"].known(100.0, _CHOICE, "example", unit="N m/rad", doc="position gain"),
            _PD["kd"].known(5.0, _CHOICE, "example", unit="N m s/rad", doc="velocity gain"),
            _PD["gain"].known(1.0, "1: all of it", "standard"),
            _PD["limit"].known(1000.0, "beyond any", "standard", unit="N m",
                               doc="largest torque of the drive"),
            _PD["hold"].known(0.0, "the controller", "setting"),
        ),
        part_named("motor", "force"),
        part_named("transmission", "rigid"),
        _INERTIA.with_coefficients(
            _INERTIA["J"].searched(1e-4, 10.0),
            _INERTIA["g_sin"].searched(-20.0, 20.0),
            _INERTIA["g_cos"].searched(-20.0, 20.0),
            _INERTIA["g_0"].searched(-5.0, 5.0),
        ),
    ),
    constants=settings("mrad"),
    # Without a column of the command's velocity, that is the command's slope.
    input_columns={"goal_velocity": "qd_cmd_rad_s", "feed_forward": "tau_ff_Nm"},
    laws=(
        "stribeck",
        "stribeck-directional",
        "coulomb-viscous",
        "coulomb-viscous-directional",
    ),
    ranges={
        "F_S": (0.0, 10.0),
        "F_C": (0.0, 10.0),
        "F": (0.0, 10.0),
        "F_V": (0.0, 20.0),
        "v_SS": (1e-4, 1.0),
    },
    shows={"position": "mrad", "velocity": "rad/s"},
    columns=_COLUMNS,
)  # fmt: skip
