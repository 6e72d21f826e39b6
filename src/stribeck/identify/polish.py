"""The last step of a fit: bounded least squares on the residuals, from where a search ended."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from ..space import Array

if TYPE_CHECKING:
    from ..optimize import Run, Trace
    from .problem import MotionProblem

#: Step of the finite differences, as a share of a parameter's range: its effect on the motion
#: is far above the integration error and far below the noise.
STEP = 1e-4


@dataclass(frozen=True, eq=False)
class Polished:
    """Where least squares ended.

    Args:
        x: Free parameters, SI.
        cost: J there.
        evaluations: Of the residuals, each row counted.
    """

    x: Array
    cost: float
    evaluations: int


def elite(trace: Trace, most: int = 6, apart: float = 0.15) -> Array:
    """The best points of a search that lie apart from each other in the unit cube, best first.

    A stick-slip misfit has many basins; the best point of a search may sit in a poor one.
    """
    order = np.argsort(trace.f, kind="stable")[:4000]
    chosen = [order[0]]
    for k in order[1:]:
        if len(chosen) == most or not np.isfinite(trace.f[k]):
            break
        if np.linalg.norm(trace.u[chosen] - trace.u[k], axis=1).min() > apart:
            chosen.append(k)
    return trace.u[chosen].copy()


def polish_run(problem: MotionProblem, run: Run, allowance: int) -> Polished:
    """Polish the elite of a search, the allowance dealt out evenly, and return the best."""
    starts = problem.space.decode(elite(run.trace)) if allowance else run.x[None]
    done = [polish(problem, x, allowance // len(starts)) for x in starts]
    best = min(done, key=lambda d: d.cost)
    return Polished(best.x, best.cost, sum(d.evaluations for d in done))


def polish(problem: MotionProblem, x: Array, allowance: int) -> Polished:
    """Improve a point by trust-region least squares inside the search box.

    Args:
        problem: Its residuals are minimised.
        x: Where to start, free parameters, SI.
        allowance: Rows of the cost that may be evaluated; with none the point stays.
    """
    start = float(problem(x[None])[0])
    space, dim = problem.space, problem.space.dim
    rounds = (allowance - 1) // (dim + 1)
    if rounds < 1 or not np.isfinite(start):
        return Polished(x, start, 0)
    spent = 0

    def residuals(u: Array) -> Array:
        nonlocal spent
        spent += 1
        found: Array = problem.residuals(space.decode(u[None]))[0]
        return found

    def slopes(u: Array) -> Array:
        nonlocal spent
        spent += dim
        return jacobian(problem, u)

    u = np.clip(space.encode(x[None])[0], 1e-6, 1 - 1e-6)
    try:
        found = least_squares(
            residuals,
            u,
            slopes,
            bounds=(0.0, 1.0),
            method="trf",
            max_nfev=rounds,
            xtol=1e-7,
            ftol=1e-9,
        )
    except ValueError:  # a neighbour that cannot be simulated: the search's answer stands
        return Polished(x, start, spent)
    better = space.decode(np.clip(found.x, 0.0, 1.0)[None])
    cost = float(problem(better)[0])
    spent += 1
    if not cost < start:
        return Polished(x, start, spent)
    return Polished(better[0], cost, spent)


def jacobian(problem: MotionProblem, u: Array) -> Array:
    """d residual / d u at a point of the unit cube, (samples, dim), all differences at once."""
    step = np.where(u + STEP <= 1.0, STEP, -STEP)
    points = np.vstack([u, u + np.diag(step)])
    r = problem.residuals(problem.space.decode(points))
    slopes: Array = ((r[1:] - r[0]) / step[:, None]).T
    return slopes


def standard_errors(problem: MotionProblem, x: Array) -> tuple[Array, Array]:
    """Standard errors (SI) and correlations of the free parameters at an estimate.

    The usual covariance of nonlinear least squares, s^2 (J^T J)^-1, widened by the integrated
    autocorrelation of the residuals: a sensor that is read more often than it measures does not
    know more. It is a quick look: linear, and blind to what the rig's model leaves out.
    """
    space = problem.space
    u = space.encode(x[None])[0]
    r = problem.residuals(x[None])[0]
    J = jacobian(problem, u)
    dof = max(len(r) - space.dim, 1)
    variance = float(r @ r) / dof * correlation_time(r)
    nudge = np.where(u + 1e-6 <= 1.0, 1e-6, -1e-6)
    width = np.diag(space.decode(u + np.diag(nudge)) - x) / nudge  # dx / du
    norms = np.linalg.norm(J, axis=0)
    if not (np.isfinite(J).all() and (norms > 0).all()):
        return np.full(space.dim, np.inf), np.eye(space.dim)
    scaled = J / norms
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    if values[0] <= 1e-14 * values[-1]:
        return np.full(space.dim, np.inf), np.eye(space.dim)
    inverse = (vectors / values) @ vectors.T
    spread = np.sqrt(np.diag(inverse))
    errors = np.sqrt(variance) * spread / norms * np.abs(width)
    return errors, inverse / np.outer(spread, spread)


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
