"""Friction of a lubricated axis over temperature: the levels and the viscous term each by its own.

The term `+temperature` multiplies all of the friction by one factor. Of an axis that warms up the
viscous part falls as its lubricant does, by an exponential, and the level falls little or rises.
"""

from dataclasses import replace
from math import copysign, exp

import numpy as np

from ..compile_cache import compiled
from ..space import Array, Param
from .coulomb import COULOMB_VISCOUS
from .law import TERMS, Law, rub_law
from .stribeck import STRIBECK

#: Where the temperature stands among the five loads.
_TEMPERATURE = 4

_SLOPES = (
    Param("level_slope", -0.05, 0.05, "1/K", "\\beta_C", doc="change of the levels per kelvin"),
    Param("visc_slope", -0.02, 0.1, "1/K", "\\beta_V",
          doc="fall of the viscous term per kelvin, as an exponential"),
    replace(TERMS["temperature"][1], name="T_ref"),
)  # fmt: skip
_CITE = "O. Reynolds (1886), doi 10.1098/rstl.1886.0005"
_VISCOUS = "F_V exp(−visc_slope (T − T_ref)) v"


@compiled(forceinline=True)
def _level_factor(T: float, slope: float, reference: float) -> float:
    """What the levels are multiplied by at T, K: friction drives nothing."""
    return max(1.0 + slope * (T - reference), 0.0)


def _rub_coulomb(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    T = load[_TEMPERATURE]
    level = p[0] * _level_factor(T, p[2], p[4])
    return copysign(1.0, v) * level + p[1] * exp(-p[3] * (T - p[4])) * v  # type: ignore[no-any-return]


def _rub_stribeck(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    F_S, F_C, F_V, v_SS, exponent = p[0], p[1], p[2], p[3], p[4]
    T = load[_TEMPERATURE]
    r = abs(v) / v_SS
    if exponent != 1.0:
        r = r**exponent
    level = (F_C + (F_S - F_C) * exp(-r)) * _level_factor(T, p[5], p[7])
    return copysign(1.0, v) * level + F_V * exp(-p[6] * (T - p[7])) * v  # type: ignore[no-any-return]


COULOMB_VISCOUS_TEMPERATURE = Law(
    name="coulomb-viscous-temperature",
    params=(*COULOMB_VISCOUS.params, *_SLOPES),
    slip=COULOMB_VISCOUS.slip,
    rub=rub_law(_rub_coulomb),
    loads=("temperature",),
    doc="Coulomb friction and viscosity, each with a dependence on temperature of its own",
    formula=f"F = F_C (1 + level_slope (T − T_ref)) sgn v + {_VISCOUS}",
    cite=_CITE,
    linear=COULOMB_VISCOUS.linear,
    physical=lambda p: np.all(p[:, :2] >= 0, axis=1),
)

STRIBECK_TEMPERATURE = Law(
    name="stribeck-temperature",
    params=(*STRIBECK.params, *_SLOPES),
    slip=STRIBECK.slip,
    rub=rub_law(_rub_stribeck),
    loads=("temperature",),
    doc="stribeck, its levels and its viscosity each with a dependence on temperature of its own",
    formula="F = [F_C + (F_S − F_C) exp(−(|v|/v_SS)^exponent)] (1 + level_slope (T − T_ref)) "
    f"sgn v + {_VISCOUS}",
    cite=_CITE,
    linear=STRIBECK.linear,
    physical=lambda p: STRIBECK.physical(p[:, :5]),
)
