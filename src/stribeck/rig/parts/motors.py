"""Motors: what makes a force at the load of a demand, by a gear of ratio n."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from ..motion.part_call import DAMPING, STIFFNESS, Row
from .part import Coefficient, Part

_ARMATURE = Coefficient(
    "armature", "kg", "inertia of the rotor, at the motor's shaft", 0.0, 0.0, 1e4,
    rotary="kg m**2", symbol="J_a", least=0.0, at_motor=True,
)  # fmt: skip
_FRICTION = Coefficient(
    "F_fm", "N", "what the motor loses of its force, at the load: none of it comes through below",
    0.0, 0.0, 1e4, rotary="N m", least=0.0,
)  # fmt: skip
#: What of them every motor contributes.
_LOST = MappingProxyType({"F_fm": ", of which clip(F_m, ±F_fm) is lost"})
_INERTIA = MappingProxyType({"armature": "n² armature"})
_TORQUE_CONSTANT = Coefficient("k_t", "N/A", "force per ampere", lower=1e-4, upper=1e3, log=True,
                               rotary="N m/A", positive=True, symbol="k_t",
                               at_motor=True)  # fmt: skip
_CURRENT_LIMIT = Coefficient("I_max", "A", "largest current", np.inf,
                             positive=True)  # fmt: skip


def driving(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:
    """Force gain · demand − emf · v at the load, with gain, emf = c."""
    slope[STIFFNESS] *= c[0]
    slope[DAMPING] = c[0] * slope[DAMPING] + c[1]
    return c[0] * force - c[1] * v


def _terms(largest: Any, values: Mapping[str, Any]) -> Mapping[str, Any]:
    """The axis as a whole, of a motor's largest force at the load."""
    n = values["ratio"]
    return {
        "M": values["armature"] * n * n,
        "force_limit": largest,
        "motor_friction": values["F_fm"],
    }


def _per_ampere(values: Mapping[str, Any]) -> Any:
    return values["k_t"] * values["ratio"]


FORCE = Part(
    name="force",
    role="motor",
    doc="an ideal one: the demand is its force or torque",
    equation="F_m = clip(n demand, ±n F_max)",
    clauses=_LOST,
    inertia=_INERTIA,
    coefficients=(
        Coefficient("F_max", "N", "largest force of the motor", np.inf,
                    rotary="N m", positive=True, at_motor=True),
        _ARMATURE, _FRICTION,
    ),
    terms=lambda values: _terms(values["ratio"] * values["F_max"], values),
    function=driving,
    constants=lambda values: (values["ratio"], 0.0),
    drive="force",
)  # fmt: skip

CURRENT = Part(
    name="current",
    role="motor",
    doc="behind a current loop: the demand is its current",
    equation="F_m = n k_t clip(demand, ±I_max)",
    clauses=_LOST,
    inertia=_INERTIA,
    coefficients=(_TORQUE_CONSTANT, _CURRENT_LIMIT, _ARMATURE, _FRICTION),
    terms=lambda values: _terms(_per_ampere(values) * values["I_max"], values),
    function=driving,
    constants=lambda values: (_per_ampere(values), 0.0),
    drive="current",
)

VOLTAGE = Part(
    name="voltage",
    role="motor",
    doc="at a voltage: with a winding, the voltage that it induces, and a largest current",
    equation="F_m = n k_t clip((demand − n k_t v)/R, ±I_max)",
    clauses=_LOST,
    inertia=_INERTIA,
    coefficients=(
        _TORQUE_CONSTANT,
        Coefficient("R", "ohm", "resistance of the winding", lower=1e-2, upper=1e3, log=True,
                    positive=True),
        _CURRENT_LIMIT, _ARMATURE, _FRICTION,
    ),
    terms=lambda values: _terms(_per_ampere(values) * values["I_max"], values),
    function=driving,
    constants=lambda values: (
        _per_ampere(values) / values["R"],
        _per_ampere(values) * _per_ampere(values) / values["R"],
    ),
    drive="voltage",
)  # fmt: skip
