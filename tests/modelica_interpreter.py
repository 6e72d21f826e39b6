"""Runs functions and sampled blocks of Modelica, so that tests need no Modelica tool.

The text is parsed by pymoca, whose grammar is the language's; this file walks its tree. It shares
nothing with what writes the text, and forgives less than a tool: inputs are not assigned to, AND
and OR look at both sides, arrays have bounds, and a division by 0 is an error.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cache
from typing import Any

from pymoca import ast, parser

_BUILT_IN: dict[str, Callable[..., Any]] = {
    "abs": abs, "sqrt": math.sqrt, "exp": math.exp, "log": math.log, "sin": math.sin,
    "cos": math.cos, "tanh": math.tanh, "min": min, "max": max,
    "div": lambda a, b: abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1),
}  # fmt: skip
#: A function or block of a package, with the two spaces that those in a package begin with.
_CLASS = re.compile(r"^  (?:function|block) (\w+)\b.*?^  end \1;\n", re.MULTILINE | re.DOTALL)
_ZERO = {"Real": 0.0, "Integer": 0, "Boolean": False}


class ModelicaError(Exception):
    """What a tool would refuse, or stop at."""


class _Return(Exception):  # noqa: N818 - no error: a return
    pass


@cache  # most classes are in many texts, and parsing is slow
def _class(text: str) -> Any:
    (parsed,) = parser.parse(f"package One\n{text}end One;\n").classes["One"].classes.values()
    return parsed


class Package:
    """A package of functions and blocks.

    Args:
        text: Modelica.
        name: The package's.
    """

    def __init__(self, text: str, name: str) -> None:
        classes = [_class(part[0]) for part in _CLASS.finditer(text)]
        frame = parser.parse(_CLASS.sub("", text)).classes.get(name)
        if frame is None or frame.type != "package":
            raise ModelicaError(f"no package {name}")
        self.classes: dict[str, Any] = {c.name: c for c in classes} | dict(frame.classes)
        if len(self.classes) != len(classes) + len(frame.classes):
            raise ModelicaError("a class is declared twice")

    def call(self, name: str, arguments: Sequence[Any]) -> list[Any]:
        """A function's results."""
        f = self.classes.get(name)
        if f is None or f.type != "function":
            raise ModelicaError(f"no function {name}")
        inputs = [s for s in f.symbols.values() if "input" in s.prefixes]
        values = {s.name: _zero(s) for s in f.symbols.values()}
        for symbol, value in zip(inputs, arguments, strict=True):
            size = _size(symbol)
            if size is not None and (not isinstance(value, list) or len(value) != size):
                raise ModelicaError(f"{name}: {symbol.name} is no array of {size}")
            if (
                size is None
                and symbol.type.name != "Real"
                and type(value) is not type(_zero(symbol))
            ):
                raise ModelicaError(f"{name}: {symbol.name} is no {symbol.type.name}")
            plain = float(value) if symbol.type.name == "Real" and size is None else value
            values[symbol.name] = plain if size is None else list(value)
        scope = _Scope(self, values, frozenset(s.name for s in inputs))
        with suppress(_Return):
            scope.run(f.statements)
        return [values[s.name] for s in f.symbols.values() if "output" in s.prefixes]


class Block:
    """An instance of a block: its equations, or the statements that it runs at an instant.

    Args:
        package: Where it is.
        name: Its name.
        changed: Parameters that differ from the text's.
    """

    def __init__(self, package: Package, name: str, **changed: float | bool) -> None:
        self._package, self._class = package, package.classes[name]
        self.values: dict[str, Any] = {}
        for symbol in self._class.symbols.values():
            if symbol.name in changed:
                self.values[symbol.name] = changed[symbol.name]
            elif "parameter" in symbol.prefixes:
                self.values[symbol.name] = _Scope(package, self.values).value(_binding(symbol))
            else:
                self.values[symbol.name] = _zero(symbol)
        if set(changed) - set(self.values):
            raise ModelicaError(f"{name} has no {set(changed) - set(self.values)}")

    def sampled(self) -> list[float]:
        """The block's first sampling instant and its sampling period."""
        (when,) = self._class.statements
        (sample,) = when.conditions
        scope = _Scope(self._package, self.values)
        return [scope.value(x) for x in sample.operands]

    def step(self, **inputs: float) -> None:
        """One instant with these inputs."""
        for name, value in inputs.items():
            if "input" not in self._class.symbols[name].prefixes:
                raise ModelicaError(f"{name} is no input")
            self.values[name] = value
        before = {k: list(v) if isinstance(v, list) else v for k, v in self.values.items()}
        read_only = frozenset(
            s.name for s in self._class.symbols.values() if {"input", "parameter"} & set(s.prefixes)
        )
        scope = _Scope(self._package, self.values, read_only, before)
        for equation in self._class.equations:
            scope.assign(equation.left, scope.value(equation.right))
        for when in self._class.statements:
            scope.run(when.blocks[0])


