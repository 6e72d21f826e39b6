"""Translation of a law's Python source into a program that other languages can express.

A law is a compiled scalar function whose source is Python. `translated` reads that source, follows
it into the functions that it calls, and gives back functions of a few kinds of statements over
three kinds of values, real, whole and truth. What a dialect prints is thereby the law itself, not
a second copy of it. Whatever has no place in the few kinds is refused, with the line that has it.
"""

from __future__ import annotations

import ast
import inspect
import math
import operator
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from ...errors import InputError
from .program import (
    MATH_FUNCTIONS,
    Array,
    Assign,
    Binary,
    Call,
    Compare,
    Conditional,
    CountLoop,
    Expression,
    If,
    Item,
    Joined,
    Kind,
    Name,
    Number,
    Program,
    ProgramFunction,
    Return,
    Statement,
    Truth,
    Unary,
    WhileLoop,
    expressions,
    leaves,
    name_of,
)

_CONSTANTS = {"pi": math.pi, "e": math.e}


@dataclass(frozen=True)
class FunctionSource:
    """A function to be translated.

    Args:
        name: Its name in the program.
        function: Python, or compiled by numba.
        arrays: Length of each array among its arguments, by argument.
        written: The arrays that it writes.
        drop: Arguments that are dropped: the function must not read them.
        constants: Arguments whose values are known, numbers or tuples of numbers: they are no
            arguments in the program, and branches that they rule out are not translated.
        functions: Arguments that are functions: the names of entries translated before this one.
    """

    name: str
    function: Any
    arrays: Mapping[str, int] = field(default_factory=dict)
    written: tuple[str, ...] = ()
    drop: tuple[str, ...] = ()
    constants: Mapping[str, float | tuple[int, ...]] = field(default_factory=dict)
    functions: Mapping[str, str] = field(default_factory=dict)

    @property
    def absent(self) -> frozenset[str]:
        """Arguments of the function that its translation does not have."""
        return frozenset((*self.drop, *self.constants, *self.functions))


def translate(entries: Sequence[FunctionSource], what: str) -> Program:
    """Translate functions and all that they call.

    Args:
        entries: The functions.
        what: Whose they are, for messages.

    Raises:
        InputError: a source that is not there, or says something that has no place in a program.
    """
    translation = _Translation(what, frozenset(entry.name for entry in entries))
    for entry in entries:
        translation.add(entry)
    functions = tuple(translation.functions.values())
    used = {x.name for f in functions for x in expressions(f.body) if isinstance(x, Call)}
    return Program(
        functions,
        tuple(e.name for e in entries),
        tuple(name for name in MATH_FUNCTIONS if name in used),
    )


def python_function(function: Any) -> Callable[..., Any]:
    """The Python function behind a compiled one."""
    python: Callable[..., Any] = getattr(function, "py_func", function)
    return python


class _Translation:
    """What has been translated so far."""

    def __init__(self, what: str, reserved: frozenset[str]) -> None:
        self.what, self._reserved = what, reserved | MATH_FUNCTIONS.keys()
        self.functions: dict[str, ProgramFunction] = {}
        self.entries: dict[str, FunctionSource] = {}
        self._names: dict[tuple[Any, ...], str] = {}
        #: Functions that are being read: what they call must not lead back to them.
        self.being_read: list[Callable[..., Any]] = []

    def add(self, entry: FunctionSource) -> None:
        """Translate an entry under its own name."""
        self.entries[entry.name] = entry
        self.functions[entry.name] = _FunctionReader(self, entry, entry.name).function()

    def translated_name(self, function: Any, name: str, lengths: Mapping[str, int]) -> str:
        """The name in the program of a function that gives a real number; translated once.

        Args:
            function: Python, or compiled by numba.
            name: What its caller calls it.
            lengths: Of the arrays among its arguments; it must not write them.
        """
        key = (python_function(function), tuple(lengths.items()))
        if key not in self._names:
            unique = name.lstrip("_")
            while unique in self.functions or unique in self._reserved:
                unique += "_"
            self._names[key] = unique
            self.add(FunctionSource(unique, function, lengths))
        return self._names[key]


