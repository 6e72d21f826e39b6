"""Moving-block bootstrap: refits of data sets resampled in blocks of residuals.

Residuals are drawn anew in blocks, circularly and within their logs, so that they correlate as
the real ones do, and are added to the fitted motion; each such data set is fitted from the best
fit on. Künsch 1989, doi 10.1214/aos/1176347265. Blocks are as long as the rule of Politis and
White asks for (2004, doi 10.1081/ETR-120028836, corrected by Patton, Politis and White 2009, doi
10.1080/07474930802459016).

For an estimate that is linear in the residuals, drawing blocks is the same as Bartlett weights over
their length; so the residuals are stretched by what such an interval lacks (`covariance.fixed_b`).

Intervals are percentiles of the estimates. In the Monte Carlo of `tests/test_bootstrap.py` and on
twins of the slide bed they hold the truth at least as often as basic intervals (the percentiles
mirrored at the fit), which, besides, reach beyond the search range.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.random import SeedSequence

from ...errors import InputError
from ...optimize.box import Box
from ...optimize.lockstep import AskTell, Counted, lockstep, rms
from ...optimize.moves import Answer, Moves
from ...optimize.trust_region import Iterate, minimise
from ...space import Array, Rng
from .covariance import autocovariance, fixed_b
from .linearisation import box_of, linearised
from .residuals import Residuals, logs_of, parts

#: Data sets drawn unless a caller says otherwise, and the fewest fits that make an interval.
DRAWS, FEWEST = 200, 40
LEVEL = 0.95
#: A refit is over where no step promises more than this many residual variances, by slopes taken
#: there: a fiftieth of a standard error. Along a curved valley that takes many steps, and refits
#: that end early huddle about the fit.
FINE = 4e-4
#: Rows that a refit may ask for, per parameter and besides.
EACH, BESIDES = 40, 40
#: Memory for slopes, bytes: so many refits advance at once.
MEMORY = 2e8


@dataclass(frozen=True, eq=False)
class Bootstrap:
    """What the drawn data sets were fitted to.

    Args:
        names: The free parameters.
        value: The fit that it started from, SI, (dim,).
        draws: The estimates, SI, (n, dim): those that succeeded.
        failed: How many data sets could not be fitted.
        block: Length of the blocks, rows.
        low: Lower ends of the intervals, SI, (dim,); nan with too few fits.
        high: Upper ends.
        rows: Rows evaluated.
    """

    names: tuple[str, ...]
    value: Array
    draws: Array = field(repr=False)
    failed: int
    block: int
    low: Array
    high: Array
    rows: int


def bootstrap(
    problem: Residuals,
    x: Array,
    *,
    n: int = DRAWS,
    seed: int = 0,
    level: float = LEVEL,
    block: int | None = None,
    budget: int | None = None,
) -> Bootstrap:
    """Refit `n` data sets drawn about a fit.

    Args:
        problem: Its residuals; see `Residuals`.
        x: The fit, SI, (dim,).
        n: Data sets.
        seed: Of the draws.
        level: Of the intervals.
        block: Rows of a block; by default from the residuals' autocorrelation.
        budget: Rows that may be evaluated; by default what all refits may need. Data sets
            that it does not reach count as failed.

    Raises:
        InputError: the fit cannot be run, or n or block is below 1.
    """
    for name, value in (("n", n), ("block", block)):
        if value is not None and value < 1:
            raise InputError(f"bootstrap: {name} must be a whole number >= 1, got {value}")
    box = box_of(problem)
    rows = EACH * box.dim + BESIDES
    counted = Counted(problem, n * rows + 3 * box.dim + 1 if budget is None else budget)
    best = linearised(counted, box, x)
    logs = logs_of(problem, len(best.r))
    length = block or block_length(best.r[: sum(logs)], logs)
    scale = np.sqrt(len(best.r) / (len(best.r) - box.dim)) * fixed_b(length / len(best.r))
    rngs = [np.random.default_rng(s) for s in SeedSequence(seed).spawn(n)]
    gain = FINE * best.squares / (len(best.r) - box.dim)
    fits: list[Array] = []
    at_once = max(int(MEMORY / (8 * best.J.size)), 1)
    for first in range(0, n, at_once):
        tasks = [
            AskTell("refit", box.space, _refit(best, box, gain, rows, added))
            for added in (
                scale * blocks(best.r, logs, length, rng) - best.r
                for rng in rngs[first : first + at_once]
            )
        ]
        refits = lockstep(counted, tasks)
        counted.forget()
        fits += [box.x(refit[0].u) for refit in refits if refit is not None and refit[1]]
    draws = np.array(fits).reshape(len(fits), box.dim)
    tail = 50 * (1 - level)
    ends = np.full((2, box.dim), np.nan)
    if len(draws) >= FEWEST:
        ends = np.percentile(draws, [tail, 100 - tail], axis=0, method="weibull")
    return Bootstrap(
        box.space.names,
        box.x(best.u),
        draws,
        n - len(draws),
        length,
        ends[0],
        ends[1],
        counted.rows,
    )


def _refit(
    best: Iterate, box: Box, gain: float, rows: int, added: Array
) -> Moves[tuple[Iterate, bool]]:
    """Fit one data set, whose residuals are the problem's and `added`, (N,), from the best fit on.

    The last iterate, and whether it came to rest.
    """
    start = best.moved(best.u, best.r + added)
    moves = minimise(replace(start, age=0), box, gain=gain, rows=rows)
    try:
        batch = next(moves)
        while True:
            answer: Answer = yield batch
            assert answer.residuals is not None  # noqa: S101 - the problem shows them
            residuals = answer.residuals + added
            batch = moves.send(Answer(rms(residuals), residuals))
    except StopIteration as done:
        refit: tuple[Iterate, bool] = done.value
        return refit


def blocks(r: Array, logs: Sequence[int], length: int, rng: Rng) -> Array:
    """Residuals drawn anew, (N,): circular blocks from each log, about a mean of zero.

    Those of priors, the rows after those of the logs, are drawn from the normal distribution that
    each stands for.
    """
    drawn, data = [], sum(logs)
    for part in parts(r - r[:data].mean(), logs):
        rows = len(part)
        size = min(length, rows)
        begins = rng.integers(0, rows, size=-(-rows // size))
        at = (begins[:, None] + np.arange(size)) % rows
        drawn.append(part[at.ravel()[:rows]])
    drawn.append(np.sqrt(np.mean(r[:data] ** 2)) * rng.standard_normal(len(r) - data))
    return np.concatenate(drawn)


def block_length(r: Array, logs: Sequence[int]) -> int:
    """The length of circular blocks by Politis and White, from all logs together; at least 1.

    The variance of a mean is what the rule makes best; the lag up to which correlations count
    is where they first stay within two standard errors for K lags in a row.
    """
    rows = len(r)
    K = max(5, int(np.sqrt(np.log10(rows))))
    most = int(np.ceil(np.sqrt(rows))) + K
    total = np.zeros(most + K + 1)
    for part in parts(r - r.mean(), logs):
        products = autocovariance(part, len(total))
        total[: len(products)] += products
    if not total[0] > 0:
        return 1
    rho, threshold = total / total[0], 2 * np.sqrt(np.log10(rows) / rows)
    small = np.abs(rho[1:]) < threshold
    runs = np.convolve(small, np.ones(K), mode="valid") == K
    m = int(np.argmax(runs)) if runs.any() else most
    if m == 0:
        return 1
    M = min(2 * m, len(total) - 1)
    k = np.arange(1, M + 1)
    taper = np.clip(2 * (1 - k / M), 0.0, 1.0)  # the flat-top window of the rule
    gamma = total / rows
    G = 2 * float(np.sum(taper * k * gamma[1 : M + 1]))
    g0 = float(gamma[0] + 2 * np.sum(taper * gamma[1 : M + 1]))
    longest = int(np.ceil(min(3 * np.sqrt(rows), rows / 3)))
    if not g0 > 0:
        return max(min(m, longest), 1)
    best = (2 * G**2 / (4 / 3 * g0**2)) ** (1 / 3) * rows ** (1 / 3)
    return int(min(max(np.ceil(best), 1), longest))
