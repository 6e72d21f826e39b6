"""One search in progress: it asks for points, is told their costs, and keeps the record."""

from __future__ import annotations

import operator
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.random import SeedSequence

from ..errors import InputError
from ..space import Array, Rng, Space, in_cube
from .trace import Trace

T = TypeVar("T")


class Detailed(NamedTuple):
    """Points of which an algorithm would know the residuals, too; it is sent an `Answer`."""

    points: Array


class Answer(NamedTuple):
    """The (n,) costs of points, and their (n, m) residuals if the problem has any."""

    costs: Array
    residuals: Array | None


#: Points of the unit cube (n, dim) go out, their costs (n,) come in, T is the result. Where the
#: points go out `Detailed`, an `Answer` comes in.
Moves = Generator[Array | Detailed, Any, T]
#: What an algorithm says of the step it is about to ask for.
Note = Callable[..., None]
#: A reason to end, or None to go on.
Stop = Callable[[Trace], "str | None"]


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


@runtime_checkable
class LeastSquares(Problem, Protocol):
    """A problem whose cost is the root mean square of residuals that it can show."""

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) physical values to (n, m) residuals, rows independent."""


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


class SearchError(RuntimeError):
    """An algorithm broke its contract, or a search is over."""


@dataclass(frozen=True, eq=False)
class Run:
    """What a search found, why it ended, and how it got there.

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


class Search:
    """Ask for the next points, tell their costs, until `ended` says why it is over.

    Args:
        space: Where to search.
        algorithm: How to search.
        budget: Rows of cost that may be evaluated; kept exactly, the last batch is cut.
        seed: Seed of the search's own generator; nothing else is random.
        stops: Reasons to end earlier, asked after every step.
    """

    def __init__(
        self,
        space: Space,
        algorithm: Algorithm,
        *,
        budget: int,
        seed: int | SeedSequence,
        stops: Sequence[Stop] = (),
    ) -> None:
        self.space, self.algorithm, self.stops = space, algorithm, stops
        self.budget = _whole(budget)
        self.trace = Trace(space.dim)
        self.ended: str | None = None
        self._note: dict[str, Any] = {}
        self._moves = algorithm.moves(space, _generator(seed), self._noted)
        self._go(lambda: next(self._moves))

    def ask(self) -> Array:
        """The points to evaluate now, (n, dim) physical values; the same until told."""
        self._check_open()
        return self.space.decode(self._asked, inside=True)

    def tell(self, costs: Array, residuals: Array | None = None) -> None:
        """The (n,) costs of the points asked, in order. What is not finite counts as worst.

        Args:
            costs: One for each point.
            residuals: Where `detailed` says that the algorithm would know them, (n, m).

        Raises:
            InputError: there is not one number for every point asked.
        """
        self._check_open()
        costs = checked(costs, len(self._asked)).copy()  # the algorithm may write into its own
        runs = np.isfinite(costs)
        if not runs.all():
            costs[~runs] = np.inf
        self.trace.append(self._asked, costs, self._note)
        self._note = {}
        if reason := next((r for stop in self.stops if (r := stop(self.trace))), None):
            self._end(reason)
        elif len(self.trace) == self.budget:
            self._end("budget")
        else:
            answer = Answer(costs, residuals) if self.detailed else costs
            self._go(lambda: self._moves.send(answer))

    def run(self) -> Run:
        """The result so far."""
        if self.trace.best < 0:
            raise SearchError(f"{self.algorithm.name} has evaluated nothing yet")
        best = self.trace.best
        return Run(
            x=self.space.decode(self.trace.u[best : best + 1])[0],
            cost=self.trace.cost,
            evaluations=len(self.trace),
            ended=self.ended or "open",
            seconds=self._seconds if self.ended else self.trace.seconds,
            trace=self.trace,
        )

    def _go(self, step: Callable[[], Array | Detailed]) -> None:
        try:
            self._take(step())
        except StopIteration as done:
            if not len(self.trace):
                raise SearchError(f"{self.algorithm.name} asked for nothing") from None
            self._end(done.value or "exhausted")

    def _take(self, wish: Array | Detailed) -> None:
        self.detailed = isinstance(wish, Detailed)
        asked: Array = wish.points if isinstance(wish, Detailed) else wish
        if asked.ndim != 2 or asked.shape[1] != self.space.dim or not len(asked):  # noqa: PLR2004
            raise SearchError(f"{self.algorithm.name} asked points of shape {asked.shape}")
        if not in_cube(asked):
            raise SearchError(f"{self.algorithm.name} asked a point outside the unit cube")
        self._asked = asked[: self.budget - len(self.trace)]

    def _noted(self, **said: Any) -> None:
        self._note.update(said)

    def _end(self, reason: str) -> None:
        self.ended = reason
        self._seconds = self.trace.seconds
        self._moves.close()

    def _check_open(self) -> None:
        if self.ended:
            raise SearchError(f"{self.algorithm.name} has ended: {self.ended}")


