"""Finite differences in the unit cube, one batch."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..space import Array
from .moves import Answer, Detailed, Moves


def differences(
    u: Array, f: Array, h: Array, *, detailed: bool, complete: bool = False
) -> Moves[tuple[Array, Array]]:
    """What changes where one coordinate after the other moves by its step.

    Steps go up, down where that would leave the cube; and to the other side where a neighbour
    cannot be run.

    Args:
        u: Where, (dim,).
        f: What is known there, (m,): the residuals, or the cost alone.
        h: Lengths of the steps, (dim,); 0 where none is to be taken.
        detailed: Whether f are residuals rather than a cost.
        complete: Whether differences with a gap are of no use: then no second batch is asked for
            if it cannot fill all gaps.

    Returns:
        The differences, (dim, m), nan where neither neighbour can be run, and the steps that they
        belong to, (dim,).
    """
    todo, h = np.flatnonzero(h), np.where((u + h >= 0.0) & (u + h <= 1.0), h, -h)
    changes, steps = np.full((len(u), len(f)), np.nan), h.copy()
    for side in (h, -h):
        neighbours = u + np.diag(side)[todo]
        inside = ((neighbours >= 0.0) & (neighbours <= 1.0)).all(axis=1)
        if complete and not inside.all():
            break
        todo, neighbours = todo[inside], neighbours[inside]
        if not len(todo):
            break
        answer = yield Detailed(neighbours) if detailed else neighbours
        costs: Array = answer.costs if isinstance(answer, Answer) else answer
        values: Any = answer.residuals if isinstance(answer, Answer) else costs[:, None]
        runs = np.isfinite(costs)
        steps[todo] = side[todo]
        for k, row in zip(todo[runs], np.flatnonzero(runs), strict=True):
            np.subtract(values[row], f, out=changes[k])
        todo = todo[~runs]
    return changes, steps
