"""A function without what nobody reads: values of variables that its known arguments rule out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from .program import (
    Assign,
    Call,
    CountLoop,
    Expression,
    If,
    Name,
    Number,
    ProgramFunction,
    Statement,
    WhileLoop,
    leaves,
    read_names,
    statements,
    targets,
)


def without_unread(function: ProgramFunction) -> ProgramFunction:
    """The function without variables that are given values and never read."""
    while True:
        read = read_names(function)
        body = _kept(function.body, read)
        if body == function.body:
            break
        function = replace(function, body=body)
    used = read | {name for s in statements(body) for name in _named(s)}
    return replace(function, variables=tuple(v for v in function.variables if v.name in used))


def _named(statement: Statement) -> set[str]:
    """The variables that a statement gives values to."""
    if isinstance(statement, CountLoop):
        return {statement.name}
    return {t.name for t in targets(statement) if isinstance(t, Name)}


def _kept(body: Sequence[Statement], read: set[str]) -> tuple[Statement, ...]:
    kept: list[Statement] = []
    for statement in body:
        match statement:
            case Assign(target=Name(name=name), value=value) if name not in read and is_pure(value):
                continue
            case If(test=test, then=then, otherwise=otherwise):
                sides = _kept(then, read), _kept(otherwise, read)
                if any(sides) or not is_pure(test):
                    kept.append(If(test, *sides))
            case CountLoop(end=Number(value=value), first=Number(value=low)) if value <= low:
                continue
            case CountLoop(body=inner):
                kept.append(replace(statement, body=_kept(inner, read)))
            case WhileLoop(test=test, body=inner):
                kept.append(WhileLoop(test, _kept(inner, read)))
            case _:
                kept.append(statement)
    return tuple(kept)


def is_pure(expression: Expression) -> bool:
    """Whether an expression writes nothing."""
    return not any(isinstance(x, Call) and x.written for x in leaves(expression))
