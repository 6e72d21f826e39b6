"""The quality report of a log: what it is good for."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from foreign import driven, slide_bed
from foreign.friction import Curve
from foreign.strokes import ramp as slide_bed_ramp
from foreign.strokes import sines
from stribeck import identify
from stribeck.data import Quality, Recording, check, read
from stribeck.space import Array

REAL = Path(__file__).parents[1] / ".." / "shared" / "data"
real = pytest.mark.recordings
T: Array = np.arange(6000, dtype=float) * 0.01


def stick_slip_log() -> Recording:
    k: Array = np.arange(len(T), dtype=float)
    return Recording(T, 0.02 * ((k // 400) + np.clip((k % 400 - 360) / 40, 0, 1)), 0.005 * T)


def test_where_a_force_is_measured_an_axis_that_moves_half_the_time_is_balanced() -> None:
    k: Array = np.arange(len(T), dtype=float)
    steps = (k // 400) + np.clip((k % 400 - 180) / 220, 0, 1)
    force = 10.0 + np.random.default_rng(0).standard_normal(len(T))
    for share, rig in ((steps, "forced"), (stick_slip_log().position / 0.02, "slide-bed")):
        assert check(Recording(T, 0.02 * share, 0.005 * T, force=force)).rig == rig
        assert check(Recording(T, 0.02 * share, 0.005 * T)).rig == "slide-bed"


@pytest.mark.parametrize(("amplitude", "doubted"), [(2e-4, True), (2e-2, False)])
def test_a_balance_of_a_travel_before_breakaway_is_doubted(amplitude: float, doubted: bool) -> None:
    """Sines whose force goes with the direction, as bristles' does once they have turned."""
    t: Array = np.arange(1200, dtype=float) * 0.01
    x, way = amplitude * np.sin(2.0 * t), np.sign(np.cos(2.0 * t))
    force = 10.0 * way + 0.01 * np.random.default_rng(0).standard_normal(len(t))
    q = check(Recording(t, x, force=force))
    assert q.rig == "forced"
    assert verdict_contains(q, "0.4 mm may lie before breakaway") is doubted
    assert verdict_contains(q, "as far as the axis slides slowly") is not doubted


def verdict_contains(quality: Quality, words: str) -> bool:
    return any(words in line for line in quality.verdict)


def test_the_numbers_of_a_made_log() -> None:
    q = check(stick_slip_log())
    assert q.rows == 6000
    assert q.duration == pytest.approx(59.99)
    assert q.rate == pytest.approx(100)
    assert q.jitter == pytest.approx(0, abs=1e-9)
    assert (q.gaps, q.longest_gap) == (0, 0)
    assert q.channels == ("position", "command")
    assert q.spans["position"] == pytest.approx((0, 0.02 * 15), rel=1e-2)
    assert len(q.slips) == 14
    assert q.median_jump == pytest.approx(0.02, rel=1e-6)
    assert q.stuck == pytest.approx(0.9, abs=0.01)
    assert q.directions == (1,)


def test_stick_slip_opens_the_simulation_road() -> None:
    q = check(stick_slip_log())
    assert verdict_contains(q, "stick-slip present: 14 slips")
    assert verdict_contains(q, "no measured force: no force balance is possible")
    assert verdict_contains(q, "one way only")


def test_steady_motion_closes_it() -> None:
    x = 0.1 * np.abs((T / 10) % 2 - 1)
    q = check(Recording(T, x, force=np.sign(np.gradient(x))))
    assert verdict_contains(q, "no stick-slip")
    assert verdict_contains(q, "one speed a direction")
    assert verdict_contains(q, "a force balance is possible")
    assert verdict_contains(q, "no command")
    assert q.directions == (-1, 1)
    assert q.speeds == pytest.approx((0.01, 0.01, 0.01), rel=1e-3)


def test_many_speeds_are_not_called_one() -> None:
    q = check(Recording(T, 0.1 * np.sin(T)))
    assert not verdict_contains(q, "one speed")


def test_a_current_without_its_factor() -> None:
    assert verdict_contains(
        check(Recording(T, np.sin(T), current=np.cos(T))), "unless current is mapped"
    )


def test_gaps_and_jitter_are_measured() -> None:
    t = np.delete(T, [100, 101, 102, 103, 104, 2000, 2001, 2002, 2003])
    q = check(Recording(t, np.sin(t)))
    assert q.gaps == 2
    assert q.longest_gap == pytest.approx(0.06)
    t = T + np.random.default_rng(0).uniform(-0.002, 0.002, len(T))  # 0.9 quantile of a triangle
    assert check(Recording(t, np.sin(t))).jitter == pytest.approx(0.4 * (1 - np.sqrt(0.1)), rel=0.1)


