"""Down to the floor of a basin by its residuals: trust-region least squares with few evaluations.

Levenberg's and Marquardt's idea in today's form: the residuals are taken as linear in the
parameters, and their sum of squares is minimised over the part of the cube that lies within the
trust radius. Three things make it quick here.

- Slopes by finite differences cost as many evaluations as there are parameters. They are asked
  for only when the cheap ones fail: every step corrects them by what it has shown (Broyden 1965,
  doi 10.1090/S0025-5718-1965-0198670-6).
- The trust region is a box, too: the step is the exact minimum of a convex quadratic over a box,
  and a parameter comes to rest on its bound as on any other value.
- The differences are tiny. Where residuals are a thousand times as steep in one direction as in
  another, the floor is a narrow, curved valley. Slopes taken over more than its width stall
  anywhere in it, and every such place looks like the floor of a basin of its own.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import NamedTuple

import numpy as np

from ..space import Array
from .search import Answer, Detailed, Note

#: A step that keeps more than GOOD of the gain promised makes the trust radius twice its own
#: length, WIDEST at most; one that keeps less than POOR, half of it.
GOOD, POOR, WIDEST = 0.9, 0.1, 0.5
#: After so many poor steps in a row, or corrections per parameter, slopes are taken anew.
BLUNDERS, AGE = 2, 3
#: Least trust radius: a shorter step is lost in rounding.
SHORTEST = 1e-9
#: What is added to the diagonal, as a share of its sum, so that directions without slope stay.
RIDGE = 1e-12


class Floor(NamedTuple):
    """Where a descent ended.

    Args:
        point: The best point of the descent, (dim,), in the unit cube.
        cost: Its cost; inf if the start cannot be run.
        ended: "flat" where slopes promise no further gain, or no step keeps what they promise;
            "nowhere" where the start cannot be run; "no residuals" where there are none.
        curvature: Inner products of the slopes, J^T J / m, (dim, dim): how the mean square of
            the residuals grows about the point. Its flattest direction is the valley's.
    """

    point: Array
    cost: float
    ended: str
    curvature: Array


def least_squares(
    start: Array,
    note: Note,
    *,
    radius: float = 0.1,
    step: float = 1e-6,
    tolerance: float = 1e-6,
) -> Generator[Detailed, Answer, Floor]:
    """Descend from a point of the unit cube by the residuals of the problem.

    It keeps dim + 1 residual vectors, and as many again while it takes slopes.

    Args:
        start: Where, (dim,).
        note: Told what is asked for: `asks` "start", "slopes" or "step", and the trust radius.
        radius: Half-width of the first trust region.
        step: Length of the finite differences: far below the width of the valley, and far
            above the noise of the residuals over their slope.
        tolerance: End where slopes promise that the sum of squares falls by less than this share
            within the trust radius: those of that very point, or corrected ones if since they
            were taken it fell by less, too.
    """
    u, dim = start.copy(), len(start)
    note(asks="start", radius=radius)
    answer = yield Detailed(u[None])
    cost = float(answer.costs[0])
    if answer.residuals is None or not np.isfinite(cost):
        ended = "no residuals" if answer.residuals is None else "nowhere"
        return Floor(u, cost, ended, np.zeros((dim, dim)))
    r = answer.residuals[0].copy()
    J = np.zeros((dim, len(r)))
    age: int | None = None  # corrections since the slopes were taken; None: take them
    blunders, before = 0, np.inf  # poor steps in a row, and the sum of squares, since then
    while True:
        if age is None:
            note(asks="slopes", radius=radius)
            yield from _take_slopes(J, u, r, step)
            age = blunders = 0
        # einsum, as the bits of BLAS depend on the number of its threads
        A, g = np.einsum("im,jm->ij", J, J), np.einsum("im,m->i", J, r)
        squares = float(np.einsum("m,m->", r, r))
        s, promise = box_minimum(A, g, np.maximum(-u, -radius), np.minimum(1.0 - u, radius))
        if age == 0:
            before = squares
        if not promise > tolerance * squares or radius < SHORTEST:
            if age == 0 or 0 < before - squares < tolerance * squares:
                return Floor(u, cost, "flat", A / len(r))
            age, radius = None, max(radius, SHORTEST)
            continue

        note(asks="step", radius=radius)
        there = np.where(s == 1.0 - u, 1.0, np.maximum(u + s, 0.0))
        answer = yield Detailed(there[None])
        reach, lower = float(np.abs(s).max()), float(answer.costs[0])
        if answer.residuals is None or not np.isfinite(lower):
            radius = reach / 4  # nothing was learnt but that it was too far
            continue
        R = answer.residuals[0]
        kept = (squares - float(np.einsum("m,m->", R, R))) / promise
        J += np.outer(s / (s @ s), R - r - np.einsum("i,im->m", s, J))
        radius = _adapted(radius, reach, kept)
        blunders = blunders + 1 if kept < POOR else 0
        if kept > 0:
            u, r, cost = there, R.copy(), lower
        age = None if blunders >= BLUNDERS or age + 1 >= AGE * dim else age + 1


def _adapted(radius: float, reach: float, kept: float) -> float:
    """The trust radius after a step of length `reach` that kept so much of its promise."""
    if kept > GOOD:
        return max(radius, min(2 * reach, WIDEST))
    return reach / 2 if kept < POOR else radius


def _take_slopes(J: Array, u: Array, r: Array, step: float) -> Generator[Detailed, Answer, None]:
    """Slopes of the residuals r at a point u, (dim, m), into J; 0 where no neighbour can run."""
    todo, aside = np.arange(len(u)), np.where(u + step <= 1.0, step, -step)
    J[:] = 0.0
    for side in (aside, -aside):  # the other side where a neighbour cannot run
        there = u + np.diag(side)[todo]
        inside = ((there >= 0.0) & (there <= 1.0)).all(axis=1)
        todo, there = todo[inside], there[inside]
        if not len(todo):
            return
        answer = yield Detailed(there)
        ran = np.isfinite(answer.costs)
        for k, R in zip(todo[ran], answer.residuals[ran], strict=True):  # type: ignore[index]
            np.subtract(R, r, out=J[k])
            J[k] /= there[todo == k][0, k] - u[k]
        todo = todo[~ran]


def box_minimum(A: Array, g: Array, lower: Array, upper: Array) -> tuple[Array, float]:
    """The least of 2 g^T s + s^T A s over the box lower <= s <= upper, which holds 0.

    A is positive semidefinite, shape (dim, dim). By the active set: a coordinate that meets its
    bound stays there until the gradient pulls it back inside.

    Returns:
        s, and by how much the quadratic falls from 0 to there.
    """
    s, slope, total = np.zeros(len(g)), g, float(np.trace(A))
    if not 0.0 < total < np.inf:
        return s, 0.0
    A = A + RIDGE * total * np.eye(len(g))
    free = np.where(slope > 0, lower < 0, upper > 0)
    for _ in range(10 * len(g)):
        move = np.zeros(len(g))
        if free.any():
            move[free] = -np.linalg.solve(A[np.ix_(free, free)], slope[free])
        room = np.where(move > 0, upper - s, lower - s)
        share = np.divide(room, move, out=np.full(len(g), np.inf), where=move != 0)
        k = int(share.argmin())
        if share[k] < 1:
            s, free[k] = s + share[k] * move, False
            s[k] = upper[k] if move[k] > 0 else lower[k]
            slope = g + A @ s
            continue
        s = s + move
        slope = g + A @ s
        pull = np.where(free, 0.0, np.where(s >= upper, slope, np.where(s <= lower, -slope, 0.0)))
        k = int(pull.argmax())
        if not pull[k] > RIDGE * np.abs(g).max():
            break
        free[k] = True
    s = np.clip(s, lower, upper)
    return s, -float(2.0 * g @ s + s @ A @ s)
