"""Breakaway by the pull at the onsets of slips alone, whatever the law: a regression."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..rig.simulated import as_simulated
from ..space import Array
from .own_breakaway import breakaway_columns, onset_of, pulls, uniform

if TYPE_CHECKING:
    from .parameters import Parameters
    from .segment import Segment

#: Fewer slips tell no breakaway levels.
FEWEST = 6
#: Nor do those whose pull rises by this share of itself from one sample to the next.
OPEN = 0.5


@dataclass(frozen=True)
class OnsetLevels:
    """What the regression tells.

    Args:
        values: Breakaway levels and the rig's free parameters that pull at an axis at rest: value
            and standard error by name, SI.
        mean: Mean breakaway, N or N m.
        squares: Sum of the squared deviations of single slips, N^2.
        rounding: Mean square of their errors by sampling.
        dof: Degrees of freedom.
        slips: How many slips it is over.
    """

    values: Mapping[str, tuple[float, float]]
    mean: float
    squares: float
    rounding: float
    dof: int
    slips: int


def onset_levels(parameters: Parameters, slips: Sequence[Segment]) -> OnsetLevels:
    """The regression of the pull at onsets on levels and the rig's free parameters.

    Raises:
        InputError: fewer than six slips count, the rig does not say what pulls at an axis at rest,
            or that explains all of the pull.
    """
    slips = broken_away(parameters, slips)
    directions = np.array([onset_of(s).direction for s in slips])
    ways = [way for way in (-1, 1) if (directions == way).any()]
    F, rise, slopes = _pulls(parameters, slips)
    A = np.column_stack([*(directions == way for way in ways), *(-dF for dF in slopes.values())])
    A = A.astype(float)
    ends = np.full(A.shape[1], np.inf)
    ends[len(ways) :] = 1.0
    from scipy.optimize import lsq_linear  # noqa: PLC0415 - slow to import

    solution = lsq_linear(A, F, (-ends, ends)).x
    off = F - A @ solution
    dof = len(slips) - int(np.linalg.matrix_rank(A))
    mean = abs(float(solution[: len(ways)].mean()))
    if dof < 1 or not mean > 0:
        raise InputError(
            f"breakaway of each slip: what else pulls at the axis explains all {len(slips)} onsets"
        )
    squares = float(off @ off)
    errors = np.sqrt(squares / dof * np.clip(np.diag(np.linalg.pinv(A.T @ A)), 0.0, None))
    fitted = list(zip(solution.tolist(), errors.tolist(), strict=True))
    levels = dict(zip(ways, fitted[: len(ways)], strict=True))
    shares = dict(zip(slopes, fitted[len(ways) :], strict=True))
    values = _values(parameters, shares) | _levels(parameters, levels)
    rounding = float(np.mean(np.square(uniform(rise))))
    return OnsetLevels(values, mean, squares, rounding, dof, len(slips))


def broken_away(parameters: Parameters, slips: Sequence[Segment]) -> list[Segment]:
    """Slips whose onset tells their breakaway: the pull rises, and not in one step.

    A motion that begins while the pull does not rise is none that breaks away, and under a step of
    the pull it may have broken away anywhere.

    Raises:
        InputError: there are fewer than six, or the rig does not say what pulls.
    """
    if len(slips) < FEWEST:
        raise InputError(
            f"breakaway of each slip: there are {len(slips)} slips in what is trained on, "
            f"{FEWEST} are needed"
        )
    F, rise, _ = _pulls(parameters, slips)
    rising = (rise > 0.0) & (rise < OPEN * np.abs(F))
    if rising.sum() < FEWEST:
        raise InputError(
            f"breakaway of each slip: {rising.sum()} of the {len(slips)} slips in what is trained "
            f"on begin while the pull rises without a step, {FEWEST} are needed"
        )
    return [s for s, counts in zip(slips, rising, strict=True) if counts]


def _pulls(
    parameters: Parameters, slips: Sequence[Segment]
) -> tuple[Array, Array, dict[str, Array]]:
    """The pull at onsets in the middle of the search ranges, and how far it is open, (slips,).

    And by how much the rig's free parameters change it over half of their ranges, (slips,) each,
    by name: those which do, and not alike for all slips.
    """
    own = {q.name for q in parameters.every[len(parameters.law.params) :]}
    places = [i for i, q in enumerate(parameters.free) if q.name in own]
    probes = np.tile(parameters.middle, (1 + len(places), 1))
    for row, i in enumerate(places, 1):
        probes[row, i] = parameters.free[i].upper
    rig, law = as_simulated(parameters.rig), parameters.law
    F, rise = pulls(rig, law, parameters.full(probes), slips)
    changes = zip(places, F[1:] - F[:1], strict=True)
    slopes = {parameters.free[i].name: change for i, change in changes if np.ptp(change) > 0}
    return F[0], rise[0], slopes


def _values(
    parameters: Parameters, shares: Mapping[str, tuple[float, float]]
) -> dict[str, tuple[float, float]]:
    """Free parameters, so many half ranges off the middle of their range: values and errors."""
    values = {}
    for q, middle in zip(parameters.free, parameters.middle.tolist(), strict=True):
        if q.name in shares:
            share, error = shares[q.name]
            values[q.name] = middle + share * (q.upper - middle), error * (q.upper - middle)
    return values


def _levels(
    parameters: Parameters, levels: Mapping[int, tuple[float, float]]
) -> dict[str, tuple[float, float]]:
    """Breakaway and its error by name, of the levels in either direction."""
    columns = breakaway_columns(parameters.law)
    names = [] if columns is None else [parameters.names[c] for c in columns]
    values = {}
    for name in dict.fromkeys(names):
        own = [level for way, level in levels.items() if names[way > 0] == name]
        if own:
            level, error = np.transpose(own)
            values[name] = float(np.mean(level)), float(np.sqrt(np.mean(np.square(error))))
    return values
