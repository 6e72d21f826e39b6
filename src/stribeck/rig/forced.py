"""Any axis whose drive force was measured, linear or rotary."""

from __future__ import annotations

from ..space import Param
from .balanced import BalancedRig

#: Wide enough for a press and for a finger joint: least squares needs no narrow box.
_RANGES = {
    "F_S": (0.0, 1e6),
    "F_C": (0.0, 1e6),
    "F": (0.0, 1e6),
    "F_V": (0.0, 1e7),
    "v_SS": (1e-5, 1.0),
    "W": (0.0, 1e6),
}

FORCED = BalancedRig(
    name="forced",
    doc="any linear axis whose drive force was measured",
    cite="Newton's second law",
    params=(
        Param("M", 0.0, 1e6, "kg", "M", doc="moving mass"),
        Param("offset", -1e6, 1e6, "N", "F_0", doc="constant force: weight, sensor offset"),
    ),
    laws=(
        "coulomb-viscous",
        "coulomb-viscous-directional",
        "stribeck",
        "stribeck-directional",
    ),
    ranges=_RANGES,
    shows={
        "position": "mm",
        "velocity": "mm/s",
        "v_SS": "mm/s",
        "v_s": "mm/s",
        "v_first": "mm/s",
        "v_last": "mm/s",
        "d_1": "um",
    },
)

FORCED_ROTARY = BalancedRig(
    name="forced-rotary",
    doc="any rotary axis whose drive torque was measured",
    cite=FORCED.cite,
    params=(
        Param("M", 0.0, 1e6, "kg m**2", "J", doc="moment of inertia about the axis"),
        Param("offset", -1e6, 1e6, "N m", "T_0", doc="constant torque: sensor offset"),
    ),
    laws=FORCED.laws,
    ranges=_RANGES
    | {
        "v_SS": (1e-4, 10.0),
        "v_s": (1e-4, 10.0),
        "sigma_0": (1.0, 1e7),
        "sigma_1": (0.0, 1e4),
        "sigma": (0.0, 1e4),
        "d_1": (1e-7, 1e-2),
    },
    shows={
        "position": "deg",
        "velocity": "deg/s",
        "v_SS": "deg/s",
        "v_s": "deg/s",
        "v_first": "deg/s",
        "v_last": "deg/s",
        "d_1": "mrad",
    },
    labels={"M": "J"},
    rotary=True,
)
