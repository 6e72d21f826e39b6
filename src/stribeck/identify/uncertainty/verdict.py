"""The verdict on a parameter, from its profile.

Verdicts come from the profile likelihood, which moves all parameters: that two of them go together
widens both their intervals, and needs no rule of its own.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from ...space import Param, Space
from .profile import Profile

Verdict = Literal["identified", "weak", "not identifiable", "fixed"]

#: Half-width of an interval as a share of the value, up to which a parameter is identified.
IDENTIFIED = 0.1
#: Share of the search range, in the search scale, from which an interval says nothing: nine in ten
#: estimates of other recordings would spread over 1.645 / 1.96 of it, which is most of the range.
ALL_OVER = 2 / 3


def verdict(profile: Profile, param: Param, *, doubtful: bool = False) -> Verdict:
    """What a profile says of a parameter; see `estimates.Estimate`."""
    down, up = half_widths(profile)
    size = abs(profile.value)
    closed = [side.ended not in ("bound", "flat") for side in (profile.low, profile.high)]
    guessed = "budget" in (profile.low.ended, profile.high.ended)  # too wide, as a rule
    if not guessed and (share_of_range(profile, param) >= ALL_OVER or not any(closed)):
        return "not identifiable"
    by_data = profile.low.ended == profile.high.ended == "threshold"
    if by_data and max(down, up) <= IDENTIFIED * size and not doubtful:
        return "identified"
    return "weak"


def half_widths(profile: Profile) -> tuple[float, float]:
    """From the value down to the lower end, and up to the upper one, SI."""
    return profile.value - profile.low.end, profile.high.end - profile.value


def share_of_range(profile: Profile, param: Param) -> float:
    """How much of its search range an interval takes, in the search scale."""
    ends = Space((param,)).encode(np.array([[profile.low.end], [profile.high.end]]))
    return float(ends[1, 0] - ends[0, 0])
