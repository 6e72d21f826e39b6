"""What was measured: logs read, checked, and taken apart into strokes, rests and slips."""

from .quality import Quality, check
from .readers.read import read
from .recording import CHANNELS, Recording, Source
from .segmentation import Segments, Slip, Stroke, noise, rests, segment, slips, step, strokes

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