class _Scope:
    """Values of variables; statements and expressions are evaluated on them."""

    def __init__(
        self,
        package: Package,
        values: dict[str, Any],
        read_only: frozenset[str] = frozenset(),
        before: dict[str, Any] | None = None,
    ) -> None:
        self._package, self._values, self._read_only = package, values, read_only
        self._before, self._loops = before, dict[str, int]()

    # --- statements

    def run(self, statements: Sequence[Any]) -> None:
        for statement in statements:
            self._statement(statement)

    def _statement(self, statement: Any) -> None:  # noqa: C901 - one case a line
        match statement:
            case ast.AssignmentStatement():
                right = statement.right
                if len(statement.left) == 1:
                    self.assign(statement.left[0], self.value(right))
                    return
                results = self._package.call(_called(right), [*map(self.value, right.operands)])
                for target, value in zip(statement.left, results, strict=True):
                    self.assign(target, value)
            case ast.IfStatement():
                for condition, block in zip(statement.conditions, statement.blocks, strict=True):
                    if condition is True or self._truth(condition):
                        self.run(block)
                        return
            case ast.ForStatement():
                self._for(statement)
            case ast.WhileStatement():
                while self._truth(statement.condition):
                    self.run(statement.statements)
            case ast.Primary(value="return"):
                raise _Return
            case _:
                raise ModelicaError(f"statement {type(statement).__name__}")

    def _for(self, loop: ast.ForStatement) -> None:
        (index,) = loop.indices
        span = index.expression
        first, last, step = (self.value(x) for x in (span.start, span.stop, span.step))
        if step != 1 or last < first:  # first:step:last: pymoca 0.12 takes the last for the step
            last, step = step, last
        if {type(first), type(step), type(last)} != {int}:
            raise ModelicaError("a loop counts by Integers")
        for i in range(first, last + (1 if step > 0 else -1), step):
            self._loops[index.name] = i
            self.run(loop.statements)
        self._loops.pop(index.name, None)

    def assign(self, target: Any, value: Any) -> None:
        name = target.name
        if name not in self._values or name in self._read_only or name in self._loops:
            raise ModelicaError(f"{name} is assigned to")
        current = self._values[name]
        index = self._index(target)
        if index is not None:
            current[index] = _as(0.0, value)
        elif isinstance(current, list):
            if not isinstance(value, list) or len(value) != len(current):
                raise ModelicaError(f"{name} is assigned {value!r}")
            self._values[name] = list(value)
        else:
            self._values[name] = _as(current, value)

    # --- expressions

    def _truth(self, condition: Any) -> bool:
        value = self.value(condition)
        if not isinstance(value, bool):
            raise ModelicaError("a condition is no Boolean")
        return value

    def value(self, expression: Any) -> Any:
        match expression:
            case ast.Primary(value=value):
                return value
            case ast.Array(values=values):
                return [self.value(v) for v in values]
            case ast.ComponentRef():
                return self._referenced(expression, self._values)
            case ast.IfExpression(conditions=conditions, expressions=expressions):
                for condition, branch in zip(conditions, expressions, strict=False):
                    if self._truth(condition):
                        return self.value(branch)
                return self.value(expressions[-1])
            case ast.Expression():
                return self._operation(expression)
        raise ModelicaError(f"expression {type(expression).__name__}")

    def _operation(self, expression: ast.Expression) -> Any:
        name = _called(expression)
        if name == "pre" and self._before is not None:
            return self._referenced(expression.operands[0], self._before)
        operands = [self.value(x) for x in expression.operands]
        if name in _OPERATIONS or name == "not":
            return _number(_operated(name, operands))
        if name in _BUILT_IN:
            return _number(_BUILT_IN[name](*operands))
        return self._package.call(name, operands)[0]

    def _referenced(self, reference: Any, values: dict[str, Any]) -> Any:
        if reference.name in self._loops:
            return self._loops[reference.name]
        if reference.name not in values:
            raise ModelicaError(f"{reference.name} is not declared")
        index = self._index(reference)
        return values[reference.name] if index is None else values[reference.name][index]

    def _index(self, reference: Any) -> int | None:
        (indices,) = reference.indices
        if indices == [None]:
            return None
        (index,) = indices
        subscript = self.value(index)
        array = self._values[reference.name]
        if (
            not isinstance(subscript, int)
            or not isinstance(array, list)
            or not 1 <= subscript <= len(array)
        ):
            raise ModelicaError(f"{reference.name}[{subscript}]")
        return subscript - 1


def _called(expression: Any) -> str:
    return str(getattr(expression.operator, "name", expression.operator))


def _binding(symbol: Any) -> Any:
    """The expression that a declaration binds its parameter to."""
    for argument in symbol.class_modification.arguments:
        if argument.value.component.name == "value":
            return argument.value.modifications[0]
    raise ModelicaError(f"{symbol.name} has no value")


def _size(symbol: Any) -> int | None:
    ((size,),) = symbol.dimensions
    return None if size.value is None else int(size.value)


def _zero(symbol: Any) -> Any:
    size, zero = _size(symbol), _ZERO[symbol.type.name]
    return zero if size is None else [zero] * size


def _as(current: Any, value: Any) -> Any:
    if isinstance(current, float) and type(value) in (int, float):
        return _number(float(value))
    if type(current) is not type(value):
        raise ModelicaError(f"{value!r} for {current!r}")
    return value


def _number(value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        raise ModelicaError("a number that is none")
    return 0.0 if isinstance(value, float) and value == 0.0 else value


_OPERATIONS: dict[str, Callable[[Any, Any], Any]] = {
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b,
    "/": lambda a, b: a / b, "^": lambda a, b: float(a) ** float(b), "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b, ">": lambda a, b: a > b, ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b, "<>": lambda a, b: a != b, "and": lambda a, b: a and b,
    "or": lambda a, b: a or b,
}  # fmt: skip


def _operated(name: str, operands: list[Any]) -> Any:
    truths = [isinstance(x, bool) for x in operands]
    if name in ("and", "or", "not"):
        if not all(truths):
            raise ModelicaError(f"{name} of {operands}")
    elif any(truths):
        raise ModelicaError(f"{name} of {operands}")
    if len(operands) == 1:
        return not operands[0] if name == "not" else (-operands[0] if name == "-" else operands[0])
    result = operands[0]
    for value in operands[1:]:
        result = _OPERATIONS[name](result, value)
    return result
