"""Loads: what moves, and what acts on it beside the motor and friction."""

from __future__ import annotations

from math import cos, sin

from ..motion.part_call import STIFFNESS, Row
from .part import Coefficient, Part


def constant_force(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:
    """Less the force c[0]."""
    return force - c[0]


def gravity(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:
    """Less g_sin sin(q + q_offset) + g_cos cos(q + q_offset) + g_0, in this order in c."""
    s, o = sin(q + c[2]), cos(q + c[2])
    slope[STIFFNESS] += c[0] * o - c[1] * s
    return force - (c[0] * s + c[1] * o) - c[3]


def spring(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:
    """Less k_spring (q − q_spring), with both in c."""
    slope[STIFFNESS] += c[0]
    return force - c[0] * (q - c[1])


MASS = Part(
    name="mass",
    role="load",
    doc="a mass, or a moment of inertia, and a constant force",
    inertia={"M": "M"},
    forces={"offset": "− offset"},
    coefficients=(
        Coefficient("M", "kg", "moving mass", lower=1e-3, upper=1e4, log=True, symbol="M",
                    rotary="kg m**2", positive=True),
        Coefficient("offset", "N", "constant force: weight, sensor offset", 0.0, -1e4, 1e4,
                    rotary="N m", symbol="F_0"),
    ),
    terms=lambda values: {"M": values["M"]},
    function=constant_force,
    constants=lambda values: (values["offset"],),
)  # fmt: skip

INERTIA = Part(
    name="inertia",
    role="load",
    doc="a moment of inertia with gravity in any direction",
    inertia={"J": "J"},
    forces={"g_sin": "− g_sin sin q", "g_cos": "− g_cos cos q", "g_0": "− g_0"},
    coefficients=(
        Coefficient("J", "kg m**2", "moment of inertia about the axis", lower=1e-6, upper=1e4,
                    log=True, symbol="J", positive=True),
        Coefficient("g_sin", "N m", "gravity that goes with sin q", 0.0, -1e4, 1e4, symbol="g_s"),
        Coefficient("g_cos", "N m", "gravity that goes with cos q", 0.0, -1e4, 1e4, symbol="g_c"),
        Coefficient("g_0", "N m", "constant torque: sensor offset, cables", 0.0, -1e4, 1e4,
                    symbol="g_0"),
    ),
    terms=lambda values: {"M": values["J"]},
    function=gravity,
    constants=lambda values: (values["g_sin"], values["g_cos"], 0.0, values["g_0"]),
    rotary=True,
)  # fmt: skip

PENDULUM = Part(
    name="pendulum",
    role="load",
    doc="a weight at the end of a uniform arm",
    inertia={"m": "m l²", "m_arm": "m_arm l²/3"},
    forces={
        "m": "− m g l sin(q + q_offset)", "m_arm": "− m_arm g l/2 sin(q + q_offset)",
    },
    coefficients=(
        Coefficient("m", "kg", "mass at the end of the arm", lower=0.0, upper=1e3, least=0.0),
        Coefficient("l", "m", "its distance from the shaft", lower=1e-3, upper=10.0,
                    positive=True),
        Coefficient("m_arm", "kg", "mass of the arm itself, uniform", 0.0, 0.0, 1e3, least=0.0),
        Coefficient("q_offset", "rad", "minus the angle at which it hangs", 0.0, -3.2, 3.2,
                    symbol="q_0"),
        Coefficient("g", "m/s**2", "gravity", 9.80665),
    ),
    terms=lambda values: {"M": (values["m"] + values["m_arm"] / 3.0) * values["l"] ** 2},
    function=gravity,
    constants=lambda values: (
        (values["m"] + values["m_arm"] / 2.0) * values["g"] * values["l"], 0.0,
        values["q_offset"], 0.0,
    ),
    rotary=True,
)  # fmt: skip

SPRING = Part(
    name="spring",
    role="load",
    doc="a spring between the load and the frame",
    forces={"k_spring": "− k_spring (q − q_spring)"},
    coefficients=(
        Coefficient("k_spring", "N/m", "its stiffness", lower=1e-3, upper=1e9, log=True,
                    rotary="N m/rad", symbol="k"),
        Coefficient("q_spring", "m", "position at which it is relaxed", 0.0, -1e3, 1e3,
                    rotary="rad"),
    ),
    function=spring,
    constants=lambda values: (values["k_spring"], values["q_spring"]),
)  # fmt: skip
