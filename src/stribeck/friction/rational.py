"""The Stribeck curve as a rational function: its drop dies out as a power of the speed."""

from math import copysign

import numpy as np

from ..compile_cache import compiled
from ..space import Array, Param
from .law import Law, by_direction, slip_law
from .stribeck import STRIBECK


@compiled()
def _force(v: float, F_S: float, F_C: float, F_V: float, v_SS: float, exponent: float) -> float:
    r = abs(v) / v_SS
    r = r * r if exponent == 2.0 else r**exponent  # noqa: PLR2004 - a square is faster
    return copysign(1.0, v) * (F_C + (F_S - F_C) / (1.0 + r)) + F_V * v


def _slip(v: float, p: Array) -> float:
    return _force(v, p[0], p[1], p[2], p[3], p[4])  # type: ignore[no-any-return]


def _slip_directional(v: float, p: Array) -> float:
    i = 0 if copysign(1.0, v) > 0 else 4
    return _force(v, p[i], p[i + 1], p[i + 2], p[i + 3], p[8])  # type: ignore[no-any-return]


STRIBECK_RATIONAL = Law(
    name="stribeck-rational",
    params=(
        *STRIBECK.params[:4],
        Param("exponent", 0.5, 4.0, "", "a", fixed=2.0, doc="power at which the drop dies out"),
    ),
    slip=slip_law(_slip),
    doc="the Stribeck drop as a Lorentz curve: it dies out more slowly than an exponential",
    formula="F = [F_C + (F_S − F_C)/(1 + (|v|/v_SS)^exponent)] sgn v + F_V v",
    cite="Hess, Soom (1990), doi 10.1115/1.2920220; "
    "Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), doi 10.1016/0005-1098(94)90209-7",
    linear=("F_S", "F_C", "F_V"),
    physical=lambda p: (p[:, 0] >= p[:, 1]) & np.all(p >= 0, axis=1) & (p[:, 3] > 0),
)

STRIBECK_RATIONAL_DIRECTIONAL = by_direction(STRIBECK_RATIONAL, _slip_directional)
