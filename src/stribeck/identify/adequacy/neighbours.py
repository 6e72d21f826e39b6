"""Other joints that move in a log: how far, and whether that changes the inertia of the axis."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...data.readers.choice import known_unit
from ...data.readers.heads import ENDS, meanings, take_apart
from ...space import Array
from ..conditions import Violation
from ..displaced_inertia import INERTIA

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ..parameters import Parameters

#: A column is a joint's position or speed if its name says so, a number before or behind it.
_NUMBER = re.compile(r"_?\d+_?")
_NAMELESS = re.compile(r"column \d+")
#: A joint moves if it covers this share of the axis's own travel.
MOVES = 0.05
#: What an angle that changes by as much, rad, does to the inertia of a joint that carries it is
#: about as large a share: below, it is within the tenth that "identified" allows.
MATTERS = 0.05
#: A column goes with another, or with its slope, at this correlation.
_SAME = 0.99
#: Samples by which columns without names are compared.
_SAMPLES = 2000


@dataclass(frozen=True)
class Neighbour:
    """A joint beside the axis.

    Args:
        column: The head of its position, or of its speed where there is no other.
        travel: From its least to its greatest position, SI where the head says the unit; of its
            speed where it has no position.
        speed: Whether that is of a speed.
        unit: Of the travel, empty where the head has none.
    """

    column: str
    travel: float
    speed: bool = False
    unit: str = ""


def neighbour_violations(
    parameters: Parameters, recordings: Sequence[Recording]
) -> list[Violation]:
    """Other joints that move in a log, and the inertia that is then that of their poses alone.

    Args:
        parameters: Rig and law.
        recordings: The logs trained on.
    """
    moving: dict[str, Neighbour] = {}
    for log in recordings:
        for n in neighbours(log) if log.known_force is None else ():
            if n.column not in moving or n.travel > moving[n.column].travel:
                moving[n.column] = n
    if not moving:
        return []
    rig = parameters.rig
    names = _listed(sorted(moving.values(), key=lambda n: (n.speed, -n.travel)))
    inertia = frozenset(q.name for q in parameters.free) & INERTIA
    matters = rig.rotary and any(n.speed or n.travel > MATTERS for n in moving.values())
    if not inertia or not matters:
        sentence = (
            f"other joints move in the log ({names}): what they push at this axis is in its force"
        )
        return [Violation("model", sentence, caps=False)]
    labels = " and ".join(sorted(map(rig.label, inertia)))
    return [
        Violation(
            "model",
            f"other joints move in the log ({names}): their motion changes the inertia of this "
            f"axis and pushes at it, so {labels} is no constant; record this joint alone, or "
            "subtract a torque that knows them (subtract)",
            inertia,
        )
    ]


def _listed(moving: Sequence[Neighbour], limit: int = 4) -> str:
    shown = [f"{n.column} by {n.travel:.3g} {n.unit}".rstrip() for n in moving[:limit]]
    return ", ".join(shown) + (f" and {len(moving) - limit} more" * (len(moving) > limit))


def neighbours(log: Recording) -> list[Neighbour]:
    """The joints that a log shows moving beside its axis, by their positions where it has these."""
    positions, speeds = _joints(log)
    if positions:
        travel = float(np.ptp(log.position))
        return [n for n in positions if n.travel > MOVES * travel]
    if not speeds:
        return []
    speed = float(np.ptp(np.gradient(log.position, log.t)))
    return [n for n in speeds if n.travel > MOVES * speed]


def _joints(log: Recording) -> tuple[list[Neighbour], list[Neighbour]]:
    """Positions and speeds of other joints, by their heads or by what they are."""
    positions, speeds = _paired(log)
    for name, values in log.extra.items():
        meaning = _meaning(name)
        if meaning and not _own(values, log):
            factor, si = _unit(meaning, name)
            n = Neighbour(name, factor * float(np.ptp(values)), meaning == "velocity", si)
            (speeds if n.speed else positions).append(n)
    return positions, speeds


def _meaning(name: str) -> str:
    """Whether a head names the position or the velocity of one of several joints; else empty."""
    head = take_apart(name)
    bare = _NUMBER.sub("_", head.stem).strip("_")
    numbered = bare != head.stem
    named = meanings(type(head)(bare, head.unit))
    for channel in ("position", "velocity"):
        rank = named.get(channel)
        if rank is not None and (numbered or rank == ENDS):
            return channel
    return ""


def _unit(meaning: str, name: str) -> tuple[float, str]:
    """The factor of a head's unit to SI, and that; 1 and nothing where it states none."""
    written = take_apart(name).unit
    unit = known_unit(meaning, written) if written else None
    return (1.0, "") if unit is None else (unit.factor, unit.dimension)


def _own(values: Array, log: Recording) -> bool:
    """Whether a column goes with one of the axis itself: its command, or another unit of it."""
    own = (log.position, log.velocity, log.command)
    return any(a is not None and _alike(values, a) for a in own)


def _alike(a: Array, b: Array) -> bool:
    a, b = a - a.mean(), b - b.mean()
    length = float(np.sqrt((a @ a) * (b @ b)))
    return length > 0 and abs(float(a @ b)) > _SAME * length


def _paired(log: Recording) -> tuple[list[Neighbour], list[Neighbour]]:
    """Columns without names of which one is the slope of the other: positions of joints."""
    names = [n for n in log.extra if _NAMELESS.fullmatch(n)]
    if len(names) < 2:  # noqa: PLR2004 - a pair
        return [], []
    every = slice(None, None, max(1, len(log) // _SAMPLES))
    columns = np.array([log.extra[n][every] for n in names])
    slopes = np.gradient(columns, log.t[every], axis=1)
    goes = _correlation(slopes, columns) > _SAME
    np.fill_diagonal(goes, val=False)
    return [
        Neighbour(names[i], float(np.ptp(log.extra[names[i]])))
        for i in np.flatnonzero(goes.any(axis=1))
        if not _own(log.extra[names[i]], log)
    ], []


def _correlation(a: Array, b: Array) -> Array:
    """Of all rows of two tables, (k, k)."""
    a, b = (x - x.mean(axis=1, keepdims=True) for x in (a, b))
    lengths = [np.sqrt(np.einsum("ij,ij->i", x, x)) for x in (a, b)]
    lengths = [np.where(n > 0, n, np.inf) for n in lengths]
    return np.asarray((a / lengths[0][:, None]) @ (b / lengths[1][:, None]).T)
