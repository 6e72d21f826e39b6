"""Transmissions: how the motor's force and inertia come to the load."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .part import Coefficient, Part

_EFFICIENCIES = (
    Coefficient("eta", "", "efficiency where the motor drives the load", 1.0, 0.01, 1.0,
                positive=True),
    Coefficient("eta_back", "", "efficiency where the load drives the motor", 1.0, 0.01, 1.0,
                positive=True),
)  # fmt: skip


def _losses(values: Mapping[str, Any]) -> Mapping[str, Any]:
    return {"forward": values["eta"], "backward": 1.0 / values["eta_back"]}


RIGID = Part(
    name="rigid",
    role="transmission",
    doc="none: the motor's shaft is the axis",
    equation="n = 1",
    coefficients=(),
    terms=lambda values: {},  # noqa: ARG005 - what other parts read
)

GEAR = Part(
    name="gear",
    role="transmission",
    doc="a rigid gear with an efficiency by the direction of power",
    equation="n = ratio; F = eta F_m where it drives the load, F_m / eta_back where it brakes it",
    coefficients=(
        Coefficient(
            "ratio",
            "",
            "turns of the motor per turn of the load",
            1.0,
            1e-3,
            1e4,
            True,
            positive=True,
        ),
        *_EFFICIENCIES,
    ),
    terms=_losses,
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
    terms=_losses,
    rotary=False,
)  # fmt: skip


def ratio(values: Mapping[str, Any]) -> Any:
    """Speed of the motor over that of the load, of the values of an axis."""
    return 2.0 * np.pi / values["lead"] if "lead" in values else values.get("ratio", 1.0)
