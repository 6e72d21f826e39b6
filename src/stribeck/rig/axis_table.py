"""An axis that a user composes of parts, as a table: of a TOML file, or of a card."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from ..constant import Origin, quantity
from ..errors import InputError
from ..friction import LAWS, law_named
from ..units import convertible, unit
from .composed import INPUT_COLUMNS, ComposedRig, read_inputs, settings
from .parts import Coefficient, Part, part_named
from .parts.axis_of_parts import in_units
from .search_ranges import with_ranges
from .two_masses import MOTOR_POSITION, READING, SIDES, TOLERANCE, TwoMassRig, two_masses

Finite = Annotated[float, Field(allow_inf_nan=False, strict=True)]
_Text = Annotated[str, Field(strict=True)]


class _Free(BaseModel):
    """A coefficient that is to be identified, within a range."""

    model_config = ConfigDict(extra="forbid")

    free: tuple[Finite, Finite]


class _Column(BaseModel):
    """A coefficient that logs state themselves, and its value in those that do not."""

    model_config = ConfigDict(extra="forbid")

    column: _Text
    value: Finite


class _Friction(BaseModel):
    """Where an axis of two masses has its friction, and by which law on the motor's side."""

    model_config = ConfigDict(extra="forbid")

    side: Literal["load", "motor", "both"] = "load"
    motor: _Text = ""


_Value = Finite | _Text | _Free | _Column
_Role = dict[str, dict[str, _Value]]


class AxisTable(BaseModel):
    """The schema of an axis of parts; coefficients are in the units that `stribeck rigs` shows."""

    model_config = ConfigDict(extra="forbid")

    name: str | None = None
    doc: str | None = None
    law: str | None = None
    rotary: Annotated[bool, Field(strict=True)] = False
    controller: _Role = {"none": {}}
    motor: _Role = {"force": {}}
    transmission: _Role = {"rigid": {}}
    load: _Role
    sensor: _Role = {}
    friction: _Friction | None = None
    inputs: dict[str, str] = {}
    ranges: dict[str, tuple[Finite, Finite]] = {}
    shows: dict[str, str] = {}
    columns: dict[str, Any] = {}
    drive: dict[str, Any] | None = None
    step: Finite | None = None
    tolerance: Finite | None = None


#: What an axis is made of, in the order in which power flows.
ROLES = ("controller", "motor", "transmission", "load", "sensor")


def composed_axis(table: Mapping[str, Any], name: str) -> ComposedRig:
    """The rig of an axis table.

    Args:
        table: As `AxisTable` has it.
        name: What the rig is called where the table does not say.

    Raises:
        pydantic.ValidationError: a word or a value that an axis has not.
        InputError: a part or a coefficient that there is not, or parts that make no axis.
    """
    content = AxisTable.model_validate(table)
    columns: dict[str, str] = {}
    named = [
        (part_named(role, name), stated)
        for role in ROLES
        for name, stated in getattr(content, role).items()
    ]
    units = in_units([part for part, _ in named], rotary=content.rotary)
    parts = [_part(part, stated, columns) for part, (_, stated) in zip(units, named, strict=True)]
    kind, sides = _masses(content, parts)
    _check_columns(content, parts, columns)
    inputs = {**INPUT_COLUMNS, **content.inputs}
    if MOTOR_POSITION in inputs:
        sides["motor_column"] = inputs.pop(MOTOR_POSITION)
    laws = tuple(dict.fromkeys((content.law or "coulomb-viscous", "stribeck", "coulomb-viscous")))
    law_named(laws[0])  # says which there are
    shown = {"position": "mrad", "velocity": "rad/s"}
    if not content.rotary:
        shown = {"position": "mm", "velocity": "mm/s"}
    states = any(law_named(law).states for law in (laws[0], sides.get("motor_law")) if law)
    rough = (TOLERANCE, "docs/parts.md") if kind is TwoMassRig and not states else ()
    simulation = settings("mrad" if content.rotary else "um", *rough)
    for word, setting in zip((content.step, content.tolerance), simulation, strict=True):
        if word is not None and not word > 0:
            raise InputError(f"{setting.name}: {word:g}: it must be above zero")
    stepped = tuple(
        setting if word is None else setting.with_value(word)
        for word, setting in zip((content.step, content.tolerance), simulation, strict=True)
    )
    rig = kind.compose(
        name if content.name is None else content.name,
        parts,
        rotary=content.rotary,
        doc=content.doc or f"an axis of parts: {', '.join(f'{p.role} {p.name}' for p in parts)}",
        cite="its parts",
        laws=laws,
        constants=stepped,
        run_columns=columns,
        input_columns=inputs,
        shows={**shown, **content.shows},
        columns=content.columns,
        bounded=frozenset(c.name for p in parts for c in p.coefficients if c.free),
        table=dict(table),
        **sides,
        **_memory(states, parts),
    )
    rig.check({c.name: c.value for c in rig.constants})
    _check_shown(rig, content.shows)
    return with_ranges(rig, content.ranges)


