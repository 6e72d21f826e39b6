"""Exports: an identified model as a file for a controller, a drive or a simulator.

`TARGETS` lists them, `export` makes one. A target is one entry there and one function of a
`Model`; `code/` has programming languages, `robot/` robot descriptions, `fmu/` the co-simulation
unit.
"""

from .model import Model, as_model, model_of, read_model
from .targets import TARGETS, Exported, ExportTarget, export

__all__ = [
    "TARGETS",
    "ExportTarget",
    "Exported",
    "Model",
    "as_model",
    "export",
    "model_of",
    "read_model",
]
