"""Laws with states from measured motion and force: sliding and presliding in one log."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from foreign import combined
from foreign.driven import Loop
from foreign.presliding import LuGre
from stribeck import RIGS, InputError, Recording, identify, plan, validate
from stribeck.friction import law_named
from stribeck.identify.balance.presliding_shown import stiffness_unseen
from stribeck.identify.balance.regression import System
from stribeck.identify.balance.rows import filtered_logs
from stribeck.identify.parameters import partition
from stribeck.space import Array

#: Seconds of the log, and of its sines below breakaway.
SECONDS, BELOW = 16.0, 6.0
GMS = combined.Elements(np.array([5.0, 7.0]), np.array([4e-6, 16e-6]), 60.0, 1.3, 5e-3, 0.01)
LUGRE = LuGre(8e5, 600.0, 14.0, 10.0, 5e-3, 60.0)
TRUTH = {
    "gms:2": {
        "W_1": 5.0, "W_2": 7.0, "d_1": 4e-6, "r_2": 4.0, "F_V": 60.0, "ratio": 1.3, "v_s": 5e-3,
        "tau": 0.01, "M": 12.0, "offset": 1.0,
    },
    "lugre": {**LUGRE._asdict(), "M": 12.0, "offset": 1.0},
}  # fmt: skip


def command() -> tuple[Array, Array]:
    """Sines that grow beyond the way of the bristles, then strokes at 0.5 to 40 mm/s."""
    t = 1e-3 * np.arange(round(1e3 * SECONDS) + 1)
    grow = np.interp(t, [0.0, BELOW], [5e-6, 120e-6]) * (t < BELOW)
    speeds = np.array([0.5, 2.0, 8.0, 20.0, 40.0]) * 1e-3
    s = t - BELOW
    place = np.clip(s * len(speeds) / (SECONDS - BELOW), 0, len(speeds) - 1).astype(int)
    v = speeds[place] * np.tanh(8.0 * np.sin(np.pi * s)) * (s > 0.0)
    wave = np.sin(2.0 * np.pi * 0.5 * t) + 0.4 * np.sin(2.0 * np.pi * 1.5 * t)
    positions: Array = np.asarray(grow * wave + np.cumsum(v) * 1e-3, dtype=np.float64)
    return np.asarray(t, dtype=np.float64), positions


def log(name: str, step: float = 0.1e-6) -> Recording:
    """A foreign axis behind an encoder with steps and a force sensor with noise."""
    law: Any = GMS if name == "gms:2" else LUGRE
    loop = Loop(kp=4e5, kd=3e3, tick=1e-4)
    m = combined.simulate(12.0, law, loop, *command(), offset=1.0)
    rng = np.random.default_rng(7)
    x = m.position + 0.5 * step * rng.standard_normal(len(m.t))
    force = m.force + 0.1 * rng.standard_normal(len(m.t))
    return Recording(t=m.t, position=step * np.round(x / step), force=force)


@pytest.mark.parametrize("name", ["gms:2", "lugre"])
def test_a_combined_log_of_a_foreign_axis(name: str) -> None:
    """All of ten (eight) 95 % intervals hold the truth with a chance of 60 %: two may not."""
    fit = identify(log(name), rig="forced", law=name)
    truth = TRUTH[name]
    missed = [
        e.name
        for q, e in zip(fit.parameters.every, fit.estimates, strict=True)
        if not e.low <= truth[q.name] <= e.high
    ]
    assert len(missed) <= 2, missed
    sure = {e.name for e in fit.estimates if e.verdict == "identified"}
    assert sure >= ({"W_1", "W_2", "d_1", "M"} if name == "gms:2" else {"sigma_0", "F_S", "F_C"})
    for n in sure:
        assert fit.values[n] == pytest.approx(truth[n], rel=0.05)
    ((_, _, score),) = validate(fit, log(name))
    assert score.value == pytest.approx(fit.score.value, rel=0.01)


def part(of: Recording, first: float, last: float, every: int = 1) -> Recording:
    """Some samples of a log, its time from 0."""
    rows = np.flatnonzero((of.t >= first) & (of.t < last))[::every]
    assert of.force is not None
    return Recording(t=of.t[rows] - of.t[rows[0]], position=of.position[rows], force=of.force[rows])


@pytest.mark.parametrize(
    ("recording", "words"),
    [
        (log("lugre"), ""),
        (log("lugre", 50e-6), "of a reversal, and positions may be off by"),
        (part(log("lugre"), 10.0, 16.0, 20), "the motion never dwells within"),
    ],
)
def test_a_stiffness_that_cannot_be_seen_is_told_before_the_fit(
    recording: Recording, words: str
) -> None:
    parameters = partition(RIGS["forced"], law_named("lugre"))
    system = System(parameters, filtered_logs(recording, parameters, None, None))
    told = stiffness_unseen(system)
    assert [words in v.sentence for v in told] == [True] * bool(words)
    assert all(v.parameters == frozenset({"sigma_0"}) and v.caps for v in told)


def test_a_bias_that_is_too_great_to_be_taken_off_names_the_rig_that_simulates() -> None:
    """An encoder of 3 um before bristles that give way at 12: a quarter of their way."""
    fine, coarse = (
        identify(log("lugre", step), rig="forced", law="lugre") for step in (1e-7, 3e-6)
    )
    assert not any("rig presliding simulates it" in w for w in fine.warnings)
    (told,) = [w for w in coarse.warnings if "rig presliding simulates it" in w]
    for e in coarse.estimates:
        if e.name in told.partition(" by more than")[0].split():
            assert e.verdict != "identified"
    assert "sigma_1" in told


def test_a_motion_without_a_reversal_is_refused_in_a_line() -> None:
    with pytest.raises(InputError, match="the motion never turns back by more") as refusal:
        identify(part(log("lugre"), 12.02, 12.98), rig="forced", law="lugre")
    assert "\n" not in str(refusal.value)


def test_dahl_is_lugre_without_a_drop() -> None:
    even = LuGre(8e5, 0.0, 10.0, 10.0, 1.0, 60.0)
    m = combined.simulate(12.0, even, Loop(kp=4e5, kd=3e3, tick=1e-4), *command(), offset=1.0)
    fit = identify(Recording(t=m.t, position=m.position, force=m.force), rig="forced", law="dahl")
    assert fit.values["sigma_0"] == pytest.approx(8e5, rel=0.01)
    assert fit.values["F_C"] == pytest.approx(10.0, rel=0.002)
    assert fit.values["M"] == pytest.approx(12.0, rel=0.002)


def test_a_force_against_the_motion_is_no_friction() -> None:
    """Friction that drives: the sign of the force is wrong, and that is said in a line."""
    right = log("lugre")
    assert right.force is not None
    wrong = Recording(t=right.t, position=right.position, force=-right.force)
    with pytest.raises(InputError, match="does not go with the motion") as refusal:
        identify(wrong, rig="forced", law="lugre")
    assert "\n" not in str(refusal.value)


def test_experiments_are_not_judged_by_static_friction() -> None:
    recording = part(log("lugre"), 5.0, 12.0)
    fit = identify(recording, rig="forced", law="lugre")
    with pytest.raises(InputError, match="compared for laws without"):
        plan(fit, [recording])
    for e, q in zip(fit.estimates, fit.parameters.every, strict=True):
        assert q.lower <= e.low <= e.value <= e.high <= q.upper
