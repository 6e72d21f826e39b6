"""Rows right behind reversals, where play leaves its mark.

A sensor behind a play stands still while the drive has turned round and gathers speed, and then
jumps to that speed: an acceleration without its force. No pattern over speed or position has that
shape, but it lies in a few rows, with one sign.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...space import Array
from .bins import probability
from .residual_rows import ResidualRows

#: Rows behind a reversal over which a jump of the speed is smeared by filters.
ROWS_BEHIND = 5
#: They have a mark if they hold more than this share of the residual's sum of squares, by means of
#: one sign; a friction that drops while the axis gathers speed, or a coarse sensor, has less there.
CONCENTRATED = 0.05
#: Fewest reversals.
FEWEST_REVERSALS = 6


def behind_reversals(rows: ResidualRows) -> NDArray[np.intp]:
    """How many rows each lies behind a reversal, from 0; `ROWS_BEHIND` for all others, (rows,).

    What a log begins with counts as one: which way its play was taken up is not known.

    Args:
        rows: Those that slide.
    """
    turns = np.flatnonzero(
        (np.diff(rows.direction, prepend=0) != 0) | (np.diff(rows.log, prepend=-1) != 0)
    )
    count = np.full(len(rows), ROWS_BEHIND)
    for k in reversed(range(ROWS_BEHIND)):
        at = turns + k
        at = at[at < len(rows)]
        count[at] = k
    return count


def mark_of_reversals(
    rows: ResidualRows, blocks: NDArray[np.intp], flips: Array
) -> tuple[float, float]:
    """The share of a residual in rows behind reversals, and the probability that it is chance.

    Args:
        rows: Those that slide, with what the parameters leave of the residual.
        blocks: The block of each row, (rows,).
        flips: Signs for the blocks, (FLIPS, blocks).
    """
    behind = behind_reversals(rows)
    if np.count_nonzero(behind == 0) < FEWEST_REVERSALS:
        return 0.0, 1.0
    m = ROWS_BEHIND + 1
    residual = rows.residual * rows.direction
    cells = np.bincount(blocks * m + behind, residual, minlength=flips.shape[1] * m)
    sums = cells.reshape(-1, m)[:, :ROWS_BEHIND]
    count = np.maximum(np.bincount(behind, minlength=m)[:ROWS_BEHIND], 1)
    total = float(residual @ residual)
    by_chance = np.einsum("fb,bm->fm", flips, sums)
    explained = float(np.sum(sums.sum(axis=0) ** 2 / count)) / total
    return explained, probability(explained, np.sum(by_chance**2 / count, axis=1) / total)
