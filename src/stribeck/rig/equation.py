"""The equation of motion of a rig: in words, and as a drive that a stepper knows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..constant import Constant


@dataclass(frozen=True)
class Input:
    """An input of an equation of motion.

    Args:
        name: As a simulator shows it.
        unit: SI; "" for a pure number.
        doc: Its meaning.
        place: Among the drive's inputs, of `motion.drives`.
        start: Its value before any is set.
        held: Whether it keeps its value until the next sample; else it is linear between samples.
    """

    name: str
    unit: str
    doc: str
    place: int
    start: float = 0.0
    held: bool = False


@dataclass(frozen=True, eq=False)
class Equation:
    """The motion of an axis under friction.

    Args:
        drive: Kind of drive, of `motion.track`.
        text: In words and signs.
        inputs: What drives the axis.
        constants: Names of the rig's constants that it reads.
        coefficients: The drive's constants in their order, of the rig's parameters and constants
            by name. Plain arithmetic: of floats, of arrays, or of symbols of another language.
        drive_doc: What the force of the drive is.
        own_step: Whether the rig's constant `step` is short enough for any law.
        friction: Which of the signs is friction, a clause.
        further: What it reads that a rig takes of each log and a simulator has to be told.
    """

    drive: int
    text: str
    inputs: tuple[Input, ...]
    constants: tuple[str, ...]
    coefficients: Callable[[Mapping[str, Any]], Sequence[Any]]
    drive_doc: str = "what the drive does to the axis"
    own_step: bool = False
    friction: str = "F_f is friction"
    further: tuple[Constant, ...] = ()
