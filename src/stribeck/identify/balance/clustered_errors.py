"""Several logs of one axis: strokes and logs as units, and whether one law holds for them all.

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
#: An interval is told as 1.96 standard errors.
_NORMAL = 1.96


@dataclass(frozen=True, eq=False)
class Strokes:
    """Means over strokes: of residual and Jacobian, with log and direction."""

    log: Array
    direction: Array
    residual: Array
    jacobian: Array


def block_errors(found: Balance) -> tuple[str, Array]:
    """What several logs say together, and standard errors that hold for them, (k,).

    The errors are scaled so that 1.96 of them make the 95 % interval of Student's distribution
    for as many strokes or logs as there are.

    Returns:
        A sentence if one law does not hold for all logs, else nothing; and the errors, never
        below the robust ones.
    """
    errors = found.robust_errors.copy()
    if len(found.system.logs) < 2:  # noqa: PLR2004 - one log is no sample of logs
        return "", errors
    blocks = _blocks(found)
    free = np.array(found.system.free)
    seen = np.isfinite(np.diag(found.covariance))
    errors[free[seen]] = np.fmax(errors[free[seen]], _clustered(found, blocks, seen))
    levels = _levels(_strokes(found, blocks))
    if levels is None:
        return "", errors
    said = []
    # Half the difference between the directions is friction, half the sum what is no friction.
    for half, what in ((1, "friction"), (0, "offset")):
        lack = _lack(found, levels, half)
        if lack is None or lack[2] >= CHANCE:
            continue
        statistic, between, chance, wide = lack
        errors[free] = np.fmax(errors[free], wide)
        names = [found.system.rig.label(found.names[i])
                 for i, e in zip(free, wide, strict=True) if e > 0]  # fmt: skip
        said.append(
            f"the {what} of the logs does not follow one law (lack of fit F({between}, "
            f"{levels.within}) = {statistic:.3g}, chance {chance:.1g}): one value of "
            f"{' or '.join(names)} for all is not a fact, and the intervals take each log as one "
            "observation"
        )
    return "; ".join(said), errors


def _blocks(found: Balance) -> Array:
    """The stroke of each row: a number that rises at each reversal and log."""
    parts, last = [], 0
    for log in found.system.logs:
        way = np.sign(log.pick(log.v))
        parts.append(last + np.cumsum(np.diff(way, prepend=way[:1]) != 0))
        last = int(parts[-1][-1]) + 1 if len(way) else last
    return np.concatenate(parts)


def _clustered(found: Balance, blocks: Array, seen: Array) -> Array:
    """Errors from whole strokes (the sandwich of Liang and Zeger 1986), (seen,)."""
    W = found.jacobian[:, seen]
    scores = W * found.residuals[:, None]
    starts = np.flatnonzero(np.diff(blocks, prepend=-1))
    sums = np.add.reduceat(scores, starts, axis=0)
    n, (rows, k) = len(starts), W.shape
    if n <= k:
        return np.zeros(k)
    bread = variable_projection.covariance(W, 1.0)
    meat = sums.T @ sums * n / (n - 1) * (rows - 1) / (rows - k)
    errors: Array = np.sqrt(np.diag(bread @ meat @ bread)) * stdtrit(n - k, 0.975) / _NORMAL
    return errors


def _strokes(found: Balance, blocks: Array) -> Strokes:
    logs = found.system.logs
    which = np.repeat(np.arange(len(logs)), [len(log.t) for log in logs])
    way = np.concatenate([np.sign(log.pick(log.v)) for log in logs])
    starts = np.flatnonzero(np.diff(blocks, prepend=-1))
    counts = np.diff(starts, append=len(blocks))
    long = counts >= np.median(counts) / 2  # what is left of a stroke at an edge is none
    mean = np.add.reduceat(np.column_stack([found.residuals, found.jacobian]), starts, axis=0)
    mean = (mean / counts[:, None])[long]
    return Strokes(which[starts][long], way[starts][long], mean[:, 0], mean[:, 1:])


@dataclass(frozen=True, eq=False)
class Levels:
    """Per log, half the sum and half the difference of the directions' means."""

    residual: tuple[Array, Array]
    jacobian: tuple[Array, Array]
    cycles: Array
    scatter: float
    within: int