class _FunctionReader:
    """Reads one function."""

    def __init__(self, translation: _Translation, entry: FunctionSource, name: str) -> None:
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
        self._known = inspect.getclosurevars(self._python)

    def function(self) -> ProgramFunction:
        """The function read."""
        tree = self._tree
        if not isinstance(tree, ast.FunctionDef):
            raise self._refused(tree, "is no plain function")
        a = tree.args
        if a.vararg or a.kwarg or a.kwonlyargs or a.defaults:
            raise self._refused(tree, "has optional or starred arguments")
        self._translation.being_read.append(self._python)
        self._loops(tree)
        arguments: list[Name | Array] = []
        for argument in (*a.posonlyargs, *a.args):
            name = argument.arg
            if name in self._entry.absent:
                continue
            if name in self._entry.arrays:
                written = name in self._entry.written
                arguments.append(Array(name, self._entry.arrays[name], written))
            else:
                self._kinds[name] = "real"
                arguments.append(Name(name, "real"))
        body = tree.body
        doc = ast.get_docstring(tree) or ""
        statements = self._block(body[1:] if doc else body)
        if not _ends(statements):
            raise self._refused(tree, "does not return a value on every way through it")
        self._translation.being_read.pop()
        return ProgramFunction(
            self._name,
            tuple(arguments),
            tuple(self._variables.values()),
            statements,
            doc.partition("\n")[0],
        )

    def _loops(self, tree: ast.FunctionDef) -> None:
        """Refuse what a loop means in Python alone: each language has its own idea of it."""
        for loop in ast.walk(tree):
            if not (isinstance(loop, ast.For) and isinstance(loop.target, ast.Name)):
                continue
            within = {id(n) for s in loop.body for n in ast.walk(s)}
            fixed = {n.id for n in ast.walk(loop.iter) if isinstance(n, ast.Name)}
            for n in ast.walk(tree):
                if not isinstance(n, ast.Name):
                    continue
                written = isinstance(n.ctx, ast.Store)
                if id(n) in within and written and n.id in {loop.target.id, *fixed}:
                    raise self._refused(loop, f"its body changes {n.id}, by which it counts")
                if n.id == loop.target.id and not written and not self._counted(tree, n):
                    raise self._refused(loop, f"{n.id} is read outside its loop")

    @staticmethod
    def _counted(tree: ast.FunctionDef, name: ast.Name) -> bool:
        """Whether a name is read inside a loop that counts by it."""
        return any(
            isinstance(loop, ast.For)
            and isinstance(loop.target, ast.Name)
            and loop.target.id == name.id
            and any(n is name for s in loop.body for n in ast.walk(s))
            for loop in ast.walk(tree)
        )

    # --- statements

    def _block(self, nodes: Sequence[ast.stmt]) -> tuple[Statement, ...]:
        block: list[Statement] = []
        for node in nodes:
            block += self._statement(node)
            if block and isinstance(block[-1], Return):
                break  # what follows is never reached
        return tuple(block)

    def _statement(  # noqa: C901, PLR0911 - one case a line
        self, node: ast.stmt
    ) -> list[Statement]:
        match node:
            case ast.Return(value=ast.expr() as value):
                return [Return(_real(self._expression(value)))]
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=ast.Tuple(elts=values)):
                if len(targets) != len(values):
                    raise self._refused(node, "assigns a different number of values")
                return self._together(targets, [self._expression(v) for v in values], node)
            case ast.Assign(targets=[target], value=value):
                return [self._assigned(target, self._expression(value))]
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                return [self._assigned(target, self._expression(value))]
            case ast.AugAssign(target=target, op=op, value=value):
                left = self._expression(_loaded(target))
                return [
                    self._assigned(target, self._binary(op, left, self._expression(value), node))
                ]
            case ast.If(test=test, body=body, orelse=orelse):
                condition = self._truth(test)
                if isinstance(condition, Truth):
                    return list(self._block(body if condition.value else orelse))
                return [If(condition, self._block(body), self._block(orelse))]
            case ast.While(test=test, body=body, orelse=[]):
                return [WhileLoop(self._truth(test), self._block(body))]
            case ast.For(
                target=ast.Name(id=name),
                iter=ast.Call(func=ast.Name(id="range"), args=[end], keywords=[]),
                body=body,
                orelse=[],
            ):
                limit = self._expression(end)
                if limit.kind != "whole":
                    raise self._refused(node, "counts to something that is no whole number")
                self._declare(name, "whole", node)
                return [CountLoop(name, limit, self._block(body))]
            case ast.Pass():
                return []
        raise self._refused(node, "is a statement that other languages are not told")

    def _together(
        self, targets: Sequence[ast.expr], values: Sequence[Expression], node: ast.stmt
    ) -> list[Statement]:
        """Several assignments at once; none of them may read what an earlier one has written."""
        assignments: list[Statement] = []
        for target, value in zip(targets, values, strict=True):
            written = {name_of(s.target) for s in assignments if isinstance(s, Assign)}
            if written & {name_of(leaf) for leaf in leaves(value)}:
                raise self._refused(node, "swaps values in one line: write it in two")
            assignments.append(self._assigned(target, value))
        return assignments

    def _assigned(self, target: ast.expr, value: Expression) -> Assign:
        match target:
            case ast.Name(id=name):
                kind = self._declare(name, value.kind, target)
                if kind == "real":
                    value = _real(value)
                elif kind != value.kind:
                    raise self._refused(target, f"{name} changes from {kind} to {value.kind}")
                return Assign(Name(name, kind), value)
            case ast.Subscript(value=ast.Name(id=array), slice=index):
                if array not in self._entry.written:
                    raise self._refused(target, f"writes into {array}, which it only reads")
                return Assign(Item(array, self._index(array, index)), _real(value))
        raise self._refused(target, "is no variable")

    def _declare(self, name: str, kind: Kind, node: ast.AST) -> Kind:
        if name in self._entry.arrays or name in self._entry.absent:
            raise self._refused(node, f"{name} is an argument")
        if name not in self._kinds:
            self._kinds[name] = kind
            self._variables[name] = Name(name, kind)
        return self._kinds[name]

    # --- expressions

    def _truth(self, node: ast.expr) -> Expression:
        truth = self._expression(node)
        if truth.kind != "truth":
            raise self._refused(node, "asks a number whether it is true: compare it")
        return truth

    def _index(self, array: str, node: ast.expr) -> Expression:
        place = self._expression(node)
        if place.kind != "whole":
            raise self._refused(node, "is an index that is no whole number")
        length = self._entry.arrays[array]
        if isinstance(place, Number) and not 0 <= place.value < length:
            raise self._refused(node, f"reads {array}[{place.value}], it has {length}")
        return place

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
            case ast.Subscript(value=ast.Name(id=array), slice=index) if (
                array in self._entry.arrays
            ):
                return Item(array, self._index(array, index))
            case ast.Subscript(
                value=ast.Name(id=name), slice=ast.Constant(value=int() as index)
            ) if isinstance(values := self._entry.constants.get(name), tuple) and 0 <= index < len(
                values
            ):
                return Number(values[index], "whole")
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return _negative(self._expression(operand))
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                inner = self._truth(operand)
                if isinstance(inner, Truth):
                    return Truth(not inner.value)
                return Unary("not", inner, "truth")
            case ast.BinOp(left=left, op=op, right=right):
                return self._binary(op, self._expression(left), self._expression(right), node)
            case ast.Compare(left=left, ops=ops, comparators=others):
                return self._compared([left, *others], ops, node)
            case ast.BoolOp(op=op, values=nodes):
                return self._joined("and" if isinstance(op, ast.And) else "or", nodes)
            case ast.IfExp(test=test, body=yes, orelse=no):
                return self._choice(self._truth(test), yes, no)
            case ast.Call(func=func, args=arguments, keywords=[]):
                return self._call(func, arguments, node)
        raise self._refused(node, "is an expression that other languages are not told")

    def _place(self, name: str, index: int, node: ast.expr) -> Number:
        """An element of an argument that is a tuple of whole numbers."""
        values = self._entry.constants.get(name)
        if not (isinstance(values, tuple) and 0 <= index < len(values)):
            raise self._refused(node, "is an expression that other languages are not told")
        return Number(values[index], "whole")

    def _joined(self, sign: Literal["and", "or"], nodes: Sequence[ast.expr]) -> Expression:
        """Truths joined; a known one is left out, or decides, and what follows is not read."""
        parts: list[Expression] = []
        for node in nodes:
            part = self._truth(node)
            if not isinstance(part, Truth):
                parts.append(part)
            elif part.value != (sign == "and"):
                return part if not parts else Joined(sign, (*parts, part))
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
            return _power(left, right)
        if sign is None or "truth" in (left.kind, right.kind):
            raise self._refused(node, "is an operation that other languages are not told")
        whole = left.kind == right.kind == "whole" and sign != "/"
        if sign == "//" and not whole:
            raise self._refused(node, "divides reals without a rest: write it out")
        if not whole:
            left, right = _real(left), _real(right)
        if isinstance(left, Number) and isinstance(right, Number):
            return _folded(sign, left, right, whole=whole)
        if sign == "*" and isinstance(left, Number) and left.value == 1:
            return right
        return Binary(sign, left, right, "whole" if whole else "real")

    def _compared(
        self, nodes: Sequence[ast.expr], ops: Sequence[ast.cmpop], node: ast.AST
    ) -> Expression:
        sides = [self._expression(n) for n in nodes]
        comparisons: list[Compare] = []
        for left, op, right in zip(sides, ops, sides[1:], strict=False):
            sign = _COMPARED.get(type(op))
            if sign is None or "truth" in (left.kind, right.kind):
                raise self._refused(node, "is a comparison that other languages are not told")
            if left.kind != right.kind:
                left, right = _real(left), _real(right)  # noqa: PLW2901 - the same values
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
            a, b = _real(a), _real(b)
        return Conditional(test, a, b, a.kind)

    def _call(self, func: ast.expr, arguments: Sequence[ast.expr], node: ast.expr) -> Expression:
        name = func.id if isinstance(func, ast.Name) else getattr(func, "attr", "")
        if name == "len" and len(arguments) == 1 and isinstance(arguments[0], ast.Name):
            array = arguments[0].id
            if array in self._entry.arrays:
                return Number(self._entry.arrays[array], "whole")
        if name in self._entry.functions:
            return self._program_call(self._entry.functions[name], arguments, node)
        math_name = {"fabs": "abs"}.get(name, name)
        if name == "float" and len(arguments) == 1:
            return _real(self._expression(arguments[0]))
        if math_name in MATH_FUNCTIONS and not self._users_own(func):
            values = tuple(self._expression(g) for g in arguments)
            if len(values) < MATH_FUNCTIONS[math_name] or (
                len(values) > MATH_FUNCTIONS[math_name] and math_name not in ("min", "max")
            ):
                raise self._refused(node, f"{name} takes {MATH_FUNCTIONS[math_name]} values here")
            return _known_call(math_name, tuple(map(_real, values)))
        callee = self._outside(name) if isinstance(func, ast.Name) else None
        if not inspect.isfunction(python_function(callee)):
            raise self._refused(node, f"{name or 'it'} is a call that other languages are not told")
        if python_function(callee) in self._translation.being_read:
            raise self._refused(node, f"{name} calls itself: write a loop")
        names = inspect.signature(python_function(callee)).parameters
        lengths = {
            to: self._entry.arrays[argument.id]
            for to, argument in zip(names, arguments, strict=False)
            if isinstance(argument, ast.Name) and argument.id in self._entry.arrays
        }
        unique = self._translation.translated_name(callee, name, lengths)
        return self._program_call(unique, arguments, node)

    def _program_call(self, name: str, values: Sequence[ast.expr], node: ast.expr) -> Call:
        """A call of a function of the program, without the arguments that it does not have."""
        entry = self._translation.entries[name]
        names = inspect.signature(python_function(entry.function)).parameters
        if len(names) != len(values):
            raise self._refused(node, f"{name} takes {len(names)} arguments")
        arguments: list[Expression] = []
        for parameter, argument in zip(names, values, strict=True):
            if parameter in entry.absent:
                continue
            if parameter not in entry.arrays:
                arguments.append(_real(self._expression(argument)))
                continue
            array = argument.id if isinstance(argument, ast.Name) else ""
            if self._entry.arrays.get(array) != entry.arrays[parameter]:
                raise self._refused(node, f"{parameter} is an array of {entry.arrays[parameter]}")
            if parameter in entry.written and array not in self._entry.written:
                raise self._refused(node, f"{name} writes into {array}, which is only read here")
            arguments.append(Array(array, entry.arrays[parameter], parameter in entry.written))
        return Call(name, tuple(arguments))

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


