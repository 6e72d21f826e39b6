"""C99 for a controller: a header, a source, and a self-test that checks itself and returns 0.

No allocation, no library but that of <math.h>, a struct for the state. The functions of law and
compensator are translated from their Python; see `law_program`.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence
from typing import ClassVar

from ...compensate.compensator import SETTINGS, Compensator
from ...errors import InputError
from ...friction import LOADS
from ..model import Model
from .c_selftest import comment, harmless, selftest
from .check_vectors import check_vectors
from .dialect import SUM, Dialect
from .function_source import FunctionSource
from .law_program import law_program
from .lowering import Restrictions, divides, lowered
from .program import (
    MATH_FUNCTIONS,
    Array,
    Call,
    Expression,
    Item,
    Kind,
    Name,
    Program,
    ProgramFunction,
    read_names,
)
from .translation import translate

#: C's own words, and C++'s, which a variable may not be called.
_WORDS = frozenset(
    """
    auto break case char const continue default do double else enum extern float for goto if
    inline int long register restrict return short signed sizeof static struct switch typedef
    union unsigned void volatile while bool class delete new namespace operator private public
    template this throw try using virtual and or not xor
    fabs sqrt exp expm1 log log1p sin cos tanh copysign pow rint
    """.split()  # noqa: SIM905 - a list of words is read as a text
)


class C(Dialect):
    """C99."""

    words: ClassVar[dict[str, str]] = {"and": "&&", "or": "||", "//": "/"}

    def __init__(self, prefix: str = "law_") -> None:
        self.prefix = prefix  # of the names of its functions

    def name(self, name: str) -> str:
        """A variable; C's own words get an underscore."""
        return f"{name}_" if name in _WORDS else name

    def ternary(self, test: Expression, yes: Expression, no: Expression) -> str:
        """One of two values."""
        return f"{self.write(test, 1)} ? {self.write(yes, 1)} : {self.write(no, 0)}"

    def number(self, value: float, kind: Kind) -> str:
        """A number; <math.h> has names for those that are not finite."""
        if math.isfinite(value):
            return super().number(value, kind)
        return "NAN" if math.isnan(value) else "INFINITY" if value > 0.0 else "-INFINITY"

    def call(self, name: str, arguments: Sequence[Expression], results: Sequence[str] = ()) -> str:
        """A function of <math.h>, of `MIN_AND_MAX`, or of the law; where further results go."""
        values = ", ".join([*(self.write(argument) for argument in arguments), *results])
        if name == "real":
            return f"(double)({values})"
        if name in MATH_FUNCTIONS:
            return f"{_CALLED.get(name, name)}({values})"
        return f"{self.prefix}{name}({values})"

    def unpacked(self, targets: Sequence[Name | Item | None], value: Call) -> str:
        """The first result is the call's value; for the others it gets addresses."""
        first, *more = targets or (None,)
        addresses = [f"&{self.write(target)}" for target in more if target is not None]
        call = self.call(value.name, value.arguments, addresses)
        return f"(void){call}" if first is None else f"{self.write(first)} = {call}"

    def several_returned(self, values: Sequence[Expression]) -> list[str]:
        """The first one is the function's value."""
        further = [f"*{_RESULT}{i} = {self.write(x)};" for i, x in enumerate(values[1:], 2)]
        return [*further, *(self.return_lines(values[0]) if values else ["return;"])]

    def count_loop(self, name: str, first: Expression, end: Expression) -> tuple[str, str]:
        """A loop that counts."""
        i = self.name(name)
        begin, bound = self.write(first), self.write(end, SUM)
        return f"for ({i} = {begin}; {i} < {bound}; {i}++) {{", "}"

    def while_loop(self, test: Expression) -> tuple[str, str]:
        """A loop."""
        return f"while ({self.write(test)}) {{", "}"

    def if_words(self) -> tuple[str, str, str, str]:
        """If, else if, else and the end."""
        return "if ({}) {{", "}} else if ({}) {{", "} else {", "}"

    def function(self, f: ProgramFunction) -> str:
        """One function, for this file alone."""
        first, *more = (*(_TYPES[kind] for kind in f.results),) or ("void",)
        arguments = [self._argument(a) for a in f.arguments]
        arguments += [f"{kind} *{_RESULT}{i}" for i, kind in enumerate(more, 2)]
        lines = [f"/* {harmless(f.doc)} */"] if f.doc else []
        lines += [f"static {first} {self.prefix}{f.name}({', '.join(arguments)})", "{"]
        for kind in ("real", "whole", "truth"):
            names = [self.name(v.name) for v in f.variables if v.kind == kind]
            lines += [f"    {_TYPES[kind]} {', '.join(names)};"] if names else []
        unread = unread_arguments(f)
        lines += [f"    (void){self.name(a.name)};" for a in f.arguments if a.name in unread]
        return "\n".join([*lines, *self.block(f.body), "}", ""])

    def table(self, name: str, values: Sequence[float]) -> str:
        """Numbers that its functions read, for this file alone."""
        numbers = ", ".join(self.number(value, "real") for value in values)
        return f"static const double {self.name(name)}[] = {{{numbers}}};\n"

    def _argument(self, argument: Name | Array) -> str:
        name = self.name(argument.name)
        if isinstance(argument, Name):
            return f"{_TYPES[argument.kind]} {name}"
        return f"{'' if argument.written else 'const '}{_TYPES[argument.kind]} *{name}"


