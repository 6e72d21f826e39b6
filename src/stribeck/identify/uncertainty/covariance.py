"""Errors from the slopes at an estimate: linear, from one batch of evaluations.

Residuals of a log correlate from sample to sample. How much that costs depends on the parameter:
one whose slopes change sign within the time in which residuals forget loses nothing, one with
even slopes the most. So each has its own ratio of the variance for residuals as they are (Newey
and West 1987, doi 10.2307/1913610) to the one for white ones. It is the greatest of three: of the
residuals themselves, which is too small where they forget slowly; of what a first-order
autoregression leaves of them (Andrews and Monahan 1992, doi 10.2307/2951574), which takes a slow
error of the model under the noise of a sensor for a fast one; and of residuals whose correlation is
the same everywhere. The first two know of a parameter that few rows show, a mass that accelerates
twice, no more than the residuals of those few rows do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from .residuals import parts

#: A direction is blind if its curvature is below this share of the greatest, slopes scaled to
#: one length.
BLIND = 1e-12
#: Critical value of a t test whose variance is Newey and West's with Bartlett weights over a share
#: b of the rows, divided by the normal's 1.96 (Kiefer and Vogelsang 2005, doi
#: 10.1017/S0266466605050565, table 1, 97.5 %): the estimated variance is uncertain itself.
FIXED_B = np.array([-0.5324, 0.4160, 2.9694, 1.9600]) / 1.9600
#: Half-width of a 95 % interval of a normal distribution, in standard deviations.
HALF_WIDTH = 1.96
#: Greatest autoregression that is taken out.
PERSISTENT = 0.97


@dataclass(frozen=True, eq=False)
class QuickLook:
    """Errors of estimates to first order, in the unit cube.

    Args:
        errors: Standard errors for residuals as correlated as they are, (dim,); inf for blind
            parameters.
        white: The same as if residuals were white.
        ratio: Variance of the first over that of the second, at least 1; (dim,).
        correlation: Of the estimates, (dim, dim); zero beside blind parameters.
        blind: Which parameters have a part in a direction that the data do not see.
        curvature: Pseudo-inverse of J J^T, (dim, dim).
        variance: Of the residuals, sum of squares over degrees of freedom.
        dof: Degrees of freedom.
    """

    errors: Array
    white: Array
    ratio: Array
    correlation: Array
    blind: NDArray[np.bool_]
    curvature: Array
    variance: float
    dof: int


def quick_look(J: Array, r: Array, logs: Sequence[int]) -> QuickLook:
    """Look at slopes J (dim, N) and residuals r (N,) of logs of so many rows each.

    Rows after those of the logs are priors: they tell as much as a row of the data's noise.
    """
    dim, rows = J.shape
    lengths = np.sqrt(np.einsum("im,im->i", J, J))
    lengths[lengths == 0] = 1.0
    gram = np.einsum("im,jm->ij", J, J) / np.outer(lengths, lengths)
    values, vectors = np.linalg.eigh(gram)
    visible = values > BLIND * max(float(values[-1]), np.finfo(float).tiny)
    part = vectors[:, visible] / np.sqrt(values[visible])
    C = part @ part.T / np.outer(lengths, lengths)
    blind = (np.abs(vectors[:, ~visible]) > np.sqrt(BLIND) ** 0.5).any(axis=1)
    dof = max(rows - dim, 1)
    variance = float(r @ r) / dof
    ratio = inflation(C, J, r, logs)
    ratio = np.where(blind, ratio.max(), ratio)  # away from here they may be seen like any other
    white = np.sqrt(variance * np.diag(C))
    errors = white * np.sqrt(ratio)
    spread = np.sqrt(np.diag(C))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = C / np.outer(spread, spread)
    correlation[blind], correlation[:, blind] = 0.0, 0.0
    correlation[~np.isfinite(correlation)] = 0.0
    np.fill_diagonal(correlation, 1.0)
    return QuickLook(
        np.where(blind, np.inf, errors),
        np.where(blind, np.inf, white),
        ratio,
        correlation,
        blind,
        C,
        variance,
        dof,
    )


def inflation(C: Array, J: Array, r: Array, logs: Sequence[int]) -> Array:
    """How many times the white variance each estimate has with residuals as they are, >= 1.

    Args:
        C: Inverse of J J^T, (dim, dim).
        J: Slopes, (dim, N).
        r: Residuals, (N,).
        logs: Rows of each log; rows after them are priors, whose error is white.
    """
    (dim, rows), data = J.shape, sum(logs)
    dof = max(rows - dim, 1)
    noise = float(r @ r) / dof
    r = r[:data]
    plain = float(_persistence([p[None] for p in parts(r, logs)], data)[0])
    whitened = [p[1:] - plain * p[:-1] for p in parts(r, logs)]
    reach = _reach(r, logs, data)
    reach_filtered = _reach(np.concatenate(whitened), [len(p) for p in whitened], data)
    del whitened
    correlation = _correlation(r, logs)
    total = np.empty(dim)
    for i in range(dim):  # one at a time: of a long log each takes as much as a channel
        moves = np.einsum("j,jm->m", C[i], J)
        prior = noise * float(np.square(moves[data:]).sum())
        moves = moves[:data]
        alike = noise * float(_sum_of_lags([p[None] for p in parts(moves, logs)], correlation)[0])
        moves *= r
        # They add up to zero but where an end of a range holds the fit, and how far it holds it
        # from the least sum of squares is no noise.
        moves -= moves.mean()
        shares = [p[None] for p in parts(moves, logs)]
        a = float(_persistence(shares, data)[0])
        as_is = _newey_west(shares, reach, data)
        for p in shares:  # from here on what the autoregression leaves
            p[:, 1:] -= a * p[:, :-1]
        filtered = [p[:, 1:] for p in shares]
        sums = max(_newey_west(filtered, reach_filtered, data) / (1 - a) ** 2, as_is)
        total[i] = max(sums * (data / dof), alike) + prior
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = total / (np.diag(C) * noise)
    return np.where(np.isfinite(ratio), np.maximum(ratio, 1.0), 1.0)


def _correlation(r: Array, logs: Sequence[int]) -> Array:
    """Autocorrelation of residuals up to the lag at which they forget, (lags,); 1 at lag 0."""
    total = np.zeros(first_below_zero(r, logs))
    for part in filter(len, parts(r, logs)):
        products = autocovariance(part, len(total))
        total[: len(products)] += products
    return total / total[0] if total[0] > 0 else np.ones(1)


def _sum_of_lags(shares: Sequence[Array], weights: Array) -> Array:
    """Sums of weights (lags,) times products of series (k, n) such a lag apart, both ways, (k,)."""
    weights = np.append(weights[:1], 2.0 * weights[1:])
    total = np.zeros(len(shares[0]))
    for part in shares:
        if part.size:
            products = autocovariance(part, len(weights))
            total += products @ weights[: products.shape[-1]]
    return total


def _reach(r: Array, logs: Sequence[int], rows: int) -> int:
    """Twice the lag at which residuals of logs forget, for Bartlett weights over so many rows."""
    reach = max(2 * first_below_zero(r, logs), int(4 * (rows / 100) ** (2 / 9)))
    return min(reach, max(rows // 5, 1))


def _newey_west(shares: Sequence[Array], reach: int, rows: int) -> float:
    """Variance of the sum of a series (1, n) of all logs, as widened as it is uncertain.

    Bartlett weights over `reach` of so many rows.
    """
    return float(long_run_variance(shares, reach)[0]) * fixed_b(reach / rows) ** 2


def long_run_variance(shares: Sequence[Array], reach: int) -> Array:
    """Variances of the sums of series (k, n) of all logs, with Bartlett weights over `reach`, (k,).

    The estimator of Newey and West (1987, doi 10.2307/1913610), as the mean square of the sums
    over windows of so many rows, also of those that reach beyond an end.
    """
    total = np.zeros(len(shares[0]))
    for part in shares:
        n = part.shape[1]
        if not n:
            continue
        sums = np.cumsum(part, axis=1)
        whole = sums[:, -1:]
        windows = (
            sums[:, : min(n, reach)],  # those that begin before the first row
            sums[:, reach:] - sums[:, : max(n - reach, 0)],
            whole - sums[:, max(n - reach, 0) : n - 1],  # those that end beyond the last
        )
        total += sum(np.einsum("im,im->i", w, w) for w in windows)
        total += max(reach - n, 0) * whole[:, 0] ** 2  # those that hold all rows
    return total / reach


def _persistence(shares: Sequence[Array], rows: int) -> Array:
    """First-order autoregression of series (k, n) of all logs, (k,), freed of its usual bias."""
    with np.errstate(invalid="ignore", divide="ignore"):
        a = sum(np.sum(p[:, 1:] * p[:, :-1], axis=1) for p in shares) / sum(
            np.sum(p * p, axis=1) for p in shares
        )
    a = np.where(np.isfinite(a), a, 0.0)
    return np.clip(a + (1 + 3 * a) / rows, -PERSISTENT, PERSISTENT)


def fixed_b(share: float) -> float:
    """By how much intervals widen because a variance from so long blocks is uncertain itself."""
    return float(np.polyval(FIXED_B, share))


def autocovariance(series: Array, lags: int) -> Array:
    """Sums of products a lag apart, (..., N) to (..., min(lags, N))."""
    from scipy.fft import irfft, next_fast_len, rfft  # noqa: PLC0415 - slow to import

    lags = min(lags, series.shape[-1])
    n = next_fast_len(series.shape[-1] + lags, real=True)
    rows = series.reshape(-1, series.shape[-1])
    products = np.empty((len(rows), lags))
    for row, sums in zip(rows, products, strict=True):
        sums[:] = irfft(np.abs(rfft(row, n)) ** 2, n)[:lags]
    return products.reshape(*series.shape[:-1], lags)


def first_below_zero(r: Array, logs: Sequence[int]) -> int:
    """The first lag at which residuals no longer resemble themselves, at most a tenth of them."""
    most = max(2, len(r) // 10)
    total = np.zeros(most)
    for part in filter(len, parts(r, logs)):
        products = autocovariance(part - part.mean(), most)
        total[: len(products)] += products
    negative = np.flatnonzero(total[1:] <= 0)
    return int(negative[0]) + 1 if len(negative) else most


def correlation_time(r: Array, logs: Sequence[int] | None = None) -> float:
    """Integrated autocorrelation 1 + 2 sum rho_k, summed while rho_k stays above zero; >= 1."""
    lags = max(len(r) // 2, 1)
    total = np.zeros(lags)
    for part in parts(r, logs or (len(r),)):
        products = autocovariance(part - part.mean(), lags)
        total[: len(products)] += products
    if not total[0] > 0:
        return 1.0
    rho = total / total[0]
    negative = np.flatnonzero(rho <= 0)
    stop = int(negative[0]) if len(negative) else len(rho)
    return float(max(1.0 + 2.0 * rho[1:stop].sum(), 1.0))
