"""Whether a fit holds beyond its training data, and explains the force as well as it was measured.

What is said here takes no verdict away: it is told.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...space import Array
from ..conditions import Violation
from ..displaced_inertia import INERTIA

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ..parameters import Parameters
    from ..score import HeldOut, Score

#: A held-out error of so many times that of training is told.
HELD_OUT = 1.5
#: Fewest samples held out that say so.
FEWEST = 50
#: Columns of a log that are positions or speeds of one of several joints: a stem and a number.
_JOINT = re.compile(
    r"(?:\w*_)?(?:q|qd|pos|position|vel|velocity|angle|theta|joint)[\s_\[]*(\d+)\b.*"
)
#: A joint moves if it covers this share of the identified one's travel.
_MOVES = 0.05


def held_out_violations(score: Score, holdout: Sequence[HeldOut]) -> list[Violation]:
    """Ranges that test nothing, or whose error is far above that of training, a sentence each.

    Args:
        score: Of the training data.
        holdout: Each range held out, with its score.
    """
    idle = [
        Violation(
            "data",
            f"hold-out {'all' if h.within is None else h.within.text} tests nothing: the axis "
            "does not move in it; hold out a range in which it moves",
            caps=False,
        )
        for h in holdout
        if not h.scope.moves
    ]
    return idle + [
        Violation(
            "model",
            f"hold-out {'all' if h.within is None else h.within.text} has "
            f"{h.score.value / score.value:.2g} times the error of training ({h.score.value:.3g}, "
            f"not {score.value:.3g} {score.unit}): what was found holds for the training data; "
            "train on more of the range in which it is to hold",
            caps=False,
        )
        for h in holdout
        if h.scope.moves
        and h.score.samples >= FEWEST
        and h.score.value > HELD_OUT * score.value > 0
    ]


def neighbour_violations(
    parameters: Parameters, recordings: Sequence[Recording]
) -> list[Violation]:
    """Other joints that move in a log: then an inertia is that of their poses alone.

    Args:
        parameters: Rig and law.
        recordings: The logs trained on.
    """
    inertia = frozenset(q.name for q in parameters.free) & INERTIA
    moving = {name for log in recordings for name in moving_joints(log)}
    if not inertia or not moving:
        return []
    names = ", ".join(sorted(moving)[:4])
    labels = " and ".join(sorted(map(parameters.rig.label, inertia)))
    return [
        Violation(
            "model",
            f"other joints move in the log ({names}): their motion changes the inertia of this "
            f"axis and pushes at it, so {labels} is no constant; record this joint alone",
            inertia,
        )
    ]


def moving_joints(log: Recording) -> list[str]:
    """The columns of a log that show other joints moving."""
    travel = float(np.ptp(log.position))
    return [
        name
        for name, values in log.extra.items()
        if _JOINT.fullmatch(name.strip().lower())
        and float(np.ptp(values)) > _MOVES * travel
        and not _same(values, log.position)
        and (log.velocity is None or not _same(values, log.velocity))
    ]


def _same(values: Array, own: Array) -> bool:
    """Whether a column goes with one of the axis itself: its command, or another unit of it."""
    a, b = values - values.mean(), own - own.mean()
    length = float(np.sqrt((a @ a) * (b @ b)))
    return length > 0 and abs(float(a @ b)) > 0.99 * length
