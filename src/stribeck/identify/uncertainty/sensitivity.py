"""What a parameter means in practice: what doubling it does to the fit, and what ends its interval.

A profile says where an interval ends. People ask first whether a parameter matters at all: so it
is set to twice its value, the others are refitted, and the misfit is told.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...space import Param, Space
from .blind_directions import percent
from .descent import Asking, Meter, Place, Terrain, ahead, masked, settle, together
from .profile import Ended, Profile, Profiles
from .residuals import Residuals

#: A refit far from the best fit is over where no step promises more than this share of the sum
#: of squares, or after so many rows for each parameter.
COARSE, ROWS = 0.02, 5
#: Above this relative change of the misfit it is told as a factor.
MANY = 4.0

#: What ends an interval, for people.
ENDS: dict[Ended, str] = {
    "threshold": "the data",
    "bound": "the search range",
    "order": "the law's order of parameters",
    "flat": "the search range, the fit hardly changing up to there",
    "unrunnable": "parameters that cannot be simulated",
    "budget": "a guess, as the evaluations were spent",
}


@dataclass(frozen=True)
class Weight:
    """What a parameter set to another value does to the fit, the others refitted.

    Args:
        kind: `doubling`, `halving`, or `end` where both leave the search range.
        value: That value, SI.
        change: Relative change of the root mean square of the residuals; nan where it cannot
            be simulated.
    """

    kind: str
    value: float
    change: float


def weights(problem: Residuals, found: Profiles) -> tuple[tuple[Weight, ...], int]:
    """The weight of each parameter profiled, in order, and how many rows were evaluated.

    Far from the best fit the refit is a coarse one, and its misfit an upper limit.
    """
    terrain = Terrain(problem)
    names = terrain.space.names
    targets = [_target(terrain, p, names.index(p.name)) for p in found.profiles]
    squares = [_within(p, value) for p, (_, value) in zip(found.profiles, targets, strict=True)]
    best = Place(terrain.u(found.x), found.residuals, found.J, found.squares, 0)
    places: dict[int, Place] = {}
    tasks = []
    for i, (p, (_, value)) in enumerate(zip(found.profiles, targets, strict=True)):
        if np.isnan(squares[i]):
            places[i] = best.copy()
            k = names.index(p.name)
            x = found.x.copy()
            x[k] = value
            tasks.append(_moved(places[i], terrain, k, float(terrain.u(x)[k] - best.u[k])))
    limit = len(tasks) * (ROWS * terrain.dim + 2 * terrain.dim + 2)
    meter = Meter(problem, limit)
    together(tasks, meter)
    for i, place in places.items():
        moved = not np.array_equal(place.u, best.u)
        squares[i] = place.squares if moved else np.nan
    return tuple(
        Weight(kind, value, _change(s + (0.0 if i in places else found.squares), found.squares))
        for i, ((kind, value), s) in enumerate(zip(targets, squares, strict=True))
    ), meter.rows


def _target(terrain: Terrain, profile: Profile, k: int) -> tuple[str, float]:
    lower, upper = float(terrain.space.lower[k]), float(terrain.space.upper[k])
    for kind, factor in (("doubling", 2.0), ("halving", 0.5)):
        if profile.value and lower <= factor * profile.value <= upper:
            return kind, factor * profile.value
    middle = float(terrain.u(np.where(np.arange(terrain.dim) == k, profile.value, 1.0))[k])
    return "end", upper if middle < 0.5 else lower  # noqa: PLR2004 - the farther one


def _within(profile: Profile, value: float) -> float:
    """The rise of the sum of squares at a value, if the profile has been there; else nan."""
    if not profile.values[0] <= value <= profile.values[-1]:
        return float("nan")
    roots = np.interp(value, profile.values, np.sqrt(np.maximum(profile.rises, 0.0)))
    return float(roots) ** 2 * profile.threshold


def _moved(place: Place, terrain: Terrain, k: int, move: float) -> Asking:
    """Set a coordinate elsewhere, and refit the others."""
    there, _ = ahead(place, terrain, k, move)
    R = (yield there[None])[0]
    if not np.isfinite(R).all():
        there = place.u.copy()
        there[k] = min(max(there[k] + move, 0.0), 1.0)
        there = terrain.orderly(there, k)
        R = (yield there[None])[0]
        if not np.isfinite(R).all():
            return
    place.move(there, R)
    free, gain = masked(terrain.dim, k), COARSE * place.squares
    yield from settle(place, terrain, free, gain, ROWS * terrain.dim)


def _change(squares: float, best: float) -> float:
    return float(np.sqrt(max(squares / best, 1.0)) - 1.0) if best > 0 else float("nan")


def sentence(
    name: str, profile: Profile, weight: Weight, show: Callable[[float], str], misfit: str = "J"
) -> str:
    """One sentence on a parameter.

    Args:
        name: As people call it.
        profile: Its profile.
        weight: Its weight.
        show: A value, SI, as people see it.
        misfit: What the root mean square of the residuals is called.
    """
    if weight.kind == "end":
        what = f"{name} at {show(weight.value)}, the far end of its range"
    else:
        what = f"{weight.kind} {name}"
    if np.isnan(weight.change):
        effect = "cannot be simulated"
    elif weight.change > MANY:
        effect = f"raises {misfit} {weight.change + 1:.2g}-fold"
    else:
        effect = f"raises {misfit} by {percent(weight.change)}"
    low, high = ENDS[profile.low.ended], ENDS[profile.high.ended]
    ends = (
        f"both ends of its interval are set by {low}"
        if low == high
        else f"the lower end of its interval is set by {low}, the upper one by {high}"
    )
    first = what[0].upper() + what[1:] if weight.kind != "end" else what
    return f"{first}, the others refitted, {effect}; {ends}"


def half_widths(profile: Profile) -> tuple[float, float]:
    """From the value down to the lower end, and up to the upper one, SI."""
    return profile.value - profile.low.end, profile.high.end - profile.value


def share_of_range(profile: Profile, param: Param) -> float:
    """How much of its search range an interval takes, in the search scale."""
    ends = Space((param,)).encode(np.array([[profile.low.end], [profile.high.end]]))
    return float(ends[1, 0] - ends[0, 0])
