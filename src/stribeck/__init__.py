"""From a motion log to a friction model you can trust.

    from stribeck import identify

    fit = identify("axis.csv", rig="slide-bed", train="112:295", holdout="44:112")

A log is a file, a `Recording`, a frame of polars or pandas, or a dict of columns. Names are
imported when they are first used: `import stribeck` costs next to nothing.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from . import presenters
from ._version import __version__ as __version__

if TYPE_CHECKING:
    from .compensate.compensation import Compensation, compensate
    from .data import Quality, Recording, check, read
    from .errors import InputError
    from .export import TARGETS, export
    from .fleet.drift import drift
    from .fleet.drift_verdict import Drift
    from .fleet.fleet_run import Fleet, fleet
    from .friction import LAWS, Law
    from .identify.card import Card, read_card
    from .identify.design.plan import Plan, plan
    from .identify.fit import identify
    from .identify.problem import problem
    from .identify.result import Fit
    from .identify.selection.select import Selection, select
    from .identify.simulate import simulate
    from .identify.validate import validate
    from .optimize import METHODS, Run, Search, minimize
    from .report.page.fit_page import report
    from .rig import RIGS, Rig
    from .rig.twin import twin
    from .space import Param, Space

__all__ = [
    "LAWS",
    "METHODS",
    "RIGS",
    "TARGETS",
    "Card",
    "Compensation",
    "Drift",
    "Fit",
    "Fleet",
    "InputError",
    "Law",
    "Param",
    "Plan",
    "Quality",
    "Recording",
    "Rig",
    "Run",
    "Search",
    "Selection",
    "Space",
    "check",
    "compensate",
    "drift",
    "export",
    "fleet",
    "identify",
    "minimize",
    "plan",
    "problem",
    "read",
    "read_card",
    "report",
    "select",
    "simulate",
    "twin",
    "validate",
]

#: The module that each public name is from.
_HOMES = {
    "LAWS": "friction",
    "METHODS": "optimize",
    "RIGS": "rig",
    "TARGETS": "export",
    "Card": "identify.card",
    "Compensation": "compensate.compensation",
    "Drift": "fleet.drift_verdict",
    "Fit": "identify.result",
    "Fleet": "fleet.fleet_run",
    "InputError": "errors",
    "Law": "friction",
    "Param": "space",
    "Plan": "identify.design.plan",
    "Quality": "data",
    "Recording": "data",
    "Rig": "rig",
    "Run": "optimize",
    "Search": "optimize",
    "Selection": "identify.selection.select",
    "Space": "space",
    "check": "data",
    "compensate": "compensate.compensation",
    "drift": "fleet.drift",
    "export": "export.targets",
    "fleet": "fleet.fleet_run",
    "identify": "identify.fit",
    "minimize": "optimize",
    "plan": "identify.design.plan",
    "problem": "identify.problem",
    "read": "data",
    "read_card": "identify.card",
    "report": "report.page.fit_page",
    "select": "identify.selection.select",
    "simulate": "identify.simulate",
    "twin": "rig.twin",
    "validate": "identify.validate",
}
#: Functions that have the name of the package that they are from.
_NAMESAKES = frozenset({"compensate", "export", "fleet", "identify", "report"})
#: What shows a result, by name.
_PRESENTERS = {
    "card": "identify.fit_card.fit_card",
    "card_html": "report.notebook.card_html",
    "compensation_html": "report.notebook.compensation_html",
    "figure": "report.figures.fit_figures.fit_figure",
    "files": "report.folder.write_exported",
    "fit_html": "report.notebook.fit_html",
    "plan_html": "report.notebook.plan_html",
    "quality_html": "report.notebook.quality_html",
    "recording_html": "report.notebook.recording_html",
    "report": "report.page.fit_page.report",
    "selection_html": "report.notebook.selection_html",
}


def _presenter(name: str) -> Any:
    module, _, function = _PRESENTERS[name].rpartition(".")
    return getattr(import_module(f".{module}", __name__), function)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
    if name in _NAMESAKES:  # `stribeck.identify.card` is what it is for who imported that
        value.__dict__ = vars(import_module(f".{name}", __name__))
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])


class _Root(ModuleType):
    """The package, in which a function keeps its name although its package has the same.

    Python would replace `stribeck.identify`, the function, by the package `stribeck.identify`
    whenever a file of that is first imported.
    """

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _NAMESAKES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Root
presenters.provide(_presenter)
