"""Modelica: a package with the law's functions, a block for the law and one for the compensator.

A law without states is an equation; one with states is sampled, as its states advance by spans of
constant velocity. It needs no library.
"""

from __future__ import annotations

import html
import re

from ...compensate.compensator import SETTINGS, Compensator
from ...errors import InputError
from ...friction import LOADS
from ..model import Model, compensator_functions
from .ascii_text import ascii_text
from .identifiers import Identifiers
from .lowering import Blunt, lowered
from .modelica_dialect import HELPERS, WORDS, function_text, quoted

_LOADS = {
    "drive": "force or torque of the drive, N or N.m",
    "external": "that of everything else on the axis, N or N.m",
    "normal": "normal load, in the rig's SI unit",
    "position": "position, m or rad",
    "temperature": "temperature, K",
}
#: What the blocks declare: neither the package nor one of its functions is called after it.
_PINS = {"v", "v_ref", "force", "u", "h", "z", "p", "c", "at", "F"} | {
    *(s.name for s in SETTINGS),
    *(f"load_{x}" for x in LOADS),
}


def modelica(
    model: Model, name: str = "Friction", compensator: Compensator | None = None
) -> dict[str, bytes]:
    """The package of a model.

    Args:
        model: What was identified.
        name: Of the file and the package.
        compensator: Its settings; full feed-forward from the reference's velocity by default.

    Raises:
        InputError: a name that Modelica does not take, or a law that cannot be translated.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,60}", name) or name in WORDS | _PINS:
        raise InputError(
            f"name {name!r}: Modelica takes letters, digits and _, beginning with a letter, up to "
            "61, no word of its own and no variable of the blocks"
        )
    text = _Package(model, name, compensator or Compensator(feedback=False)).text()
    return {f"{name}.mo": text.encode("ascii")}


class _Package:
    """The package of one model."""

    def __init__(self, model: Model, name: str, compensator: Compensator) -> None:
        self.model, self.law, self.name, self.compensator = model, model.law, name, compensator
        program = lowered(model.program(*compensator_functions()), Blunt())
        helpers = [h for h in program.calls if h in HELPERS]
        own = (name, "Law", "Compensator", *helpers)
        parameters = [n for n, _ in model.named()]
        names = Identifiers([*WORDS, *_PINS, *parameters, *own], alike=False)
        self.called = {f.name: names.new(f.name) for f in program.functions}
        self.called |= {h: h for h in helpers}
        self.functions = [HELPERS[h] for h in helpers]
        self.functions += [function_text(f, self.called) for f in program.functions]
        self.reads = [x for x in LOADS if x in (*self.law.loads, *self.law.terms)]

    def text(self) -> str:
        """All of it."""
        said = html.escape("\n".join(self.model.head()), quote=False)
        info = quoted(
            f"<html><pre>{said}\n\nNo zero has a sign here: at v = 0.0 the law gives what holds on "
            "the + side.</pre></html>"
        )
        parts = [
            f'package {self.name} "Friction of an axis by the law {self.law.name}"',
            *self.functions,
            *self._law(),
            *self._compensator(),
            f'  annotation(Documentation(info = "{info}"));',
            f"end {self.name};",
            "",
        ]
        return ascii_text("\n".join(parts))

    def _names(self) -> Identifiers:
        own = (self.name, "Law", "Compensator", *self.called.values())
        return Identifiers([*WORDS, *own], alike=False)

    def _inputs(self, names: Identifiers, *velocities: tuple[str, str]) -> list[str]:
        speed = _unit(self.model.speed_unit)
        lines = [f'    input Real {names.new(n)}{speed} "{d}";' for n, d in velocities]
        return lines + [
            f'    input Real {names.new(f"load_{x}")} "{_LOADS[x]}";' for x in self.reads
        ]

    def _parameters(self, names: Identifiers) -> tuple[list[str], str]:
        """Their declarations, and all of them as an array."""
        lines, own = [], []
        for (n, q), value in zip(self.model.named(), self.model.p.tolist(), strict=True):
            own.append(names.new(n))
            lines.append(
                f'    parameter Real {own[-1]}{_unit(q.unit)} = {value!r} "{quoted(q.doc)}";'
            )
        return lines, f"{{{', '.join(own)}}}"

    def _given(self, v: str, h: str, z: str, p: str) -> str:
        """What `rubbed` is given, in the order of its arguments."""
        law = self.law
        loads = [f"load_{x}" if x in law.loads else "0.0" for x in LOADS]
        given = [v, *([h, z] if law.states else [])]
        given += [f"{{{', '.join(loads)}}}"] if law.loads else []
        return f"{self.called['rubbed']}({', '.join([*given, p])})"

    def _scale(self, p: str) -> str:
        """What the terms multiply friction by, with the sign of the product; nothing without."""
        factors = []
        for term, _, at, count in self.model.terms():
            given = ", ".join([f"load_{term}", *(f"{p}[{at + k + 1}]" for k in range(count))])
            factors.append(f"{self.called[f'{term}_factor']}({given})")
        return f"max({' * '.join(factors)}, 0.0) * " if factors else ""

    # --- the law

    def _law(self) -> list[str]:
        law, names = self.law, self._names()
        force_unit = self.model.force_unit
        inputs = self._inputs(names, ("v", "velocity"))
        force, h, z, p = map(names.new, ("force", "h", "z", "p"))
        parameters, every = self._parameters(names)
        lines = [f'  block Law "Friction by the law {law.name}, with the sign of the velocity"']
        lines += parameters
        if law.states:
            lines.append(f'    parameter Real {h}(unit = "s") = 1e-3 "sample time";')
        lines += inputs
        says = f'"friction, {force_unit}"'
        fixed = _unit(force_unit, "start = 0.0", "fixed = true")
        listed = f'    parameter Real {p}[{len(law.params)}] = {every} "the same, as a list";'
        scale = self._scale(p)
        if law.states:
            return [
                *lines,
                f"    discrete output Real {force}{fixed} {says};",
                "  protected",
                listed,
                *_states(z, law.states),
                "  algorithm",
                f"    when sample({h}, {h}) then",
                f"      ({force}, {z}) := {self._given('v', h, f'pre({z})', p)};",
                *([f"      {force} := {scale}{force};"] if scale else []),
                "    end when;",
                "  end Law;",
                "",
            ]
        said = (
            f"{self.called['steady']}(v, {p})" if law.rub is None else self._given("v", "", "", p)
        )
        return [
            *lines,
            f"    output Real {force}{_unit(force_unit)} {says};",
            "  protected",
            listed,
            "  equation",
            f"    {force} = {scale}{said};",
            "  end Law;",
            "",
        ]

    # --- the compensator

    def _compensator(self) -> list[str]:
        law, names, rotary = self.law, self._names(), self.model.rig.rotary
        inputs = self._inputs(
            names, ("v_ref", "velocity of the reference"), ("v", "measured velocity")
        )
        u, h, z, p, c, at, F = map(names.new, ("u", "h", "z", "p", "c", "at", "F"))
        settings, listed = [], []
        for s, value in zip(SETTINGS, self.compensator.c.tolist(), strict=True):
            n = names.new(s.name)
            if s.name == "feedback":
                on = "true" if value else "false"
                settings.append(
                    f"    parameter Boolean {n} = {on} "
                    '"true: law at the measured velocity, false: at that of the reference";'
                )
                listed.append(f"if {n} then 1.0 else 0.0")
            else:
                unit = _unit(s.rotary if rotary else s.unit)
                settings.append(f'    parameter Real {n}{unit} = {value!r} "{quoted(s.meaning)}";')
                listed.append(n)
        rests = f"{listed[1].split()[1]} and abs(v) <= {listed[2]}"
        parameters, every = self._parameters(names)
        fixed = _unit(self.model.force_unit, "start = 0.0", "fixed = true")
        return [
            '  block Compensator "What a controller adds to its command, once a sample"',
            *settings,
            *parameters,
            f'    parameter Real {h}(unit = "s") = 1e-3 "sample time";',
            *inputs,
            f'    discrete output Real {u}{fixed} "what to add to the command";',
            "  protected",
            f'    parameter Real {p}[{len(law.params)}] = {every} "of the law, as a list";',
            f'    parameter Real {c}[{len(SETTINGS)}] = {{{", ".join(listed)}}} "the same";',
            *(_states(z, law.states) if law.states else []),
            f'    discrete Real {at}(start = 0.0, fixed = true) "speed at which the law is asked";',
            f'    discrete Real {F}(start = 0.0, fixed = true) "the law\'s answer";',
            "  algorithm",
            f"    when sample(0.0, {h}) then",
            f"      {at} := {self.called['asked']}(v_ref, v, {c});",
            *self._asked(at, F, h, z, p, rests),
            f"      {u} := {self.called['shaped']}({F}, v_ref, v, {h}, pre({u}), {c});",
            "    end when;",
            "  end Compensator;",
            "",
        ]  # fmt: skip

    def _asked(self, at: str, F: str, h: str, z: str, p: str, rests: str) -> list[str]:
        """The law's answer; a resting axis keeps its states."""
        law, scale = self.law, self._scale(p)
        steady = f"{self.called['steady']}({at}, {p})"
        if law.rub is None:
            return [f"      {F} := {scale}{steady};"]
        if not law.states:
            return [f"      {F} := {scale}{self._given(at, '', '', p)};"]
        return [
            f"      if {rests} then",
            f"        {F} := {steady};",
            f"        {z} := pre({z});",
            "      else",
            f"        ({F}, {z}) := {self._given(at, h, f'pre({z})', p)};",
            "      end if;",
            *([f"      {F} := {scale}{F};"] if scale else []),
        ]


def _states(z: str, count: int) -> list[str]:
    start = "(each start = 0.0, each fixed = true)"
    return [f'    discrete Real {z}[{count}]{start} "states, 0.0 where bristles are relaxed";']


def _unit(unit: str, *more: str) -> str:
    """A variable's modification: its unit in Modelica's way of writing them."""
    said = [f'unit = "{unit.replace(" ", ".")}"'] if unit else []
    return f"({', '.join([*said, *more])})" if said or more else ""
