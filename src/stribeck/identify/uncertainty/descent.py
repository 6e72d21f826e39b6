"""Refitting from nearby: bounded least squares that brings its slopes along.

A profile or a bootstrap solves hundreds of fits, each next to one that is known. What one fit has
learnt of the slopes serves the next: they are corrected by every step (Broyden 1965, doi
10.1090/S0025-5718-1965-0198670-6) and taken anew only where they fail. Many refits advance
together, so that the problem sees their points as one batch.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...optimize.trust_region import box_minimum
from ...space import Array, Space
from .residuals import Residuals, orders_of

#: Finite difference, as a share of the range: the floor of a misfit is a valley a thousandth of
#: the ranges wide, and curved.
STEP = 1e-6
#: Half-width of the first trust region, and the least one.
RADIUS, SHORTEST = 0.1, 1e-9
#: A step that keeps more than GOOD of its promise widens the trust region, one that keeps less
#: than POOR narrows it.
GOOD, POOR = 0.9, 0.1
#: After so many poor steps in a row, or corrections a parameter, slopes are taken anew.
BLUNDERS, AGE = 2, 3
#: How far a parameter is put inside the order that it must keep, as a share of its value.
CLEAR = 1e-12

#: Points of the unit cube go out, (n, dim), their residuals come in, (n, N).
Asking = Generator[Array, Array, None]


@dataclass(eq=False)
class Place:
    """A point with what is known there.

    Args:
        u: In the unit cube, (dim,).
        r: Residuals, (N,).
        J: Their slopes, (dim, N), corrected or taken.
        squares: Sum of the squared residuals.
        age: Corrections since the slopes were taken there; 0 where they are exact.
    """

    u: Array
    r: Array
    J: Array
    squares: float
    age: int

    def copy(self) -> Place:
        """One that can move on while this stays."""
        return replace(self, u=self.u.copy(), r=self.r.copy(), J=self.J.copy())

    def learn(self, s: Array, R: Array) -> None:
        """The least change of the slopes that explains the residuals R found a step s away."""
        if s.any():
            self.J += np.outer(s / (s @ s), R - self.r - np.einsum("i,im->m", s, self.J))
            self.age += 1

    def move(self, u: Array, R: Array) -> None:
        """Go to a point with residuals R, and learn from the way."""
        self.learn(u - self.u, R)
        self.u, self.r, self.squares = u, R.copy(), float(squares_of(R[None])[0])


def squares_of(r: Array) -> Array:
    """Sums of squares, (n, N) to (n,); the bits of einsum do not depend on threads."""
    found: Array = np.einsum("nm,nm->n", r, r)
    return found


class Terrain:
    """The box that is searched, and the orders that points in it keep.

    Args:
        problem: Whose box it is.
    """

    def __init__(self, problem: Residuals) -> None:
        self.space: Space = problem.space
        self.dim = self.space.dim
        self.orders = orders_of(problem)

    def x(self, u: Array) -> Array:
        """A point, SI, of one of the unit cube."""
        found: Array = self.space.decode(u[None])[0]
        return found

    def u(self, x: Array) -> Array:
        """The other way round."""
        found: Array = self.space.encode(x[None])[0]
        return found

    def slope(self, u: Array) -> Array:
        """Slopes dx / du at a point, (dim,)."""
        width = self.space.upper - self.space.lower
        return np.array(
            [
                at * np.log(q.upper / q.lower) if q.log else w
                for q, at, w in zip(self.space, self.x(u), width, strict=True)
            ]
        )

    def limit(self, k: int, sign: int) -> tuple[float, bool]:
        """How far a coordinate can go at all, and whether an order with another stops it there."""
        x = self.space.upper if sign > 0 else self.space.lower
        best, ordered = float(x[k]), False
        for i, j in self.orders:
            if sign < 0 and i == k and self.space.lower[j] > best:
                best, ordered = float(self.space.lower[j]), True
            if sign > 0 and j == k and self.space.upper[i] < best:
                best, ordered = float(self.space.upper[i]), True
        at = self.space.lower.copy()
        at[k] = best
        return float(self.u(at)[k]), ordered

    def orderly(self, u: Array, held: int | None = None) -> Array:
        """A point moved into the box and into order, `held` staying where it is."""
        u = np.clip(u, 0.0, 1.0)
        if not self.orders:
            return u
        x = self.x(u)
        for _ in range(self.dim):
            wrong = [(i, j) for i, j in self.orders if x[i] < x[j]]
            if not wrong:
                break
            for i, j in wrong:
                if i == held:
                    x[j] = x[i] - CLEAR * abs(x[i])
                else:
                    x[i] = x[j] + CLEAR * abs(x[j])
        else:
            return u
        inside = self.u(x)
        same = x == self.x(u)
        inside[same] = u[same]
        y = self.x(inside)
        for i, j in self.orders:  # rounding on the way to the cube and back
            if y[i] < y[j]:
                if i == held:
                    inside[j] -= 4 * CLEAR
                else:
                    inside[i] += 4 * CLEAR
        return np.clip(inside, 0.0, 1.0)

    def step(self, place: Place, free: Sequence[int], radius: float) -> tuple[Array, float]:
        """The best step of the linear model within the radius, (dim,), and what it promises."""
        at, s = list(free), np.zeros(self.dim)
        if not at:
            return s, 0.0
        J = place.J[at]
        A, g = np.einsum("im,jm->ij", J, J), np.einsum("im,m->i", J, place.r)
        lower = np.maximum(-place.u[at], -radius)
        upper = np.minimum(1.0 - place.u[at], radius)
        width = self.slope(place.u) if self.orders else np.ones(self.dim)
        x = self.x(place.u) if self.orders else place.u
        both = []
        for i, j in self.orders:
            slack = max(float(x[i] - x[j]), 0.0)
            if i in at and j in at:
                both.append((at.index(i), at.index(j), slack))
            elif i in at:
                lower[at.index(i)] = max(lower[at.index(i)], -slack / width[i])
            elif j in at:
                upper[at.index(j)] = min(upper[at.index(j)], slack / width[j])
        found, promise = box_minimum(A, g, lower, upper)
        w = width[at]
        T, c, tied = np.eye(len(at)), np.zeros(len(at)), set[int]()
        for _ in both:
            broken = [
                (i, j, slack)
                for i, j, slack in both
                if i not in tied and w[i] * found[i] - w[j] * found[j] < -slack - CLEAR * w[i]
            ]
            if not broken:
                break
            i, j, slack = broken[0]  # their difference is kept at zero: one variable less
            tied.add(i)
            row, offset = T[j] * w[j] / w[i], (w[j] * c[j] - slack) / w[i]
            for m in range(len(at)):
                share = T[m, i]
                if m != i and share:
                    T[m] += share * row
                    c[m] += share * offset
                    T[m, i] = 0.0
            T[i], c[i] = row, offset
            keep = [m for m in range(len(at)) if m not in tied]
            part = T[:, keep]
            low, high = lower[keep], upper[keep]
            z, _ = box_minimum(
                part.T @ A @ part, part.T @ (g + A @ c), np.minimum(low, 0), np.maximum(high, 0)
            )
            found = np.clip(part @ z + c, lower, upper)
            promise = -float(2.0 * g @ found + found @ A @ found)
        s[at] = found
        return s, promise


def slopes(place: Place, terrain: Terrain, less: Array | float = 0.0) -> Asking:
    """Take the slopes at a place, all in one batch; 0 where neither neighbour can be run."""
    todo = np.arange(terrain.dim)
    aside = np.where(place.u + STEP <= 1.0, STEP, -STEP)
    J = np.zeros_like(place.J)
    for way in (aside, -aside):
        there = place.u + np.diag(way)[todo]
        inside = ((there >= 0.0) & (there <= 1.0)).all(axis=1)
        todo, there = todo[inside], there[inside]
        if not len(todo):
            break
        R = yield there
        ran = np.isfinite(R).all(axis=1)
        for k, beside, at in zip(todo[ran], R[ran], there[ran], strict=True):
            J[k] = (beside + less - place.r) / (at[k] - place.u[k])
        todo = todo[~ran]
    place.J, place.age = J, 0


def settle(
    place: Place,
    terrain: Terrain,
    free: Sequence[int],
    gain: float,
    most: int,
    *,
    sure: bool = True,
    less: Array | float = 0.0,
    radius: float = RADIUS,
) -> Generator[Array, Array, bool]:
    """Move a place down to where no step promises more than `gain` of the sum of squares.

    Args:
        place: Where to start; it moves.
        terrain: Where it may go.
        free: The coordinates that may move.
        gain: Sum of squares that is not worth a step.
        most: Rows that may be asked for.
        sure: Whether the end must rest on slopes taken there.
        less: What is added to the problem's residuals.
        radius: Half-width of the first trust region.

    Returns:
        Whether it came to rest.
    """
    spent, blunders, held = 0, 0, _one_held(terrain.dim, free)
    while True:
        s, promise = terrain.step(place, free, radius)
        done, tired = not promise > gain or radius < SHORTEST, blunders >= BLUNDERS
        if (done and sure and place.age) or (
            not done and place.age and (tired or place.age >= AGE * terrain.dim)
        ):
            if spent + terrain.dim > most:
                return not sure and done
            yield from slopes(place, terrain, less)
            spent, blunders, radius = spent + terrain.dim, 0, max(radius, SHORTEST)
            continue
        if done:
            return True
        if spent >= most:
            return False
        there = terrain.orderly(place.u + s, held)
        s = there - place.u
        R = (yield there[None])[0] + less
        spent += 1
        reach = float(np.abs(s).max())
        if not np.isfinite(R).all() or not reach:
            radius = min(radius, reach or radius) / 4
            continue
        here = float(squares_of(R[None])[0])
        kept = (place.squares - here) / promise
        if kept > 0:
            place.move(there, R)
        else:
            place.learn(s, R)
        radius = max(radius, 2 * reach) if kept > GOOD else reach / 2 if kept < POOR else radius
        blunders = blunders + 1 if kept < POOR else 0


def _one_held(dim: int, free: Sequence[int]) -> int | None:
    held = set(range(dim)) - set(free)
    return held.pop() if len(held) == 1 else None


def ahead(place: Place, terrain: Terrain, k: int, move: float) -> tuple[Array, float]:
    """Where the linear model has the others if coordinate k moves, and the sum of squares there."""
    u = place.u.copy()
    u[k] = min(max(u[k] + move, 0.0), 1.0)
    u = terrain.orderly(u, k)
    r = place.r + np.einsum("i,im->m", u - place.u, place.J)
    moved = Place(u, r, place.J, float(squares_of(r[None])[0]), place.age)
    s, promise = terrain.step(moved, [i for i in range(terrain.dim) if i != k], 0.5)
    return terrain.orderly(u + s, k), moved.squares - promise


class Meter:
    """A problem by points of the unit cube: rows are counted, and what is good is remembered.

    Args:
        problem: What is asked.
        budget: Rows that may be evaluated.
    """

    def __init__(self, problem: Residuals, budget: int) -> None:
        self.problem, self.budget, self.rows = problem, budget, 0
        self.seen: list[tuple[Array, float]] = []

    @property
    def left(self) -> int:
        """Rows that may still be evaluated."""
        return self.budget - self.rows

    def __call__(self, u: Array) -> Array:
        """Residuals of points of the unit cube, (n, dim) to (n, N)."""
        self.rows += len(u)
        found = np.asarray(self.problem.residuals(self.problem.space.decode(u)), dtype=float)
        self.seen += zip(u.copy(), squares_of(found).tolist(), strict=True)
        return found

    def forget(self, above: float) -> None:
        """Drop the points whose sum of squares is above a level."""
        self.seen = [(u, s) for u, s in self.seen if s <= above]


def together(
    tasks: Sequence[Asking], meter: Meter, stop: Callable[[], bool] = lambda: False
) -> list[bool]:
    """Advance all tasks in step, their points in one batch, until each has ended.

    Tasks that the budget does not reach are closed, those that ask for most first, and so are
    all once `stop` says so. Returns which of them ended by themselves.
    """
    ended = [False] * len(tasks)
    asked: dict[int, Array] = {}
    for i, task in enumerate(tasks):
        try:
            asked[i] = next(task)
        except StopIteration:
            ended[i] = True
    while asked:
        while asked and sum(map(len, asked.values())) > meter.left:
            worst = max(asked, key=lambda i: (len(asked[i]), i))
            tasks[worst].close()
            del asked[worst]
        if not asked:
            break
        answers = meter(np.vstack(list(asked.values())))
        start = 0
        for i, points in list(asked.items()):
            part = answers[start : start + len(points)]
            start += len(points)
            try:
                asked[i] = tasks[i].send(part)
            except StopIteration:
                ended[i] = True
                del asked[i]
        if stop():
            for i in asked:
                tasks[i].close()
            break
    return ended


def masked(dim: int, but: int) -> list[int]:
    """All coordinates but one."""
    return [i for i in range(dim) if i != but]
