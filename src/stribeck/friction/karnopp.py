"""Karnopp's law: static friction within a band of speeds, Coulomb and viscous beyond."""

from math import copysign

import numpy as np

from ..compile_cache import compiled
from ..space import Array, Param
from .law import Law, by_direction, slip_law


@compiled()
def _force(v: float, F_S: float, F_C: float, F_V: float, dv: float) -> float:
    s = copysign(1.0, v)
    return s * F_S if abs(v) < dv else s * F_C + F_V * v


def _slip(v: float, p: Array) -> float:
    return _force(v, p[0], p[1], p[2], p[3])  # type: ignore[no-any-return]


def _slip_directional(v: float, p: Array) -> float:
    i = 0 if copysign(1.0, v) > 0 else 3
    return _force(v, p[i], p[i + 1], p[i + 2], p[6])  # type: ignore[no-any-return]


KARNOPP = Law(
    name="karnopp",
    params=(
        Param("F_S", 0.0, 1000.0, "N", "F_S", doc="static friction"),
        Param("F_C", 0.0, 1000.0, "N", "F_C", doc="Coulomb friction"),
        Param("F_V", 0.0, 5000.0, "N s/m", "F_V", doc="viscous friction"),
        Param("dv", 1e-6, 1e-1, "m/s", "\\Delta v", log=True, fixed=1e-4,
              doc="half-width of the band in which it counts as stuck"),
    ),
    slip=slip_law(_slip),
    doc="F_S within a band of speeds about rest, Coulomb and viscous friction beyond",
    formula="F = F_S sgn v for |v| < dv, else F_C sgn v + F_V v",
    cite="D. Karnopp (1985), doi 10.1115/1.3140698",
    linear=("F_S", "F_C", "F_V"),
    physical=lambda p: (p[:, 0] >= p[:, 1]) & np.all(p >= 0, axis=1) & (p[:, 3] > 0),
)  # fmt: skip

KARNOPP_DIRECTIONAL = by_direction(KARNOPP, _slip_directional)
