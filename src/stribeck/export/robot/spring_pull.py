"""A motion by which two friction laws are compared: an axis pulled through a spring.

It needs nothing of the rig but its inertia, and shows what a controller would feel: the force at
which the axis breaks away, and whether it then slides or jumps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...data.recording import Recording
from ...friction import Law
from ...rig import Rig
from ...rig.slide_bed import SLIDE_BED
from ...space import Array

#: Samples of a pull; its last half shows how it goes on.
_SAMPLES = 5000
#: The band of rest, a share of the speed of the pull, and the way by which a step may be off, a
#: share of the whole way.
_BAND, _TOLERANCE = 1e-5, 1e-8


@dataclass(frozen=True, eq=False)
class SpringPull:
    """How an axis moved that was pulled through a spring whose other end moves evenly.

    Args:
        breakaway: Largest force of the spring, N (N m).
        jump: By how much the stretch of the spring swings in the last half, m (rad).
        position: Where the axis is at the samples, m (rad).
    """

    breakaway: float
    jump: float
    position: Array


def spring_pull(
    law: Law, p: Array, mass: float, stiffness: float, speed: float, span: float
) -> SpringPull:
    """Pull an axis from rest.

    Args:
        law: Any friction law.
        p: Its parameters, SI; what follows them is not looked at.
        mass: kg (kg m^2).
        stiffness: N/m (N m/rad).
        speed: Of the far end of the spring, m/s (rad/s).
        span: How long, s.
    """
    rig = SLIDE_BED.set(
        **{"m": mass, "k_hat+": 0.0, "k_hat-": 0.0, "F_fm": 0.0, "J_m": 0.0, "D_m": 0.0},
        dv=1e3 * _BAND * speed, tolerance=1e3 * _TOLERANCE * speed * span,
    )  # fmt: skip
    t = np.linspace(0.0, span, _SAMPLES)
    command, still = speed * t, np.zeros(len(t))
    warm = still + temperature(law, p)
    log = Recording(t=t, position=still, command=command, temperature=warm)
    track = rig.track(log, slice(0, len(t)), 0.0, np.ones(len(t)))
    springs = np.full(len(rig.own(law)), stiffness)
    x = rig.move(law, np.concatenate([p[: len(law.params)], springs])[None], track).position[0]
    stretch = command - x
    swing = float(np.ptp(stretch[len(t) // 2 :]))
    return SpringPull(stiffness * float(stretch.max()), swing, x)


def temperature(law: Law, p: Array) -> float:
    """The temperature at which a law's own parameters hold, K; 0 if it is all one to the law."""
    name = "temp_ref" if "temperature" in law.terms else "T_ref"
    return float(p[law.names.index(name)]) if law.warms else 0.0


def inertia(rig: Rig, law: Law, p: Array) -> float | None:
    """What moves on a rig, kg (kg m^2): identified or known; None where the rig does not say."""
    known = {c.name: c.value for c in rig.constants}
    known |= {q.name: float(v) for q, v in zip(rig.parameters(law), p, strict=True)}
    if {"armature", "m", "l"} <= known.keys():
        return known["m"] * known["l"] ** 2 + known["armature"]
    mass = next((known[n] for n in ("M", "J", "m") if n in known), 0.0)
    return mass if 0.0 < mass < np.inf else None
