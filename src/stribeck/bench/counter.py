"""A problem as a third-party optimizer sees it: counted, cut to the budget, ended at the target."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..optimize import Problem, Target, Trace, rms
from ..optimize.lockstep import checked
from ..space import Array

#: What stands for a residual that is not finite, for libraries that take finite ones alone.
UNKNOWN = 1e9


class Over(BaseException):
    """The budget is spent or the target met. No library's `except Exception` may hold it up."""


class Counter:
    """A problem as a peer sees it: it counts, keeps the trace and says when it is over.

    Args:
        problem: What is searched.
        budget: Rows that may be evaluated.
        target: Cost at or below which the run ends; None to go on.
    """

    def __init__(self, problem: Problem, budget: int, target: float | None) -> None:
        self.problem, self.space, self.budget = problem, problem.space, budget
        self.target = None if target is None else Target(target)
        self.dim = self.space.dim
        self.trace = Trace(self.dim)
        self.ended: str | None = None
        self.failure: Exception | None = None
        self._shown: Any = getattr(problem, "residuals", None)  # of problems that have them
        self._rounds = 0
        self._note: dict[str, Any] = {}

    @property
    def budget_left(self) -> int:
        """Rows that may still be evaluated."""
        return self.budget - len(self.trace)

    def note(self, **fields: Any) -> None:
        """Say something of the step that comes next."""
        self._note |= fields

    def round(self) -> None:
        """The next step opens a round of search."""
        self._rounds += 1
        self.note(round=self._rounds)

    def restarted(self) -> None:
        """The next step begins anew."""
        self.note(event="restart")

    def generation(self, u: Any) -> Array:
        """A batch that is a round of search."""
        self.round()
        return self.batch(u)

    def batch(self, u: Any) -> Array:
        """(n, dim) points to (n,) costs.

        Raises:
            Over: nothing may be evaluated any more; always raised by the last batch.
        """
        return self._evaluated(u, self.problem)

    def _evaluated(self, u: Any, cost: Callable[[Array], Array]) -> Array:
        if self.ended or self.failure:
            raise Over
        u = np.asarray(u, dtype=float).reshape(-1, self.dim)[: self.budget_left]
        u = np.fmin(np.fmax(u, 0.0), 1.0)
        try:
            costs = checked(cost(self.space.decode(u)), len(u)).copy()
        except Exception as failure:
            self.failure = failure  # libraries have a way of renaming what passes through them
            raise
        costs[~np.isfinite(costs)] = np.inf
        self.trace.append(u, costs, dict(self._note))
        self._note.clear()
        if self.target and (word := self.target(self.trace)):
            self.ended = word
        elif not self.budget_left:
            self.ended = "budget"
        if self.ended:
            raise Over
        return costs

    def one(self, u: Any) -> float:
        """(dim,) point to its cost."""
        return float(self.batch(u)[0])

    def residuals(self, u: Any) -> Array:
        """(dim,) point to its (m,) residuals; UNKNOWN where they are not finite.

        Raises:
            Over: as `batch`.
        """
        shown = np.empty((0, 0))

        def costs(x: Array) -> Array:
            nonlocal shown
            shown = np.asarray(self._shown(x), dtype=float)
            return rms(shown)

        self._evaluated(u, costs)
        row: Array = np.where(np.isfinite(shown[0]), shown[0], UNKNOWN)
        return row
