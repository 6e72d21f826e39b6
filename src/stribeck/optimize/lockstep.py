"""The one loop of all searches and descents: their points are evaluated in one call a step.

Searches, descents, refits of a profile and of a bootstrap are all generators of points (`Moves`).
An `AskTell` drives one by ask and tell; `steps` drives many.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Generic, Protocol, TypeVar, runtime_checkable

import numpy as np

from ..errors import InputError
from ..space import Array, Space, in_cube
from .moves import Answer, Detailed, Moves, SpentError

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)
D = TypeVar("D", bound="Driven[Any]")


class Problem(Protocol):
    """A space and a cost over it. Rows are independent: cost(x)[i] depends on x[i] alone."""

    @property
    def name(self) -> str:
        """The name it is listed under."""

    @property
    def space(self) -> Space:
        """Where it is searched."""

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) physical values to (n,) costs; inf or nan where a point cannot be run."""


class ShowsResiduals(Protocol):
    """A space and residuals over it."""

    @property
    def space(self) -> Space:
        """Where it is searched."""

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) physical values to (n, m) residuals, rows independent."""


@runtime_checkable
class LeastSquares(Problem, ShowsResiduals, Protocol):
    """A problem whose cost is the root mean square of residuals that it can show."""


class SearchError(RuntimeError):
    """An algorithm broke its contract, or a search is over."""


class Driven(Protocol[T_co]):
    """What `steps` advances: an `AskTell` or a `Search`."""

    ended: str | None
    detailed: bool
    rows: int

    def ask(self) -> Array:
        """The points to evaluate now, (n, dim) physical values; the same until told."""

    def tell(self, costs: Array, residuals: Array | None = None) -> None:
        """The (n,) costs of the points asked for, in order."""

    def cut(self, reason: str) -> None:
        """End it before its own end."""

    def run(self) -> T_co:
        """The result so far."""


class AskTell(Generic[T]):
    """A generator of points of the unit cube, driven by ask and tell.

    Args:
        name: What it is called in errors.
        space: Whose unit cube it moves through.
        moves: The generator.

    Attributes:
        ended: Why it is over; None while it is not.
        detailed: Whether it asks for residuals besides costs.
        rows: How many points it asks for.
    """

    def __init__(self, name: str, space: Space, moves: Moves[T]) -> None:
        self.name, self.space = name, space
        self.ended: str | None = None
        self._moves = moves
        self._result: T | None = None
        self._advance(lambda: next(moves))

    def ask(self) -> Array:
        """The points to evaluate now, (n, dim) physical values; the same until told."""
        self._check_open()
        return self.space.decode(self._points, inside=True)

    def tell(self, costs: Array, residuals: Array | None = None) -> None:
        """The (n,) costs of the points asked for, in order. What is not finite counts as worst.

        Args:
            costs: One for each point.
            residuals: Where `detailed` says that the algorithm would know them, (n, m).

        Raises:
            InputError: there is not one number for every point asked for.
        """
        self._check_open()
        costs = checked(costs, self.rows).copy()  # the algorithm may write into its own
        runs = np.isfinite(costs)
        if not runs.all():
            costs[~runs] = np.inf
        self._record(costs)
        if self.ended is None:
            answer = Answer(costs, residuals) if self.detailed else costs
            self._advance(lambda: self._moves.send(answer))

    def cut(self, reason: str) -> None:
        """End it before its own end: the generator may still return what it knows."""
        if self.ended is None:
            try:
                self._moves.throw(SpentError())
            except StopIteration as done:
                self._result = done.value
            except SpentError:
                pass
            self._end(reason)

    def run(self) -> T | None:
        """What the generator has returned; None if it was cut and knows nothing."""
        return self._result

    def _record(self, costs: Array) -> None:
        """Keep the costs of the points asked for, and end where that is a reason to."""

    def _advance(self, step: Callable[[], Array | Detailed]) -> None:
        try:
            self._take(step())
        except StopIteration as done:
            self._finish(done.value)

    def _take(self, batch: Array | Detailed) -> None:
        self.detailed = isinstance(batch, Detailed)
        points: Array = batch.points if isinstance(batch, Detailed) else batch
        if points.ndim != 2 or points.shape[1] != self.space.dim or not len(points):  # noqa: PLR2004
            raise SearchError(f"{self.name} asked points of shape {points.shape}")
        if not in_cube(points):
            raise SearchError(f"{self.name} asked a point outside the unit cube")
        self._points, self.rows = points, len(points)

    def _finish(self, result: T) -> None:
        self._result, self.ended = result, "returned"

    def _end(self, reason: str) -> None:
        self.ended = reason
        self._moves.close()

    def _check_open(self) -> None:
        if self.ended:
            raise SearchError(f"{self.name} has ended: {self.ended}")


class Counted:
    """A least-squares problem with a budget: rows are counted, and what was evaluated is kept.

    Args:
        problem: What is evaluated.
        budget: Rows that may be evaluated.

    Attributes:
        rows: Rows evaluated.
        visited: Points, physical values, (dim,), and their sums of squares, in order.
    """

    name = "counted"

    def __init__(self, problem: ShowsResiduals, budget: int) -> None:
        self.problem, self.budget, self.rows = problem, budget, 0
        self.space = problem.space
        self.visited: list[tuple[Array, float]] = []
        self._samples = 1

    @property
    def left(self) -> int:
        """Rows that may still be evaluated."""
        return self.budget - self.rows

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) physical values to (n, m) residuals."""
        self.rows += len(x)
        residuals = np.asarray(self.problem.residuals(x), dtype=float)
        self._samples = residuals.shape[1]
        self.visited += zip(x.copy(), squares_of(residuals).tolist(), strict=True)
        return residuals

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) physical values to (n,) root mean squares."""
        return rms(self.residuals(x))

    def best(self) -> tuple[Array, float]:
        """The best point kept, physical values, and its root mean square; inf if none could run."""
        x, squares = min(self.visited, key=lambda visited: (np.isnan(visited[1]), visited[1]))
        cost = float(np.sqrt(squares / self._samples))
        return x, cost if np.isfinite(cost) else np.inf

    def forget(self, above: float = -np.inf) -> None:
        """Drop the points whose sum of squares is above a level; all of them by default."""
        self.visited = [(x, squares) for x, squares in self.visited if squares <= above]


def lockstep(
    problem: Problem, tasks: Iterable[Driven[T]], stop: Callable[[], bool] | None = None
) -> list[T]:
    """Run tasks of one problem together, all their points evaluated in one call a step.

    Rows of a problem are independent, so every run is bit for bit what it is alone. Once `stop`
    holds after a step, those that have not ended are cut.

    Raises:
        InputError: the cost does not return one number for every row.
    """
    tasks = list(tasks)
    for _ in steps(problem, tasks):
        if stop is not None and stop():
            for task in tasks:
                task.cut("stopped")
    return [task.run() for task in tasks]


def steps(
    problem: Problem, tasks: Sequence[D], rests: Callable[[D], bool] | None = None
) -> Iterator[int]:
    """The same a step at a time, to look at the tasks in between: yields rows evaluated.

    Args:
        problem: Gives the costs.
        tasks: Those to run.
        rests: Whether a task skips the next step. The loop ends where all that have not ended do.
    """
    shown = problem if isinstance(problem, LeastSquares) else None  # slow to ask at every step
    while live := [t for t in tasks if not (t.ended or (rests is not None and rests(t)))]:
        if isinstance(problem, Counted):
            live = _affordable(problem, live)
            if not live:
                return
        plain = [t for t in live if not t.detailed]
        detailed = [t for t in live if t.detailed] if len(plain) < len(live) else []
        rows = _step(problem, plain, None) if plain else 0
        yield rows + (_step(problem, detailed, shown) if detailed else 0)


def _affordable(problem: Counted, live: list[D]) -> list[D]:
    """The tasks that the budget reaches; those that ask for most are cut first."""
    while sum(t.rows for t in live) > problem.left:
        k = max(range(len(live)), key=lambda i: (live[i].rows, i))
        live.pop(k).cut("budget")
    return live


def _step(problem: Problem, tasks: Sequence[Driven[Any]], shown: LeastSquares | None) -> int:
    """One step of tasks that all want the same of a problem; returns the rows evaluated.

    Args:
        problem: Gives the costs.
        tasks: Those to advance.
        shown: The same problem where its residuals are wanted and it can show them.
    """
    points = [t.ask() for t in tasks]
    x = np.concatenate(points) if len(points) > 1 else points[0]
    residuals = None if shown is None else _residuals(shown, x)
    costs = checked(problem(x) if residuals is None else rms(residuals), len(x))
    end = 0
    for task, batch in zip(tasks, points, strict=True):
        begin, end = end, end + len(batch)
        task.tell(costs[begin:end], None if residuals is None else residuals[begin:end])
    return end


def squares_of(residuals: Array) -> Array:
    """Sums of squares, (n, m) to (n,); the bits of einsum do not depend on threads."""
    return np.asarray(np.einsum("nm,nm->n", residuals, residuals))


def rms(residuals: Array) -> Array:
    """(n, m) residuals to their (n,) root mean squares: the cost of a `LeastSquares` problem."""
    mean = squares_of(residuals) / residuals.shape[1]
    return np.asarray(np.sqrt(mean))


def _residuals(problem: LeastSquares, x: Array) -> Array:
    shown = np.asarray(problem.residuals(x))
    if shown.ndim != 2 or len(shown) != len(x) or not shown.size or shown.dtype.kind not in "fiub":  # noqa: PLR2004
        raise InputError(
            f"the residuals of {len(x)} points must be real numbers of shape ({len(x)}, m >= 1): "
            f"got shape {shown.shape} of {shown.dtype}"
        )
    return shown.astype(float, copy=False)


def checked(costs: Any, rows: int) -> Array:
    """The costs as an array of `rows` numbers, or an error that says what is wrong."""
    array = np.asarray(costs)
    if array.shape != (rows,) or array.dtype.kind not in "fiub":
        one = ": a function of one point is given as lambda X: [f(x) for x in X]"
        raise InputError(
            f"the cost of {rows} points must be {rows} real numbers, shape ({rows},): "
            f"got shape {array.shape} of {array.dtype}{one * (rows > 1)}"
        )
    return array.astype(float, copy=False)
