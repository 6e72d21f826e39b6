"""Transmissions: how the motor's force and inertia come to the load."""

from __future__ import annotations

from collections.abc import Mapping
from math import copysign
from typing import Any

import numpy as np

from ..motion.part_call import DAMPING, STIFFNESS, Row
from .part import Coefficient, Part

#: A law may have a ratio, too, of static over Coulomb friction.
_RATIO = Coefficient(
    "gear_ratio", "", "turns (way) of the motor for one of the load", 1.0, 1e-3, 1e4, True,
    positive=True,
)  # fmt: skip
_EFFICIENCIES = (
    Coefficient("eta", "", "efficiency where the motor drives the load", 1.0, 0.01, 1.0,
                positive=True, most=1.0),
    Coefficient("eta_back", "", "efficiency where the load drives the motor", 1.0, 0.01, 1.0,
                positive=True, most=1.0),
)  # fmt: skip


def lossy(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:
    """Force times eta where it drives the load, over eta_back where it brakes it: c has both."""
    share = c[0] if force * copysign(1.0, v) >= 0.0 else c[1]
    slope[STIFFNESS] *= share
    slope[DAMPING] *= share
    return share * force


def _losses(values: Mapping[str, Any]) -> tuple[Any, Any]:
    return values["eta"], 1.0 / values["eta_back"]


RIGID = Part(
    name="rigid",
    role="transmission",
    doc="none: the motor's shaft is the axis",
    equation="n = 1, F = F_m",
    coefficients=(),
)

GEAR = Part(
    name="gear",
    role="transmission",
    doc="a rigid gear with an efficiency by the direction of power",
    equation="n = gear_ratio; F = eta F_m where it drives the load, F_m / eta_back where it "
    "brakes it",
    coefficients=(
        _RATIO,
        *_EFFICIENCIES,
    ),
    function=lossy,
    constants=_losses,
    rotary=True,
)

SCREW = Part(
    name="screw",
    role="transmission",
    doc="a rigid screw, rack or belt: a way for each turn of the motor",
    equation="n = 2π / lead; F = eta F_m where it drives the load, F_m / eta_back where it "
    "brakes it",
    coefficients=(
        Coefficient("lead", "m", "way of the load for a turn of the motor", lower=1e-4, upper=10.0,
                    log=True, positive=True),
        *_EFFICIENCIES,
    ),
    function=lossy,
    constants=_losses,
    rotary=False,
)  # fmt: skip

COMPLIANT = Part(
    name="compliant",
    role="transmission",
    doc="a spring with a damper and play between a motor and a load that both have inertia",
    equation="F = eta T where it drives the load, T / eta_back where it brakes it; "
    "T = stiffness s + damping s' at a flank, 0 between them; q_m − q = s + b, |b| ≤ play/2; "
    "n = gear_ratio",
    coefficients=(
        _RATIO,
        Coefficient("stiffness", "N/m", "stiffness between motor and load, at the load",
                    lower=1.0, upper=1e9, log=True, rotary="N m/rad", symbol="k",
                    positive=True),
        Coefficient("damping", "N s/m", "damping beside it", 0.0, 0.0, 1e6,
                    rotary="N m s/rad", symbol="d", least=0.0),
        Coefficient("play", "m", "way of the load from flank to flank with the motor held", 0.0,
                    0.0, 1.0, rotary="rad", symbol="b", least=0.0),
        Coefficient("start", "", "where in the play a motion starts, −1 to 1, if no encoder tells",
                    0.0, -1.0, 1.0, least=-1.0, most=1.0),
        *_EFFICIENCIES,
    ),
    terms=lambda values: {
        **{name: values[name] for name in ("stiffness", "damping", "play", "start")},
        "forward": values["eta"], "backward": 1.0 / values["eta_back"],
    },
)  # fmt: skip


def ratio(values: Mapping[str, Any]) -> Any:
    """Speed of the motor over that of the load, of the values of an axis."""
    return 2.0 * np.pi / values["lead"] if "lead" in values else values.get("gear_ratio", 1.0)
