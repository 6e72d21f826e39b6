"""Reads the part of Structured Text (IEC 61131-3) that is exported, into a tree.

Shares nothing with what writes the text. A recursive descent, as a full grammar takes seconds a
text; that the two read the same is tested with blark.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

_RESERVED = frozenset(
    """
    if then elsif else end_if for to by do end_for while end_while repeat until of at on or and xor
    not mod exit return case function function_block end_function end_function_block program var
    var_input var_output var_in_out end_var constant array string bool int dint lint sint uint real
    lreal time date byte word dword lword true false type struct limit sel mux min max len left
    right mid concat insert delete replace find abs sqrt ln log exp sin cos tan asin acos atan add
    mul sub div expt move gt ge eq le lt ne shl shr rol ror trunc tp ton tof sr rs ctu ctd ctud with
    step action task interval priority configuration resource transition pointer reference ref
    """.split()  # noqa: SIM905 - a list of words is read as a text
)
#: Standard functions: reserved as names of variables, called like any other.
STANDARD = frozenset({"abs", "sqrt", "exp", "ln", "sin", "cos", "min", "max", "expt"})
_SECTIONS = {"var_input": "input", "var_in_out": "in_out", "var_output": "output", "var": "own"}
_TOKEN = re.compile(
    r"""\s+ | \(\*.*?\*\)
    | (?P<real> (?:LREAL\#-?)? \d+ (?:_\d+)* \. \d+ (?:_\d+)* (?:[Ee][+-]?\d+)? )
    | (?P<whole> \d+ (?:_\d+)* (?![\w#]|\.\d) )
    | (?P<word> [A-Za-z_]\w* )
    | (?P<sign> := | \.\. | <> | <= | >= | [-+*/<>=()\[\];:,.] )""",
    re.VERBOSE | re.DOTALL | re.ASCII,
)
#: Binary operators from the loosest to the tightest; those of a line bind alike, from the left.
_LEVELS = (("or",), ("and",), ("=", "<>"), ("<", "<=", ">", ">="), ("+", "-"), ("*", "/"))


class IecError(Exception):
    """What a compiler would refuse, or a controller would stop at."""


# --- the tree: names are in small letters, as the language does not tell them apart


class Number(NamedTuple):
    value: float | int


class Truth(NamedTuple):
    value: bool


class Name(NamedTuple):
    name: str


class Element(NamedTuple):
    """An element of an array."""

    name: str
    subscript: Expression


class Output(NamedTuple):
    """An output of an instance of a function block."""

    name: str
    output: str


class Unary(NamedTuple):
    operator: str
    operand: Expression


class Binary(NamedTuple):
    operator: str
    left: Expression
    right: Expression


class Call(NamedTuple):
    """A call of a function, or, as a statement, of an instance; names may lack in a function's."""

    name: str
    arguments: tuple[tuple[str | None, Expression], ...]


Expression = Number | Truth | Name | Element | Output | Unary | Binary | Call


class Assignment(NamedTuple):
    target: Name | Element
    value: Expression


class If(NamedTuple):
    branches: tuple[tuple[Expression, Body], ...]
    otherwise: Body


class For(NamedTuple):
    counter: str
    first: Expression
    last: Expression
    step: Expression
    body: Body


class While(NamedTuple):
    condition: Expression
    body: Body


class Return(NamedTuple):
    pass


Statement = Assignment | If | For | While | Return | Call
Body = tuple[Statement, ...]


class Variable(NamedTuple):
    """A declaration.

    Args:
        name: As it is written.
        kind: LREAL, DINT, BOOL, or the name of a function block.
        length: Of an array.
        initial: Its value at the start.
        section: input, in_out, output or own.
    """

    name: str
    kind: str
    length: int | None
    initial: Expression | None
    section: str


class Unit(NamedTuple):
    """A function, or a function block, which has no result."""

    name: str
    result: str | None
    variables: tuple[Variable, ...]
    body: Body


def parsed(text: str) -> tuple[Unit, ...]:
    """The units of a text.

    Raises:
        IecError: The text is not of the part of the language that is known here.
    """
    units = re.split(r"(?<=^END_FUNCTION\n)|(?<=^END_FUNCTION_BLOCK\n)", text, flags=re.MULTILINE)
    return tuple(unit for part in units for unit in _parsed(part))


@cache  # most units are in many texts
def _parsed(text: str) -> tuple[Unit, ...]:
    return tuple(_Parser(text).units())


def number(text: str, *, double: bool) -> float:
    """A literal's value; without a type it is a REAL."""
    value = float(text.replace("_", ""))
    return value if double else float(struct.unpack("<f", struct.pack("<f", value))[0])


def identifier(name: str) -> str:
    """A name that may be declared."""
    if not re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name) or name.lower() in _RESERVED:
        raise IecError(f"{name} is no identifier")
    return name


class _Parser:
    def __init__(self, text: str) -> None:
        self._tokens, self._at = [*_tokens(text), ("end", "")], 0

    # --- tokens

    @property
    def _word(self) -> str:
        """The token at hand, in small letters."""
        return self._tokens[self._at][1].lower()

    def _next(self, kind: str) -> str:
        token_kind, text = self._tokens[self._at]
        if token_kind != kind:
            raise IecError(f"{text!r} is no {kind}")
        self._at += 1
        return text

    def _accept(self, *words: str) -> str | None:
        word = self._word
        if word not in words:
            return None
        self._at += 1
        return word

    def _expect(self, *words: str) -> None:
        for word in words:
            if self._accept(word) is None:
                raise IecError(f"{self._word!r} stands where {word!r} should")

    # --- declarations

    def units(self) -> Iterator[Unit]:
        while word := self._accept("function", "function_block"):
            name, result = identifier(self._next("word")), None
            if word == "function":
                self._expect(":")
                result = self._next("word")
            variables = tuple(self._variables())
            yield Unit(name, result, variables, self._body(f"end_{word}"))
            self._expect(f"end_{word}")
        self._next("end")

    def _variables(self) -> Iterator[Variable]:
        while section := self._accept(*_SECTIONS):
            while not self._accept("end_var"):
                name, length, initial = identifier(self._next("word")), None, None
                self._expect(":")
                if self._accept("array"):
                    self._expect("[", "0", "..")
                    length = int(self._next("whole")) + 1
                    self._expect("]", "of")
                kind = self._next("word")
                if length is None and self._accept(":="):
                    initial = self._expression()
                self._expect(";")
                yield Variable(name, kind, length, initial, _SECTIONS[section])

    # --- statements

    def _body(self, *ends: str) -> Body:
        """The statements up to a word."""
        statements = []
        while self._word not in ends:
            statements.append(self._statement())
            self._expect(";")
        return tuple(statements)

    def _statement(self) -> Statement:
        match self._accept("if", "for", "while", "return"):
            case "if":
                return self._if()
            case "for":
                return self._for()
            case "while":
                condition = self._expression()
                self._expect("do")
                body = self._body("end_while")
                self._expect("end_while")
                return While(condition, body)
            case "return":
                return Return()
        target = self._variable()
        if isinstance(target, Call):
            return target
        self._expect(":=")
        if isinstance(target, Output):
            raise IecError(f"{target.name}.{target.output} is assigned to")
        return Assignment(target, self._expression())

    def _if(self) -> If:
        branches, otherwise, another_branch = [], Body(), True
        while another_branch:
            condition = self._expression()
            self._expect("then")
            branches.append((condition, self._body("elsif", "else", "end_if")))
            another_branch = self._accept("elsif") is not None
        if self._accept("else"):
            otherwise = self._body("end_if")
        self._expect("end_if")
        return If(tuple(branches), otherwise)

    def _for(self) -> For:
        counter = self._next("word").lower()
        self._expect(":=")
        first = self._expression()
        self._expect("to")
        last = self._expression()
        step = self._expression() if self._accept("by") else Number(1)
        self._expect("do")
        body = self._body("end_for")
        self._expect("end_for")
        return For(counter, first, last, step, body)

    # --- expressions

    def _expression(self, level: int = 0) -> Expression:
        if level == len(_LEVELS):
            return self._unary()
        left = self._expression(level + 1)
        while operator := self._accept(*_LEVELS[level]):
            left = Binary(operator, left, self._expression(level + 1))
        return left

    def _unary(self) -> Expression:
        operator = self._accept("-", "not")
        return self._primary() if operator is None else Unary(operator, self._primary())

    def _primary(self) -> Expression:
        kind, text = self._tokens[self._at]
        match kind:
            case "real":
                self._at += 1
                typed = text.upper().startswith("LREAL#")
                return Number(number(text.removeprefix("LREAL#"), double=typed))
            case "whole":
                self._at += 1
                return Number(int(text.replace("_", "")))
        if self._accept("("):
            inner = self._expression()
            self._expect(")")
            return inner
        if truth := self._accept("true", "false"):
            return Truth(truth == "true")
        return self._variable()

    def _variable(self) -> Name | Element | Output | Call:
        name = self._next("word").lower()
        if self._accept("["):
            index = self._expression()
            self._expect("]")
            return Element(name, index)
        if self._accept("."):
            return Output(name, self._next("word").lower())
        if self._accept("("):
            return Call(name, tuple(self._arguments()))
        if name in _RESERVED:
            raise IecError(f"{name} is no variable")
        return Name(name)

    def _arguments(self) -> Iterator[tuple[str | None, Expression]]:
        if self._accept(")"):
            return
        while True:
            name = None
            if self._tokens[self._at + 1][1] == ":=":
                name = self._next("word").lower()
                self._expect(":=")
            yield name, self._expression()
            if self._accept(")"):
                return
            self._expect(",")


def _tokens(text: str) -> Iterator[tuple[str, str]]:
    at = 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise IecError(f"{text[at : at + 20]!r} is not of the language")
        if match.lastgroup is not None:
            yield match.lastgroup, match[0]
        at = match.end()
