"""The Maxwell-slip law: blocks on springs side by side, each of which slips at its own level."""

from functools import cache, partial
from math import copysign
from typing import Any

import numpy as np

from ..space import Array, Param
from .law import Law, rub_law, slip_law
from .yield_spectrum import Spectrum

#: How many elements the law has unless its name says so: `maxwell-slip:6`.
ELEMENTS = 4
#: Levels, distances and this one are searched by their decades: elements that differ in the size of
#: all that they have are what the law is about.
VISCOUS = Param("F_V", 1e-1, 1e5, "N s/m", "F_V", log=True, doc="viscous friction")


def _rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    # A state is the force of an element as a share of its level: its spring loads it, up to ±1.
    n = len(z)
    F, distance = p[2 * n] * v, 1.0
    for i in range(n):
        distance *= p[n + i]
        share = min(max(z[i], -1.0), 1.0) + v * h / distance
        out[i] = min(max(share, -1.0), 1.0)
        F += p[i] * out[i]
    return F  # type: ignore[no-any-return]


def slip_of(n: int) -> Any:
    """Steady sliding of n elements; what follows the law's own parameters is not looked at."""

    def _slip(v: float, p: Array) -> float:
        F_C = 0.0
        for i in range(n):
            F_C += p[i]
        return copysign(1.0, v) * F_C + p[2 * n] * v  # type: ignore[no-any-return]

    return slip_law(_slip)


def elements(n: int) -> tuple[Param, ...]:
    """Levels and yield distances of n elements, in an order that no permutation repeats."""
    return (
        *(
            Param(f"W_{i}", 1e-3, 1e3, "N", f"W_{i}", log=True,
                  doc=f"level at which element {i} slips")
            for i in range(1, n + 1)
        ),
        Param("d_1", 1e-7, 1e-3, "m", "d_1", log=True, doc="displacement at which element 1 slips"),
        *(
            Param(f"r_{i}", 1.1, 30.0, "", f"r_{i}", log=True,
                  doc=f"displacement at which element {i} slips, over that of element {i - 1}")
            for i in range(2, n + 1)
        ),
    )  # fmt: skip


def starts_of(spectrum: Spectrum, n: int) -> Array:
    """Levels of n elements, the first yield and the ratios of the others, and F_V, (2, k)."""
    merged = [part.merged(n) for part in (spectrum, spectrum.without_tail())]
    return np.array([[*W, d[0], *(d[1:] / d[:-1]), 0.0] for W, d in merged])


def _elements(p: Array, n: int) -> tuple[Array, Array, Array]:
    yields: Array = np.cumprod(p[:, n : 2 * n], axis=1, dtype=np.float64)
    return p[:, :n], yields, p[:, 2 * n]


@cache
def maxwell_slip(n: int) -> Law:
    """The law with n elements."""
    return Law(
        name="maxwell-slip" if n == ELEMENTS else f"maxwell-slip:{n}",
        params=(
            *elements(n),
            VISCOUS,
        ),
        slip=slip_of(n),
        rub=rub_law(_rub),
        states=n,
        doc=f"{n} spring-loaded blocks side by side: presliding hysteresis with memory",
        formula="F = Σ W_i c_i + F_V v,  c_i' = v/d_i while |c_i| < 1,  "
        "d_i = d_1 r_2 … r_i,  k_i = W_i/d_i",
        cite="W. D. Iwan (1966), doi 10.1115/1.3625199",
        linear=(*(f"W_{i}" for i in range(1, n + 1)), "F_V"),
        physical=lambda p: (
            np.all(p >= 0, axis=1) & (p[:, n] > 0) & np.all(p[:, n + 1 : 2 * n] >= 1, axis=1)
        ),
        starts=partial(starts_of, n=n),
        elements=partial(_elements, n=n),
    )


MAXWELL_SLIP = maxwell_slip(ELEMENTS)
