"""Runs Structured Text by the rules of IEC 61131-3, so that tests need no controller.

The text is parsed by blark, whose grammar is TwinCAT's; this file walks blark's tree. It shares
nothing with what writes the text, and is stricter than a controller where tools differ: a
literal without a type is a REAL, AND and OR look at both sides, DINT and LREAL do not mix, an
input is not assigned to, a loop's variable has no value after the loop, arrays have bounds,
integers overflow, and what a floating-point unit would trap is an error.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from blark import transform as tf
from blark.parse import parse_source_code

_DINT = 2**31
_RESERVED = frozenset(
    """
    if then elsif else end_if for to by do end_for while end_while repeat until of at on or and xor
    not mod exit return case function function_block end_function end_function_block program var
    var_input var_output var_in_out end_var constant array string bool int dint lint sint uint real
    lreal time date byte word dword lword true false type struct limit sel mux min max len left
    right mid concat insert delete replace find abs sqrt ln log exp sin cos tan asin acos atan add
    mul sub div expt move gt ge eq le lt ne shl shr rol ror trunc tp ton tof sr rs ctu ctd ctud with
    step action task interval priority configuration resource transition pointer reference ref
    """.split()  # noqa: SIM905 - a list of words is read as a text
)


class IecError(Exception):
    """What a compiler would refuse, or a controller would stop at."""


class _Return(Exception):  # noqa: N818 - no error: a RETURN
    pass


@dataclass
class _Declared:
    name: str
    type: str
    length: int | None
    initial: Any
    section: str


@dataclass
class _Unit:
    name: str
    block: bool
    variables: dict[str, _Declared]
    body: list[Any]


@dataclass
class _Frame:
    unit: _Unit
    values: dict[str, Any] = field(default_factory=dict)
    #: Variables that running loops count by: not to be assigned to.
    counting: set[str] = field(default_factory=set)


def parsed(text: str) -> tf.SourceCode:
    """The syntax tree of a text."""
    made = parse_source_code(text).transform()
    assert isinstance(made, tf.SourceCode)
    return made


@cache
def _items(text: str) -> tuple[Any, ...]:
    return tuple(parsed(text).items)


def _units(text: str) -> list[Any]:
    """The trees of all units: parsed one by one, as most are in many texts and parsing is slow."""
    found = re.split(r"(?<=^END_FUNCTION\n)|(?<=^END_FUNCTION_BLOCK\n)", text, flags=re.MULTILINE)
    return [item for unit in found for item in _items(unit)]


class Controller:
    """The units of a text, ready to be run.

    Args:
        text: Structured Text.
    """

    def __init__(self, text: str) -> None:
        self.units: dict[str, _Unit] = {}
        for item in _units(text):
            unit = _unit(item)
            if unit.name.lower() in self.units:
                raise IecError(f"{unit.name} is declared twice")
            self.units[unit.name.lower()] = unit
        for unit in self.units.values():
            for name in unit.variables:
                if name in self.units:
                    raise IecError(f"{unit.name}: {name} is a unit")

    def instance(self, name: str) -> Instance:
        """A new instance of a function block."""
        return Instance(self, self.units[name.lower()])

    def call(self, name: str, *given: Any) -> Any:
        """A function's value; arrays are lists."""
        unit = self.units[name.lower()]
        frame = self._frame(unit)
        places = [d for d in unit.variables.values() if d.section in ("input", "in_out")]
        for place, value in zip(places, given, strict=True):
            frame.values[place.name.lower()] = value
        return self._run(frame)

    def _frame(self, unit: _Unit) -> _Frame:
        frame = _Frame(unit)
        for key, declared in unit.variables.items():
            frame.values[key] = self._initial(declared)
        return frame

    def _initial(self, of: _Declared) -> Any:
        if of.type.lower() in self.units:
            return Instance(self, self.units[of.type.lower()])
        if of.length is not None:
            return [_ZERO[of.type]] * of.length
        if of.initial is None:
            return _ZERO[of.type]
        value = self._value(of.initial, _Frame(_Unit("", block=False, variables={}, body=[])))
        return _as(of.type, value)

    def _run(self, frame: _Frame) -> Any:
        with suppress(_Return):
            self._block(frame.unit.body, frame)
        return frame.values.get(frame.unit.name.lower())

    # --- statements

    def _block(self, body: Any, frame: _Frame) -> None:
        for statement in body.statements if isinstance(body, tf.StatementList) else body or ():
            self._statement(statement, frame)

    def _statement(self, of: Any, frame: _Frame) -> None:
        match of:
            case tf.AssignmentStatement(variables=[target], expression=expression):
                self._assign(target, self._value(expression, frame), frame)
            case tf.IfStatement():
                self._if(of, frame)
            case tf.ForStatement():
                self._for(of, frame)
            case tf.WhileStatement(expression=test, statements=body):
                while self._truth(test, frame):
                    self._block(body, frame)
            case tf.ReturnStatement():
                raise _Return
            case tf.FunctionCallStatement() | tf.FunctionCall():
                instance = self._look(of.name, frame)
                if not isinstance(instance, Instance):
                    raise IecError(f"{of.name} is no function block")
                instance.call_with(
                    {str(p.name.name): self._value(p.value, frame) for p in of.parameters}
                )
            case _:
                raise IecError(f"statement {type(of).__name__}")

    def _if(self, of: tf.IfStatement, frame: _Frame) -> None:
        if self._truth(of.if_expression, frame):
            self._block(of.statements, frame)
            return
        for other in of.else_ifs or ():
            if self._truth(other.if_expression, frame):
                self._block(other.statements, frame)
                return
        if of.else_clause is not None:
            self._block(of.else_clause.statements, frame)

    def _for(self, of: tf.ForStatement, frame: _Frame) -> None:
        name = str(of.control.name).lower()
        first, last = (_whole(self._value(e, frame)) for e in (of.from_, of.to))
        step = 1 if of.step is None else _whole(self._value(of.step, frame))
        if frame.unit.variables[name].type != "DINT":
            raise IecError(f"{name} is no DINT")
        frame.counting.add(name)
        for i in range(first, last + (1 if step > 0 else -1), step):
            frame.values[name] = i
            self._block(of.statements, frame)
        frame.counting.discard(name)
        frame.values[name] = None  # the standard does not say what it is now

    def _assign(self, target: Any, value: Any, frame: _Frame) -> None:
        name = _plain(target.name)
        declared = frame.unit.variables.get(name)
        if name == frame.unit.name.lower() and not frame.unit.block:
            frame.values[name] = _as("LREAL", value)
            return
        if declared is None:
            raise IecError(f"{frame.unit.name}: {name} is not declared")
        if declared.section == "input" or name in frame.counting:
            raise IecError(f"{frame.unit.name}: {name} is assigned to")
        if isinstance(target, tf.MultiElementVariable):
            array = frame.values[name]
            array[self._place(target, array, frame)] = _as(declared.type, value)
        else:
            if declared.length is not None:
                raise IecError(f"{frame.unit.name}: {name} is assigned to as a whole")
            frame.values[name] = _as(declared.type, value)

    # --- expressions

    def _truth(self, of: Any, frame: _Frame) -> bool:
        value = self._value(of, frame)
        if not isinstance(value, bool):
            raise IecError("a condition is no BOOL")
        return value

    def _value(self, of: Any, frame: _Frame) -> Any:  # noqa: PLR0911 - one case a line
        match of:
            case tf.ParenthesizedExpression(expr=inner):
                return self._value(inner, frame)
            case tf.Real(value=text, type_name=kind):
                value = float(str(text).replace("_", ""))
                return value if str(kind).upper() == "LREAL" else _single(value)
            case tf.Integer(value=text):
                return int(str(text).replace("_", ""))
            case tf.Boolean(value=text):
                return str(text).upper() == "TRUE"
            case tf.UnaryOperation(op=op, expr=inner):
                return _unary(str(op).upper(), self._value(inner, frame))
            case tf.BinaryOperation(left=left, op=op, right=right):
                return _binary(str(op).upper(), self._value(left, frame), self._value(right, frame))
            case tf.FunctionCall():
                return self._call(of, frame)
            case tf.SimpleVariable() | tf.MultiElementVariable():
                return self._look(of, frame)
        raise IecError(f"expression {type(of).__name__}")

    def _look(self, of: Any, frame: _Frame) -> Any:
        name = _plain(of if isinstance(of, tf.SimpleVariable) else of.name)
        if name not in frame.values:
            raise IecError(f"{frame.unit.name}: {name} is not declared")
        value = frame.values[name]
        if value is None:
            raise IecError(f"{frame.unit.name}: {name} has no value")
        if isinstance(of, tf.SimpleVariable):
            return value
        if isinstance(value, Instance):
            (selector,) = of.elements
            assert isinstance(selector, tf.FieldSelector)
            return value.output(_plain(selector.field))
        return value[self._place(of, value, frame)]

    def _place(self, of: Any, array: Any, frame: _Frame) -> int:
        (subscripts,) = of.elements
        (index,) = subscripts.subscripts
        at = _whole(self._value(index, frame))
        if not isinstance(array, list) or not 0 <= at < len(array):
            raise IecError(f"{frame.unit.name}: index {at}")
        return at

    def _call(self, of: tf.FunctionCall, frame: _Frame) -> Any:
        name = _plain(of.name)
        given = [self._value(p.value, frame) for p in of.parameters]
        if name in _STANDARD:
            return _finite(_STANDARD[name](*given))
        unit = self.units.get(name)
        if unit is None or unit.block:
            raise IecError(f"{frame.unit.name}: no function {name}")
        inner = self._frame(unit)
        places = [d for d in unit.variables.values() if d.section in ("input", "in_out")]
        names = [None if p.name is None else str(p.name.name).lower() for p in of.parameters]
        if len(given) > 1 and set(names) != {d.name.lower() for d in places}:
            raise IecError(f"{name} is given {names}")
        for i, (key, value) in enumerate(zip(names, given, strict=True)):
            place = places[i] if key is None else unit.variables[key]
            if place.length is not None:
                if not isinstance(value, list) or len(value) != place.length:
                    raise IecError(f"{name}: {place.name} is no array of {place.length}")
            else:
                value = _as(place.type, value)  # noqa: PLW2901 - checked
            inner.values[place.name.lower()] = value
        return self._run(inner)


