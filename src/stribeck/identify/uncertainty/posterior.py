"""The posterior of the parameters, sampled: an option beside profile and bootstrap.

The likelihood is Gaussian. Residuals that correlate carry less than their number says: the
variance is inflated by their correlation time. The prior is uniform over the search box, in the
search scale of each paracounted. The sampler is emcee's (Foreman-Mackey et al. 2013, doi
10.1086/670067), an extra.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...errors import InputError
from ...optimize.lockstep import Counted, squares_of
from ...space import Array
from .covariance import correlation_time, quick_look
from .linearisation import box_of, linearised
from .residuals import Residuals, logs_of

LEVEL = 0.95
#: Steps of the walkers, and the share of them that is dropped while they settle.
STEPS, SETTLING = 1000, 0.3
#: Steps a walker must make for each step of its correlation time, for intervals to be trusted.
ENOUGH = 25


@dataclass(frozen=True, eq=False)
class Posterior:
    """Samples of the posterior.

    Args:
        names: The free parameters.
        samples: SI, (n, dim).
        low: Lower ends of the central intervals, SI, (dim,).
        high: Upper ends.
        accepted: Share of the steps that were taken.
        settled: Whether the walkers made enough steps for their correlation time.
        rows: Rows evaluated.
    """

    names: tuple[str, ...]
    samples: Array = field(repr=False)
    low: Array
    high: Array
    accepted: float
    settled: bool
    rows: int


def posterior(
    problem: Residuals,
    x: Array,
    *,
    walkers: int | None = None,
    steps: int = STEPS,
    seed: int = 0,
    level: float = LEVEL,
) -> Posterior:
    """Sample the posterior about a fit.

    Args:
        problem: Its residuals; see `Residuals`.
        x: The fit, SI, (dim,).
        walkers: How many move together; at least twice as many as parameters.
        steps: Of each walker; the first three tenths are dropped.
        seed: Of the sampler.
        level: Of the intervals.

    Raises:
        InputError: emcee is not installed, the fit cannot be run, or there are too few walkers.
    """
    try:
        import emcee  # noqa: PLC0415 - an extra
    except ImportError:
        raise InputError(
            "the posterior needs emcee: install it with pip install 'stribeck[posterior]'"
        ) from None
    box = box_of(problem)
    many = max(4 * box.dim, 16) if walkers is None else walkers
    if many < 2 * box.dim or steps < 10:  # noqa: PLR2004 - a tenth is the least to tell
        raise InputError(
            f"posterior: {many} walkers and {steps} steps: give at least {2 * box.dim} and 10"
        )
    counted = Counted(problem, many * (steps + 2) + 4 * box.dim)
    best = linearised(counted, box, x)
    logs = logs_of(problem, len(best.r))
    look = quick_look(best.J, best.r, logs)
    variance = look.variance * correlation_time(best.r, logs)

    def log_probability(u: Array) -> Array:
        found = np.full(len(u), -np.inf)
        inside = ((u >= 0.0) & (u <= 1.0)).all(axis=1)
        if inside.any():
            squares = squares_of(counted.residuals(box.space.decode(u[inside])))
            counted.forget()
            found[inside] = np.where(np.isfinite(squares), -0.5 * squares / variance, -np.inf)
        return found

    rng = np.random.default_rng(seed)
    spread = np.minimum(np.where(np.isfinite(look.errors), look.errors, 0.1), 0.1)
    begin = _begin(best.u, np.maximum(spread, 1e-9), many, rng, log_probability)
    sampler: Any = emcee.EnsembleSampler(many, box.dim, log_probability, vectorize=True)
    sampler.random_state = np.random.RandomState(rng.integers(2**31)).get_state()
    sampler.run_mcmc(begin, steps)
    drop = int(SETTLING * steps)
    u = np.ascontiguousarray(sampler.get_chain(discard=drop, flat=True))
    samples = box.space.decode(u)
    tail = 50 * (1 - level)
    low, high = np.percentile(samples, [tail, 100 - tail], axis=0)
    times = sampler.get_autocorr_time(discard=drop, tol=0)
    return Posterior(
        box.space.names,
        samples,
        low,
        high,
        float(np.mean(sampler.acceptance_fraction)),
        bool(np.all(ENOUGH * times < steps - drop)),
        counted.rows,
    )


def _begin(
    u: Array, spread: Array, many: int, rng: np.random.Generator, log_probability: Any
) -> Array:
    """Where walkers begin: about the best fit, where the model can be run."""
    begin = np.clip(u + 0.5 * spread * rng.standard_normal((many, len(u))), 0.0, 1.0)
    # none may sit on another: those on an end of the range are spread along it
    begin = np.abs(begin - 1e-6 * rng.random(begin.shape))
    for _ in range(20):
        bad = ~np.isfinite(log_probability(begin))
        if not bad.any():
            break
        again = u + 0.2 * (begin[bad] - u) + 1e-7 * spread * rng.standard_normal(begin[bad].shape)
        begin[bad] = np.clip(again, 0.0, 1.0)
    return begin
