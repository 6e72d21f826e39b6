"""Axes at the ends of intervals: what the other parameters are where one is at its end.

An interval is a profile: at its end the others have been refitted. Where the data know a
combination better than its parts (k_t and R of a motor, by a position alone), an axis with one of
them at its end and the others as estimated is none that the data allow.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ..space import Array, Space

if TYPE_CHECKING:
    from .parameters import Parameters
    from .result import Fit
    from .uncertainty.profile import Profile

#: Where none moves by more than this share of its own interval's half, the others may as well stay:
#: an axis with one at its end and another as estimated lies within 4/3 of the threshold then.
MOVES = 0.5


def interval_ends(fit: Fit) -> dict[str, tuple[dict[str, float], dict[str, float]]]:
    """By parameter the others at its lower and at its upper end, by name, SI.

    Empty where none of them moves with it.
    """
    parameters = fit.parameters
    every = Space(parameters.every)
    profiles = {p.name: p for p in fit.uncertainty.profiles.profiles}
    of_each = [profiles.get(parameters.tied.get(n, n)) for n in every.names]
    estimated = np.array([profile is not None for profile in of_each])

    def encoded(values: Iterable[float]) -> Array:
        u: Array = every.encode(np.array([list(values)]))[0]
        return u

    at = encoded(fit.p)
    ends = [encoded(e.low for e in fit.estimates), encoded(e.high for e in fit.estimates)]
    # What widens an interval after its profile says nothing of how parameters go together.
    low = encoded(np.nan if p is None else p.low.end for p in of_each)
    high = encoded(np.nan if p is None else p.high.end for p in of_each)
    result = {}
    for k, (name, profile) in enumerate(zip(every.names, of_each, strict=True)):
        if profile is None:
            continue
        others = estimated & (np.arange(len(at)) != k)
        sides: list[dict[str, float]] = []
        for end in ends:
            u = _refitted(profile, every, parameters, at, k, float(end[k]))
            half = np.where(u < at, at - low, high - at)
            moves = bool((others & (np.abs(u - at) > MOVES * half)).any())
            values = every.decode(u[None])[0].tolist()
            sides.append(
                {every.names[i]: values[i] for i in np.flatnonzero(others)} if moves else {}
            )
        result[name] = (sides[0], sides[1])
    return result


def _refitted(
    profile: Profile, every: Space, parameters: Parameters, at: Array, k: int, end: float
) -> Array:
    """Where all parameters are with one at its end, in the unit cube, (k,).

    The place of the profile's walk that is nearest to the end, on the line from the estimate.
    """
    free = len(parameters.free)
    places = every.encode(parameters.full(profile.places[:, :free]))
    way = end - at[k]
    ways = places[:, k] - at[k]
    walked = np.flatnonzero(ways * way > 0)
    u = at.copy()
    if len(walked):
        nearest = walked[np.argmin(np.abs(ways[walked] - way))]
        u = np.clip(at + way / ways[nearest] * (places[nearest] - at), 0.0, 1.0)
    u[k] = end
    return u
