"""Runs Structured Text by the rules of IEC 61131-3, so that tests need no controller.

Units are compiled to closures. Shares nothing with what writes the text, and is stricter than a
controller where tools differ: a literal without a type is a REAL, AND and OR evaluate both sides,
DINT and LREAL do not mix, an input is not assigned to, a loop's counter has no value after the
loop, arrays have bounds, integers overflow, and what a floating-point unit would trap is an error.
"""

from __future__ import annotations

import math
import operator
import sys
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from st_parser import (
    STANDARD,
    Assignment,
    Binary,
    Body,
    Call,
    Element,
    Expression,
    For,
    IecError,
    If,
    Name,
    Number,
    Output,
    Return,
    Statement,
    Truth,
    Unary,
    Unit,
    Variable,
    While,
    parsed,
)

_DINT = 2**31
_LARGEST = sys.float_info.max

#: Values of a unit's variables, by their places; a function's result is at place 0.
Frame = list[Any]
Evaluate = Callable[[Frame], Any]
#: Runs a statement: whether it was a RETURN.
Run = Callable[[Frame], bool]


class Controller:
    """The units of a text, ready to be run.

    Args:
        text: Structured Text.

    Raises:
        IecError: A compiler would refuse the text.
    """

    def __init__(self, text: str) -> None:
        trees = parsed(text)
        names = [tree.name.lower() for tree in trees]
        self.units: dict[str, _Unit] = {}
        for name, tree in zip(names, trees, strict=True):
            if name in self.units:
                raise IecError(f"{tree.name} is declared twice")
            for variable in tree.variables:
                if variable.name.lower() in names:
                    raise IecError(f"{tree.name}: {variable.name} is a unit")
            # What a unit calls stands before it: so none can call itself.
            self.units[name] = _Unit(tree, self.units)

    def instance(self, name: str) -> Instance:
        """A new instance of a function block."""
        return Instance(self.units[name.lower()])

    def call(self, name: str, *arguments: Any) -> Any:
        """A function's value; arrays are lists."""
        unit = self.units[name.lower()]
        frame = unit.frame()
        for (place, variable), value in zip(unit.parameters.values(), arguments, strict=True):
            frame[place] = value if variable.length is not None else _as(variable.kind, value)
        return unit.result(frame)


class Instance:
    """An instance of a function block, whose inputs and variables outlast a call."""

    def __init__(self, unit: _Unit) -> None:
        if unit.kind is not None:
            raise IecError(f"{unit.name} is no function block")
        self._unit, self.frame = unit, unit.frame()

    def __call__(self, **inputs: float | bool) -> None:
        """Set inputs and run the body once."""
        for name, value in inputs.items():
            place, variable = self._unit.variable(name.lower(), "input")
            self.frame[place] = _as(variable.kind, value)
        self._unit.run(self.frame)

    def output(self, name: str) -> Any:
        """The value of an output."""
        return self.frame[self._unit.variable(name.lower(), "output")[0]]

    def write(self, name: str, value: float) -> None:
        """Retune a variable, as a person at a controller's watch window does."""
        place, variable = self._unit.variable(name.lower())
        self.frame[place] = _as(variable.kind, value)

    def value(self, name: str) -> Any:
        """The present value of a variable."""
        return self.frame[self._unit.variable(name.lower())[0]]


class _Typed(NamedTuple):
    """A compiled expression, of LREAL, DINT, BOOL, or the type of an array or instance."""

    kind: str
    evaluate: Evaluate


