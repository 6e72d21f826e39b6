"""A program for languages that lack what Python has: the same values in simpler statements.

What is lowered, always:

- a conditional expression becomes an `if` that sets a variable, so that only the chosen side is
  evaluated: in front of the statement that has it, and for the test of a loop at its end, too;
- an argument that a function assigns to is copied into a variable of its own;
- the loop's test, where it needs statements, becomes a variable that they set.

What only some languages say, several results or a jump out of a loop, is refused for the others.

And for a language that is more restricted than Python (`Restrictions`):

- `and` and `or` that may evaluate all their parts become nested ifs where a later part could do
  harm by itself, such as divide by what an earlier one has found to be 0;
- the division of whole numbers that cuts towards 0 gets Python's floor;
- a call that writes into arrays becomes a statement of its own where a function can only hand
  back what it writes.

Signed zeros are no statement's business but a language's: one that has none says so in its own
file, and its `copysign(x, v)` takes + for v == 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from ...errors import InputError
from .program import (
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
    direct_expressions,
    expressions,
    parts,
    statements,
    targets,
)

_Use = Callable[[Expression], list[Statement]]
#: Calls that go well whatever numbers they are given.
_HARMLESS = frozenset({"abs", "min", "max", "copysign", "real"})


@dataclass(frozen=True)
class Restrictions:
    """How a language is more restricted than Python: operators, results, loops and numbers.

    Args:
        joins: `and` and `or` may evaluate all their parts.
        divides: Whole numbers are divided towards 0.
        returns: Functions hand back the arrays that they write, as further results.
        plain: It has functions of one result, loops without jumps, and finite numbers only.
    """

    joins: bool = True
    divides: bool = True
    returns: bool = False
    plain: bool = True


def divides(program: Program) -> bool:
    """Whether a program divides whole numbers by each other."""
    return any(
        isinstance(x, Binary) and x.sign == "//"
        for f in program.functions
        for x in expressions(f.body)
    )


def lowered(program: Program, restrictions: Restrictions) -> Program:
    """The program with each of its functions lowered.

    Raises:
        InputError: a function has what the language does not say.
    """
    for f in program.functions if restrictions.plain else ():
        wide = len(f.results) != 1 or any(isinstance(s, Unpack | Jump) for s in statements(f.body))
        if wide or any(map(_is_wide, expressions(f.body))):
            raise InputError(
                f"{f.name}: cannot be translated: several results, a jump in a loop, a rest of a "
                "division, rounding and infinite numbers are what only C is told"
            )
        if _has_parts(f, program):
            raise InputError(
                f"{f.name}: cannot be translated: parts of arrays, arrays of whole numbers and "
                "tables of a module are what only C is told"
            )
    return replace(
        program, functions=tuple(_Lowering(f, restrictions).lowered() for f in program.functions)
    )


def _has_parts(function: ProgramFunction, program: Program) -> bool:
    """Whether a function reads tables, has whole numbers in arrays, or hands over parts of them."""
    own = {a.name: a for a in function.arguments if isinstance(a, Array)}
    return any(a.kind == "whole" for a in own.values()) or any(
        x.array in program.tables
        if isinstance(x, Item)
        else x.name not in own or replace(x, written=own[x.name].written) != own[x.name]
        for x in expressions(function.body)
        if isinstance(x, Item | Array)
    )


def _is_wide(expression: Expression) -> bool:
    match expression:
        case Binary(sign="%") | Call(name="round"):
            return True
        case Number(value=value):
            return not math.isfinite(value)
    return False


def renamed(function: ProgramFunction, names: Mapping[str, str]) -> ProgramFunction:
    """A function whose variables and arguments are called otherwise."""
    return replace(
        function,
        arguments=tuple(replace(a, name=names.get(a.name, a.name)) for a in function.arguments),
        variables=tuple(replace(v, name=names.get(v.name, v.name)) for v in function.variables),
        body=_block_renamed(function.body, names),
    )


def assigned(body: Sequence[Statement]) -> set[str]:
    """The variables that a block assigns to; those that loops count by are not among them."""
    return {t.name for s in statements(body) for t in targets(s) if isinstance(t, Name)}


def counters(body: Sequence[Statement]) -> set[str]:
    """The variables that the loops of a block count by."""
    return {s.name for s in statements(body) if isinstance(s, CountLoop)}


def rebuilt(  # noqa: PLR0911 - one case a line
    expression: Expression, new_parts: Sequence[Expression]
) -> Expression:
    """An expression with other parts, in the order of `parts`."""
    match expression:
        case Item():
            return replace(expression, index=new_parts[0])
        case Unary():
            return replace(expression, operand=new_parts[0])
        case Binary() | Compare():
            return replace(expression, left=new_parts[0], right=new_parts[1])
        case Joined():
            return replace(expression, parts=tuple(new_parts))
        case Conditional():
            return replace(expression, test=new_parts[0], yes=new_parts[1], no=new_parts[2])
        case Call():
            return replace(expression, arguments=tuple(new_parts))
        case Array() if new_parts:
            return replace(expression, offset=new_parts[0])
    return expression


def _safe(expression: Expression) -> bool:
    """Whether an expression may be evaluated where Python would not have looked at it."""
    match expression:
        case Number() | Truth() | Name():
            alone = True
        case Item(index=index):
            alone = isinstance(index, Number)
        case Binary(sign=sign):
            alone = sign in ("+", "-", "*")
        case Call(name=name):
            alone = name in _HARMLESS
        case _:
            alone = not isinstance(expression, Conditional)
    return alone and all(map(_safe, parts(expression)))


class _Lowering:
    """Lowers one function."""

    def __init__(self, function: ProgramFunction, restrictions: Restrictions) -> None:
        self._function, self._restrictions = function, restrictions
        self._variables = list(function.variables)
        self._taken = {v.name for v in (*function.arguments, *function.variables)}
        self._counted = counters(function.body)

    def lowered(self) -> ProgramFunction:
        """The function, lowered."""
        f = self._function
        written = assigned(f.body)
        copies = {
            a.name: self._fresh(a.kind, f"{a.name}_now")
            for a in f.arguments
            if isinstance(a, Name) and a.name in written
        }
        body = _block_renamed(f.body, {old: new.name for old, new in copies.items()})
        head = tuple(Assign(new, Name(old, new.kind)) for old, new in copies.items())
        lines = head + self._block(body)
        return replace(f, variables=tuple(self._variables), body=lines)

    def _fresh(self, kind: Kind, stem: str) -> Name:
        """A variable that nobody has."""
        name, n = stem, 1
        while name in self._taken:
            n += 1
            name = f"{stem}{n}"
        self._taken.add(name)
        self._variables.append(Name(name, kind))
        return Name(name, kind)

    # --- statements

    def _block(self, body: Sequence[Statement]) -> tuple[Statement, ...]:
        return tuple(lowered for statement in body for lowered in self._statement(statement))

    def _statement(  # noqa: PLR0911 - one case a line
        self, statement: Statement
    ) -> list[Statement]:
        match statement:
            case Assign(target=target, value=Conditional() as value):
                return self._chosen(value, lambda side: self._assign(target, side))
            case Assign(target=target, value=value):
                return self._assign(target, value)
            case Unpack(targets=targets, value=value):
                before, arguments = self._values(parts(value))
                return [*before, Unpack(targets, replace(value, arguments=tuple(arguments)))]
            case Return(value=Conditional() as value, more=()):
                return self._chosen(value, self._return)
            case Return(value=value, more=more):
                return self._return(value, more)
            case Jump():
                return [statement]
            case If(test=test, then=then, otherwise=otherwise):
                before, test = self._value(test)
                return [*before, If(test, self._block(then), self._block(otherwise))]
            case CountLoop(name=name, end=end, body=body, first=first):
                before, (first, end) = self._values((first, end))
                return [*before, CountLoop(name, end, self._block(body), first)]
            case WhileLoop(test=test, body=body):
                return self._while(test, self._block(body))

    def _assign(self, target: Name | Item, value: Expression) -> list[Statement]:
        before: list[Statement] = []
        if isinstance(target, Item):
            before, index = self._value(target.index)
            target = replace(target, index=index)
        more, value = self._value(value, alone=isinstance(target, Name))
        return [*before, *more, Assign(target, value)]

    def _return(
        self, value: Expression | None, more: tuple[Expression, ...] = ()
    ) -> list[Statement]:
        if value is None:
            return [Return(None)]
        before, (value, *more_values) = self._values((value, *more))
        return [*before, Return(value, tuple(more_values))]

    def _chosen(self, conditional: Conditional, use: _Use) -> list[Statement]:
        """An `if` whose sides make use of the one value or the other."""
        before, test = self._value(conditional.test)
        sides = [
            tuple(self._chosen(side, use) if isinstance(side, Conditional) else use(side))
            for side in (conditional.yes, conditional.no)
        ]
        return [*before, If(test, *sides)]

    def _while(self, test: Expression, body: tuple[Statement, ...]) -> list[Statement]:
        before, test = self._value(test)
        if not before:
            return [WhileLoop(test, body)]
        if any(isinstance(s, Jump) and s.word == "continue" for s in statements(body)):
            raise InputError(f"{self._function.name}: cannot be translated: goes on to the next "
                             "turn of a loop whose test needs statements")  # fmt: skip
        goes = self._fresh("truth", "goes_on")
        again = (*before, Assign(goes, test))
        return [*again, WhileLoop(goes, (*body, *again))]

    # --- expressions: statements that go before, and what is left to write

    def _value(
        self, expression: Expression, *, alone: bool = False
    ) -> tuple[list[Statement], Expression]:
        """Statements and an expression; `alone` where it is assigned to a variable as it is."""
        if isinstance(expression, Conditional):
            variable = self._fresh(expression.kind, "chosen")
            return self._chosen(expression, lambda side: self._assign(variable, side)), variable
        if isinstance(expression, Joined):
            return self._joined(expression)
        before, new = self._values(parts(expression))
        lowered = rebuilt(expression, new)
        if isinstance(lowered, Binary) and lowered.sign == "//" and self._restrictions.divides:
            more, lowered = self._floored(lowered)
            before += more
        if (
            self._restrictions.returns
            and isinstance(lowered, Call)
            and lowered.written
            and not alone
        ):
            variable = self._fresh(lowered.kind, "result")
            before.append(Assign(variable, lowered))
            lowered = variable
        return before, lowered

    def _values(self, several: Sequence[Expression]) -> tuple[list[Statement], list[Expression]]:
        """The same of several expressions, one after the other."""
        before: list[Statement] = []
        values: list[Expression] = []
        for expression in several:
            more, value = self._value(expression)
            before += more
            values.append(value)
        return before, values

    def _joined(self, joined: Joined) -> tuple[list[Statement], Expression]:
        """Later parts behind an `if`, unless they are harmless."""
        before, first = self._value(joined.parts[0])
        truths = [first]
        for i, part in enumerate(joined.parts[1:], 1):
            more, value = self._value(part)
            if more or (self._restrictions.joins and not _safe(value)):
                holds = self._fresh("truth", "holds")
                before.append(Assign(holds, _all(joined.sign, truths)))
                rest = Joined(joined.sign, joined.parts[i:]) if i + 1 < len(joined.parts) else part
                inner = tuple(self._assign(holds, rest))
                ask = holds if joined.sign == "and" else Unary("not", holds, "truth")
                return [*before, If(ask, inner)], holds
            truths.append(value)
        return before, _all(joined.sign, truths)

    def _floored(self, quotient: Binary) -> tuple[list[Statement], Expression]:
        """A quotient that was cut, less one where cutting has raised it."""
        if self._positive(quotient.left) and self._positive(quotient.right):
            return [], quotient
        cut, zero = self._fresh("whole", "quotient"), Number(0, "whole")
        rest = Compare("!=", Binary("*", cut, quotient.right, "whole"), quotient.left)
        apart = Compare("<", Binary("*", quotient.left, quotient.right, "whole"), zero)
        less = Assign(cut, Binary("-", cut, Number(1, "whole"), "whole"))
        return [Assign(cut, quotient), If(Joined("and", (rest, apart)), (less,))], cut

    def _positive(self, expression: Expression) -> bool:
        """Whether a whole number is known not to be below 0."""
        match expression:
            case Number(value=value):
                return value >= 0
            case Name(name=name):
                return name in self._counted
            case Binary(sign="+" | "*" | "//", left=left, right=right):
                return self._positive(left) and self._positive(right)
        return False


def _all(sign: str, truths: Sequence[Expression]) -> Expression:
    return (
        truths[0] if len(truths) == 1 else Joined("and" if sign == "and" else "or", tuple(truths))
    )


def _block_renamed(body: Sequence[Statement], names: Mapping[str, str]) -> tuple[Statement, ...]:
    return tuple(_statement_renamed(s, names) for s in body)


def _statement_renamed(  # noqa: PLR0911 - one case a line
    statement: Statement, names: Mapping[str, str]
) -> Statement:
    new = [_expression_renamed(e, names) for e in direct_expressions(statement)]
    match statement:
        case Assign():
            return Assign(_target_renamed(statement.target, names), new[-1])
        case Unpack(targets=several):
            call = new[-1]
            renamed_targets = (t and _target_renamed(t, names) for t in several)
            return Unpack(
                tuple(renamed_targets), call if isinstance(call, Call) else statement.value
            )
        case Jump():
            return statement
        case Return():
            return Return(new[0], tuple(new[1:])) if new else statement
        case If(then=then, otherwise=otherwise):
            return If(new[0], _block_renamed(then, names), _block_renamed(otherwise, names))
        case CountLoop(name=name, body=body):
            return CountLoop(names.get(name, name), new[1], _block_renamed(body, names), new[0])
        case WhileLoop(body=body):
            return WhileLoop(new[0], _block_renamed(body, names))


def _target_renamed(target: Name | Item, names: Mapping[str, str]) -> Name | Item:
    new = _expression_renamed(target, names)
    return new if isinstance(new, Name | Item) else target


def _expression_renamed(expression: Expression, names: Mapping[str, str]) -> Expression:
    result = rebuilt(expression, [_expression_renamed(part, names) for part in parts(expression)])
    if isinstance(result, Name):
        return replace(result, name=names.get(result.name, result.name))
    if isinstance(result, Array):
        return replace(result, name=names.get(result.name, result.name))
    if isinstance(result, Item):
        return replace(result, array=names.get(result.array, result.array))
    return result
