"""How well the data know each parameter: a quick look from the Jacobian and the repeats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..space import Array
from .polish import jacobian

if TYPE_CHECKING:
    from ..optimize.search import LeastSquares
    from .problem import Parameters

Verdict = Literal["identified", "weak", "not identifiable", "fixed"]

#: Half-width of an interval as a share of the value, up to which a parameter is identified, weak.
IDENTIFIED, WEAK = 0.1, 0.5
#: Correlation above which the data know a combination of two parameters rather than each.
TOGETHER = 0.95
#: Share of the search range within which a parameter counts as sitting at its end.
AT_END = 1e-3


@dataclass(frozen=True)
class Estimate:
    """One parameter as it was found, SI.

    Args:
        name: As its rig calls it.
        value: The estimate.
        standard_error: From the Jacobian at the estimate, for residuals as correlated as they
            are; nan for a fixed parameter.
        spread: Standard deviation over the repeats that fit as well; nan with fewer than two.
        low: Lower end of an interval of two standard errors or spreads, whichever is wider,
            cut at the search range.
        high: Upper end.
        at_bound: Which end of its search range it sits at, if any.
        verdict: `identified` if the interval is within 10 % of the value, the parameter neither
            sits at a bound nor moves with another (correlation above 0.95), and a second
            repeat fits as well; `weak` if it is within 50 %; nothing better than `not
            identifiable` where the model as a whole explains little.
        unit: In which people see it.
    """

    name: str
    value: float
    standard_error: float
    spread: float
    low: float
    high: float
    at_bound: Literal["lower", "upper"] | None
    verdict: Verdict
    unit: str


def estimates(
    made: Parameters,
    p: Array,
    errors: Array,
    spread: Array,
    correlation: Array,
    ends: Mapping[str, str] | None = None,
    robust: Array | None = None,
    doubtful: bool = False,
) -> tuple[Estimate, ...]:
    """Every parameter with its interval, its bound and a verdict, in the order of `made.every`.

    Args:
        made: Which parameters were free.
        p: The complete parameter set, SI, (k,).
        errors: Standard errors of the free parameters, SI, (dim,).
        spread: Their standard deviations over repeats, SI, nan where there are none, (dim,).
        correlation: Of the free parameters, (dim, dim).
        ends: Which end of its range a parameter sits at, by name, if that is known; else what
            lies within a thousandth of a range of its end counts as sitting there.
        robust: Standard errors for the intervals, where the usual ones are told beside them
            but known to be too small.
        doubtful: Whether the fit as a whole holds so badly that it identifies nothing.
    """
    within = errors if robust is None else robust
    free = {q.name: i for i, q in enumerate(made.free)}
    others = np.abs(correlation - np.eye(len(correlation))).max(axis=1, initial=0.0)
    found = []
    for param, value in zip(made.every, p.tolist(), strict=True):
        label, written = made.rig.label(param.name), made.rig.unit_of(param)
        i = free.get(made.tied.get(param.name, param.name))
        if i is None:
            nan = float("nan")
            found.append(Estimate(label, value, nan, nan, value, value, None, "fixed", written))
            continue
        error, wide = float(errors[i]), float(spread[i])
        half = max(1.96 * float(within[i]), 2.0 * np.nan_to_num(wide))
        at = _end(value, param.lower, param.upper) if ends is None else _named(ends, param.name)
        verdict: Verdict = "not identifiable"
        if half <= WEAK * abs(value) and not doubtful:
            sure = half <= IDENTIFIED * abs(value) and at is None and others[i] <= TOGETHER
            confirmed = robust is not None or np.isfinite(wide)  # a search has to find it twice
            verdict = "identified" if sure and confirmed else "weak"
        low, high = max(value - half, param.lower), min(value + half, param.upper)
        found.append(Estimate(label, value, error, wide, low, high, at, verdict, written))
    return tuple(found)


def _named(ends: Mapping[str, str], name: str) -> Literal["lower", "upper"] | None:
    at = ends.get(name)
    return None if at is None else ("lower" if at == "lower" else "upper")


def _end(value: float, lower: float, upper: float) -> Literal["lower", "upper"] | None:
    width = upper - lower
    if value - lower < AT_END * width:
        return "lower"
    return "upper" if upper - value < AT_END * width else None


def standard_errors(problem: LeastSquares, x: Array) -> tuple[Array, Array]:
    """Standard errors (SI) and correlations of the free parameters at an estimate.

    The usual covariance of nonlinear least squares, s^2 (J^T J)^-1, widened by the integrated
    autocorrelation of the residuals: a sensor that is read more often than it measures does not
    know more. It is a quick look: linear, and blind to what the rig's model leaves out.
    """
    space = problem.space
    u = space.encode(x[None])[0]
    r = problem.residuals(x[None])[0]
    J = jacobian(problem, u, r)
    dof = max(len(r) - space.dim, 1)
    variance = float(r @ r) / dof * correlation_time(r)
    nudge = np.where(u + 1e-6 <= 1.0, 1e-6, -1e-6)
    width = np.diag(space.decode(u + np.diag(nudge)) - x) / nudge  # dx / du
    norms = np.linalg.norm(J, axis=0)
    errors, correlation = np.full(space.dim, np.inf), np.eye(space.dim)
    seen = np.flatnonzero(norms > 1e-9 * norms.max())  # the data say nothing of the others
    if not np.isfinite(J).all() or norms.max() == 0:
        return errors, correlation
    scaled = J[:, seen] / norms[seen]
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    if values[0] <= 1e-14 * values[-1]:
        return errors, correlation
    inverse = (vectors / values) @ vectors.T
    spread = np.sqrt(np.diag(inverse))
    errors[seen] = np.sqrt(variance) * spread / norms[seen] * np.abs(width[seen])
    correlation[np.ix_(seen, seen)] = inverse / np.outer(spread, spread)
    return errors, correlation


def correlation_time(r: Array) -> float:
    """Integrated autocorrelation 1 + 2 sum rho_k, summed while rho_k stays above zero; >= 1."""
    d = r - r.mean()
    n = len(d)
    spectrum = np.abs(np.fft.rfft(d, 2 * n)) ** 2
    rho = np.fft.irfft(spectrum)[: n // 2]
    if not rho[0] > 0:
        return 1.0
    rho = rho / rho[0]
    below = np.flatnonzero(rho <= 0)
    stop = int(below[0]) if len(below) else len(rho)
    return float(max(1.0 + 2.0 * rho[1:stop].sum(), 1.0))


def bound_warnings(estimates: Sequence[Estimate]) -> list[str]:
    """A sentence for every parameter that ended at an end of its search range."""
    return [
        f"{e.name} ended at the {e.at_bound} end of its range: widen the range or doubt the value"
        for e in estimates
        if e.at_bound
    ]


def correlation_warnings(made: Parameters, correlation: Array) -> list[str]:
    """A sentence for the parameters that the data cannot tell apart."""
    names = [made.rig.label(q.name) for q in made.free]
    pairs = [
        f"{names[i]} and {names[j]} ({correlation[i, j]:+.3f})"
        for i in range(len(names))
        for j in range(i)
        if abs(correlation[i, j]) > TOGETHER
    ]
    if not pairs:
        return []
    return [f"the data hardly tell apart {', '.join(pairs)}: trust their combination, not each"]
