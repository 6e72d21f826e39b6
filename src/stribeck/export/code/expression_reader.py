"""Reading of expressions of compiled Python: values, arrays, and calls of what is known there."""

from __future__ import annotations

import ast
import inspect
import math
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from ...rig.motion.part_call import called
from .array_reader import ArrayReader
from .folding import Operation, by_two, known_call, negative, power, real
from .function_source import FunctionSource, python_function
from .named_tuples import field_name
from .program import (
    MATH_FUNCTIONS,
    Array,
    Call,
    Compare,
    Conditional,
    Expression,
    Joined,
    Kind,
    Name,
    Number,
    Truth,
    Unary,
)
from .unread import is_pure

_CONSTANTS = {"pi": math.pi, "e": math.e, "inf": math.inf, "nan": math.nan}


@dataclass(frozen=True)
class _Known:
    """An argument that is known, as its function is told of it: by which field of its source."""

    field: Literal["drop", "constants", "functions"]
    value: Any = None


class ExpressionReader(ArrayReader):
    """Reads the expressions of one function."""

    def _truth(self, node: ast.expr) -> Expression:
        truth = self._expression(node)
        if truth.kind != "truth":
            raise self._refused(node, "asks a number whether it is true: compare it")
        return truth

    def _expression(  # noqa: C901, PLR0911, PLR0912 - one case a line
        self, node: ast.expr
    ) -> Expression:
        match node:
            case ast.Constant(value=bool() as value):
                return Truth(value)
            case ast.Constant(value=int() as value):
                return Number(value, "whole")
            case ast.Constant(value=float() as value):
                return Number(value)
            case ast.Name(id=name):
                return self._named(name, node)
            case ast.Attribute(value=ast.Name(id=name), attr=attr) if name in self._records:
                return self._records[name][attr]
            case ast.Attribute(value=ast.Name(), attr=attr) if attr in _CONSTANTS:
                return Number(_CONSTANTS[attr])
            case ast.Subscript(value=array_node, slice=index) if (
                array := self._array(array_node)
            ) is not None:
                item = self._item(array, index)
                return self._element(item) or item
            case ast.Subscript(
                value=ast.Name(id=name), slice=ast.Constant(value=int() as index)
            ) if isinstance(values := self._entry.constants.get(name), tuple) and 0 <= index < len(
                values
            ):
                return Number(values[index], "whole")
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return negative(self._expression(operand))
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return self._negated(self._truth(operand))
            case ast.BinOp(left=left, op=op, right=right):
                return self._binary(op, self._expression(left), self._expression(right), node)
            case ast.Compare(
                left=left,
                ops=[ast.In() | ast.NotIn() as op],
                comparators=[ast.Tuple(elts=elements)],
            ):
                equal = (self._compared([left, e], [ast.Eq()], node) for e in elements)
                inside = self._any_or_all("or", equal)
                return inside if isinstance(op, ast.In) else self._negated(inside)
            case ast.Compare(left=left, ops=ops, comparators=others):
                return self._compared([left, *others], ops, node)
            case ast.BoolOp(op=op, values=nodes):
                sign: Literal["and", "or"] = "and" if isinstance(op, ast.And) else "or"
                return self._any_or_all(sign, map(self._truth, nodes))
            case ast.IfExp(test=test, body=yes, orelse=no):
                return self._choice(self._truth(test), yes, no)
            case ast.Call():
                result = self._called(node, 1)
                return self._translation.known_value(result) or result
        raise self._refused(node, "is an expression that other languages are not told")

    @staticmethod
    def _negated(truth: Expression) -> Expression:
        """The opposite."""
        return Truth(not truth.value) if isinstance(truth, Truth) else Unary("not", truth, "truth")

    @staticmethod
    def _any_or_all(sign: Literal["and", "or"], truths: Iterable[Expression]) -> Expression:
        """Truths joined; a known one is left out, or decides, and what follows is not read."""
        parts: list[Expression] = []
        for part in truths:
            if not isinstance(part, Truth):
                parts.append(part)
            elif part.value != (sign == "and"):
                return part if all(map(is_pure, parts)) else Joined(sign, (*parts, part))
        if not parts:
            return Truth(sign == "and")
        return parts[0] if len(parts) == 1 else Joined(sign, tuple(parts))

    def _named(self, name: str, node: ast.expr) -> Expression:
        if name in self._fixed:
            return self._fixed[name]
        if name in self._kinds:
            return Name(name, self._kinds[name])
        value = self._entry.constants.get(name, self._outside(name))
        if isinstance(value, bool):
            return Truth(value)
        if isinstance(value, int):
            return Number(value, "whole")
        if isinstance(value, float):
            return Number(value)
        raise self._refused(node, f"{name} is no number that is known here")

    def _binary(
        self, op: ast.operator, left: Expression, right: Expression, node: ast.AST
    ) -> Expression:
        sign = _SIGNS.get(type(op))
        if isinstance(op, ast.Pow):
            return power(left, right)
        if sign is None or "truth" in (left.kind, right.kind):
            raise self._refused(node, "is an operation that other languages are not told")
        whole = left.kind == right.kind == "whole" and sign != "/"
        if sign in ("//", "%") and not whole:
            raise self._refused(node, "divides reals with a rest or without: write it out")
        if not whole:
            left, right = real(left), real(right)
        return by_two(sign, left, right)

    def _compared(
        self, nodes: Sequence[ast.expr], ops: Sequence[ast.cmpop], node: ast.AST
    ) -> Expression:
        sides = [self._expression(n) for n in nodes]
        comparisons: list[Compare | Truth] = []
        for left, op, right in zip(sides, ops, sides[1:], strict=False):
            sign = _COMPARED.get(type(op))
            truths = [left.kind, right.kind].count("truth")
            if sign is None or (truths and (truths == 1 or sign not in ("==", "!="))):
                raise self._refused(node, "is a comparison that other languages are not told")
            if left.kind != right.kind:
                left, right = real(left), real(right)  # noqa: PLW2901 - the same values
            comparisons.append(
                Truth(_BY_ORDER[sign](left.value, right.value))
                if isinstance(left, Number) and isinstance(right, Number)
                else Compare(sign, left, right)
            )
        return self._any_or_all("and", comparisons)

    def _choice(self, test: Expression, yes: ast.expr, no: ast.expr) -> Expression:
        if isinstance(test, Truth):
            return self._expression(yes if test.value else no)
        a, b = self._expression(yes), self._expression(no)
        if a.kind != b.kind:
            a, b = real(a), real(b)
        return Conditional(test, a, b, a.kind)

    def _called(self, node: ast.Call, results: int) -> Expression:
        """A call that gives so many results."""
        func, arguments = node.func, node.args
        name = func.id if isinstance(func, ast.Name) else getattr(func, "attr", "")
        if node.keywords:
            raise self._refused(node, "names its arguments")
        if name in self._entry.functions:
            return self._program_call(self._entry.functions[name], arguments, node, results)
        if not self._users_own(func) and (
            known := self._converted(name, arguments) or self._math(func, name, arguments, node)
        ):
            return known
        callee = self._outside(name) if isinstance(func, ast.Name) else None
        if callee is called:
            return self._addressed(arguments, node, results)
        if not inspect.isfunction(python_function(callee)):
            raise self._refused(node, f"{name or 'it'} is a call that other languages are not told")
        return self._function_call(callee, name, arguments, node, results)

    def _addressed(self, arguments: Sequence[ast.expr], node: ast.Call, results: int) -> Call:
        """A call of a function by the address that stands in a row."""
        row, place, *handed = arguments
        array, at = self._array(row), self._expression(place)
        known_there = self._known_part(array) if array is not None else {}
        where = int(at.value) if isinstance(at, Number) else -1
        callee, begin = known_there.get(where), known_there.get(where + 1)
        if array is None or begin is None or not callable(callee):
            raise self._refused(node, "is a call by an address that is not known")
        name, constants = python_function(callee).__name__, self._further(array, int(begin), 0)
        return self._function_call(
            callee, name, [*handed[:-1], constants, handed[-1]], node, results
        )

    def _converted(self, name: str, arguments: Sequence[ast.expr]) -> Expression | None:
        """The length of an array, or a number as one of another kind."""
        if name not in ("len", "float", "int") or len(arguments) != 1:
            return None
        if name == "len":
            array = self._array(arguments[0])
            known = array is not None and array.length > 0
            return Number(array.length // array.columns, "whole") if array and known else None
        number = self._expression(arguments[0])
        if name == "float":
            return real(number)
        if isinstance(number, Number):
            return Number(int(number.value), "whole")
        return number if number.kind == "whole" else None

    def _math(
        self, func: ast.expr, name: str, arguments: Sequence[ast.expr], node: ast.expr
    ) -> Expression | None:
        """A function of the mathematics, if that is what is called."""
        if name == "isnan" and len(arguments) == 1:
            number = self._expression(arguments[0])
            return Compare("!=", number, number)
        name = {"fabs": "abs"}.get(name, name)
        if name not in MATH_FUNCTIONS or (name == "round" and isinstance(func, ast.Name)):
            return None
        values = tuple(self._expression(g) for g in arguments)
        if len(values) < MATH_FUNCTIONS[name] or (
            len(values) > MATH_FUNCTIONS[name] and name not in ("min", "max")
        ):
            raise self._refused(node, f"{name} takes {MATH_FUNCTIONS[name]} values here")
        return known_call(name, tuple(map(real, values)))

    def _function_call(
        self, callee: Any, name: str, arguments: Sequence[ast.expr | Array], node: ast.expr,
        results: int,
    ) -> Call:  # fmt: skip
        """A call of a function that is translated as far as it is not known here."""
        if python_function(callee) in self._translation.being_read:
            raise self._refused(node, f"{name} calls itself: write a loop")
        names = tuple(inspect.signature(python_function(callee)).parameters)
        source = FunctionSource(name, callee, {}, None)
        arrays: dict[str, int | tuple[int, int]] = {}
        whole: list[str] = []
        known: dict[str, Mapping[int, Any]] = {}
        passed: dict[str, dict[str, Any]] = {"drop": {}, "constants": {}, "functions": {}}
        for parameter, argument in zip(names, arguments, strict=False):
            value = self._argument(argument)
            if isinstance(value, Array):
                rows = value.length // value.columns
                arrays[parameter] = (rows, value.columns) if value.columns > 1 else rows
                whole += [parameter] if value.kind == "whole" else []
                if part := self._known_part(value):
                    known[parameter] = part
            elif isinstance(value, _Known):
                passed[value.field][parameter] = value.value
        source = replace(
            source, arrays=arrays, known=known, drop=tuple(passed["drop"]),
            constants=passed["constants"], functions=passed["functions"], whole=tuple(whole),
        )  # fmt: skip
        unique = self._translation.translated_name(source)
        return self._program_call(unique, arguments, node, results)

    def _argument(self, argument: ast.expr | Array) -> Array | _Known | None:
        """An argument that is an array, or known; None for a value."""
        if isinstance(argument, Array):
            return argument
        if (array := self._array(argument)) is not None:
            return array
        if isinstance(argument, ast.Constant | ast.Compare | ast.BoolOp | ast.Subscript):
            value = self._expression(argument)
            whole = isinstance(argument, ast.Subscript) and value.kind == "whole"
            if isinstance(value, Truth) or (whole and isinstance(value, Number)):
                return _Known("constants", value.value)
            return None
        return self._known_name(argument.id) if isinstance(argument, ast.Name) else None

    def _known_name(self, name: str) -> _Known | None:
        """What is known by a name."""
        entry = self._entry
        if name in self._fixed:
            return _Known("constants", self._fixed[name].value)
        if name in (*entry.constants, *entry.functions):
            field: Literal["constants", "functions"] = (
                "constants" if name in entry.constants else "functions"
            )
            return _Known(field, getattr(entry, field)[name])
        return _Known("drop") if name in entry.drop else None

    def _program_call(
        self, name: str, values: Sequence[ast.expr | Array], node: ast.expr, results: int
    ) -> Call:
        """A call of a function of the program, without the arguments that it does not have."""
        entry, function = self._translation.entries[name], self._translation.functions[name]
        names = inspect.signature(python_function(entry.function)).parameters
        if len(names) != len(values):
            raise self._refused(node, f"{name} takes {len(names)} arguments")
        if results and len(function.results) != results:
            raise self._refused(node, f"gives {len(function.results)} values, not {results}")
        handed: dict[str, ast.expr | Array | Name | Number] = {}
        for formal_name, given in zip(names, values, strict=True):
            if isinstance(given, ast.Name) and given.id in self._records:
                fields = self._records[given.id]
                handed |= {field_name(formal_name, f): place for f, place in fields.items()}
            else:
                handed[formal_name] = given
        if odd := [f.name for f in function.arguments if f.name not in handed]:
            raise self._refused(node, f"{odd[0]} is of a NamedTuple, or is of none")
        arguments = (self._handed(f, handed[f.name], node) for f in function.arguments)
        return Call(name, tuple(arguments), (*function.results, "real")[0])

    def _handed(
        self, formal: Name | Array, argument: ast.expr | Array | Name | Number, node: ast.expr
    ) -> Expression:
        """An argument of a call, as its function takes it."""
        if isinstance(argument, Name | Number):
            return argument
        array = self._argument(argument)
        if isinstance(formal, Name) and not isinstance(argument, Array):
            return self._of_kind(self._expression(argument), formal.kind, argument)
        if not (isinstance(formal, Array) and isinstance(array, Array)):
            raise self._refused(node, f"{formal.name} is an array, or is none")
        if (
            array.length < formal.length
            or array.columns != formal.columns
            or array.kind != formal.kind
        ):
            raise self._refused(node, f"{formal.name} is an array of {formal.length}")
        if formal.written:
            self._writes(array.name, node)
        return replace(array, written=formal.written)

    def _users_own(self, func: ast.expr) -> bool:
        """Whether a name that is known elsewhere means a function of the user's here."""
        if not isinstance(func, ast.Name):
            return False
        value = self._outside(func.id)
        return inspect.isfunction(value) or hasattr(value, "py_func")

    def _of_kind(self, value: Expression, kind: Kind, node: ast.AST) -> Expression:
        """A value as one of a kind."""
        if kind == "real" and value.kind == "whole":
            return real(value)
        if kind != value.kind:
            raise self._refused(node, f"is {value.kind}, not {kind}")
        return value


_SIGNS: Mapping[type[ast.operator], Operation] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%",
}  # fmt: skip
_COMPARED: Mapping[type[ast.cmpop], Literal["<", "<=", ">", ">=", "==", "!="]] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
_BY_ORDER: Mapping[str, Callable[[float, float], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
    "==": operator.eq, "!=": operator.ne,
}  # fmt: skip