class _Unit:
    """A compiled function or function block.

    Args:
        tree: The unit.
        units: Those declared before it.
    """

    def __init__(self, tree: Unit, units: dict[str, _Unit]) -> None:
        self.name, self.kind, self._units = tree.name, tree.result, dict(units)
        if self.kind not in (None, *_ZERO):
            raise IecError(f"{self.name} is of {self.kind}")
        self._variables: dict[str, tuple[int, Variable]] = {}
        self._start: Frame = [None]
        #: Places of lists and instances, of which each frame has its own.
        self._fresh: list[tuple[int, Callable[[], Any]]] = []
        for variable in tree.variables:
            self._declare(variable)
        #: Counters of the loops around the statement that is compiled.
        self._counting: list[str] = []
        self.run = self._body(tree.body)

    @property
    def parameters(self) -> dict[str, tuple[int, Variable]]:
        """Inputs, with their places."""
        return {k: x for k, x in self._variables.items() if x[1].section in ("input", "in_out")}

    def variable(self, name: str, section: str | None = None) -> tuple[int, Variable]:
        """A variable and its place."""
        declared = self._variables.get(name)
        if declared is None or section not in (None, declared[1].section):
            raise IecError(f"{self.name} has no {section or 'variable'} {name}")
        return declared

    def frame(self) -> Frame:
        """Its variables, before a first call."""
        frame = self._start.copy()
        for place, initial_value in self._fresh:
            frame[place] = initial_value()
        return frame

    def result(self, frame: Frame) -> Any:
        """Run a function."""
        self.run(frame)
        if frame[0] is None:
            raise IecError(f"{self.name} has no value")
        return frame[0]

    def _declare(self, variable: Variable) -> None:
        place, name = len(self._start), variable.name.lower()
        if name in self._variables or name == self.name.lower():
            raise IecError(f"{self.name}: {variable.name} is declared twice")
        self._variables[name] = place, variable
        block, value = self._units.get(variable.kind.lower()), None
        if block is not None:
            self._fresh.append((place, lambda: Instance(block)))
        elif variable.kind not in _ZERO:
            raise IecError(f"{self.name}: no type {variable.kind}")
        elif variable.length is not None:
            zeros = [_ZERO[variable.kind]] * variable.length
            self._fresh.append((place, zeros.copy))
        elif variable.initial is None:
            value = _ZERO[variable.kind]
        else:
            value = _checked(variable.kind, self._constant(variable.initial))([])
        self._start.append(value)

    # --- statements

    def _body(self, body: Body) -> Run:
        steps = [self._statement(s) for s in body]
        if len(steps) == 1:
            return steps[0]

        def run(frame: Frame) -> bool:
            for step in steps:  # noqa: SIM110 - `any` is half as fast
                if step(frame):
                    return True
            return False

        return run

    def _statement(self, statement: Statement) -> Run:
        match statement:
            case Assignment():
                return self._assignment(statement)
            case If():
                return self._if(statement)
            case For():
                return self._for(statement)
            case While():
                return self._while(statement)
            case Return():
                return lambda _: True
            case Call():
                return self._invocation(statement)

    def _assignment(self, statement: Assignment) -> Run:
        name = statement.target.name
        value = self._expression(statement.value)
        if name == self.name.lower() and self.kind and isinstance(statement.target, Name):
            return _stored(0, _checked(self.kind, value))
        place, variable = self.variable(name)
        if variable.section == "input" or name in self._counting:
            raise IecError(f"{self.name}: {name} is assigned to")
        evaluate = _checked(variable.kind, value)
        if isinstance(statement.target, Name):
            if variable.length is not None or variable.kind not in _ZERO:
                raise IecError(f"{self.name}: {name} is assigned to as a whole")
            return _stored(place, evaluate)
        array, index = self._element(statement.target)

        def run(frame: Frame) -> bool:
            array(frame)[index(frame)] = evaluate(frame)
            return False

        return run

    def _if(self, statement: If) -> Run:
        otherwise = self._body(statement.otherwise)
        branches = [(self._truth(test), self._body(body)) for test, body in statement.branches]
        if len(branches) == 1:
            ((condition, body),) = branches
            return lambda frame: body(frame) if condition(frame) else otherwise(frame)

        def run(frame: Frame) -> bool:
            for condition, body in branches:
                if condition(frame):
                    return body(frame)
            return otherwise(frame)

        return run

    def _for(self, statement: For) -> Run:
        name = statement.counter
        place, variable = self.variable(name)
        if variable.kind != "DINT" or variable.length is not None or name in self._counting:
            raise IecError(f"{self.name}: no loop counts by {name}")
        ends = (statement.first, statement.last, statement.step)
        first, last, step = (_checked("DINT", self._expression(x)) for x in ends)
        self._counting.append(name)
        body = self._body(statement.body)
        self._counting.remove(name)

        def run(frame: Frame) -> bool:
            start, end, by = first(frame), last(frame), step(frame)
            for i in range(start, end + (1 if by > 0 else -1), by):
                frame[place] = i
                if body(frame):
                    return True
            frame[place] = None  # the standard leaves it undefined
            return False

        return run

    def _while(self, statement: While) -> Run:
        condition, body = self._truth(statement.condition), self._body(statement.body)

        def run(frame: Frame) -> bool:
            while condition(frame):
                if body(frame):
                    return True
            return False

        return run

    def _invocation(self, statement: Call) -> Run:
        place, variable = self.variable(statement.name)
        block = self._units.get(variable.kind.lower())
        if block is None or block.kind is not None:
            raise IecError(f"{statement.name} is no function block")
        inputs = []
        for name, value in statement.arguments:
            target, declared = block.variable(name or "", "input")
            inputs.append((target, _checked(declared.kind, self._expression(value))))

        def run(frame: Frame) -> bool:
            inner = frame[place].frame
            for target, value in [(target, evaluate(frame)) for target, evaluate in inputs]:
                inner[target] = value
            block.run(inner)
            return False

        return run

    # --- expressions

    def _truth(self, expression: Expression) -> Evaluate:
        return _checked("BOOL", self._expression(expression))

    def _expression(self, expression: Expression) -> _Typed:  # noqa: PLR0911 - one case a line
        match expression:
            case Number(value=value):
                number = _finite(value)
                return _Typed("LREAL" if isinstance(value, float) else "DINT", lambda _: number)
            case Truth(value=value):
                return _Typed("BOOL", lambda _: value)
            case Name(name=name):
                return self._variable(name)
            case Element():
                _, variable = self.variable(expression.name)
                array, index = self._element(expression)
                return _Typed(variable.kind, lambda frame: array(frame)[index(frame)])
            case Output(name=name, output=output):
                place, variable = self.variable(name)
                block = self._units.get(variable.kind.lower())
                if block is None:
                    raise IecError(f"{name} is no function block")
                source, declared = block.variable(output, "output")
                return _Typed(declared.kind, lambda frame: frame[place].frame[source])
            case Unary():
                return _unary(expression.operator, self._expression(expression.operand))
            case Binary(operator=operator, left=left, right=right):
                return _binary(operator, self._expression(left), self._expression(right))
            case Call():
                return self._call(expression)

    def _constant(self, expression: Expression) -> _Typed:
        match expression:
            case Number() | Truth() | Unary(operand=Number()):
                return self._expression(expression)
        raise IecError(f"{self.name}: {expression} is no constant")

    def _variable(self, name: str) -> _Typed:
        if name == self.name.lower() and self.kind:
            place, kind = 0, self.kind
        else:
            place, variable = self.variable(name)
            kind = variable.kind
            if variable.length is not None:
                return _Typed(_array(variable), lambda frame: frame[place])

        def evaluate(frame: Frame) -> Any:
            value = frame[place]
            if value is None:
                raise IecError(f"{name} has no value")
            return value

        may_lack = place == 0 or kind == "DINT"
        return _Typed(kind, evaluate if may_lack else operator.itemgetter(place))

    def _element(self, element: Element) -> tuple[Evaluate, Evaluate]:
        """The array, and where the element is in it."""
        place, variable = self.variable(element.name)
        length = variable.length
        if length is None:
            raise IecError(f"{self.name}: {element.name} is no array")
        at = _checked("DINT", self._expression(element.subscript))
        if isinstance(element.subscript, Number) and element.subscript.value in range(length):
            return operator.itemgetter(place), at

        def index(frame: Frame) -> int:
            i = int(at(frame))
            if not 0 <= i < length:
                raise IecError(f"{self.name}: {element.name}[{i}]")
            return i

        return operator.itemgetter(place), index

    def _call(self, call: Call) -> _Typed:
        values = [self._expression(value) for _, value in call.arguments]
        if call.name in STANDARD or call.name == "dint_to_lreal":
            if any(name is not None for name, _ in call.arguments):
                raise IecError(f"{call.name} takes no names")
            return _standard(call.name, values)
        unit = self._units.get(call.name)
        if unit is None or unit.kind is None:
            raise IecError(f"{self.name}: no function {call.name}")
        parameters, names = unit.parameters, [name for name, _ in call.arguments]
        if names == [None]:
            names = list(parameters)
        if len(names) != len(parameters) or set(names) != set(parameters):
            raise IecError(f"{call.name} is called with {names}")
        arguments = []
        for name, value in zip(names, values, strict=True):
            place, variable = parameters[name or ""]
            arguments.append((place, _checked(_array(variable), value)))

        def evaluate(frame: Frame) -> Any:
            inner = unit.frame()
            for place, argument in arguments:
                inner[place] = argument(frame)
            return unit.result(inner)

        return _Typed(unit.kind, evaluate)


