"""Reading of a compiled Python function: its statements, and so all of it."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Mapping, Sequence
from dataclasses import replace

from .expression_reader import ExpressionReader
from .folding import by_two
from .function_source import python_function
from .named_tuples import field_name, kind_of, record_fields
from .program import (
    Array,
    Assign,
    Call,
    CountLoop,
    Expression,
    If,
    Item,
    Jump,
    Kind,
    Name,
    Number,
    ProgramFunction,
    Return,
    Statement,
    Truth,
    Unpack,
    WhileLoop,
    leaves,
    name_of,
)
from .unread import without_unread


class StatementReader(ExpressionReader):
    """Reads one function."""

    #: What the function gives, where it is one NamedTuple.
    _record: dict[str, Kind]
    #: Variables that are assigned to in one place, outside of loops that are written out.
    _once: frozenset[str]

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
        arguments = [place for g in formal for place in self._formal(g)]
        self._kinds |= {place.name: place.kind for place in arguments if isinstance(place, Name)}
        self._record = record_fields(self._python, tree.returns)
        self._results = tuple(self._record.values()) or _results(tree.returns)
        self._once = _assigned_once(tree)
        body = tree.body
        doc = ast.get_docstring(tree) or ""
        statements = self._block(body[1:] if doc else body)
        if self._results and not _ends(statements):
            raise self._refused(tree, "does not return a value on every way through it")
        self._translation.being_read.pop()
        arguments = [
            replace(place, written=place.name in self._written)
            if isinstance(place, Array)
            else place
            for place in arguments
        ]
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

    def _formal(self, argument: ast.arg) -> list[Name | Array]:
        """An argument, or what a NamedTuple is made of."""
        name = argument.arg
        if name in self._entry.arrays:
            return [self._arrays[name]]
        fields = record_fields(self._python, argument.annotation)
        if not fields:
            return [Name(name, _kind(argument.annotation))]
        places = {f: Name(field_name(name, f), kind) for f, kind in fields.items()}
        self._records[name] = dict(places)
        return list(places.values())

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
                return self._returned(value, node)
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=ast.Tuple(elts=values)):
                if len(targets) != len(values):
                    raise self._refused(node, "assigns a different number of values")
                return self._together(targets, values)
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=value):
                return [self._unpacked(targets, value)]
            case ast.Assign(targets=[ast.Subscript() as target], value=value) if (
                array := self._array(target)
            ) is not None:
                return [self._filled(array, value, target)]
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
                iter=ast.Call(func=ast.Name(id="range"), args=[*first, end], keywords=[]),
                body=body,
                orelse=[],
            ) if len(first) <= 1:
                limits = [self._expression(n) for n in (*first, end)]
                if any(limit.kind != "whole" for limit in limits):
                    raise self._refused(node, "counts to something that is no whole number")
                self._declare(name, "whole", node)
                begin = limits[0] if first else Number(0, "whole")
                return [CountLoop(name, limits[-1], self._block(body), begin)]
            case ast.For(
                target=ast.Name(id=name), iter=ast.Tuple(elts=values), body=body, orelse=[]
            ):
                return self._written_out(name, values, body, node)
            case ast.Break() | ast.Continue():
                return [Jump("break" if isinstance(node, ast.Break) else "continue")]
            case ast.Pass():
                return []
        raise self._refused(node, "is a statement that other languages are not told")

    def _written_out(
        self, name: str, values: Sequence[ast.expr], body: Sequence[ast.stmt], node: ast.stmt
    ) -> list[Statement]:
        """A loop over values that are known: its body for each."""
        if any(_jumps(statement) for statement in body):
            raise self._refused(node, "is a loop over values that jumps: write it without")
        written: list[Statement] = []
        for value in values:
            known = self._expression(value)
            if not isinstance(known, Number):
                raise self._refused(value, "is a value that is not known")
            self._fixed[name] = known
            written += self._block(body)
        self._fixed.pop(name, None)
        return written

    def _returned(self, value: ast.expr | None, node: ast.stmt) -> list[Statement]:
        """The function's values, as its annotation counts them."""
        values = value.elts if isinstance(value, ast.Tuple) else () if value is None else (value,)
        if isinstance(value, ast.Call) and self._record:
            record = value.func.id if isinstance(value.func, ast.Name) else ""
            if not inspect.isclass(self._outside(record)):
                raise self._refused(value, "is no NamedTuple of values written out")
            values = value.args
        elif isinstance(value, ast.Call) and len(self._results) > 1:
            results = [self._fresh(f"given_{i}", k) for i, k in enumerate(self._results, 1)]
            call = self._results_of(value, len(results))
            return [Unpack(tuple(results), call), Return(results[0], tuple(results[1:]))]
        if len(values) != len(self._results):
            raise self._refused(node, f"gives {len(values)} values, not {len(self._results)}")
        given = [
            self._of_kind(self._expression(v), kind, v)
            for v, kind in zip(values, self._results, strict=True)
        ]
        return [Return(given[0], tuple(given[1:])) if given else Return(None)]

    def _together(self, targets: Sequence[ast.expr], values: Sequence[ast.expr]) -> list[Statement]:
        """Assignments at once: what one of them would read too late is kept before them."""
        before: list[Statement] = []
        assignments: list[Statement] = []
        known_once: list[tuple[str, Number | Truth]] = []
        evaluated: list[tuple[ast.expr, Expression]] = []
        for target, node in zip(targets, values, strict=True):
            if isinstance(node, ast.Call) and (fields := self._fields_given(node)):
                before.append(self._record_given(target, fields, node))
                continue
            evaluated.append((target, self._array(node) or self._expression(node)))
        for target, value in evaluated:
            name = target.id if isinstance(target, ast.Name) else ""
            if name in self._once and (
                isinstance(value, Truth) or (isinstance(value, Number) and value.kind == "whole")
            ):
                known_once.append((name, value))
                continue
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
        self._fixed |= dict(known_once)
        return [*before, *assignments]

    def _fields_given(self, call: ast.Call) -> dict[str, Kind]:
        """The values of the NamedTuple that a call of a function gives; none of any other."""
        name = call.func.id if isinstance(call.func, ast.Name) else ""
        python = python_function(self._outside(name))
        annotation = getattr(python, "__annotations__", {}).get("return")
        if not (inspect.isfunction(python) and isinstance(annotation, str)):
            return {}
        return record_fields(python, ast.Name(annotation))

    def _record_given(
        self, target: ast.expr, fields: Mapping[str, Kind], call: ast.Call
    ) -> Unpack:  # fmt: skip
        """A NamedTuple that a function gives: its values, each by a name of its own."""
        if not isinstance(target, ast.Name) or target.id not in self._once:
            raise self._refused(target, "is no new name for a NamedTuple")
        given = self._results_of(call, len(fields))
        record: dict[str, Name | Number] = {}
        places: list[Name] = []
        for (f, kind), known in zip(
            fields.items(), self._translation.known_results(given), strict=True
        ):
            if known is None:
                record[f] = place = self._fresh(field_name(target.id, f), kind)
            else:
                record[f], place = known, self._fresh(f"unread_{kind}", kind, again=True)
            places.append(place)
        self._records[target.id] = record
        return Unpack(tuple(places), given)

    def _unpacked(self, targets: Sequence[ast.expr], value: ast.expr) -> Unpack:
        """The results of a call; `_` for one that nobody reads."""
        call = self._results_of(value, len(targets))
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

    def _results_of(self, value: ast.expr, n: int) -> Call:
        """A call of a function that is translated, for so many results."""
        call = self._called(value, n) if isinstance(value, ast.Call) else None
        if not isinstance(call, Call) or call.name not in self._translation.functions:
            raise self._refused(value, "is no call of a function that is translated")
        return call

    def _filled(self, array: Array, value: ast.expr, node: ast.expr) -> CountLoop:
        """All elements of an array get one value, or those of another."""
        if not array.length:
            raise self._refused(node, "is no array of a known length")
        place = self._fresh("place", "whole", again=True)
        self._writes(array.name, node)
        source = self._array(value)
        if source is None:
            element = self._of_kind(self._expression(value), array.kind, value)
        elif source.length != array.length or source.kind != array.kind:
            raise self._refused(value, f"is no array of {array.length} numbers like these")
        else:
            element = Item(source.name, by_two("+", place, source.offset), source.kind)
        target = Item(array.name, by_two("+", place, array.offset), array.kind)
        return CountLoop(place.name, Number(array.length, "whole"), (Assign(target, element),))

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
        if name in self._fixed or name in self._translation.tables:
            raise self._refused(node, f"{name} has a value that stays")
        if name not in self._kinds:
            self._kinds[name] = kind
            self._variables[name] = Name(name, kind)
        return self._kinds[name]


