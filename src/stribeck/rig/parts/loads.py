"""Loads: what moves, and what acts on it beside the motor and friction."""

from __future__ import annotations

from .part import Coefficient, Part

MASS = Part(
    name="mass",
    role="load",
    doc="a mass, or a moment of inertia, and a constant force",
    equation="M a = F − offset − F_f",
    coefficients=(
        Coefficient("M", "kg", "moving mass", lower=1e-3, upper=1e4, log=True, symbol="M",
                    rotary="kg m**2", positive=True),
        Coefficient("offset", "N", "constant force: weight, sensor offset", 0.0, -1e4, 1e4,
                    rotary="N m", symbol="F_0"),
    ),
    terms=lambda values: {"M": values["M"], "g_0": values["offset"]},
)  # fmt: skip

INERTIA = Part(
    name="inertia",
    role="load",
    doc="a moment of inertia with gravity in any direction",
    equation="J a = F − g_sin sin q − g_cos cos q − g_0 − F_f",
    coefficients=(
        Coefficient("J", "kg m**2", "moment of inertia about the axis", lower=1e-6, upper=1e4,
                    log=True, symbol="J", positive=True),
        Coefficient("g_sin", "N m", "gravity that goes with sin q", 0.0, -1e4, 1e4, symbol="g_s"),
        Coefficient("g_cos", "N m", "gravity that goes with cos q", 0.0, -1e4, 1e4, symbol="g_c"),
        Coefficient("g_0", "N m", "constant torque: sensor offset, cables", 0.0, -1e4, 1e4,
                    symbol="g_0"),
    ),
    terms=lambda values: {
        "M": values["J"], "g_sin": values["g_sin"], "g_cos": values["g_cos"],
        "g_0": values["g_0"],
    },
    rotary=True,
)  # fmt: skip

PENDULUM = Part(
    name="pendulum",
    role="load",
    doc="a weight at the end of a uniform arm",
    equation="(m l² + m_arm l²/3) a = F − (m + m_arm/2) g l sin(q + q_offset) − F_f",
    coefficients=(
        Coefficient("m", "kg", "mass at the end of the arm", lower=0.0, upper=1e3),
        Coefficient("l", "m", "its distance from the shaft", lower=1e-3, upper=10.0,
                    positive=True),
        Coefficient("m_arm", "kg", "mass of the arm itself, uniform", 0.0, 0.0, 1e3),
        Coefficient("q_offset", "rad", "minus the angle at which it hangs", 0.0, -3.2, 3.2,
                    symbol="q_0"),
        Coefficient("g", "m/s**2", "gravity", 9.80665),
    ),
    terms=lambda values: {
        "M": (values["m"] + values["m_arm"] / 3.0) * values["l"] ** 2,
        "g_sin": (values["m"] + values["m_arm"] / 2.0) * values["g"] * values["l"],
        "q_offset": values["q_offset"],
    },
    rotary=True,
)  # fmt: skip

SPRING = Part(
    name="spring",
    role="load",
    doc="a spring between the load and the frame",
    equation="− k_spring (q − q_spring)",
    coefficients=(
        Coefficient("k_spring", "N/m", "its stiffness", lower=1e-3, upper=1e9, log=True,
                    rotary="N m/rad", symbol="k"),
        Coefficient("q_spring", "m", "position at which it is relaxed", 0.0, -1e3, 1e3,
                    rotary="rad"),
    ),
    terms=lambda values: {"spring": values["k_spring"], "q_spring": values["q_spring"]},
)  # fmt: skip
