"""The generalised Maxwell-slip law: Maxwell elements whose levels fall and lag as they slide."""

from functools import cache, partial
from itertools import product
from math import copysign, exp
from typing import Any

import numpy as np

from ..space import Array, Param
from .law import Law, rub_law, slip_law
from .maxwell import ELEMENTS, VISCOUS, elements, starts_of
from .yield_spectrum import Spectrum

#: Where a search begins: Coulomb levels as shares of the mean friction, and lags, s.
_DROPPED, _LAGS = 0.9, (3e-3, 3e-2)


def _rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    # States: the force of each element as a share of its Coulomb level, then 1 for each that
    # slides and 0 for each that sticks. An element slides the way it pulls.
    n = len(z) // 2
    ratio, v_s, tau = p[2 * n + 1], p[2 * n + 2], p[2 * n + 3]
    r = v / v_s
    level = 1.0 + (ratio - 1.0) * exp(-r * r)
    s = copysign(1.0, v)
    F, distance = p[2 * n] * v, 1.0
    for i in range(n):
        distance *= p[n + i]
        out[i], out[n + i] = z[i], z[n + i]
        if h != 0.0:
            slides, remaining = s * z[i] > 0.0 and z[n + i] > 0.5 and v != 0.0, h  # noqa: PLR2004
            if not slides:
                gap = max(level - s * z[i], 0.0) * distance
                if abs(v) * h <= gap:
                    out[i] += v * h / distance
                elif v != 0.0:
                    slides, remaining = True, h - gap / abs(v)
                    if gap > 0.0:
                        out[i] = s * level
            if slides:
                out[i] = s * level + (out[i] - s * level) * exp(-remaining / (tau * level))
            out[n + i] = 1.0 if slides else 0.0
        F += p[i] * out[i]
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


@cache
def gms(n: int) -> Law:
    """The law with n elements."""
    return Law(
        name="gms" if n == ELEMENTS else f"gms:{n}",
        params=(
            *elements(n),
            VISCOUS,
            Param("ratio", 1.0, 5.0, "", "F_S/F_C", doc="static over Coulomb friction"),
            Param("v_s", 1e-4, 1e-1, "m/s", "v_s", log=True, doc="Stribeck velocity"),
            Param("tau", 1e-4, 1.0, "s", "\\tau", log=True,
                  doc="time in which a sliding element follows its level, F_C/C"),
        ),
        slip=slip_of(n),
        rub=rub_law(_rub),
        states=2 * n,
        doc=f"{n} Maxwell elements with a Stribeck level that sliding follows with a lag",
        formula="F = Σ W_i c_i + F_V v,  stuck: c_i' = v/d_i until c_i sgn v = s(v), "
        "sliding: c_i' = (sgn v − c_i/s(v))/tau until v turns,  "
        "s = 1 + (ratio − 1) exp(−(v/v_s)²),  d_i = d_1 r_2 … r_i",
        cite="Al-Bender, Lampaert, Swevers (2005), doi 10.1109/TAC.2005.858676",
        linear=(*(f"W_{i}" for i in range(1, n + 1)), "F_V"),
        physical=lambda p: (
            np.all(p >= 0, axis=1)
            & (p[:, n] > 0)
            & np.all(p[:, n + 1 : 2 * n] >= 1, axis=1)
            & (p[:, 2 * n + 1] >= 1)
            & np.all(p[:, 2 * n + 2 : 2 * n + 4] > 0, axis=1)
        ),
        starts=partial(_starts, n=n),
    )  # fmt: skip


GMS = gms(ELEMENTS)
