"""Where a fit slip by slip begins to search: what onsets and slips tell without simulating any."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..space import Array, Param, Rng, Space
from .onset_levels import onset_levels
from .own_breakaway import onset_of

if TYPE_CHECKING:
    from .parameters import Parameters
    from .segment import Segment

#: Starts that are drawn.
STARTS = 16
#: Range of a parameter in the natural scale of slips: a force over that of breakaway, and so on;
#: speeds and masses evenly in their logarithm.
_LEVEL, _SLOPE, _SPEED, _MASS = (0.1, 1.0), (0.0, 2.0), (0.02, 1.0), (0.02, 2.0)
#: Standard errors about what the onsets tell.
_ERRORS = 2.0


@dataclass(frozen=True)
class SlipScale:
    """What slips measure parameters by, SI.

    Args:
        force: Breakaway.
        speed: Median of the slips' greatest speeds.
        length: Median of their ways.
    """

    force: float
    speed: float
    length: float


def slip_scale(force: float, slips: Sequence[Segment]) -> SlipScale:
    """The scale of slips that break away under a force."""
    ways, speeds = [], []
    for s in slips:
        x, t = s.track.measured, s.track.t
        ways.append(float(np.ptp(x)))
        lag = max(int(np.searchsorted(t - t[0], 0.5 * onset_of(s).seconds)), 1)
        speeds.append(float(np.max(np.abs(x[lag:] - x[:-lag]) / (t[lag:] - t[:-lag]))))
    return SlipScale(force, float(np.median(speeds)), float(np.median(ways)))


def drawn_starts(parameters: Parameters, slips: Sequence[Segment], rng: Rng) -> Array:
    """Starts in the unit cube of the free parameters, (STARTS, dim).

    Breakaway and what else pulls at an axis at rest as a regression over the onsets has them; the
    others over the natural scale of the slips, within their search ranges.
    """
    try:
        known = onset_levels(parameters, slips)
    except InputError:
        return rng.random((STARTS, len(parameters.free)))
    scale = slip_scale(known.mean, slips)
    columns = []
    for q in parameters.free:
        if q.name in known.values:
            value, error = known.values[q.name]
            x = value + _ERRORS * error * rng.uniform(-1.0, 1.0, STARTS)
        else:
            x = _drawn(q, scale, rng)
        columns.append(np.clip(x, q.lower, q.upper))
    return np.clip(Space(parameters.free).encode(np.column_stack(columns)), 0.0, 1.0)


def _drawn(q: Param, scale: SlipScale, rng: Rng) -> Array:
    """Values of a parameter over its natural scale, or over its range where it has none."""
    strata = rng.permutation(STARTS) + rng.random(STARTS)
    share: Array = strata / STARTS
    if q.unit in ("N", "N m"):
        return scale.force * _between(_LEVEL, share)
    if q.unit in ("N s/m", "N m s/rad"):
        return scale.force / scale.speed * _between(_SLOPE, share)
    if q.unit in ("m/s", "rad/s"):
        return scale.speed * np.exp(_between((np.log(_SPEED[0]), np.log(_SPEED[1])), share))
    if q.unit in ("kg", "kg m**2"):
        mass = scale.force * scale.length / scale.speed**2
        return mass * np.exp(_between((np.log(_MASS[0]), np.log(_MASS[1])), share))
    if q.log:
        return np.exp(_between((np.log(q.lower), np.log(q.upper)), share))
    return _between((q.lower, q.upper), share)


def _between(ends: tuple[float, float], share: Array) -> Array:
    return ends[0] + share * (ends[1] - ends[0])