_SIGNS: Mapping[type[ast.operator], Literal["+", "-", "*", "/", "//"]] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//",
}  # fmt: skip
_COMPARED: Mapping[type[ast.cmpop], Literal["<", "<=", ">", ">=", "==", "!="]] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
_BY_ORDER: Mapping[str, Callable[[float, float], bool]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
    "==": operator.eq, "!=": operator.ne,
}  # fmt: skip
_BY_TWO: Mapping[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b if b else math.copysign(math.inf, a) * math.copysign(1.0, b),
    "//": lambda a, b: a // b,
}


def _real(expression: Expression) -> Expression:
    """The same value as a real number: of a whole one that is not known yet, by a call `real`."""
    if expression.kind == "truth":
        raise InputError("a truth is not a number: use a conditional expression")
    if isinstance(expression, Number):
        return Number(float(expression.value))
    return Call("real", (expression,)) if expression.kind == "whole" else expression


def _negative(expression: Expression) -> Expression:
    if isinstance(expression, Number):
        return Number(-expression.value, expression.kind)
    return Unary("-", expression, expression.kind)


def _folded(sign: str, left: Number, right: Number, *, whole: bool) -> Number:
    value = _BY_TWO[sign](left.value, right.value)
    return Number(int(value), "whole") if whole else Number(float(value))