def test_a_channel_at_its_limit_is_told_and_others_are_not() -> None:
    force = 10 * np.sin(T)
    q = check(Recording(T, np.sin(T), force=np.clip(force, -8, 99), current=force))
    share = np.mean(force <= -8)
    (fault,) = q.faults
    assert fault.startswith(f"force is cut off at -8 N in {share:.1%} of the samples")


def test_a_rest_at_the_end_of_travel_is_no_clipping() -> None:
    assert not check(stick_slip_log()).faults


def test_lines_speak_the_unit_of_the_workshop() -> None:
    lines = dict(check(stick_slip_log()).lines())
    assert lines["slips"] == "14, median 20 mm"
    assert lines["samples"] == "6000 in 59.99 s, 100 Hz"
    rotary = Recording(T, stick_slip_log().position, rotary=True)
    assert dict(check(rotary).lines())["slips"] == "14, median 20 mrad"


def test_checking_changes_nothing_and_repeats() -> None:
    r = stick_slip_log()
    before = r.position.tobytes()
    assert check(r).lines() == check(r).lines()
    assert r.position.tobytes() == before


def test_a_million_samples_take_no_hours() -> None:
    t: Array = np.arange(10**6, dtype=float) * 1e-3
    x = 0.1 * np.sin(t / 9) + np.random.default_rng(0).normal(0, 1e-5, len(t))
    r = Recording(t, x, 0.1 * np.sin(t / 9))
    started = time.process_time()
    check(r)
    assert time.process_time() - started < 100  # a quadratic step would take hours


# Logs without stick-slip, and logs without what a force balance needs


def rests_and_moves(moves: list[float]) -> tuple[Array, Array]:
    """Time and position of an axis that rests for 3 s before each smooth move of 2 s."""
    t = T[: 500 * len(moves)]
    x = np.zeros(len(t))
    for k, move in enumerate(moves):
        phase = np.clip((t - 5 * k - 3) / 2, 0, 1)
        x += move * (phase - np.sin(2 * np.pi * phase) / (2 * np.pi))
    return t, x


def test_a_pendulum_that_swings_and_rests_does_not_stick_and_slip() -> None:
    t, x = rests_and_moves([6.0, 0.2, -6.0, -0.2, 6.0, 0.2, -6.0, -0.2])
    force = 0.5 * np.gradient(np.gradient(x, t), t) + 0.1 * np.sign(np.gradient(x, t))
    q = check(Recording(t, x, force=force, rotary=True))
    assert len(q.slips) >= 3  # as moves from rest to rest they are found
    assert verdict_contains(q, "swings or single moves")
    assert not verdict_contains(q, "stick-slip present")
    assert verdict_contains(q, "a force balance is possible")


def test_an_arm_that_is_led_by_hand_does_not_stick_and_slip() -> None:
    t, x = rests_and_moves([-1.6, -1.0, -1.5, 1.7, 1.2, 1.2])
    q = check(Recording(t, x, force=3.3 * np.sin(x), rotary=True))
    assert verdict_contains(q, "no stick-slip: the force is a function of the position")
    assert verdict_contains(q, "a command and not a measurement: no force balance is possible")
    assert not verdict_contains(q, "stick-slip present")


def test_a_ramp_of_force_tells_its_breakaway_and_no_more() -> None:
    t = T[:3000]
    x = 5e-5 * np.minimum(t, 16.0) + 0.01 * np.maximum(t - 16.0, 0.0) ** 2
    q = check(Recording(t, x, force=0.5 * t, rotary=True))
    assert len(q.breakaways) == 1
    line = dict(q.lines())["breakaway"]
    assert line.endswith("in a ramp of 0.5 N m/s to 15 N m")
    assert float(line.split()[1]) == pytest.approx(8.0, abs=0.15)
    assert verdict_contains(q, "a ramp of force to breakaway, without slips")
    assert verdict_contains(q, "no force balance is possible, rig presliding-rotary simulates it")
    assert not verdict_contains(q, "hardly any stick-slip")
    lines = dict(check(Recording(t, 5e-5 * t, force=0.5 * t)).lines())
    assert lines["breakaway"].startswith("none below 15 N")


