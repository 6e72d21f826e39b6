"""Equation errors of short segments: single slips of a slowly sampled arm."""

from __future__ import annotations

import numpy as np
import pytest

from foreign import joint
from foreign.friction import coulomb_viscous
from stribeck import RIGS, Recording
from stribeck.data.ranges import Range
from stribeck.friction import LAWS
from stribeck.identify.adequacy.equation_error import equation_error
from stribeck.identify.parameters import partition
from stribeck.identify.segment import segments
from stribeck.identify.uncertainty.estimates import Estimate
from stribeck.rig.simulated import as_simulated

TRUTH = {"F_C": 0.25, "F_V": 0.7, "J": 0.06, "g_sin": 0.05, "g_cos": 0.0, "g_0": -0.03}


@pytest.mark.parametrize("samples", [12, 20, 26, 28, 30, 40, 60, 200])
def test_a_segment_is_long_enough_or_left_out(samples: int) -> None:
    t = 0.02 * np.arange(400.0)
    command = 0.4 * np.sin(2 * np.pi * t / 4.0)
    curve = coulomb_viscous(TRUTH["F_C"], TRUTH["F_V"])
    arm = joint.Joint(J=0.06, g_sin=0.05, g_0=-0.03, kp=35.0, kd=2.2)
    m = joint.simulate(arm, curve, curve, t, command, np.gradient(command, t))
    log = Recording(t=m.t, position=m.position, command=m.command, force=m.force, rotary=True)
    rig = as_simulated(RIGS["joint"].set(kp=35.0, kd=2.2))
    parameters = partition(rig, LAWS["coulomb-viscous"])
    p = np.array([TRUTH[q.name] for q in parameters.every])
    estimates = [
        Estimate(q.name, v, 0.0, 0.0, v - 0.01, v + 0.01, None, "identified", "")
        for q, v in zip(parameters.every, p.tolist(), strict=True)
    ]
    part = segments([log], rig, Range.parse(f"1s:{1 + 0.02 * samples}s", "rad"))
    rows = equation_error(parameters, p, part, estimates)
    if samples < 25:
        assert rows is None
    elif rows is not None:
        assert len(rows.residual) <= samples
        assert np.sqrt(np.mean(rows.residual**2)) < 0.05
    assert rows is not None or samples < 100
