"""What was measured: logs read, checked, and taken apart into strokes, rests and slips."""

from .channels import CHANNELS
from .quality import Quality, check
from .readers.read import read
from .recording import Recording, Source
from .resolution import noise, step
from .segmentation import Segments, Slip, Stroke, rests, segment, slips, strokes

__all__ = [
    "CHANNELS",
    "Quality",
    "Recording",
    "Segments",
    "Slip",
    "Source",
    "Stroke",
    "check",
    "noise",
    "read",
    "rests",
    "segment",
    "slips",
    "step",
    "strokes",
]