#: Functions of a program that <math.h> has not, or under another name.
_CALLED = {"abs": "fabs", "round": "rint", "min": "math_min", "max": "math_max"}
#: Where results go that are not a function's value, counted from 2.
_RESULT = "result_"
#: As Python has them, also where a value is no number: fmin and fmax would leave it out.
MIN_AND_MAX = {
    "min": """\
static double math_min(double a, double b)
{
    return b < a ? b : a;
}
""",
    "max": """\
static double math_max(double a, double b)
{
    return b > a ? b : a;
}
""",
}
_TYPES: dict[Kind, str] = {"real": "double", "whole": "int", "truth": "int"}


def unread_arguments(f: ProgramFunction) -> set[str]:
    """The arguments that a function does not look at."""
    return {a.name for a in f.arguments} - read_names(f)


def c(
    model: Model, name: str = "friction", compensator: Compensator | None = None
) -> dict[str, bytes]:
    """Header, source and self-test of a model.

    Args:
        model: What was identified.
        name: Of the files, and what all public names begin with.
        compensator: Its settings; full feed-forward from the reference's velocity by default.

    Raises:
        InputError: a name that C does not take, or a law that cannot be translated.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,40}", name) or name in _WORDS:
        raise InputError(
            f"name {name!r}: C takes letters, digits and _, beginning with a letter, up to 41"
        )
    settings = compensator or Compensator(feedback=False)
    source = _CFiles(model, name, settings)
    return {
        f"{name}.h": source.header().encode(),
        f"{name}.c": source.source().encode(),
        "selftest.c": selftest(model, name, check_vectors(model, settings)).encode(),
    }


def c_functions(
    entries: Sequence[FunctionSource],
    what: str,
    prefix: str,
    before: Sequence[FunctionSource] = (),
) -> str:
    """Functions in C, for one file alone, with all that they call.

    Args:
        entries: Where their Python is.
        what: Whose they are, for messages.
        prefix: What their names begin with.
        before: Functions that they may call by name.

    Raises:
        InputError: a source that says something that has no place in C.
    """
    program = translate(entries, what, before)
    if divides(program):
        program = lowered(program, Restrictions(joins=False, plain=False))
    dialect = C(prefix)
    text = [text for name, text in MIN_AND_MAX.items() if name in program.calls]
    text += [dialect.table(name, values) for name, values in program.tables.items()]
    lines = "\n".join([*text, *(dialect.function(f) for f in program.functions)]).split("\n")
    return "\n".join("\n".join(_wrapped(line)) for line in lines)


def _wrapped(line: str) -> list[str]:
    """A line as several, where it is long."""
    indent = line[: len(line) - len(line.lstrip())]
    return textwrap.wrap(
        line, 100, initial_indent="", subsequent_indent=f"{indent}    ", break_long_words=False,
        break_on_hyphens=False, drop_whitespace=True,
    ) or [""]  # fmt: skip


class _CFiles:
    """The three files of a model."""

    def __init__(self, model: Model, name: str, compensator: Compensator) -> None:
        self.model, self.name, self.compensator = model, name, compensator
        self.law = model.law
        self.loaded = bool(self.law.loads or self.law.terms)
        self.program: Program = law_program(model.law)
        if divides(self.program):  # C cuts towards 0 where Python takes the floor
            self.program = lowered(self.program, Restrictions(joins=False, plain=False))

    # --- the header

    def header(self) -> str:
        """Declarations, and all that the model says of itself."""
        n, law = self.name, self.law
        guard = f"{n.upper()}_H"
        parts = [
            comment(self.model.head()),
            f"#ifndef {guard}",
            f"#define {guard}",
            "",
            "#ifdef __cplusplus",
            'extern "C" {',
            "#endif",
            "",
            "/* Places of the parameters in p[], SI. */",
            self._places("", [(p, q.unit, q.doc) for p, q in self.model.named()], "PARAMETERS"),
        ]
        if self.loaded:
            reads = [*law.loads, *law.terms]
            parts += [
                f"/* Places in load[]: this law reads {', '.join(reads)}. Force of the drive and",
                "   of everything else on the axis, normal load, position, temperature (K). */",
                self._places("LOAD_", [(load, "", "") for load in LOADS], "LOADS"),
            ]
        parts += [
            "/* The law, and what it depends on. */",
            "typedef struct {",
            f"    double p[{n.upper()}_PARAMETERS]; /* the identified ones after init */",
        ]
        if self.loaded:
            parts.append(f"    double load[{n.upper()}_LOADS]; /* to be set before each call */")
        if law.states:
            parts.append(f"    double z[{law.states}]; /* states, 0 where bristles are relaxed */")
        parts += [
            f"}} {n}_law;",
            "",
            "/* The identified parameters, relaxed, without load. */",
            f"void {n}_init({n}_law *law);",
            "",
            (
                f"/* Friction of steady sliding at v, {self.model.speed_unit}, in "
                f"{self.model.force_unit}; at +0.0 and -0.0 the breakaway levels. */"
            ),
            f"double {n}_steady(const {n}_law *law, double v);",
            "",
            *self._force_doc(),
            f"double {n}_force({n}_law *law, double v, double h);",
            "",
            "/* Places of the compensator's settings in c[]. */",
            self._places(
                "",
                [
                    (s.name, s.rotary if self.model.rig.rotary else s.unit, s.meaning)
                    for s in SETTINGS
                ],
                "SETTINGS",
            ),
            "/* A compensator: what a controller adds to its command. */",
            "typedef struct {",
            f"    {n}_law law; /* its own copy, with states of its own */",
            f"    double c[{n.upper()}_SETTINGS]; /* settings: as exported after init */",
            "    double before; /* what it put out last */",
            f"}} {n}_compensator;",
            "",
            f"void {n}_compensator_init({n}_compensator *compensator);",
            "",
            "/* What to add to the command, once a sample of h seconds: v_ref is the velocity of",
            "   the reference, v the measured one (not read where feedback is 0). */",
            f"double {n}_compensate({n}_compensator *compensator,",
            "    double v_ref, double v, double h);",
            "",
            "#ifdef __cplusplus",
            "}",
            "#endif",
            "",
            f"#endif /* {guard} */",
            "",
        ]
        return "\n".join(parts)

    def _force_doc(self) -> list[str]:
        if self.law.states:
            return [
                "/* Friction at the end of h seconds passed at the velocity v; advances the states",
                "   exactly, or by a rule that is stable for any h. */",
            ]
        return ["/* Friction at the velocity v; this law has no states, so h is not read. */"]

    def _places(self, kind: str, named: Sequence[tuple[str, str, str]], count: str) -> str:
        prefix = f"{self.name.upper()}_"
        rows = [(f"{prefix}{kind}{n.upper() if kind else n},", u, d) for n, u, d in named]
        if not kind and count == "SETTINGS":
            rows = [(f"{prefix}{n.upper()},", u, d) for n, u, d in named]
        wide = max(len(r[0]) for r in rows)
        lines = ["enum {"]
        for i, (text, unit, doc) in enumerate(rows):
            comment = f"{doc}{f', {unit}' if unit else ''}"
            place = text.removesuffix(",") + (" = 0," if i == 0 else ",")
            lines.append(f"    {place.ljust(wide + 4)}" + (f" /* {comment} */" if comment else ""))
        return "\n".join(line.rstrip() for line in [*lines, f"    {prefix}{count}", "};", ""])

    # --- the source

    def source(self) -> str:
        """The functions."""
        n, dialect = self.name, C()
        bodies = [dialect.function(f) for f in self.program.functions]
        parts = [
            comment(
                [f"The functions of {n}.h, translated from those of the library that made them."]
            ),
            f'#include "{n}.h"',
            "",
            "#include <math.h>",
            "",
            *(text for name, text in MIN_AND_MAX.items() if name in self.program.calls),
            *(dialect.table(name, values) for name, values in self.program.tables.items()),
            *bodies,
            f"void {n}_init({n}_law *law)",
            "{",
            *self._cleared(),
            *(
                f"    law->p[{n.upper()}_{name}] = {value!r};"
                for (name, _), value in zip(self.model.named(), self.model.p.tolist(), strict=True)
            ),
            "}",
            "",
            f"double {n}_steady(const {n}_law *law, double v)",
            "{",
            f"    return {self._scaled(self._call('steady', 'law->', v='v'))};",
            "}",
            "",
            f"double {n}_force({n}_law *law, double v, double h)",
            "{",
            *self._force(),
            "}",
            "",
            f"void {n}_compensator_init({n}_compensator *compensator)",
            "{",
            f"    {n}_init(&compensator->law);",
            *(
                f"    compensator->c[{n.upper()}_{s.name.upper()}] = {value!r};"
                for s, value in zip(SETTINGS, self.compensator.c.tolist(), strict=True)
            ),
            "    compensator->before = 0.0;",
            "}",
            "",
            f"double {n}_compensate({n}_compensator *compensator,",
            "    double v_ref, double v, double h)",
            "{",
            *self._compensate(),
            "}",
            "",
        ]
        return "\n".join(parts)

    def _cleared(self) -> list[str]:
        lines = []
        if self.loaded or self.law.states:
            lines.append("    int i;")
        if self.loaded:
            lines.append(f"    for (i = 0; i < {self.name.upper()}_LOADS; i++) {{")
            lines += ["        law->load[i] = 0.0;", "    }"]
        if self.law.states:
            lines.append(f"    for (i = 0; i < {self.law.states}; i++) {{")
            lines += ["        law->z[i] = 0.0;", "    }"]
        return lines

    def _scaled(self, text: str) -> str:
        return f"{self._call('factor', 'law->')} * {text}" if self.law.terms else text

    def _call(self, name: str, law: str, **texts: str) -> str:
        """A call of a function of the program; `law` is what stands before a law's members."""
        members = {array: f"{law}{array}" for array in ("p", "z", "load")}
        texts = {"out": "out", "c": "compensator->c", **members, **texts}
        return f"law_{name}({', '.join(self.program.arguments(name, texts))})"

    def _kept(self, law: str) -> list[str]:
        """The states after a span become those of the struct."""
        return [
            f"    for (i = 0; i < {self.law.states}; i++) {{",
            f"        {law}z[i] = out[i];",
            "    }",
        ]

    def _force(self) -> list[str]:
        law = self.law
        name = "steady" if law.rub is None else "rubbed"
        force = self._scaled(self._call(name, "law->", v="v", h="h"))
        if not law.states:
            return ["    (void)h;", f"    return {force};"]
        return [
            f"    double out[{law.states}], F;",
            "    int i;",
            f"    F = {force};",
            *self._kept("law->"),
            "    return F;",
        ]

    def _compensate(self) -> list[str]:
        texts = {"v_ref": "v_ref", "v": "v", "h": "h", "before": "compensator->before"}
        if self.law.terms:
            texts["factor"] = self._call("factor", "compensator->law.")
        output = self._call("compensator_output", "compensator->law.", **texts)
        lines = [f"    compensator->before = {output};"]
        if self.law.states:
            head = [f"    double out[{self.law.states}];", "    int i;"]
            lines = [*head, *lines, *self._kept("compensator->law.")]
        return [*lines, "    return compensator->before;"]
