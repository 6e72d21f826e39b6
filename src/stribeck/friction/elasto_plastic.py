"""The elasto-plastic law: LuGre's bristle, purely elastic up to a deflection of its own."""

from math import copysign, cos, exp, log, pi, sin

import numpy as np

from ..compile_cache import compiled
from ..space import Array, Param
from .law import Law, RigidLimit, rub_law
from .lugre import LUGRE, near_stribeck
from .lugre import starts as lugre_starts
from .stribeck import STRIBECK_GAUSS
from .yield_spectrum import Spectrum

#: What is left to the steady deflection below which the approach is known in closed form, as a
#: share of the plastic range, and the step of the quadrature until then, in its logarithm.
_NEAR, _STEP = 1e-3, 0.05
#: Where a search begins: the share of the Coulomb deflection that is purely elastic.
_ELASTIC = 0.3


@compiled()
def _approach(log_left: float, width: float) -> float:
    """How fast the logarithm of what is left falls per travel of one steady deflection."""
    remainder = exp(log_left)
    c = cos(0.5 * pi * remainder)
    s = sin(0.5 * pi * remainder)
    return s * s / (width * remainder) + c * c


@compiled()
def _deflected(u: float, elastic: float, x: float) -> float:
    """The deflection after a travel x forward, all in steady deflections."""
    if u < elastic:
        if u + x <= elastic:
            return u + x
        x -= elastic - u
        u = elastic
    if u >= 1.0:
        return 1.0 + (u - 1.0) * exp(-x)
    width = 1.0 - elastic
    log_left = log((1.0 - u) / width)
    while x > 0.0 and log_left > log(_NEAR):
        # Runge and Kutta's rule of order 4. The step follows the state smoothly, and so does z.
        k1 = _approach(log_left, width)
        h = min(_STEP / k1, x)
        k2 = _approach(log_left - 0.5 * h * k1, width)
        k3 = _approach(log_left - 0.5 * h * k2, width)
        k4 = _approach(log_left - h * k3, width)
        log_left -= h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0
        x -= h
    remainder = exp(log_left)
    # u' = 1 - u cos^2(pi left / 2) to third order: a logistic equation.
    approached = 1.0 - exp(-x)
    return 1.0 - width * remainder * (1.0 - approached) / (
        1.0 + 0.25 * pi * pi * remainder / width * approached
    )


def _rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    sigma_0, sigma_1, F_S, F_C, v_s, F_V = p[0], p[1], p[2], p[3], p[4], p[5]
    r = v / v_s
    level = F_C + (F_S - F_C) * exp(-r * r)
    if not level > 0.0:  # nothing rubs: no deflection lasts
        out[0] = z[0] if v * h == 0.0 else 0.0
        return sigma_0 * out[0] + F_V * v  # type: ignore[no-any-return]
    steady, elastic = copysign(level / sigma_0, v), p[6] * F_C / level
    u = z[0] / steady
    if v * h == 0.0:
        out[0] = z[0]
    else:
        x = abs(v) * h / abs(steady)
        # As an increment where the bristle only bends: nothing of a small step is rounded away.
        if u + x <= elastic:
            out[0] = z[0] + v * h
            u += x
        else:
            u = _deflected(u, elastic, x)
            out[0] = u * steady
    gives = 0.0
    if u >= 1.0:
        gives = 1.0
    elif u > elastic:
        c = cos(0.5 * pi * (1.0 - u) / (1.0 - elastic))
        gives = c * c
    return sigma_0 * out[0] + sigma_1 * v * (1.0 - gives * u) + F_V * v  # type: ignore[no-any-return]


def _starts(spectrum: Spectrum) -> Array:
    p = lugre_starts(spectrum)
    return np.column_stack([p, np.full(len(p), _ELASTIC)])


def _near_stribeck(p: Array) -> Array:
    bristles = near_stribeck(p)
    return np.column_stack([bristles, np.full(len(bristles), _ELASTIC)])


ELASTO_PLASTIC = Law(
    name="elasto-plastic",
    params=(
        *LUGRE.params,
        Param("elastic", 0.0, 0.95, "", "z_{ba}/z_{C}",
              doc="share of the Coulomb deflection F_C/sigma_0 that is purely elastic"),
    ),
    slip=LUGRE.slip,
    rub=rub_law(_rub),
    states=1,
    doc="LuGre without drift: below z_ba the bristle only bends, and holds a load for good",
    formula="F = σ_0 z + σ_1 z' + F_V v,  z' = v (1 − α σ_0 |z| / g(v)),  "
    "g = F_C + (F_S − F_C) exp(−(v/v_s)²),  α rises as a sine from 0 at z_ba = elastic F_C/σ_0 "
    "to 1 at g/σ_0; 0 while z and v point apart",
    cite="Dupont, Hayward, Armstrong, Altpeter (2002), doi 10.1109/TAC.2002.1000274",
    linear=("sigma_1", "F_V"),
    physical=lambda p: np.logical_and(LUGRE.physical(p[:, :6]), (p[:, 6] >= 0) & (p[:, 6] < 1)),
    starts=_starts,
    rigid_limit=RigidLimit(STRIBECK_GAUSS, _near_stribeck),
)  # fmt: skip
