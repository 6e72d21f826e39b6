"""What the measured force gives for parameters that are set; see `contested_values`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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


def contested_by_force(
    parameters: Parameters, solved: Balance, judge: Callable[[Parameters], Fit]
) -> tuple[FreedValue, ...]:
    """What the logs give for parameters that are set, where the balance is better with them free.

    A quick look, with the parameter free in the balance that was solved, says which are worth a
    fit of their own, with all that it is judged by.

    Args:
        parameters: As they were asked for.
        solved: Their balance.
        judge: The fit of others on the same logs.
    """
    values = (
        _freed(parameters.freeing(name), name, solved, judge)
        for name, value in fixed_values(parameters).items()
        if _worth(solved, name, value)
    )
    return tuple(value for value in values if value is not None)


def force_slopes(parameters: Parameters, solved: Balance) -> Slopes:
    """Slopes of a balance's free parameters over the values set, all others refitted, SI.

    Args:
        parameters: As they were asked for.
        solved: Their balance.
    """
    slopes: dict[str, Mapping[str, float]] = {}
    for name, value in fixed_values(parameters).items():
        if value:
            freed = solved.system.parameters.freeing(name)
            W = System(freed, solved.system.logs).jacobian(solved.values)
            columns = dict(zip((q.name for q in freed.free), W.T, strict=True))
            over = {name: columns.pop(name)}
            slopes |= slopes_over([*columns.values()], over, [*columns])
    return slopes


def _worth(solved: Balance, name: str, value: float) -> bool:
    """Whether a balance with a parameter free may have it elsewhere."""
    system = solved.system
    if name not in system.parameters.fixed:
        return False
    freed = System(system.parameters.freeing(name), system.logs)
    try:
        quick = balance.solved(freed, solved.values)
    except InputError:  # too few rows for one more
        return False
    half = HALF_WIDTH * float(quick.robust_errors[quick.names.index(name)])
    return abs(quick[name] - value) > max(half, APART * abs(value))


def _freed(
    parameters: Parameters, name: str, solved: Balance, judge: Callable[[Parameters], Fit]
) -> FreedValue | None:
    """What a fit with a parameter free gives for it; None where it is in doubt itself."""
    try:
        fit = judge(parameters)
    except InputError:
        return None
    pairs = zip(parameters.every, fit.estimates, strict=True)
    (e,) = (e for q, e in pairs if q.name == name)
    if e.verdict == "not identifiable" or e.reason in _DOUBTS or not np.isfinite(e.high - e.low):
        return None
    gain = 1.0 - (fit.score.value / solved.relative_error) ** 2
    misfit = f"the force error is {fit.score.value:.3g}, not {solved.relative_error:.3g} %"
    adequate = not any(v.condition == "model" for v in fit.violations)
    return FreedValue(name, e.value, e.low, e.high, fit.p, gain, misfit, adequate)
