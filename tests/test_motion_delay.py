"""Motions that were logged late, in fits by output error, on logs of foreign simulators."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.random import default_rng

from foreign import joint, sensors, servo, slide_bed
from foreign.clock import Array
from foreign.friction import Curve
from foreign.strokes import even, ramp, sines
from stribeck import RIGS, InputError, Recording, identify, validate
from stribeck.cli.inputs import delay_value
from stribeck.data.alignment import MOTION_CHANNELS, advanced

JOINT = {"F_C": 0.6, "F_V": 0.3, "J": 0.2, "g_sin": 1.0}
SERVO = {"F_C": 0.02, "F_V": 0.008, "k_t": 0.4, "R": 4.0, "armature": 3e-3}


@cache
def arm_motion() -> Any:
    t, command = sines(10.0, np.array([0.6, 0.25]), np.array([0.4, 0.9]), dt=0.01)
    axis = joint.Joint(J=0.2, g_sin=1.0, kp=70.0, kd=4.4)
    curve = Curve(0.6, 0.6, 0.3, 0.1)
    return joint.simulate(axis, curve, curve, t, command, np.gradient(command, t), 0.0 * t)


@cache
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
    assert at == pytest.approx(1e3 * late, abs=1.6)
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
    assert told(arm.__wrapped__(0.02))


# --- delays that a log hardly shows, or not at all ------------------------------------------------

#: What pulls at the slide for each metre of stretch, N/m, and its ramp to the right, m/s.
PULL, PACE = 3500.0 + 967.98, 5e-3


@cache
def bed_motion(scattered: bool) -> Any:
    curve = Curve(130.0, 60.0, 958.3, 2e-3)
    times, way = ramp(60.0, PACE)
    factors = np.array([1.0, 1.15, 0.88, 1.06, 0.93] if scattered else [1.0])
    return slide_bed.simulate(
        slide_bed.Bed(), curve, curve, times, way, -0.006, 0.02, factors, h=2e-5
    )


def bed(late: float, *, scattered: bool = False, **options: Any) -> Any:
    """A slide bed on a steady ramp, its position logged late."""
    table = sensors.delayed(bed_motion(scattered)._asdict(), "position", late)
    table = sensors.noisy(table, "position", 3e-4, default_rng(0))
    log = Recording(table["t"], table["position"], command=table["command"])
    return identify(log, rig=RIGS["slide-bed"].exact(), law="stribeck", repeats=1, **options)


def recorded(fit: Any) -> list[str]:
    return [v.sentence for v in fit.violations if "motion was recorded" in v.sentence]


def interval(fit: Any, name: str) -> tuple[float, float]:
    (e,) = [e for e in fit.estimates if e.name == name]
    return e.low, e.high


@pytest.mark.parametrize("late", [0.0, 0.1])
def test_what_no_log_of_a_ramp_shows_is_told_with_what_it_moves(late: float) -> None:
    fit = bed(late)
    (sentence,) = recorded(fit)
    assert sentence in fit.warnings
    assert "the log cannot show how much later than its command" in sentence
    assert "0 ± 20 ms is assumed" in sentence
    assert "F_C falls 0.02" in sentence  # N each ms
    assert {e.verdict for e in fit.estimates if e.name in ("F_S", "F_C")} == {"identified"}


def test_a_late_ramp_is_one_of_more_friction() -> None:
    """The motion of a slide that is F_S and F_C stiffer by the stretch that the delay adds."""
    true, late, moved = (
        bed(by, fixed={"k_spring": 0.96798}, delay=delay)
        for by, delay in ((0.0, "auto"), (0.1, "auto"), (0.1, -0.1))
    )
    assert late.score.value == pytest.approx(true.score.value, rel=1e-3)
    for name in ("F_S", "F_C"):
        added = late.values[name] - true.values[name]
        assert added == pytest.approx(PULL * PACE * 0.1, abs=0.1)
        assert moved.values[name] == pytest.approx(true.values[name], abs=0.3)
    assert not recorded(moved)


def test_a_tolerance_of_the_delay_is_in_the_intervals() -> None:
    exact, known, less, wide = (
        bed(0.1, delay=(0.0, tolerance)) for tolerance in (0.0, 0.02, 0.08, 0.2)
    )
    assert not recorded(exact)
    assert not interval(exact, "F_C")[0] < 60.0 < interval(exact, "F_C")[1]
    assert interval(known, "F_C") == interval(exact, "F_C")  # a half-width of 0.44 N beside 1.7 N
    assert not recorded(known)
    assert "0 ± 200 ms was said" in recorded(wide)[0]
    low, high = interval(wide, "F_C")
    assert low < 60.0 < high
    (least, most), (low, high) = interval(exact, "F_C"), interval(less, "F_C")
    half = np.hypot(0.5 * (most - least), 1.96 * PULL * PACE * 0.04)
    assert 0.5 * (high - low) == pytest.approx(half, rel=0.1)


def test_slips_with_a_breakaway_each_tell_no_delay_either() -> None:
    fit = bed(0.0, scattered=True)
    (sentence,) = recorded(fit)
    k_spring = fit.values["k_spring"]
    each = 1e-3 * PACE * (3500.0 + k_spring)
    assert f"F_C falls {each:.2g} N for each ms" in sentence


@pytest.mark.parametrize("late", [5e-4, 1e-3, 2e-3])
@pytest.mark.parametrize("seed", range(2))
def test_a_delay_of_a_part_of_a_sample_is_in_the_intervals(late: float, seed: int) -> None:
    fit = arm(late, seed)
    (sentence,) = recorded(fit)
    assert not lies(fit, JOINT)
    at = float(sentence.split("recorded ")[1].split(" ± ")[0])
    assert at == pytest.approx(1e3 * late, abs=0.4)
    assert "F_V falls 0.06" in sentence
    low, high = interval(fit, "F_V")
    assert low < 1.03 * JOINT["F_V"] < 1.03 * high
    assert next(e.verdict for e in fit.estimates if e.name == "F_V") == "weak"


def test_a_delay_that_is_known_widens_nothing() -> None:
    unknown, known = arm(0.0), arm(0.0, delay=0.0)
    assert not recorded(known)
    assert known.values == unknown.values
    (low, high), (least, most) = interval(unknown, "F_V"), interval(known, "F_V")
    assert 3 * (most - least) < high - low
    assert least < JOINT["F_V"] < most


def test_a_delay_as_it_is_typed() -> None:
    assert delay_value("auto") == "auto"
    assert delay_value("-20") == (-0.02, 0.0)
    assert delay_value("0±50") == delay_value("0+-50") == (0.0, 0.05)
    for text in ("5±", "5±-1", "x±1", "5 ms"):
        with pytest.raises(InputError, match="--delay"):
            delay_value(text)
    with pytest.raises(InputError, match="a tolerance in seconds, 0 or more"):
        arm(0.0, delay=(0.0, float("nan")))


def test_slips_of_a_joint_hold_a_delay() -> None:
    """The torque of a slow ramp of command rises by kp times its speed times the delay."""
    t: Array = np.arange(0.0, 40.0, 0.01)
    axis = joint.Joint(J=0.2, kp=70.0, kd=0.5)
    curve = Curve(6.0, 3.0, 0.3, 0.02)
    command = 0.05 * np.maximum(t - 0.5, 0.0)
    motion = joint.simulate(
        axis, curve, curve, t, command, np.gradient(command, t), 0.0 * t,
        scatter=np.array([1.0, 1.2, 0.85, 1.1, 0.95]),
    )._asdict()  # fmt: skip
    table = sensors.noisy(motion, "position", 2e-4, default_rng(0))
    log = Recording(t, table["position"], command=command, rotary=True)
    fit = identify(
        log, rig=RIGS["joint"].set(kp=70.0, kd=0.5).exact(), law="stribeck",
        fixed={"g_sin": 0.0, "g_cos": 0.0, "g_0": 0.0}, repeats=1, breakaway="scattered",
    )  # fmt: skip
    (sentence,) = recorded(fit)
    assert "F_C falls 0.0035 N m" in sentence  # 70 N m/rad at 0.05 rad/s, each ms
