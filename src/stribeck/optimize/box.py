"""The unit cube with the orders that points keep, and the best step of a linear model in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from ..space import Array, Space

#: How far a parameter is put inside the order that it must keep, as a share of its value.
CLEAR = 1e-12
#: What is added to the diagonal, as a share of its sum, so that directions without slope stay.
RIDGE = 1e-12


@dataclass(frozen=True)
class Box:
    """The unit cube of a space, and the orders that points in it keep.

    Args:
        space: The parameters with their ranges.
        orders: Pairs (i, j) of parameters for which x_i >= x_j must hold, of a refit; None for a
            search, which keeps none.
    """

    space: Space
    orders: tuple[tuple[int, int], ...] | None = None

    @property
    def dim(self) -> int:
        """How many parameters there are."""
        return self.space.dim

    def x(self, u: Array) -> Array:
        """Physical values of a point of the unit cube, (dim,)."""
        x: Array = self.space.decode(u[None])[0]
        return x

    def u(self, x: Array) -> Array:
        """The point of the unit cube of physical values, (dim,)."""
        u: Array = self.space.encode(x[None])[0]
        return u

    def scale(self, u: Array) -> Array:
        """Slopes dx / du at a point, (dim,)."""
        width = self.space.upper - self.space.lower
        return np.array(
            [
                value * np.log(q.upper / q.lower) if q.log else w
                for q, value, w in zip(self.space, self.x(u), width, strict=True)
            ]
        )

    def limit(self, k: int, sign: int) -> tuple[float, bool]:
        """How far a coordinate can go at all, and whether an order with another stops it there."""
        ends = self.space.upper if sign > 0 else self.space.lower
        end, ordered = float(ends[k]), False
        for i, j in self.orders or ():
            if sign < 0 and i == k and self.space.lower[j] > end:
                end, ordered = float(self.space.lower[j]), True
            if sign > 0 and j == k and self.space.upper[i] < end:
                end, ordered = float(self.space.upper[i]), True
        x = self.space.lower.copy()
        x[k] = end
        return float(self.u(x)[k]), ordered

    def orderly(self, u: Array, k_held: int | None = None) -> Array:
        """A point moved into the cube and into order, coordinate `k_held` staying where it is."""
        u = np.clip(u, 0.0, 1.0)
        if not self.orders:
            return u
        x = self.x(u)
        for _ in range(self.dim):
            violated = [(i, j) for i, j in self.orders if x[i] < x[j]]
            if not violated:
                break
            for i, j in violated:
                if i == k_held:
                    x[j] = x[i] - CLEAR * abs(x[i])
                else:
                    x[i] = x[j] + CLEAR * abs(x[j])
        else:
            return u
        inside = self.u(x)
        unchanged = x == self.x(u)
        inside[unchanged] = u[unchanged]
        y = self.x(inside)
        for i, j in self.orders or ():  # rounding on the way to the cube and back
            if y[i] < y[j]:
                if i == k_held:
                    inside[j] -= 4 * CLEAR
                else:
                    inside[i] += 4 * CLEAR
        return np.clip(inside, 0.0, 1.0)

    def moved(self, u: Array, s: Array, k_held: int | None) -> tuple[Array, Array]:
        """The point a step s away from u, and the step.

        A search ends on bounds exactly, and takes the step as it was planned. A refit takes the
        difference of the two points: rounding on the way there is no matter of the slopes.
        """
        if self.orders is None:
            return np.where(s == 1.0 - u, 1.0, np.maximum(u + s, 0.0)), s
        v = self.orderly(u + s, k_held)
        return v, v - u

    def step(
        self, u: Array, A: Array, g: Array, free: Sequence[int], radius: float
    ) -> tuple[Array, float]:
        """The least of 2 g^T s + s^T A s over the steps s from u within a radius, in order.

        Args:
            u: A point of the unit cube, (dim,).
            A: Curvature over the free coordinates, (k, k).
            g: Half the slope over them, (k,).
            free: The k coordinates that may move.
            radius: Half-width of the trust region.

        Returns:
            s, (dim,), and by how much the quadratic falls from 0 to there.
        """
        rows, s = list(free), np.zeros(self.dim)
        if not rows:
            return s, 0.0
        start = u[rows] if len(rows) < self.dim else u
        lower, upper = np.maximum(-start, -radius), np.minimum(1.0 - start, radius)
        if not self.orders:
            s[rows], promise = box_minimum(A, g, lower, upper)
            return s, promise
        x, width = self.x(u), self.scale(u)
        pairs = []
        for i, j in self.orders:
            slack = max(float(x[i] - x[j]), 0.0)
            if i in rows and j in rows:
                pairs.append((rows.index(i), rows.index(j), slack))
            elif i in rows:
                lower[rows.index(i)] = max(lower[rows.index(i)], -slack / width[i])
            elif j in rows:
                upper[rows.index(j)] = min(upper[rows.index(j)], slack / width[j])
        s[rows], promise = _ordered_minimum(A, g, lower, upper, width[rows], pairs)
        return s, promise


def _ordered_minimum(
    A: Array,
    g: Array,
    lower: Array,
    upper: Array,
    w: Array,
    pairs: Sequence[tuple[int, int, float]],
) -> tuple[Array, float]:
    """`box_minimum` with w_i s_i - w_j s_j >= -slack for each (i, j, slack) of `pairs`."""
    s, promise = box_minimum(A, g, lower, upper)
    if not pairs:
        return s, promise
    T, c, tied = np.eye(len(g)), np.zeros(len(g)), set[int]()
    for _ in pairs:
        broken = [
            (i, j, slack)
            for i, j, slack in pairs
            if i not in tied and w[i] * s[i] - w[j] * s[j] < -slack - CLEAR * w[i]
        ]
        if not broken:
            break
        i, j, slack = broken[0]  # their difference is kept at zero: one variable less
        tied.add(i)
        row, offset = T[j] * w[j] / w[i], (w[j] * c[j] - slack) / w[i]
        for m in range(len(g)):
            share = T[m, i]
            if m != i and share:
                T[m] += share * row
                c[m] += share * offset
                T[m, i] = 0.0
        T[i], c[i] = row, offset
        keep = [m for m in range(len(g)) if m not in tied]
        part = T[:, keep]
        low, high = np.minimum(lower[keep], 0), np.maximum(upper[keep], 0)
        z, _ = box_minimum(part.T @ A @ part, part.T @ (g + A @ c), low, high)
        s = np.clip(part @ z + c, lower, upper)
        promise = -float(2.0 * g @ s + s @ A @ s)
    return s, promise


def box_minimum(A: Array, g: Array, lower: Array, upper: Array) -> tuple[Array, float]:
    """The least of 2 g^T s + s^T A s over the box lower <= s <= upper, which holds 0.

    A is positive semidefinite, shape (dim, dim). By the active set: a coordinate that meets its
    bound stays there until the gradient pulls it back inside.

    Returns:
        s, and by how much the quadratic falls from 0 to there.
    """
    dim, total = len(g), float(A.trace())
    if not 0.0 < total < inf:
        return np.zeros(dim), 0.0
    A = A.copy()
    A.flat[:: dim + 1] += RIDGE * total
    # Coordinate by coordinate: on arrays as short as these NumPy's calls cost more than the sums.
    low, high, s, slope = lower.tolist(), upper.tolist(), [0.0] * dim, g.tolist()
    least_pull = RIDGE * max(abs(x) for x in slope)
    free = [low[i] < 0 if slope[i] > 0 else high[i] > 0 for i in range(dim)]
    for _ in range(10 * dim):
        move = _newton_step(A, slope, free)
        shares = [  # of the move, at which each coordinate meets its bound
            ((high[i] if m > 0 else low[i]) - s[i]) / m if m else inf for i, m in enumerate(move)
        ]
        share = min(shares)
        if share < 1:
            k = shares.index(share)
            s = [x + share * m for x, m in zip(s, move, strict=True)]
            s[k], free[k] = high[k] if move[k] > 0 else low[k], False
            slope = (g + A @ np.array(s)).tolist()
            continue
        s = [x + m for x, m in zip(s, move, strict=True)]
        if all(free):
            break
        slope = (g + A @ np.array(s)).tolist()
        pulls = [  # of the slope, on each coordinate at its bound, back inside
            0.0 if free[i] else slope[i] if x >= high[i] else -slope[i] if x <= low[i] else 0.0
            for i, x in enumerate(s)
        ]
        pull = max(pulls)
        if not pull > least_pull:
            break
        free[pulls.index(pull)] = True
    step = np.array(s).clip(lower, upper)
    return step, -float(2.0 * g @ step + step @ A @ step)


def _newton_step(A: Array, slope: Sequence[float], free: Sequence[bool]) -> list[float]:
    """To the least over the free coordinates, wherever their bounds are; 0 for the others."""
    from scipy.linalg.lapack import dgesv  # noqa: PLC0415 - not every search steps in a box

    rows = [i for i in range(len(slope)) if free[i]]
    move = [0.0] * len(slope)
    if not rows:
        return move
    if len(rows) < len(slope):
        A, slope = A.take(rows, axis=0).take(rows, axis=1), [slope[i] for i in rows]
    # NumPy's `solve` calls the same routine, and takes ten times as long to look at so few numbers.
    *_, solution, zero_pivot = dgesv(A, slope)
    if zero_pivot:
        raise np.linalg.LinAlgError("Singular matrix")
    for i, x in zip(rows, solution.tolist(), strict=True):
        move[i] = -x
    return move