def _check_columns(content: AxisTable, parts: list[Part], columns: Mapping[str, str]) -> None:
    """Refuse inputs that there are not or that nothing reads, and one column for two things.

    Args:
        content: The table.
        parts: Its parts.
        columns: Coefficients that logs state, by column.
    """
    both = {p.name for p in parts if p.role == "sensor"} >= {*SIDES}
    reads = (*read_inputs(parts), *([MOTOR_POSITION] if two_masses(parts) and both else []))
    needs = {
        "goal_velocity": "a controller that takes the command's velocity",
        "feed_forward": "a controller",
        MOTOR_POSITION: "[transmission.compliant], [sensor.motor] and [sensor.load]",
    }
    for name in content.inputs:
        if name not in (*INPUT_COLUMNS, *needs):
            raise InputError(f"inputs: no input {name!r}: there are {', '.join(reads)}")
        if name not in reads:
            needed = needs[name]
            raise InputError(f"inputs.{name}: nothing of this axis reads it: it takes {needed}")
    owners: dict[str, str] = {}
    for channel, entry in content.columns.items():
        head = entry.get("column") if isinstance(entry, dict) else entry
        if isinstance(head, str):
            owners[head] = channel
    unnamed = {n: column for n, column in INPUT_COLUMNS.items() if n not in content.inputs}
    pairs = [(f"inputs.{n}", column) for n, column in {**unnamed, **content.inputs}.items()]
    for name, column in [*pairs, *((n, column) for column, n in columns.items())]:
        if not column.strip() or not column.isprintable():
            raise InputError(f"{name}: {column!r} is no head of a column")
        if other := owners.get(column):
            raise InputError(f"{name}: column {column!r} is that of {other} already")
        owners[column] = name


def _check_shown(rig: ComposedRig, shows: Mapping[str, str]) -> None:
    """Refuse units of what the axis does not have, or of another dimension."""
    if not shows:
        return
    laws = (law_named(law) for law in {*LAWS, *rig.laws})
    params = {q.name: q for law in laws for q in rig.parameters(law)}
    quantities = {
        "position": rig.si_unit("position"), "velocity": rig.si_unit("velocity"),
        "force": rig.si_unit("force"),
    }  # fmt: skip
    for name, written in shows.items():
        if name in quantities:
            ours = quantities[name]
        elif name in params:
            ours = params[name].unit
        else:
            named = [q.name for q in rig.parameters(law_named(rig.laws[0]))]
            raise InputError(
                f"shows.{name}: there is position, velocity, force and what is identified: "
                f"{', '.join(named)}"
            )
        if not convertible(written, ours):
            raise InputError(f"shows.{name}: {written!r} is not a unit of {ours}")


def _masses(content: AxisTable, parts: list[Part]) -> tuple[type[ComposedRig], dict[str, Any]]:
    """The kind of rig that parts make, and where an axis of two masses has its friction.

    Raises:
        InputError: one mass, and what two have; or the friction of another side is asked for.
    """
    if not two_masses(parts):
        if content.friction is not None:
            raise InputError(
                "friction: an axis of one mass has one side: [transmission.compliant] makes two"
            )
        if odd := [p.name for p in parts if p.role == "sensor" and p.name in SIDES]:
            raise InputError(
                f"sensor.{odd[0]}: an axis of one mass has one side: [transmission.compliant] "
                "makes two"
            )
        return ComposedRig, {}
    if any(p.slot == "way" for p in parts):
        raise InputError(
            "sensor.lead-error is of one mass: with [transmission.compliant] motor and load have "
            "positions of their own"
        )
    if {p.name for p in parts if p.role == "sensor"} & {*SIDES} == {"motor"}:
        _refuse_reading_of_two(content.sensor["motor"])
    motor = next(p for p in parts if p.role == "motor")
    if not motor.stated("armature"):
        raise InputError(
            f"motor.{motor.name}: with [transmission.compliant] the motor has an inertia of its "
            "own: state armature"
        )
    if not any(p.stated(c) for p in parts if p.role == "load" for c in p.inertia):
        raise InputError(
            "load: with [transmission.compliant] the load has an inertia of its own: it takes a "
            "load.mass, load.inertia or load.pendulum"
        )
    friction = content.friction or _Friction()
    if friction.motor:
        law_named(friction.motor)  # says which there are
        if friction.side != "both":
            raise InputError(
                "friction.motor: the motor's own law, beside the load's: side = \"both\""
            )
    return TwoMassRig, {"friction_side": friction.side, "motor_law": friction.motor}


