"""What a residual has again wherever the motion has: what a model leaves out without a name.

Noise does not know the motion, however long it remembers. So a residual that is predicted from
residuals at like positions, velocities and accelerations in other parts of the logs has something
of the axis in it: a load that is carried one way, a bump of friction, hysteresis of the force
sensor. Prediction is by the mean of the nearest neighbours (Stone 1977, doi
10.1214/aos/1176343886), none of them from the same part or one beside it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from .residual_rows import ResidualRows

#: Neighbours that predict a row, and those among which they are looked for.
NEIGHBOURS, AMONG = 16, 128
#: Parts of the logs, and about how many rows are looked at.
PARTS, SEEN = 12, 6000
#: Rows that are predicted at once.
AT_ONCE = 500
#: Directions are as far apart as so many standard deviations of a speed.
APART = 4.0
#: A residual recurs from this share of its variance on that is predicted. Noise alone has one below
#: 0, about -1 / NEIGHBOURS where it is white: it is predicted worse than by nothing.
RECURS = 0.01
#: Rows that have neighbours, as a share, of fewer nothing is said.
ENOUGH = 0.5


@dataclass(frozen=True)
class Recurrence:
    """What a residual has again wherever the motion has.

    Args:
        share: Of its variance that other parts of the logs predict.
        shifts: By how much each parameter would have to move to make as much force, root mean
            square, beside what the others make up for, SI, by name.
    """

    share: float
    shifts: dict[str, float]


def recurrence(rows: ResidualRows, block: NDArray[np.intp]) -> Recurrence | None:
    """What recurs in a residual; None where nothing does.

    Args:
        rows: Its rows, less what parameters and patterns explain.
        block: The block of each; blocks hardly know of each other.
    """
    residual, parts = rows.residual, block * PARTS // (int(block.max()) + 1)
    predicted = _predicted(_states(rows), residual, parts)
    has = np.isfinite(predicted)
    total = float(np.sum(residual[has] ** 2))
    if has.mean() < ENOUGH or not total > 0:
        return None
    share = 1.0 - float(np.sum((residual - predicted)[has] ** 2)) / total
    if not share > RECURS:
        return None
    size = float(np.sqrt(share * np.mean(residual[has] ** 2)))
    J = rows.jacobian
    C = np.linalg.pinv(np.einsum("im,in->mn", J, J) / len(J), hermitian=True)
    moves = size * np.sqrt(np.maximum(np.diag(C), 0.0))
    return Recurrence(share, dict(zip(rows.names, moves.tolist(), strict=True)))


def _states(rows: ResidualRows) -> Array:
    """Position, velocity and acceleration in standard deviations, and the direction, (rows, 4)."""
    states = np.column_stack([rows.position, rows.velocity, rows.acceleration])
    spread = states.std(axis=0)
    spread[spread == 0] = 1.0
    return np.column_stack([(states - states.mean(axis=0)) / spread, APART / 2 * rows.direction])


def _predicted(states: Array, residual: Array, parts: NDArray[np.intp]) -> Array:
    """The mean residual of the nearest rows of parts that are not beside, nan without, (rows,)."""
    from scipy.spatial import KDTree  # noqa: PLC0415 - slow to import

    tree, predicted = KDTree(states), np.empty(len(states))
    for k in range(0, len(states), AT_ONCE):
        some = slice(k, k + AT_ONCE)
        _, near = tree.query(states[some], k=min(AMONG, len(states)))
        allowed = np.abs(parts[near] - parts[some, None]) > 1
        allowed &= np.cumsum(allowed, axis=1) <= NEIGHBOURS
        count = allowed.sum(axis=1)
        mean = np.where(allowed, residual[near], 0.0).sum(axis=1) / np.maximum(count, 1)
        predicted[some] = np.where(count >= NEIGHBOURS // 2, mean, np.nan)
    return predicted