def _power(base: Expression, exponent: Expression) -> Expression:
    """A square as a product, any other power as a call."""
    if isinstance(exponent, Number) and exponent.value == 2:  # noqa: PLR2004 - the square
        whole = base.kind == "whole"
        return Binary("*", base, base, "whole" if whole else "real")
    return _known_call("pow", (_real(base), _real(exponent)))


def _known_call(name: str, arguments: tuple[Expression, ...]) -> Expression:
    if len(arguments) > MATH_FUNCTIONS[name]:  # min and max of more than two
        return _known_call(name, (_known_call(name, arguments[:2]), *arguments[2:]))
    if all(isinstance(g, Number) for g in arguments):
        function: Any = {"abs": abs, "min": min, "max": max}.get(name) or getattr(math, name)
        return Number(float(function(*(g.value for g in arguments if isinstance(g, Number)))))
    return Call(name, arguments)


def _ends(body: Sequence[Statement]) -> bool:
    """Whether every way through a block returns."""
    if not body:
        return False
    last = body[-1]
    if isinstance(last, If):
        return _ends(last.then) and _ends(last.otherwise)
    return isinstance(last, Return)


def _loaded(target: ast.expr) -> ast.expr:
    """The target of an assignment as something that is read."""
    match target:
        case ast.Subscript(value=value, slice=index):
            return ast.copy_location(
                ast.Subscript(value=value, slice=index, ctx=ast.Load()), target
            )
        case ast.Name(id=name):
            return ast.copy_location(ast.Name(id=name, ctx=ast.Load()), target)
    return target
