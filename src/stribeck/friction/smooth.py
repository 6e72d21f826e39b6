"""A Stribeck curve without a jump at rest, as simulators of block diagrams have it."""

from math import copysign, e, exp, sqrt, tanh

import numpy as np

from ..compile_cache import compiled
from ..space import Array, Param
from .law import Law, RigidLimit, by_direction, slip_law
from .stribeck import STRIBECK, STRIBECK_DIRECTIONAL

#: The speed scale of the Stribeck peak and of Coulomb's tanh, over the break-away velocity.
_PEAK, _TURN = sqrt(2.0), 0.1
#: Sets near a Stribeck law: break-away velocities over that law's Stribeck velocity.
_BREAKS = (10.0, 1.0, 0.1)


@compiled()
def _force(v: float, F_S: float, F_C: float, F_V: float, v_brk: float) -> float:
    r = v / (_PEAK * v_brk)
    return sqrt(2.0 * e) * (F_S - F_C) * exp(-r * r) * r + F_C * tanh(v / (_TURN * v_brk)) + F_V * v


def _slip(v: float, p: Array) -> float:
    return _force(v, p[0], p[1], p[2], p[3])  # type: ignore[no-any-return]


def _slip_directional(v: float, p: Array) -> float:
    i = 0 if copysign(1.0, v) > 0 else 4
    return _force(v, p[i], p[i + 1], p[i + 2], p[i + 3])  # type: ignore[no-any-return]


def _near_stribeck(p: Array) -> Array:
    """Sets with the same levels, (n, 4)."""
    F_S, F_C, F_V, v_SS = p[:4]
    return np.array([[F_S, F_C, F_V, v_SS * ratio] for ratio in _BREAKS])


STRIBECK_SMOOTH = Law(
    name="stribeck-smooth",
    params=(
        *STRIBECK.params[:3],
        Param(
            "v_brk", 1e-5, 1e-1, "m/s", "v_{brk}", log=True, doc="speed of the greatest friction"
        ),
    ),
    slip=slip_law(_slip),
    doc="a Stribeck curve that is smooth through rest: its level there is 0, so it never sticks",
    formula="F = √(2e) (F_S − F_C) exp(−(v/v_St)²) v/v_St + F_C tanh(v/v_C) + F_V v,  "
    "v_St = √2 v_brk,  v_C = v_brk/10",
    cite="Simscape, Translational Friction block (MathWorks)",
    linear=("F_S", "F_C", "F_V"),
    physical=lambda p: (p[:, 0] >= p[:, 1]) & np.all(p >= 0, axis=1) & (p[:, 3] > 0),
    rigid_limit=RigidLimit(STRIBECK, _near_stribeck),
)

STRIBECK_SMOOTH_DIRECTIONAL = by_direction(
    STRIBECK_SMOOTH, _slip_directional, limit=STRIBECK_DIRECTIONAL
)
