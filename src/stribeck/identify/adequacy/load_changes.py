"""An inertia that comes and goes within a log, as the load of an axis that picks and places.

Twelve bins of time are too coarse for a load that is there for every other stroke, and a single
change does not describe it. Here each phase of a motion, in which the axis speeds up or slows down,
has an estimate of the inertia beside a constant force and a friction of its own, which take up what
noise remembers for longer. Estimates of one inertia have errors of either sign; those of a load
that stays for some phases and is away for others resemble their neighbours (the serial correlation
of von Neumann 1941, doi 10.1214/aoms/1177731677; here over its own size, as phases are not equally
long). The noise of the acceleration makes the inertia of slow strokes smaller; what the same noise
once more adds to the estimates is taken off, as in `acceleration_error`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from ...space import Array
from .remainder import Remainder
from .residual_rows import FEWEST, ResidualRows

#: Phases that are taken together: a load may stay for long or short.
_TOGETHER = (1, 2)
#: A phase begins where the acceleration has turned and is above this share of its root mean square.
_TURNED = 0.5
#: One in which inertia does less than this share of the mean belongs to the one before.
_LEAST = 0.02
#: Phases of which each estimate is the mean: it and its neighbours.
_SMOOTHED = 3
#: Shares of all that inertia has done at which the least and the greatest load are read.
_ENDS = (0.1, 0.9)
#: A phase knows an inertia if its own force and friction leave this share of what that does.
_KNOWN = 0.01


@dataclass(frozen=True, eq=False)
class LoadChanges:
    """An inertia that differs from phase to phase of logs.

    Args:
        more: Inertia beyond the mean of its log, (rows,), SI.
        least: What it is at least, less that mean.
        greatest: What it is at most, less that mean.
        probability: That chance makes neighbouring phases so much alike.
    """

    more: Array
    least: float
    greatest: float
    probability: float


def load_changes(remainder: Remainder, chance: float) -> LoadChanges | None:
    """How the inertia in a residual comes and goes.

    Args:
        remainder: What parameters and patterns leave of it.
        chance: Greatest probability of chance; None is returned where it is more probable, or
            where there are too few phases.
    """
    rows = remainder.source
    phase, log = _phases(rows)
    if len(log) < FEWEST:
        return None

    def estimated(rows: ResidualRows) -> Array:
        columns = np.column_stack([rows.jacobian, remainder.columns])
        return _estimated(rows, rows.residual - columns @ remainder.x, phase)

    changes = _changes(estimated(rows), phase, log)
    if changes.probability <= chance:  # what takes several times as long
        changes = _changes(rows.without_error(estimated), phase, log)
    return changes if changes.probability <= chance else None


def _changes(estimated: Array, phase: NDArray[np.intp], log: NDArray[np.intp]) -> LoadChanges:
    """Inertia from phase to phase, as `_estimated` has it of each."""
    score, known = np.where(estimated[1] > 0.0, estimated, 0.0)
    in_all = np.bincount(log, known)[log]
    score = score - np.bincount(log, score)[log] / np.where(in_all > 0, in_all, np.inf) * known
    smooth = np.concatenate([_smoothed(score[log == k], known[log == k]) for k in np.unique(log)])
    order = np.argsort(smooth, kind="stable")
    done = np.cumsum(known[order])
    least, greatest = smooth[order][np.searchsorted(done, np.array(_ENDS) * done[-1])].tolist()
    probability = min(_by_chance(score, known, log, count) for count in _TOGETHER)
    return LoadChanges(smooth[phase], least, greatest, probability)


def _by_chance(score: Array, known: Array, log: NDArray[np.intp], count: int) -> float:
    """The probability that neighbours, some phases each, are so much alike by chance.

    Their products have signs by chance then, so that the sum of them is that of a walk.
    """
    products = []
    for k in np.unique(log):
        n = int(np.count_nonzero(log == k)) // count
        s, v = (x[log == k][: n * count].reshape(n, count).sum(axis=1) for x in (score, known))
        errors = s / np.sqrt(np.where(v > 0, v, np.inf))
        products.append(errors[1:] * errors[:-1])
    walk = np.concatenate(products)
    size = float(np.sqrt(walk @ walk))
    return float(ndtr(-walk.sum() / size)) if size > 0 else 1.0


def _smoothed(score: Array, known: Array) -> Array:
    """Inertia of each phase of a log and its neighbours, beyond the mean, (phases,)."""
    side, n = _SMOOTHED // 2, len(score)
    above, below = (np.convolve(x, np.ones(_SMOOTHED))[side : side + n] for x in (score, known))
    return np.asarray(above / np.where(below > 0, below, np.inf))


def _phases(rows: ResidualRows) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The phase of each row, (rows,), and the log of each phase."""
    a = rows.inertial
    turned = np.abs(a) > _TURNED * np.sqrt(np.mean(a**2))
    last = np.maximum.accumulate(np.where(turned, np.arange(len(a)), 0))
    changes = (np.diff(x) != 0 for x in (np.sign(a)[last], rows.direction, rows.log))
    phase = np.concatenate([[0], np.cumsum(np.logical_or.reduce(list(changes)))])
    first = np.flatnonzero(np.diff(phase, prepend=-1))
    log, done = rows.log[first], np.bincount(phase, a**2)
    begins = np.diff(log, prepend=-1) != 0
    begins |= done > _LEAST * done.mean()
    return (np.cumsum(begins) - 1)[phase], log[begins]


def _estimated(rows: ResidualRows, residual: Array, phase: NDArray[np.intp]) -> Array:
    """Of each phase, the product of inertia and residual, and inertia's square, (2, phases).

    Both less what a constant force and friction of the phase make of them.
    """
    a, d, r = rows.inertial, rows.direction, residual

    def total(values: Array) -> Array:
        return np.asarray(np.bincount(phase, values), dtype=float)

    n, forward, squares = total(np.ones(len(a))), total(d), total(d * d)
    a1, ad, r1, rd, aa = total(a), total(a * d), total(r), total(r * d), total(a * a)
    both = n * squares - forward**2
    two = both > _KNOWN * n * n

    def made(y1: Array, yd: Array) -> Array:
        """What force and friction, or where the axis goes one way their sum, make of a y."""
        mixed = squares * a1 * y1 - forward * (a1 * yd + ad * y1) + n * ad * yd
        return np.where(two, mixed / np.where(two, both, 1.0), a1 * y1 / n)

    score, known = total(a * r) - made(r1, rd), aa - made(a1, ad)
    return np.where(known > _KNOWN * aa, [score, known], 0.0)
