"""Whether a fit holds beyond its training data, and explains the force as well as it was measured.

What is said here takes no verdict away: it is told.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..conditions import Violation

if TYPE_CHECKING:
    from ..score import HeldOut, Score

#: A held-out error of so many times that of training is told.
HELD_OUT = 1.5
#: Fewest samples held out that say so.
FEWEST = 50


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
