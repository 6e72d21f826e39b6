"""What the gate finds in a log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from ...units import unit

if TYPE_CHECKING:
    from ..recording import Recording

Kind = Literal[
    "clipping", "reset", "jump", "missing rows", "contradiction", "frozen", "held", "gap",
]  # fmt: skip

#: In which unit a channel is shown to people.
SHOWN = {"m": "mm", "rad": "mrad", "m/s": "mm/s", "rad/s": "mrad/s", "m/s**2": "mm/s**2",
         "rad/s**2": "rad/s**2", "Pa": "bar"}  # fmt: skip
#: Millimetres or milliradians from which on metres or radians read better.
MANY = 1e4


@dataclass(frozen=True, eq=False)
class Fault:
    """A channel of a log that is not what it seems.

    Args:
        kind: What it suffers from.
        channel: Which.
        rows: The samples it concerns, (N,).
        size: How much: the share of samples for clipping, seconds for time, SI units else.
        sentence: What, where and how much, without the name of the log.
        harmful: Whether estimates from these samples are biased by it.
    """

    kind: Kind
    channel: str
    rows: NDArray[np.bool_]
    size: float
    sentence: str
    harmful: bool = True


def shown(value: float, si: str) -> str:
    """A value in SI as people read it, with its unit."""
    written = SHOWN.get(si, si)
    scaled = float(unit(written).from_si(value))
    if abs(scaled) >= MANY:
        scaled, written = value, si
    return f"{scaled:.4g} {written.replace('**2', '²')}"


def shown_as(recording: Recording, channel: str, value: float) -> str:
    """A value of a channel as people read it."""
    return shown(value, recording.si_unit(channel))


def mask(n: int, rows: NDArray[np.intp] | slice | list[int]) -> NDArray[np.bool_]:
    """Samples as a mask over all of them."""
    result = np.zeros(n, dtype=bool)
    result[rows] = True
    return result
