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
from ..model import Model
from .ascii_text import ascii_text
from .identifiers import Identifiers
from .law_program import law_program
from .lowering import Restrictions, lowered
from .modelica_dialect import HELPERS, WORDS, function_text, quoted

_LOADS = {
    "drive": "force or torque of the drive, N or N.m",
    "external": "that of everything else on the axis, N or N.m",
    "normal": "normal load, in the rig's SI unit",
    "position": "position, m or rad",
    "temperature": "temperature, K",
}
#: What the blocks declare: neither the package nor one of its functions is called after it.
_PINS = {"v", "v_ref", "force", "u", "h", "z", "p", "c"} | {
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
    text = _PackageText(model, name, compensator or Compensator(feedback=False)).text()
    return {f"{name}.mo": text.encode("ascii")}


class _PackageText:
    """The package of one model."""

    def __init__(self, model: Model, name: str, compensator: Compensator) -> None:
        self.model, self.law, self.name, self.compensator = model, model.law, name, compensator
        self.program = law_program(model.law)
        program = lowered(self.program, Restrictions(returns=True))
        helpers = [h for h in program.calls if h in HELPERS]
        reserved = (name, "Law", "Compensator", *helpers)
        parameters = [n for n, _ in model.named()]
        names = Identifiers([*WORDS, *_PINS, *parameters, *reserved], alike=False)
        self.called = {f.name: names.new(f.name) for f in program.functions}
        self.called |= {h: h for h in helpers}
        self.functions = [HELPERS[h] for h in helpers]
        self.functions += [function_text(f, self.called) for f in program.functions]
        self.reads = [x for x in LOADS if x in (*self.law.loads, *self.law.terms)]

    def text(self) -> str:
        """All of it."""
        head = html.escape("\n".join(self.model.head()), quote=False)
        info = quoted(
            f"<html><pre>{head}\n\nNo zero has a sign here: at v = 0.0 the law gives what holds on "
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
        reserved = (self.name, "Law", "Compensator", *self.called.values())
        return Identifiers([*WORDS, *reserved], alike=False)

    def _inputs(self, names: Identifiers, *velocities: tuple[str, str]) -> list[str]:
        speed = _unit(self.model.speed_unit)
        lines = [f'    input Real {names.new(n)}{speed} "{d}";' for n, d in velocities]
        return lines + [
            f'    input Real {names.new(f"load_{x}")} "{_LOADS[x]}";' for x in self.reads
        ]

    def _parameters(self, names: Identifiers) -> tuple[list[str], str]:
        """Their declarations, and all of them as an array."""
        lines, parameter_names = [], []
        for (n, q), value in zip(self.model.named(), self.model.p.tolist(), strict=True):
            name = names.new(n)
            parameter_names.append(name)
            lines.append(f'    parameter Real {name}{_unit(q.unit)} = {value!r} "{quoted(q.doc)}";')
        return lines, f"{{{', '.join(parameter_names)}}}"

    def _call(self, name: str, **texts: str) -> str:
        """A call of a function of the program; loads that the law does not read are 0."""
        loads = [f"load_{x}" if x in self.reads else "0.0" for x in LOADS]
        texts = {"load": f"{{{', '.join(loads)}}}", **texts}
        return f"{self.called[name]}({', '.join(self.program.arguments(name, texts))})"

    def _scale(self, p: str) -> str:
        """What the terms multiply friction by, with the sign of the product; nothing without."""
        return f"{self._call('factor', p=p)} * " if self.law.terms else ""

    # --- the law

    def _law(self) -> list[str]:
        law, names = self.law, self._names()
        force_unit = self.model.force_unit
        inputs = self._inputs(names, ("v", "velocity"))
        force, h, z, p = map(names.new, ("force", "h", "z", "p"))
        parameters, values = self._parameters(names)
        lines = [f'  block Law "Friction by the law {law.name}, with the sign of the velocity"']
        lines += parameters
        if law.states:
            lines.append(f'    parameter Real {h}(unit = "s") = 1e-3 "sample time";')
        lines += inputs
        says = f'"friction, {force_unit}"'
        fixed = _unit(force_unit, "start = 0.0", "fixed = true")
        listed = f'    parameter Real {p}[{len(law.params)}] = {values} "the same, as a list";'
        scale = self._scale(p)
        if law.states:
            before = f"pre({z})"
            advanced = self._call("rubbed", v="v", h=h, z=before, p=p, out=before)
            return [
                *lines,
                f"    discrete output Real {force}{fixed} {says};",
                "  protected",
                listed,
                *_states(z, law.states),
                "  algorithm",
                f"    when sample({h}, {h}) then",
                f"      ({force}, {z}) := {advanced};",
                *([f"      {force} := {scale}{force};"] if scale else []),
                "    end when;",
                "  end Law;",
                "",
            ]
        force_now = self._call("steady" if law.rub is None else "rubbed", v="v", p=p)
        return [
            *lines,
            f"    output Real {force}{_unit(force_unit)} {says};",
            "  protected",
            listed,
            "  equation",
            f"    {force} = {scale}{force_now};",
            "  end Law;",
            "",
        ]

    # --- the compensator

    def _compensator(self) -> list[str]:
        law, names, rotary = self.law, self._names(), self.model.rig.rotary
        inputs = self._inputs(
            names, ("v_ref", "velocity of the reference"), ("v", "measured velocity")
        )
        u, h, z, p, c = map(names.new, ("u", "h", "z", "p", "c"))
        settings, listed = [], []
        for s, value in zip(SETTINGS, self.compensator.c.tolist(), strict=True):
            n = names.new(s.name)
            if s.name == "feedback":
                initial = "true" if value else "false"
                settings.append(
                    f"    parameter Boolean {n} = {initial} "
                    '"true: law at the measured velocity, false: at that of the reference";'
                )
                listed.append(f"if {n} then 1.0 else 0.0")
            else:
                unit = _unit(s.rotary if rotary else s.unit)
                settings.append(f'    parameter Real {n}{unit} = {value!r} "{quoted(s.meaning)}";')
                listed.append(n)
        parameters, values = self._parameters(names)
        fixed = _unit(self.model.force_unit, "start = 0.0", "fixed = true")
        output = self._call(
            "compensator_output", factor=self._call("factor", p=p) if law.terms else "",
            v_ref="v_ref", v="v", h=h, before=f"pre({u})", z=f"pre({z})", p=p, c=c,
            out=f"pre({z})",
        )  # fmt: skip
        return [
            '  block Compensator "What a controller adds to its command, once a sample"',
            *settings,
            *parameters,
            f'    parameter Real {h}(unit = "s") = 1e-3 "sample time";',
            *inputs,
            f'    discrete output Real {u}{fixed} "what to add to the command";',
            "  protected",
            f'    parameter Real {p}[{len(law.params)}] = {values} "of the law, as a list";',
            f'    parameter Real {c}[{len(SETTINGS)}] = {{{", ".join(listed)}}} "the same";',
            *(_states(z, law.states) if law.states else []),
            "  algorithm",
            f"    when sample(0.0, {h}) then",
            f"      {f'({u}, {z})' if law.states else u} := {output};",
            "    end when;",
            "  end Compensator;",
            "",
        ]  # fmt: skip


def _states(z: str, count: int) -> list[str]:
    start = "(each start = 0.0, each fixed = true)"
    return [f'    discrete Real {z}[{count}]{start} "states, 0.0 where bristles are relaxed";']


def _unit(unit: str, *more: str) -> str:
    """A variable's modification: its unit in Modelica's way of writing them."""
    modifiers = [f'unit = "{unit.replace(" ", ".")}"'] if unit else []
    return f"({', '.join([*modifiers, *more])})" if modifiers or more else ""
