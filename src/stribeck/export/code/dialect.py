"""The base of all languages: how expressions and statements are written."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import ClassVar

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
    Return,
    Statement,
    Truth,
    Unary,
    Unpack,
    WhileLoop,
)

#: How tightly operations bind, the loosest first.
CHOICE, OR, AND, NOT, COMPARE, SUM, PRODUCT, SIGN, ATOM = range(9)
_LEVELS = {"+": SUM, "-": SUM, "*": PRODUCT, "/": PRODUCT, "//": PRODUCT, "%": PRODUCT}


class Dialect(ABC):
    """A language. The words are class variables, what they are put together as are methods."""

    indent: ClassVar[str] = "    "
    #: What ends a statement.
    end: ClassVar[str] = ";"
    becomes: ClassVar[str] = "="
    true: ClassVar[str] = "1"
    false: ClassVar[str] = "0"
    negation: ClassVar[str] = "!"
    #: `and`, `or`, comparisons and operations, where they are not Python's.
    words: ClassVar[dict[str, str]] = {}
    #: Whether one `and` inside an `or` is put in brackets.
    cautious: ClassVar[bool] = True

    # --- expressions

    def write(self, expression: Expression, surrounding: int = CHOICE) -> str:
        """An expression, in brackets where it binds more loosely than what is around it."""
        text, level = self._written(expression)
        return f"({text})" if level < surrounding else text

    def _written(  # noqa: C901, PLR0911 - one case a line
        self, expression: Expression
    ) -> tuple[str, int]:
        match expression:
            case Number(value=value, kind=kind):
                return self.number(value, kind), SIGN if _below_zero(value) else ATOM
            case Truth(value=value):
                return self.true if value else self.false, ATOM
            case Array(name=name, offset=offset) if expression.begin != 0:
                return f"{self.name(name)} + {self.write(offset, SUM)}", SUM
            case Name(name=name) | Array(name=name):
                return self.name(name), ATOM
            case Item(array=array, index=index):
                return self.item(array, index), ATOM
            case Unary(sign="-", operand=operand):
                return f"-{self.write(operand, ATOM)}", SIGN
            case Unary(operand=operand):
                return f"{self.negation}{self.write(operand, ATOM)}", NOT
            case Binary(sign=sign, left=left, right=right):
                return self._by_two(sign, left, right, expression.kind), _LEVELS[sign]
            case Compare(sign=sign, left=left, right=right):
                word = self.words.get(sign, sign)
                return f"{self.write(left, SUM)} {word} {self.write(right, SUM)}", COMPARE
            case Joined(sign=sign, parts=parts):
                level = AND if sign == "and" else OR
                tight = COMPARE if self.cautious else level + 1
                word = self.words.get(sign, sign)
                return f" {word} ".join(self.write(p, tight) for p in parts), level
            case Conditional(test=test, yes=yes, no=no):
                return self.ternary(test, yes, no), CHOICE
            case Call(name=name, arguments=arguments):
                return self.call(name, arguments), ATOM

    def _by_two(self, sign: str, left: Expression, right: Expression, kind: Kind) -> str:
        level = _LEVELS[sign]
        a, b = self.operand(left, kind, level), self.operand(right, kind, level + 1)
        return f"{a} {self.words.get(sign, sign)} {b}"

    def operand(self, expression: Expression, kind: Kind, surrounding: int) -> str:
        """One side of an operation on values of a kind."""
        del kind
        return self.write(expression, surrounding)

    def number(self, value: float, kind: Kind) -> str:
        """A number, to its last bit."""
        if kind == "whole":
            return str(int(value))
        if not math.isfinite(value):
            raise InputError(f"{value} cannot be written down: set it to a finite number")
        return repr(float(value))

    def name(self, name: str) -> str:
        """A variable."""
        return name

    def item(self, array: str, index: Expression) -> str:
        """An element of an array."""
        return f"{self.name(array)}[{self.write(index)}]"

    def from_one(self, index: Expression) -> str:
        """An index where arrays count from 1."""
        if isinstance(index, Number):
            return str(int(index.value) + 1)
        return self.write(Binary("+", index, Number(1, "whole"), "whole"))

    def ternary(self, test: Expression, yes: Expression, no: Expression) -> str:
        """One of two values."""
        del test, yes, no
        raise InputError(f"{type(self).__name__} has no conditional expression")

    def call(self, name: str, arguments: Sequence[Expression]) -> str:
        """A function of the mathematics or of the program."""
        return f"{name}({', '.join(self.write(argument) for argument in arguments)})"

    # --- statements

    def block(self, body: Iterable[Statement], depth: int = 1) -> list[str]:
        """The lines of a block."""
        return [line for statement in body for line in self._statement(statement, depth)]

    def _statement(  # noqa: PLR0911 - one case a line
        self, statement: Statement, depth: int
    ) -> list[str]:
        pad = self.indent * depth
        match statement:
            case Assign(target=target, value=value):
                written = value.written if isinstance(value, Call) else ()
                targets = self.assigned_targets(target, [self.name(a.name) for a in written])
                return [
                    f"{pad}{targets} {self.becomes} {self.assigned_value(target, value)}{self.end}"
                ]
            case Unpack(targets=targets, value=value):
                return [f"{pad}{self.unpacked(targets, value)}{self.end}"]
            case Jump(word=word):
                return [f"{pad}{word}{self.end}"]
            case Return(value=value, more=()) if value is not None:
                return [pad + line for line in self.return_lines(value)]
            case Return(value=value, more=more):
                values = more if value is None else (value, *more)
                return [pad + line for line in self.several_returned(values)]
            case If():
                return self._if(statement, depth)
            case CountLoop(name=name, end=end, body=body, first=first):
                head, tail = self.count_loop(name, first, end)
                return [pad + head, *self.block(body, depth + 1), *([pad + tail] if tail else [])]
            case WhileLoop(test=test, body=body):
                head, tail = self.while_loop(test)
                return [pad + head, *self.block(body, depth + 1), *([pad + tail] if tail else [])]

    def _if(self, statement: If, depth: int) -> list[str]:
        pad = self.indent * depth
        begin, otherwise_if, otherwise, finish = self.if_words()
        lines = [
            pad + begin.format(self.write(statement.test)),
            *self.block(statement.then, depth + 1),
        ]
        rest = statement.otherwise
        while len(rest) == 1 and isinstance(rest[0], If):
            lines += [pad + otherwise_if.format(self.write(rest[0].test))]
            lines += self.block(rest[0].then, depth + 1)
            rest = rest[0].otherwise
        if rest:
            lines += [pad + otherwise, *self.block(rest, depth + 1)]
        return [*lines, pad + finish] if finish else lines

    def assigned_targets(self, target: Name | Item, written: Sequence[str]) -> str:
        """The left side of an assignment of a call that writes into arrays, or of any other."""
        del written
        return self.write(target)

    def assigned_value(self, target: Name | Item, value: Expression) -> str:
        """The right side of an assignment."""
        return self.operand(value, target.kind, CHOICE)

    def unpacked(self, targets: Sequence[Name | Item | None], value: Call) -> str:
        """A call for its results, or what it writes; in languages that `lowered` lets say it."""
        del targets
        raise InputError(f"{type(self).__name__} has no call of {value.name} for several results")

    def several_returned(self, values: Sequence[Expression]) -> list[str]:
        """How a function gives back several values, or none; likewise."""
        raise InputError(f"{type(self).__name__} has no function of {len(values)} results")

    def return_lines(self, value: Expression) -> list[str]:
        """How a function gives back its value."""
        return [f"return {self.write(value)}{self.end}"]

    @abstractmethod
    def count_loop(self, name: str, first: Expression, end: Expression) -> tuple[str, str]:
        """The first and the last line ("" for none) of a loop up to one below the end."""

    def last(self, end: Expression) -> str:
        """The last number that such a loop counts to."""
        if isinstance(end, Number):
            return str(int(end.value) - 1)
        return f"{self.write(end, SIGN)} - 1"

    @abstractmethod
    def while_loop(self, test: Expression) -> tuple[str, str]:
        """The first and the last line ("" for none) of a loop as long as a truth holds."""

    @abstractmethod
    def if_words(self) -> tuple[str, str, str, str]:
        """If, else if, else and the end, "" where a block has none; {} stands for the truth."""


def _below_zero(value: float) -> bool:
    return math.copysign(1.0, value) < 0