class Instance:
    """An instance of a function block: it keeps what it was last given, and its variables."""

    def __init__(self, controller: Controller, unit: _Unit) -> None:
        if not unit.block:
            raise IecError(f"{unit.name} is no function block")
        self._controller, self._unit = controller, unit
        self._frame = controller._frame(unit)  # noqa: SLF001 - the same interpreter

    def __call__(self, **given: float | bool) -> None:
        self.call_with(given)

    def call_with(self, given: dict[str, Any]) -> None:
        """Set inputs and run the body once."""
        for name, value in given.items():
            declared = self._unit.variables.get(name.lower())
            if declared is None or declared.section != "input":
                raise IecError(f"{self._unit.name} has no input {name}")
            self._frame.values[name.lower()] = _as(declared.type, value)
        self._controller._run(self._frame)  # noqa: SLF001 - the same interpreter

    def output(self, name: str) -> Any:
        """What an output has."""
        declared = self._unit.variables.get(name.lower())
        if declared is None or declared.section != "output":
            raise IecError(f"{self._unit.name} has no output {name}")
        return self._frame.values[name.lower()]

    def write(self, name: str, value: float) -> None:
        """Retune a variable, as a person at a controller's watch window does."""
        if name.lower() not in self._unit.variables:
            raise IecError(f"{self._unit.name} has no {name}")
        self._frame.values[name.lower()] = value

    def initial(self, name: str) -> Any:
        """The value that a variable has now."""
        return self._frame.values[name.lower()]