def _assigned_once(tree: ast.FunctionDef) -> frozenset[str]:
    """Variables that are assigned to in one place, outside of loops that are written out."""
    arguments = {g.arg for g in (*tree.args.posonlyargs, *tree.args.args)}
    stored = [n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and _stored(n)]
    again = {
        n.id
        for loop in ast.walk(tree)
        if isinstance(loop, ast.For) and isinstance(loop.iter, ast.Tuple)
        for n in ast.walk(loop)
        if isinstance(n, ast.Name) and _stored(n)
    }
    return frozenset(n for n in stored if stored.count(n) == 1 and n not in {*arguments, *again})


def _stored(name: ast.Name) -> bool:
    return isinstance(name.ctx, ast.Store)


def _jumps(statement: ast.stmt) -> bool:
    """Whether a statement jumps out of a loop that it is in itself."""
    if isinstance(statement, ast.Break | ast.Continue):
        return True
    if isinstance(statement, ast.For | ast.While):
        return False
    return any(isinstance(n, ast.stmt) and _jumps(n) for n in ast.iter_child_nodes(statement))


def _kind(annotation: ast.expr | None) -> Kind:
    """The kind of an argument or a result, by its annotation."""
    return kind_of(annotation.id if isinstance(annotation, ast.Name) else "")


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
