"""Ripple: forces that go with the position, of cogging, teeth, balls and magnets."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, pi, sin
from typing import Any

from ..motion.part_call import STIFFNESS, Row
from .part import Coefficient, Part


def waves(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:
    """Less a_1 cos ω q + b_1 sin ω q + a_2 cos 2 ω q + b_2 sin 2 ω q: ω and these four in c."""
    turn = c[0] * q
    s, o, s_2, o_2 = sin(turn), cos(turn), sin(2.0 * turn), cos(2.0 * turn)
    slope[STIFFNESS] += c[0] * (c[2] * o - c[1] * s + 2.0 * (c[4] * o_2 - c[3] * s_2))
    return force - c[1] * o - c[2] * s - c[3] * o_2 - c[4] * s_2


def _amplitude(name: str, doc: str, *, at_motor: bool = False) -> Coefficient:
    """An amplitude that is 0 where nobody speaks of it."""
    return Coefficient(name, "N", doc, 0.0, -1e4, 1e4, rotary="N m", at_motor=at_motor)


RIPPLE = Part(
    name="ripple",
    role="load",
    doc="a force that repeats itself over the position of the load, with its second harmonic",
    equation="x = 2π q / rip_period",
    forces={
        "rip_cos": "− rip_cos cos x", "rip_sin": "− rip_sin sin x",
        "rip_cos2": "− rip_cos2 cos 2x", "rip_sin2": "− rip_sin2 sin 2x",
    },
    coefficients=(
        Coefficient("rip_period", "m", "way after which it repeats itself", lower=1e-4, upper=10.0,
                    log=True, rotary="rad", positive=True),
        _amplitude("rip_cos", "its cosine"),
        _amplitude("rip_sin", "its sine"),
        _amplitude("rip_cos2", "cosine of half the period"),
        _amplitude("rip_sin2", "sine of half the period"),
    ),
    function=waves,
    constants=lambda values: (
        2.0 * pi / values["rip_period"], values["rip_cos"], values["rip_sin"],
        values["rip_cos2"], values["rip_sin2"],
    ),
    wave=("rip_period", "rip_cos", "rip_sin"),
)  # fmt: skip


def _cogging(values: Mapping[str, Any]) -> tuple[Any, ...]:
    """A torque of the motor as a force at the load: n times, n order periods a radian."""
    n = values["ratio"]
    return n * values["cog_order"], n * values["cog_cos"], n * values["cog_sin"], 0.0, 0.0


MOTOR_RIPPLE = Part(
    name="motor-ripple",
    role="load",
    doc="cogging of the motor: a torque that repeats itself so many times in each of its turns",
    forces={
        "cog_cos": "− n cog_cos cos(cog_order n q)", "cog_sin": "− n cog_sin sin(cog_order n q)",
    },
    coefficients=(
        Coefficient("cog_order", "", "periods in a turn of the motor (in 2π m of a linear one)",
                    lower=1.0, upper=1000.0, log=True, positive=True),
        _amplitude("cog_cos", "its cosine, at the motor", at_motor=True),
        _amplitude("cog_sin", "its sine, at the motor", at_motor=True),
    ),
    function=waves,
    constants=_cogging,
    wave=("cog_order", "cog_cos", "cog_sin"),
    of_motor=True,
)  # fmt: skip
