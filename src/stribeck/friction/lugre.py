"""The LuGre law: contact as a brush of bristles that bend, and slip as they give way."""

from itertools import product
from math import copysign, exp, expm1

import numpy as np

from ..space import Array, Param
from .law import Law, RigidLimit, rub_law, slip_law
from .stribeck import STRIBECK_GAUSS
from .yield_spectrum import Spectrum

#: A bristle that falls into its deflection at a greater rate than this, 1/s, is there at once.
_QUICKEST = 1e200
#: Sets near a rigid law: Stribeck velocities over that law's, and times, s, in which an axis moves
#: at that velocity by the deflection at which the bristles break away.
_FASTER, _TIMES = (1.0, 10.0), (0.1, 0.01, 0.001)


def _slip(v: float, p: Array) -> float:
    F_S, F_C, v_s, F_V = p[2], p[3], p[4], p[5]
    r = v / v_s
    return copysign(1.0, v) * (F_C + (F_S - F_C) * exp(-r * r)) + F_V * v  # type: ignore[no-any-return]


def _rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    # At constant v the bristle falls into its steady deflection exponentially: z' = rate (z_ss - z)
    sigma_0, sigma_1, F_S, F_C, v_s, F_V = p[0], p[1], p[2], p[3], p[4], p[5]
    r = v / v_s
    level = F_C + (F_S - F_C) * exp(-r * r)
    # Next to nothing rubs, so that a rate would not be a number: no deflection lasts.
    if not level * _QUICKEST > sigma_0 * abs(v):
        out[0] = z[0] if v * h == 0.0 else 0.0
        return sigma_0 * out[0] + F_V * v  # type: ignore[no-any-return]
    rate = sigma_0 * abs(v) / level
    gap = copysign(level / sigma_0, v) - z[0]
    share = -expm1(-rate * h)
    out[0] = z[0] + gap * share
    return sigma_0 * out[0] + sigma_1 * rate * gap * (1.0 - share) + F_V * v  # type: ignore[no-any-return]


def starts(spectrum: Spectrum) -> Array:
    """Levels about that of the spectrum, its drop at one of the speeds."""
    level = spectrum.level
    return np.array([
        [k, 0.0, 1.1 * level, 0.9 * level, v_s, 0.0]
        for k, v_s in product((spectrum.stiffness, level / spectrum.way), spectrum.speeds)
    ])  # fmt: skip


def near_stribeck(p: Array) -> Array:
    """Sets with the same levels, without damping, (n, 6)."""
    F_S, F_C, F_V, v_SS = p[:4]
    ways = [(v_SS * faster, v_SS * faster * T) for faster, T in product(_FASTER, _TIMES)]
    return np.array([[max(F_S, F_C) / way, 0.0, F_S, F_C, v_s, F_V] for v_s, way in ways])


LUGRE = Law(
    name="lugre",
    params=(
        Param("sigma_0", 1e3, 1e9, "N/m", "\\sigma_0", log=True, doc="stiffness of the bristles"),
        Param("sigma_1", 0.0, 1e5, "N s/m", "\\sigma_1", doc="damping of the bristles"),
        Param("F_S", 0.0, 1000.0, "N", "F_S", doc="static friction"),
        Param("F_C", 0.0, 1000.0, "N", "F_C", doc="Coulomb friction"),
        Param("v_s", 1e-4, 1e-1, "m/s", "v_s", log=True, doc="Stribeck velocity"),
        Param("F_V", 0.0, 5000.0, "N s/m", "F_V", doc="viscous friction"),
    ),
    slip=slip_law(_slip),
    rub=rub_law(_rub),
    states=1,
    doc="bristles bend before they slip: presliding, break-away and Stribeck in one state",
    formula="F = σ_0 z + σ_1 z' + F_V v,  z' = v − σ_0 |v| z / g(v),  "
    "g = F_C + (F_S − F_C) exp(−(v/v_s)²)",
    cite="Canudas de Wit, Olsson, Åström, Lischinsky (1995), doi 10.1109/9.376053",
    linear=("sigma_1", "F_V"),
    physical=lambda p: (
        (p[:, 2] >= p[:, 3]) & np.all(p >= 0, axis=1) & (p[:, 0] > 0) & (p[:, 4] > 0)
    ),
    starts=starts,
    rigid_limit=RigidLimit(STRIBECK_GAUSS, near_stribeck),
)
