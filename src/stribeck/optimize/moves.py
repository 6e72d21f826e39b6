"""Moves: generators that request points and receive costs, and how they compose."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any, NamedTuple, TypeVar

from ..space import Array

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
#: Takes what an algorithm says of the step it is about to ask for.
Note = Callable[..., None]


class SpentError(Exception):
    """Thrown into moves that get no more evaluations: they may still return what they know."""


def silent(**_: object) -> None:
    """A note that nobody keeps."""


def best_of(moves: Moves[Any]) -> Moves[tuple[Array, float]]:
    """Let another search move to its end, and return the best point it met and its cost."""
    points = next(moves)
    best, least = points[0].copy(), float("inf")
    while True:
        costs = yield points
        k = int(costs.argmin())
        if costs[k] < least:
            best, least = points[k].copy(), float(costs[k])
        try:
            points = moves.send(costs)
        except StopIteration:
            return best, least


def counted(moves: Moves[T]) -> Moves[tuple[T, int]]:
    """Let another search move to its end, and return its result and the points it asked for."""
    rows = 0
    try:
        points = next(moves)
        while True:
            answer = yield points
            rows += len(points.points if isinstance(points, Detailed) else points)
            points = moves.send(answer)
    except StopIteration as done:
        return done.value, rows
