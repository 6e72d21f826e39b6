"""The state in which a log begins, against a foreign joint whose true motion is known."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from foreign import joint
from foreign.driven import DrivenMotion
from foreign.friction import Curve
from foreign.strokes import sines
from stribeck import Recording, identify
from stribeck.rig import RIGS

#: Parameters of the law and of the rig, SI.
TRUTH = {
    "F_S": 1.2, "F_C": 0.6, "F_V": 0.3, "v_SS": 0.1, "J": 0.2, "g_sin": 1.0, "g_cos": 2.0,
    "g_0": 0.3,
}  # fmt: skip
#: Standard deviation of the sensor's noise, rad.
NOISE = 2e-5


@cache
def motion() -> DrivenMotion:
    """A joint that is at rest when its command already moves."""
    t, command = sines(12.0, np.array([0.6, 0.25]), np.array([0.25, 0.7]), dt=0.01)
    friction = Curve(*(TRUTH[n] for n in ("F_S", "F_C", "F_V", "v_SS")))
    load = {n: TRUTH[n] for n in ("J", "g_sin", "g_cos", "g_0")}
    arm = joint.Joint(**load, kp=70.0, kd=4.4)
    return joint.simulate(arm, friction, friction, t, command, np.gradient(command, t))


@pytest.mark.parametrize(
    "begin", [pytest.param(0, id="moves off at once"), pytest.param(137, id="in full motion")]
)
def test_a_log_that_begins_in_motion_moves_no_parameter(begin: int) -> None:
    m = motion()
    noisy = m.position + NOISE * np.random.default_rng(begin).standard_normal(len(m.t))
    log = Recording(
        t=m.t[begin:] - m.t[begin], position=noisy[begin:], command=m.command[begin:], rotary=True
    )
    fit = identify(log, rig=RIGS["joint"].set(kp=70.0, kd=4.4), law="stribeck",
                   fixed={"exponent": 1.0})  # fmt: skip
    estimated = {e.name: e.value for e in fit.estimates}
    for name, truth in TRUTH.items():
        assert estimated[name] == pytest.approx(truth, rel=4e-3), name
    assert fit.score.value < 3e3 * NOISE  # mrad; from the measured state it is 9 times the noise
