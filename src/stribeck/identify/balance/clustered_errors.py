"""Clustered errors: strokes and logs as units, and the lack of fit of one law for all logs.

The samples of a stroke are not observations of their own, and neither are the strokes of a log if
the next log, at another pressure or on another day, has another level. So the errors of a balance
of several logs are those of strokes as blocks; and where the levels of the logs lie further from
the law than their strokes scatter, each log counts as one observation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import fdtrc, stdtrit

from ...space import Array
from ..uncertainty.covariance import HALF_WIDTH
from . import variable_projection

if TYPE_CHECKING:
    from .balance import Balance

#: A law is told not to hold for all logs if chance gives such a lack of fit less often than this.
#: It is strict because the strokes of a log drift, so that their scatter shows too little.
CHANCE = 1e-3
#: A combination of parameters counts as seen by the levels of the logs if it moves them by this
#: share of what the best seen one does, and a parameter if this much of it lies in such.
_SEEN, _WITHIN = 0.01, 0.9
#: A parameter that the levels show only together with others counts if it makes this share of them.
_TENTH = 0.1


@dataclass(frozen=True, eq=False)
class Strokes:
    """Means over strokes: of residual and Jacobian, with log and direction."""

    log: Array
    direction: Array
    residual: Array
    jacobian: Array


def clustered_errors(
    solution: Balance, known_alone: frozenset[str] = frozenset()
) -> tuple[str, Array]:
    """What several logs say together, and standard errors that hold for them, (k,).

    The errors are scaled so that 1.96 of them make the 95 % interval of Student's distribution
    for as many strokes or logs as there are.

    Args:
        solution: The balance.
        known_alone: Parameters that single logs know, so that these can be compared
            (`log_spread`): the levels of the logs are asked about the others alone.

    Returns:
        A sentence if one law does not hold for all logs, else nothing; and the errors, never
        below the robust ones.
    """
    errors = solution.robust_errors.copy()
    # A reversal that is off by the sensor's error shifts the friction of states from there on.
    if len(solution.system.logs) < 2 and not solution.system.law.states:  # noqa: PLR2004
        return "", errors  # one log is no sample of logs
    blocks = _blocks(solution)
    free = np.array(solution.system.free)
    identified = np.isfinite(np.diag(solution.covariance))
    errors[free[identified]] = np.fmax(
        errors[free[identified]], _clustered(solution, blocks, identified)
    )
    levels = _levels(_strokes(solution, blocks))
    if levels is None:
        return "", errors
    sentences = []
    # Half the difference between the directions is friction, half the sum what is no friction.
    for half, quantity in ((1, "friction"), (0, "offset")):
        lack = _lack(solution, levels, half)
        if lack is None or lack[2] >= CHANCE:
            continue
        statistic, dof, chance, lack_errors = lack
        shown = [solution.names[i] for i, e in zip(free, lack_errors, strict=True) if e > 0]
        if known_alone.issuperset(shown):
            continue
        errors[free] = np.fmax(errors[free], lack_errors)
        names = map(solution.system.rig.label, shown)
        sentences.append(
            f"the {quantity} of the logs does not follow one law (lack of fit F({dof}, "
            f"{levels.dof}) = {statistic:.3g}, chance {chance:.1g}): one value of "
            f"{' or '.join(names)} for all is not a fact, and the intervals take each log as one "
            "observation"
        )
    return "; ".join(sentences), errors


def _blocks(solution: Balance) -> Array:
    """The stroke of each row: a number that rises at each reversal and log."""
    parts, last = [], 0
    for log in solution.system.logs:
        direction = np.sign(log.pick(log.v if log.path is None else log.path.heading))
        parts.append(last + np.cumsum(np.diff(direction, prepend=direction[:1]) != 0))
        last = int(parts[-1][-1]) + 1 if len(direction) else last
    return np.concatenate(parts)


def _clustered(solution: Balance, blocks: Array, identified: Array) -> Array:
    """Errors from whole strokes (the sandwich of Liang and Zeger 1986), (seen,)."""
    W = solution.jacobian[:, identified]
    scores = W * solution.residuals[:, None]
    starts = np.flatnonzero(np.diff(blocks, prepend=-1))
    sums = np.add.reduceat(scores, starts, axis=0)
    n, (rows, k) = len(starts), W.shape
    if n <= k:
        return np.zeros(k)
    prior = solution.system.free_prior[:, identified]
    bread = variable_projection.covariance(np.vstack([W, prior]), 1.0)
    meat = sums.T @ sums * n / (n - 1) * (rows - 1) / (rows - k)
    errors: Array = np.sqrt(np.diag(bread @ meat @ bread)) * stdtrit(n - k, 0.975) / HALF_WIDTH
    return errors


def _strokes(solution: Balance, blocks: Array) -> Strokes:
    logs = solution.system.logs
    log_of_row = np.repeat(np.arange(len(logs)), [len(log.t) for log in logs])
    direction = np.concatenate([np.sign(log.pick(log.v)) for log in logs])
    starts = np.flatnonzero(np.diff(blocks, prepend=-1))
    counts = np.diff(starts, append=len(blocks))
    long = counts >= np.median(counts) / 2  # what is left of a stroke at an edge is none
    mean = np.add.reduceat(np.column_stack([solution.residuals, solution.jacobian]), starts, axis=0)
    mean = (mean / counts[:, None])[long]
    return Strokes(log_of_row[starts][long], direction[starts][long], mean[:, 0], mean[:, 1:])


@dataclass(frozen=True, eq=False)
class Levels:
    """Per log, half the sum and half the difference of the directions' means."""

    residual: tuple[Array, Array]
    jacobian: tuple[Array, Array]
    cycles: Array
    scatter: float
    dof: int


