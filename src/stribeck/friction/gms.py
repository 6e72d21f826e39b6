"""The generalised Maxwell-slip law: Maxwell elements whose levels fall and lag as they slide.

With damping, an element that sticks resists the speed of its bending, too.
"""

from functools import cache, partial
from itertools import product
from math import copysign, exp
from typing import Any

import numpy as np

from ..compile_cache import compiled
from ..space import Array, Param
from .law import Law, rub_law, slip_law
from .maxwell import ELEMENTS, VISCOUS, elements, starts_of
from .yield_spectrum import Spectrum

#: Where a search begins: Coulomb levels as shares of the mean friction, and lags, s.
_DROPPED, _LAGS = 0.9, (3e-3, 3e-2)


@compiled(forceinline=True)
def _sliding_time(
    z: float, slides: float, v: float, h: float, level: float, distance: float
) -> float:
    """For how long of a span of h seconds an element slides, s; -1 where it sticks to its end."""
    s = copysign(1.0, v)
    if v == 0.0:
        return -1.0
    if s * z > 0.0 and slides > 0.5:  # noqa: PLR2004
        return h
    gap = max(level - s * z, 0.0) * distance
    return h - gap / abs(v) if abs(v) * h > gap else -1.0


@compiled(forceinline=True)
def _share_after(
    z: float, sliding: float, v: float, h: float, level: float, distance: float, tau: float
) -> float:
    """The share of an element after a span in which it slides so long; see `_sliding_time`."""
    s = copysign(1.0, v)
    if sliding < 0.0:
        return z + v * h / distance
    begin = z if sliding == h else s * max(level, s * z)
    return s * level + (begin - s * level) * exp(-sliding / (tau * level))


def _rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    # States: the force of each element as a share of its Coulomb level, then 1 for each that
    # slides and 0 for each that sticks. An element slides the way it pulls.
    n = len(z) // 2
    ratio, v_s, tau = p[2 * n + 1], p[2 * n + 2], p[2 * n + 3]
    r = v / v_s
    level = 1.0 + (ratio - 1.0) * exp(-r * r)
    F, distance = p[2 * n] * v, 1.0
    for i in range(n):
        distance *= p[n + i]
        out[i], out[n + i] = z[i], z[n + i]
        if h != 0.0:
            sliding = _sliding_time(z[i], z[n + i], v, h, level, distance)
            out[i] = _share_after(z[i], sliding, v, h, level, distance, tau)
            out[n + i] = 1.0 if sliding >= 0.0 else 0.0
        F += p[i] * out[i]
    return F  # type: ignore[no-any-return]


def _damped_rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    # States as of the law without damping.
    n = len(z) // 2
    ratio, v_s, tau, sigma = p[2 * n + 1], p[2 * n + 2], p[2 * n + 3], p[2 * n + 4]
    r = v / v_s
    level = 1.0 + (ratio - 1.0) * exp(-r * r)
    F, distance, every, sticking = p[2 * n] * v, 1.0, 0.0, 0.0
    for i in range(n):
        distance *= p[n + i]
        out[i], out[n + i] = z[i], z[n + i]
        sliding = _sliding_time(z[i], z[n + i], v, h, level, distance)
        if h != 0.0:
            out[i] = _share_after(z[i], sliding, v, h, level, distance, tau)
            out[n + i] = 1.0 if sliding >= 0.0 else 0.0
        F += p[i] * out[i]
        every += p[i]
        if sliding < 0.0:
            sticking += p[i]
    if sticking > 0.0:
        F += sigma * v * sticking / every
    return F  # type: ignore[no-any-return]


def slip_of(n: int) -> Any:
    """Steady sliding of n elements; what follows the law's own parameters is not looked at."""

    def _slip(v: float, p: Array) -> float:
        F_C = 0.0
        for i in range(n):
            F_C += p[i]
        r = v / p[2 * n + 2]
        level = F_C * (1.0 + (p[2 * n + 1] - 1.0) * exp(-r * r))
        return copysign(1.0, v) * level + p[2 * n] * v  # type: ignore[no-any-return]

    return slip_law(_slip)


