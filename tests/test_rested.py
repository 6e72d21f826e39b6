"""Breakaway that rises with rest: the law in closed form, and found again in a foreign log."""

from __future__ import annotations

import numpy as np
import pytest

from foreign import driven, rested
from stribeck import LAWS, Recording, identify
from stribeck.space import Array

LAW = LAWS["armstrong"]
#: A contact of 12 N that takes 20 N after a long rest, half of the difference after a second.
TRUTH = rested.Rested(1.5e6, 20.0, 12.0, 5e-3, 80.0, 1.0, 1e-2)
P = np.array(TRUTH)
MASS, LOADS = 10.0, np.zeros(5)


def stepped(v: float, h: float, z: Array) -> tuple[float, Array]:
    out = np.empty(LAW.states)
    return float(LAW.rub(v, h, z, LOADS, P, out)), out


@pytest.mark.parametrize("rest", [0.01, 0.3, 1.0, 5.0, 100.0])
def test_breakaway_after_a_rest_is_that_of_the_published_hyperbola(rest: float) -> None:
    fast = 5.0 * TRUTH.v_s
    _, z = stepped(fast, 10.0, np.zeros(LAW.states))  # a slide from a long rest, to its end
    left = 1.0 / (1.0 + (fast / TRUTH.v_s - 0.1) ** 2)
    _, z = stepped(0.0, rest, z)
    creep = 1e-12  # the spring is at its level already: what it takes to go on
    z[0] = 1.0
    level, _ = stepped(creep, 1e-9, z)
    share = left + (1.0 - left) * rest / (rest + TRUTH.gamma)
    assert level == pytest.approx(TRUTH.F_C + (TRUTH.F_S - TRUTH.F_C) * share, rel=1e-7)


def test_friction_lags_behind_a_change_of_speed() -> None:
    v = 5.0 * TRUTH.v_s
    steady = LAW.slip(v, P)
    z = np.zeros(LAW.states)
    z[0] = 1.0
    for span in (0.5e-2, 1e-2, 2e-2):
        F, _ = stepped(v, span, z)
        drop = (TRUTH.F_S - TRUTH.F_C) * (1.0 - 1.0 / (1.0 + 4.9**2))
        assert F - steady == pytest.approx(drop * np.exp(-span / TRUTH.tau_L), rel=1e-9)


def foreign_log() -> Recording:
    """Moves at three speeds after rests of 50 ms to 4 s, behind an encoder of 0.1 um, at 1 kHz."""
    t, x, way = [0.0], [0.0], 1.0
    for k, rest in enumerate([0.05, 0.2, 0.5, 1.0, 2.0, 4.0, 1.0, 0.5, 0.2, 0.05, 2.0, 4.0]):
        speed = (2e-3, 1e-2, 5e-2)[k % 3]
        length = 0.4 * speed + 2e-3
        t += [t[-1] + rest, t[-1] + rest + length / speed]
        x += [x[-1], x[-1] + way * length]
        way = -way
    grid = np.arange(0.0, t[-1], 1e-3)
    loop = driven.Loop(kp=4e4, kd=2e3, tick=1e-4)
    motion = rested.simulate(MASS, TRUTH, loop, grid, np.interp(grid, t, x))
    rng = np.random.default_rng(2)
    n = len(motion.t)
    position = 1e-7 * np.round(motion.position / 1e-7 + 0.5 * rng.standard_normal(n))
    return Recording(t=motion.t, position=position, force=motion.force + rng.normal(0, 0.1, n))


def test_a_foreign_log_with_rests_of_many_lengths_gives_the_law_back() -> None:
    fit = identify(foreign_log(), rig="forced", law="armstrong")
    truth = {**TRUTH._asdict(), "M": MASS, "offset": 0.0}
    close = {"tau_L": 0.1, "gamma": 0.05, "v_s": 0.05, "F_V": 0.05}
    held = 0
    for q, e in zip(fit.parameters.every, fit.estimates, strict=True):
        held += e.low <= truth[q.name] <= e.high
        assert e.value == pytest.approx(truth[q.name], rel=close.get(q.name, 0.02), abs=0.05), (
            q.name
        )
    assert held >= 7  # of nine intervals of 95 %
    rested_level = next(e for q, e in zip(fit.parameters.every, fit.estimates, strict=True)
                        if q.name == "gamma")  # fmt: skip
    assert rested_level.verdict == "identified"
