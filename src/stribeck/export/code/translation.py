"""Translation of compiled Python into a program that other languages can express.

A law, a part of an axis and the stepper are compiled functions whose source is Python. `translate`
reads that source, follows it into the functions that it calls, and gives back functions of a few
kinds of statements over three kinds of values, real, whole and truth. What a dialect prints is
thereby the function itself, not a second copy of it. Whatever has no place in the few kinds is
refused, with the line that has it.

A function is translated anew for each kind of arguments that it is called with: those that are
known (numbers, truths, functions) are no arguments any more, and what they rule out is left out. An
argument or a result is a whole number or a truth where its annotation says `int` or `bool`.
"""

from __future__ import annotations

import ast
import inspect
import math
import operator
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from ...errors import InputError
from ...rig.motion.part_call import beginning, called, further
from .folding import Operation, by_two, known_call, negative, power, real
from .function_source import FunctionSource, python_function
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
    Jump,
    Kind,
    Name,
    Number,
    Program,
    ProgramFunction,
    Return,
    Statement,
    Truth,
    Unary,
    Unpack,
    WhileLoop,
    expressions,
    leaves,
    name_of,
)
from .unread import is_pure, without_unread

_CONSTANTS = {"pi": math.pi, "e": math.e, "inf": math.inf, "nan": math.nan}


