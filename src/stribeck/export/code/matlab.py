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
from ..model import Model, compensator_functions, folded
from .ascii_text import ascii_text
from .identifiers import Identifiers
from .lowering import Blunt, lowered
from .matlab_dialect import COPYSIGN, WORDS, function_text
from .program import Program
from .translation import translated

#: Variables of the two functions, which would hide a law of their name.
_OWN = {"F", "z", "p", "v", "h", "load", "scale", "u", "s", "c", "v_ref", "at", "copysign"}


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
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,40}", name) or name in WORDS | _OWN:
        raise InputError(
            f"name {name!r}: MATLAB takes letters, digits and _, beginning with a letter, up to "
            "41, no word or function of its own and no variable of these functions"
        )
    made = compensator or Compensator(feedback=False)
    return {
        f"{name}.m": _law(model, name).encode("ascii"),
        f"{name}_compensator.m": _compensator(model, name, made).encode("ascii"),
    }


def _functions(of: Program, taken: list[str]) -> tuple[list[str], dict[str, str]]:
    """The texts of a program's functions, and what they are called."""
    names = Identifiers([*WORDS, *_OWN, *taken], alike=False)
    called = {f.name: names.new(f.name) for f in of.functions} | {"copysign": "copysign"}
    made = lowered(of, Blunt(joins=False, divides=False))
    texts = [function_text(f, called) for f in made.functions]
    return [*texts, *([COPYSIGN] if "copysign" in of.calls else [])], called


# --- the law


def _law(model: Model, name: str) -> str:
    law, states = model.law, model.law.states
    texts, called = _functions(model.program(), [name])
    values = model.p.tolist()
    wide = max(len(repr(x)) for x in values)
    parameters = [
        f"    {repr(x).rjust(wide)} % {n}: {_said(q.doc, q.unit)}"
        for (n, q), x in zip(model.named(), values, strict=True)
    ]
    steady = f"F = {called['steady']}(v, p);"
    body = [steady]
    scaled = []
    if law.terms:
        scaled = ["% What multiplies all of it.", "scale = 1;"]
        for term, load, at, count in model.terms():
            terms = ", ".join([f"load({load + 1})", *(f"p({at + k + 1})" for k in range(count))])
            scaled.append(f"scale = scale * {called[f'{term}_factor']}({terms});")
        scaled.append("F = max(scale, 0) * F;")
    if law.rub is not None:
        given = ["v", *(["h", "z"] if states else []), *(["load"] if law.loads else []), "p"]
        rubbed = f"{called['rubbed']}({', '.join(given)});"
        body = [f"F = {rubbed}"]
        if states:
            body = ["if isempty(h)", f"    {steady}", "else", f"    [F, z] = {rubbed}", "end"]
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
        *scaled,
        "end",
        "",
    ]  # fmt: skip
    return "\n".join([*map(ascii_text, lines), *texts])


# --- the compensator


def _compensator(model: Model, name: str, compensator: Compensator) -> str:
    rotary = model.rig.rotary
    full = f"{name}_compensator"
    of = translated(compensator_functions(), "the compensator")
    texts, called = _functions(of, [name, full])
    rows = [
        f"    {value!r} % {s.name}: {_said(s.meaning, s.rotary if rotary else s.unit)}"
        for s, value in zip(SETTINGS, compensator.c.tolist(), strict=True)
    ]
    place = {s.name: s.index + 1 for s in SETTINGS}
    ask = f"[F, s.z] = {name}(at, h, s.z, load, p);"
    body = [ask]
    if model.law.states:
        body = [
            f"if c({place['feedback']}) ~= 0 && abs(v) <= c({place['dead_band']})",
            f"    F = {name}(at, [], s.z, load, p); % at rest: what it breaks away at",
            "else",
            f"    {ask}",
            "end",
        ]
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
        "if nargin < 5",
        "    load = [];",
        "end",
        "if nargin < 6 || isempty(c)",
        "    c = [",
        *(f"    {row}" for row in rows),
        "    ];",
        "end",
        "if nargin < 7",
        "    p = [];",
        "end",
        f"at = {called['asked']}(v_ref, v, c);",
        *body,
        f"s.before = {called['shaped']}(F, v_ref, v, h, s.before, c);",
        "u = s.before;",
        "end",
        "",
    ]
    return "\n".join([*map(ascii_text, lines), *texts])


def _help(said: list[str]) -> list[str]:
    """The comment that `help` shows: no line of it can be taken for a block of comments."""
    return [
        f"%   {line}".rstrip()
        for whole in said
        for text in whole.split("\n")
        for line in folded(ascii_text(text), 94)
    ]  # fmt: skip


def _said(*texts: str) -> str:
    """What stands behind a % on one line."""
    return ", ".join(" ".join(t.split()) for t in texts if t)
