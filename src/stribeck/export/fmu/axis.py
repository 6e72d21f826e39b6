"""The axis of a co-simulation unit: what moves it, and each of its values with unit and start."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from ...constant import Constant
from ...errors import InputError
from ...rig.equation import Equation
from ...rig.motion.drives import NORMAL_LOAD, TEMPERATURE
from ...rig.two_masses import TwoMassRig
from ...space import Param
from ...units import convertible, unit
from ..model import Model, identifier
from .symbol import Symbol
from .unit_two_masses import OUT_FRICTION, RubbedSide

#: Longest step, s, and way by which a step may be off, m or rad, where a rig has none of its own.
_STEP, _TOLERANCE = 1e-3, 1e-7
#: Speeds between which a law may fall, m/s or rad/s, and a step that is short enough for any, s.
_SPEEDS, _SHORTEST = (1e-6, 10.0), 1e-6
#: Quantities of a rig that act at the start alone.
_AT_START = ("start",)
#: SI units of those in which constants are shown.
_SCALED = {"mm": "m", "um": "m", "ms": "s", "us": "s", "mrad": "rad", "deg": "rad"}


@dataclass(frozen=True)
class Value:
    """A variable of the unit, SI.

    Args:
        name: As a simulator shows it.
        role: What it is for.
        unit: SI, "" for a pure number.
        doc: Its meaning, and for an identified parameter how well it is known.
        start: None where it is calculated.
        low: Least value of its search range.
        high: Greatest.
        fixed: Whether it stays as it is at the start; held between steps, for an input.
        place: Of an input among the drive's.
        symbol: What the C calls it; "" where nothing there is made of it by name.
    """

    name: str
    role: Literal["output", "input", "setting", "law", "parameter"]
    unit: str
    doc: str
    start: float | None = None
    low: float | None = None
    high: float | None = None
    fixed: bool = False
    place: int = 0
    symbol: str = ""


@dataclass(frozen=True)
class Axis:
    """An axis as it is exported.

    Args:
        drive: What moves it, of `rig.motion.drives`.
        motion: Its equation of motion, in words and signs.
        friction: Which of the signs is friction.
        row: The drive's constants: numbers, symbols, and functions of parts.
        values: Outputs, inputs, settings, the law's parameters, the rig's; value references
            count them.
        sides: Of two masses, the friction of the motor and of the load.
    """

    drive: int
    motion: str
    friction: str
    row: Sequence[Any]
    values: tuple[Value, ...]
    sides: tuple[RubbedSide, RubbedSide] | None = None

    @property
    def parameters(self) -> int:
        """How many values there are from the first of its law's."""
        return len(self.values) - self.first("law")

    def of(self, *roles: str) -> list[Value]:
        """The values of some roles."""
        return [v for v in self.values if v.role in roles]

    def first(self, role: str) -> int:
        """Where the values of a role begin."""
        return next(i for i, v in enumerate(self.values) if v.role == role)


def axis(model: Model) -> Axis:
    """The axis of a model.

    Raises:
        InputError: its rig has no equation of motion that could be stepped.
    """
    equation = model.rig.equation(model.law)
    if equation is None:
        raise InputError(
            f"fmu: rig {model.rig.name} has no equation of motion that could be stepped"
        )
    values = [
        *_outputs(model, equation), *_inputs(model, equation), *_settings(model, equation),
        *_identified(model), *_constants(model, equation),
    ]  # fmt: skip
    used_names: set[str] = set()
    unique = []
    for v in values:
        name = v.name
        while name in used_names:
            name += "_"
        used_names.add(name)
        unique.append(replace(v, name=name))
    row = _coefficients(model, equation)
    return Axis(equation.drive, equation.text, equation.friction, row, tuple(unique), _sides(model))


def _sides(model: Model) -> tuple[RubbedSide, RubbedSide] | None:
    """The friction of the motor and of the load of an axis of two masses."""
    rig, law = model.rig, model.law
    if not isinstance(rig, TwoMassRig):
        return None
    if rig.friction_side == "motor":
        return RubbedSide(law, 0, OUT_FRICTION), RubbedSide(None)
    own = len(law.params) + len(rig.params)  # before those of the motor's law
    motor = RubbedSide(rig.law_of_motor(law), own, OUT_FRICTION + 1)
    return motor if motor.law else RubbedSide(None), RubbedSide(law, 0, OUT_FRICTION)


def _coefficients(model: Model, equation: Equation) -> Sequence[Any]:
    """The drive's row of constants, of the values of the unit as symbols."""
    params = model.parameters.every[len(model.law.params) :]
    further = (c.name for c in equation.further)
    names = [*(q.name for q in params), *equation.constants, *further]
    symbols = {name: Symbol(f"r[R_{identifier(name)}]") for name in names}
    return equation.coefficients(symbols)


def _outputs(model: Model, equation: Equation) -> Iterator[Value]:
    way = "rad" if model.rig.rotary else "m"
    of_load = " of the load" if isinstance(model.rig, TwoMassRig) else ""
    yield Value("position", "output", way, f"position{of_load}")
    yield Value("velocity", "output", model.speed_unit, f"velocity{of_load}")
    yield Value("drive", "output", model.force_unit, equation.drive_doc)
    rubs = "friction, with the sign of the velocity; at rest, of the pull that it balances"
    if not isinstance(model.rig, TwoMassRig):
        yield Value("friction", "output", model.force_unit, rubs)
        return
    yield Value("motor_position", "output", way, _position_of_motor(model.rig))
    yield Value("motor_velocity", "output", model.speed_unit, "velocity of the motor, at the load")
    yield Value("coupling", "output", model.force_unit, "of the spring, from the motor on the load")
    names = {"motor": ("friction_motor",), "load": ("friction",)}
    for name in names.get(model.rig.friction_side, ("friction", "friction_motor")):
        yield Value(name, "output", model.force_unit, rubs)


