"""A misfit that is too rough to be walked along, and slopes that outweigh what is rough.

A simulation of many stiff slips answers to the last digits of its parameters. What it changes by
there is what its steps are off by: a walk ends wherever that is large, and short differences show
it rather than slopes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...optimize.box import Box
from ...optimize.differences import differences
from ...optimize.lockstep import AskTell, Counted, lockstep
from ...optimize.moves import Moves
from ...optimize.trust_region import Iterate
from ...space import Array

#: The way in the unit cube over which nothing should change, and how many points that far away
#: tell: half of them change more than is said.
SHORT, POINTS = 1e-11, 8
#: First length of a difference, how often it is doubled at most, and how many times as large as
#: the roughness what changes over it has to be.
FIRST, DOUBLINGS, TIMES = 1e-4, 9, 10.0


class Roughness(NamedTuple):
    """What hardly moving at a fit changes.

    Args:
        squares: The sum of squares by.
        residuals: All residuals by, as a Euclidean norm.
    """

    squares: float
    residuals: float


def roughness(best: Iterate, box: Box, counted: Counted, level: float) -> Roughness | None:
    """The roughness at a fit; None where the sum of squares changes by less than a level.

    Args:
        best: The fit.
        box: Of its parameters.
        counted: Its problem.
        level: What is not worth more than one point.
    """
    if counted.left < POINTS:
        return None
    ways = np.random.default_rng(0).uniform(-1.0, 1.0, (POINTS, box.dim))
    places = box.space.decode(np.clip(best.u + SHORT * ways, 0.0, 1.0))
    first = _changes(best, counted, places[:1])
    if not first[0].squares > level:  # as a rule
        return None
    changes = first + _changes(best, counted, places[1:])
    median = Roughness(*np.median(np.array(changes), axis=0).tolist())
    return median if median.squares > level else None


def _changes(best: Iterate, counted: Counted, places: Array) -> list[Roughness]:
    R = counted.residuals(places)
    squares = np.einsum("nm,nm->n", R, R) - best.squares
    sizes = np.linalg.norm(R - best.r, axis=1)
    return [Roughness(abs(s), d) for s, d in zip(squares.tolist(), sizes.tolist(), strict=True)]


def outweighing(best: Iterate, box: Box, counted: Counted, rough: Roughness) -> Iterate:
    """A fit with slopes by differences to both sides that are long enough.

    To one side where the other cannot be run, and 0 where neither can.
    """
    J = np.zeros_like(best.J)
    lockstep(counted, [AskTell("slopes", box.space, _lengthened(best, TIMES * rough.residuals, J))])
    return replace(best, J=J, age=0)


def _lengthened(best: Iterate, least: float, J: Array) -> Moves[None]:
    """Slopes, into J, by differences that are doubled until residuals change by so much."""
    lengths = np.full(len(best.u), FIRST)
    for _ in range(1 + DOUBLINGS):
        up, ahead = yield from differences(best.u, best.r, lengths, detailed=True)
        down, behind = yield from differences(best.u, best.r, -lengths, detailed=True)
        both = ahead != behind
        change = np.where(both[:, None], up - down, up)
        runs = np.isfinite(change[:, 0])
        J[runs] = change[runs] / np.where(both, ahead - behind, ahead)[runs, None]
        lengths = np.where(np.linalg.norm(change, axis=1) <= least, 2.0 * lengths, 0.0)
        if not lengths.any():
            break