def lockstep(problem: Problem, searches: Iterable[Search]) -> list[Run]:
    """Run searches of one problem together, all their points evaluated in one call a step.

    Rows of a problem are independent, so every run is bit for bit what it is alone.

    Raises:
        InputError: the cost does not return one number for every row.
    """
    searches = list(searches)
    for _ in steps(problem, searches):
        pass
    return [s.run() for s in searches]


def steps(problem: Problem, searches: Sequence[Search]) -> Iterator[int]:
    """The same a step at a time, for whoever wants to look in between: yields rows evaluated."""
    while live := [s for s in searches if not s.ended]:
        plain = [s for s in live if not s.detailed]
        others = [s for s in live if s.detailed] if len(plain) < len(live) else []
        rows = _step(problem, plain, detailed=False) if plain else 0
        yield rows + (_step(problem, others, detailed=True) if others else 0)


def _step(problem: Problem, searches: Sequence[Search], detailed: bool) -> int:
    """One step of searches that all want the same of a problem; returns the rows evaluated."""
    asked = [s.ask() for s in searches]
    x = np.concatenate(asked) if len(asked) > 1 else asked[0]
    residuals = _residuals(problem, x) if detailed and isinstance(problem, LeastSquares) else None
    costs = checked(problem(x) if residuals is None else rms(residuals), len(x))
    end = 0
    for search, points in zip(searches, asked, strict=True):
        begin, end = end, end + len(points)
        search.tell(costs[begin:end], None if residuals is None else residuals[begin:end])
    return end


def rms(residuals: Array) -> Array:
    """(n, m) residuals to their (n,) root mean squares: the cost of a `LeastSquares` problem."""
    mean: Array = np.einsum("nm,nm->n", residuals, residuals) / residuals.shape[1]
    return np.sqrt(mean)


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
        raise InputError(
            f"the cost of {rows} points must be {rows} real numbers, shape ({rows},): "
            f"got shape {array.shape} of {array.dtype}"
        )
    return array.astype(float, copy=False)


def best_of(moves: Moves[Any]) -> Moves[tuple[Array, float]]:
    """Let another search move to its end, and return the best point it met and its cost."""
    asked = next(moves)
    best, least = asked[0].copy(), float("inf")
    while True:
        costs = yield asked
        k = int(costs.argmin())
        if costs[k] < least:
            best, least = asked[k].copy(), float(costs[k])
        try:
            asked = moves.send(costs)
        except StopIteration:
            return best, least


def counted(moves: Moves[T]) -> Moves[tuple[T, int]]:
    """Let another search move to its end, and return its result and the points it asked."""
    rows = 0
    try:
        asked = next(moves)
        while True:
            answer = yield asked
            rows += len(asked.points if isinstance(asked, Detailed) else asked)
            asked = moves.send(answer)
    except StopIteration as done:
        return done.value, rows


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