def test_cycles_below_breakaway_tell_a_stiffness_and_no_more() -> None:
    t = T[:3000]
    x = 1.5e-4 * np.sin(2 * np.pi * t / 3 - 0.3)
    q = check(Recording(t, x, force=6 * np.sin(2 * np.pi * t / 3), rotary=True))
    assert q.presliding is not None
    line = dict(q.lines())["presliding"]
    assert line.startswith("sigma_0 at least 4000")
    assert "N m/rad, the slope between the tips: ±6 N m over 0.3 mrad" in line
    assert "9 settled cycles" in line
    assert line.endswith("is half of that, 20000 N m/rad")
    assert verdict_contains(q, "cycles of force below breakaway: no force balance is possible")


def test_travel_of_a_few_steps_is_no_motion_to_differentiate() -> None:
    t = T[:3000]
    force = np.where((t > 5) & (t < 20), 6.0, 0.0)
    coarse = 6e-6 * np.round(5e-5 * force * (1 - np.exp(-np.maximum(t - 5, 0))) / 6e-6)
    q = check(Recording(t, coarse, force=force, rotary=True))
    assert verdict_contains(q, "hardly any motion: the whole travel of")
    assert verdict_contains(q, "no force balance is possible")
    assert not q.faults  # a step that was held


def test_spikes_and_a_pressure_are_told() -> None:
    x = 0.1 * np.sin(T)
    force = 5.0 * np.sign(np.cos(T))
    force[::30] += 60.0
    q = check(Recording(T, x, force=force, pressure=2e5 + 0 * T))
    assert verdict_contains(q, "of its variance is spikes: expect wide intervals")
    assert verdict_contains(q, "rig cylinder takes its share off the force")
    assert dict(q.lines())["pressure"] == "2 bar to 2 bar"


@real
@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("openarm/collect_joint_1.csv", "stick-slip present"),
        ("openarm/collect_joint_4.csv", "stick-slip present"),
        ("pneumatic/Kidney_1bar.csv", "one speed a direction"),
        ("pneumatic/Kidney_1bar.csv", "no stick-slip"),
        ("direct_drive/est_j1_05_exp1.csv", "one way only"),
        ("openarm/collect_joint_1.csv", "55 slips of 33.37 mrad, stuck 75% of the time"),
        ("openarm/compensate_joint_2.csv", "no stick-slip"),  # a limit cycle, its sensor stalls
        ("openarm/identification_joint_2.csv", "stick-slip present"),
        ("openarm/collect_joint_3.csv", "a force balance is possible"),
    ],
)
def test_real_logs(file: str, words: str) -> None:
    assert verdict_contains(check(read(REAL / file)), words)


@real
@pytest.mark.parametrize("name", ["DATA_EMPS", "DATA_EMPS_PULSES"])
def test_emps_is_a_log_for_a_force_balance(name: str) -> None:
    columns = {
        "time": "t [s]", "position": "qm [m]", "command": "qg [m]",
        "force": {"column": "vir", "factor": "gtau", "unit": "N"},
    }  # fmt: skip
    q = check(read(REAL / f"emps/{name}.mat", columns=columns))
    sticking = "no stick-slip (no slip from rest to rest, stuck 2% of the time): breakaway and the "
    sliding = "drop after it are known as far as the axis slides slowly: a tenth of the moving "
    slow = {"DATA_EMPS": "39.45", "DATA_EMPS_PULSES": "37.91"}[name]
    assert q.verdict == (
        f"{sticking}{sliding}time is below {slow} mm/s",
        "force measured: a force balance is possible (mass, Coulomb, viscous)",
        "command recorded: motion can be simulated from it",
    )


@pytest.mark.parametrize(("seen", "words"), [
    ({"force"}, "a tenth of the moving time is below"),
    ({"command"}, "a tenth of the moving time is below"),
    (set(), "breakaway and Stribeck parameters cannot be identified"),
])  # fmt: skip
def test_a_drop_that_slow_sliding_shows_is_not_denied(seen: set[str], words: str) -> None:
    """A foreign slide under a controller does not stick, and its force shows F_S and v_SS."""
    curve = Curve(40.0, 25.0, 60.0, 1e-2)
    times, positions = sines(40.0, np.array([0.08]), np.array([0.31]))
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-4)
    m = driven.simulate(10.0, curve, curve, loop, times, positions)
    x = m.position + 1e-6 * np.random.default_rng(3).standard_normal(len(m.t))
    q = check(
        Recording(
            m.t,
            x,
            np.interp(m.t, times, positions) if "command" in seen else None,
            force=m.force if "force" in seen else None,
        )
    )
    assert verdict_contains(q, words)
    if "force" in seen:
        fit = identify(Recording(m.t, x, force=m.force), rig="forced", law="stribeck")
        verdict = {e.name: e.verdict for e in fit.estimates}
        assert verdict["F_S"] == verdict["F_C"] == "identified"


