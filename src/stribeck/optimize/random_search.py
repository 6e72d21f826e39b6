"""Uniform random search, the baseline every method must beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..space import Rng, Space
from .hyperparameters import whole
from .moves import Moves, Note


@dataclass(frozen=True, kw_only=True)
class RandomSearch:
    """Points drawn uniformly at random, until the budget is spent.

    Args:
        batch: Points a round.
    """

    name: ClassVar[str] = "random"
    batch: int = 40

    def __post_init__(self) -> None:
        whole(self, 1, "batch")

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        """Yield one batch after another."""
        count = 0
        while True:
            count += 1
            note(round=count)
            yield space.sample(rng, self.batch)
