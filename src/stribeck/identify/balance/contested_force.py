"""What the measured force gives for parameters that are set; see `contested_values`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ..contested_values import APART, FreedValue, fixed_values, slopes_over
from ..uncertainty.covariance import HALF_WIDTH
from . import balance
from .regression import System

if TYPE_CHECKING:
    from ..exact_constants import Slopes
    from ..parameters import Parameters
    from ..result import Fit
    from .balance import Balance

#: What keeps an estimate from saying that another value is wrong.
_DOUBTS = frozenset({"data", "model", "arithmetic", "at a bound", "guessed", "rests on another"})


@dataclass(frozen=True)
class SetValues:
    """What a balance owes to the parameters that are set.

    Args:
        freed: What the logs give for those that may be others.
        slopes: Of the free parameters over those set, all others refitted, SI.
    """

    freed: tuple[FreedValue, ...] = ()
    slopes: Slopes = field(default_factory=dict)


def set_values(
    parameters: Parameters, solved: Balance, judge: Callable[[Parameters], Fit]
) -> SetValues:
    """The parameters that are set, each free once more in the balance that was solved.

    A quick look says for which a fit of its own is worth while, with all that it is judged by.

    Args:
        parameters: As they were asked for.
        solved: Their balance.
        judge: The fit of others on the same logs.
    """
    freed: list[FreedValue] = []
    slopes: dict[str, Mapping[str, float]] = {}
    for name, value in fixed_values(parameters).items():
        system = System(solved.system.parameters.freeing(name), solved.system.logs)
        if value:
            slopes |= _slopes(system, solved, name)
        if _worth(system, solved, name, value):
            freed += _freed(parameters.freeing(name), name, solved, judge)
    return SetValues(tuple(freed), slopes)


def _slopes(system: System, solved: Balance, name: str) -> Slopes:
    """Slopes of the other free parameters of a system over one of them."""
    names = [q.name for q in system.parameters.free]
    columns = dict(zip(names, system.jacobian(solved.values).T, strict=True))
    over = {name: columns.pop(name)}
    return slopes_over([*columns.values()], over, [*columns])


def _worth(system: System, solved: Balance, name: str, value: float) -> bool:
    """Whether a balance with a parameter free may have it elsewhere."""
    try:
        quick = balance.solved(system, solved.values)
    except InputError:  # too few rows for one more
        return False
    half = HALF_WIDTH * float(quick.robust_errors[quick.names.index(name)])
    return abs(quick[name] - value) > max(half, APART * abs(value))


def _freed(
    parameters: Parameters, name: str, solved: Balance, judge: Callable[[Parameters], Fit]
) -> list[FreedValue]:
    """What a fit with a parameter free gives for it; nothing where that is in doubt itself."""
    try:
        fit = judge(parameters)
    except InputError:
        return []
    pairs = zip(parameters.every, fit.estimates, strict=True)
    (e,) = (e for q, e in pairs if q.name == name)
    if e.verdict == "not identifiable" or e.reason in _DOUBTS or not np.isfinite(e.high - e.low):
        return []
    gain = 1.0 - (fit.score.value / solved.relative_error) ** 2
    misfit = f"the force error is {fit.score.value:.3g}, not {solved.relative_error:.3g} %"
    adequate = not any(v.condition == "model" for v in fit.violations)
    return [FreedValue(name, e.value, e.low, e.high, fit.p, gain, misfit, adequate)]
