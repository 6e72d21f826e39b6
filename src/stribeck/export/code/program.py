"""The program of a law: functions of a few kinds of statements and expressions.

Three kinds of values, real, whole and truth; numbers and arrays of fixed length as arguments. A
`translation` makes a program of a law's source, a `dialect` writes it in its language. What only
some languages say (several results, jumps in a loop) is refused for the others by `lowering`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

Kind = Literal["real", "whole", "truth"]
#: What a law may call, and how many values each takes.
MATH_FUNCTIONS: Mapping[str, int] = {
    "abs": 1, "sqrt": 1, "exp": 1, "expm1": 1, "log": 1, "log1p": 1, "sin": 1, "cos": 1,
    "tanh": 1, "round": 1, "copysign": 2, "min": 2, "max": 2, "pow": 2,
}  # fmt: skip


@dataclass(frozen=True)
class Number:
    """A number as it stands."""

    value: float | int
    kind: Kind = "real"


@dataclass(frozen=True)
class Truth:
    """True or False."""

    value: bool
    kind: Kind = "truth"


@dataclass(frozen=True)
class Name:
    """A variable."""

    name: str
    kind: Kind


@dataclass(frozen=True)
class Item:
    """An element of an array, counted from 0."""

    array: str
    index: Expression
    kind: Kind = "real"


@dataclass(frozen=True)
class Unary:
    """`-` of a number or `not` of a truth."""

    sign: Literal["-", "not"]
    operand: Expression
    kind: Kind


@dataclass(frozen=True)
class Binary:
    """`+ - * /` of reals, `+ - *`, `//` and `%` of whole numbers."""

    sign: Literal["+", "-", "*", "/", "//", "%"]
    left: Expression
    right: Expression
    kind: Kind


@dataclass(frozen=True)
class Compare:
    """One comparison."""

    sign: Literal["<", "<=", ">", ">=", "==", "!="]
    left: Expression
    right: Expression
    kind: Kind = "truth"


@dataclass(frozen=True)
class Joined:
    """All, or any, of several truths; the later ones are harmless where the first decides."""

    sign: Literal["and", "or"]
    parts: tuple[Expression, ...]
    kind: Kind = "truth"


@dataclass(frozen=True)
class Conditional:
    """One of two values by a truth; only that one may be looked at."""

    test: Expression
    yes: Expression
    no: Expression
    kind: Kind


@dataclass(frozen=True)
class Array:
    """A whole array, as an argument of a function or handed to one.

    Args:
        name: Its name in the function that has it.
        length: Its elements; 0 where nobody says.
        written: Whether the function that takes it writes into it.
        offset: Of the first element that is handed over.
        columns: Of a table, whose rows stand one after the other; else 1.
        kind: Of its elements, real or whole.
    """

    name: str
    length: int
    written: bool = False
    offset: Expression = Number(0, "whole")
    columns: int = 1
    kind: Kind = "real"

    @property
    def begin(self) -> int:
        """Its offset, where that is known; else −1."""
        return int(self.offset.value) if isinstance(self.offset, Number) else -1


@dataclass(frozen=True)
class Call:
    """One of MATH_FUNCTIONS, `real` of a whole number, or another function of the program."""

    name: str
    arguments: tuple[Expression, ...]
    kind: Kind = "real"

    @property
    def written(self) -> tuple[Array, ...]:
        """The arrays that it writes into."""
        return tuple(g for g in self.arguments if isinstance(g, Array) and g.written)


Expression = (
    Number | Truth | Name | Item | Unary | Binary | Compare | Joined | Conditional | Call | Array
)


@dataclass(frozen=True)
class Assign:
    """A variable or an element gets a value."""

    target: Name | Item
    value: Expression


@dataclass(frozen=True)
class Unpack:
    """Variables or elements get the results of a call, in order; None takes none.

    Without targets the call is made for what it writes.
    """

    targets: tuple[Name | Item | None, ...]
    value: Call


@dataclass(frozen=True)
class If:
    """One of two blocks."""

    test: Expression
    then: tuple[Statement, ...]
    otherwise: tuple[Statement, ...] = ()


@dataclass(frozen=True)
class CountLoop:
    """A block for each whole number from the first to one below the end."""

    name: str
    end: Expression
    body: tuple[Statement, ...]
    first: Expression = Number(0, "whole")


@dataclass(frozen=True)
class WhileLoop:
    """A block as long as a truth holds."""

    test: Expression
    body: tuple[Statement, ...]


@dataclass(frozen=True)
class Jump:
    """Out of a loop, or on to its next turn."""

    word: Literal["break", "continue"]


@dataclass(frozen=True)
class Return:
    """The function's value, and further ones; no value of one that only writes."""

    value: Expression | None
    more: tuple[Expression, ...] = ()