# --- values

_ZERO: dict[str, Any] = {"LREAL": 0.0, "DINT": 0, "BOOL": False}
_PYTHON = {"LREAL": float, "DINT": int, "BOOL": bool}


def _array(variable: Variable) -> str:
    return variable.kind if variable.length is None else f"{variable.kind}[{variable.length}]"


def _checked(kind: str, value: _Typed) -> Evaluate:
    """An expression's evaluation, once its type is checked."""
    if value.kind != kind:
        raise IecError(f"an expression is of {value.kind}, not of {kind}")
    return value.evaluate


def _as(kind: str, value: Any) -> Any:
    if kind not in _PYTHON or type(value) is not _PYTHON[kind]:
        raise IecError(f"{value!r} is no {kind}")
    return _finite(value)


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        if not -_LARGEST <= value <= _LARGEST:
            raise IecError("a floating-point exception")
        return value + 0.0  # no zero has a sign here: what relies on one gives another number
    if type(value) is int and not -_DINT <= value < _DINT:
        raise IecError("an overflow")
    return value


def _stored(place: int, evaluate: Evaluate) -> Run:
    def run(frame: Frame) -> bool:
        frame[place] = evaluate(frame)
        return False

    return run


# --- operators


def _unary(sign: str, operand: _Typed) -> _Typed:
    evaluate = operand.evaluate
    if sign == "not":
        _checked("BOOL", operand)
        return _Typed("BOOL", lambda frame: not evaluate(frame))
    if operand.kind not in ("LREAL", "DINT"):
        raise IecError(f"{sign} of {operand.kind}")
    return _Typed(operand.kind, lambda frame: _finite(-evaluate(frame)))


