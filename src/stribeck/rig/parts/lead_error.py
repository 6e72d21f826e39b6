"""The error of a screw's lead, or of a gear's teeth: a motor that is not where the load is."""

from __future__ import annotations

from math import cos, pi, sin

from ..motion.part_call import STIFFNESS, Row
from .part import Coefficient, Part


def uneven(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:
    """The position of the motor, q − a cos ω q − b sin ω q, and how fast it grows: ω, a, b = c."""
    s, o = sin(c[0] * q), cos(c[0] * q)
    slope[STIFFNESS] = 1.0 + c[0] * (c[1] * s - c[2] * o)
    return q - c[1] * o - c[2] * s


LEAD_ERROR = Part(
    name="lead-error",
    role="sensor",
    doc="an encoder at the motor, whose screw or gear gives way unevenly, before the load's own",
    equation="q_m = q − err_cos cos y − err_sin sin y, y = 2π q / err_period, v_m = v dq_m/dq",
    coefficients=(
        Coefficient("err_period", "m", "way after which the error repeats itself, as the lead",
                    lower=1e-4, upper=10.0, log=True, rotary="rad", positive=True),
        Coefficient("err_cos", "m", "its cosine", 0.0, -0.01, 0.01, rotary="rad"),
        Coefficient("err_sin", "m", "its sine", 0.0, -0.01, 0.01, rotary="rad"),
    ),
    function=uneven,
    constants=lambda values: (2.0 * pi / values["err_period"], values["err_cos"],
                              values["err_sin"]),
    slot="way",
)  # fmt: skip
