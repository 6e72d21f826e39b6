"""From a motion log to a friction model you can trust.

    from stribeck import identify, read

    fit = identify(read("axis.csv"), rig="slide-bed", train="112:295", holdout="44:112")

Names are imported when they are first used: `import stribeck` costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .data import Recording, read
    from .errors import InputError
    from .export import TARGETS, exported, read_model
    from .export.compensation import compensation
    from .friction import LAWS, Law
    from .identify.card import Card, card, read_card
    from .identify.fit import identify
    from .identify.found import Fit
    from .identify.problem import problem
    from .identify.select import Selection, select
    from .identify.validate import validate
    from .optimize import METHODS, Run, Search, minimize
    from .rig import RIGS, Rig
    from .space import Param, Space

__version__ = "0.1.0"

__all__ = [
    "LAWS",
    "METHODS",
    "RIGS",
    "TARGETS",
    "Card",
    "Fit",
    "InputError",
    "Law",
    "Param",
    "Recording",
    "Rig",
    "Run",
    "Search",
    "Selection",
    "Space",
    "card",
    "compensation",
    "exported",
    "identify",
    "minimize",
    "problem",
    "read",
    "read_card",
    "read_model",
    "select",
    "validate",
]

_HOMES = {
    "LAWS": "friction",
    "METHODS": "optimize",
    "RIGS": "rig",
    "TARGETS": "export",
    "Card": "identify.card",
    "Fit": "identify.found",
    "InputError": "errors",
    "Law": "friction",
    "Param": "space",
    "Recording": "data",
    "Rig": "rig",
    "Run": "optimize",
    "Search": "optimize",
    "Selection": "identify.select",
    "Space": "space",
    "card": "identify.card",
    "compensation": "export.compensation",
    "exported": "export",
    "minimize": "optimize",
    "problem": "identify.problem",
    "read": "data",
    "read_card": "identify.card",
    "read_model": "export",
    "select": "identify.select",
    "validate": "identify.validate",
}


def __getattr__(name: str) -> Any:
    if name == "identify":
        return import_module(".identify", __name__)  # a package that can be called
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
