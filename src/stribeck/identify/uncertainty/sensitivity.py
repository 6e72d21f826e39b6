"""The effect of a parameter on the fit when doubled or halved, and what ends its interval.

A profile says where an interval ends. People ask first whether a parameter matters at all: so it
is set to twice its value, the others are refitted, and the misfit is said.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

import numpy as np

from ...optimize.box import Box
from ...optimize.lockstep import AskTell, Counted, lockstep
from ...optimize.moves import Answer, Detailed, Moves
from ...optimize.trust_region import Iterate, minimise
from ...units import percent, two_digits
from .linearisation import REACH, box_of, others, predicted
from .profile import MEMORY, Profile, Profiles
from .profile_walk import Ended
from .residuals import Residuals

#: A refit far from the best fit is over where no step promises more than this share of the sum
#: of squares, or after so many rows for each parameter.
COARSE, ROWS = 0.02, 5
#: Where the linear model promises the sum of squares to this share of it, the refit is its minimum.
LINEAR = 1e-9
#: Above this relative change of the misfit it is said as a factor.
MANY = 4.0

#: What ends an interval, for people.
ENDS: dict[Ended, str] = {
    "threshold": "the data",
    "bound": "the search range",
    "order": "the law's order of parameters",
    "flat": "the search range, the fit hardly changing up to there",
    "unrunnable": "parameters that cannot be simulated",
    "budget": "a guess, as no walk came to its end",
}


@dataclass(frozen=True)
class Sensitivity:
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


def sensitivities(problem: Residuals, profiles: Profiles) -> tuple[tuple[Sensitivity, ...], int]:
    """The sensitivity to each parameter profiled, in order, and how many rows were evaluated.

    Far from the best fit the refit is a coarse one, and its misfit an upper limit.
    """
    box = box_of(problem)
    names = box.space.names
    targets = [_target(box, p, names.index(p.name)) for p in profiles.profiles]
    rises = [_within(p, value) for p, (_, value) in zip(profiles.profiles, targets, strict=True)]
    best = replace(Iterate.at(box.u(profiles.x), profiles.residuals), J=profiles.J, age=0)
    tasks: dict[int, AskTell[Iterate]] = {}
    for i, (p, (_, value)) in enumerate(zip(profiles.profiles, targets, strict=True)):
        if np.isnan(rises[i]):
            k = names.index(p.name)
            x = profiles.x.copy()
            x[k] = value
            moves = _elsewhere(best, box, k, float(box.u(x)[k] - best.u[k]))
            tasks[i] = AskTell("refit", box.space, moves)
    counted = Counted(problem, len(tasks) * (ROWS * box.dim + 2 * box.dim + 2))
    at_once, order = max(int(MEMORY / (8 * best.J.size)), 1), list(tasks)
    refits: dict[int, Iterate | None] = {}
    for first in range(0, len(order), at_once):
        part = order[first : first + at_once]
        refits |= zip(part, lockstep(counted, [tasks[i] for i in part]), strict=True)
    squares = [
        profiles.squares + rise if i not in refits else _squares(refits[i], best)
        for i, rise in enumerate(rises)
    ]
    return tuple(
        Sensitivity(kind, value, _change(s, profiles.squares))
        for (kind, value), s in zip(targets, squares, strict=True)
    ), counted.rows


def _squares(refit: Iterate | None, best: Iterate) -> float:
    """The sum of squares of a refit; nan where it could not leave the best fit."""
    return float("nan") if refit is None or np.array_equal(refit.u, best.u) else refit.squares


def _target(box: Box, profile: Profile, k: int) -> tuple[str, float]:
    lower, upper = float(box.space.lower[k]), float(box.space.upper[k])
    for kind, factor in (("doubling", 2.0), ("halving", 0.5)):
        if profile.value and lower <= factor * profile.value <= upper:
            return kind, factor * profile.value
    middle = float(box.u(np.where(np.arange(box.dim) == k, profile.value, 1.0))[k])
    return "end", upper if middle < 0.5 else lower  # noqa: PLR2004 - the farther one


def _within(profile: Profile, value: float) -> float:
    """The rise of the sum of squares at a value, if the profile has been there; else nan."""
    if not profile.values[0] <= value <= profile.values[-1]:
        return float("nan")
    roots = np.interp(value, profile.values, np.sqrt(np.maximum(profile.rises, 0.0)))
    return float(roots) ** 2 * profile.threshold


def _elsewhere(best: Iterate, box: Box, k: int, move: float) -> Moves[Iterate]:
    """Set a coordinate elsewhere, and refit the others."""
    u, squares = predicted(best, box, k, move)
    answer: Answer = yield Detailed(u[None])
    if not np.isfinite(answer.costs[0]):
        u = best.u.copy()
        u[k] = min(max(u[k] + move, 0.0), 1.0)
        u = box.orderly(u, k)
        answer = yield Detailed(u[None])
        if not np.isfinite(answer.costs[0]):
            return best
    assert answer.residuals is not None  # noqa: S101 - the problem shows them
    R = answer.residuals[0]
    free = others(box.dim, k)
    inside = float(np.abs(u - best.u)[free].max(initial=0.0)) < REACH
    if inside and abs(float(R @ R) - squares) <= LINEAR * squares:
        return best.without_slopes().moved(u, R)
    place = best.corrected(u - best.u, R).moved(u, R)
    gain = COARSE * place.squares
    place, _ = yield from minimise(place, box, free, gain=gain, rows=ROWS * box.dim)
    return place


def _change(squares: float, best: float) -> float:
    return float(np.sqrt(max(squares / best, 1.0)) - 1.0) if best > 0 else float("nan")


def distinct(misfit: str, names: Collection[str]) -> str:
    """What the misfit is called where a parameter may have its letter, as an inertia has J."""
    return f"the misfit {misfit}" if misfit in names else misfit


def sentence(
    name: str,
    profile: Profile,
    effect: Sensitivity,
    show: Callable[[float], str],
    misfit: str = "J",
) -> str:
    """One sentence on a parameter.

    Args:
        name: As people call it.
        profile: Its profile.
        effect: What it does to the fit.
        show: A value, SI, as people see it.
        misfit: What the root mean square of the residuals is called.
    """
    if effect.kind == "end":
        change = f"{name} at {show(effect.value)}, the far end of its range"
    else:
        change = f"{effect.kind} {name}"
    if np.isnan(effect.change):
        text = "cannot be simulated"
    elif effect.change > MANY:
        text = f"raises {misfit} {two_digits(effect.change + 1)}-fold"
    else:
        text = f"raises {misfit} by {percent(effect.change)}"
    low, high = ENDS[profile.low.ended], ENDS[profile.high.ended]
    ends = (
        f"both ends of its interval are set by {low}"
        if low == high
        else f"the lower end of its interval is set by {low}, the upper one by {high}"
    )
    first = change[0].upper() + change[1:] if effect.kind != "end" else change
    return f"{first}, the others refitted, {text}; {ends}"
