"""Descents from many starts, thinned out as they go: for misfits whose basins are wide."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import ClassVar

import numpy as np

from ..space import Array, Rng, Space
from .box import Box
from .moves import Answer, Detailed, Moves, Note
from .trust_region import Minimum, least_squares


@dataclass(frozen=True, eq=False)
class Descents:
    """Least squares from drawn starts, all in step; after each round the best of them go on.

    Args:
        draw: Starts in the unit cube, (n, dim), from a generator.
        rounds: For each round, how many descents take part, and how many evaluations a parameter
            each may ask for in it.
    """

    draw: Callable[[Rng], Array]
    rounds: tuple[tuple[int, int], ...] = ((16, 4), (6, 6), (3, 60))

    name: ClassVar[str] = "descents"

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str]:
        """Yield the points of all descents that take part, a batch a step."""
        box = Box(space)
        descents = [_Descent(least_squares(box.orderly(u), box)) for u in self.draw(rng)]
        for k, (most, rows) in enumerate(self.rounds, 1):
            descents = sorted(descents, key=lambda d: d.cost)[:most]
            note(stage="descents", round=k)
            limits = [d.spent + rows * space.dim for d in descents]
            while asking := [
                d for d, limit in zip(descents, limits, strict=True) if d.open and d.spent < limit
            ]:
                answer: Answer = yield Detailed(np.concatenate([d.points for d in asking]))
                first = 0
                for d in asking:
                    stop = first + len(d.points)
                    rows_shown = None if answer.residuals is None else answer.residuals[first:stop]
                    d.advance(Answer(answer.costs[first:stop], rows_shown))
                    first = stop
        return "settled"


class _Descent:
    """One descent: the points it asks for, what it has spent, and the least cost that it met."""

    def __init__(self, moves: Moves[Minimum]) -> None:
        self._moves = moves
        self.open, self.spent, self.cost = True, 0, inf
        self.points = _points(next(moves))

    def advance(self, answer: Answer) -> None:
        """Take the answer to the points asked for."""
        self.spent += len(self.points)
        self.cost = min(self.cost, float(answer.costs.min()))
        try:
            self.points = _points(self._moves.send(answer))
        except StopIteration:
            self.open = False


def _points(batch: Array | Detailed) -> Array:
    return batch.points if isinstance(batch, Detailed) else batch
