"""Armstrong's seven parameters: static friction that rises with rest, and friction that lags.

A contact at rest grows together: the longer it rests, the more it takes to break away, up to F_S.
And friction follows the speed late. As published the lag is a delay of the speed; here it is a
first-order lag of the drop, which no history of speeds is kept for.
"""

from itertools import product
from math import copysign, exp

import numpy as np

from ..compile_cache import compiled
from ..space import Array, Param
from .law import Law, rub_law, slip_law
from .yield_spectrum import Spectrum

#: Up to this share of v_s the contact is at rest.
_REST = 0.1
#: Times of rest and of lag where a search begins, s.
_RESTS, _LAGS = (0.1, 1.0, 10.0), (3e-3, 3e-2)


@compiled(forceinline=True)
def _share(v: float, v_s: float) -> float:
    """The share of the drop that is left at a speed: 1 at rest."""
    r = max(abs(v) / v_s - _REST, 0.0)
    return 1.0 / (1.0 + r * r)


def _slip(v: float, p: Array) -> float:
    F_S, F_C, v_s, F_V = p[1], p[2], p[3], p[4]
    return copysign(1.0, v) * (F_C + (F_S - F_C) * _share(v, v_s)) + F_V * v  # type: ignore[no-any-return]


def _rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    # States: the spring; what is missing of the drop now, and of the drop that this slide began
    # with, as shares; and the time of rest, 0 in a slide. All 0: relaxed, after a long rest.
    sigma_0, F_S, F_C, v_s, F_V, gamma, tau_L = p[0], p[1], p[2], p[3], p[4], p[5], p[6]
    out[0], out[1], out[2], out[3] = z[0], z[1], z[2], z[3]
    if h != 0.0:
        if abs(v) <= _REST * v_s:  # what a slide has left of the drop is what the rise begins with
            out[1] *= (gamma + z[3]) / (gamma + z[3] + h)
            out[2] = out[1]
            out[3] += h
        else:
            steady = 1.0 - (1.0 - z[2]) * _share(v, v_s)
            out[1] = steady + (z[1] - steady) * exp(-h / tau_L)
            out[3] = 0.0
        level = F_C + (F_S - F_C) * (1.0 - out[1])
        if v != 0.0:
            s = copysign(1.0, v)
            out[0] = s * min(s * z[0] + abs(v) * h, level / sigma_0)
    return sigma_0 * out[0] + F_V * v  # type: ignore[no-any-return]


def starts(spectrum: Spectrum) -> Array:
    """Levels about that of the spectrum, its drop at one of the speeds, rests of all sizes."""
    level = spectrum.level
    stiff = (spectrum.stiffness, level / spectrum.way)
    return np.array([
        [k, 1.3 * level, 0.9 * level, v_s, 0.0, rest, lag]
        for k, v_s, rest, lag in product(stiff, spectrum.speeds, _RESTS, _LAGS)
    ])  # fmt: skip


ARMSTRONG = Law(
    name="armstrong",
    params=(
        Param("sigma_0", 1e3, 1e9, "N/m", "\\sigma_0", log=True, doc="stiffness before a slide"),
        Param("F_S", 0.0, 1000.0, "N", "F_{S,\\infty}", doc="static friction after a long rest"),
        Param("F_C", 0.0, 1000.0, "N", "F_C", doc="Coulomb friction"),
        Param("v_s", 1e-4, 1e-1, "m/s", "v_s", log=True, doc="Stribeck velocity"),
        Param("F_V", 0.0, 5000.0, "N s/m", "F_V", doc="viscous friction"),
        Param("gamma", 1e-3, 1e3, "s", "\\gamma", log=True,
              doc="rest in which half of the static friction is regained"),
        Param("tau_L", 1e-4, 1.0, "s", "\\tau_L", log=True, doc="lag of friction after the speed"),
    ),
    slip=slip_law(_slip),
    rub=rub_law(_rub),
    states=4,
    doc="Armstrong's seven parameters: breakaway that rises with rest, and frictional lag",
    formula="F = σ_0 z + F_V v,  z' = v while |σ_0 z| < g = F_C + s (F_S − F_C),  "
    "sliding: s' = (s_0/(1 + r²) − s)/tau_L,  r = |v|/v_s − 0.1, from s_0 at its beginning,  "
    "at rest (r < 0) for a time t: s = s_a + (1 − s_a) t/(t + gamma), from s_a at its end",
    cite="Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), doi 10.1016/0005-1098(94)90209-7",
    linear=("F_V",),
    physical=lambda p: (
        (p[:, 1] >= p[:, 2]) & np.all(p >= 0, axis=1) & np.all(p[:, [0, 3, 5, 6]] > 0, axis=1)
    ),
    starts=starts,
    rests=True,
)  # fmt: skip
