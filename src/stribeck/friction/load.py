"""Coulomb friction that grows with the load on the contact, with a viscous term."""

from math import copysign

import numpy as np

from ..space import Array, Param
from .coulomb import COULOMB_VISCOUS
from .law import Law, rub_law

#: Where the normal load stands among the five loads.
_NORMAL = 2


def _rub(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    return copysign(1.0, v) * (p[0] + p[2] * abs(load[_NORMAL])) + p[1] * v  # type: ignore[no-any-return]


COULOMB_LOAD = Law(
    name="coulomb-load",
    params=(
        *COULOMB_VISCOUS.params,
        # N over the unit of the load: a number for a normal force, m^2 for a pressure.
        Param("mu", 0.0, 1.0, "", "\\mu", doc="friction per unit of normal load"),
    ),
    slip=COULOMB_VISCOUS.slip,
    rub=rub_law(_rub),
    loads=("normal",),
    doc="a level that grows with the normal load, such as a seal's with pressure, and viscosity",
    formula="F = (F_C + mu |N|) sgn v + F_V v,  N: normal load, such as a pressure",
    cite="G. Amontons (1699); C. A. Coulomb (1785)",
    linear=("F_C", "F_V", "mu"),
    physical=lambda p: np.all(p >= 0, axis=1),
)
