"""The parts of which an axis is composed, each one declaration. A new one is its name here.

`controllers` ask `motors` for a demand, `transmissions` pass their force on to `loads`, among them
`ripple`, `sensors` read the position, with a `lead_error`; `part` is what all of them are,
`axis_of_parts` the row of constants by which an axis of them is stepped, `motion_equation` its
equation of motion.
"""

from collections.abc import Mapping
from types import MappingProxyType

from ...errors import InputError
from . import controllers, lead_error, loads, motors, ripple, sensors, transmissions
from .part import Coefficient, Part, Role

__all__ = ["PARTS", "Coefficient", "Part", "Role", "part_named"]

_DECLARED = (
    controllers.PD, controllers.DAMPED, controllers.CASCADE, controllers.PWM, controllers.NONE,
    motors.FORCE, motors.CURRENT, motors.VOLTAGE,
    transmissions.RIGID, transmissions.GEAR, transmissions.SCREW, transmissions.COMPLIANT,
    loads.MASS, loads.INERTIA, loads.PENDULUM, loads.SPRING,
    ripple.RIPPLE, ripple.MOTOR_RIPPLE,
    sensors.ENCODER, lead_error.LEAD_ERROR, sensors.MOTOR, sensors.LOAD,
)  # fmt: skip

#: Every part by role and name.
PARTS: Mapping[tuple[str, str], Part] = MappingProxyType({(p.role, p.name): p for p in _DECLARED})


def part_named(role: str, name: str) -> Part:
    """A part by its role and its name.

    Raises:
        InputError: there is no such part; those that there are, are told.
    """
    if (role, name) not in PARTS:
        names = ", ".join(p.name for p in _DECLARED if p.role == role)
        raise InputError(f"no {role} {name!r}: there are {names}")
    return PARTS[role, name]