# --- declarations

_SECTIONS = {
    tf.InputDeclarations: "input",
    tf.InputOutputDeclarations: "in_out",
    tf.OutputDeclarations: "output",
    tf.VariableDeclarations: "own",
    tf.FunctionVariableDeclarations: "own",
}


def _unit(of: Any) -> _Unit:
    if not isinstance(of, tf.Function | tf.FunctionBlock):
        raise IecError(f"{type(of).__name__} is no unit")
    name = _named(str(of.name))
    variables: dict[str, _Declared] = {}
    for section in of.declarations:
        for item in section.items:
            for variable in item.variables:
                made = _declared(
                    _named(str(variable.variable.name)), item, _SECTIONS[type(section)]
                )
                if made.name.lower() in {*variables, name.lower()}:
                    raise IecError(f"{name}: {made.name} is declared twice")
                variables[made.name.lower()] = made
    body = of.body.statements if of.body is not None else []
    return _Unit(name, isinstance(of, tf.FunctionBlock), variables, list(body))


def _declared(name: str, item: Any, section: str) -> _Declared:
    init = item.init
    if isinstance(item, tf.ArrayVariableInitDeclaration):
        (bounds,) = init.spec.subranges
        if int(str(bounds.start.value)) != 0:
            raise IecError(f"{name} is not counted from 0")
        kind = str(init.spec.type.type_name).upper()
        return _Declared(name, kind, int(str(bounds.stop.value)) + 1, None, section)
    return _Declared(name, str(init.spec.type), None, init.value, section)


