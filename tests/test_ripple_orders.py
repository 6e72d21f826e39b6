"""Orders and periods of ripple are found in logs of plain small steps."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from foreign import parts as plain_steps
from stribeck import Recording, identify
from stribeck.rig.axis_table import composed_axis

AXIS = """
law = "coulomb-viscous"
rotary = true
ranges = {{ F_C = [0, 2], F_V = [0, 1] }}
controller.damped = {{ kp = 4.0, kd = 0.1 }}
motor.force.armature = 4e-5
transmission.gear.gear_ratio = 10.0
load.inertia.J = {{ free = [0.01, 0.2] }}
{ripple}
"""
MOTOR = """
[load.motor-ripple]
cog_order = { free = [1, 60] }
cog_cos = { free = [-0.1, 0.1] }
cog_sin = { free = [-0.1, 0.1] }
"""
LOAD = """
[load.ripple]
rip_period = { free = [0.02, 2.0] }
rip_cos = { free = [-1, 1] }
rip_sin = { free = [-1, 1] }
"""
VALUES = {
    "kp": 4.0,
    "kd": 0.1,
    "gear_ratio": 10.0,
    "armature": 4e-5,
    "J": 0.05,
    "F_C": 0.4,
    "F_V": 0.2,
}


@pytest.mark.parametrize(
    ("ripple", "waves"),
    [
        (MOTOR, {"cog_order": 7.0, "cog_cos": 0.01, "cog_sin": 0.02}),
        (MOTOR, {"cog_order": 28.0, "cog_cos": -0.02, "cog_sin": 0.01}),
        (LOAD, {"rip_period": 0.13, "rip_cos": 0.15, "rip_sin": -0.1}),
    ],
)
def test_a_ripple_of_unknown_order_is_found(ripple: str, waves: dict[str, float]) -> None:
    t = np.arange(0.0, 3.0, 4e-3)
    goal = 0.8 * np.sin(1.5 * t) + 0.3 * np.sin(4.1 * t)
    values = VALUES | waves
    q = plain_steps.simulate(values, t, {"goal": goal}, "damped", "force", 100)
    q += 2e-5 * np.random.default_rng(0).standard_normal(len(t))
    rig = composed_axis(tomllib.loads(AXIS.format(ripple=ripple)), "axis")
    fit = identify(Recording(t=t, position=q, command=goal, rotary=True), rig=rig, delay=0.0)
    order = next(iter(waves))
    for e in fit.estimates:
        assert e.verdict == "identified", e.name
        # The plain steps of 40 us are off, too: by little, since their error is no wave.
        off = abs(e.value / values[e.name] - 1.0)
        assert off < (1e-4 if e.name == order else 0.02), e.name
