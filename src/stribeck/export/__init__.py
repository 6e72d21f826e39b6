"""Out of the house: a model for a controller, a drive, a simulator. One file a target."""

from .model import Model, as_model, read_model
from .targets import TARGETS, Exported, Source, Target, exported

__all__ = ["TARGETS", "Exported", "Model", "Source", "Target", "as_model", "exported", "read_model"]