Statement = Assign | Unpack | If | CountLoop | WhileLoop | Jump | Return


@dataclass(frozen=True)
class ProgramFunction:
    """One function.

    Args:
        name: What the program calls it.
        arguments: Numbers and arrays, in order.
        variables: Of its own, with their kinds, in order of appearance.
        body: What it does; every way through it ends in a `Return`.
        doc: The first line of its docstring.
        results: The kinds of its values.
    """

    name: str
    arguments: tuple[Name | Array, ...]
    variables: tuple[Name, ...]
    body: tuple[Statement, ...]
    doc: str = ""
    results: tuple[Kind, ...] = ("real",)


@dataclass(frozen=True)
class Program:
    """Functions, each after those that it calls; the last ones are those asked for.

    Args:
        functions: All of them.
        entries: The names of those that were asked for.
        calls: Which of MATH_FUNCTIONS they use, in the order of that table.
        tables: Numbers of which they read elements by places that are not known before, by name.
    """

    functions: tuple[ProgramFunction, ...]
    entries: tuple[str, ...]
    calls: tuple[str, ...]
    tables: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    def __contains__(self, name: object) -> bool:
        return any(f.name == name for f in self.functions)

    def arguments(self, name: str, texts: Mapping[str, str]) -> list[str]:
        """The arguments of a call of a function, in its order, from texts by its own names."""
        function = next(f for f in self.functions if f.name == name)
        return [texts[argument.name] for argument in function.arguments]


def name_of(expression: Expression) -> str:
    """The name of a variable, of an array, or of an element's array; "" for anything else."""
    if isinstance(expression, Name | Array):
        return expression.name
    return expression.array if isinstance(expression, Item) else ""


def leaves(expression: Expression) -> list[Expression]:
    """An expression and all that it is made of."""
    return [expression, *(leaf for part in parts(expression) for leaf in leaves(part))]


def parts(expression: Expression) -> tuple[Expression, ...]:  # noqa: PLR0911 - one case a line
    """What an expression is made of."""
    match expression:
        case Item(index=index):
            return (index,)
        case Unary(operand=operand):
            return (operand,)
        case Binary(left=left, right=right) | Compare(left=left, right=right):
            return (left, right)
        case Joined(parts=joined):
            return joined
        case Conditional(test=test, yes=yes, no=no):
            return (test, yes, no)
        case Call(arguments=arguments):
            return arguments
        case Array(offset=offset) if not isinstance(offset, Number):
            return (offset,)
    return ()


def statements(body: Sequence[Statement]) -> Iterator[Statement]:
    """The statements of a block, and those inside of them."""
    for statement in body:
        yield statement
        for block in blocks(statement):
            yield from statements(block)


def expressions(body: Sequence[Statement]) -> Iterator[Expression]:
    """All expressions of a block, and all that they are made of."""
    for statement in statements(body):
        for expression in direct_expressions(statement):
            yield from leaves(expression)


def read_names(function: ProgramFunction) -> set[str]:
    """The variables that a function reads, and the arrays that it reads or writes."""
    names: set[str] = set()
    for statement in statements(function.body):
        for expression in direct_expressions(statement):
            assigned = any(expression is target for target in targets(statement))
            if not (assigned and isinstance(expression, Name)):
                names |= {name_of(leaf) for leaf in leaves(expression)}
    return names - {""}


def targets(statement: Statement) -> tuple[Name | Item, ...]:
    """What a statement gives values to."""
    match statement:
        case Assign(target=target):
            return (target,)
        case Unpack(targets=several):
            return tuple(target for target in several if target is not None)
    return ()


def direct_expressions(statement: Statement) -> tuple[Expression, ...]:
    """The expressions of a statement itself."""
    match statement:
        case Assign(value=value) | Unpack(value=value):
            return (*targets(statement), value)
        case If(test=test) | WhileLoop(test=test):
            return (test,)
        case CountLoop(end=end, first=first):
            return (first, end)
        case Return(value=value, more=more):
            return () if value is None else (value, *more)
    return ()


def blocks(statement: Statement) -> tuple[tuple[Statement, ...], ...]:
    """The blocks inside a statement."""
    match statement:
        case If(then=then, otherwise=otherwise):
            return (then, otherwise)
        case CountLoop(body=body) | WhileLoop(body=body):
            return (body,)
    return ()
