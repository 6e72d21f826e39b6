"""The program organization units of a model, as IEC 61131-3 has them, before they are text.

Functions for the law's mathematics and for the law, a function block for the law with its
parameters and states, and one for the compensator. Structured Text and PLCopen XML print them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...compensate.compensator import SETTINGS, Compensator
from ...errors import InputError
from ...friction import LOADS
from ..model import Model, compensator_functions
from .identifiers import Identifiers, named
from .lowering import Blunt, lowered
from .program import Array, Function, Name, Program
from .st_dialect import HELPERS, ST, TYPES, WORDS, needed

#: Settings whose names are words of the language's.
_SETTINGS = {"limit": "largest"}
#: What the blocks' own inputs and outputs are called, which the blocks are therefore not.
_PINS = {"v", "h", "steady", "reset", "force", "enable", "v_ref", "u", "law"} | {
    *(_SETTINGS.get(s.name, s.name) for s in SETTINGS),
    *(f"load_{x}" for x in LOADS),
}


@dataclass(frozen=True)
class Variable:
    """A variable that a unit declares.

    Args:
        name: Its name.
        type: LREAL, DINT, BOOL, or a function block.
        length: Of an array, counted from 0; None for a single value.
        initial: What it begins with, as it is written.
        says: What it is.
    """

    name: str
    type: str
    length: int | None = None
    initial: str | None = None
    says: str = ""


@dataclass(frozen=True)
class Unit:
    """A program organization unit.

    Args:
        name: Its name.
        kind: FUNCTION, which gives an LREAL, or FUNCTION_BLOCK.
        says: What it is for.
        inputs: VAR_INPUT.
        shared: VAR_IN_OUT.
        outputs: VAR_OUTPUT.
        own: VAR.
        body: Lines of Structured Text.
    """

    name: str
    kind: str
    says: str
    inputs: tuple[Variable, ...] = ()
    shared: tuple[Variable, ...] = ()
    outputs: tuple[Variable, ...] = ()
    own: tuple[Variable, ...] = ()
    body: tuple[str, ...] = ()


def units(model: Model, name: str, compensator: Compensator | None) -> list[Unit]:
    """The units of a model, each after those that it calls.

    Args:
        model: What was identified.
        name: Of the law's function block, and what all other names begin with.
        compensator: Its settings; full feed-forward from the reference's velocity by default.

    Raises:
        InputError: a name that the language does not take, or a law that cannot be translated.
    """
    if (
        not re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9]){0,23}", name)
        or name.upper() in WORDS
        or name.lower() in _PINS
    ):
        raise InputError(
            f"name {name!r}: a controller takes letters, digits and single _, beginning with a "
            "letter, up to 24, no word of its own and none of the blocks' inputs and outputs"
        )
    return _Units(model, name, compensator or Compensator(feedback=False)).every()


class _Units:
    """The units of one model."""

    def __init__(self, model: Model, name: str, compensator: Compensator) -> None:
        self.model, self.law, self.name, self.compensator = model, model.law, name, compensator
        self.program: Program = lowered(model.program(*compensator_functions()), Blunt())
        helpers = needed(self.program.calls)
        names = Identifiers([*WORDS, name, f"{name}_compensator"], alike=True)
        own = {h: names.new(f"{name}_{h}") for h in helpers}
        own |= {f.name: names.new(f"{name}_{f.name}") for f in self.program.functions}
        # No variable may have the name of a unit: tools differ in which of the two is meant.
        around = [*WORDS, *own.values(), name, f"{name}_compensator"]
        self.functions: dict[str, Function] = {
            f.name: named(f, Identifiers(around, alike=True)) for f in self.program.functions
        }
        self.called: dict[str, tuple[str, Sequence[str]]] = {
            **{h: (own[h], HELPERS[h].arguments) for h in helpers},
            **{n: (own[n], [a.name for a in f.arguments]) for n, f in self.functions.items()},
        }
        self.helpers, self.around = helpers, around
        unit = (model.speed_unit, model.force_unit)
        self.speed, self.force = unit
        self.reads = [x for x in LOADS if x in (*self.law.loads, *self.law.terms)]

    def every(self) -> list[Unit]:
        """All of them."""
        return [
            *map(self._helper, self.helpers),
            *map(self._function, self.functions.values()),
            self._law(),
            self._compensator(),
        ]

    # --- functions

    def _helper(self, which: str) -> Unit:
        of, name = HELPERS[which], self.called[which][0]
        body = of.body.format(f=name, **{n: self.called[n][0] for n in of.needs})
        return Unit(
            name,
            "FUNCTION",
            of.says,
            inputs=tuple(Variable(a, "LREAL") for a in of.arguments),
            own=tuple(Variable(n, t) for n, t in of.variables),
            body=tuple(body.split("\n")),
        )

    def _function(self, of: Function) -> Unit:
        name = self.called[of.name][0]
        lines = ST(name, self.called).block(of.body, depth=0)
        return Unit(
            name,
            "FUNCTION",
            of.doc,
            inputs=tuple(Variable(a.name, "LREAL") for a in of.arguments if isinstance(a, Name)),
            shared=tuple(
                Variable(a.name, "LREAL", a.length) for a in of.arguments if isinstance(a, Array)
            ),
            own=tuple(Variable(v.name, TYPES[v.kind]) for v in of.variables),
            body=tuple(lines[:-1] if lines[-1] == "RETURN;" else lines),
        )

    def _call(self, which: str, **given: str) -> str:
        """A call of a function of the program, its arguments by the names that Python has."""
        full, arguments = self.called[which]
        plain = [a.name for a in self._plain(which).arguments]
        said = ", ".join(f"{a} := {given[p]}" for a, p in zip(arguments, plain, strict=True))
        return f"{full}({said})"

    def _plain(self, which: str) -> Function:
        return next(f for f in self.program.functions if f.name == which)

    # --- the law

    def _law(self) -> Unit:
        law, states = self.law, self.law.states
        names = Identifiers(self.around, alike=True)
        inputs = [Variable(names.new("v"), "LREAL", says=f"velocity, {self.speed}")]
        if states:
            inputs += [
                Variable(names.new("h"), "LREAL", says="time since the call before, s"),
                Variable(names.new("steady"), "BOOL", says=(
                    "TRUE: friction of steady sliding at v, states as they are")),
                Variable(names.new("reset"), "BOOL", says="TRUE: states relaxed first"),
            ]  # fmt: skip
        inputs += [Variable(names.new(f"load_{x}"), "LREAL", says=_LOADS[x]) for x in self.reads]
        force = names.new("force")
        parameters = [
            Variable(names.new(n), "LREAL", initial=_number(value), says=_said(q.doc, q.unit))
            for (n, q), value in zip(self.model.named(), self.model.p.tolist(), strict=True)
        ]
        p, z, out, load, i, scale = map(names.new, ("p", "z", "out", "load", "i", "scale"))
        own = [*parameters, Variable(p, "LREAL", len(parameters), says="the same, as a list")]
        body = [f"{p}[{k}] := {q.name};" for k, q in enumerate(parameters)]
        if law.loads:
            own.append(Variable(load, "LREAL", len(LOADS), says="loads, as a list"))
            body += [f"{load}[{LOADS.index(x)}] := load_{x};" for x in law.loads]
        if states:
            own += [
                Variable(z, "LREAL", states, says="states, 0.0 where bristles are relaxed"),
                Variable(out, "LREAL", states, says="states after h"),
                Variable(i, "DINT"),
            ]
            loop = f"    FOR {i} := 0 TO {states - 1} DO"
            body += ["IF reset THEN", loop, f"        {z}[{i}] := 0.0;", "    END_FOR;", "END_IF;"]
        steady = self._call("steady", v="v", p=p)
        if law.rub is None:
            body.append(f"{force} := {steady};")
        else:
            given = {"v": "v", "p": p, "h": "h", "z": z, "load": load, "out": out}
            rubbed = self._call("rubbed", **given)
            if states:
                body += ["IF steady THEN", f"    {force} := {steady};", "ELSE"]
                body += [f"    {force} := {rubbed};", loop, f"        {z}[{i}] := {out}[{i}];"]
                body += ["    END_FOR;", "END_IF;"]
            else:
                body.append(f"{force} := {rubbed};")
        if law.terms:
            own.append(Variable(scale, "LREAL", says="what the terms multiply friction by"))
            body += self._scaled(scale, force, p)
        return Unit(
            self.name,
            "FUNCTION_BLOCK",
            f"Friction by the law {law.name}, with the sign of the velocity",
            inputs=tuple(inputs),
            outputs=(Variable(force, "LREAL", says=f"friction, {self.force}"),),
            own=tuple(own),
            body=tuple(body),
        )

    def _scaled(self, scale: str, force: str, p: str) -> list[str]:
        lines = []
        for k, (term, _, at, count) in enumerate(self.model.terms()):
            full, arguments = self.called[f"{term}_factor"]
            values = [f"load_{term}", *(f"{p}[{at + j}]" for j in range(count))]
            said = ", ".join(f"{a} := {v}" for a, v in zip(arguments, values, strict=True))
            lines.append(f"{scale} := {f'{scale} * ' if k else ''}{full}({said});")
        return [*lines, f"{force} := MAX({scale}, 0.0) * {force};"]

    # --- the compensator

    def _compensator(self) -> Unit:
        rotary = self.model.rig.rotary
        names = Identifiers(self.around, alike=True)
        enable, v_ref, v, h = map(names.new, ("enable", "v_ref", "v", "h"))
        inputs = [
            Variable(enable, "BOOL", initial="TRUE", says="FALSE: u = 0.0, states relaxed"),
            Variable(v_ref, "LREAL", says=f"velocity of the reference, {self.speed}"),
            Variable(v, "LREAL", says=f"measured velocity, {self.speed}; for feedback alone"),
            Variable(h, "LREAL", says="sample time, s"),
        ]
        loads = {x: names.new(f"load_{x}") for x in self.reads}
        inputs += [Variable(n, "LREAL", says=_LOADS[x]) for x, n in loads.items()]
        c, settings, filled = names.new("c"), {}, []
        for s, value in zip(SETTINGS, self.compensator.c.tolist(), strict=True):
            n = settings[s.name] = names.new(_SETTINGS.get(s.name, s.name))
            unit = s.rotary if rotary else s.unit
            if s.name == "feedback":
                initial = "TRUE" if value else "FALSE"
                says = "TRUE: law at the measured velocity, FALSE: at that of the reference"
                inputs.append(Variable(n, "BOOL", initial=initial, says=says))
                filled += [f"{c}[{s.index}] := 0.0;"]
                filled += [f"IF {n} THEN", f"    {c}[{s.index}] := 1.0;", "END_IF;"]
            else:
                inputs.append(
                    Variable(n, "LREAL", initial=_number(value), says=_said(s.meaning, unit))
                )
                filled.append(f"{c}[{s.index}] := {n};")
        u, law, speed = map(names.new, ("u", "law", "speed"))
        given = {"v": speed}
        off = {"v": "0.0"}
        if self.law.states:
            rests = f"{settings['feedback']} AND (ABS({v}) <= {settings['dead_band']})"
            given |= {"h": h, "steady": rests, "reset": "FALSE"}
            off |= {"h": "0.0", "steady": "TRUE", "reset": "TRUE"}
        given |= {f"load_{x}": n for x, n in loads.items()}
        on = self._call("asked", v_ref=v_ref, v=v, c=c)
        shaped = self._call(
            "shaped", force=f"{law}.force", v_ref=v_ref, v=v, h=h, before=u, c=c
        )  # fmt: skip
        body = [
            *filled,
            f"IF {enable} THEN",
            f"    {speed} := {on};",
            f"    {law}({_given(given)});",
            f"    {u} := {shaped};",
            "ELSE",
            *([f"    {law}({_given(off)});"] if self.law.states else []),
            f"    {u} := 0.0;",
            "END_IF;",
        ]
        return Unit(
            f"{self.name}_compensator",
            "FUNCTION_BLOCK",
            "What a controller adds to its command, called once a sample",
            inputs=tuple(inputs),
            outputs=(Variable(u, "LREAL", says=f"what to add to the command, {self.force}"),),
            own=(
                Variable(law, self.name, says="its own law, with states of its own"),
                Variable(c, "LREAL", len(SETTINGS), says="settings, as a list"),
                Variable(speed, "LREAL", says=f"at which the law is asked, {self.speed}"),
            ),
            body=tuple(body),
        )


_LOADS: Mapping[str, str] = {
    "drive": "force or torque of the drive, N or N m",
    "external": "that of everything else on the axis, N or N m",
    "normal": "normal load, in the rig's SI unit",
    "position": "position, m or rad",
    "temperature": "temperature, K",
}


def _given(values: Mapping[str, str]) -> str:
    return ", ".join(f"{k} := {v}" for k, v in values.items())


def _number(value: float) -> str:
    return ST("", {}).number(value, "real")


def _said(*texts: str) -> str:
    return ", ".join(t for t in texts if t)
