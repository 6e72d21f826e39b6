"""LuGre's law on a film of lubricant that builds up and drains late, as under a cylinder's seals.

The level that the bristles slide at falls as the film grows. The film follows the speed with a lag,
longer or shorter as it builds up or drains, so that friction at a speed that swings is higher on
the way up than on the way down.
"""

from itertools import product
from math import copysign, exp, expm1, log

import numpy as np

from ..compile_cache import compiled
from ..space import Array, Param
from .law import Law, rub_law, slip_law
from .lugre import LUGRE
from .lugre import starts as lugre_starts
from .yield_spectrum import Spectrum

#: The film grows with the speed to this power.
_POWER = 2.0 / 3.0
#: A span in which the film moves by no more than this share of its lag is passed in one part,
#: longer ones in so many, over each of which it moves as much.
_SHORT, _PARTS = 0.05, 16
#: A bristle that falls into its deflection at a greater rate than this, 1/s, is there at once.
_QUICKEST = 1e200
#: Where a search begins: lags of the film, s, and speeds at which it is whole, as multiples of v_s.
_LAGS, _WHOLE = (0.02, 0.2), (2.0, 10.0)


@compiled(forceinline=True)
def _steady_film(v: float, F_S: float, F_C: float, v_b: float) -> float:
    """The film in steady sliding: the share of F_S that it carries, up to 1 - F_C/F_S."""
    return max(1.0 - F_C / max(F_S, 1e-300), 0.0) * min(abs(v) / v_b, 1.0) ** _POWER  # type: ignore[no-any-return]


@compiled(forceinline=True)
def _level(v: float, film: float, F_S: float, F_C: float, v_s: float) -> float:
    """What the bristles slide at."""
    r = v / v_s
    return F_C + ((1.0 - film) * F_S - F_C) * exp(-r * r)


def _slip(v: float, p: Array) -> float:
    F_S, F_C, v_s, F_V, v_b = p[2], p[3], p[4], p[5], p[6]
    film = _steady_film(v, F_S, F_C, v_b)
    return copysign(1.0, v) * _level(v, film, F_S, F_C, v_s) + F_V * v  # type: ignore[no-any-return]


def _rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    # States: the deflection and the film. The film goes into its steady value exponentially; over
    # a part of the span the bristle does the same at the film of its middle.
    sigma_0, sigma_1, F_S, F_C, v_s, F_V, v_b = p[0], p[1], p[2], p[3], p[4], p[5], p[6]
    steady = _steady_film(v, F_S, F_C, v_b)
    lag = p[7] if steady >= z[1] else p[8]
    off = z[1] - steady
    passed = h / lag
    parts = 1 if passed <= _SHORT else _PARTS
    bent, left, before = z[0], exp(-passed), 0.0
    for k in range(parts):
        # The film is off its steady value by as much less in each part, and the last is the rest.
        after = passed
        if k + 1 < parts:
            after = -log(1.0 - (1.0 - left) * (k + 1.0) / parts)
        film = steady + off * exp(-0.5 * (before + after))
        level = _level(v, film, F_S, F_C, v_s)
        span = (after - before) * lag
        before = after
        if level * _QUICKEST > sigma_0 * abs(v):
            rate = sigma_0 * abs(v) / level
            bent += (copysign(level / sigma_0, v) - bent) * -expm1(-rate * span)
        elif v * h != 0.0:  # next to nothing rubs: no deflection lasts
            bent = 0.0
    out[0] = z[0] if v * h == 0.0 else bent
    out[1] = z[1] if h == 0.0 else steady + off * left
    level = _level(v, out[1], F_S, F_C, v_s)
    bending = 0.0
    if level * _QUICKEST > sigma_0 * abs(v):
        bending = v - sigma_0 * abs(v) * out[0] / level
    return sigma_0 * out[0] + sigma_1 * bending + F_V * v  # type: ignore[no-any-return]


def starts(spectrum: Spectrum) -> Array:
    """Those of LuGre's law, with films that are whole at some speeds and lag by some times."""
    return np.array([
        [*p, many * p[4], lag, lag]
        for p, many, lag in product(lugre_starts(spectrum), _WHOLE, _LAGS)
    ])  # fmt: skip


LUGRE_FILM = Law(
    name="lugre-film",
    params=(
        *LUGRE.params,
        Param("v_b", 1e-3, 1.0, "m/s", "v_b", log=True, doc="speed from which the film is whole"),
        Param("tau_p", 1e-4, 10.0, "s", "\\tau_{hp}", log=True, doc="lag of a film that builds up"),
        Param("tau_n", 1e-4, 10.0, "s", "\\tau_{hn}", log=True, doc="lag of a film that drains"),
    ),
    slip=slip_law(_slip),
    rub=rub_law(_rub),
    states=2,
    doc="LuGre's bristles on a film of lubricant that follows the speed late, as under seals",
    formula="F = σ_0 z + σ_1 z' + F_V v,  z' = v − σ_0 |v| z / g,  "
    "g = F_C + ((1 − h) F_S − F_C) exp(−(v/v_s)²),  h' = (h_ss − h)/tau_p, or /tau_n where h > "
    "h_ss,  h_ss = (1 − F_C/F_S) min(|v|/v_b, 1)^(2/3)",
    cite="Yanada, Sekikawa (2008), Mechatronics 18; Tran, Yanada (2013), doi "
    "10.4236/ica.2013.42022",
    linear=("sigma_1", "F_V"),
    physical=lambda p: (
        (p[:, 2] >= p[:, 3])
        & np.all(p >= 0, axis=1)
        & (p[:, 0] > 0)
        & np.all(p[:, [4, 6, 7, 8]] > 0, axis=1)
    ),
    starts=starts,
)
