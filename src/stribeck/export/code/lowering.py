"""A program for languages that lack what Python has: the same values in simpler statements.

What is lowered, always:

- a conditional expression becomes an `if` that sets a variable, so that only the chosen side is
  evaluated: in front of the statement that has it, and for the test of a loop at its end, too;
- an argument that a function assigns to is copied into a variable of its own;
- the loop's test, where it needs statements, becomes a variable that they set.

And for a language whose operators are blunter than Python's (`Blunt`):

- `and` and `or` that may evaluate all their parts become nested ifs where a later part could do
  harm by itself, such as divide by what an earlier one has found to be 0;
- the division of whole numbers that cuts towards 0 gets Python's floor;
- a call that writes into arrays becomes a statement of its own where a function can only hand
  back what it writes.

Signed zeros are no statement's business but a language's: one that has none says so in its own
file, and its `copysign(x, v)` takes + for v == 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from .program import (
    Array,
    Assign,
    Binary,
    Call,
    Choice,
    Compare,
    Count,
    Expression,
    Function,
    If,
    Item,
    Joined,
    Kind,
    Name,
    Number,
    Program,
    Return,
    Statement,
    Truth,
    Unary,
    While,
    expressions,
    parts,
    said,
    statements,
)

_Use = Callable[[Expression], list[Statement]]
#: Calls that go well whatever numbers they are given.
_HARMLESS = frozenset({"abs", "min", "max", "copysign", "real"})


@dataclass(frozen=True)
class Blunt:
    """Which operators of a language are blunter than Python's.

    Args:
        joins: `and` and `or` may evaluate all their parts.
        divides: Whole numbers are divided towards 0.
        returns: Functions hand back the arrays that they write, as further results.
    """

    joins: bool = True
    divides: bool = True
    returns: bool = False


def divides(program: Program) -> bool:
    """Whether a program divides whole numbers by each other."""
    return any(
        isinstance(x, Binary) and x.sign == "//"
        for f in program.functions
        for x in expressions(f.body)
    )


def lowered(program: Program, blunt: Blunt) -> Program:
    """The program with each of its functions lowered."""
    return replace(program, functions=tuple(_Lowering(f, blunt).made() for f in program.functions))


def renamed(function: Function, names: Mapping[str, str]) -> Function:
    """A function whose variables and arguments are called otherwise."""
    return replace(
        function,
        arguments=tuple(replace(a, name=names.get(a.name, a.name)) for a in function.arguments),
        variables=tuple(replace(v, name=names.get(v.name, v.name)) for v in function.variables),
        body=_block_renamed(function.body, names),
    )


def assigned(body: Sequence[Statement]) -> set[str]:
    """The variables that a block assigns to; those that loops count by are not among them."""
    return {s.to.name for s in statements(body) if isinstance(s, Assign) and isinstance(s.to, Name)}


def counters(body: Sequence[Statement]) -> set[str]:
    """The variables that the loops of a block count by."""
    return {s.name for s in statements(body) if isinstance(s, Count)}


def rebuilt(  # noqa: PLR0911 - one case a line
    of: Expression, new: Sequence[Expression]
) -> Expression:
    """An expression with other parts, in the order of `parts`."""
    match of:
        case Item():
            return replace(of, index=new[0])
        case Unary():
            return replace(of, of=new[0])
        case Binary() | Compare():
            return replace(of, left=new[0], right=new[1])
        case Joined():
            return replace(of, parts=tuple(new))
        case Choice():
            return replace(of, test=new[0], yes=new[1], no=new[2])
        case Call():
            return replace(of, given=tuple(new))
    return of


def _safe(of: Expression) -> bool:
    """Whether an expression may be evaluated where Python would not have looked at it."""
    match of:
        case Number() | Truth() | Name():
            own = True
        case Item(index=index):
            own = isinstance(index, Number)
        case Binary(sign=sign):
            own = sign in ("+", "-", "*")
        case Call(name=name):
            own = name in _HARMLESS
        case _:
            own = not isinstance(of, Choice)
    return own and all(map(_safe, parts(of)))


class _Lowering:
    """Lowers one function."""

    def __init__(self, function: Function, blunt: Blunt) -> None:
        self._function, self._blunt = function, blunt
        self._variables = list(function.variables)
        self._taken = {v.name for v in (*function.arguments, *function.variables)}
        self._counted = counters(function.body)

    def made(self) -> Function:
        """The function, lowered."""
        f = self._function
        written = assigned(f.body)
        copies = {
            a.name: self._fresh("real", f"{a.name}_now")
            for a in f.arguments
            if isinstance(a, Name) and a.name in written
        }
        body = _block_renamed(f.body, {old: new.name for old, new in copies.items()})
        head = tuple(Assign(new, Name(old, "real")) for old, new in copies.items())
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
        return tuple(made for statement in body for made in self._statement(statement))

    def _statement(  # noqa: PLR0911 - one case a line
        self, of: Statement
    ) -> list[Statement]:
        match of:
            case Assign(to=to, value=Choice() as value):
                return self._chosen(value, lambda side: self._assign(to, side))
            case Assign(to=to, value=value):
                return self._assign(to, value)
            case Return(value=Choice() as value):
                return self._chosen(value, self._return)
            case Return(value=value):
                return self._return(value)
            case If(test=test, then=then, otherwise=otherwise):
                before, test = self._value(test)
                return [*before, If(test, self._block(then), self._block(otherwise))]
            case Count(name=name, end=end, body=body):
                before, end = self._value(end)
                return [*before, Count(name, end, self._block(body))]
            case While(test=test, body=body):
                return self._while(test, self._block(body))

    def _assign(self, to: Name | Item, value: Expression) -> list[Statement]:
        before: list[Statement] = []
        if isinstance(to, Item):
            before, index = self._value(to.index)
            to = replace(to, index=index)
        more, value = self._value(value, alone=isinstance(to, Name))
        return [*before, *more, Assign(to, value)]

    def _return(self, value: Expression) -> list[Statement]:
        before, value = self._value(value)
        return [*before, Return(value)]

    def _chosen(self, of: Choice, use: _Use) -> list[Statement]:
        """An `if` whose sides make use of the one value or the other."""
        before, test = self._value(of.test)
        sides = [
            tuple(self._chosen(side, use) if isinstance(side, Choice) else use(side))
            for side in (of.yes, of.no)
        ]
        return [*before, If(test, *sides)]

    def _while(self, test: Expression, body: tuple[Statement, ...]) -> list[Statement]:
        before, test = self._value(test)
        if not before:
            return [While(test, body)]
        goes = self._fresh("truth", "goes_on")
        again = (*before, Assign(goes, test))
        return [*again, While(goes, (*body, *again))]

    # --- expressions: statements that go before, and what is left to write

    def _value(self, of: Expression, *, alone: bool = False) -> tuple[list[Statement], Expression]:
        """Statements and an expression; `alone` where it is assigned to a variable as it is."""
        if isinstance(of, Choice):
            to = self._fresh(of.kind, "chosen")
            return self._chosen(of, lambda side: self._assign(to, side)), to
        if isinstance(of, Joined):
            return self._joined(of)
        before: list[Statement] = []
        new: list[Expression] = []
        for part in parts(of):
            more, value = self._value(part)
            before += more
            new.append(value)
        made = rebuilt(of, new)
        if isinstance(made, Binary) and made.sign == "//" and self._blunt.divides:
            more, made = self._floored(made)
            before += more
        if self._blunt.returns and isinstance(made, Call) and made.written and not alone:
            to = self._fresh("real", "result")
            before.append(Assign(to, made))
            made = to
        return before, made

    def _joined(self, of: Joined) -> tuple[list[Statement], Expression]:
        """Later parts behind an `if`, unless they are harmless."""
        before, first = self._value(of.parts[0])
        together = [first]
        for i, part in enumerate(of.parts[1:], 1):
            more, value = self._value(part)
            if more or (self._blunt.joins and not _safe(value)):
                holds = self._fresh("truth", "holds")
                before.append(Assign(holds, _all(of.sign, together)))
                rest = Joined(of.sign, of.parts[i:]) if i + 1 < len(of.parts) else part
                inner = tuple(self._assign(holds, rest))
                ask = holds if of.sign == "and" else Unary("not", holds, "truth")
                return [*before, If(ask, inner)], holds
            together.append(value)
        return before, _all(of.sign, together)

    def _floored(self, of: Binary) -> tuple[list[Statement], Expression]:
        """A quotient that was cut, less one where cutting has raised it."""
        if self._positive(of.left) and self._positive(of.right):
            return [], of
        cut, zero = self._fresh("whole", "quotient"), Number(0, "whole")
        rest = Compare("!=", Binary("*", cut, of.right, "whole"), of.left)
        apart = Compare("<", Binary("*", of.left, of.right, "whole"), zero)
        less = Assign(cut, Binary("-", cut, Number(1, "whole"), "whole"))
        return [Assign(cut, of), If(Joined("and", (rest, apart)), (less,))], cut

    def _positive(self, of: Expression) -> bool:
        """Whether a whole number is known not to be below 0."""
        match of:
            case Number(value=value):
                return value >= 0
            case Name(name=name):
                return name in self._counted
            case Binary(sign="+" | "*" | "//", left=left, right=right):
                return self._positive(left) and self._positive(right)
        return False


def _all(sign: str, of: Sequence[Expression]) -> Expression:
    return of[0] if len(of) == 1 else Joined("and" if sign == "and" else "or", tuple(of))


def _block_renamed(body: Sequence[Statement], names: Mapping[str, str]) -> tuple[Statement, ...]:
    return tuple(_statement_renamed(s, names) for s in body)


def _statement_renamed(of: Statement, names: Mapping[str, str]) -> Statement:
    new = [_expression_renamed(e, names) for e in said(of)]
    match of:
        case Assign():
            to = new[0]
            return Assign(to if isinstance(to, Name | Item) else of.to, new[1])
        case Return():
            return Return(new[0])
        case If(then=then, otherwise=otherwise):
            return If(new[0], _block_renamed(then, names), _block_renamed(otherwise, names))
        case Count(name=name, body=body):
            return Count(names.get(name, name), new[0], _block_renamed(body, names))
        case While(body=body):
            return While(new[0], _block_renamed(body, names))


def _expression_renamed(of: Expression, names: Mapping[str, str]) -> Expression:
    made = rebuilt(of, [_expression_renamed(part, names) for part in parts(of)])
    if isinstance(made, Name):
        return replace(made, name=names.get(made.name, made.name))
    if isinstance(made, Array):
        return replace(made, name=names.get(made.name, made.name))
    if isinstance(made, Item):
        return replace(made, array=names.get(made.array, made.array))
    return made