def _binary(sign: str, left: _Typed, right: _Typed) -> _Typed:
    kind, a, b = left.kind, left.evaluate, right.evaluate
    kinds = ("BOOL",) if sign in ("and", "or") else ("LREAL", "DINT")
    if kind != right.kind or kind not in kinds:
        raise IecError(f"{kind} {sign} {right.kind}")
    operation = _OPERATIONS[sign]
    if sign not in "+-*/":
        return _Typed("BOOL", lambda frame: operation(a(frame), b(frame)))
    if kind == "DINT":
        operation = _whole_division if sign == "/" else operation
        return _Typed(kind, lambda frame: _finite(operation(a(frame), b(frame))))

    def evaluate(frame: Frame) -> float:
        try:
            value: float = operation(a(frame), b(frame))
        except ZeroDivisionError:
            raise IecError("a division by 0") from None
        if -_LARGEST <= value <= _LARGEST:
            return value + 0.0
        raise IecError("a floating-point exception")

    return _Typed(kind, evaluate)


def _whole_division(a: int, b: int) -> int:
    """Towards 0."""
    if b == 0:
        raise IecError("a division by 0")
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


_OPERATIONS: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
    "=": operator.eq, "<>": operator.ne, "and": operator.and_, "or": operator.or_,
}  # fmt: skip


# --- standard functions


def _expt(base: float, exponent: float) -> float:
    if base <= 0.0:  # a controller may go by the logarithm
        raise IecError("a floating-point exception")
    return float(base**exponent)


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": abs, "sqrt": math.sqrt, "exp": math.exp, "ln": math.log, "sin": math.sin,
    "cos": math.cos, "min": min, "max": max, "expt": _expt, "dint_to_lreal": float,
}  # fmt: skip


def _standard(name: str, arguments: Sequence[_Typed]) -> _Typed:
    kinds = {x.kind for x in arguments}
    takes = "DINT" if name == "dint_to_lreal" or kinds == {"DINT"} else "LREAL"
    two = name in ("min", "max", "expt")
    any_number = name in ("abs", "min", "max", "dint_to_lreal")
    if kinds != {takes} or len(arguments) != 1 + two or (takes == "DINT" and not any_number):
        raise IecError(f"{name} of {[x.kind for x in arguments]}")
    function, evaluates = _FUNCTIONS[name], [x.evaluate for x in arguments]

    def evaluate(frame: Frame) -> Any:
        try:
            return _finite(function(*[x(frame) for x in evaluates]))
        except (ValueError, OverflowError):
            raise IecError("a floating-point exception") from None

    return _Typed("LREAL" if name == "dint_to_lreal" else takes, evaluate)
