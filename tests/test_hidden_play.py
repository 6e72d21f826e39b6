"""Play of a drive behind one encoder: told where it explains a log, and only there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from foreign import two_masses as plain_steps
from stribeck import Fit, Recording, identify
from stribeck.identify.hidden_play import hidden_play
from stribeck.identify.problem import MotionProblem
from stribeck.rig.axis_table import composed_axis

DATA = Path(__file__).parents[2] / "shared" / "data"
#: A servo axis of 7 kg whose motor is 2 kg of that, in a loop of 10 Hz.
AXIS = {
    "M_m": 2.0, "M": 5.0, "stiffness": 4e5, "damping": 80.0, "play": 9e-5, "F_C": 19.0,
    "F_V": 25.0, "F_C_motor": 26.0, "F_V_motor": 30.0, "kp": 4e4, "kd": 700.0,
}  # fmt: skip
t = np.arange(0.0, 3.0, 2e-3)
GOAL = np.minimum(t / 0.5, 1.0) * (0.01 * np.sin(8.0 * t) + 0.003 * np.sin(20.0 * t))


def fitted(changed: dict[str, float], law: str, side: int) -> Fit:
    """The fit of one mass to what the encoder of one side has read."""
    values = AXIS | changed
    positions = plain_steps.simulate(values, t, 1000, goal=GOAL)
    q = positions[side] + 1.5e-6 * np.random.default_rng(0).standard_normal(len(t))
    rig = composed_axis(
        {
            "law": law, "ranges": {"F_C": [0.0, 100.0], "F_V": [0.0, 300.0]},
            "controller": {"damped": {"kp": values["kp"], "kd": values["kd"]}},
            "load": {"mass": {"M": 7.0}},
        },
        "axis",
    )  # fmt: skip
    log = Recording(t=t, position=q, command=GOAL)
    return identify(log, rig=rig, repeats=1, budget=400)


@pytest.mark.parametrize(("law", "side", "name"), [
    ("coulomb-viscous", 0, "motor"), ("coulomb-viscous", 1, "load"), ("dahl", 0, "motor"),
])  # fmt: skip
def test_play_that_looks_like_friction_is_told(law: str, side: int, name: str) -> None:
    fit = fitted({}, law, side)
    told = [w for w in fit.warnings if "play of the drive looks like friction" in w]
    assert len(told) == 1
    assert f"read at the {name}" in told[0]
    assert "[transmission.compliant]" in told[0]
    level = next(e for e in fit.estimates if e.name == "F_C")
    assert level.verdict != "identified"


def test_a_stiff_drive_is_told_no_play() -> None:
    """Even if it is asked for one: the mass in two explains no more of the log."""
    fit = fitted({"stiffness": 1e8, "damping": 5e3, "play": 0.0}, "coulomb-viscous", 0)
    assert not any("play" in w for w in fit.warnings)
    assert isinstance(fit.residuals, MotionProblem)
    x = np.array([next(e.value for e in fit.estimates if e.name == q.name)
                  for q in fit.parameters.free])  # fmt: skip
    violations, rows = hidden_play(fit.residuals, x, rough=True)
    assert rows > 100
    assert violations == []


@pytest.mark.recordings("go1")
def test_a_motor_whose_log_states_no_load_is_not_parted() -> None:
    """Its mass of 0 left the load of two masses without inertia, which refused the whole fit."""
    log = DATA / "go1" / "2025-05-13_04h57m44.json"
    fit = identify(log, rig="servo-pendulum", repeats=1, budget=60)
    assert any("the model explains little" in w for w in fit.warnings)  # else no play is asked for
    assert not any("play" in w for w in fit.warnings)