def _named(name: str) -> str:
    if not re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name) or name.lower() in _RESERVED:
        raise IecError(f"{name} is no identifier")
    return name


def _plain(of: Any) -> str:
    while not isinstance(of, str):
        of = of.name
    return str(of).lower()


# --- values

_ZERO: dict[str, Any] = {"LREAL": 0.0, "DINT": 0, "BOOL": False}


def _as(kind: str, value: Any) -> Any:
    fits = {"LREAL": float, "DINT": int, "BOOL": bool}.get(kind)
    if fits is None or type(value) is not fits:
        raise IecError(f"{value!r} is no {kind}")
    return _finite(value)


def _finite(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        raise IecError("a floating-point exception")
    if type(value) is int and not -_DINT <= value < _DINT:
        raise IecError("an overflow")
    # No zero has a sign here: what relies on one gives another number.
    return 0.0 if isinstance(value, float) and value == 0.0 else value


def _single(value: float) -> float:
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def _whole(value: Any) -> int:
    if type(value) is not int:
        raise IecError(f"{value!r} is no DINT")
    return value


def _unary(op: str, value: Any) -> Any:
    if op == "NOT":
        return not _as("BOOL", value)
    if op != "-" or isinstance(value, bool):
        raise IecError(f"{op} {value!r}")
    return _finite(-value)


def _binary(op: str, a: Any, b: Any) -> Any:
    if type(a) is not type(b):
        raise IecError(f"{a!r} {op} {b!r}")
    if op in ("AND", "OR"):
        return (_as("BOOL", a) and b) if op == "AND" else (_as("BOOL", a) or b)
    if isinstance(a, bool):
        raise IecError(f"{a!r} {op} {b!r}")
    if op == "/" and b == 0:
        raise IecError("a division by 0")
    if op == "/" and isinstance(a, int):
        return _finite(abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1))
    return _finite(_OPERATIONS[op](a, b))


_OPERATIONS: dict[str, Callable[[Any, Any], Any]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
    "=": lambda a, b: a == b,
    "<>": lambda a, b: a != b,
}


def _expt(base: float, exponent: float) -> float:
    if base <= 0.0:  # a controller may go by the logarithm
        raise IecError("a floating-point exception")
    return float(base**exponent)


_STANDARD: dict[str, Callable[..., Any]] = {
    "abs": abs, "sqrt": math.sqrt, "exp": math.exp, "ln": math.log, "sin": math.sin,
    "cos": math.cos, "min": min, "max": max, "expt": _expt,
    "dint_to_lreal": lambda i: float(_whole(i)),
}  # fmt: skip
