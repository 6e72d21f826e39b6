"""Ratios of parameters that a common scale of all forces leaves as they are.

Where the torque constant of a drive is uncertain, so are all levels, by the same share: what one
level is of another is known as well as the data know it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..space import Array
from ..units import unit
from .exact_constants import Slopes
from .parameters import Parameters
from .uncertainty.covariance import HALF_WIDTH
from .uncertainty.estimates import Estimate
from .uncertainty.verdict import IDENTIFIED, Reason, Verdict

#: A parameter goes with the scale of all forces if its elasticity is so close to that of the scale.
PROPORTIONAL = 0.02
#: A ratio is told if both its parameters are known to this share, but for the scale.
KNOWN = 0.5
#: The level to which others are compared, where there is one.
_REFERENCE = ("F_C", "F_C+", "F_C-")


@dataclass(frozen=True)
class Ratio:
    """A parameter over another of the same scale.

    Args:
        name: As `F_S / F_C`.
        value: In `unit`.
        low: Lower end of its 95 % interval.
        high: Upper end.
        unit: Of the parameters as their rig shows them; empty for two of one unit.
        verdict: As of a parameter.
        reason: As of a parameter.
    """

    name: str
    value: float
    low: float
    high: float
    unit: str
    verdict: Verdict
    reason: Reason


def proportional(parameters: Parameters, values: Array, slopes: Slopes) -> frozenset[str]:
    """Names of the free parameters that go with the scale of all forces.

    Args:
        parameters: Rig, law and what is free.
        values: The complete set, SI, (k,).
        slopes: Of all parameters over the constants of the rig.
    """
    chain = parameters.rig.chain
    scaling = [] if chain is None else [c for c in chain.constants if chain.exponent(c.name)]
    if chain is None or not scaling or scaling[0].name not in slopes:
        return frozenset()
    first = scaling[0]
    exponent = chain.exponent(first.name) or 1
    by_name = dict(zip(parameters.names, values.tolist(), strict=True))
    return frozenset(
        q.name
        for q in parameters.free
        if by_name[q.name]
        and abs(
            slopes[first.name][q.name] * first.value / by_name[q.name] / exponent - 1
        ) < PROPORTIONAL
    )  # fmt: skip


def ratios(
    parameters: Parameters,
    estimates: Sequence[Estimate],
    correlation: Array,
    scaled: frozenset[str],
    *,
    common: bool = False,
) -> tuple[Ratio, ...]:
    """Ratios of the parameters of one scale, where the scale is not exact.

    Args:
        parameters: Rig, law and what is free.
        estimates: As in `parameters.every`.
        correlation: Of the free parameters, (dim, dim).
        scaled: Names of those that go with the scale.
        common: Whether intervals and correlation hold the scale's uncertainty.
    """
    chain = parameters.rig.chain
    if chain is None or not any(c.tolerance for c in chain.constants):
        return ()
    free = [q.name for q in parameters.free]
    known = {
        q.name: e
        for q, e in zip(parameters.every, estimates, strict=True)
        if q.name in scaled and e.value > 0 and _spread(e) <= KNOWN
    }
    if len(known) < 2:  # noqa: PLR2004 - a ratio is of two
        return ()
    best = min(known, key=lambda n: _spread(known[n]))
    reference = next((n for n in _REFERENCE if n in known), best)
    below = known[reference]
    result = []
    for name, e in known.items():
        if name != reference:
            rho = float(correlation[free.index(name), free.index(reference)])
            half = _half_width(e, below, rho, common=common)
            result.append(_ratio(e, below, half, parameters))
    return tuple(result)


def _half_width(above: Estimate, below: Estimate, rho: float, *, common: bool) -> float:
    """Half of the interval of a ratio, as a share of it.

    Without the scale's uncertainty, what of an interval is more than its standard error is of its
    parameter alone; with it, the correlation is of the intervals as they are.
    """
    if common:
        a, b, extra = _spread(above), _spread(below), 0.0
    else:
        a, b = (e.standard_error / e.value for e in (above, below))
        extra = sum(max(_spread(e) ** 2 - r * r, 0.0) for e, r in ((above, a), (below, b)))
    return HALF_WIDTH * math.sqrt(max(a * a + b * b - 2 * rho * a * b, 0.0) + extra)


def _ratio(above: Estimate, below: Estimate, half: float, parameters: Parameters) -> Ratio:
    """A ratio of two estimates, its interval so large a share of it to each side."""
    units = [parameters.rig.unit_of(q) for e in (above, below) for q in parameters.every
             if parameters.rig.label(q.name) == e.name]  # fmt: skip
    same = units[0] == units[1]
    value = _shown(above.value, units[0]) / _shown(below.value, units[1])
    judged: tuple[Verdict, Reason] = ("identified", "") if half <= IDENTIFIED else ("weak", "wide")
    written = "" if same else f"{units[0]} / {units[1]}"
    ends = value * math.exp(-half), value * math.exp(half)
    return Ratio(f"{above.name} / {below.name}", value, *ends, written, *judged)


def _spread(e: Estimate) -> float:
    """Half of an estimate's interval over its value, as a standard deviation."""
    if not (math.isfinite(e.low) and math.isfinite(e.high) and e.value):
        return math.inf
    return max(e.high - e.value, e.value - e.low) / HALF_WIDTH / abs(e.value)


def _shown(value: float, written: str) -> float:
    return float(unit(written).from_si(value))
