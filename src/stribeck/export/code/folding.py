"""Expressions over values that are known are carried out, as Python would."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Literal

from ...errors import InputError
from .program import MATH_FUNCTIONS, Binary, Call, Expression, Kind, Number, Unary

Operation = Literal["+", "-", "*", "/", "//", "%"]
_BY_TWO: Mapping[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b if b else math.copysign(math.inf, a) * math.copysign(1.0, b),
    "//": lambda a, b: a // b,
    "%": lambda a, b: a % b,
}


def real(expression: Expression) -> Expression:
    """The same value as a real number: of a whole one that is not known yet, by a call `real`."""
    if expression.kind == "truth":
        raise InputError("a truth is not a number: use a conditional expression")
    if isinstance(expression, Number):
        return Number(float(expression.value))
    return Call("real", (expression,)) if expression.kind == "whole" else expression


def negative(expression: Expression) -> Expression:
    """Minus a number."""
    if isinstance(expression, Number):
        return Number(-expression.value, expression.kind)
    return Unary("-", expression, expression.kind)


def by_two(sign: Operation, left: Expression, right: Expression) -> Expression:
    """An operation on two values of one kind, carried out where both are known."""
    kind: Kind = left.kind
    if isinstance(left, Number) and isinstance(right, Number):
        value = _BY_TWO[sign](left.value, right.value)
        return Number(int(value), "whole") if kind == "whole" else Number(float(value))
    if sign == "*" and isinstance(left, Number) and left.value == 1:
        return right
    if sign == "+" and kind == "whole":
        for one, other in ((left, right), (right, left)):
            if isinstance(one, Number) and one.value == 0:
                return other
    return Binary(sign, left, right, kind)


def power(base: Expression, exponent: Expression) -> Expression:
    """A square as a product, any other power as a call."""
    if isinstance(exponent, Number) and exponent.value == 2:  # noqa: PLR2004 - the square
        whole = base.kind == "whole"
        return Binary("*", base, base, "whole" if whole else "real")
    return known_call("pow", (real(base), real(exponent)))


_BUILT_IN: Mapping[str, Callable[..., float]] = {"abs": abs, "min": min, "max": max, "round": round}


def known_call(name: str, arguments: tuple[Expression, ...]) -> Expression:
    """A function of the mathematics."""
    if len(arguments) > MATH_FUNCTIONS[name]:  # min and max of more than two
        return known_call(name, (known_call(name, arguments[:2]), *arguments[2:]))
    if all(isinstance(g, Number) for g in arguments):
        function: Any = _BUILT_IN.get(name) or getattr(math, name)
        return Number(float(function(*(g.value for g in arguments if isinstance(g, Number)))))
    return Call(name, arguments)
