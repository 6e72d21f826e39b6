"""One search in progress, by ask and tell, and its record."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.random import SeedSequence

from ..errors import InputError
from ..space import Array, Rng, Space
from .lockstep import AskTell, SearchError
from .moves import Detailed, Moves, Note
from .trace import Trace

#: A reason to end, or None to go on.
Stop = Callable[[Trace], "str | None"]


class Algorithm(Protocol):
    """A frozen set of hyper-parameters that knows how to move through the unit cube."""

    @property
    def name(self) -> str:
        """The name it is registered and reported under."""

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        """Yield (n, dim) points of the unit cube; receive their (n,) costs.

        Points yielded as `Detailed` are answered with an `Answer`.

        The costs are the algorithm's own to change; none is nan. What it returns is the word
        for why it ended.
        """


@dataclass(frozen=True, eq=False)
class Run:
    """The result of a search, why it ended, and how it got there.

    Args:
        x: The best point evaluated, physical values, shape (dim,).
        cost: Its cost; inf if no point could be run.
        evaluations: Rows of cost evaluated.
        ended: Why it ended: "budget", a stop's word, the algorithm's word (such as
            "count_max"), or "open" if it has not.
        seconds: Wall-clock time from start to end. Searches in lockstep share theirs.
        trace: Every point and cost.
    """

    x: Array
    cost: float
    evaluations: int
    ended: str
    seconds: float
    trace: Trace = field(repr=False)


class Search(AskTell[Any]):
    """Ask for the next points, tell their costs, until `ended` says why it is over.

    Args:
        space: Where to search.
        algorithm: How to search.
        budget: Rows of cost that may be evaluated; kept exactly, the last batch is cut.
        seed: Seed of the search's own generator; nothing else is random.
        stops: Reasons to end earlier, asked after every step.
        measure: What people are shown of a point, physical values, (dim,); its cost by default.
    """

    def __init__(
        self,
        space: Space,
        algorithm: Algorithm,
        *,
        budget: int,
        seed: int | SeedSequence,
        stops: Sequence[Stop] = (),
        measure: Callable[[Array], float] | None = None,
    ) -> None:
        self.algorithm, self.stops = algorithm, stops
        self._measure, self._shown = measure, (-1, np.inf)
        self.budget = _whole(budget)
        self.trace = Trace(space.dim)
        self._note: dict[str, Any] = {}
        moves = algorithm.moves(space, _generator(seed), self._noted)
        super().__init__(algorithm.name, space, moves)

    @property
    def shown(self) -> float:
        """What people are shown of the best point; inf while there is none."""
        best = self.trace.best
        if self._measure is None or best < 0 or not np.isfinite(self.trace.cost):
            return self.trace.cost
        if self._shown[0] != best:
            x = self.space.decode(self.trace.u[best : best + 1])[0]
            self._shown = best, self._measure(x)
        return self._shown[1]

    def run(self) -> Run:
        """The result so far."""
        if self.trace.best < 0:
            raise SearchError(f"{self.name} has evaluated nothing yet")
        best = self.trace.best
        return Run(
            x=self.space.decode(self.trace.u[best : best + 1])[0],
            cost=self.trace.cost,
            evaluations=len(self.trace),
            ended=self.ended or "open",
            seconds=self._seconds if self.ended else self.trace.seconds,
            trace=self.trace,
        )

    def _record(self, costs: Array) -> None:
        self.trace.append(self._points, costs, self._note)
        self._note = {}
        if reason := next((r for stop in self.stops if (r := stop(self.trace))), None):
            self._end(reason)
        elif len(self.trace) == self.budget:
            self._end("budget")

    def _take(self, batch: Array | Detailed) -> None:
        super()._take(batch)
        self._points = self._points[: self.budget - len(self.trace)]
        self.rows = len(self._points)

    def _finish(self, result: str | None) -> None:
        if not len(self.trace):
            raise SearchError(f"{self.name} asked for nothing") from None
        self._end(result or "exhausted")

    def _end(self, reason: str) -> None:
        super()._end(reason)
        self._seconds = self.trace.seconds

    def _noted(self, **words: Any) -> None:
        self._note.update(words)


def _whole(budget: int) -> int:
    try:
        rows = operator.index(budget)
    except TypeError:
        rows = 0
    if rows < 1:
        raise InputError(f"budget must be a whole number of evaluations >= 1, got {budget!r}")
    return rows


def _generator(seed: int | SeedSequence) -> Rng:
    try:
        return np.random.default_rng(seed)
    except (TypeError, ValueError):
        raise InputError(f"seed must be a whole number >= 0, got {seed!r}") from None
