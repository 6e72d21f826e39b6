"""Controllers: what asks a motor for a demand, from where an axis is and where it should be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..motion.drives import FOLLOWS, GOAL, GOAL_VELOCITY, HELD, LATE
from ..motion.part_call import DAMPING, STIFFNESS, Row
from .part import Coefficient, Part

_ASKED = "what the motor takes: N (N m), A or V"
_SAMPLED = (
    Coefficient("hold", "", "1: demand held from sample to sample, 2: and a sample late", 0.0,
                setting=True, choices=(FOLLOWS, HELD, LATE)),
    Coefficient("limit", "", f"largest demand, in {_ASKED}", np.inf,
                positive=True),
)  # fmt: skip


def proportional(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:
    """Demand k_p (goal − q) + k_d (goal_velocity − v), with k_p, k_d = c."""
    slope[STIFFNESS] += c[0]
    slope[DAMPING] += c[1]
    return force + c[0] * (u[GOAL] - q) + c[1] * (u[GOAL_VELOCITY] - v)


def _pd(values: Mapping[str, Any]) -> tuple[Any, Any]:
    gain = values["gain"]
    return gain * values["gain_p"] * values["kp"], gain * values["gain_d"] * values["kd"]


def _held(values: Mapping[str, Any]) -> Mapping[str, Any]:
    return {"limit": values["limit"], "hold": values["hold"]}


_PD_COEFFICIENTS = (
    Coefficient("kp", "", f"demand per error of the position, in {_ASKED}, per m (rad)",
                lower=1e-3, upper=1e9, log=True, symbol="k_p"),
    Coefficient("kd", "", "demand per velocity", 0.0),
    Coefficient("gain", "", "share of the feedback that acts", 1.0),
    Coefficient("gain_p", "", "share of the position's feedback that acts, beside gain", 1.0),
    Coefficient("gain_d", "", "share of the velocity's feedback that acts, beside gain", 1.0),
    *_SAMPLED,
)  # fmt: skip

PD = Part(
    name="pd",
    role="controller",
    doc="proportional to the error of the position and to that of the velocity",
    equation="demand = clip(feed_forward + gain (gain_p kp (command − q) "
    "+ gain_d kd (command_velocity − v)), ±limit)",
    coefficients=_PD_COEFFICIENTS,
    terms=_held,
    function=proportional,
    constants=_pd,
    commanded=True,
    takes_velocity=True,
    follows_velocity=True,
)

DAMPED = Part(
    name="damped",
    role="controller",
    doc="proportional to the error of the position, and braking by the velocity of the axis alone",
    equation="demand = clip(feed_forward + gain (gain_p kp (command − q) − gain_d kd v), ±limit)",
    coefficients=_PD_COEFFICIENTS,
    terms=_held,
    function=proportional,
    constants=_pd,
    commanded=True,
)

CASCADE = Part(
    name="cascade",
    role="controller",
    doc="a sampled loop of the position around one of the velocity (P-PI)",
    equation="demand = clip(feed_forward + e_v + ki ∫ e_v dt, ±limit), "
    "e_v = kv (kp (command − q) + command_velocity − v)",
    coefficients=(
        Coefficient("kp", "1/s", "gain of the position loop", lower=1e-2, upper=1e4, log=True,
                    symbol="K_v"),
        Coefficient("kv", "", f"gain of the velocity loop: {_ASKED}, per m/s (rad/s)",
                    lower=1e-3, upper=1e9, log=True, symbol="K_p"),
        Coefficient("ki", "1/s", "what it integrates of its demand: 1 over the reset time", 0.0),
        Coefficient("T", "s", "its sample time", 1e-3,
                    positive=True),
        Coefficient("difference", "", "1: its velocity is a difference over two samples", 0.0,
                    setting=True, choices=(0.0, 1.0)),
        replace(_SAMPLED[0], idle=1.0),
        _SAMPLED[1],
    ),
    terms=lambda values: {
        **_held(values), "k_i": values["ki"], "T": values["T"], "difference": values["difference"],
    },
    function=proportional,
    constants=lambda values: (values["kv"] * values["kp"], values["kv"]),
    commanded=True,
    takes_velocity=True,
)  # fmt: skip

PWM = Part(
    name="pwm",
    role="controller",
    doc="a hobby servo's: a share of the supply voltage for the error of the position",
    equation="demand = clip(feed_forward + vin duty kp (command − q), ±vin)",
    coefficients=(
        Coefficient("kp", "", "gain, in the servo's own counts", lower=1.0, upper=1e5, log=True,
                    positive=True),
        Coefficient("vin", "V", "supply voltage", lower=1.0, upper=100.0, positive=True),
        Coefficient("duty", "1/rad", "share of the supply voltage for an error of 1 at kp = 1",
                    lower=1e-5, upper=10.0, log=True),
    ),
    terms=lambda values: {"limit": values["vin"]},
    function=proportional,
    constants=lambda values: (values["vin"] * values["kp"] * values["duty"], 0.0),
    commanded=True,
    drive="voltage",
)  # fmt: skip

NONE = Part(
    name="none",
    role="controller",
    doc="no controller in the model: the log has the force, the current or the voltage",
    equation="demand as recorded",
    coefficients=(),
)
