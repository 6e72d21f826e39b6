"""Slopes of residuals by central differences, each over the step at which both sides agree best.

A simulated motion has two faults that slopes must not read. Steps that adapt make it rough by some
1e-8 of its size: a difference over too short a step is of that. Where an axis sticks and slips it
is bent: a difference over too long a step is of that. What a step to one side changes is, but for
the sign, what one to the other side changes; the share by which it is not shows either fault.
"""

from __future__ import annotations

import numpy as np

from ...errors import InputError
from ...space import Array
from .residuals import Residuals

#: Steps that are tried, as shares of a coordinate's size.
STEPS = (1e-6, 1e-5, 1e-4, 1e-3)


def central_slopes(problem: Residuals, x: Array, size: Array) -> tuple[Array, Array, int]:
    """Slopes of the residuals at a point, SI, (dim, N), the residuals there, and rows evaluated.

    0 where neither side can be run.

    Args:
        problem: The problem.
        x: The point, SI, (dim,).
        size: Of its coordinates, SI, (dim,); steps are shares of it.

    Raises:
        InputError: it cannot be run there, or there are no more rows than coordinates.
    """
    r = problem.residuals(x[None])[0]
    if not np.isfinite(r).all():
        raise InputError("the fit cannot be run at its own parameters: fit again before this")
    if len(r) <= len(x):
        raise InputError(f"{len(r)} rows cannot tell {len(x)} parameters: give more data")
    slopes, least = np.zeros((len(x), len(r))), np.full(len(x), np.inf)
    for share in STEPS:
        steps = share * size
        sides = np.concatenate([x + np.diag(steps), x - np.diag(steps)])
        up, down = np.split(problem.residuals(sides), 2)
        for i in range(len(x)):
            slope, fault = _slope(r, up[i], down[i], float(steps[i]))
            if fault < least[i]:
                slopes[i], least[i] = slope, fault
    return slopes, r, 1 + 2 * len(x) * len(STEPS)


def _slope(r: Array, up: Array, down: Array, step: float) -> tuple[Array, float]:
    """A slope by residuals at both sides, and the share of it by which they disagree.

    With one side alone nothing is known of that: any slope with both is better.
    """
    sides = [(up - r) / step, (r - down) / step]
    runs = [side for side in sides if np.isfinite(side).all()]
    if not runs:
        return np.zeros_like(r), np.inf
    slope: Array = np.mean(runs, axis=0)
    size = float(np.linalg.norm(slope))
    if len(runs) == 1 or not size:
        return slope, float(np.finfo(float).max)
    return slope, float(np.linalg.norm(runs[0] - runs[1])) / size
