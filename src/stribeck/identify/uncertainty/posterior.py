"""The posterior of the parameters, sampled: an option beside profile and bootstrap.

The likelihood is Gaussian. Residuals that correlate carry less than their number says: the
variance is inflated by their correlation time. The prior is uniform over the search box, in the
search scale of each parameter. The sampler is emcee's (Foreman-Mackey et al. 2013, doi
10.1086/670067), an extra.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...errors import InputError
from ...optimize.lockstep import Counted, squares_of
from ...optimize.trust_region import Iterate
from ...space import Array
from .covariance import QuickLook, correlation_time, quick_look
from .linearisation import box_of, linearised
from .residuals import Residuals, logs_of

LEVEL = 0.95
#: Samples unless a caller says otherwise.
SAMPLES = 20_000
#: Share of the walkers' steps that is dropped while they settle, and the fewest steps.
SETTLING, FEWEST = 0.3, 10
#: Steps a walker must make for each step of its correlation time, for intervals to be trusted.
ENOUGH = 25
#: Walkers for each parameter, and in all, at least.
EACH, ALL = 4, 16
#: Standard deviation of the walkers' first cloud in a coordinate of the unit cube, at most.
WIDE = 0.1


@dataclass(frozen=True, eq=False)
class Posterior:
    """Samples of the posterior.

    Args:
        names: The free parameters.
        samples: SI, (n, dim).
        median: Of each parameter, SI, (dim,).
        low: Lower ends of the central 95 % intervals, SI, (dim,).
        high: Upper ends.
        accepted: Share of the steps that were taken.
        settled: Whether the walkers made enough steps for their correlation time.
        rows: Rows evaluated.
    """

    names: tuple[str, ...]
    samples: Array = field(repr=False)
    median: Array
    low: Array
    high: Array
    accepted: float
    settled: bool
    rows: int


def sampler() -> Any:
    """The package that samples.

    Raises:
        InputError: it is not installed.
    """
    try:
        import emcee  # noqa: PLC0415 - an extra
    except ImportError:
        raise InputError(
            "the posterior needs emcee: install it with pip install 'stribeck[posterior]'"
        ) from None
    return emcee


def posterior(
    problem: Residuals,
    x: Array,
    *,
    samples: int = SAMPLES,
    walkers: int | None = None,
    seed: int = 0,
    level: float = LEVEL,
) -> Posterior:
    """Sample the posterior about a fit.

    Args:
        problem: Its residuals; see `Residuals`.
        x: The fit, SI, (dim,).
        samples: How many, of all walkers; three tenths of the steps come before them.
        walkers: How many move together; at least twice as many as parameters.
        seed: Of the sampler.
        level: Of the intervals.

    Raises:
        InputError: emcee is not installed, the fit cannot be run, or there are too few walkers.
    """
    emcee, box = sampler(), box_of(problem)
    walkers = max(EACH * box.dim, ALL) if walkers is None else walkers
    if walkers < 2 * box.dim or samples < 1:
        raise InputError(
            f"posterior: {walkers} walkers and {samples} samples: give at least {2 * box.dim} and 1"
        )
    steps = max(int(np.ceil(samples / walkers / (1 - SETTLING))), FEWEST)
    drop = int(SETTLING * steps)
    counted = Counted(problem, walkers * (steps + 2) + 4 * box.dim)
    best = linearised(counted, box, x)
    logs = logs_of(problem, len(best.r))
    quick = quick_look(best.J, best.r, logs)
    time, data = correlation_time(best.r, logs), sum(logs)
    variance = quick.variance * time

    def log_probability(u: Array) -> Array:
        density = np.full(len(u), -np.inf)
        inside = ((u >= 0.0) & (u <= 1.0)).all(axis=1)
        if inside.any():
            r = counted.residuals(box.space.decode(u[inside]))
            # priors do not correlate
            squares = squares_of(r[:, :data]) + time * squares_of(r[:, data:])
            counted.forget()
            density[inside] = np.where(np.isfinite(squares), -0.5 * squares / variance, -np.inf)
        return density

    rng = np.random.default_rng(seed)
    chains = emcee.EnsembleSampler(walkers, box.dim, log_probability, vectorize=True)
    begin = _begin(best, quick, walkers, rng, log_probability)
    chains.random_state = np.random.RandomState(rng.integers(2**31)).get_state()
    chains.run_mcmc(begin, steps)
    u = np.ascontiguousarray(chains.get_chain(discard=drop, flat=True)[-samples:])
    drawn = box.space.decode(u)
    tail = 50 * (1 - level)
    low, median, high = np.percentile(drawn, [tail, 50, 100 - tail], axis=0)
    times = chains.get_autocorr_time(discard=drop, tol=0)
    return Posterior(
        box.space.names,
        drawn,
        median,
        low,
        high,
        float(np.mean(chains.acceptance_fraction)),
        bool(np.all(ENOUGH * times < steps - drop)),
        counted.rows,
    )


def _begin(
    best: Iterate,
    quick: QuickLook,
    walkers: int,
    rng: np.random.Generator,
    log_probability: Callable[[Array], Array],
) -> Array:
    """Where walkers begin, (walkers, dim): about the best fit, where the model can be run.

    They spread as the linear model has it, along valleys and not across them: a walker that
    begins far up a slope may stay in a basin that the posterior hardly knows.
    """
    u, dim = best.u, len(best.u)
    values, vectors = np.linalg.eigh(quick.variance * quick.curvature)
    cloud = rng.standard_normal((walkers, dim)) @ (vectors * np.sqrt(np.maximum(values, 0.0))).T
    widest = np.sqrt(np.diag(quick.variance * quick.curvature)).max(initial=0.0)
    cloud *= min(1.0, WIDE / widest) if widest > 0 else 1.0
    # in every direction, a blind one too
    aside = np.where(quick.blind, WIDE, 1e-3 * np.minimum(np.maximum(quick.white, 1e-6), WIDE))
    begin: Array = np.clip(
        u + 0.5 * cloud + 0.5 * aside * rng.standard_normal(cloud.shape), 0.0, 1.0
    )
    # none may sit on another: those on an end of the range are spread along it
    begin = np.abs(begin - 1e-6 * rng.random(begin.shape))
    for _ in range(20):
        impossible = ~np.isfinite(log_probability(begin))
        if not impossible.any():
            break
        redrawn = (
            u
            + 0.2 * (begin[impossible] - u)
            + 1e-7 * rng.standard_normal(begin[impossible].shape) * aside
        )
        begin[impossible] = np.clip(redrawn, 0.0, 1.0)
    return begin
