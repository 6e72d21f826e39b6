"""Reading of expressions of compiled Python: values, arrays, and calls of what is known there."""

from __future__ import annotations

import ast
import inspect
import math
import operator
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol

from ...errors import InputError
from ...rig.motion.part_call import beginning, called, further
from .folding import Operation, by_two, known_call, negative, power, real
from .function_source import FunctionSource, python_function
from .program import (
    MATH_FUNCTIONS,
    Array,
    Call,
    Compare,
    Conditional,
    Expression,
    Item,
    Joined,
    Kind,
    Name,
    Number,
    ProgramFunction,
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


class Translator(Protocol):
    """What has been translated so far, as one of its functions sees it."""

    what: str
    functions: dict[str, ProgramFunction]
    entries: dict[str, FunctionSource]
    being_read: list[Callable[..., Any]]

    def translated_name(self, source: FunctionSource) -> str:
        """The name in the program of a function that another calls; translated once."""

    def known_value(self, value: Expression) -> Number | Truth | None:
        """What a call gives, of a function that gives the same each time and does no more."""


class ExpressionReader:
    """Reads the expressions of one function."""

    def __init__(self, translation: Translator, entry: FunctionSource, name: str) -> None:
        self._translation, self._entry, self._name = translation, entry, name
        self._python = python_function(entry.function)
        try:
            lines, self._first = inspect.getsourcelines(self._python)
            self._tree = ast.parse(textwrap.dedent("".join(lines))).body[0]
        except (OSError, TypeError, SyntaxError, IndexError) as error:
            raise InputError(
                f"{translation.what}: cannot be translated: the source of its function "
                f"{getattr(self._python, '__name__', name)!r} is not in a file"
            ) from error
        self._kinds: dict[str, Kind] = {}
        self._variables: dict[str, Name] = {}
        self._arrays = {
            name: Array(name, math.prod(shape), columns=shape[1])
            if isinstance(shape, tuple)
            else Array(name, shape)
            for name, shape in entry.arrays.items()
        }
        self._written = set(entry.written or ())
        self._results: tuple[Kind, ...] = ("real",)
        self._known = inspect.getclosurevars(self._python)

    def _truth(self, node: ast.expr) -> Expression:
        truth = self._expression(node)
        if truth.kind != "truth":
            raise self._refused(node, "asks a number whether it is true: compare it")
        return truth

    def _array(self, node: ast.expr) -> Array | None:
        """An array by its name, or what begins within it; None for any other expression."""
        match node:
            case ast.Name(id=name):
                return self._arrays.get(name)
            case ast.Call(func=ast.Name(id=name), args=[first, *rest]):
                intrinsic, array = self._outside(name), self._array(first)
                if array is None or intrinsic not in (beginning, further):
                    return None
                places = [self._expression(n) for n in rest]
                if not all(isinstance(p, Number) and p.kind == "whole" for p in places):
                    raise self._refused(node, "begins where nobody knows")
                on = sum(int(p.value) for p in places if isinstance(p, Number))
                return replace(array, length=0, offset=array.offset + on)
        return None

    def _item(self, array: Array, node: ast.expr) -> Item:
        """An element, of a table by its row and its column."""
        places = [
            self._expression(n) for n in (node.elts if isinstance(node, ast.Tuple) else [node])
        ]
        if any(place.kind != "whole" for place in places):
            raise self._refused(node, "is an index that is no whole number")
        if len(places) != 1 + (array.columns > 1):
            raise self._refused(node, f"is no index of {array.name}")
        index = places[0]
        if array.columns > 1:
            row = by_two("*", index, Number(array.columns, "whole"))
            index = by_two("+", row, places[1])
        if isinstance(index, Number) and not 0 <= index.value < (array.length or math.inf):
            raise self._refused(node, f"reads {array.name}[{index.value}], it has {array.length}")
        if array.offset:
            index = by_two("+", index, Number(array.offset, "whole"))
        return Item(array.name, index)

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
                inner = self._truth(operand)
                if isinstance(inner, Truth):
                    return Truth(not inner.value)
                return Unary("not", inner, "truth")
            case ast.BinOp(left=left, op=op, right=right):
                return self._binary(op, self._expression(left), self._expression(right), node)
            case ast.Compare(
                left=left,
                ops=[ast.In() | ast.NotIn() as op],
                comparators=[ast.Tuple(elts=elements)],
            ):
                equal = [self._compared([left, e], [ast.Eq()], node) for e in elements]
                inside = Joined("or", tuple(equal))
                return inside if isinstance(op, ast.In) else Unary("not", inside, "truth")
            case ast.Compare(left=left, ops=ops, comparators=others):
                return self._compared([left, *others], ops, node)
            case ast.BoolOp(op=op, values=nodes):
                return self._joined("and" if isinstance(op, ast.And) else "or", nodes)
            case ast.IfExp(test=test, body=yes, orelse=no):
                return self._choice(self._truth(test), yes, no)
            case ast.Call():
                result = self._called(node, 1)
                return self._translation.known_value(result) or result
        raise self._refused(node, "is an expression that other languages are not told")

    def _element(self, item: Item) -> Number | None:
        """An element that is known: a function's address is some number above 0."""
        if not isinstance(item.index, Number):
            return None
        value = self._entry.known.get(item.array, {}).get(int(item.index.value))
        return None if value is None else Number(1.0 if callable(value) else float(value))

    def _joined(self, sign: Literal["and", "or"], nodes: Sequence[ast.expr]) -> Expression:
        """Truths joined; a known one is left out, or decides, and what follows is not read."""
        parts: list[Expression] = []
        for node in nodes:
            part = self._truth(node)
            if not isinstance(part, Truth):
                parts.append(part)
            elif part.value != (sign == "and"):
                return part if all(map(is_pure, parts)) else Joined(sign, (*parts, part))
        if not parts:
            return Truth(sign == "and")
        return parts[0] if len(parts) == 1 else Joined(sign, tuple(parts))

    def _named(self, name: str, node: ast.expr) -> Expression:
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

    def _outside(self, name: str) -> Any:
        """What a name means that is none of the function's own."""
        for names in (self._known.nonlocals, self._known.globals, self._known.builtins):
            if name in names:
                return names[name]
        return None

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
        comparisons: list[Compare] = []
        for left, op, right in zip(sides, ops, sides[1:], strict=False):
            sign = _COMPARED.get(type(op))
            truths = [left.kind, right.kind].count("truth")
            if sign is None or (truths and (truths == 1 or sign not in ("==", "!="))):
                raise self._refused(node, "is a comparison that other languages are not told")
            if left.kind != right.kind:
                left, right = real(left), real(right)  # noqa: PLW2901 - the same values
            comparisons.append(Compare(sign, left, right))
        if len(comparisons) > 1:
            return Joined("and", tuple(comparisons))
        (only,) = comparisons
        if isinstance(only.left, Number) and isinstance(only.right, Number):
            return Truth(_BY_ORDER[only.sign](only.left.value, only.right.value))
        return only

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
        if name == "len" and len(arguments) == 1:
            array = self._array(arguments[0])
            if array is not None and array.length:
                return Number(array.length // array.columns, "whole")
        if name in self._entry.functions:
            return self._program_call(self._entry.functions[name], arguments, node, results)
        if name == "float" and len(arguments) == 1:
            return real(self._expression(arguments[0]))
        if not self._users_own(func) and (known := self._math(func, name, arguments, node)):
            return known
        callee = self._outside(name) if isinstance(func, ast.Name) else None
        if callee is called:  # by the address that stands in a row
            row, place, *handed = arguments
            array, at = self._array(row), self._expression(place)
            known_there = self._entry.known.get(array.name, {}) if array is not None else {}
            where = int(at.value) if isinstance(at, Number) else -1
            callee, begin = known_there.get(where), known_there.get(where + 1)
            if array is None or begin is None or not callable(callee):
                raise self._refused(node, "is a call by an address that is not known")
            name = python_function(callee).__name__
            constants = replace(array, length=0, offset=array.offset + int(begin))
            return self._function_call(callee, name, [*handed[:-1], constants, handed[-1]],
                                       node, results)  # fmt: skip
        if not inspect.isfunction(python_function(callee)):
            raise self._refused(node, f"{name or 'it'} is a call that other languages are not told")
        return self._function_call(callee, name, arguments, node, results)

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
        known: dict[str, Mapping[int, Any]] = {}
        passed: dict[str, dict[str, Any]] = {"drop": {}, "constants": {}, "functions": {}}
        for parameter, argument in zip(names, arguments, strict=False):
            value = self._argument(argument)
            if isinstance(value, Array):
                rows = value.length // value.columns
                arrays[parameter] = (rows, value.columns) if value.columns > 1 else rows
                if not value.offset and value.name in self._entry.known:
                    known[parameter] = self._entry.known[value.name]
            elif isinstance(value, _Known):
                passed[value.field][parameter] = value.value
        source = replace(
            source, arrays=arrays, known=known, drop=tuple(passed["drop"]),
            constants=passed["constants"], functions=passed["functions"],
        )  # fmt: skip
        unique = self._translation.translated_name(source)
        return self._program_call(unique, arguments, node, results)

    def _argument(self, argument: ast.expr | Array) -> Array | _Known | None:
        """An argument that is an array, or known; None for a value."""
        if isinstance(argument, Array):
            return argument
        if (array := self._array(argument)) is not None:
            return array
        if isinstance(argument, ast.Constant | ast.Compare | ast.BoolOp):
            value = self._expression(argument)
            return _Known("constants", value.value) if isinstance(value, Truth) else None
        name, entry = argument.id if isinstance(argument, ast.Name) else "", self._entry
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
        handed = dict(zip(names, values, strict=True))
        arguments: list[Expression] = []
        for formal in function.arguments:
            argument = handed[formal.name]
            array = self._argument(argument)
            if isinstance(formal, Name) and not isinstance(argument, Array):
                value = self._expression(argument)
                arguments.append(self._of_kind(value, formal.kind, argument))
            elif isinstance(formal, Array) and isinstance(array, Array):
                if array.length < formal.length or array.columns != formal.columns:
                    raise self._refused(node, f"{formal.name} is an array of {formal.length}")
                if formal.written:
                    self._writes(array.name, node)
                arguments.append(replace(array, written=formal.written))
            else:
                raise self._refused(node, f"{formal.name} is an array, or is none")
        return Call(name, tuple(arguments), (*function.results, "real")[0])

    def _users_own(self, func: ast.expr) -> bool:
        """Whether a name that is known elsewhere means a function of the user's here."""
        if not isinstance(func, ast.Name):
            return False
        value = self._outside(func.id)
        return inspect.isfunction(value) or hasattr(value, "py_func")

    def _refused(self, node: ast.AST, why: str) -> InputError:
        line = self._first + getattr(node, "lineno", 1) - 1
        try:
            text = ast.unparse(node).partition("\n")[0]
        except (ValueError, TypeError, AttributeError):
            text = type(node).__name__
        what, name = self._translation.what, self._python.__name__
        return InputError(f"{what}: cannot be translated: {name}, line {line}: `{text:.60}`: {why}")

    def _of_kind(self, value: Expression, kind: Kind, node: ast.AST) -> Expression:
        """A value as one of a kind."""
        if kind == "real" and value.kind == "whole":
            return real(value)
        if kind != value.kind:
            raise self._refused(node, f"is {value.kind}, not {kind}")
        return value

    def _writes(self, array: str, node: ast.AST) -> None:
        """An array among the arguments is written."""
        if self._entry.written is not None and array not in self._entry.written:
            raise self._refused(node, f"writes into {array}, which it only reads")
        self._written.add(array)


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
