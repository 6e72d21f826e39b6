"""IEC 61131-3 Structured Text for a programmable controller: the law and its compensator.

A file of plain text that CODESYS, TwinCAT, SCL and whatever else reads the standard's third
edition import: functions for the mathematics, a function block for the law, whose parameters can
be retuned while it runs, and one for the compensator. LREAL throughout; no zero has a sign.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...compensate.compensator import Compensator
from ..model import Model, folded
from .ascii_text import ascii_text
from .pou import ProgramUnit, Variable, program_units

_SECTIONS = (("VAR_INPUT", "inputs"), ("VAR_IN_OUT", "shared"), ("VAR_OUTPUT", "outputs"))


def st(
    model: Model, name: str = "Friction", compensator: Compensator | None = None
) -> dict[str, bytes]:
    """Structured Text of a model.

    Args:
        model: What was identified.
        name: Of the file and the law's function block; what all other units begin with.
        compensator: Its settings; full feed-forward from the reference's velocity by default.

    Raises:
        InputError: a name that the language does not take, or a law that cannot be translated.
    """
    units = program_units(model, name, compensator)
    text = "\n".join([*comment(head(model)), "", *map(unit_text, units)])
    return {f"{name}.st": text.encode("ascii")}


def head(model: Model) -> list[str]:
    """What the file says of itself."""
    return [
        *model.head(),
        "",
        "This text has no zero with a sign: at v = 0.0 the law gives what holds on the + side.",
        "One task calls an instance: states and lists are its own.",
    ]


def unit_text(unit: ProgramUnit) -> str:
    """One unit, with its comment, as it stands in the file."""
    returns = f" : {unit.gives}" if unit.kind == "FUNCTION" else ""
    lines = [*(comment([unit.says]) if unit.says else []), f"{unit.kind} {unit.name}{returns}"]
    for word, section in (*_SECTIONS, ("VAR", "own")):
        variables: tuple[Variable, ...] = getattr(unit, section)
        if variables:
            lines += [word, *(f"    {declaration(v)}" for v in variables), "END_VAR"]
    return "\n".join([*lines, "", *unit.body, f"END_{unit.kind}", ""])


def declaration(variable: Variable) -> str:
    """A variable's line."""
    kind = (
        variable.type
        if variable.length is None
        else f"ARRAY[0..{variable.length - 1}] OF {variable.type}"
    )
    initial = f" := {variable.initial}" if variable.initial is not None else ""
    says = f" {''.join(comment([variable.says]))}" if variable.says else ""
    return f"{variable.name} : {kind}{initial};{says}"


def comment(lines: Sequence[str]) -> list[str]:
    """A comment that nothing in it can end, or begin another in."""
    safe = [harmless(line) for line in lines]
    if len(safe) == 1:
        return [f"(* {safe[0]} *)"]
    wrapped = [w for s in safe for w in folded(s, 96)]
    return ["(*", *(f"   {line}".rstrip() for line in wrapped), "*)"]


def harmless(text: str) -> str:
    """ASCII without the signs that begin or end a comment."""
    plain = ascii_text(text)
    for sign, apart in (("*)", "* )"), ("(*", "( *"), ("*/", "* /"), ("/*", "/ *")):
        plain = plain.replace(sign, apart)
    return plain
