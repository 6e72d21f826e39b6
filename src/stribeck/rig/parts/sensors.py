"""Sensors: how a controller sees the axis."""

from __future__ import annotations

from .part import Coefficient, Part

ENCODER = Part(
    name="encoder",
    role="sensor",
    doc="the position that a sampled controller reads has steps",
    equation="q as read = resolution round(q / resolution)",
    coefficients=(
        Coefficient("resolution", "m", "a step of the position", lower=1e-12, upper=1.0, log=True,
                    rotary="rad", positive=True),
    ),
    terms=lambda values: {"resolution": values["resolution"]},
)  # fmt: skip
