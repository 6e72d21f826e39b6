"""What there is to choose from: rigs with their constants, parts, laws, methods and drives."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

from ..drive import CONVENTIONS
from ..drive.chain_numbers import ACTING, NUMBERS, example_of
from ..report.registry_documents import laws_text, methods_text, rigs_text
from ..rig import Rig
from ..rig.parts import PARTS, Part
from ..rig.parts.axis_of_parts import motor_turns


@cache
def catalogue() -> dict[str, Any]:
    """All of it as one document."""
    return {
        "rigs": json.loads(rigs_text(None)),
        "laws": json.loads(laws_text(None)),
        "methods": json.loads(methods_text(None)),
        "parts": [_part(part) for part in PARTS.values()],
        "drives": [
            {"name": c.name, "drives": c.drives, "object": c.object, "needs": list(c.needs),
             "meaning": c.meaning, "note": c.note, "examples": dict(c.examples)}
            for c in CONVENTIONS.values()
        ],
        "numbers": {
            name: {"doc": doc, "example": example_of(name), "acting": name in ACTING}
            for name, (_, doc) in NUMBERS.items()
        },
    }  # fmt: skip


def rig_document(rig: Rig) -> dict[str, Any]:
    """A rig as the catalogue has those that are shipped."""
    (document,) = json.loads(rigs_text(rig)).values()
    return dict(document)


def _part(part: Part) -> dict[str, Any]:
    return {
        "role": part.role,
        "name": part.name,
        "doc": part.doc,
        "equation": part.contribution,
        "rotary": part.rotary,
        "turns": motor_turns([part], rotary=False),
        "coefficients": [
            {
                "name": c.name,
                "unit": c.written(rotary=False),
                "rotary_unit": c.written(rotary=True),
                "at_motor": c.at_motor,
                "doc": c.doc,
                "idle": None if c.idle is None else f"{c.idle:g}",
                "range": f"{c.lower:g} … {c.upper:g}",
            }
            for c in part.coefficients
        ],
    }