def _position_of_motor(rig: TwoMassRig) -> str:
    """What the position of the motor is, and what an encoder there shows of it."""
    words = "position of the motor, at the load"
    if rig.encoders == "motor":
        return f"{words}: what the encoder shows, and the rig calls its position"
    if rig.encoders == "both":
        return f"{words}; its encoder shows {rig.per_load:.10g} (motor_position + zero)"
    return words


def _inputs(model: Model, equation: Equation) -> Iterator[Value]:
    """What drives the axis, and what else its law reads."""
    for i in equation.inputs:
        yield Value(i.name, "input", i.unit, i.doc, i.start, fixed=i.held, place=i.place)
    places = {i.place for i in equation.inputs}
    laws = [model.law]
    if isinstance(model.rig, TwoMassRig) and (motor := model.rig.law_of_motor(model.law)):
        laws.append(motor)
    if any("normal" in law.loads for law in laws) and NORMAL_LOAD not in places:
        words = "normal load, as the law counts it"
        yield Value("normal_load", "input", "", words, 0.0, place=NORMAL_LOAD)
    if any("temperature" in law.terms for law in laws) and TEMPERATURE not in places:
        words = "temperature that friction depends on"
        yield Value("temperature", "input", "K", words, 293.15, place=TEMPERATURE)


def _settings(model: Model, equation: Equation) -> Iterator[Value]:
    """Where it starts, and how it is stepped: fixed when the simulation begins."""
    way = "rad" if model.rig.rotary else "m"
    of_load = " of the load" if isinstance(model.rig, TwoMassRig) else ""
    rig_has = {c.name: c.value for c in model.rig.constants}
    step = _longest(model, equation, rig_has.get("step", _STEP))
    for name, written, doc, start in (
        ("position_start", way, f"position{of_load} at the start", 0.0),
        ("velocity_start", model.speed_unit, f"velocity{of_load} at the start", 0.0),
        ("step", "s", "longest step inside a communication step", step),
        ("tolerance", way, "way by which such a step may be off",
         rig_has.get("tolerance", _TOLERANCE)),
    ):  # fmt: skip
        yield Value(name, "setting", written, doc, start, fixed=True)


def _longest(model: Model, equation: Equation, step: float) -> float:
    """The longest step, s, at which an axis breaks away when its law says so.

    A friction that falls with speed by more than mass over step hides from an implicit step that
    rest is not stable. A rig that was identified by such steps keeps its own; so does a law with
    states, which does not jump.
    """
    law, p = model.law, model.p
    if law.states or equation.own_step or not (law.static and law.sticks):
        return step
    names = (q.name for q in model.parameters.every[len(law.params) :])
    values = dict(zip(names, model.values[len(law.params) :].tolist(), strict=True))
    known = {c.name: c.value for c in model.rig.constants} | values
    mass = float(equation.coefficients(known)[0])
    v = np.geomspace(*_SPEEDS, 400)
    fall = max(float(np.max(-np.diff(s * law.friction(s * v, p)) / np.diff(v))) for s in (1, -1))
    return max(min(step, 0.5 * mass / fall), _SHORTEST) if fall > 0.0 and mass > 0.0 else step


def _identified(model: Model) -> Iterator[Value]:
    named = [name for name, _ in model.named()]
    every, k = model.parameters.every, len(model.law.params)
    labels = [*named, *(identifier(model.rig.label(q.name)) for q in every[k:])]
    for i, (name, q, value) in enumerate(zip(labels, every, model.values.tolist(), strict=True)):
        symbol = identifier(q.name)
        inside = q.lower <= value <= q.upper
        yield Value(
            name,
            "law" if i < k else "parameter",
            q.unit,
            known(model, q),
            value,
            q.lower if inside else None,
            q.upper if inside else None,
            fixed=i >= k and q.name in _AT_START,
            symbol="" if i < k else symbol,
        )


def known(model: Model, q: Param) -> str:
    """What a parameter means, its interval and the verdict on it."""
    entry = model.card.parameters.get(model.rig.label(q.name))
    text = q.doc or q.name
    if entry is None:
        return f"{text}; as the law has it"
    if entry.low is not None and entry.high is not None:
        low, high = (float(unit(entry.unit).to_si(x)) for x in (entry.low, entry.high))
        text += f"; 95 % interval {low:.6g} to {high:.6g}"
    return f"{text}; {entry.verdict_text}"


def _constants(model: Model, equation: Equation) -> Iterator[Value]:
    for c in model.rig.constants:
        if c.name in equation.constants and not math.isnan(c.value):
            yield _constant(c, f"{c.doc}; a constant of the rig")
    for c in equation.further:
        yield _constant(c, c.doc)


def _constant(c: Constant, doc: str) -> Value:
    name = identifier(c.name)
    fixed = c.name in _AT_START
    return Value(name, "parameter", si(c.unit), doc, c.value, fixed=fixed, symbol=name)


def si(written: str) -> str:
    """The SI unit of a quantity that is shown in another."""
    si_unit = re.sub(r"[A-Za-z]+", lambda word: _SCALED.get(word[0], word[0]), written)
    if not (convertible(si_unit, written) and unit(si_unit).factor == 1.0):
        raise InputError(f"fmu: {written!r} has no SI unit here")
    return si_unit
