"""The registries of laws, methods and rigs as JSON, for programs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, asdict, fields
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..friction import LAWS, Law, law_named
from ..optimize import METHODS
from ..rig import RIGS
from ..rig.rig import shown_in
from .format import json_text
from .registries import meanings, summary

if TYPE_CHECKING:
    from ..rig import Rig
    from ..space import Param


def laws_text(name: str | None) -> str:
    """All laws, or one: what each is, with its parameters in SI."""
    laws = LAWS if name is None else {name: law_named(name)}
    return json_text({n: _law(law) for n, law in laws.items()})


def methods_text(name: str | None) -> str:
    """All search methods, or one: what each does, with its settings and their defaults."""
    if name is not None and name not in METHODS:
        raise InputError(f"no method {name!r}: there are {', '.join(METHODS)}")
    chosen = METHODS if name is None else {name: METHODS[name]}
    return json_text({n: _method(kind) for n, kind in chosen.items()})


def rigs_text(rig: Rig | None) -> str:
    """All rigs, or one: what each is, with its constants and parameters in the units it shows."""
    rigs: Mapping[str, Rig] = RIGS if rig is None else {rig.name: rig}
    return json_text({n: _rig(r) for n, r in rigs.items()})


def _law(law: Law) -> dict[str, Any]:
    return {
        "doc": law.doc,
        "formula": law.formula,
        "cite": law.cite,
        "states": law.states,
        "loads": list(law.loads),
        "parameters": {q.name: _param(q) for q in law.params},
    }


def _param(q: Param) -> dict[str, Any]:
    return {"doc": q.doc, "unit": q.unit, "low": q.lower, "high": q.upper, "fixed": q.fixed}


def _method(kind: Any) -> dict[str, Any]:
    said = meanings(kind)
    settings = {
        f.name: {
            "default": str(f.default) if f.default is not MISSING else None,
            "doc": said.get(f.name, ""),
        }
        for f in fields(kind)
    }
    return {"doc": summary(kind), "settings": settings}


def _rig(rig: Rig) -> dict[str, Any]:
    law = law_named(rig.laws[0])
    constants = {
        c.name: {"value": c.shown, "tolerance": c.shown_tolerance, "unit": c.unit, "doc": c.doc,
                 "origin": c.origin, "source": c.source}
        for c in rig.constants
    }  # fmt: skip
    parameters = {
        rig.label(q.name): {
            "doc": q.doc,
            "unit": rig.unit_of(q),
            "low": float(shown_in(rig, q, q.lower)),
            "high": float(shown_in(rig, q, q.upper)),
            "fixed": q.fixed,
        }
        for q in rig.parameters(law)
    }
    equation = rig.equation(law_named(rig.laws[0]))
    return {
        "doc": rig.doc,
        "cite": rig.cite,
        "approach": rig.approach,
        "rotary": rig.rotary,
        "composition": [asdict(block) for block in rig.composition],
        "equation": None if equation is None else equation.text.split(";  "),
        "laws": list(rig.laws),
        "constants": constants,
        "parameters": parameters,
        "columns": dict(rig.columns),
    }