def _levels(strokes: Strokes) -> Levels | None:
    """None where no two logs have strokes enough."""
    means, slopes, cycles = [], [], []
    square, dof = 0.0, 0
    for log in np.unique(strokes.log):
        directions = [(strokes.log == log) & (strokes.direction == d) for d in (1, -1)]
        n = [int(np.count_nonzero(w)) for w in directions]
        if min(n) < 2:  # noqa: PLR2004 - a scatter takes two
            continue
        parts = [strokes.residual[w] for w in directions]
        means.append([part.mean() for part in parts])
        slopes.append([strokes.jacobian[w].mean(axis=0) for w in directions])
        cycles.append(2 * n[0] * n[1] / sum(n))
        square += 0.25 * sum(float(np.sum((part - part.mean()) ** 2)) for part in parts)
        dof += min(n) - 1
    if len(means) < 2 or not square > 0:  # noqa: PLR2004
        return None
    r, W = np.array(means), np.array(slopes)
    return Levels(
        (0.5 * (r[:, 0] + r[:, 1]), 0.5 * (r[:, 0] - r[:, 1])),
        (0.5 * (W[:, 0] + W[:, 1]), 0.5 * (W[:, 0] - W[:, 1])),
        np.array(cycles),
        square / dof,
        dof,
    )


def _lack(solution: Balance, levels: Levels, half: int) -> tuple[float, int, float, Array] | None:
    """Lack of fit of the levels of the logs: F, its degrees of freedom, its chance, and errors.

    The errors, (free,), are those of a regression with a log as the unit, 0 for parameters that
    the levels do not show. None where there are no more logs than such parameters.
    """
    r = levels.residual[half]
    size = np.abs(solution.values[solution.system.free])
    own_half, other_half = (levels.jacobian[i] * size for i in (half, 1 - half))
    at_home = np.linalg.norm(own_half, axis=0) > np.linalg.norm(other_half, axis=0)
    if not at_home.any():
        return None
    # A level of many strokes is known better than one of few, and only weighted so is it an F.
    weight = np.sqrt(levels.cycles)
    scaled, dof, *_ = _regressed(weight[:, None] * own_half[:, at_home], weight * r)
    # The errors take each log as one observation, however long it is.
    residual, log_dof, s, Vt = _regressed(own_half[:, at_home], r)
    if min(dof, log_dof) < 1:
        return None
    statistic = float(scaled @ scaled) / dof / levels.scatter
    # What the levels show is regressed on; of what they only show together, each may be it alone.
    shown = (Vt**2).sum(axis=0) >= _WITHIN
    alone = np.linalg.norm(own_half[:, at_home], axis=0)
    share = np.where(shown, np.sqrt(((Vt.T / s) ** 2).sum(axis=1)), 1 / np.fmax(alone, 1e-300))
    share[~shown & (alone < _TENTH * s[0])] = 0.0
    errors = np.zeros(len(size))
    errors[at_home] = (
        share * np.sqrt(residual @ residual / log_dof) * stdtrit(log_dof, 0.975) / HALF_WIDTH
    )
    chance = float(fdtrc(dof, levels.dof, statistic))
    return statistic, dof, chance, errors * size


def _regressed(W: Array, r: Array) -> tuple[Array, int, Array, Array]:
    """What W leaves of r, its degrees of freedom, and W's singular values and rows that count."""
    U, s, Vt = np.linalg.svd(W, full_matrices=False)
    significant = s > _SEEN * s[0]
    residual: Array = r - U[:, significant] @ (U[:, significant].T @ r)
    return residual, len(r) - int(significant.sum()), s[significant], Vt[significant]
