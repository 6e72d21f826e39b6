"""The record of a search: every point and cost, in the order asked."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from ..space import Array


class Trace:
    """Every point and cost in the order asked, cut into steps.

    Attributes:
        ends: Evaluations done after each step.
        notes: What the algorithm said of each step. `round=k` stands on the step that opens a
            search round, `stage` says which part of a hybrid it belongs to.
        best: Index of the least cost, the first of equals; -1 while nothing is evaluated.
    """

    def __init__(self, dim: int) -> None:
        self._u, self._f = np.empty((64, dim)), np.empty(64)
        self._began = time.perf_counter()
        self.ends: list[int] = []
        self.notes: list[dict[str, Any]] = []
        self.best = -1

    def __len__(self) -> int:
        return self.ends[-1] if self.ends else 0

    @property
    def u(self) -> Array:
        """The points asked, in the unit cube, shape (evaluations, dim); read-only."""
        return _view(self._u, len(self))

    @property
    def f(self) -> Array:
        """Their costs, shape (evaluations,), +inf where not finite; read-only."""
        return _view(self._f, len(self))

    @property
    def cost(self) -> float:
        """The least cost so far; inf while there is none."""
        return float(self._f[self.best]) if self.best >= 0 else float("inf")

    @property
    def failed(self) -> int:
        """How many costs were not finite."""
        return int(np.count_nonzero(np.isinf(self.f)))

    @property
    def seconds(self) -> float:
        """Wall-clock time since the search began."""
        return time.perf_counter() - self._began

    def append(self, u: Array, f: Array, note: dict[str, Any] | None = None) -> None:
        """Add one step: (n, dim) points of the unit cube and their (n,) costs."""
        start, end = len(self), len(self) + len(f)
        self._grow(end)
        self._u[start:end], self._f[start:end] = u, f
        self.ends.append(end)
        self.notes.append(note or {})
        k = int(f.argmin())
        if self.best < 0 or f[k] < self._f[self.best]:
            self.best = start + k

    def convergence(self) -> Array:
        """The least cost after each evaluation, shape (evaluations,)."""
        return np.minimum.accumulate(self.f)

    def rounds(self, stage: str | None = None) -> int:
        """How many search rounds were begun, in all or in one stage.

        A round is what the paper's Table 4 counts: a neighbourhood of tabu search, a
        chemotactic step of bacteria, a generation of the genetic algorithm. For `bts` the
        table counts the rounds of its tabu stage: `rounds("tabu")`.
        """
        return sum("round" in n and stage in {None, n.get("stage")} for n in self.notes)

    def reached(self, cost: float) -> int | None:
        """Evaluations until the first cost at or below `cost`; None if there is none."""
        hit = np.flatnonzero(self.f <= cost)
        return int(hit[0]) + 1 if len(hit) else None

    def _grow(self, size: int) -> None:
        if size > len(self._f):  # doubled, so that a huge budget costs only what it uses
            room = max(size, 2 * len(self._f)) - len(self)
            self._u = np.concatenate([self.u, np.empty((room, self._u.shape[1]))])
            self._f = np.concatenate([self.f, np.empty(room)])


def _view(values: Array, n: int) -> Array:
    shown = values[:n]
    shown.flags.writeable = False
    return shown
