"""A paired test of the held-out errors of two models, over blocks of samples.

Both models answer for the same samples, so what counts is how their squared errors differ there.
Differences correlate in time: they are summed over blocks that are several correlation times
long, which are taken as independent. Of each block the ratio of the two errors is taken, and
Student's t is asked of the logarithms of these ratios. A logarithm, because errors differ from
block to block by factors: one block in which everything goes wrong (a motion that slips a moment
too late) would otherwise drown what all others say.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...space import Array
from ..uncertainty.covariance import autocovariance, correlation_time
from ..uncertainty.residuals import parts

#: A one-sided test of this size; and by how much an error must be greater to matter in practice,
#: where it is not known by what share the friction differs.
LEVEL, MARGIN = 0.05, 0.01
#: Friction that differs by less than this share does not matter: that of an axis differs by more
#: from day to day.
MATERIAL = 0.02
#: Blocks are so many correlation times long, and at most so many.
TIMES, MOST = 3.0, 24
#: Blocks below which nothing is tested, because no test would see much; and what counts as worse
#: there.
FEWEST, COARSE = 4, 0.1
#: What is below this share of all squared errors counts as this.
EXACT = 1e-12
#: Lags of the test for whiteness.
LAGS = 20


@dataclass(frozen=True)
class Paired:
    """One model's held-out error against another's.

    Args:
        change: Relative change of the error in a typical block (their geometric mean), 0.05 for
            5 % worse.
        low: Lower end of its 90 % interval, so that 5 % lie beyond each end; nan if not tested.
        high: Upper end.
        p: Probability of such a change or a greater one if the error were not greater (at most 1 %
            greater, where `friction` is nan); nan if there are too few blocks to tell.
        blocks: How many there are.
        friction: By what share the friction of the two differs at most within the motion, 0.1 for
            10 %; nan where that cannot be said.
    """

    change: float
    low: float
    high: float
    p: float
    blocks: int
    friction: float = float("nan")

    @property
    def worse(self) -> bool:
        """Whether it is worse, and matters.

        Significantly, or by more than a tenth where nothing is tested; unless the friction of the
        two is the same within `MATERIAL`.
        """
        if self.friction <= MATERIAL:
            return False
        return self.change > COARSE if np.isnan(self.p) else self.p < LEVEL


def blocks(first: Sequence[Array], second: Sequence[Array]) -> list[list[slice]]:
    """How each held-out piece is cut, for two models' losses of the same samples."""
    pieces = [len(r) for r in first]
    differences = np.concatenate([a - b for a, b in zip(first, second, strict=True)])
    length = max(TIMES * correlation_time(differences, pieces), sum(pieces) / MOST)
    cut = []
    for n in pieces:
        edges = np.linspace(0, n, max(int(n / length), 1) + 1).round().astype(int)
        cut.append([slice(int(a), int(b)) for a, b in pairwise(edges)])
    return cut


def paired(
    first: Sequence[Array],
    second: Sequence[Array],
    *,
    power: int = 2,
    friction: float = float("nan"),
) -> Paired:
    """How much worse `first` is than `second`.

    Args:
        first: Residuals of one model, an array a piece.
        second: Those of the other, of the same pieces.
        power: What counts: 2 for squares of the residuals, 1 for their sizes.
        friction: By what share the friction of the two differs. Where it is known, it says
            whether a difference matters, and the test is for any difference of the errors.
    """
    nan, margin = float("nan"), MARGIN if np.isnan(friction) else 0.0
    for r, change in ((first, float("inf")), (second, -1.0)):
        if not all(np.isfinite(piece).all() for piece in r):
            return Paired(change, nan, nan, 0.0 if change > 0 else 1.0, len(r), friction)
    losses = [[np.abs(r) ** power for r in model] for model in (first, second)]
    cut = blocks(*losses)
    A, B = (
        np.array([float(r[b].sum()) for r, bs in zip(model, cut, strict=True) for b in bs])
        for model in losses
    )
    least = EXACT * float(A.sum() + B.sum())
    if not least > 0:
        return Paired(0.0, 0.0, 0.0, 1.0, len(A), friction)
    logs = 1 / power * np.log((A + least) / (B + least))
    mean = float(logs.mean())
    if len(logs) < FEWEST:
        return Paired(float(np.expm1(mean)), nan, nan, nan, len(logs), friction)
    from scipy.special import stdtr, stdtrit  # noqa: PLC0415 - slow to import

    dof, excess = len(logs) - 1, mean - float(np.log1p(margin))
    error = float(np.std(logs, ddof=1) / np.sqrt(len(logs)))
    p = float(stdtr(dof, -excess / error if error > 0 else np.copysign(np.inf, -excess)))
    reach = float(stdtrit(dof, 1 - LEVEL)) * error
    low, high = (float(np.expm1(end)) for end in (mean - reach, mean + reach))
    return Paired(float(np.expm1(mean)), low, high, p, len(logs), friction)


@dataclass(frozen=True)
class Whiteness:
    """How far residuals are from white noise.

    Args:
        lag_1: Correlation of neighbours.
        time: Integrated correlation time, samples: 1 for white noise.
        Q: Ljung and Box's statistic over `lags` lags (1978, doi 10.1093/biomet/65.2.297).
        lags: How many.
        p: Probability of that or more in white noise.
    """

    lag_1: float
    time: float
    Q: float
    lags: int
    p: float


def whiteness(r: Array, logs: Sequence[int]) -> Whiteness:
    """Look for correlation in residuals (N,) of logs of so many rows; none reaches across logs."""
    from scipy.special import chdtrc  # noqa: PLC0415 - slow to import

    lags = max(min(LAGS, len(r) // 5), 1)
    total = np.zeros(lags + 1)
    for part in parts(r, logs):
        products = autocovariance(part - part.mean(), lags + 1)
        total[: len(products)] += products
    if not total[0] > 0:
        return Whiteness(0.0, 1.0, 0.0, lags, 1.0)
    rho, n = total[1:] / total[0], len(r)
    Q = float(n * (n + 2) * np.sum(rho**2 / (n - np.arange(1, lags + 1))))
    return Whiteness(float(rho[0]), correlation_time(r, logs), Q, lags, float(chdtrc(lags, Q)))


@dataclass(frozen=True)
class Criteria:
    """What a fit costs by Akaike, corrected for few samples (Hurvich and Tsai 1989), and Schwarz.

    With so few samples in effect that a criterion has no meaning, it is inf.
    """

    aicc: float
    bic: float


def criteria(mean_square: float, free: int, effective: float) -> Criteria:
    """The criteria for normal residuals.

    Args:
        mean_square: Of the training residuals.
        free: Parameters that were found; the variance counts as one more.
        effective: Samples in effect: rows over their correlation time.
    """
    k = free + 1
    if not mean_square > 0:
        return Criteria(float("-inf"), float("-inf"))
    fit = effective * float(np.log(mean_square))
    spare = effective - k - 1
    aicc = fit + 2 * k + 2 * k * (k + 1) / spare if spare > 0 else float("inf")
    return Criteria(aicc, fit + k * float(np.log(effective)))