def _starts(spectrum: Spectrum, n: int) -> Array:
    """Maxwell elements whose level drops at one of the speeds, and how fast."""
    elements = starts_of(spectrum, n)
    elements[:, :n] *= _DROPPED
    return np.array([
        [*p, _DROPPED**-2, v_s, tau] for p, v_s, tau in product(elements, spectrum.speeds, _LAGS)
    ])  # fmt: skip


def _damped_starts(spectrum: Spectrum, n: int) -> Array:
    """Sets of the law without damping, its level rising with the speed in half of them.

    The damping begins at what makes the force of a bend at the median speed as great as a tenth of
    the level.
    """
    plain = _starts(spectrum, n)
    rising = plain.copy()
    rising[:, 2 * n + 1] = _DROPPED
    damping = 0.1 * spectrum.level / float(np.median(spectrum.speeds))
    return np.array([[*p, sigma] for p in (*plain, *rising) for sigma in (0.0, damping)])


def _law(n: int, stem: str, **further: Any) -> Law:
    """The law with n elements, with or without damping."""
    damped = stem != "gms"
    return Law(
        name=stem if n == ELEMENTS else f"{stem}:{n}",
        params=(
            *elements(n),
            VISCOUS,
            Param("ratio", 0.2 if damped else 1.0, 5.0, "", "F_S/F_C",
                  doc="static over Coulomb friction"),
            Param("v_s", 1e-5 if damped else 1e-4, 1e-1, "m/s", "v_s", log=True,
                  doc="Stribeck velocity"),
            Param("tau", 1e-4, 1.0, "s", "\\tau", log=True,
                  doc="time in which a sliding element follows its level, F_C/C"),
            *((Param("sigma", 0.0, 1e5, "N s/m", "\\sigma",
                     doc="damping while all elements stick"),) if damped else ()),
        ),
        slip=slip_of(n),
        states=2 * n,
        cite="Al-Bender, Lampaert, Swevers (2005), doi 10.1109/TAC.2005.858676",
        linear=(*(f"W_{i}" for i in range(1, n + 1)), "F_V", *(("sigma",) if damped else ())),
        physical=lambda p: (
            np.all(p >= 0, axis=1)
            & (p[:, n] > 0)
            & np.all(p[:, n + 1 : 2 * n] >= 1, axis=1)
            & (p[:, 2 * n + 1] >= (0.0 if damped else 1.0))
            & np.all(p[:, 2 * n + 1 : 2 * n + 4] > 0, axis=1)
        ),
        **further,
    )  # fmt: skip


_STUCK = "stuck: c_i' = v/d_i until c_i sgn v = s(v)"
_SLIDING = "sliding: c_i' = (sgn v − c_i/s(v))/tau until v turns"
_LEVEL = "s = 1 + (ratio − 1) exp(−(v/v_s)²),  d_i = d_1 r_2 … r_i"


@cache
def gms(n: int) -> Law:
    """The law with n elements."""
    return _law(
        n,
        "gms",
        rub=rub_law(_rub),
        doc=f"{n} Maxwell elements with a Stribeck level that sliding follows with a lag",
        formula=f"F = Σ W_i c_i + F_V v,  {_STUCK}, {_SLIDING},  {_LEVEL}",
        starts=partial(_starts, n=n),
    )


@cache
def gms_damped(n: int) -> Law:
    """The law with n elements, those that stick damped in proportion to their levels."""
    return _law(
        n,
        "gms-damped",
        rub=rub_law(_damped_rub),
        doc=f"{n} generalised Maxwell elements, damped while they stick; friction may rise from "
        "rest",
        formula=f"F = Σ W_i c_i + sigma v Σ_stuck W_i / Σ W_i + F_V v,  {_STUCK}, {_SLIDING},  "
        f"{_LEVEL}",
        starts=partial(_damped_starts, n=n),
    )


GMS = gms(ELEMENTS)
GMS_DAMPED = gms_damped(ELEMENTS)
