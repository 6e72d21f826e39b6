"""What a constant can be, and a value that is near an end of its search range."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.random import default_rng

from stribeck import Recording, identify
from stribeck.friction import law_named
from stribeck.rig.custom import rig_file
from stribeck.rig.simulated import as_simulated

AXIS = """\
rotary = true
[controller.pd]
kp = 10
kd = 0.3
[motor.current]
k_t = 0.1
armature = 1e-4
I_max = 10
[transmission.gear]
gear_ratio = 50
eta = {eta}
eta_back = {eta}
[load.pendulum]
m = 1
l = 0.2
m_arm = 0.3
"""


@pytest.mark.parametrize("eta", ['"1±5%"', '"0.97±0.03"', '"0.95 nameplate"'])
def test_an_efficiency_is_never_above_one(tmp_path: Path, eta: str) -> None:
    """With the truth at 0.95 and noise of 1 mrad, the estimates must not leave the possible.

    And 0.4 N m s/rad, which the data hold to a hundredth, is at no end of a default range that goes
    up to thousands.
    """
    law = law_named("coulomb-viscous")
    (tmp_path / "true.toml").write_text(AXIS.format(eta=0.95), encoding="utf-8")
    (tmp_path / "axis.toml").write_text(AXIS.format(eta=eta), encoding="utf-8")
    true, rig = (rig_file(tmp_path / name) for name in ("true.toml", "axis.toml"))
    t = np.arange(0.0, 2.0, 4e-3)
    goal = np.minimum(t, 1.0) * (0.8 * np.sin(5.0 * t) + 0.3 * np.sin(13.0 * t))
    asked = Recording(t, np.zeros(len(t)), command=goal, rotary=True)
    p = np.array([[{"F_C": 1.5, "F_V": 0.4}[q.name] for q in true.parameters(law)]])
    x = as_simulated(true).simulate(law, p, asked).position[0]
    log = Recording(t, x + 1e-3 * default_rng(0).standard_normal(len(t)), command=goal, rotary=True)
    fit = identify(log, rig=rig, law="coulomb-viscous", repeats=1)
    values = {e.name: (e.low, e.high) for e in fit.estimates}
    assert values["F_C"][0] < 1.5 < values["F_C"][1]
    assert not [w for w in fit.warnings if "end of its range" in w]
    assert rig.limits("eta")[1] == 1.0
    assert rig.limits("k_t")[0] > 0.0
