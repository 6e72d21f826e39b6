"""Slopes of residuals by finite differences, as short as rounding allows, and each fan checked.

A motion that is simulated by steps which adapt is a smooth function of its parameters but for
jumps: where a step is divided once more, or an iteration ends one turn earlier, the motion changes
by a fraction of its tolerance. A servo's residuals meet several of them within 1e-6 of a range, and
differences of that length show the jumps rather than the slopes. Longer ones average them (Moré and
Wild 2012, doi 10.1145/2168773.2168777, balance that against the curvature), but where parameters
nearly replace each other no length shows the direction in which they do. Differences far shorter
lie between two jumps as a rule, and are then exact but for rounding. A descent likes to end beside
a jump; then each of them crosses it to one side, and is exact to the other. Where rounding is
amplified, as by bristles, longer ones are better.

Which fan of differences is good is seen from a point at which all coordinates have moved at once:
it shows the sum of what each of them has changed, but for jumps, rounding and curvature.

Where none of one length is good, one length does not serve all: what outweighs the roughness in a
coordinate that changes little is, in one that changes much, beyond all curvature. There each has a
length of its own, to both sides, over which the residuals change by the same share; and slopes at
the next point begin with these. That is for what is said of a fit; searches keep to one length.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..space import Array
from .differences import differences
from .moves import Answer, Detailed, Moves, SpentError

#: Length of differences that lie between two jumps, and of those to both sides that are taken where
#: no such fan is good.
SHORT, LONGER = 1e-9, (1e-6, 1e-4)
#: A fan is good if what does not add up is below this share of the least slope in any direction,
#: or of one that moves a parameter through its range before the misfit has doubled.
GOOD = 0.1
#: Own lengths change the residuals by this share of their size, and are no shorter and no longer;
#: they serve if what does not add up is below this share of the greatest change.
CHANGE, LEAST, MOST, SERVES = 0.1, 1e-6, 1e-2, 0.5
#: Fans of dim + 1 evaluations that slopes take at most.
MOST_FANS = 5 + 2 * len(LONGER)


class Slopes(NamedTuple):
    """Slopes of residuals at a point.

    Args:
        J: Over the unit cube, (dim, m); 0 where neither neighbour can be run.
        lengths: Of differences at the next point, (dim,), where each coordinate needs its own.
    """

    J: Array
    lengths: Array | None = None


class _Fan(NamedTuple):
    """Slopes by differences, one for each coordinate.

    Args:
        J: Slopes, (dim, m); 0 where no neighbour can be run.
        steps: The differences, (dim,); 0 there, too.
        left: What the sum of the changes leaves of that of all coordinates together, (m,); inf
            where these cannot be run.
    """

    J: Array
    steps: Array
    left: Array

    @property
    def serves(self) -> bool:
        """Whether differences of own lengths add up."""
        changes = _sizes(self.J) * np.abs(self.steps)
        return bool(_sizes(self.left) < SERVES * changes.max(initial=0.0))

    @property
    def error(self) -> float:
        """Of the slopes, as far as it shows."""
        length = float(np.abs(self.steps).max()) or 1.0
        return float(_sizes(self.left) / length / np.sqrt(len(self.steps)))

    def good(self, r: Array) -> bool:
        """Whether that is small, beside residuals r."""
        taken = self.steps != 0.0
        J = self.J if taken.all() else self.J[taken]
        least = float(np.linalg.eigvalsh(np.einsum("im,jm->ij", J, J)).min(initial=np.inf))
        weak = max(np.sqrt(max(least, 0.0)), float(_sizes(r)) / np.sqrt(len(r)))
        return bool(self.error <= GOOD * weak)


def slopes(u: Array, r: Array, lengths: Array | None = None, *, own: bool = False) -> Moves[Slopes]:
    """Slopes of residuals over the unit cube.

    It takes dim + 1 evaluations as a rule, and as many for each further fan; where these are spent
    the best so far counts.

    Args:
        u: Where, (dim,).
        r: The residuals there, (m,).
        lengths: Of differences that served nearby, where each coordinate needs its own, (dim,).
        own: Whether each may have its own.
    """
    fans: list[_Fan] = []
    try:
        if own and lengths is not None:
            fan = yield from _both_sides(u, r, lengths)
            if fan.serves:
                return _own(fan, r)
            fans.append(fan)
        if (yield from _until_good(u, r, fans)) and own:
            fan = yield from _both_sides(u, r, _lengths(_best(fans), r))
            if fan.serves:
                return _own(fan, r)
    except SpentError:
        if not fans:
            raise
    return Slopes(_best(fans).J)


def _best(fans: list[_Fan]) -> _Fan:
    return min(fans, key=lambda fan: fan.error)


def _own(fan: _Fan, r: Array) -> Slopes:
    return Slopes(fan.J, _lengths(fan, r))


def _lengths(fan: _Fan, r: Array) -> Array:
    """Over which each coordinate changes residuals r by a share of their size, by its slopes."""
    change = CHANGE * float(_sizes(r))
    lengths: Array = np.maximum(change / np.maximum(_sizes(fan.J), change / MOST), LEAST)
    return lengths


def _until_good(u: Array, r: Array, fans: list[_Fan]) -> Moves[bool]:
    """Take fans of one length, into `fans`, until one of them is good; whether none is."""
    ones = np.ones(len(u))
    up = yield from _fan(u, r, SHORT * ones)
    fans.append(up)
    if up.good(r):
        return False
    down = yield from _fan(u, r, -SHORT * ones)
    fans += [down, (yield from _less_steep(u, r, up, down))]
    for length in LONGER:
        if _best(fans).good(r):
            return False
        fans.append((yield from _both_sides(u, r, length * ones)))
    return not _best(fans).good(r)


def _both_sides(u: Array, r: Array, lengths: Array) -> Moves[_Fan]:
    up, down = (yield from _fan(u, r, lengths)), (yield from _fan(u, r, -lengths))
    return _central(up, down)


def _fan(u: Array, r: Array, lengths: Array) -> Moves[_Fan]:
    changes, steps = yield from differences(u, r, lengths, detailed=True)
    runs = np.isfinite(changes[:, 0])
    changes[~runs] = steps[~runs] = 0.0
    moved = (u + steps) - u  # as they are once rounded
    changes /= np.where(runs, moved, 1.0)[:, None]
    return (yield from _checked(u, r, changes, steps))


def _checked(u: Array, r: Array, J: Array, steps: Array) -> Moves[_Fan]:
    together = u + steps
    answer: Answer = yield Detailed(together[None])
    if answer.residuals is None or not np.isfinite(answer.costs[0]):
        return _Fan(J, steps, np.full(len(r), np.inf))
    left = answer.residuals[0] - r
    left -= np.einsum("i,im->m", together - u, J)
    return _Fan(J, steps, left)


def _less_steep(u: Array, r: Array, a: _Fan, b: _Fan) -> Moves[_Fan]:
    """Of each coordinate the difference that is less steep: a jump makes one steep."""
    first, second = (np.where(fan.steps, _sizes(fan.J), np.inf) for fan in (a, b))
    chosen = first <= second
    J = np.where(chosen[:, None], a.J, b.J)
    return (yield from _checked(u, r, J, np.where(chosen, a.steps, b.steps)))


def _central(a: _Fan, b: _Fan) -> _Fan:
    """The mean of differences to both sides; the first ones where one of them has a single side."""
    if (a.steps != -b.steps).any() or not np.isfinite(b.left[0]):
        return a
    return _Fan((a.J + b.J) / 2, a.steps, (a.left - b.left) / 2)


def _sizes(rows: Array) -> Array:
    """Euclidean norms along the last axis."""
    sizes: Array = np.sqrt(np.einsum("...m,...m->...", rows, rows))
    return sizes
