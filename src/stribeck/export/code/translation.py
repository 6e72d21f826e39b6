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
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from .expression_reader import ExpressionReader
from .folding import real
from .function_source import FunctionSource
from .program import (
    MATH_FUNCTIONS,
    Array,
    Assign,
    Binary,
    Call,
    CountLoop,
    Expression,
    If,
    Item,
    Jump,
    Kind,
    Name,
    Number,
    Program,
    ProgramFunction,
    Return,
    Statement,
    Truth,
    Unpack,
    WhileLoop,
    expressions,
    leaves,
    name_of,
)
from .unread import without_unread


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


class _FunctionReader(ExpressionReader):
    """Reads one function."""

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

    def _declare(self, name: str, kind: Kind, node: ast.AST) -> Kind:
        if name in self._arrays or name in self._entry.absent:
            raise self._refused(node, f"{name} is an argument")
        if name not in self._kinds:
            self._kinds[name] = kind
            self._variables[name] = Name(name, kind)
        return self._kinds[name]


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
