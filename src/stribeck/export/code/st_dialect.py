"""How IEC 61131-3 Structured Text writes expressions and statements, and its mathematics.

The language has no zero with a sign: `copysign(x, v)` takes + for v == 0. It has no conditional
expression, its AND and OR may evaluate all their parts, and INT / INT cuts towards 0: programs
are lowered first. Its functions are known by name in a whole project, so each begins with the
name that the user gave.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from .dialect import ATOM, CHOICE, SUM, Dialect
from .program import Expression, Kind, Number

#: Keywords, types, standard functions and standard function blocks (IEC 61131-3:2013, tables of
#: clause 6), and operators that CODESYS, TwinCAT and SCL add.
WORDS = frozenset(
    """
    ABSTRACT ACTION AND AND_THEN ANY ARRAY AT BEGIN BOOL BY BYTE CASE CHAR CLASS CONFIGURATION
    CONSTANT CONTINUE DATE DATE_AND_TIME DATA_BLOCK DINT DO DT DWORD ELSE ELSIF EN END_ACTION
    END_CASE END_CLASS END_CONFIGURATION END_FOR END_FUNCTION END_FUNCTION_BLOCK END_IF
    END_INTERFACE END_METHOD END_NAMESPACE END_PROGRAM END_PROPERTY END_REPEAT END_RESOURCE
    END_STEP END_STRUCT END_TRANSITION END_TYPE END_UNION END_VAR END_WHILE ENO EXIT EXTENDS
    FALSE FINAL FOR FROM FUNCTION FUNCTION_BLOCK FUNCTIONBLOCK F_EDGE GOTO IF IMPLEMENTATION
    IMPLEMENTS INI INITIAL_STEP INT INTERFACE INTERNAL INTERVAL JMP LABEL LDATE LDT LINT LREAL LT
    LTIME LTOD LWORD METHOD MOD NAMESPACE NON_RETAIN NOT NULL OF ON OR OR_ELSE OVERLAP OVERRIDE
    ORGANIZATION_BLOCK PERSISTENT POINTER PRIORITY PRIVATE PROGRAM PROPERTY PROTECTED PUBLIC
    READ_ONLY READ_WRITE REAL REF REFERENCE REF_TO REGION REPEAT RESOURCE RETAIN RETURN R_EDGE
    SINGLE SINT STEP STRING STRUCT SUPER TASK THEN THIS TIME TIME_OF_DAY TITLE TO TOD TRANSITION
    TRUE TYPE UDINT UINT ULINT UNION UNTIL USING USINT VAR VAR_ACCESS VAR_CONFIG VAR_EXTERNAL
    VAR_GLOBAL VAR_INPUT VAR_INST VAR_IN_OUT VAR_OUTPUT VAR_STAT VAR_TEMP VERSION WCHAR WHILE WITH
    WORD WSTRING XOR ANY_BIT ANY_CHAR ANY_DATE ANY_DERIVED ANY_ELEMENTARY ANY_INT ANY_MAGNITUDE
    ANY_NUM ANY_REAL ANY_STRING ANY_UNSIGNED ANY_SIGNED ANY_DURATION
    ABS ACOS ADD ADD_TIME ADR ASIN ASSERT ATAN ATAN2 BITADR CEIL CONCAT COS CTD CTU CTUD DELETE DIV
    DIV_TIME EQ EXP EXPT FIND FLOOR FRAC F_TRIG GE GT INDEXOF INSERT LE LEFT LEN LIMIT LN LOG
    LOWER_BOUND MAX MID MIN MOVE MUL MUL_TIME MUX NE NEG NORM_X REPLACE RIGHT ROL ROR ROUND RS
    R_TRIG SCALE_X SEL SHL SHR SIGN SIN SIZEOF SQR SQRT SR SUB SUB_TIME TAN TOF TON TP TRUNC
    UPPER_BOUND CAL CALC CALCN LD LDN RET RETC RETCN ST STN ANDN ORN XORN
    """.split()  # noqa: SIM905 - a list of words is read as a text
)
#: Functions of a program that the language has itself. min and max take two.
OWN = {
    "abs": "ABS", "sqrt": "SQRT", "exp": "EXP", "log": "LN", "sin": "SIN", "cos": "COS",
    "min": "MIN", "max": "MAX", "real": "DINT_TO_LREAL",
}  # fmt: skip
TYPES: Mapping[Kind, str] = {"real": "LREAL", "whole": "DINT", "truth": "BOOL"}


class ST(Dialect):
    """Structured Text.

    Args:
        result: What a function's value is assigned to: its name.
        called: The functions that may be called: their names and those of their arguments.
    """

    becomes: ClassVar[str] = ":="
    true: ClassVar[str] = "TRUE"
    false: ClassVar[str] = "FALSE"
    negation: ClassVar[str] = "NOT "
    words: ClassVar[dict[str, str]] = {
        "and": "AND", "or": "OR", "==": "=", "!=": "<>", "//": "/",
    }  # fmt: skip

    def __init__(self, result: str, called: Mapping[str, tuple[str, Sequence[str]]]) -> None:
        self._result, self._called = result, called

    def number(self, value: float, kind: Kind) -> str:
        """A number, to its last bit: marked as LREAL where a REAL would round it."""
        text = super().number(value, kind)
        if kind == "whole":
            return text
        mantissa, e, exponent = text.partition("e")
        if e:
            text = f"{mantissa if '.' in mantissa else f'{mantissa}.0'}E{int(exponent)}"
        return text if _single(value) else f"LREAL#{text}"

    def operand(self, expression: Expression, kind: Kind, above: int) -> str:
        """One side of an operation: what has a minus sign stands in brackets behind another."""
        del kind
        text = self.write(expression, above)
        signed = text.startswith("-") or (isinstance(expression, Number) and expression.value < 0)
        return f"({text})" if signed and SUM < above < ATOM else text

    def call(self, name: str, arguments: Sequence[Expression]) -> str:
        """A function; more than one argument are named, as some controllers will have it."""
        values = [self.write(argument) for argument in arguments]
        if name in OWN:
            return f"{OWN[name]}({', '.join(values)})"
        full, names = self._called[name]
        if len(values) > 1:
            values = [f"{a} := {v}" for a, v in zip(names, values, strict=True)]
        return f"{full}({', '.join(values)})"

    def return_lines(self, value: Expression) -> list[str]:
        """The function's name gets its value."""
        return [f"{self._result} := {self.write(value)};", "RETURN;"]

    def count_loop(self, name: str, first: Expression, end: Expression) -> tuple[str, str]:
        """A loop that counts."""
        return f"FOR {name} := {self.write(first)} TO {self.last(end)} DO", "END_FOR;"

    def while_loop(self, test: Expression) -> tuple[str, str]:
        """A loop."""
        return f"WHILE {self.write(test, CHOICE)} DO", "END_WHILE;"

    def if_words(self) -> tuple[str, str, str, str]:
        """If, else if, else and the end."""
        return "IF {} THEN", "ELSIF {} THEN", "ELSE", "END_IF;"


