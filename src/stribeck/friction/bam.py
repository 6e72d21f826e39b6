"""The six laws of BAM for servos: friction budgets, from m3 on with the load on the gears.

What the motor and the surroundings (gravity) apply to the two ends of a gear train presses its
teeth together, so friction grows with their difference: the more the one works against the other.
"""

from math import copysign, exp

import numpy as np

from ..compile_cache import compiled
from ..space import Array, Param
from .law import Law, rub_law, slip_law

# Of the five loads: drive, external.
_DRIVE, _EXTERNAL = 0, 1


@compiled()
def _low_speed(v: float, w_s: float, alpha: float) -> float:
    """The share of the Stribeck terms: 1 at rest, 0 at speed."""
    return exp(-(abs(v / w_s) ** alpha))


def _slip_m1(v: float, p: Array) -> float:
    return copysign(1.0, v) * p[0] + p[1] * v  # type: ignore[no-any-return]


def _slip_m2(v: float, p: Array) -> float:
    return copysign(1.0, v) * (p[0] + _low_speed(v, p[3], p[4]) * p[2]) + p[1] * v  # type: ignore[no-any-return]


def _rub_m3(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    pressed = abs(load[_DRIVE] - load[_EXTERNAL])
    return copysign(1.0, v) * (p[0] + p[2] * pressed) + p[1] * v  # type: ignore[no-any-return]


def _rub_m4(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    pressed = abs(load[_DRIVE] - load[_EXTERNAL])
    slow = _low_speed(v, p[3], p[4]) * (p[2] + p[6] * pressed)
    return copysign(1.0, v) * (p[0] + p[5] * pressed + slow) + p[1] * v  # type: ignore[no-any-return]


def _rub_m5(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    t_m, t_e = load[_DRIVE], load[_EXTERNAL]
    slow = _low_speed(v, p[3], p[4]) * (p[2] + abs(p[7] * t_m - p[8] * t_e))
    return copysign(1.0, v) * (p[0] + abs(p[5] * t_m - p[6] * t_e) + slow) + p[1] * v  # type: ignore[no-any-return]


def _rub_m6(v: float, h: float, z: Array, load: Array, p: Array, out: Array) -> float:
    t_m, t_e = load[_DRIVE], load[_EXTERNAL]
    square = 0.0
    if t_m * t_e < 0.0:  # they work against each other: the weaker one counts
        square = p[10] * t_e * t_e if abs(t_m) > abs(t_e) else p[9] * t_m * t_m
    slow = _low_speed(v, p[3], p[4]) * (p[2] + abs(p[7] * t_m - p[8] * t_e) + square)
    return copysign(1.0, v) * (p[0] + abs(p[5] * t_m - p[6] * t_e) + slow) + p[1] * v  # type: ignore[no-any-return]


_PLAIN = (
    Param("K_c", 0.0, 1000.0, "N", "K_c", doc="Coulomb friction"),
    Param("K_v", 0.0, 5000.0, "N s/m", "K_v", doc="viscous friction"),
)
_SLOW = (
    Param("K_cs", 0.0, 1000.0, "N", "K_{cs}", doc="what is added at rest"),
    Param("w_s", 1e-4, 1.0, "m/s", "w_s", log=True, doc="Stribeck velocity"),
    Param("alpha", 0.5, 10.0, "", "\\alpha", doc="Stribeck exponent"),
)
_ONE = Param("K_l", 0.0, 1.0, "", "K_l", doc="friction per load")
_ONE_SLOW = Param("K_ls", 0.0, 1.0, "", "K_{ls}", doc="what is added per load at rest")
_TWO = (
    Param("K_m", 0.0, 1.0, "", "K_m", doc="friction per force of the motor"),
    Param("K_e", 0.0, 1.0, "", "K_e", doc="friction per external force"),
    Param("K_ms", 0.0, 1.0, "", "K_{ms}", doc="what is added per force of the motor at rest"),
    Param("K_es", 0.0, 1.0, "", "K_{es}", doc="what is added per external force at rest"),
)
_SQUARES = (
    Param("K_mq", 0.0, 0.1, "1/N", "K_{mq}", doc="at rest, per square of a weaker motor's force"),
    Param("K_eq", 0.0, 0.1, "1/N", "K_{eq}", doc="at rest, per square of a weaker external force"),
)
_CITE = "Duclusaud, Passault, Padois, Ly (2024), doi 10.48550/arXiv.2410.08650"
_E = "E = exp(−|v/w_s|^alpha)"
_T = "t_m, t_e: what the drive and what the surroundings apply"
_N3 = ("K_c", "K_v", "K_cs")


def _physical(p: Array) -> object:
    return np.all(p >= 0, axis=1)


def _physical_slow(p: Array) -> object:
    return np.all(p >= 0, axis=1) & (p[:, 3] > 0)


BAM_M1 = Law(
    name="bam-m1",
    params=_PLAIN,
    slip=slip_law(_slip_m1),
    doc="BAM's first: Coulomb and viscous friction",
    formula="F = (K_c + K_v |v|) sgn v",
    cite=_CITE,
    linear=("K_c", "K_v"),
    physical=_physical,
)
BAM_M2 = Law(
    name="bam-m2",
    params=(*_PLAIN, *_SLOW),
    slip=slip_law(_slip_m2),
    doc="BAM's second: Coulomb, viscous and Stribeck friction",
    formula=f"F = (K_c + K_v |v| + E K_cs) sgn v,  {_E}",
    cite=_CITE,
    linear=_N3,
    physical=_physical_slow,
)
BAM_M3 = Law(
    name="bam-m3",
    params=(*_PLAIN, _ONE),
    slip=BAM_M1.slip,
    rub=rub_law(_rub_m3),
    loads=("drive", "external"),
    doc="BAM's third: Coulomb and viscous friction, and a share of the load on the gears",
    formula=f"F = (K_c + K_v |v| + K_l |t_m − t_e|) sgn v,  {_T}",
    cite=_CITE,
    linear=("K_c", "K_v", "K_l"),
    physical=_physical,
)
BAM_M4 = Law(
    name="bam-m4",
    params=(*_PLAIN, *_SLOW, _ONE, _ONE_SLOW),
    slip=BAM_M2.slip,
    rub=rub_law(_rub_m4),
    loads=("drive", "external"),
    doc="BAM's fourth: Stribeck friction and a share of the load, greater at rest",
    formula="F = (K_c + K_v |v| + K_l |t_m − t_e| + E (K_cs + K_ls |t_m − t_e|)) sgn v,  "
    f"{_E},  {_T}",
    cite=_CITE,
    linear=(*_N3, "K_l", "K_ls"),
    physical=_physical_slow,
)
BAM_M5 = Law(
    name="bam-m5",
    params=(*_PLAIN, *_SLOW, *_TWO),
    slip=BAM_M2.slip,
    rub=rub_law(_rub_m5),
    loads=("drive", "external"),
    doc="BAM's fifth: Stribeck friction, with shares of their own for motor and surroundings",
    formula="F = (K_c + K_v |v| + |K_m t_m − K_e t_e| + "
    f"E (K_cs + |K_ms t_m − K_es t_e|)) sgn v,  {_E},  {_T}",
    cite=_CITE,
    linear=_N3,
    physical=_physical_slow,
)
BAM_M6 = Law(
    name="bam-m6",
    params=(*_PLAIN, *_SLOW, *_TWO, *_SQUARES),
    slip=BAM_M2.slip,
    rub=rub_law(_rub_m6),
    loads=("drive", "external"),
    doc="BAM's sixth: the fifth, and at rest the square of the weaker of two opposed forces",
    formula="F = (K_c + K_v |v| + |K_m t_m − K_e t_e| + "
    f"E (K_cs + |K_ms t_m − K_es t_e| + Q)) sgn v,  {_E},  Q = K_eq t_e² if |t_m| > |t_e| "
    f"else K_mq t_m² where t_m t_e < 0, else 0,  {_T}",
    cite=_CITE,
    linear=(*_N3, "K_mq", "K_eq"),
    physical=_physical_slow,
)
