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
from .pou import Unit, Variable, units

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
    text = "\n".join([*comment(head(model)), "", *map(unit_text, units(model, name, compensator))])
    return {f"{name}.st": text.encode("ascii")}


def head(model: Model) -> list[str]:
    """What the file says of itself."""
    return [
        *model.head(),
        "",
        "This text has no zero with a sign: at v = 0.0 the law gives what holds on the + side.",
        "One task calls an instance: states and lists are its own.",
    ]


def unit_text(of: Unit) -> str:
    """One unit, with its comment, as it stands in the file."""
    returns = " : LREAL" if of.kind == "FUNCTION" else ""
    lines = [*(comment([of.says]) if of.says else []), f"{of.kind} {of.name}{returns}"]
    for word, section in (*_SECTIONS, ("VAR", "own")):
        found: tuple[Variable, ...] = getattr(of, section)
        if found:
            lines += [word, *(f"    {declaration(v)}" for v in found), "END_VAR"]
    return "\n".join([*lines, "", *of.body, f"END_{of.kind}", ""])


def declaration(of: Variable) -> str:
    """A variable's line."""
    kind = of.type if of.length is None else f"ARRAY[0..{of.length - 1}] OF {of.type}"
    initial = f" := {of.initial}" if of.initial is not None else ""
    says = f" {''.join(comment([of.says]))}" if of.says else ""
    return f"{of.name} : {kind}{initial};{says}"


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
