"""A new axis of parts as a TOML file with comments, ready to be filled in."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import replace

from ..errors import InputError
from .axis_table import ROLES, composed_axis
from .composed import INPUT_COLUMNS, read_inputs
from .parts import Coefficient, Part
from .parts.axis_of_parts import in_units
from .two_masses import MOTOR_POSITION, READING, SIDES, two_masses

#: What the inputs of an axis are, beside its channels.
_INPUTS = {
    "goal_velocity": "the command's velocity",
    "feed_forward": "added to what the controller asks for",
    "enabled": "above 0.5 while the motor drives",
    "external": "a known force on the load",
}
_WIDTH = 46
#: Least inertia that is searched for of a motor that moves apart from its load, kg or kg m**2.
_LEAST_ROTOR = 1e-6
#: What is to be said of the friction of an axis of two masses.
_SIDES = (
    'side = "load"                                 # or "motor", or "both"',
    '# motor = "coulomb-viscous"                   # its own law, where both have friction',
)
#: What else, where no encoder is said.
_ENCODERS = (
    "# An encoder at the motor, beside that of the load:",
    "# [sensor.motor]",
    "# [sensor.load]",
)


def axis_draft(parts: Sequence[Part], *, rotary: bool) -> str:
    """The text of a file that composes an axis of parts.

    What an axis cannot do without is to be identified within the range that its part declares;
    the rest stands commented out at the value that it has where nobody speaks of it, or as NUMBER
    where each log tells it then.

    Raises:
        InputError: parts that make no axis.
    """
    parts = tuple(_needed(p, parts) for p in in_units(parts, rotary=rotary))
    names = [f"{p.role}.{p.name}" for p in parts]
    if twice := [name for name in names if names.count(name) > 1]:
        raise InputError(f"{twice[0]}: an axis file has each part once")
    lines = [
        "# An axis of parts. A coefficient is a number (exact), text with a tolerance such as",
        '# "12±4" or "12 nameplate", { free = [low, high] } to be identified within a range, or',
        '# { column = "HEAD", value = 1.0 } where logs state it themselves, each for its own run.',
        f"rotary = {str(rotary).lower()}",
        'law = "coulomb-viscous"',
        "# ranges = { F_C = [0, 10] }  # search ranges of the law's parameters",
    ]
    for role in ROLES:
        for part in parts:
            if part.role == role:
                lines += ["", *_part(part)]
    if two_masses(parts):
        read = {p.name for p in parts if p.role == "sensor"} & {*SIDES}
        lines += ["", "[friction]", *_SIDES, *(() if read else _ENCODERS)]
    lines += ["", "# Columns of the logs that say more than the channels do.", "[inputs]"]
    lines += [
        f'# {n} = "{INPUT_COLUMNS[n]}"  # {words}'
        for n, words in _INPUTS.items()
        if n in read_inputs(parts)
    ]
    if two_masses(parts):
        lines.append(f'# {MOTOR_POSITION} = "{MOTOR_POSITION}"  # where both sides have an encoder')
    lines += [
        "",
        "[columns]",
        '# position = "actual [rad]"' if rotary else '# position = "actual [mm]"',
    ]
    text = "\n".join(lines) + "\n"
    composed_axis(tomllib.loads(text), "axis")
    return text


def _needed(part: Part, parts: Sequence[Part]) -> Part:
    """A part as it stands among others: with what two masses need, without what one encoder has."""
    if not two_masses(parts):
        return part
    both = {p.name for p in parts if p.role == "sensor"} >= {*SIDES}
    coefficients = [c for c in part.coefficients if both or c.name not in READING]
    if part.role == "motor":
        coefficients = [
            replace(c, idle=None, lower=_LEAST_ROTOR) if c.name == "armature" else c
            for c in coefficients
            if c.name != "F_fm"  # is a law's, of two masses
        ]
    return replace(part, coefficients=tuple(coefficients))


def _part(part: Part) -> Iterable[str]:
    """The table of a part: what it is, its equation, and its coefficients."""
    yield f"[{part.role}.{part.name}]  # {part.doc}"
    yield f"# {part.contribution}"
    for c in part.coefficients:
        stated = f"{c.name} = {_value(c)}"
        words = f"{c.doc}{f', in {c.unit}' if c.unit else ''}"
        yield (
            f"{stated:<{_WIDTH}}# {words}"
            if c.idle is None
            else f"# {stated:<{_WIDTH - 2}}# {words}"
        )


def _value(c: Coefficient) -> str:
    """A coefficient as TOML takes it."""
    if c.idle is None:
        return f"{{ free = [{c.lower:g}, {c.upper:g}] }}"
    if math.isnan(c.idle):  # each log tells
        return "NUMBER"
    return f"{c.idle:g}" if math.isfinite(c.idle) else "1e9"
