"""The Stribeck law: friction falls from its static level to Coulomb's as speed grows.

One curve, three laws: they differ in what is said of its exponent.
"""

from dataclasses import replace
from math import copysign, exp

import numpy as np

from ..space import Array, Param
from .law import Law, by_direction, slip_law


def _slip(v: float, p: Array) -> float:
    # Equation (4.2) with |v|/|v_SS|: the printed e^{-(v/v_SS)} would explode for v < 0.
    F_S, F_C, F_V, v_SS, exponent = p[0], p[1], p[2], p[3], p[4]
    r = abs(v) / v_SS
    if exponent != 1.0:
        r = r**exponent
    return copysign(1.0, v) * (F_C + (F_S - F_C) * exp(-r)) + F_V * v  # type: ignore[no-any-return]


def _slip_directional(v: float, p: Array) -> float:
    i = 0 if copysign(1.0, v) > 0 else 4
    F_S, F_C, F_V, v_SS, exponent = p[i], p[i + 1], p[i + 2], p[i + 3], p[8]
    r = abs(v) / v_SS
    if exponent != 1.0:
        r = r**exponent
    return copysign(1.0, v) * (F_C + (F_S - F_C) * exp(-r)) + F_V * v  # type: ignore[no-any-return]


STRIBECK = Law(
    name="stribeck",
    params=(
        Param("F_S", 0.0, 1000.0, "N", "F_S", doc="static friction"),
        Param("F_C", 0.0, 1000.0, "N", "F_C", doc="Coulomb friction"),
        Param("F_V", 0.0, 5000.0, "N s/m", "F_V", doc="viscous friction"),
        Param("v_SS", 1e-4, 1e-1, "m/s", "v_{SS}", log=True, doc="Stribeck (crossover) velocity"),
        Param("exponent", 0.5, 3.0, "", "\\delta", fixed=1.0, doc="Stribeck exponent"),
    ),
    slip=slip_law(_slip),
    doc="friction falls from F_S to F_C over the Stribeck velocity, then grows with speed",
    formula="F = [F_C + (F_S − F_C) exp(−(|v|/v_SS)^exponent)] sgn v + F_V v",
    cite="Sarasiri, Suthamno, Sujitjorn (2012), equation (4.2), doi 10.1155/2012/238563",
    linear=("F_S", "F_C", "F_V"),
    physical=lambda p: (p[:, 0] >= p[:, 1]) & np.all(p >= 0, axis=1) & (p[:, 3] > 0),
)

STRIBECK_DIRECTIONAL = by_direction(STRIBECK, _slip_directional)

STRIBECK_GAUSS = replace(
    STRIBECK,
    name="stribeck-gauss",
    params=(*STRIBECK.params[:4], replace(STRIBECK.params[4], fixed=2.0)),
    doc="the Stribeck drop as a bell curve: flat at rest, gone beyond twice v_SS",
    formula="F = [F_C + (F_S − F_C) exp(−(v/v_SS)²)] sgn v + F_V v",
    cite="Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), doi 10.1016/0005-1098(94)90209-7",
)

STRIBECK_GAUSS_DIRECTIONAL = by_direction(STRIBECK_GAUSS, _slip_directional)

STRIBECK_FREE = replace(
    STRIBECK,
    name="stribeck-free",
    params=(*STRIBECK.params[:4], replace(STRIBECK.params[4], fixed=None)),
    doc="the Stribeck drop with an exponent to be found",
    cite="Bo, Pavelescu (1982), doi 10.1016/0043-1648(82)90223-X",
)

STRIBECK_FREE_DIRECTIONAL = by_direction(
    STRIBECK_FREE, _slip_directional, split_names=("F_S", "F_C", "F_V", "v_SS")
)
