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
from ..model import Model
from .identifiers import Identifiers, named
from .law_program import law_program
from .lowering import Restrictions, lowered
from .program import Array, Name, Program, ProgramFunction
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
class ProgramUnit:
    """A program organization unit.

    Args:
        name: Its name.
        kind: FUNCTION or FUNCTION_BLOCK.
        says: What it is for.
        inputs: VAR_INPUT.
        shared: VAR_IN_OUT.
        outputs: VAR_OUTPUT.
        own: VAR.
        body: Lines of Structured Text.
        gives: The type of a function's value.
    """

    name: str
    kind: str
    says: str
    inputs: tuple[Variable, ...] = ()
    shared: tuple[Variable, ...] = ()
    outputs: tuple[Variable, ...] = ()
    own: tuple[Variable, ...] = ()
    body: tuple[str, ...] = ()
    gives: str = "LREAL"


def program_units(model: Model, name: str, compensator: Compensator | None) -> list[ProgramUnit]:
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
    return _Units(model, name, compensator or Compensator(feedback=False)).all_units()


class _Units:
    """The units of one model."""

    def __init__(self, model: Model, name: str, compensator: Compensator) -> None:
        self.model, self.law, self.name, self.compensator = model, model.law, name, compensator
        self.program: Program = lowered(law_program(model.law), Restrictions())
        helpers = needed(self.program.calls)
        names = Identifiers([*WORDS, name, f"{name}_compensator"], alike=True)
        unit_names = {h: names.new(f"{name}_{h}") for h in helpers}
        unit_names |= {f.name: names.new(f"{name}_{f.name}") for f in self.program.functions}
        # No variable may have the name of a unit: tools differ in which of the two is meant.
        around = [*WORDS, *unit_names.values(), name, f"{name}_compensator"]
        self.functions: dict[str, ProgramFunction] = {
            f.name: named(f, Identifiers(around, alike=True)) for f in self.program.functions
        }
        self.called: dict[str, tuple[str, Sequence[str]]] = {
            **{h: (unit_names[h], HELPERS[h].arguments) for h in helpers},
            **{
                n: (unit_names[n], [a.name for a in f.arguments]) for n, f in self.functions.items()
            },
        }
        self.helpers, self.around = helpers, around
        unit = (model.speed_unit, model.force_unit)
        self.speed, self.force = unit
        self.reads = [x for x in LOADS if x in (*self.law.loads, *self.law.terms)]

    def all_units(self) -> list[ProgramUnit]:
        """All of them."""
        return [
            *map(self._helper, self.helpers),
            *map(self._function, self.functions.values()),
            self._law(),
            self._compensator(),
        ]

    # --- functions

    def _helper(self, name: str) -> ProgramUnit:
        helper, unit_name = HELPERS[name], self.called[name][0]
        body = helper.body.format(f=unit_name, **{n: self.called[n][0] for n in helper.needs})
        return ProgramUnit(
            unit_name,
            "FUNCTION",
            helper.says,
            inputs=tuple(Variable(a, "LREAL") for a in helper.arguments),
            own=tuple(Variable(n, t) for n, t in helper.variables),
            body=tuple(body.split("\n")),
        )

    def _function(self, function: ProgramFunction) -> ProgramUnit:
        unit_name = self.called[function.name][0]
        lines = ST(unit_name, self.called).block(function.body, depth=0)
        return ProgramUnit(
            unit_name,
            "FUNCTION",
            function.doc,
            inputs=tuple(
                Variable(a.name, TYPES[a.kind]) for a in function.arguments if isinstance(a, Name)
            ),
            shared=tuple(
                Variable(a.name, "LREAL", a.length)
                for a in function.arguments
                if isinstance(a, Array)
            ),
            own=tuple(Variable(v.name, TYPES[v.kind]) for v in function.variables),
            body=tuple(lines[:-1] if lines[-1] == "RETURN;" else lines),
            gives=TYPES[function.results[0]],
        )

    def _call(self, name: str, **texts: str) -> str:
        """A call of a function of the program, its arguments by the names that it has there."""
        full, names = self.called[name]
        values = self.program.arguments(name, texts)
        arguments = ", ".join(f"{a} := {v}" for a, v in zip(names, values, strict=True))
        return f"{full}({arguments})"

    def _loads(self, names: Identifiers) -> list[Variable]:
        return [Variable(names.new(f"load_{x}"), "LREAL", says=_LOADS[x]) for x in self.reads]

    def _members(self, names: Identifiers, loads: Sequence[Variable]) -> _Members:
        """What a block holds of its law: parameters, loads and states, each as a list, too."""
        parameters = [
            Variable(
                names.new(n), "LREAL", initial=_number(value), says=_comment_text(q.doc, q.unit)
            )
            for (n, q), value in zip(self.model.named(), self.model.p.tolist(), strict=True)
        ]
        p, z, out, load, i = map(names.new, ("p", "z", "out", "load", "i"))
        variables = [*parameters, Variable(p, "LREAL", len(parameters), says="the same, as a list")]
        lists = [f"{p}[{k}] := {q.name};" for k, q in enumerate(parameters)]
        if self.reads:
            variables.append(Variable(load, "LREAL", len(LOADS), says="loads, as a list"))
            places = [LOADS.index(x) for x in self.reads]
            lists += [
                f"{load}[{place}] := {x.name};" for place, x in zip(places, loads, strict=True)
            ]
        if states := self.law.states:
            variables += [
                Variable(z, "LREAL", states, says="states, 0.0 where bristles are relaxed"),
                Variable(out, "LREAL", states, says="states after h"),
                Variable(i, "DINT"),
            ]
        loop = f"    FOR {i} := 0 TO {self.law.states - 1} DO"
        return _Members(
            tuple(variables),
            tuple(lists),
            {"p": p, "z": z, "load": load, "out": out},
            (loop, f"        {z}[{i}] := 0.0;", "    END_FOR;"),
            (loop, f"        {z}[{i}] := {out}[{i}];", "    END_FOR;"),
        )

    # --- the law

    def _law(self) -> ProgramUnit:
        law, names = self.law, Identifiers(self.around, alike=True)
        inputs = [Variable(names.new("v"), "LREAL", says=f"velocity, {self.speed}")]
        if law.states:
            inputs += [
                Variable(names.new("h"), "LREAL", says="time since the call before, s"),
                Variable(names.new("steady"), "BOOL", says=(
                    "TRUE: friction of steady sliding at v, states as they are")),
                Variable(names.new("reset"), "BOOL", says="TRUE: states relaxed first"),
            ]  # fmt: skip
        loads = self._loads(names)
        force = names.new("force")
        members = self._members(names, loads)
        steady = f"{force} := {self._call('steady', v='v', **members.lists)};"
        body = list(members.filled)
        if law.rub is None:
            body.append(steady)
        else:
            rubbed = f"{force} := {self._call('rubbed', v='v', h='h', **members.lists)};"
            if law.states:
                body += ["IF reset THEN", *members.relaxed, "END_IF;"]
                body += ["IF steady THEN", f"    {steady}", "ELSE"]
                body += [f"    {rubbed}", *members.advanced, "END_IF;"]
            else:
                body.append(rubbed)
        if law.terms:
            body.append(f"{force} := {self._call('factor', **members.lists)} * {force};")
        return ProgramUnit(
            self.name,
            "FUNCTION_BLOCK",
            f"Friction by the law {law.name}, with the sign of the velocity",
            inputs=(*inputs, *loads),
            outputs=(Variable(force, "LREAL", says=f"friction, {self.force}"),),
            own=members.own,
            body=tuple(body),
        )

    # --- the compensator

    def _compensator(self) -> ProgramUnit:
        names = Identifiers(self.around, alike=True)
        enable, v_ref, v, h = map(names.new, ("enable", "v_ref", "v", "h"))
        loads = self._loads(names)
        c = names.new("c")
        settings, filled = self._settings(names, c)
        u = names.new("u")
        members = self._members(names, loads)
        factor = self._call("factor", **members.lists) if self.law.terms else ""
        output = self._call(
            "compensator_output",
            factor=factor, v_ref=v_ref, v=v, h=h, before=u, c=c, **members.lists,
        )  # fmt: skip
        body = [
            *filled,
            *members.filled,
            f"IF {enable} THEN",
            f"    {u} := {output};",
            *(members.advanced if self.law.states else ()),
            "ELSE",
            f"    {u} := 0.0;",
            *(members.relaxed if self.law.states else ()),
            "END_IF;",
        ]
        return ProgramUnit(
            f"{self.name}_compensator",
            "FUNCTION_BLOCK",
            "What a controller adds to its command, called once a sample",
            inputs=(
                Variable(enable, "BOOL", initial="TRUE", says="FALSE: u = 0.0, states relaxed"),
                Variable(v_ref, "LREAL", says=f"velocity of the reference, {self.speed}"),
                Variable(v, "LREAL", says=f"measured velocity, {self.speed}; for feedback alone"),
                Variable(h, "LREAL", says="sample time, s"),
                *loads,
                *settings,
            ),
            outputs=(Variable(u, "LREAL", says=f"what to add to the command, {self.force}"),),
            own=(*members.own, Variable(c, "LREAL", len(SETTINGS), says="settings, as a list")),
            body=tuple(body),
        )

    def _settings(self, names: Identifiers, c: str) -> tuple[list[Variable], list[str]]:
        """The settings as inputs, and the lines that fill the list of them."""
        inputs, filled = [], []
        for s, value in zip(SETTINGS, self.compensator.c.tolist(), strict=True):
            name = names.new(_SETTINGS.get(s.name, s.name))
            unit = s.rotary if self.model.rig.rotary else s.unit
            if s.name == "feedback":
                initial = "TRUE" if value else "FALSE"
                says = "TRUE: law at the measured velocity, FALSE: at that of the reference"
                inputs.append(Variable(name, "BOOL", initial=initial, says=says))
                filled += [f"{c}[{s.index}] := 0.0;"]
                filled += [f"IF {name} THEN", f"    {c}[{s.index}] := 1.0;", "END_IF;"]
            else:
                inputs.append(
                    Variable(
                        name, "LREAL", initial=_number(value), says=_comment_text(s.meaning, unit)
                    )
                )
                filled.append(f"{c}[{s.index}] := {name};")
        return inputs, filled


@dataclass(frozen=True)
class _Members:
    """What a function block holds of its law.

    Args:
        own: Its variables.
        filled: Lines that fill the lists from the variables.
        lists: Names of the lists, by their names in the program.
        relaxed: Lines that relax the states.
        advanced: Lines by which the states become those after h.
    """

    own: tuple[Variable, ...]
    filled: tuple[str, ...]
    lists: Mapping[str, str]
    relaxed: tuple[str, ...]
    advanced: tuple[str, ...]


_LOADS: Mapping[str, str] = {
    "drive": "force or torque of the drive, N or N m",
    "external": "that of everything else on the axis, N or N m",
    "normal": "normal load, in the rig's SI unit",
    "position": "position, m or rad",
    "temperature": "temperature, K",
}


def _number(value: float) -> str:
    return ST("", {}).number(value, "real")


def _comment_text(*texts: str) -> str:
    return ", ".join(t for t in texts if t)
