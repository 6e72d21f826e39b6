"""What a log is said to be good for."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from stribeck.data import Quality, Recording, check, read
from stribeck.space import Array

REAL = Path(__file__).parents[1] / ".." / "shared" / "data"
real = pytest.mark.skipif(not REAL.exists(), reason="real logs are not beside the repository")
T: Array = np.arange(6000, dtype=float) * 0.01


def stairs() -> Recording:
    k: Array = np.arange(len(T), dtype=float)
    return Recording(T, 0.02 * ((k // 400) + np.clip((k % 400 - 360) / 40, 0, 1)), 0.005 * T)


def says(quality: Quality, words: str) -> bool:
    return any(words in line for line in quality.verdict)


def test_the_numbers_of_a_made_log() -> None:
    q = check(stairs())
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
    q = check(stairs())
    assert says(q, "stick-slip present: 14 slips")
    assert says(q, "no measured force: the force-balance road is closed")
    assert says(q, "one way only")


def test_steady_motion_closes_it() -> None:
    x = 0.1 * np.abs((T / 10) % 2 - 1)
    q = check(Recording(T, x, force=np.sign(np.gradient(x))))
    assert says(q, "no stick-slip")
    assert says(q, "one speed a direction")
    assert says(q, "force-balance road is open")
    assert says(q, "no command")
    assert q.directions == (-1, 1)
    assert q.speeds == pytest.approx((0.01, 0.01, 0.01), rel=1e-3)


def test_many_speeds_are_not_called_one() -> None:
    q = check(Recording(T, 0.1 * np.sin(T)))
    assert not says(q, "one speed")


def test_a_current_without_its_factor() -> None:
    assert says(check(Recording(T, np.sin(T), current=np.cos(T))), "unless current is mapped")


def test_gaps_and_jitter_are_measured() -> None:
    t = np.delete(T, [100, 101, 102, 103, 104, 2000, 2001, 2002, 2003])
    q = check(Recording(t, np.sin(t)))
    assert q.gaps == 2
    assert q.longest_gap == pytest.approx(0.06)
    t = T + np.random.default_rng(0).uniform(-0.002, 0.002, len(T))  # 0.9 quantile of a triangle
    assert check(Recording(t, np.sin(t))).jitter == pytest.approx(0.4 * (1 - np.sqrt(0.1)), rel=0.1)


def test_a_channel_at_its_limit_is_suspected_and_others_are_not() -> None:
    force = 10 * np.sin(T)
    q = check(Recording(T, np.sin(T), force=np.clip(force, -8, 99), current=force))
    assert list(q.clipped) == ["force"]
    assert q.clipped["force"] == pytest.approx(np.mean(force <= -8), rel=1e-9)
    assert says(q, "force sits at its limit")


def test_a_rest_at_the_end_of_travel_is_no_clipping() -> None:
    assert not check(stairs()).clipped


def test_lines_speak_the_unit_of_the_workshop() -> None:
    said = dict(check(stairs()).lines())
    assert said["slips"] == "14, median 20 mm"
    assert said["samples"] == "6000 in 59.99 s, 100 Hz"
    rotary = Recording(T, stairs().position, rotary=True)
    assert dict(check(rotary).lines())["slips"] == "14, median 20 mrad"


def test_checking_changes_nothing_and_repeats() -> None:
    r = stairs()
    before = r.position.tobytes()
    assert check(r).lines() == check(r).lines()
    assert r.position.tobytes() == before


def test_a_million_samples_take_seconds() -> None:
    t: Array = np.arange(10**6, dtype=float) * 1e-3
    x = 0.1 * np.sin(t / 9) + np.random.default_rng(0).normal(0, 1e-5, len(t))
    r = Recording(t, x, 0.1 * np.sin(t / 9))
    started = time.process_time()
    check(r)
    assert time.process_time() - started < 10  # a quadratic step would take hours


@real
@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("openarm/collect_joint_1.csv", "stick-slip present"),
        ("openarm/collect_joint_4.csv", "stick-slip present"),
        ("pneumatic/Kidney_1bar.csv", "one speed a direction"),
        ("pneumatic/Kidney_1bar.csv", "no stick-slip"),
        ("direct_drive/est_j1_05_exp1.csv", "one way only"),
    ],
)
def test_real_logs(file: str, words: str) -> None:
    assert says(check(read(REAL / file)), words)