def _single(value: float) -> bool:
    """Whether a number is the same in single precision."""
    try:
        return bool(struct.unpack("<f", struct.pack("<f", value))[0] == value)
    except OverflowError:
        return False


@dataclass(frozen=True)
class Helper:
    """A function of the mathematics that the language lacks.

    Args:
        arguments: Their names.
        says: What it gives.
        variables: Of its own, with their types.
        body: Lines; {f} stands for its own name, {log} and others for names of those it needs.
        needs: Which others.
    """

    arguments: tuple[str, ...]
    says: str
    variables: tuple[tuple[str, str], ...]
    body: str
    needs: tuple[str, ...] = ()


HELPERS: Mapping[str, Helper] = {
    "copysign": Helper(
        ("x", "v"),
        "ABS(x) with the sign of v; 0.0 has the sign +",
        (),
        """\
IF v < 0.0 THEN
    {f} := -ABS(x);
ELSE
    {f} := ABS(x);
END_IF;""",
    ),
    "expm1": Helper(
        ("x",),
        "EXP(x) - 1.0, near 0.0 by its series: nothing cancels",
        (("i", "DINT"), ("total", "LREAL")),
        """\
IF ABS(x) < 0.5 THEN
    total := 1.0;
    FOR i := 17 TO 2 BY -1 DO
        total := 1.0 + x * total / DINT_TO_LREAL(i);
    END_FOR;
    {f} := x * total;
ELSE
    {f} := EXP(x) - 1.0;
END_IF;""",
    ),
    "log1p": Helper(
        ("x",),
        "LN(1.0 + x), near 0.0 as 2 artanh(x / (2 + x)) by its series",
        (("i", "DINT"), ("share", "LREAL"), ("total", "LREAL")),
        """\
IF ABS(x) < 0.25 THEN
    share := x / (2.0 + x);
    total := 1.0 / 23.0;
    FOR i := 10 TO 1 BY -1 DO
        total := total * share * share + 1.0 / DINT_TO_LREAL(2 * i + 1);
    END_FOR;
    {f} := 2.0 * (share + share * share * share * total);
ELSE
    {f} := LN(1.0 + x);
END_IF;""",
    ),
    "tanh": Helper(
        ("x",),
        "hyperbolic tangent",
        (("grown", "LREAL"),),
        """\
IF x > 20.0 THEN
    {f} := 1.0;
ELSIF x < -20.0 THEN
    {f} := -1.0;
ELSE
    grown := {expm1}(2.0 * x);
    {f} := grown / (grown + 2.0);
END_IF;""",
        ("expm1",),
    ),
    "pow": Helper(
        ("x", "exponent"),
        "EXPT(x, exponent), for x = 0.0, too, where a controller may take its logarithm",
        (),
        """\
IF exponent = 0.0 THEN
    {f} := 1.0;
ELSIF x = 0.0 THEN
    {f} := 0.0;
ELSE
    {f} := EXPT(x, exponent);
END_IF;""",
    ),
}


def needed(calls: Iterable[str]) -> list[str]:
    """The helpers that a program calls, each after those that it needs."""
    helpers: dict[str, None] = {}
    for name in calls:
        if name in HELPERS:
            helpers |= dict.fromkeys((*HELPERS[name].needs, name))
    return list(helpers)
