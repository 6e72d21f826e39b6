"""The parts of which an axis is composed, each one declaration. A new one is its name here."""

from collections.abc import Mapping
from types import MappingProxyType

from ...errors import InputError
from . import controller, load, motor, sensor, transmission
from .part import Coefficient, Part, Role

__all__ = ["PARTS", "Coefficient", "Part", "Role", "part_named"]

_DECLARED = (
    controller.PD, controller.CASCADE, controller.PWM, controller.NONE,
    motor.FORCE, motor.CURRENT, motor.VOLTAGE,
    transmission.RIGID, transmission.GEAR, transmission.SCREW,
    load.MASS, load.INERTIA, load.PENDULUM, load.SPRING,
    sensor.ENCODER,
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
