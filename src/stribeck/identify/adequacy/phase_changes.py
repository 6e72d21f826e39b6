"""An inertia or a friction that comes and goes within a log.

An axis that picks and places has a load for every other stroke; friction wanders with lubricant,
heat and what lies on the guides. Twelve bins of time are too coarse for either, and neither a drift
nor a single change describes it. Here each phase of a motion has an estimate of its own. Estimates
of one constant have errors of either sign; those of one that stays for some phases, or changes
slowly, resemble their neighbours (the serial correlation of von Neumann 1941, doi
10.1214/aoms/1177731677; here over its own size, as phases are not equally long).

Noise may remember for longer than a phase, and must not look like that. Of an inertia, a phase
begins where the axis turns from speeding up to slowing down or back; the phase's own force and
friction are estimated with it and take such noise up. The noise of the acceleration makes the
inertia of slow strokes smaller; what the same noise once more adds is taken off, as in
`acceleration_error`. Of friction, a phase is a stroke from one reversal to the next. A force that
is left over for two strokes is more friction in one and less in the other, so that noise with a
memory makes neighbours differ. What goes with the speed or the place of a stroke tells nothing: it
is a law's matter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from ...space import Array
from .remainder import Remainder
from .residual_rows import FEWEST, ResidualRows

#: Phases that are taken together: a load may stay for long or short. Of strokes each is for itself:
#: in two of them together a zero that drifts would be friction.
_TOGETHER = (1, 2)
#: A phase begins where the acceleration has turned and is above this share of its root mean square.
_TURNED = 0.5
#: One in which inertia does less than this share of the mean belongs to the one before.
_LEAST = 0.02
#: Phases of which each estimate is the mean: it and its neighbours.
_SMOOTHED = 3
#: Shares of all that is known at which the least and the greatest estimate are read.
_ENDS = (0.1, 0.9)
#: A phase knows an inertia if its own force and friction leave this share of what that does.
_KNOWN = 0.01


@dataclass(frozen=True, eq=False)
class PhaseChanges:
    """An inertia or a friction that differs from phase to phase of logs.

    Args:
        more: What there is of it beyond the mean of its log, (rows,), SI.
        least: What it is at least, less that mean.
        greatest: What it is at most, less that mean.
        probability: That chance makes neighbouring phases so much alike.
    """

    more: Array
    least: float
    greatest: float
    probability: float


def phase_changes(
    remainder: Remainder, kind: Literal["inertia", "friction"], chance: float
) -> PhaseChanges | None:
    """How the inertia or the friction in a residual comes and goes.

    Args:
        remainder: What parameters and patterns leave of it.
        kind: Which of the two.
        chance: Greatest probability of chance; None is returned where it is more probable, or
            where there are too few phases.
    """
    return (_of_inertia if kind == "inertia" else _of_friction)(remainder, chance)


def _of_inertia(remainder: Remainder, chance: float) -> PhaseChanges | None:
    rows = remainder.source
    phase, log = _phases(rows)
    if len(log) < FEWEST:
        return None

    def estimated(rows: ResidualRows) -> Array:
        columns = np.column_stack([rows.jacobian, remainder.columns])
        return _inertias(rows, rows.residual - columns @ remainder.x, phase)

    inertias = _inertias(rows, remainder.rows.residual, phase)
    probability = min(_by_chance(inertias, log, count) for count in _TOGETHER)
    if probability <= chance:  # what takes several times as long
        inertias = rows.without_error(estimated)
        probability = min(_by_chance(inertias, log, count) for count in _TOGETHER)
    if probability > chance:
        return None
    more, least, greatest = _changes(inertias, log)
    return PhaseChanges(more[phase], least, greatest, probability)


def _of_friction(remainder: Remainder, chance: float) -> PhaseChanges | None:
    rows = remainder.source
    stroke, log = _strokes(rows)
    if len(log) < FEWEST:
        return None
    frictions = _frictions(remainder.rows, stroke)
    probability = _by_chance(_without_law(rows, frictions, stroke), log, 1)
    if probability > chance:
        return None
    more, least, greatest = _changes(frictions, log)
    return PhaseChanges(_between(rows, more, stroke), least, greatest, probability)


def _beyond_mean(estimated: Array, log: NDArray[np.intp]) -> tuple[Array, Array]:
    """Sums of products and of squares, as in `_inertias`, the first less the mean of its log."""
    score, known = np.where(estimated[1] > 0.0, estimated, 0.0)
    in_all = np.bincount(log, known)[log]
    score = score - np.bincount(log, score)[log] / np.where(in_all > 0, in_all, np.inf) * known
    return score, known


def _changes(estimated: Array, log: NDArray[np.intp]) -> tuple[Array, float, float]:
    """What there is beyond the mean of a log, (phases,), at least and at most."""
    score, known = _beyond_mean(estimated, log)
    smooth = np.concatenate([_smoothed(score[log == k], known[log == k]) for k in np.unique(log)])
    order = np.argsort(smooth, kind="stable")
    done = np.cumsum(known[order])
    least, greatest = smooth[order][np.searchsorted(done, np.array(_ENDS) * done[-1])].tolist()
    return smooth, least, greatest


def _by_chance(estimated: Array, log: NDArray[np.intp], count: int) -> float:
    """The probability that neighbours, some phases each, are so much alike by chance.

    Their products have signs by chance then, so that the sum of them is that of a walk.
    """
    score, known = _beyond_mean(estimated, log)
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
    """The estimate of each phase of a log and its neighbours, beyond the mean, (phases,)."""
    side, n = _SMOOTHED // 2, len(score)
    above, below = (np.convolve(x, np.ones(_SMOOTHED))[side : side + n] for x in (score, known))
    return np.asarray(above / np.where(below > 0, below, np.inf))


def _phases(rows: ResidualRows) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The phase of each row in which it speeds up or slows down, (rows,), and each phase's log."""
    a = rows.inertial
    turned = np.abs(a) > _TURNED * np.sqrt(np.mean(a**2))
    last = np.maximum.accumulate(np.where(turned, np.arange(len(a)), 0))
    phase = _runs(np.sign(a)[last], rows.direction, rows.log)
    first = np.flatnonzero(np.diff(phase, prepend=-1))
    log, done = rows.log[first], np.bincount(phase, a**2)
    begins = np.diff(log, prepend=-1) != 0
    begins |= done > _LEAST * done.mean()
    return (np.cumsum(begins) - 1)[phase], log[begins]


