"""What an axis is composed of, for whoever draws it or says it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Block:
    """A part of an axis in a picture of it.

    Args:
        role: controller, motor, transmission, load or sensor.
        name: What it is called.
        doc: What it is, in a line.
        equation: What it contributes; empty where the equation of the whole says it.
        constants: Names of the rig's constants that are its own.
    """

    role: str
    name: str
    doc: str
    equation: str = ""
    constants: tuple[str, ...] = ()


#: The sensor of an axis whose parts name none.
POSITION = Block("sensor", "position", "the position as the log has it")
