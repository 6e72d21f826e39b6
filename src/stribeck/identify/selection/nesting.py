"""Nested laws: their order, the ingredients that differ, and one law embedded in another.

A richer law that contains a simpler one starts from the simpler one's answer as well, so that it
never trains worse. Whether it does contain it is not asked of a table: the simpler law's values
are carried over by their meaning, and what they cost under the richer law is evaluated.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ...space import Array, Param, Space

if TYPE_CHECKING:
    from ...friction import Law
    from ..parameters import Parameters

#: What other literatures call a parameter.
_ALIASES = {"K_c": "F_C", "K_v": "F_V", "w_s": "v_SS", "v_s": "v_SS", "alpha": "exponent"}
#: Levels of friction, to which a constant force adds in one direction and not in the other.
_LEVELS = ("F_S", "F_C")
#: Parameters that a law has in place of a single one.
_PARTS = {"K_m": "K_l", "K_e": "K_l", "K_ms": "K_ls", "K_es": "K_ls"}
#: Parameters by which a law falls from rest to speed.
_FALLS = frozenset({"F_S", "K_cs", "g1", "ratio"})
_OFFSET = "offset"

#: What a law may have beyond a level and a slope, as people call it, the plainest first.
INGREDIENTS = {
    "asymmetry": "parameters of their own for each direction",
    "stribeck": "a level at rest above the one at speed (Stribeck)",
    "exponent": "a free exponent of the Stribeck curve",
    "load": "friction that grows with the load",
    "two loads": "a share of its own for each load",
    "squares": "a share that goes with the square of the load",
    "states": "inner states (presliding, memory)",
    "temperature": "a share that depends on temperature",
    "position": "a share that depends on position",
    "cogging": "a force over position, the same both ways",
}
#: What only refines another ingredient, and is no step of its own where that is new.
_REFINES = {"exponent": "stribeck", "two loads": "load", "squares": "load"}


def ingredients(law: Law, free: Iterable[str]) -> frozenset[str]:
    """What a law has beyond Coulomb and viscous friction, of `INGREDIENTS`.

    Args:
        law: The law.
        free: Names of the parameters that are to be found.
    """
    bare = {name.rstrip("+-") for name in law.names}
    stems = {_ALIASES.get(stem, stem) for stem in (name.rstrip("+-") for name in free)}
    has = {
        "asymmetry": law.directional,
        "stribeck": bool(bare & _FALLS),
        "exponent": bool(bare & _FALLS) and "exponent" in stems,
        "load": bool({*law.loads} - {"temperature"}),
        "two loads": "K_m" in bare,
        "squares": "K_mq" in bare,
        "states": law.states > 0,
        "temperature": law.warms,
        "position": "position" in law.terms,
        "cogging": "cogging" in law.terms,
    }
    return frozenset(name for name, present in has.items() if present)


def step(simple: frozenset[str], rich: frozenset[str]) -> str | None:
    """The one ingredient that is new in a richer law; None if there are none or several."""
    if not simple < rich:
        return None
    added = rich - simple
    steps = [name for name in INGREDIENTS if name in added and _REFINES.get(name) not in added]
    return steps[0] if len(steps) == 1 else None


def embedded(simple: Parameters, p: Array, rich: Parameters) -> Array:
    """The free parameters (dim,) of a richer law at which it is, if it can be, a simpler one.

    As `placed`, inside the ranges.
    """
    space = Space(rich.free)
    x = placed(simple, p, rich)
    inside: Array = space.decode(space.encode(x[None]).clip(0.0, 1.0))[0]
    return inside


def placed(simple: Parameters, p: Array, rich: Parameters) -> Array:
    """The free parameters (dim,) of a richer law that stand for a simpler one's.

    What both have keeps its value; both directions get the one value of a law that knew no
    direction, its constant force counted with the levels where the richer law has none; a
    Stribeck curve starts without a fall, and what else is new at zero, or in the middle of its
    range where that does not reach to zero.

    Args:
        simple: The simpler law's parameters.
        p: Their values, SI, (k,).
        rich: The richer law's.
    """
    values = {synonym(n): v for n, v in simple.values(p).items()}
    dropped = 0.0 if any(q.name == _OFFSET for q in rich.every) else values.get(_OFFSET, 0.0)
    return np.array([_value(q, values, dropped) for q in rich.free])


def carried(simple: Parameters, p: Array, rich: Parameters) -> list[Array]:
    """Free parameters (dim,) of a richer law near a simpler one's: `embedded`, or near a limit.

    Of a law that the simpler one is the rigid limit of, several; see `RigidLimit`.

    Args:
        simple: The simpler law's parameters.
        p: Their values, SI, (k,).
        rich: The richer law's.
    """
    point, limit = embedded(simple, p, rich), rich.law.rigid_limit
    if limit is None or limit.law.name != simple.law.name:
        return [point]
    sets = limit.sets(p[: len(limit.law.params)])
    of_law = dict(zip(rich.law.names, sets.T, strict=False))  # those of terms come last
    else_at = zip(rich.free, point.tolist(), strict=True)
    columns = [of_law.get(q.name, np.full(len(sets), value)) for q, value in else_at]
    space = Space(rich.free)
    return list(space.decode(space.encode(np.column_stack(columns)).clip(0.0, 1.0)))


def synonym(name: str) -> str:
    """The name that most laws have for a parameter, its direction kept: K_c is F_C."""
    stem = name.rstrip("+-")
    return _ALIASES.get(stem, stem) + name[len(stem) :]


def _value(param: Param, values: Mapping[str, float], offset: float) -> float:
    name = synonym(param.name)
    stem, sign = name.rstrip("+-"), name[len(name.rstrip("+-")) :]
    for name_sought in (stem, *(("F_C",) if stem == "F_S" else ())):
        if (value := _at(name_sought, sign, values, offset)) is not None:
            return value
    if stem == "K_cs" and "F_S" in values:
        return values["F_S"] - values["F_C"]
    if stem in _PARTS:
        return values.get(_PARTS[stem], 0.0)
    if param.lower <= 0.0 <= param.upper:
        return 0.0
    middle: Array = Space((param,)).decode(np.array([[0.5]]))
    return float(middle[0, 0])


def _at(stem: str, sign: str, values: Mapping[str, float], offset: float) -> float | None:
    """A value by its name and direction, or by what comes closest to that, if anything does."""
    if stem + sign in values:
        return values[stem + sign]
    if sign and stem in values:
        sign_of_offset = {"+": 1.0, "-": -1.0}[sign] if stem in _LEVELS else 0.0
        return values[stem] + sign_of_offset * offset
    if f"{stem}+" in values and f"{stem}-" in values:
        return 0.5 * (values[f"{stem}+"] + values[f"{stem}-"])
    return None