def test_slips_are_not_called_a_ramp_of_force() -> None:
    """The motor's force on a foreign slide bed rises straight for a tenth of the log at first."""
    curve = Curve(144.5463, 47.8514, 958.3, 1.0964e-3)
    motion = slide_bed.simulate(
        slide_bed.Bed(), curve, curve, *slide_bed_ramp(60.0, 5e-3), 0.0, h=2e-5
    )
    q = check(Recording(motion.t, motion.position, motion.command, force=motion.force))
    assert len(q.slips) == 10
    assert verdict_contains(q, "stick-slip present: 10 slips")
    assert not verdict_contains(q, "ramp of force")


def test_coarse_steps_of_a_long_travel_are_motion() -> None:
    """57 steps of a millimetre, in bursts of ten rows between which rows were lost."""
    row: Array = np.arange(2000, dtype=float)
    t = 0.1 * (row // 10 * 137 + row % 10)
    x = 1e-3 * np.round(28.5 * np.sin(0.3 * t))
    v = 28.5e-3 * 0.3 * np.cos(0.3 * t)
    q = check(Recording(0.1 * row, x, velocity=v, force=np.sign(v)))
    assert not verdict_contains(q, "hardly any motion")
    assert verdict_contains(q, "position is coarse: 56 mm of travel are 56 times what the sensor")
    assert any("rows are missing" in fault for fault in q.faults)


def test_jumps_where_rows_are_missing_are_no_moves() -> None:
    """Bursts of ten rows at rest or at 2 mm/s, in any order: the position leaps between them."""
    rng = np.random.default_rng(2)
    bursts = [(0.1 * rng.random(), 2e-3 * rng.integers(0, 2)) for _ in range(200)]
    x = np.concatenate([at + v * 0.1 * np.arange(10) for at, v in bursts])
    v = np.repeat([v for _, v in bursts], 10)
    t: Array = np.arange(2000, dtype=float) * 0.1
    q = check(Recording(t, 1e-4 * np.round(x / 1e-4), velocity=v, force=v))
    assert any("rows are missing there or out of order" in fault for fault in q.faults)
    assert not q.slips
    assert not verdict_contains(q, "moves from rest to rest")
    assert not verdict_contains(q, "stick-slip present")


def test_one_move_is_no_stick_slip() -> None:
    x = 0.02 * np.clip(T - 30, 0, 0.4) + 0.004 * np.minimum(T, 20.0)
    q = check(Recording(T, x, 0.004 * T))
    assert len(q.slips) == 1
    assert verdict_contains(q, "no stick-slip: one move of 8 mm from rest to rest, not repeated")


def test_a_force_that_never_changes_is_no_measurement() -> None:
    q = check(Recording(T, 0.1 * np.sin(T), force=0.0 * T))
    assert verdict_contains(q, "force is 0 N in every sample, no measurement: no force")


def test_an_axis_that_stays_where_its_command_returns_moves_one_way() -> None:
    command = 0.1 * np.minimum(T, 30.0) - 0.02 * np.maximum(T - 30.0, 0.0)
    q = check(Recording(T, 0.04 * np.minimum(T, 30.0), command))
    assert q.directions == (-1, 1)  # of the command
    assert verdict_contains(q, "moves one way only (1 stroke up)")


def test_a_force_that_stays_a_current_is_in_amperes() -> None:
    x = 0.1 * np.abs((T / 10) % 2 - 1)
    frame = {"t_s": T, "x_m": x, "force [A]": 2.0 * np.sign(np.gradient(x))}
    q = check(Recording.of(frame, drive={"signal": "A"}))
    lines = dict(q.lines())
    assert lines["force"].startswith("-2 A to 2 A")
    assert lines["position"].endswith("mm")
    assert q.units["force"] == "A"


def test_a_quality_is_a_line_and_prints_as_what_check_says() -> None:
    q = check(stick_slip_log())
    assert repr(q) == (
        "<Quality of recording: 6000 samples in 59.99 s, strokes: 1, slips: 14; "
        "likely rig: slide-bed>"
    )
    assert [value in str(q) for _, value in q.lines()] == [True] * len(q.lines())
