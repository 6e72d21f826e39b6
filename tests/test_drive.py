"""Commands: lines, paths, and the samples of a log thinned to knots."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck.data.recording import Recording
from stribeck.errors import InputError
from stribeck.rig.motion.command import KNOT_TOLERANCE, Drive
from stribeck.rig.motion.track import track

T = np.arange(0.0, 10.0, 0.01)


def test_a_line_runs_at_its_speed_and_holds_at_both_ends() -> None:
    drive = Drive.line(2.0, 0.1, 6.0, -0.005)
    np.testing.assert_allclose(
        drive(np.array([0.0, 2.0, 4.0, 6.0, 9.0])), [0.1, 0.1, 0.09, 0.08, 0.08], rtol=1e-14
    )


def test_a_path_visits_its_points_at_one_speed() -> None:
    drive = Drive.path([0.05, 0.35, 0.05], 0.005, hold=1.0)
    np.testing.assert_allclose(drive.t, [0, 1, 61, 121, 122])
    np.testing.assert_array_equal(drive.x, [0.05, 0.05, 0.35, 0.05, 0.05])
    assert Drive.path([0.0, 0.1], 0.01).t.tolist() == [0.0, 10.0]


@pytest.mark.parametrize("speed", [0.0, -0.005, float("nan")])
def test_a_path_needs_a_speed(speed: float) -> None:
    with pytest.raises(InputError, match="speed"):
        Drive.path([0.0, 0.1], speed)


def test_a_path_needs_points_that_differ() -> None:
    with pytest.raises(InputError, match="differ"):
        Drive.path([0.0, 0.1, 0.1], 0.01)


def test_sampled_lines_are_thinned_to_their_corners() -> None:
    path = Drive.path([0.05, 0.08, 0.05], 0.01, hold=1.0)
    drive = Drive.sampled(T[T < 8.0], path(T[T < 8.0]))
    # A corner may be met one sample late: the cone still holds the next sample then.
    assert len(drive.t) <= 8
    np.testing.assert_allclose(drive(T), path(np.minimum(T, 7.99)), atol=KNOT_TOLERANCE * 0.031)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(2, 200), st.sampled_from(["walk", "stairs", "line"]))
def test_a_thinned_command_misses_no_sample(seed: int, n: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(1e-3, 2e-2, n))
    x = {
        "walk": np.cumsum(rng.normal(0, 1e-3, n)),
        "stairs": np.floor(t * 10) * 1e-3,
        "line": 0.3 - 0.005 * t,
    }[kind]
    drive = Drive.sampled(t, x)
    tolerance = KNOT_TOLERANCE * max(float(np.ptp(x)), 1e-12)
    assert np.abs(drive(t) - x).max() <= tolerance * 1.01 + 1e-16
    assert np.isin(drive.t, t).all()
    assert drive.t[0] == t[0]
    assert drive.t[-1] == t[-1]
    if kind == "line":
        assert len(drive.t) == 2


def test_a_recorded_command_is_what_drives() -> None:
    command = np.interp(T, [0, 3, 10], [0.1, 0.1, 0.2])
    drive = Drive.of(Recording(T, np.zeros_like(T), command=command), ramp_speed=7.0)
    np.testing.assert_allclose(drive(T), command, atol=1e-6)


def test_without_a_command_the_ramp_starts_at_the_mean_of_fifty_samples() -> None:
    # Section 4.3, step 1.
    rng = np.random.default_rng(1)
    x = 0.112 + 0.3e-3 * rng.standard_normal(len(T))
    drive = Drive.of(Recording(T + 5.0, x), ramp_speed=0.005)
    np.testing.assert_allclose(
        drive(T + 5.0), x[:50].mean() + 0.005 * np.minimum(T, T[-1]), rtol=1e-12
    )


def test_without_a_speed_either_the_ramp_has_the_mean_speed_of_the_log() -> None:
    x = 0.3 - 0.004 * T + 1e-3 * np.sin(20 * T)
    drive = Drive.of(Recording(T, x))
    assert (drive.x[-1] - drive.x[0]) / (drive.t[-1] - drive.t[0]) == pytest.approx(
        np.polyfit(T, x, 1)[0], rel=1e-9
    )


@pytest.mark.parametrize(
    ("t", "x", "times", "x0", "measured"),
    [
        ([0.0, 1.0], [0.0, 1.0], [], 0.0, None),
        ([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], 0.0, [0.1]),
        ([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], math.nan, None),
        ([0.0, 1.0], [0.0, 1.0], [0.0, math.nan], 0.0, None),
        ([0.0, 1.0], [0.0, math.inf], [0.0, 1.0], 0.0, None),
        ([0.0, math.nan], [0.0, 1.0], [0.0, 1.0], 0.0, None),
        ([0.0, 1.0, 2.0], [0.0, 1.0], [0.0, 1.0], 0.0, None),
        ([], [], [0.0, 1.0], 0.0, None),
    ],
)
def test_a_track_that_no_kernel_could_walk_is_refused(
    t: list[float], x: list[float], times: list[float], x0: float, measured: list[float] | None
) -> None:
    shown = None if measured is None else np.array(measured)
    with pytest.raises(InputError, match="a track"):
        track(Drive(np.array(t), np.array(x)), np.array(times), x0, shown)
