"""Motions that were logged late, in fits by output error, on logs of foreign simulators."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.random import default_rng

from foreign import joint, sensors, servo
from foreign.clock import Array
from foreign.friction import Curve
from foreign.strokes import even, sines
from stribeck import RIGS, InputError, Recording, identify, validate
from stribeck.data.alignment import MOTION_CHANNELS, advanced

JOINT = {"F_C": 0.6, "F_V": 0.3, "J": 0.2, "g_sin": 1.0}
SERVO = {"F_C": 0.02, "F_V": 0.008, "k_t": 0.4, "R": 4.0, "armature": 3e-3}


@cache
def arm_motion() -> Any:
    t, command = sines(10.0, np.array([0.6, 0.25]), np.array([0.4, 0.9]), dt=0.01)
    axis = joint.Joint(J=0.2, g_sin=1.0, kp=70.0, kd=4.4)
    curve = Curve(0.6, 0.6, 0.3, 0.1)
    return joint.simulate(axis, curve, curve, t, command, np.gradient(command, t), 0.0 * t)


def arm(late: float, seed: int = 0, **options: Any) -> Any:
    """A joint whose angle is logged late; F_S is its F_C."""
    table = sensors.delayed(arm_motion()._asdict(), "position", late)
    table = sensors.noisy(table, "position", 5e-4, default_rng(seed))
    log = Recording(table["t"], table["position"], command=table["command"], rotary=True)
    rig = RIGS["joint"].set(kp=70.0, kd=4.4).exact()
    return identify(
        log, rig=rig, law="coulomb-viscous", fixed={"g_cos": 0.0, "g_0": 0.0}, repeats=2,
        budget=1500, **options,
    )  # fmt: skip


def pendulum(late: float, seed: int = 0) -> Any:
    axis, t = servo.Servo(armature=3e-3, m=0.5, l=0.1), even(6.0, 0.01)
    goal = 0.8 * np.sin(1.2 * t) + 0.3 * np.sin(5.0 * t)
    enabled = (t < 4.0).astype(float)
    table = servo.simulate(axis, servo.Bam(0.02, 0.008), t, goal, enabled)._asdict()
    table = sensors.delayed(table, "position", late)
    table = sensors.noisy(table, "position", 1e-3, default_rng(seed))
    extra = {name: np.full_like(t, v) for name, v in {"mass": 0.5, "length": 0.1}.items()}
    log = Recording(
        t, table["position"], command=goal, rotary=True, extra=extra | {"torque_enable": enabled}
    )
    rig = RIGS["servo-pendulum"].set(kp=axis.kp, vin=axis.vin).exact()
    return identify(log, rig=rig, law="coulomb-viscous", repeats=2, budget=1500)


def told(fit: Any) -> list[str]:
    return [v.sentence for v in fit.violations if "the motion was measured" in v.sentence]


def lies(fit: Any, truth: dict[str, float]) -> list[str]:
    """Identified values that are more than 3 % off and whose interval misses the truth."""
    return [
        e.name
        for e in fit.estimates
        if e.verdict == "identified"
        and e.name in truth
        and abs(e.value / truth[e.name] - 1) > 0.03
        and not e.low <= truth[e.name] <= e.high
    ]


@pytest.mark.parametrize("late", [0.01, 0.02, 0.04])
def test_the_delay_of_a_joint_is_told_with_what_it_biases(late: float) -> None:
    fit = arm(late)
    (sentence,) = told(fit)
    at = float(sentence.split(" ms ")[0].split()[-1])
    assert at == pytest.approx(1e3 * late, abs=1.5)
    assert "behind its command: with that J is" in sentence
    assert sentence.endswith(f"delay={-1e-3 * at:.4g} moves it back")
    assert not lies(fit, JOINT)
    assert not {e.verdict for e in fit.estimates if e.name in ("F_V", "J")} & {"identified"}


def test_what_is_told_moves_the_motion_back() -> None:
    fit = arm(0.02, delay=-0.02)
    assert fit.delay == -0.02
    assert not told(fit)
    assert {e.verdict for e in fit.estimates if e.name in ("F_C", "F_V", "J")} == {"identified"}
    assert fit.values["J"] == pytest.approx(arm(0.0).values["J"], rel=0.01)
    late = arm(0.02).recordings
    in_step, off = (validate(fit, late, delay=d)[0][2].value for d in ("auto", "off"))
    assert in_step < 0.1 * off


@pytest.mark.parametrize("seed", range(3))
def test_joints_in_step_have_no_delay(seed: int) -> None:
    assert not told(arm(0.0, seed))


@pytest.mark.parametrize("late", [0.03, -0.02])
def test_the_delay_of_a_servo_is_told(late: float) -> None:
    fit = pendulum(late)
    (sentence,) = told(fit)
    side = "behind" if late > 0 else "ahead of"
    at = float(sentence.split(f" ms {side} its command")[0].split()[-1])
    assert at == pytest.approx(1e3 * abs(late), abs=1.0)
    assert not lies(fit, SERVO)


def test_a_servo_in_step_has_no_delay() -> None:
    assert not told(pendulum(0.0))


def test_the_motion_is_moved_where_no_force_was_measured() -> None:
    t: Array = np.arange(0.0, 2.0, 0.01)
    log = Recording(t, np.sin(t - 0.03), command=np.sin(t), velocity=np.cos(t - 0.03))
    moved = advanced(log, 0.03, MOTION_CHANNELS)
    np.testing.assert_allclose(moved.position, np.sin(moved.t), atol=2e-5)
    np.testing.assert_array_equal(np.asarray(moved.command), np.sin(moved.t))
    np.testing.assert_array_equal(RIGS["slide-bed"].in_step(log, -0.03).position, moved.position)
    with pytest.raises(InputError, match="no force that a delay could move"):
        RIGS["forced"].in_step(log, 0.03)


def test_a_delay_within_what_passes_for_noise_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rests that creep make the floor of the noise too high to see a misfit of twice the noise."""
    monkeypatch.setattr("stribeck.identify.fit_warnings.NOISY", 10.0)
    assert told(arm(0.02))
