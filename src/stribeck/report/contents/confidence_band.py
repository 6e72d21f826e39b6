"""Where the curve of an identified law may lie: 95 % at each speed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...identify.result import Fit
    from ...identify.uncertainty.assessment import Uncertainty
    from ...space import Array

#: Parameter sets drawn, and the fewest that make a band.
DRAWS, FEWEST = 300, 60
#: Half-widths of 95 % in standard deviations, and the shares of the draws that the band leaves out.
_SIGMAS, _TAILS = 1.96, (2.5, 97.5)
#: A place of a profile belongs to the interval up to this rise, in thresholds.
_INSIDE = 1.02

BandSource = Literal["intervals", "bootstrap"]


def band(fit: Fit, sides: Sequence[Array]) -> tuple[BandSource, list[tuple[Array, Array]]] | None:
    """The least and greatest friction at each speed, 95 % in between, and where they come from.

    Parameter sets are those of the bootstrap if there was one. Else they are drawn from the
    covariance at the fit, widened to what intervals are as a rule; and as no covariance sees a
    curved valley, the band holds the law at every point of the profiles inside their intervals.

    Args:
        fit: The fit.
        sides: Speeds, m/s (rad/s), (N,) each.

    Returns:
        The source, and (low, high) in N (N m) for each of `sides`; None where too few sets can be
        drawn that are friction at all.
    """
    parameters, n = fit.parameters, len(fit.parameters.free)
    source: BandSource = "intervals"
    if fit.uncertainty.bootstrap is not None and len(fit.uncertainty.bootstrap.draws) >= FEWEST:
        source, sets, profiled = (
            "bootstrap",
            fit.uncertainty.bootstrap.draws[:, :n],
            np.empty((0, n)),
        )
    else:
        sets, profiled = _drawn(fit, fit.uncertainty), _profiled(fit.uncertainty)[:, :n]
    drawn = _laws(fit, parameters.full(sets))
    certain = _laws(fit, parameters.full(profiled))
    if len(drawn) < FEWEST:
        return None
    certain = np.vstack([fit.p[None, : len(fit.law.params)], certain])
    ends = []
    for v in sides:
        low, high = np.percentile([fit.law.friction(v, p) for p in drawn], _TAILS, axis=0)
        curves = np.array([fit.law.friction(v, p) for p in certain])
        low, high = np.minimum(low, curves.min(axis=0)), np.maximum(high, curves.max(axis=0))
        if not np.isfinite(low + high).all():
            return None
        ends.append((low, high))
    return source, ends


def _laws(fit: Fit, p: Array) -> Array:
    """The laws' part of complete parameter sets, where that is friction at all."""
    sets = np.ascontiguousarray(p[:, : len(fit.law.params)])
    physical: Array = sets[np.asarray(fit.law.physical(sets), dtype=bool)] if len(sets) else sets
    return physical


def _profiled(known: Uncertainty) -> Array:
    """Free parameters, SI, (m, dim), at every place of a profile inside its interval."""
    return np.vstack([p.places[p.rises <= _INSIDE] for p in known.profiles.profiles])


def _drawn(fit: Fit, known: Uncertainty) -> Array:
    """Free parameters, SI, (DRAWS, n), from the covariance at the fit, within the search ranges."""
    free, n = fit.parameters.free, len(fit.parameters.free)
    ends = {q.name: e for q, e in zip(fit.parameters.every, fit.estimates, strict=True)}
    profiles = known.by_name()
    value = np.array([ends[q.name].value for q in free])
    half = np.array([0.5 * (ends[q.name].high - ends[q.name].low) for q in free]) / _SIGMAS
    ranges = [profiles[q.name][0].high.end - profiles[q.name][0].low.end for q in free]
    profiled = 0.5 * np.array(ranges) / _SIGMAS
    errors = known.errors[:n]
    closed = np.array([
        ends[q.name].low_ended == ends[q.name].high_ended == "threshold" for q in free
    ])  # fmt: skip
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = (profiled / errors)[closed & (errors > 0)]
        # What was widened beyond its profile, for reasons that no covariance knows, stays wide.
        wider = np.maximum(half / profiled, 1.0)
    scale = max(1.0, float(np.median(ratios))) if len(ratios) else 1.0
    spread = errors * scale * np.where(np.isfinite(wider), wider, 1.0)
    # What the data do not see at all may be anything in its interval.
    spread = np.where(np.isfinite(spread), spread, half)
    root = _root(known.correlation[:n, :n])
    z = np.random.default_rng(0).standard_normal((DRAWS, n)) @ root.T
    lower, upper = (np.array([getattr(q, end) for q in free]) for end in ("lower", "upper"))
    drawn: Array = np.clip(value + z * spread, lower, upper)
    return drawn


def _root(correlation: Array) -> Array:
    """A square root of a correlation matrix, rounded as it may be."""
    finite = np.where(np.isfinite(correlation), correlation, 0.0)
    np.fill_diagonal(finite, 1.0)
    sizes, vectors = np.linalg.eigh(0.5 * (finite + finite.T))
    root: Array = vectors * np.sqrt(np.maximum(sizes, 0.0))
    return root
