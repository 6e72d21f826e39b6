"""Signs of overcompensation in a simulated motion: limit cycles, reversals, creep.

Each stretch in which the reference moves one way, and each of its rests, is compared with the same
stretch of the same axis without compensation; the first third of it, in which the axis catches up,
is not looked at. A sign that is there without compensation is not the compensation's.

- **runs away**: the axis leaves its start by a hundred times the reference's travel, and 10 m or
  rad, or swings so fast that it cannot be simulated.
- **runs back**: it moves against the reference by more than the floor.
- **swings on**: a limit cycle. While the reference moves at one speed, the error swings by more
  than the floor and twice what it swings on an axis of viscous friction (gravity makes a soft loop
  swing), and by four fifths or more in the last third of the stretch of what it swings in the
  middle one. Where the speed changes, the error turns four times or more, each time by more than
  the floor, and at last by half or more of its greatest turn.
- **sticks and slips**: it swings by so much, and rests in between: in the last third of a stretch
  of one speed, else while the reference has more than half of the stretch's greatest speed.
- **creeps on**: in the last third of a rest of the reference it still moves by more than the floor,
  and by four fifths or more of what it moves in the middle third: it does not settle.
- **is worse**: the error's RMS is above that without compensation.

The floor is a hundredth of the greatest error without compensation, two counts of the sensor if
that is more.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numba import float64, int64, types

from ..compile_cache import compiled

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from ..space import Array
    from .closed_loop import Reference

Sign = Literal[
    "runs away", "runs back", "swings on", "sticks and slips", "creeps on", "is worse"
]  # fmt: skip
#: Signs in the order in which the worst is told first.
SIGNS: tuple[Sign, ...] = (
    "runs away", "runs back", "swings on", "sticks and slips", "creeps on", "is worse",
)  # fmt: skip

#: Share of the greatest error without compensation below which nothing is looked at.
FLOOR = 0.01
#: A swing that keeps this share from one third to the next does not decay.
LASTING = 0.8
#: Where the speed changes: turns of an error that make two cycles, and the share of the greatest
#: turn that the last one keeps.
_TURNS, _KEPT = 4, 0.5
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

    @property
    def middle(self) -> slice:
        """Its second third."""
        third = (self.stop - self.begin) // 3
        return slice(self.begin + third, self.begin + 2 * third)

    @property
    def last(self) -> slice:
        """Its last third."""
        return slice(self.begin + 2 * ((self.stop - self.begin) // 3), self.stop)

    @property
    def settled(self) -> slice:
        """Both of these."""
        return slice(self.middle.start, self.stop)


@dataclass(frozen=True, eq=False)
class Observed:
    """What n motions do, stretch by stretch.

    Args:
        signs: By sign whether a motion shows it in a stretch, (n, S).
        unsettled: Where it swings on or rests behind the reference, (n, S): no stretch in which
            it settles.
        swing: How far its error swings in the last third of each, where that lasts, m or rad,
            (n, S).
        at_rest: Share of the reference's moving samples at which the axis rests, (n,).
        peak: Greatest speed, m/s or rad/s, (n,).
    """

    signs: Mapping[Sign, NDArray[np.bool_]]
    unsettled: NDArray[np.bool_]
    swing: Array
    at_rest: Array
    peak: Array

    def beyond(self, baseline: Observed) -> dict[Sign, NDArray[np.bool_]]:
        """The signs that a baseline does not show in the same stretch, (n,) each.

        Only where the baseline settles can a swing be a compensation's.
        """
        before = dict(baseline.signs)
        before["swings on"] = before["sticks and slips"] = baseline.unsettled
        return {k: np.any(v & ~before[k], axis=1) for k, v in self.signs.items()}


def stretches(reference: Reference, still: float) -> list[Stretch]:
    """The stretches of a reference that are long enough to be looked at.

    Args:
        reference: The reference.
        still: Speed up to which it rests, m/s or rad/s.
    """
    v = reference.v
    direction = np.where(np.abs(v) > still, np.sign(v), 0.0).astype(int)
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
    return np.array([np.ptp(error[:, s.last], axis=1) for s in parts]).reshape(len(parts), -1).T


def observed(
    reference: Reference,
    parts: list[Stretch],
    x: Array,
    v: Array,
    still: float,
    floor: Array,
    own_motion: Array | None = None,
) -> Observed:
    """What motions show, without a look at their baseline.

    Args:
        reference: What they follow.
        parts: Its stretches.
        x: Positions, (n, N).
        v: Velocities, (n, N).
        still: Speed up to which an axis rests, m/s or rad/s.
        floor: (n,).
        own_motion: What the loops swing where nothing can hunt, see `swings`; by default none.
    """
    n = len(x)
    away: NDArray[np.bool_] = np.array([not np.isfinite(row).all() for row in x])
    swing, back, cycles, rests, creeps = np.zeros((5, n, len(parts)))
    with np.errstate(invalid="ignore"):  # what ran away is told as that
        for k, s in enumerate(parts):
            if s.direction == 0:
                settling, at_rest = (np.ptp(x[:, rows], axis=1) for rows in (s.middle, s.last))
                creeps[:, k] = (at_rest > floor) & (at_rest >= LASTING * settling)
                continue
            along = s.direction * x[:, s.settled]
            back[:, k] = (np.maximum.accumulate(along, axis=1) - along).max(axis=1) > floor
            fast = np.abs(reference.v[s.settled])
            at_speed = s.last if s.even else s.settled.start + np.flatnonzero(fast > fast.max() / 2)
            rests[:, k] = (np.abs(v[:, at_speed]) <= still).any(axis=1)
            if s.even:
                before, after = (np.ptp((reference.x - x)[:, rows], axis=1)
                                 for rows in (s.middle, s.last))  # fmt: skip
                least = floor if own_motion is None else floor + 2.0 * own_motion[:, k]
                lasts = (after >= LASTING * before) | (rests[:, k] > 0)
                cycles[:, k], swing[:, k] = (after > least) & lasts, after
                continue
            for i in np.flatnonzero(~away):
                error = np.ascontiguousarray((reference.x - x[i])[s.settled])
                turns, last, swing[i, k] = turned(error, floor[i])
                cycles[i, k] = rests[i, k] or (turns >= _TURNS and last >= _KEPT * swing[i, k])
    moves = np.abs(reference.v) > still
    lasting, resting, there = cycles > 0, rests > 0, ~away[:, None]
    ran = np.zeros_like(lasting)
    ran[:, :1] = away[:, None]
    return Observed(
        {
            "runs away": ran,
            "runs back": (back > 0) & there,
            "swings on": lasting & ~resting & there,
            "sticks and slips": lasting & resting & there,
            "creeps on": (creeps > 0) & there,
        },
        lasting | resting,
        np.where(lasting, swing, 0.0),
        (np.abs(v[:, moves]) <= still).mean(axis=1),
        np.abs(np.nan_to_num(v, nan=np.inf)).max(axis=1),
    )


@compiled(types.Tuple((int64, float64, float64))(types.Array(float64, 1, "C"), float64))
def turned(error: Array, floor: float) -> tuple[int, float, float]:
    """How often an error turns by more than a floor; its last turn, and its greatest."""
    turns, last, most = 0, 0.0, 0.0
    low = high = error[0]
    way = 0  # the way it goes, once that is known
    for e in error:
        if way >= 0:
            high = max(high, e)
        if way <= 0:
            low = min(low, e)
        if way >= 0 and high - e > floor:
            if way > 0:
                turns, last = turns + 1, high - low
            way, low = -1, e
        elif way <= 0 and e - low > floor:
            if way < 0:
                turns, last = turns + 1, high - low
            way, high = 1, e
        most = max(most, last)
    return turns, last, most
