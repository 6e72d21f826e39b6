"""MATLAB and GNU Octave: the law as a function of its states, and a function that compensates.

Two files of plain functions without persistent variables: what has to be remembered is handed in
and handed back, so they run in scripts, in a simulation's MATLAB Function blocks, and generate
code.
"""

from __future__ import annotations

import re

from ...compensate.compensator import SETTINGS, Compensator
from ...errors import InputError
from ...friction import LOADS
from ..model import Model, folded
from .ascii_text import ascii_text
from .identifiers import Identifiers
from .law_program import law_program
from .lowering import Restrictions, lowered
from .matlab_dialect import COPYSIGN, WORDS, function_text
from .program import Program

#: Variables of the two functions, which would hide a law of their name.
_VARIABLES = {"F", "z", "p", "v", "h", "load", "u", "s", "c", "v_ref", "copysign"}
#: Arguments of a program's functions that the two functions have under the same names.
_SAME_NAMES = {name: name for name in ("v", "v_ref", "h", "z", "load", "p", "c")}


def matlab(
    model: Model, name: str = "friction", compensator: Compensator | None = None
) -> dict[str, bytes]:
    """The two functions of a model.

    Args:
        model: What was identified.
        name: Of the law's function and file; the compensator's is `name_compensator`.
        compensator: Its settings; full feed-forward from the reference's velocity by default.

    Raises:
        InputError: a name that MATLAB does not take, or a law that cannot be translated.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,40}", name) or name in WORDS | _VARIABLES:
        raise InputError(
            f"name {name!r}: MATLAB takes letters, digits and _, beginning with a letter, up to "
            "41, no word or function of its own and no variable of these functions"
        )
    settings = compensator or Compensator(feedback=False)
    return {
        f"{name}.m": _law(model, name).encode("ascii"),
        f"{name}_compensator.m": _compensator(model, name, settings).encode("ascii"),
    }


def _functions(program: Program, reserved: list[str]) -> tuple[list[str], dict[str, str]]:
    """The texts of a program's functions, and what they are called."""
    names = Identifiers([*WORDS, *_VARIABLES, *reserved], alike=False)
    function_names = {f.name: names.new(f.name) for f in program.functions} | {
        "copysign": "copysign"
    }
    simpler = lowered(program, Restrictions(joins=False, divides=False, returns=True))
    texts = [function_text(f, function_names) for f in simpler.functions]
    return [*texts, *([COPYSIGN] if "copysign" in program.calls else [])], function_names


# --- the law


def _law(model: Model, name: str) -> str:
    law, states = model.law, model.law.states
    program = law_program(law, compensator=False)
    texts, function_names = _functions(program, [name])
    values = model.p.tolist()
    wide = max(len(repr(x)) for x in values)
    parameters = [
        f"    {repr(x).rjust(wide)} % {n}: {_comment_text(q.doc, q.unit)}"
        for (n, q), x in zip(model.named(), values, strict=True)
    ]

    def call(which: str) -> str:
        arguments = program.arguments(which, {**_SAME_NAMES, "out": "z"})
        return f"{function_names[which]}({', '.join(arguments)})"

    body = [f"F = {call('steady' if law.rub is None else 'rubbed')};"]
    if states:
        advanced = f"[F, z] = {call('rubbed')};"
        body = ["if isempty(h)", f"    F = {call('steady')};", "else", f"    {advanced}", "end"]
    if law.terms:
        body.append(f"F = {call('factor')} * F;")
    lines = [
        f"function [F, z, p] = {name}(v, h, z, load, p)",
        *_help(
            [
                f"{name.upper()}  Friction by the law {law.name}, {model.force_unit}.",
                "",
                f"F = {name}(v) is the friction of steady sliding at v, {model.speed_unit}.",
                f"[F, z] = {name}(v, h, z, load, p) is that at the end of h seconds passed at v:",
                "z: states, in and out, " + (f"({states}, 1)" if states else "of which it has none")
                + "; [] where bristles are relaxed.",
                "load: drive, external, normal, position, temperature (K); it reads "
                + (", ".join((*law.loads, *law.terms)) or "none") + ".",
                "p: parameters in the order below; [] for the identified ones.",
                f"[~, z, p] = {name}(0) gives relaxed states and the identified parameters.",
                "",
                *model.head(),
            ]
        ),
        "if nargin < 2",
        "    h = [];",
        "end",
        "if nargin < 3 || isempty(z)",
        f"    z = zeros({states}, 1);",
        "end",
        "if nargin < 4 || isempty(load)",
        f"    load = zeros({len(LOADS)}, 1);",
        "end",
        "if nargin < 5 || isempty(p)",
        "    p = [",
        *(f"    {line}" for line in parameters),
        "    ];",
        "end",
        *body,
        "end",
        "",
    ]  # fmt: skip
    return "\n".join([*map(ascii_text, lines), *texts])


# --- the compensator


def _compensator(model: Model, name: str, compensator: Compensator) -> str:
    rotary = model.rig.rotary
    full = f"{name}_compensator"
    program = law_program(model.law)
    texts, function_names = _functions(program, [name, full])
    rows = [
        f"    {value!r} % {s.name}: {_comment_text(s.meaning, s.rotary if rotary else s.unit)}"
        for s, value in zip(SETTINGS, compensator.c.tolist(), strict=True)
    ]

    def call(which: str, **more: str) -> str:
        arguments = program.arguments(which, {**_SAME_NAMES, "z": "s.z", "out": "s.z", **more})
        return f"{function_names[which]}({', '.join(arguments)})"

    factor = call("factor") if model.law.terms else ""
    output = call("compensator_output", before="s.before", factor=factor)
    results = "[u, s.z]" if model.law.states else "u"
    lines = [
        f"function [u, s, c] = {full}(v_ref, v, h, s, load, c, p)",
        *_help(
            [
                f"{full.upper()}  What a controller adds to its command, {model.force_unit}.",
                "",
                f"[u, s] = {full}(v_ref, v, h, s, load, c, p), once a sample:",
                f"v_ref: velocity of the reference, {model.speed_unit}.",
                "v: measured velocity, the same; not read where feedback is 0.",
                "h: sample time, s.",
                "s: what it remembers, in and out; [] at first.",
                f"load, p: as {name} has them.",
                "c: settings in the order below; [] for those.",
            ]
        ),
        "if nargin < 4 || isempty(s)",
        f"    s = struct('z', zeros({model.law.states}, 1), 'before', 0);",
        "end",
        "if nargin < 5 || isempty(load)",
        f"    load = zeros({len(LOADS)}, 1);",
        "end",
        "if nargin < 6 || isempty(c)",
        "    c = [",
        *(f"    {row}" for row in rows),
        "    ];",
        "end",
        "if nargin < 7 || isempty(p)",
        f"    [~, ~, p] = {name}(0);",
        "end",
        f"{results} = {output};",
        "s.before = u;",
        "end",
        "",
    ]
    return "\n".join([*map(ascii_text, lines), *texts])


def _help(lines: list[str]) -> list[str]:
    """The comment that `help` shows: no line of it can be taken for a block of comments."""
    return [
        f"%   {folded_line}".rstrip()
        for text in lines
        for line in text.split("\n")
        for folded_line in folded(ascii_text(line), 94)
    ]  # fmt: skip


def _comment_text(*texts: str) -> str:
    """What stands behind a % on one line."""
    return ", ".join(" ".join(t.split()) for t in texts if t)
