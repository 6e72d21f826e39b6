"""The six-parameter law of Makkar and others: differentiable, made of hyperbolic tangents."""

from itertools import product
from math import atanh, copysign, log, tanh

import numpy as np

from ..compile_cache import compiled
from ..space import Array, Param
from .law import Law, RigidLimit, by_direction, slip_law
from .stribeck import STRIBECK, STRIBECK_DIRECTIONAL

#: Half of the drop is left where 1 - tanh g3 v is a half, and of Stribeck's at v_SS ln 2: g3 v_SS.
_HALF = atanh(0.5) / log(2.0)
#: Sets near a Stribeck law: its velocities over that law's, and g2 and g5 over g3.
_SLOWER, _STEEPER = (1.0, 10.0), (10.0, 100.0, 1000.0)


@compiled()
def _force(v: float, g1: float, g2: float, g3: float, g4: float, g5: float, g6: float) -> float:
    return g1 * (tanh(g2 * v) - tanh(g3 * v)) + g4 * tanh(g5 * v) + g6 * v


def _slip(v: float, p: Array) -> float:
    return _force(v, p[0], p[1], p[2], p[3], p[4], p[5])  # type: ignore[no-any-return]


def _slip_directional(v: float, p: Array) -> float:
    i = 0 if copysign(1.0, v) > 0 else 6
    return _force(v, p[i], p[i + 1], p[i + 2], p[i + 3], p[i + 4], p[i + 5])  # type: ignore[no-any-return]


def _near_stribeck(p: Array) -> Array:
    """Sets whose drop is half gone at the same speed, or at a greater one, (n, 6)."""
    F_S, F_C, F_V, v_SS = p[:4]
    falls = [(_HALF / (v_SS * slower), ratio) for slower, ratio in product(_SLOWER, _STEEPER)]
    return np.array([[F_S - F_C, k * g3, g3, F_C, k * g3, F_V] for g3, k in falls])


MAKKAR = Law(
    name="makkar",
    params=(
        Param("g1", 0.0, 1000.0, "N", "\\gamma_1", doc="height of the Stribeck drop, F_S − F_C"),
        Param("g2", 1e2, 1e6, "s/m", "\\gamma_2", log=True, doc="slope of its rise from rest"),
        Param("g3", 1.0, 1e4, "s/m", "\\gamma_3", log=True, doc="slope of its fall, below g2"),
        Param("g4", 0.0, 1000.0, "N", "\\gamma_4", doc="Coulomb friction"),
        Param("g5", 1e2, 1e6, "s/m", "\\gamma_5", log=True, doc="slope of Coulomb's rise"),
        Param("g6", 0.0, 5000.0, "N s/m", "\\gamma_6", doc="viscous friction"),
    ),
    slip=slip_law(_slip),
    doc="drop, Coulomb and viscous friction, smooth through rest: it never sticks",
    formula="F = g1 (tanh g2 v − tanh g3 v) + g4 tanh g5 v + g6 v",
    cite="Makkar, Dixon, Sawyer, Hu (2005), doi 10.1109/AIM.2005.1511048",
    linear=("g1", "g4", "g6"),
    physical=lambda p: np.all(p >= 0, axis=1) & (p[:, 1] >= p[:, 2]),
    rigid_limit=RigidLimit(STRIBECK, _near_stribeck),
)

MAKKAR_DIRECTIONAL = by_direction(MAKKAR, _slip_directional, limit=STRIBECK_DIRECTIONAL)
