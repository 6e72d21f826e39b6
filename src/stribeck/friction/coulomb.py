"""Coulomb friction with a viscous term."""

from math import copysign

import numpy as np

from ..space import Array, Param
from .law import Law, by_direction, slip_law


def _slip(v: float, p: Array) -> float:
    F_C, F_V = p[0], p[1]
    return copysign(1.0, v) * F_C + F_V * v  # type: ignore[no-any-return]


def _slip_directional(v: float, p: Array) -> float:
    if copysign(1.0, v) > 0:
        return p[0] + p[1] * v  # type: ignore[no-any-return]
    return -p[2] + p[3] * v  # type: ignore[no-any-return]


COULOMB_VISCOUS = Law(
    name="coulomb-viscous",
    params=(
        Param("F_C", 0.0, 1000.0, "N", "F_C", doc="Coulomb friction"),
        Param("F_V", 0.0, 5000.0, "N s/m", "F_V", doc="viscous friction"),
    ),
    slip=slip_law(_slip),
    doc="a constant level and a term that grows with speed",
    formula="F = F_C sgn v + F_V v",
    cite="C. A. Coulomb (1785); O. Reynolds (1886)",
    linear=("F_C", "F_V"),
    physical=lambda p: np.all(p >= 0, axis=1),
)

COULOMB_VISCOUS_DIRECTIONAL = by_direction(COULOMB_VISCOUS, _slip_directional)