def _refuse_reading_of_two(stated: Mapping[str, Any]) -> None:
    """Refuse what tells the readings of two encoders apart where there is one.

    Raises:
        InputError: it is stated.
    """
    if "per_load" in stated:
        raise InputError(
            "sensor.motor.per_load: it scales a second position, and without [sensor.load] there "
            'is one: leave it out and scale the column: [columns] position = { column = "HEAD", '
            "factor = NUMBER }"
        )
    if "zero" in stated:
        raise InputError(
            "sensor.motor.zero: it is between two encoders, and without [sensor.load] there is "
            "one: leave it out (a position and its command have the same zero)"
        )


def _memory(states: bool, parts: list[Part]) -> dict[str, Any]:
    """A law with states under a measured force alone remembers all that its log has seen."""
    remembers = states and not any(p.commanded for p in parts)
    return {"history": remembers, "floating": remembers}


def _part(part: Part, stated: Mapping[str, Any], columns: dict[str, str]) -> Part:
    """A part with what a table says of its coefficients; columns of logs go into `columns`."""
    place = f"{part.role}.{part.name}"
    return part.with_coefficients(
        *(_coefficient(part[key], value, place, columns) for key, value in stated.items())
    )


def _coefficient(
    c: Coefficient, value: float | str | _Free | _Column, place: str, columns: dict[str, str]
) -> Coefficient:
    """A coefficient as a table states it."""
    place = f"{place}.{c.name}"
    if isinstance(value, _Free):
        return _searched(c, value.free, place)
    if isinstance(value, _Column):
        if other := columns.get(value.column):
            raise InputError(f"{place}: column {value.column!r} is that of {other} already")
        if c.name in READING:
            raise InputError(f"{place}: no column of a log: give a number")
        columns[value.column] = c.name
        _check_value(c, value.value, place)
        return c.known(value.value, "the log, where it says so", "yours")
    if isinstance(value, str):
        number, tolerance, origin = _written(c, value, place)
        if c.setting and tolerance:
            raise InputError(f"{place} has no tolerance: give a number")
        _check_value(c, number, place)
        stated = c.known(number, "the axis file", origin)
        assert stated.constant is not None  # noqa: S101 - known just now
        return replace(stated, constant=stated.constant.with_value(number, tolerance, origin))
    _check_value(c, value, place)
    return c.known(value, "the axis file")


def _searched(c: Coefficient, ends: tuple[float, float], place: str) -> Coefficient:
    """A coefficient that is to be identified between two values."""
    low, high = ends
    if not low < high:
        raise InputError(f"{place}: free = [{low:g}, {high:g}]: the first is not below")
    if c.setting:
        raise InputError(f"{place} is a choice: no log identifies it; give a number")
    if fault := c.fault(low) or c.fault(high):
        raise InputError(f"{place}: free = [{low:g}, {high:g}]: it {fault}")
    return c.searched(low, high)


def _check_value(c: Coefficient, value: float, place: str) -> None:
    """Refuse a value that such a thing cannot have."""
    if fault := c.fault(value):
        raise InputError(f"{place} = {value:g} {fault}")


def _written(c: Coefficient, text: str, place: str) -> tuple[float, float, Origin]:
    """A value as text, its tolerance and origin, in the unit that the coefficient has."""
    stated = quantity(text, place)
    if stated.source:
        raise InputError(f"{place}: {text!r}: a comment behind # says where a value stands")
    factor = 1.0
    if stated.unit:
        try:
            fits = convertible(stated.unit, c.unit)
        except InputError as error:
            raise InputError(f"{place}: {text!r}: {error}") from error
        if not fits:
            written = f"it is in {c.unit}" if c.unit else f"it is a number alone: {c.doc}"
            raise InputError(f"{place}: {text!r}: {written}")
        factor = unit(stated.unit).factor / unit(c.unit).factor
    value, tolerance = factor * stated.value, factor * stated.tolerance
    if not np.isfinite(value) or not np.isfinite(tolerance):
        raise InputError(f"{place}: {text!r} is no finite number with a finite tolerance")
    return value, tolerance, stated.origin
