"""The constant that a measured force is in proportion to, and what its tolerance does."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...rig.balanced import as_balanced
from ...rig.constant import Constant
from ...space import Param
from ...units import unit
from ..parameters import Parameters
from ..uncertainty.estimates import Estimate
from ..uncertainty.verdict import IDENTIFIED

#: Half-width of a 95 % interval in standard deviations.
NORMAL = 1.96


def with_force_gain(parameters: Parameters, estimates: Sequence[Estimate]) -> tuple[Estimate, ...]:
    """Estimates whose intervals carry the tolerance of the gain that all forces scale with."""
    rig = as_balanced(parameters.rig)
    gain = next((c for c in rig.constants if c.name == rig.force_gain), None)
    if gain is None:
        return tuple(estimates)
    return tuple(
        _scaled(e, gain, q) if e.verdict != "fixed" and _is_force(q) else e
        for q, e in zip(parameters.every, estimates, strict=True)
    )


def _is_force(q: Param) -> bool:
    """Whether a parameter scales with the force: a force, a mass, a damping, a stiffness."""
    return re.search(r"\bkg\b", unit(q.unit).dimension) is not None


def _scaled(e: Estimate, gain: Constant, q: Param) -> Estimate:
    share = gain.standard_deviation / abs(gain.value)
    text = f"{e.meaning}; it is in proportion to {gain.name}"
    e = replace(e, meaning=text.removeprefix("; "))
    if not share > 0:
        return e
    half = NORMAL * share * abs(e.value)
    low = max(e.value - float(np.hypot(e.value - e.low, half)), q.lower)
    high = min(e.value + float(np.hypot(e.high - e.value, half)), q.upper)
    wide = max(e.value - low, high - e.value) > IDENTIFIED * abs(e.value)
    e = replace(e, low=low, high=high)
    return (
        replace(e, verdict="weak", reason="constants") if wide and e.verdict == "identified" else e
    )