@dataclass(frozen=True)
class _Known:
    """An argument that is known, as its function is told of it: by which field of its source."""

    field: Literal["drop", "constants", "functions"]
    value: Any = None


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
    names = tuple(e.name for e in entries)
    used = set(names)
    for f in reversed(translation.functions.values()):  # each after those that it calls
        if f.name in used:
            used |= {x.name for x in expressions(f.body) if isinstance(x, Call)}
    functions = tuple(f for f in translation.functions.values() if f.name in used)
    return Program(functions, names, tuple(name for name in MATH_FUNCTIONS if name in used))


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

    def translated_name(self, source: FunctionSource) -> str:
        """The name in the program of a function that another calls; translated once.

        Args:
            source: It, by the name that its caller calls it.
        """
        if source.key not in self._names:
            unique = source.name.lstrip("_")
            while unique in self.functions or unique in self._reserved:
                unique += "_"
            self._names[source.key] = unique
            self.add(replace(source, name=unique))
        return self._names[source.key]

    def known_value(self, value: Expression) -> Number | Truth | None:
        """What a call gives, of a function that gives the same each time and does no more."""
        function = self.functions.get(value.name) if isinstance(value, Call) else None
        match function and function.body:
            case (Return(value=Number() | Truth() as known, more=()),):
                return known
        return None


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
        self._arrays = {
            name: Array(name, math.prod(shape), columns=shape[1])
            if isinstance(shape, tuple)
            else Array(name, shape)
            for name, shape in entry.arrays.items()
        }
        self._written = set(entry.written or ())
        self._results: tuple[Kind, ...] = ("real",)
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
        formal = [g for g in (*a.posonlyargs, *a.args) if g.arg not in self._entry.absent]
        self._kinds |= {g.arg: _kind(g.annotation) for g in formal if g.arg not in self._arrays}
        self._results = _results(tree.returns)
        body = tree.body
        doc = ast.get_docstring(tree) or ""
        statements = self._block(body[1:] if doc else body)
        if self._results and not _ends(statements):
            raise self._refused(tree, "does not return a value on every way through it")
        self._translation.being_read.pop()
        arguments = (
            replace(self._arrays[g.arg], written=g.arg in self._written)
            if g.arg in self._entry.arrays
            else Name(g.arg, self._kinds[g.arg])
            for g in formal
        )
        return without_unread(
            ProgramFunction(
                self._name,
                tuple(arguments),
                tuple(self._variables.values()),
                statements,
                doc.partition("\n")[0],
                self._results,
            )
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
            if block and isinstance(block[-1], Return | Jump):
                break  # what follows is never reached
        return tuple(block)

    def _statement(  # noqa: C901, PLR0911, PLR0912 - one case a line
        self, node: ast.stmt
    ) -> list[Statement]:
        match node:
            case ast.Return(value=value):
                return [self._returned(value, node)]
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=ast.Tuple(elts=values)):
                if len(targets) != len(values):
                    raise self._refused(node, "assigns a different number of values")
                return self._together(targets, values)
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=value):
                return [self._unpacked(targets, value)]
            case ast.Assign(
                targets=[ast.Subscript(value=array, slice=ast.Slice(None, None, None))], value=value
            ):
                return [self._filled(array, value)]
            case ast.Assign(targets=[target, *others], value=value):
                first = self._together([target], [value])
                return [*first, *(self._assigned(o, self._expression(_loaded(target)))
                                  for o in others)]  # fmt: skip
            case ast.Expr(value=ast.Call() as value):
                return [self._unpacked((), value)]
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
            case ast.Break() | ast.Continue():
                return [Jump("break" if isinstance(node, ast.Break) else "continue")]
            case ast.Pass():
                return []
        raise self._refused(node, "is a statement that other languages are not told")

    def _returned(self, value: ast.expr | None, node: ast.stmt) -> Return:
        """The function's values, as its annotation counts them."""
        values = value.elts if isinstance(value, ast.Tuple) else () if value is None else (value,)
        if len(values) != len(self._results):
            raise self._refused(node, f"gives {len(values)} values, not {len(self._results)}")
        results = [
            self._of_kind(self._expression(v), kind, v)
            for v, kind in zip(values, self._results, strict=True)
        ]
        return Return(results[0], tuple(results[1:])) if results else Return(None)

    def _together(self, targets: Sequence[ast.expr], values: Sequence[ast.expr]) -> list[Statement]:
        """Assignments at once: what one of them would read too late is kept before them."""
        before: list[Statement] = []
        assignments: list[Statement] = []
        evaluated = [self._array(v) or self._expression(v) for v in values]
        for target, value in zip(targets, evaluated, strict=True):
            if isinstance(value, Array):  # another name for it
                if not isinstance(target, ast.Name) or target.id in self._kinds:
                    raise self._refused(target, "is no new name for an array")
                self._arrays[target.id] = value
                continue
            written = {name_of(s.target) for s in assignments if isinstance(s, Assign)}
            kept: Expression = value
            if written & {name_of(leaf) for leaf in leaves(value)}:
                kept = self._fresh("kept", value.kind)
                before.append(Assign(kept, value))
            assignments.append(self._assigned(target, kept))
        return [*before, *assignments]

    def _unpacked(self, targets: Sequence[ast.expr], value: ast.expr) -> Unpack:
        """The results of a call; `_` for one that nobody reads."""
        call = self._called(value, len(targets)) if isinstance(value, ast.Call) else None
        if not isinstance(call, Call) or call.name not in self._translation.functions:
            raise self._refused(value, "is no call of a function that is translated")
        kinds = self._translation.functions[call.name].results
        places: list[Name | Item | None] = []
        for i, (target, kind) in enumerate(zip(targets, kinds, strict=False)):
            if isinstance(target, ast.Name) and target.id == "_":
                places.append(self._fresh(f"unread_{kind}", kind, again=True) if i else None)
                continue
            place = self._target(target, kind)
            if place.kind != kind:
                raise self._refused(target, f"changes from {place.kind} to {kind}")
            places.append(place)
        return Unpack(tuple(places), call)

    def _filled(self, node: ast.expr, value: ast.expr) -> CountLoop:
        """All elements of an array get one value."""
        array = self._array(node)
        if array is None or not array.length:
            raise self._refused(node, "is no array of a known length")
        place = self._fresh("place", "whole", again=True)
        index: Expression = place
        if array.offset:
            index = Binary("+", place, Number(array.offset, "whole"), "whole")
        self._writes(array.name, node)
        one = Assign(Item(array.name, index), real(self._expression(value)))
        return CountLoop(place.name, Number(array.length, "whole"), (one,))

    def _fresh(self, stem: str, kind: Kind, *, again: bool = False) -> Name:
        """A variable that the source has not; the same one for each use where that is harmless."""
        taken = {n.id for n in ast.walk(self._tree) if isinstance(n, ast.Name)}
        taken |= {n.arg for n in ast.walk(self._tree) if isinstance(n, ast.arg)}
        name, n = stem, 1
        while name in taken or (name in self._kinds and not again):
            n += 1
            name = f"{stem}_{n}"
        self._kinds[name] = kind
        return self._variables.setdefault(name, Name(name, kind))

    def _assigned(self, target: ast.expr, value: Expression) -> Assign:
        place = self._target(target, value.kind)
        return Assign(place, self._of_kind(value, place.kind, target))

    def _target(self, target: ast.expr, kind: Kind) -> Name | Item:
        """What gets a value of a kind."""
        match target:
            case ast.Name(id=name):
                return Name(name, self._declare(name, kind, target))
            case ast.Subscript(value=node, slice=index):
                if (array := self._array(node)) is not None:
                    self._writes(array.name, target)
                    return self._item(array, index)
        raise self._refused(target, "is no variable")

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

    def _declare(self, name: str, kind: Kind, node: ast.AST) -> Kind:
        if name in self._arrays or name in self._entry.absent:
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


def _kind(annotation: ast.expr | None) -> Kind:
    """The kind of an argument or a result, by its annotation."""
    name = annotation.id if isinstance(annotation, ast.Name) else ""
    return "whole" if name == "int" else "truth" if name == "bool" else "real"


def _results(annotation: ast.expr | None) -> tuple[Kind, ...]:
    """The kinds of what a function gives, by its annotation."""
    match annotation:
        case ast.Constant(value=None):
            return ()
        case ast.Subscript(value=ast.Name(id="tuple"), slice=ast.Tuple(elts=several)):
            return tuple(map(_kind, several))
    return (_kind(annotation),)


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
