"""Signs of overcompensation in a simulated motion: limit cycles, reversals, creep.

Against the same axis without compensation, on each stretch in which the reference moves one way
(the first third of it, in which the axis catches up, is not looked at), and on each of its rests:

- **runs away**: the axis leaves its start by a hundred times the reference's travel, and 10 m or
  rad, or swings so fast that it cannot be simulated.
- **runs back**: it moves against the reference by more than the floor.
- **oscillates**: while the reference moves at one speed, the error swings by more than the floor
  and twice what it swings on an axis of viscous friction (gravity makes a soft loop swing), its
  swing in the last third of the stretch is four fifths or more of that in the middle third,
  and in none of the two does the axis rest behind its reference. (An axis that rests behind is
  not pushed enough: what is left is stick-slip, not too much compensation.)
- **creeps on**: in the last third of a rest of the reference it still moves by more than the floor,
  and by four fifths or more of what it moves in the middle third: it does not settle.
- **is worse**: the error's RMS is above that without compensation.

A sign that is there without compensation is not the compensation's. The floor is a hundredth of
the greatest error without compensation, two counts of the sensor if that is more.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..space import Array
    from .closed_loop import Reference

Sign = Literal["runs away", "runs back", "oscillates", "creeps on", "is worse"]
#: Signs in the order in which the worst is told first.
SIGNS: tuple[Sign, ...] = ("runs away", "runs back", "oscillates", "creeps on", "is worse")

#: Share of the greatest error without compensation below which nothing is looked at.
FLOOR = 0.01
#: A swing that keeps this share from one third to the next does not decay.
LASTING = 0.8
#: Stretches have so many samples at least, and last so long, s.
_FEWEST, _SHORTEST = 30, 0.3


class Stretch(NamedTuple):
    """Samples over which the reference moves one way, or rests.

    Args:
        begin: The first.
        stop: One after the last.
        direction: 1, -1, or 0 where it rests.
        even: Whether it moves at one speed.
    """

    begin: int
    stop: int
    direction: int
    even: bool


def stretches(reference: Reference, dead_band: float) -> list[Stretch]:
    """The stretches of a reference that are long enough to be looked at."""
    v = reference.v
    direction = np.where(np.abs(v) > dead_band, np.sign(v), 0.0).astype(int)
    cuts = [0, *(np.flatnonzero(np.diff(direction)) + 1).tolist(), len(v)]
    result = []
    for begin, stop in pairwise(cuts):
        if stop - begin < max(_FEWEST, _SHORTEST / reference.h):
            continue
        inner = v[begin + 1 : stop - 1]
        even = bool(np.ptp(inner) <= 0.02 * np.abs(inner).max()) if direction[begin] else False
        result.append(Stretch(begin, stop, int(direction[begin]), even))
    return result


def floors(reference: Reference, without: Array, resolution: float) -> Array:
    """How much is looked at, m or rad, (n,), from positions without compensation (n, N)."""
    floor: Array = np.maximum(FLOOR * np.abs(without - reference.x).max(axis=1), 2.0 * resolution)
    return floor


def swings(reference: Reference, parts: list[Stretch], x: Array) -> Array:
    """How far the errors of positions (n, N) swing in the last third of each stretch, (n, S)."""
    error = reference.x - x
    last = [slice(s.begin + 2 * ((s.stop - s.begin) // 3), s.stop) for s in parts]
    return np.array([np.ptp(error[:, rows], axis=1) for rows in last]).reshape(len(parts), -1).T


def signs(
    reference: Reference,
    parts: list[Stretch],
    x: Array,
    v: Array,
    dead_band: float,
    floor: Array,
    own_motion: Array | None = None,
) -> dict[Sign, NDArray[np.bool_]]:
    """Which motions show which sign, (n,) each, without a look at their baseline.

    Args:
        reference: What they follow.
        parts: Its stretches.
        x: Positions, (n, N).
        v: Velocities, (n, N).
        dead_band: Speed up to which an axis rests, m/s or rad/s.
        floor: (n,).
        own_motion: What the loops swing where nothing can hunt, see `swings`; by default none.
    """
    n = len(x)
    away = np.array([not np.isfinite(row).all() for row in x])
    reverses, swung, creeps = np.zeros((3, n), dtype=bool)
    with np.errstate(invalid="ignore"):  # what ran away is told as that
        for k, s in enumerate(parts):
            third = (s.stop - s.begin) // 3
            middle, last = s.begin + third, s.begin + 2 * third
            if s.direction == 0:
                settling, at_rest = (
                    np.ptp(x[:, middle:last], axis=1),
                    np.ptp(x[:, last : s.stop], axis=1),
                )
                creeps |= (at_rest > floor) & (at_rest >= LASTING * settling)
                continue
            along = s.direction * x[:, middle : s.stop]
            reverses |= (np.maximum.accumulate(along, axis=1) - along).max(axis=1) > floor
            if s.even:
                behind = s.direction * (reference.x - x)[:, middle : s.stop]
                rests = (np.abs(v[:, middle : s.stop]) <= dead_band) & (behind > 0.0)
                before, after = (
                    np.ptp(behind[:, rows], axis=1) for rows in (slice(third), slice(third, None))
                )
                least = floor if own_motion is None else floor + 2.0 * own_motion[:, k]
                swung |= (after > least) & (after >= LASTING * before) & ~rests.any(axis=1)
    return {
        "runs away": away,
        "runs back": reverses & ~away,
        "oscillates": swung & ~away,
        "creeps on": creeps & ~away,
    }
