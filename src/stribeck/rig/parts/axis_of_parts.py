"""The row of constants of an axis that parts make."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..motion.axis_row import axis_row
from ..motion.drives import AxisConstants
from .part import Part
from .transmissions import ratio


def motor_turns(parts: Iterable[Part], *, rotary: bool) -> bool:
    """Whether the motor of an axis turns: of any rotary one, and in front of a screw."""
    return rotary or any(p.role == "transmission" and p.name == "screw" for p in parts)


def in_units(parts: Iterable[Part], *, rotary: bool) -> tuple[Part, ...]:
    """The parts of an axis with the units that their coefficients have there."""
    parts = tuple(parts)
    turning = motor_turns(parts, rotary=rotary)
    return tuple(p.on(rotary=rotary, turning=turning) for p in parts)


def completed(parts: Iterable[Part], values: Mapping[str, Any]) -> dict[str, Any]:
    """The values of the parts' coefficients, idle ones where nobody states them, and the ratio."""
    # A drive's chain has constants of its own, as a lead, which are no coefficients of a part.
    own = {c.name: values.get(c.name, c.idle) for p in parts for c in p.coefficients}
    return {**own, "ratio": ratio(own)}


def contributions(values: Mapping[str, Any], parts: Iterable[Part]) -> dict[str, Any]:
    """What parts make of the fields of `AxisConstants`; what several have adds up."""
    fields: dict[str, Any] = {}
    for part in parts:
        for name, value in part.terms(values).items():
            fields[name] = fields[name] + value if name in fields else value
    return fields


def assembled(parts: Iterable[Part], values: Mapping[str, Any], **fields: Any) -> tuple[Any, ...]:
    """The row of constants of an axis; see `motion.axis_row`.

    Args:
        parts: What it is made of.
        values: Of their coefficients by name: floats, arrays (n,), or symbols of another language.
        fields: Of `AxisConstants`, in place of those that the parts make.
    """
    parts = tuple(parts)
    return mass_row(parts, completed(parts, values), **fields)


def mass_row(parts: Sequence[Part], values: Mapping[str, Any], **fields: Any) -> tuple[Any, ...]:
    """The row of constants of some parts of an axis, as `assembled` makes that of all.

    Args:
        parts: Those that act on one of its masses.
        values: Of the whole axis, as `completed` makes them: the gear is none of these parts.
        fields: As of `assembled`.
    """
    stages = (part.stage(values) for part in parts)
    constants = AxisConstants(**{**contributions(values, parts), **fields})
    return axis_row(constants, [stage for stage in stages if stage is not None])
