"""Equal-count bins of a variable, and a test of what they explain that autocorrelation leaves true.

Rows of a residual resemble their neighbours, so an F test of bins finds patterns in mere noise.
Here the residual is cut into blocks that hardly know of each other, and whole blocks change their
signs at random: what is then explained is chance, with the autocorrelation and the motion as they
are (the wild bootstrap of clusters: Cameron, Gelbach and Miller 2008, doi 10.1162/rest.90.3.414).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc, stdtr

from ...space import Array
from ..uncertainty.covariance import HALF_WIDTH

#: Bins of a variable; so many see a bow, a drop and a wave, and each still has rows enough.
BINS = 12
#: Random changes of sign, and their seed: the same fit has the same page.
FLIPS, SEED = 499, 14
#: Degrees of freedom that a model and a pattern take of the blocks, as a rule.
SPENT = 5


@dataclass(frozen=True, eq=False)
class Binned:
    """A residual in bins of a variable.

    Args:
        at: Median of the variable in each bin, SI, (bins,).
        mean: Mean residual in each bin, SI, (bins,).
        chance: Half the width of the band that holds 95 % of means without a pattern, (bins,).
        share: Of the residual's sum of squares that the means explain, less what chance explains.
        probability: That chance explains as much, by a gamma distribution of its trials' moments.
    """

    at: Array
    mean: Array
    chance: Array
    share: float
    probability: float


def bin_of(values: Array) -> NDArray[np.intp]:
    """The equal-count bin of each value, (rows,); equal values share one."""
    edges = np.quantile(values, np.linspace(0.0, 1.0, BINS + 1)[1:-1])
    which = np.searchsorted(np.unique(edges), values, side="right")
    taken = np.bincount(which) > 0
    return (np.cumsum(taken) - 1)[which]


def between(values: Array, which: NDArray[np.intp]) -> Array:
    """The mean of the values in the bin of each, (rows,)."""
    count = np.maximum(np.bincount(which), 1)
    means: Array = np.bincount(which, values) / count
    return means[which]


def signs(blocks: NDArray[np.intp]) -> Array:
    """Random signs for each block, (FLIPS, blocks)."""
    rng = np.random.default_rng(SEED)
    return rng.choice(np.array([-1.0, 1.0]), size=(FLIPS, int(blocks.max()) + 1))


def binned(values: Array, residual: Array, blocks: NDArray[np.intp], flips: Array) -> Binned:
    """A residual in bins of a variable, and what chance makes of such bins.

    Args:
        values: The variable, (rows,).
        residual: (rows,).
        blocks: The block of each row, (rows,).
        flips: Signs for the blocks, as `signs` has them.
    """
    which = bin_of(values)
    m = int(which.max()) + 1
    count = np.bincount(which, minlength=m)
    cells = np.bincount(blocks * m + which, residual, minlength=flips.shape[1] * m)
    sums = cells.reshape(-1, m)
    total = float(residual @ residual)
    actual = sums.sum(axis=0)
    by_chance = np.einsum("fb,bm->fm", flips, sums)
    explained = float(np.sum(actual**2 / count)) / total
    chance = np.sum(by_chance**2 / count, axis=1) / total
    at = np.array([np.median(values[which == k]) for k in range(m)])
    return Binned(
        at,
        actual / count,
        HALF_WIDTH * np.sqrt(np.mean(by_chance**2, axis=0)) / count,
        max(explained - float(chance.mean()), 0.0),
        probability(explained, chance),
    )


def probability(explained: float, chance: Array) -> float:
    """That chance explains as much: the tail of the gamma distribution of its trials, (FLIPS,)."""
    mean, variance = float(chance.mean()), float(chance.var())
    if not (mean > 0 and variance > 0):
        return 1.0
    return float(gammaincc(mean**2 / variance, explained * mean / variance))


def t_probability(
    columns: Array, residual: Array, blocks: NDArray[np.intp], *, uneven: bool = False
) -> Array:
    """That a residual goes along each of some columns by chance, two-sided, (k,).

    Student's t with a variance by blocks (Liang and Zeger 1986, doi 10.1093/biomet/73.1.13).

    Args:
        columns: (rows, k).
        residual: (rows,).
        blocks: The block of each row, (rows,), rising.
        uneven: Whether columns live in few blocks, as accelerations do, which then have no more
            freedom than their effective number (Carter, Schnepel and Steigerwald 2017, doi
            10.1162/REST_a_00639).
    """
    starts = np.flatnonzero(np.diff(blocks, prepend=-1))
    lengths = np.einsum("ij,ij->j", columns, columns)
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = np.einsum("ij,i->j", columns, residual) / lengths
        scores = -weights * columns  # in place from here on: of a long log they are large
        scores += residual[:, None]
        scores *= columns
        sums = np.add.reduceat(scores, starts, axis=0)
        del scores
    energy = np.add.reduceat(columns**2, starts, axis=0) if uneven else None
    return clustered_probability(weights * lengths, sums, energy)


def clustered_probability(inner: Array, sums: Array, energy: Array | None = None) -> Array:
    """That products with a residual are as large by chance; see `t_probability`.

    Args:
        inner: Of columns with the residual, (k,).
        sums: By block, of what each row of them has once the columns are estimated, (blocks, k).
        energy: By block, of the squares of uneven columns, (blocks, k); None if they are even.
    """
    n = len(sums)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = inner / np.sqrt(np.sum(sums**2, axis=0) * n / (n - SPENT))
        freedom = np.full(len(inner), n - SPENT, dtype=float)
        if energy is not None:
            freedom *= np.sum(energy, axis=0) ** 2 / np.sum(energy**2, axis=0) / n
    freedom = np.where(freedom >= 1.0, freedom, 1.0)
    return np.where(np.isfinite(t), 2 * stdtr(freedom, -np.abs(t)), 1.0)
