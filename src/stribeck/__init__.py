"""From a motion log to a friction model you can trust.

    from stribeck import identify, read

    fit = identify(read("axis.csv"), rig="slide-bed", train="112:295", holdout="44:112")

Names are imported when they are first used: `import stribeck` costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ._version import __version__ as __version__

if TYPE_CHECKING:
    from .compensate.compensation import compensation
    from .data import Recording, read
    from .errors import InputError
    from .export import TARGETS, exported, read_model
    from .friction import LAWS, Law
    from .identify.card import Card, card, read_card
    from .identify.fit import identify
    from .identify.problem import problem
    from .identify.result import Fit
    from .identify.selection.select import Selection, select
    from .identify.validate import validate
    from .optimize import METHODS, Run, Search, minimize
    from .rig import RIGS, Rig
    from .space import Param, Space

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
    "Fit": "identify.result",
    "InputError": "errors",
    "Law": "friction",
    "Param": "space",
    "Recording": "data",
    "Rig": "rig",
    "Run": "optimize",
    "Search": "optimize",
    "Selection": "identify.selection.select",
    "Space": "space",
    "card": "identify.card",
    "compensation": "compensate.compensation",
    "exported": "export",
    "minimize": "optimize",
    "problem": "identify.problem",
    "read": "data",
    "read_card": "identify.card",
    "read_model": "export",
    "select": "identify.selection.select",
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
