"""Trust-region least squares in the unit cube, with few evaluations.

Levenberg's and Marquardt's idea in today's form: the residuals are taken as linear in the
parameters, and their sum of squares is minimised over the part of the cube that lies within the
trust radius. Three things make it quick here.

- Slopes by finite differences cost as many evaluations as there are parameters. They are asked
  for only when the cheap ones fail: every step corrects them by what it has shown (Broyden 1965,
  doi 10.1090/S0025-5718-1965-0198670-6). A refit that begins next to a fit takes its slopes along.
- The trust region is a box, too: the step is the exact minimum of a convex quadratic over a box
  (and over the orders that parameters must keep), and a parameter comes to rest on its bound as
  on any other value.
- The differences are tiny. Where residuals are a thousand times as steep in one direction as in
  another, the minimum lies in a narrow, curved valley. Slopes taken over more than its width
  stall anywhere in it, and every such place looks like a minimum of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from ..space import Array
from .box import Box
from .lockstep import rms
from .moves import Answer, Detailed, Moves, Note, counted, silent
from .slopes import slopes

#: Half-width of the first trust region, and the least one: a shorter step is lost in rounding.
RADIUS, SHORTEST = 0.1, 1e-9
#: A step that keeps more than GOOD of the gain promised makes the trust radius twice its own
#: length; one that keeps less than POOR, half of it.
GOOD, POOR = 0.9, 0.1
#: Widest trust region of a descent that searches: one step is not to leave its basin for another.
WIDEST = 0.5
#: After so many poor steps in a row, or corrections per parameter, slopes are taken anew.
BLUNDERS, AGE = 2, 3
#: Age of slopes that were never taken.
NEVER = 1_000_000

#: On what slopes a descent may end: `taken` at that very point; `level`, or corrected ones if the
#: sum of squares has hardly fallen since they were taken; `corrected`, on any.
Rest = Literal["taken", "level", "corrected"]


@dataclass(frozen=True, eq=False)
class Iterate:
    """A point with what is known there.

    Args:
        u: In the unit cube, (dim,).
        r: Residuals, (m,).
        J: Their slopes, (dim, m), taken or corrected.
        squares: Sum of the squared residuals.
        cost: Their root mean square.
        age: Corrections since the slopes were taken; 0 where they are exact.
        own: Whether slopes may be by differences of each coordinate's own length.
        lengths: Those that served, where that was so, (dim,).
    """

    u: Array
    r: Array
    J: Array
    squares: float
    cost: float
    age: int
    own: bool = False
    lengths: Array | None = None

    @classmethod
    def at(cls, u: Array, r: Array) -> Iterate:
        """A point with residuals, and no slopes yet."""
        squares = _sum_of_squares(r)
        return cls(u, r, np.zeros((len(u), len(r))), squares, float(rms(r[None])[0]), NEVER)

    def corrected(self, s: Array, R: Array) -> Iterate:
        """The least change of the slopes that explains the residuals R a step s away."""
        if not s.any():
            return self
        unexplained = R - self.r
        unexplained -= np.einsum("i,im->m", s, self.J)
        J = (s / (s @ s))[:, None] * unexplained
        J += self.J
        return replace(self, J=J, age=self.age + 1)

    def moved(
        self, u: Array, R: Array, squares: float | None = None, cost: float | None = None
    ) -> Iterate:
        """The point u with residuals R; the slopes come along as they are.

        Args:
            u: In the unit cube, (dim,).
            R: Residuals there, (m,).
            squares: Sum of their squares, where it is known.
            cost: Their root mean square, where it is known.
        """
        squares = _sum_of_squares(R) if squares is None else squares
        cost = float(rms(R[None])[0]) if cost is None else cost
        return replace(self, u=u, r=R.copy(), squares=squares, cost=cost)

    def without_slopes(self) -> Iterate:
        """The same without its slopes, which of many residuals take most of the memory."""
        return replace(self, J=np.zeros((len(self.u), 0)), age=NEVER)

    def step(self, box: Box, free: Sequence[int], radius: float) -> tuple[Array, float]:
        """The best step of the linear model within the radius, (dim,), and the gain it promises."""
        J = self.J[list(free)] if len(free) < len(self.u) else self.J
        # einsum, as the bits of BLAS depend on the number of its threads
        A, g = np.einsum("im,jm->ij", J, J), np.einsum("im,m->i", J, self.r)
        return box.step(self.u, A, g, free, radius)


def _sum_of_squares(r: Array) -> float:
    return float(np.einsum("m,m->", r, r))


class Minimum(NamedTuple):
    """Where a descent ended.

    Args:
        point: The best point of the descent, (dim,), in the unit cube.
        cost: Its cost; inf if the start cannot be run.
        ended: "flat" where slopes promise no further gain, or no step keeps what they promise;
            "nowhere" where the start cannot be run; "no residuals" where there are none; "poor"
            where it was given up.
    """

    point: Array
    cost: float
    ended: str


def least_squares(
    start: Array,
    box: Box,
    note: Note = silent,
    *,
    radius: float = RADIUS,
    tolerance: float = 1e-6,
) -> Moves[Minimum]:
    """Descend from a point of the unit cube by the residuals of the problem.

    It keeps dim + 1 residual vectors, and as many again while it takes slopes.

    Args:
        start: Where, (dim,).
        box: Where it may go.
        note: Takes what is asked for: `asks` "start", "slopes" or "step", and the trust radius.
        radius: Half-width of the first trust region.
        tolerance: End where slopes promise that the sum of squares falls by less than this share
            within the trust radius.
    """
    u = start.copy()
    note(asks="start", radius=radius)
    answer: Answer = yield Detailed(u[None])
    cost = float(answer.costs[0])
    if answer.residuals is None:
        return Minimum(u, cost, "no residuals")
    if not np.isfinite(cost):
        return Minimum(u, cost, "nowhere")
    iterate = replace(Iterate.at(u, answer.residuals[0].copy()), cost=cost)
    end, _ = yield from minimise(
        iterate, box, tolerance=tolerance, rest="level", radius=radius, widest=WIDEST, note=note
    )
    return Minimum(end.u, end.cost, "flat")


def minimise(
    start: Iterate,
    box: Box,
    free: Sequence[int] | None = None,
    *,
    gain: float = 0.0,
    tolerance: float = 0.0,
    rows: float = np.inf,
    rest: Rest = "taken",
    radius: float = RADIUS,
    widest: float = np.inf,
    note: Note = silent,
) -> Moves[tuple[Iterate, bool]]:
    """Descend to where no step promises more than `gain` of the sum of squares.

    Args:
        start: Where to begin; its slopes are used as long as they serve.
        box: Where it may go.
        free: The coordinates that may move; all by default.
        gain: Sum of squares that is not worth a step.
        tolerance: The same as a share of the sum of squares.
        rows: Evaluations that may be asked for.
        rest: On what slopes it may end.
        radius: Half-width of the first trust region.
        widest: Half-width that none exceeds.
        note: Takes what is asked for, and the trust radius.

    Returns:
        The last iterate, and whether it came to rest.
    """
    iterate, dim = start, box.dim
    free = range(dim) if free is None else free
    held_coordinate = _one_held(dim, free)
    spent, blunders, taken = 0, 0, start  # taken: where slopes were taken last
    before = np.inf
    while True:
        if iterate.age == 0:
            taken, before = iterate, iterate.squares
        s, promise = iterate.step(box, free, radius)
        worth = max(gain, tolerance * iterate.squares)
        finished = not promise > worth or radius < SHORTEST
        stale = iterate.age > 0 and (blunders >= BLUNDERS or iterate.age >= AGE * dim)
        level = rest == "level" and not stale and 0 < before - iterate.squares < worth
        if finished and (iterate.age == 0 or rest == "corrected" or level):
            return iterate, True

        if finished or stale:
            if spent + dim > rows:
                return iterate, False
            note(asks="slopes", radius=radius)
            iterate, asked = yield from _renewed(iterate, taken)
            radius = max(radius, SHORTEST) if asked else radius
            spent, blunders = spent + asked, 0
            continue

        if spent >= rows:
            return iterate, False
        note(asks="step", radius=radius)
        u, s = box.moved(iterate.u, s, held_coordinate)
        answer: Answer = yield Detailed(u[None])
        spent, reach, cost = spent + 1, float(np.abs(s).max()), float(answer.costs[0])
        if answer.residuals is None or not np.isfinite(cost) or not reach:
            radius = min(radius, reach or radius) / 4  # nothing was learnt but that it was too far
            continue
        R = answer.residuals[0]
        squares = _sum_of_squares(R)
        gain_ratio = (iterate.squares - squares) / promise
        iterate = iterate.corrected(s, R)
        if gain_ratio > 0:
            iterate = iterate.moved(u, R, squares, cost)
        radius = _adapted(radius, reach, gain_ratio, widest)
        blunders = blunders + 1 if gain_ratio < POOR else 0


def _renewed(iterate: Iterate, taken: Iterate) -> Moves[tuple[Iterate, int]]:
    """The point with slopes of its own, and the evaluations: none where they were taken there."""
    if taken.age == 0 and np.array_equal(taken.u, iterate.u):
        return taken, 0
    return (yield from counted(with_slopes(iterate)))


def _one_held(dim: int, free: Sequence[int]) -> int | None:
    fixed = set(range(dim)) - set(free)
    return fixed.pop() if len(fixed) == 1 else None


def _adapted(radius: float, reach: float, gain_ratio: float, widest: float) -> float:
    """The trust radius after a step of length `reach` that kept so much of its promise."""
    if gain_ratio > GOOD:
        return max(radius, min(2 * reach, widest))
    return reach / 2 if gain_ratio < POOR else radius


def with_slopes(iterate: Iterate) -> Moves[Iterate]:
    """The slopes at a point."""
    J, lengths = yield from slopes(iterate.u, iterate.r, iterate.lengths, own=iterate.own)
    return replace(iterate, J=J, age=0, lengths=lengths)
