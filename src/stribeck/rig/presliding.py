"""An axis under a measured force below breakaway: M dv/dt = F − offset − F_f.

Bristles remember, so a motion is simulated from the start of its log; and what a first load has
left behind shifts all that follows, so positions are compared up to a constant.
"""

from __future__ import annotations

from typing import Any

from .composed import ComposedRig, settings
from .parts import Part, part_named

_LAWS = ("lugre", "dahl", "elasto-plastic", "maxwell-slip", "gms", "gms-damped")


_MASS = part_named("load", "mass")


def _parts(mass: tuple[float, float], offset: float) -> tuple[Part, ...]:
    """A mass under the measured force, with the ranges of both of its coefficients."""
    return (
        part_named("controller", "none"),
        part_named("motor", "force"),
        part_named("transmission", "rigid"),
        _MASS.with_coefficients(
            _MASS["M"].searched(*mass), _MASS["offset"].searched(-offset, offset)
        ),
    )


_COMMON: dict[str, Any] = {
    "cite": "Newton's second law",
    "scale": "the measured force",
    "laws": _LAWS,
    "history": True,
    "floating": True,
    "overtravel": 20.0,
}

PRESLIDING = ComposedRig.compose(
    name="presliding",
    rotary=False,
    doc="a linear axis under a measured force: ramps and sines below breakaway",
    parts=_parts((1e-3, 1e4), 100.0),
    constants=settings("um"),
    shows={"position": "um", "velocity": "mm/s"},
    **_COMMON,
)

PRESLIDING_ROTARY = ComposedRig.compose(
    name="presliding-rotary",
    rotary=True,
    doc="a rotary axis under a measured torque: ramps and sines below breakaway",
    parts=_parts((1e-5, 100.0), 10.0),
    constants=settings("urad"),
    ranges={
        "sigma_0": (1.0, 1e7),
        "sigma_1": (0.0, 1e4),
        "sigma": (0.0, 1e4),
        "F_S": (0.0, 100.0),
        "F_C": (0.0, 100.0),
        "F": (0.0, 100.0),
        "F_V": (1e-3, 1e4),
        "v_s": (1e-4, 10.0),
        "W": (1e-3, 100.0),
        "d_1": (1e-7, 1e-2),
    },
    shows={"position": "mrad", "velocity": "mrad/s"},
    labels={"M": "J"},
    **_COMMON,
)
