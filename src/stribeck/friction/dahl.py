"""Dahl's law: friction builds up like the stress of a solid that yields."""

from math import copysign, expm1, log1p

import numpy as np

from ..space import Array, Param
from .law import Law, rub_law, slip_law
from .yield_spectrum import Spectrum


def _slip(v: float, p: Array) -> float:
    return copysign(1.0, v) * p[1] + p[3] * v  # type: ignore[no-any-return]


def _rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    # What is left to the steady deflection, u, obeys du/dx = -u^exponent per F_C/sigma_0 of travel:
    # closed forms for every exponent. Below 1 it is reached after a finite way.
    sigma_0, F_C, exponent, F_V = p[0], p[1], p[2], p[3]
    out[0] = z[0]
    if v * h != 0.0:
        steady = F_C / sigma_0
        gap = copysign(steady, v) - z[0]
        if steady > 0.0 and gap != 0.0:
            x, w = abs(v) * h / steady, 1.0 - exponent
            if w == 0.0:
                change = expm1(-x)
            else:
                x *= w / (abs(gap) / steady) ** w
                change = expm1(log1p(-x) / w) if x < 1.0 else -1.0
            out[0] -= gap * change
        else:
            out[0] = copysign(steady, v)
    return sigma_0 * out[0] + F_V * v  # type: ignore[no-any-return]


def _starts(spectrum: Spectrum) -> Array:
    F_C = spectrum.level
    return np.array([[k, F_C, 1.0, 0.0] for k in (spectrum.stiffness, F_C / spectrum.way)])


DAHL = Law(
    name="dahl",
    params=(
        Param("sigma_0", 1e3, 1e9, "N/m", "\\sigma_0", log=True, doc="stiffness at rest"),
        Param("F_C", 0.0, 1000.0, "N", "F_C", doc="Coulomb friction"),
        Param("exponent", 0.0, 2.0, "", "\\delta", fixed=1.0, doc="shape of the build-up"),
        Param("F_V", 0.0, 5000.0, "N s/m", "F_V", doc="viscous friction"),
    ),
    slip=slip_law(_slip),
    rub=rub_law(_rub),
    states=1,
    doc="a spring that yields: presliding hysteresis, no break-away peak",
    formula="F = σ_0 z + F_V v,  dz/dx = |u|^exponent sgn u,  u = 1 − σ_0 z sgn v / F_C",
    cite="P. R. Dahl (1968), TOR-0158(3107-18)-1, doi 10.21236/ADA041920",
    linear=("F_V",),
    physical=lambda p: np.all(p >= 0, axis=1) & (p[:, 0] > 0),
    starts=_starts,
)
