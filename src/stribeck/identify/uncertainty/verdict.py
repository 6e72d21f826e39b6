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
#: Why a parameter is not identified: its interval is wide, or reaches a bound of its range; a side
#: of it is a guess; the order of the law holds it; or a condition of the fit does not hold.
Reason = Literal[
    "", "wide", "at a bound", "guessed", "rests on another",
    "data", "constants", "model", "arithmetic", "search",
]  # fmt: skip

#: Half-width of an interval as a share of the value, up to which a parameter is identified.
IDENTIFIED = 0.1
#: Share of the search range, in the search scale, from which an interval says nothing: nine in ten
#: estimates of other recordings would spread over 1.645 / 1.96 of it, which is most of the range.
ALL_OVER = 2 / 3
#: Upper over lower end of the interval of a parameter that is searched by its decades, from which
#: not even its order of magnitude is known.
DECADES = 100.0


def verdict(profile: Profile, param: Param) -> tuple[Verdict, Reason]:
    """What a profile says of a parameter, and why no more; see `estimates.Estimate`."""
    down, up = half_widths(profile)
    size = abs(profile.value)
    closed = [side.ended not in ("bound", "flat") for side in (profile.low, profile.high)]
    guessed = "budget" in (profile.low.ended, profile.high.ended)  # too wide, as a rule
    share = share_of_range(profile.low.end, profile.high.end, param)
    if not guessed and (share >= ALL_OVER or not any(closed)):
        return "not identifiable", "wide" if any(closed) else "at a bound"
    if down + up <= 0.0 or (param.log and profile.high.end > DECADES * profile.low.end):
        return "not identifiable", "wide" if down + up > 0.0 else "at a bound"
    if max(down, up) > IDENTIFIED * size:
        return "weak", "wide"
    ended = {profile.low.ended, profile.high.ended}
    if ended == {"threshold"}:
        return "identified", ""
    if guessed:
        return "weak", "guessed"
    return "weak", "rests on another" if "order" in ended else "at a bound"


def verdict_text(verdict: str, reason: str = "", *, borderline: bool = False) -> str:
    """A verdict with what keeps it from being "identified", and whether it could be another."""
    words = [reason] if verdict == "weak" and reason else []
    words += ["borderline"] if borderline else []
    return f"{verdict} ({', '.join(words)})" if words else verdict


def half_widths(profile: Profile) -> tuple[float, float]:
    """From the value down to the lower end, and up to the upper one, SI."""
    return profile.value - profile.low.end, profile.high.end - profile.value


def share_of_range(low: float, high: float, param: Param) -> float:
    """How much of its search range an interval takes, in the search scale."""
    ends = Space((param,)).encode(np.array([[low], [high]]))
    return float(ends[1, 0] - ends[0, 0])
