"""A balance of an axis that moves one way, where a constant force looks like Coulomb friction."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...rig.rig import stem
from ...wording import option
from ..conditions import Violation

if TYPE_CHECKING:
    from ..parameters import Parameters
    from .regression import System

OFFSET = "offset"
#: Parameters of a law that a constant force adds to while the axis moves one way.
_LEVELS = {"F_C", "F_S"}
#: A way back below this share of the way forth is none: so little of it is noise, or the turn of a
#: compliant drive, and tells nothing of friction there.
_BACK = 0.02


def moves_one_way(system: System) -> bool:
    """Whether the rows of a balance are of one direction."""
    v = np.concatenate([log.pick(log.v) for log in system.logs])
    ways = sorted([float(v[v > 0].sum()), float(-v[v < 0].sum())])
    return ways[0] < _BACK * ways[1]


def without_offset(parameters: Parameters) -> Parameters:
    """The parameters with the offset held at 0, unless there is none or its range is the user's."""
    free = tuple(q for q in parameters.free if q.name != OFFSET)
    if len(free) == len(parameters.free) or OFFSET in parameters.bounded or not free:
        return parameters
    fixed = {**parameters.fixed, OFFSET: 0.0}
    return replace(parameters, free=free, fixed=fixed, held=parameters.held | {OFFSET})


def one_way_violations(parameters: Parameters) -> list[Violation]:
    """What holding the offset means for the friction, where it is held for that reason."""
    if OFFSET not in parameters.held:
        return []
    levels, label = levels_of(parameters), parameters.rig.label
    part = f" and is part of {' and '.join(map(label, levels))}" if levels else ""
    sentence = (
        "the axis moves one way only, where a constant force looks like friction: "
        f"{label(OFFSET)} is held at 0{part}: log the other way too, or say what it is "
        f"({option('fixed', {label(OFFSET): 0})})"
    )
    return [Violation("data", sentence, frozenset(levels) or None)]


def levels_of(parameters: Parameters) -> list[str]:
    """The free parameters that a constant force adds to while the axis moves one way."""
    return [q.name for q in parameters.free if stem(q.name) in _LEVELS]
