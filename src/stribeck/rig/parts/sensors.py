"""Sensors: how a controller sees the axis, and which side of it a log shows."""

from __future__ import annotations

import numpy as np

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

MOTOR = Part(
    name="motor",
    role="sensor",
    doc="an encoder at the motor of an axis with two masses",
    equation="q_m as logged = per_load (q_m + zero)",
    coefficients=(
        Coefficient("per_load", "", "what it shows for 1 m (1 rad) of the load", 1.0, positive=True,
                    setting=True),
        Coefficient("zero", "m", "what it shows, over per_load, in the middle of the play where "
                    "the load's shows 0; by each log itself where it is not stated", np.nan,
                    rotary="rad", setting=True),
    ),
)  # fmt: skip

LOAD = Part(
    name="load",
    role="sensor",
    doc="an encoder at the load of an axis with two masses",
    equation="q as logged",
    coefficients=(
        Coefficient("by_load", "", "1: the controller reads its position, 0: the motor's", 0.0,
                    setting=True, choices=(0.0, 1.0)),
    ),
    terms=lambda values: {"by_load": values["by_load"]},
)  # fmt: skip
