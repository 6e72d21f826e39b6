"""An axis of two masses whose coefficients are stated, and its motions from rest."""

from __future__ import annotations

from typing import Any

import numpy as np

from stribeck import Recording
from stribeck.friction import law_named
from stribeck.rig.axis_table import composed_axis
from stribeck.rig.motion.track import Track
from stribeck.rig.simulated import SimulatedRig
from stribeck.rig.two_masses import TwoMassRig
from stribeck.space import Array

t = np.arange(0.0, 1.5, 2e-3)
#: A servo axis: 2 and 5 kg, a coupling that swings at 95 Hz, 0.2 mm of play.
SERVO = {
    "armature": 2.0, "M": 5.0, "stiffness": 5e5, "damping": 100.0, "play": 2e-4, "F_C": 20.0,
    "F_V": 30.0, "F_C_motor": 10.0, "F_V_motor": 20.0,
}  # fmt: skip
GAINS = {"kp": 2e4, "kd": 300.0}
GOAL = np.minimum(t, 1.0) * (0.01 * np.sin(9.0 * t) + 0.004 * np.sin(20.0 * t))
FORCE = 90.0 * np.sin(8.0 * t) + 30.0 * np.sin(20.0 * t)
SENSORS: dict[str, Any] = {"motor": {}, "load": {}}


def rig_of(values: dict[str, float], law: str = "coulomb-viscous", **changed: Any) -> TwoMassRig:
    """An axis of two masses whose coefficients are all stated."""
    commanded = "kp" in values
    parts = {
        "controller": ("damped", ("kp", "kd")) if commanded else ("none", ()),
        "motor": ("force", ("armature",)),
        "transmission": ("compliant", ("stiffness", "damping", "play", "start", "eta", "eta_back")),
        "load": ("mass", ("M", "offset")),
    }
    table: dict[str, Any] = {
        role: {name: {n: values[n] for n in names if n in values}}
        for role, (name, names) in parts.items()
    }
    if "gear" in values:  # a law has a ratio, too
        table["transmission"]["compliant"]["gear_ratio"] = values["gear"]
    table |= {"law": law, "friction": {"side": "both"}, "sensor": SENSORS, "tolerance": 1e-3}
    rig = composed_axis(table | changed, "test")
    assert isinstance(rig, TwoMassRig)
    return rig


def started(rig: SimulatedRig, force: Array | None = None, goal: Array | None = None) -> Track:
    """The track of a rig from rest at 0."""
    log = Recording(t=t, position=np.zeros(len(t)), command=goal, force=force)
    return rig.track(log, slice(0, len(t)), 0.0, np.ones(len(t)))._replace(v0=0.0)


def moved(
    rig: TwoMassRig, values: dict[str, float], force: Array | None = None, goal: Array | None = None
) -> tuple[Array, Array]:
    """Positions of motor and load from rest at 0, (N,) each."""
    law = law_named(rig.laws[0])
    p = np.array([[values[q.name] for q in rig.parameters(law)]])
    motor, load = rig.sides(law, p, started(rig, force, goal))
    return motor.position[0], load.position[0]