def _strokes(rows: ResidualRows) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The stroke of each row, (rows,), and the log of each stroke."""
    stroke = _runs(rows.direction, rows.log)
    return stroke, rows.log[np.flatnonzero(np.diff(stroke, prepend=-1))]


def _runs(*columns: NDArray[np.generic]) -> NDArray[np.intp]:
    """The run of each row in which no column changes, (rows,)."""
    changes = np.logical_or.reduce([x[1:] != x[:-1] for x in columns])
    return np.concatenate([[0], np.cumsum(changes)])


def _between(rows: ResidualRows, values: Array, stroke: NDArray[np.intp]) -> Array:
    """Values of strokes as lines from the middle of one to that of the next, (rows,)."""
    result = np.empty(len(rows))
    for k in np.unique(rows.log):
        here = rows.log == k
        which, first, count = np.unique(stroke[here], return_index=True, return_counts=True)
        t = rows.t[here]
        result[here] = np.interp(t, 0.5 * (t[first] + t[first + count - 1]), values[which])
    return result


def _inertias(rows: ResidualRows, residual: Array, phase: NDArray[np.intp]) -> Array:
    """Of each phase, the product of acceleration and residual, and its square, (2, phases).

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


def _frictions(rows: ResidualRows, stroke: NDArray[np.intp]) -> Array:
    """Of each stroke, the sum of residuals against the motion, and how many, (2, strokes)."""
    return np.array([np.bincount(stroke, rows.direction * rows.residual), np.bincount(stroke)])


def _without_law(rows: ResidualRows, estimated: Array, stroke: NDArray[np.intp]) -> Array:
    """Frictions without what goes with a stroke's speed and place, each as a parabola."""
    score, known = estimated
    columns = [np.ones(len(known))]
    for values in (np.abs(rows.velocity), rows.position):
        mean = np.bincount(stroke, values) / known
        mean = (mean - mean.mean()) / (np.std(mean) or 1.0)
        columns += [mean, mean**2]
    weights, Z = np.sqrt(known), np.column_stack(columns)
    x = np.linalg.lstsq(Z * weights[:, None], score / weights, rcond=1e-9)[0]
    return np.array([score - known * (Z @ x), known])
