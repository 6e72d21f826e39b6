"""How the constants of a rig move what its force balance gives, and what their tolerances do."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...constant import Constant
from ...errors import InputError
from ...units import percent
from ..exact_constants import STEP, Slopes, is_exact
from ..parameters import Parameters
from ..uncertainty.covariance import HALF_WIDTH
from ..uncertainty.estimates import Estimate
from ..uncertainty.verdict import IDENTIFIED
from .balance import Balance

#: A parameter is said to be in proportion to a constant if its elasticity is so close to 1.
PROPORTIONAL = 0.02


def constant_slopes(
    solution: Balance, solve: Callable[[Parameters], Balance]
) -> dict[str, dict[str, float]]:
    """Slopes of all parameters over the constants of the axis, SI, by the names of both.

    Args:
        solution: The balance.
        solve: Solves it again on a rig with other constants.
    """
    parameters = solution.system.parameters
    chain = parameters.rig.chain
    slopes: dict[str, dict[str, float]] = {}
    scaled: tuple[int, Constant] | None = None
    for c in parameters.rig.constants:
        if not (is_exact(c) or c.tolerance > 0):
            continue
        power = None if chain is None else chain.exponent(c.name)
        if power and scaled:  # all forces go with it as with another: no need to solve again
            per_share = scaled[1].value / scaled[0] * power / c.value
            slopes[c.name] = {n: s * per_share for n, s in slopes[scaled[1].name].items()}
            continue
        rig = parameters.rig.estimated({c.name: (1 + STEP) * c.value})
        try:
            moved = solve(replace(parameters, rig=rig))
        except InputError:  # a balance that cannot be solved there says nothing of the constant
            continue
        change = (moved.values - solution.values) / (STEP * c.value)
        slopes[c.name] = dict(zip(solution.names, change.tolist(), strict=True))
        scaled = (power, c) if power else scaled
    return slopes


def with_tolerances(
    parameters: Parameters, estimates: Sequence[Estimate], slopes: Slopes
) -> tuple[Estimate, ...]:
    """Estimates whose intervals carry the tolerances of the constants of their rig."""
    constants = [c for c in parameters.rig.constants if c.name in slopes]
    result = []
    for q, e in zip(parameters.every, estimates, strict=True):
        if e.verdict == "fixed":
            result.append(e)
            continue
        moves = {c.name: slopes[c.name].get(q.name, 0.0) for c in constants}
        sd = np.hypot.reduce([moves[c.name] * c.standard_deviation for c in constants] or [0.0])
        text = "".join(_clause(c, moves[c.name] * c.value / e.value if e.value else 0.0)
                       for c in constants)  # fmt: skip
        e = replace(e, meaning=f"{e.meaning}{text}".removeprefix("; "))  # noqa: PLW2901
        result.append(_widened(e, HALF_WIDTH * float(sd), q.lower, q.upper))
    return tuple(result)


def _clause(c: Constant, elasticity: float) -> str:
    if abs(elasticity - 1) < PROPORTIONAL:
        return f"; it is in proportion to {c.name}"
    if c.tolerance > 0 and abs(elasticity) > PROPORTIONAL:
        return f"; 1 % of {c.name} moves it by {percent(0.01 * elasticity)}"
    return ""


def _widened(e: Estimate, half: float, lower: float, upper: float) -> Estimate:
    """An estimate with a further error, of which 95 % is `half`."""
    if not half > 0:
        return e
    low = max(e.value - float(np.hypot(e.value - e.low, half)), lower)
    high = min(e.value + float(np.hypot(e.high - e.value, half)), upper)
    wide = max(e.value - low, high - e.value) > IDENTIFIED * abs(e.value)
    e = replace(e, low=low, high=high)
    if wide and e.verdict == "identified":
        return replace(e, verdict="weak", reason="constants")
    return e