def _levels(strokes: Strokes) -> Levels | None:
    """None where no two logs have strokes enough."""
    means, slopes, cycles = [], [], []
    square, within = 0.0, 0
    for log in np.unique(strokes.log):
        ways = [(strokes.log == log) & (strokes.direction == d) for d in (1, -1)]
        n = [int(np.count_nonzero(w)) for w in ways]
        if min(n) < 2:  # noqa: PLR2004 - a scatter takes two
            continue
        parts = [strokes.residual[w] for w in ways]
        means.append([part.mean() for part in parts])
        slopes.append([strokes.jacobian[w].mean(axis=0) for w in ways])
        cycles.append(2 * n[0] * n[1] / sum(n))
        square += 0.25 * sum(float(np.sum((part - part.mean()) ** 2)) for part in parts)
        within += min(n) - 1
    if len(means) < 2 or not square > 0:  # noqa: PLR2004
        return None
    r, W = np.array(means), np.array(slopes)
    return Levels(
        (0.5 * (r[:, 0] + r[:, 1]), 0.5 * (r[:, 0] - r[:, 1])),
        (0.5 * (W[:, 0] + W[:, 1]), 0.5 * (W[:, 0] - W[:, 1])),
        np.array(cycles),
        square / within,
        within,
    )


def _lack(found: Balance, levels: Levels, half: int) -> tuple[float, int, float, Array] | None:
    """Lack of fit of the levels of the logs: F, its degrees of freedom, its chance, and errors.

    The errors, (free,), are those of a regression with a log as the unit, 0 for parameters that
    the levels do not show. None where there are no more logs than such parameters.
    """
    r = levels.residual[half]
    size = np.abs(found.values[found.system.free])
    here, elsewhere = (levels.jacobian[i] * size for i in (half, 1 - half))
    at_home = np.linalg.norm(here, axis=0) > np.linalg.norm(elsewhere, axis=0)
    if not at_home.any():
        return None
    # A level of many strokes is known better than one of few, and only weighted so is it an F.
    weight = np.sqrt(levels.cycles)
    scaled, between, *_ = _regressed(weight[:, None] * here[:, at_home], weight * r)
    # The errors take each log as one observation, however long it is.
    left, freedom, s, Vt = _regressed(here[:, at_home], r)
    if min(between, freedom) < 1:
        return None
    statistic = float(scaled @ scaled) / between / levels.scatter
    # What the levels show is regressed on; of what they only show together, each may be it alone.
    shown = (Vt**2).sum(axis=0) >= _WITHIN
    alone = np.linalg.norm(here[:, at_home], axis=0)
    share = np.where(shown, np.sqrt(((Vt.T / s) ** 2).sum(axis=1)), 1 / np.fmax(alone, 1e-300))
    share[~shown & (alone < _TENTH * s[0])] = 0.0
    errors = np.zeros(len(size))
    errors[at_home] = share * np.sqrt(left @ left / freedom) * stdtrit(freedom, 0.975) / _NORMAL
    chance = float(fdtrc(between, levels.within, statistic))
    return statistic, between, chance, errors * size


def _regressed(W: Array, r: Array) -> tuple[Array, int, Array, Array]:
    """What W leaves of r, its degrees of freedom, and W's singular values and rows that count."""
    U, s, Vt = np.linalg.svd(W, full_matrices=False)
    kept = s > _SEEN * s[0]
    left: Array = r - U[:, kept] @ (U[:, kept].T @ r)
    return left, len(r) - int(kept.sum()), s[kept], Vt[kept]
