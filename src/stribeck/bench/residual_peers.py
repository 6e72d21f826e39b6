"""Third-party solvers of least squares: they are shown residuals, as `mbts` is.

Each run starts at the best of `screened` random points, all of them counted. A residual that is
not finite is UNKNOWN to them. What ends by itself begins anew elsewhere, see `third_party`.
"""

from __future__ import annotations

import numpy as np

from ..errors import InputError
from ..space import Array, Rng
from .counter import Counter
from .library import library


def dfo_ls(
    count: Counter,
    rng: Rng,
    *,
    screened: int = 1,
    rhobeg: float = 0.1,
    rhoend: float = 1e-4,
    npt: int | None = None,
) -> None:
    """DFO-LS, trust regions on linear models of each residual, without derivatives.

    Cartis, Fiala, Marteau and Roberts, ACM TOMS 45 (2019) 32, doi 10.1145/3338517. GPL-3.0.
    `rhoend` is 1e-8 by its own choice: beside a minimum of a simulation whose slopes are rough it
    then goes round for ever without an evaluation (1.6.5).
    """
    solver = library("dfols")
    if not 0.0 < rhoend < rhobeg <= 0.5:  # noqa: PLR2004 - its own rule for the unit cube
        raise InputError(f"dfo-ls takes 0 < rhoend < rhobeg <= 0.5, got {rhoend!r}, {rhobeg!r}")
    start = _start(count, rng, screened)
    solver.solve(
        count.residuals,
        start,
        bounds=(np.zeros(count.dim), np.ones(count.dim)),
        npt=npt,
        rhobeg=rhobeg,
        rhoend=rhoend,
        maxfun=count.budget_left + 1,
        do_logging=False,
    )


def least_squares(
    count: Counter,
    rng: Rng,
    *,
    screened: int = 20,
    diff_step: float | None = None,
    ftol: float = 1e-8,
    xtol: float = 1e-8,
    gtol: float = 1e-8,
) -> None:
    """`scipy.optimize.least_squares`, its slopes by forward differences.

    `diff_step` is a length of the unit cube; scipy's default is the root of the rounding error,
    which is shorter than the roughness of most simulations.
    """
    optimize = library("scipy.optimize")
    start = _start(count, rng, screened)
    optimize.least_squares(
        count.residuals,
        start,
        bounds=(0.0, 1.0),
        # scipy's steps are relative to the point.
        diff_step=None if diff_step is None else diff_step / np.maximum(start, diff_step),
        ftol=ftol,
        xtol=xtol,
        gtol=gtol,
        max_nfev=count.budget_left + 1,
    )


def _start(count: Counter, rng: Rng, screened: int) -> Array:
    """The best of some random points."""
    if screened < 1:
        raise InputError(f"screened counts random points, at least 1, got {screened!r}")
    points: Array = rng.random((screened, count.dim))
    first = int(np.argmin(count.batch(points))) if screened > 1 else 0
    best: Array = points[first]
    return best
