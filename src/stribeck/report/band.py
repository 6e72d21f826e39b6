"""Where the curve of an identified law may lie: 95 % at each speed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..identify.found import Fit
    from ..space import Array

#: Parameter sets drawn, and the fewest that make a band.
DRAWS, FEWEST = 300, 60
#: Half-widths of 95 % in standard deviations, and the shares of the draws that the band leaves out.
_SIGMAS, _TAILS = 1.96, (2.5, 97.5)

Source = Literal["intervals", "bootstrap"]


def band(fit: Fit, sides: Sequence[Array]) -> tuple[Source, list[tuple[Array, Array]]] | None:
    """The least and greatest friction at each speed, 95 % in between, and where they come from.

    Parameter sets are those of the bootstrap if there was one. Else they are drawn about the fit
    with its correlations, each parameter as wide to either side as its interval.

    Args:
        fit: What was found.
        sides: Speeds, m/s (rad/s), (N,) each.

    Returns:
        The source, and (low, high) in N (N m) for each of `sides`; None where too few sets can be
        drawn that are friction at all.
    """
    source, sets = drawn(fit)
    own = np.ascontiguousarray(sets[:, : len(fit.law.params)])
    own = own[np.asarray(fit.law.physical(own), dtype=bool)]
    if len(own) < FEWEST:
        return None
    best = np.ascontiguousarray(fit.p[: len(fit.law.params)])
    found = []
    for v in sides:
        F = np.array([fit.law.friction(v, p) for p in own])
        low, high = np.percentile(F, _TAILS, axis=0)
        middle = fit.law.friction(v, best)
        if not np.isfinite(low + high + middle).all():
            return None
        found.append((np.minimum(low, middle), np.maximum(high, middle)))
    return source, found


def drawn(fit: Fit) -> tuple[Source, Array]:
    """Complete parameter sets that the data allow, SI, (n, k), and how they were made."""
    made, n = fit.parameters, len(fit.parameters.free)
    resampled = fit.known.bootstrap if fit.known is not None else None
    if resampled is not None and len(resampled.draws) >= FEWEST:
        return "bootstrap", made.full(resampled.draws[:, :n])
    ends = {q.name: e for q, e in zip(made.every, fit.estimates, strict=True)}
    value = np.array([ends[q.name].value for q in made.free])
    down = value - np.array([ends[q.name].low for q in made.free])
    up = np.array([ends[q.name].high for q in made.free]) - value
    z = np.random.default_rng(0).standard_normal((DRAWS, n)) @ _root(fit.correlation).T
    x = value + z * np.where(z > 0, up, down) / _SIGMAS
    lower, upper = (np.array([getattr(q, end) for q in made.free]) for end in ("lower", "upper"))
    return "intervals", made.full(np.clip(x, lower, upper))


def _root(correlation: Array) -> Array:
    """A square root of a correlation matrix, whatever rounding has made of it."""
    good = np.where(np.isfinite(correlation), correlation, 0.0)
    np.fill_diagonal(good, 1.0)
    sizes, ways = np.linalg.eigh(0.5 * (good + good.T))
    root: Array = ways * np.sqrt(np.maximum(sizes, 0.0))
    return root
