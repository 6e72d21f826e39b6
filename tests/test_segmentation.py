"""Strokes, rests and slips of motions whose rests and slips are known."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck.data import Recording, noise, read, rests, segment, slips, step, strokes
from stribeck.space import Array

REAL = Path(__file__).parents[1] / ".." / "shared" / "data"
real = pytest.mark.recordings
DT = 0.01
RAMP = 5e-3  # m/s


@dataclass(frozen=True)
class Staircase:
    """A slide under a ramp: rests, and slips at constant speed."""

    t: Array
    x: Array
    command: Array
    starts: list[int]
    stops: list[int]
    jumps: list[float]


def staircase(seed: int, n: int = 12, direction: int = 1) -> Staircase:
    """n slips of 15 to 40 mm that last 0.3 to 0.6 s; rests of 3 to 8 s follow from the ramp."""
    rng = np.random.default_rng(seed)
    jumps = rng.uniform(0.015, 0.040, n)
    times, levels, starts, stops, time = [0.0], [0.0], [], [], 0
    for jump in jumps:
        dwell, slip = round(jump / RAMP / DT), round(rng.uniform(0.3, 0.6) / DT)
        start = time + dwell
        time = start + slip
        starts.append(start)
        stops.append(time)
        times += [start, time]
        levels += [levels[-1], levels[-1] + jump]
    k: Array = np.arange(time + 300, dtype=float)
    x = np.interp(k, times, levels)
    command = RAMP * DT * k
    return Staircase(k * DT, direction * x, direction * command, starts, stops,
                     (direction * jumps).tolist())  # fmt: skip


def transducer(s: Staircase, seed: int, *, sd: float, q: float, hold: int) -> Array:
    """The position by a transducer: noisy, held for some samples, quantised."""
    rng = np.random.default_rng([seed, 7])
    k = np.arange(len(s.x)) // hold * hold
    x = (s.x + rng.normal(0, sd, len(s.x)))[k] if sd else s.x[k]
    return np.rint(x / q) * q if q else x


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("commanded", [True, False])
@pytest.mark.parametrize(
    ("sd", "q", "hold", "samples"),
    [
        (0.0, 0.0, 1, 1),
        (0.0, 1e-6, 1, 1),
        (0.0, 1e-4, 1, 3),
        (0.3e-3, 0.0, 1, 2.5),
        (0.3e-3, 0.1e-3, 1, 2.5),
        (0.3e-3, 0.1e-3, 2, 2.5),
    ],
)
def test_slips_are_found_where_they_are(
    direction: int, commanded: bool, sd: float, q: float, hold: int, samples: float
) -> None:
    """All 12 slips and no other; edges within `samples` in the mean, 8 at most; jumps to 2 sd."""
    for seed in range(3):
        s = staircase(seed, direction=direction)
        r = Recording(
            s.t, transducer(s, seed, sd=sd, q=q, hold=hold), s.command if commanded else None
        )
        detected = slips(r)
        assert len(detected) == len(s.starts)
        off = np.abs([[f.start, f.stop] for f in detected] - np.transpose([s.starts, s.stops]))
        assert off.mean() <= samples + hold / 2
        assert off.max() <= 8
        np.testing.assert_allclose([f.jump for f in detected], s.jumps, atol=2 * sd / 3 + q + 1e-5)
        spans = np.subtract(s.stops, s.starts) * DT
        peaks = [f.peak_speed for f in detected]
        np.testing.assert_allclose(peaks, np.abs(s.jumps) / spans, rtol=0.35)


@pytest.mark.parametrize(("sd", "q", "hold"), [(0, 0, 1), (0.3e-3, 0.1e-3, 2)])
def test_rests_fill_the_time_between_slips(sd: float, q: float, hold: int) -> None:
    s = staircase(5)
    r = Recording(s.t, transducer(s, 5, sd=sd, q=q, hold=hold), s.command)
    truth = np.ones(len(s.t), dtype=bool)
    for a, b in zip(s.starts, s.stops, strict=True):
        truth[a + 1 : b] = False
    at_rest = np.zeros(len(s.t), dtype=bool)
    for interval in rests(r):
        at_rest[interval] = True
    assert (at_rest != truth).mean() < (0.03 if sd else 0.005)
    assert segment(r).stuck == pytest.approx(truth.mean(), abs=0.02)


@pytest.mark.parametrize("hold", [1, 2, 3])
@pytest.mark.parametrize("q", [0.0, 0.1e-3, 0.3e-3])
def test_noise_is_told_from_quantisation_hold_and_motion(q: float, hold: int) -> None:
    """Within 10 %: 6000 / hold independent values give a relative sd below 3 %; seeds fixed."""
    s = staircase(1)
    r = Recording(s.t, transducer(s, 1, sd=0.3e-3, q=q, hold=hold))
    assert noise(r) == pytest.approx(0.3e-3, rel=0.1)


@pytest.mark.parametrize("q", [0.0, 1e-6, 1e-4])
def test_a_silent_sensor_has_no_noise(q: float) -> None:
    s = staircase(2)
    assert noise(Recording(s.t, transducer(s, 2, sd=0, q=q, hold=1))) <= 1e-9 + q / 10


@settings(max_examples=60)
@given(st.floats(-9, 2), st.integers(0, 99))
def test_the_step_of_a_quantised_channel(exponent: float, seed: int) -> None:
    q = 10.0**exponent
    x = np.cumsum(np.random.default_rng(seed).normal(0, 3 * q, 3000))
    assert step(np.rint(x / q) * q) == pytest.approx(q, rel=1e-3)
    assert step(x) == 0


@pytest.mark.parametrize("sd", [0.0, 0.3e-3])
@pytest.mark.parametrize("commanded", [True, False])
def test_steady_motion_has_neither_rests_nor_slips(sd: float, commanded: bool) -> None:
    t: Array = np.arange(4000, dtype=float) * DT
    x = RAMP * t + np.random.default_rng(3).normal(0, sd, len(t))
    r = Recording(t, x, RAMP * t if commanded else None)
    assert not slips(r)
    assert not rests(r)
    (stroke,) = strokes(r)
    assert stroke.direction == 1
    assert stroke.speed == pytest.approx(RAMP, rel=0.02)


def test_strokes_to_and_fro() -> None:
    t: Array = np.arange(6000, dtype=float) * DT
    r = Recording(t, 0.1 * np.sin(2 * np.pi * t / 20) + 0.0)
    assert [s.direction for s in strokes(r)] == [1, -1, 1, -1, 1, -1, 1]
    for s in strokes(r)[1:-1]:
        assert s.travel == pytest.approx(0.2, rel=1e-3)
        assert s.rows.stop - s.rows.start == pytest.approx(1000, abs=45)
    assert not slips(r)


def test_standstill_before_and_after_is_no_stroke() -> None:
    x = np.concatenate([np.zeros(1000), np.linspace(0, 0.1, 501), np.full(2000, 0.1)])
    (stroke,) = strokes(Recording(np.arange(len(x), dtype=float) * DT, x))
    assert stroke.rows.start == pytest.approx(1000, abs=3)
    assert stroke.rows.stop == pytest.approx(1501, abs=3)
    assert stroke.speed == pytest.approx(0.02, rel=0.01)


@settings(max_examples=25)
@given(st.integers(0, 50), st.floats(-4, 4), st.floats(-3, 3), st.sampled_from([1, -1]))
def test_no_threshold_has_a_unit(seed: int, length: float, time: float, sign: int) -> None:
    """Other units, a mirror image: the same samples rest and slip."""
    s = staircase(seed, n=4)
    x = transducer(s, seed, sd=0.3e-3, q=0, hold=2)
    a = Recording(s.t, x, s.command)
    b = Recording(s.t * 10**time, sign * x * 10**length, sign * s.command * 10**length)
    assert len(rests(a)) == len(rests(b))
    assert [(f.start, f.stop) for f in slips(a)] == [(f.start, f.stop) for f in slips(b)]


def test_a_slip_between_two_samples_is_seen() -> None:
    x = np.repeat([0.0, 0.02, 0.04, 0.06], 100)
    detected = slips(Recording(np.arange(400, dtype=float) * DT, x, np.linspace(0, 0.08, 400)))
    assert [(f.start, f.stop) for f in detected] == [(99, 100), (199, 200), (299, 300)]


@real
@pytest.mark.parametrize(
    ("joint", "jumps", "share", "median"), [(1, 51, 0.77, 33), (3, 46, 0.80, 80), (4, 20, 0.96, 98)]
)
def test_arm_joints_in_stick_slip(joint: int, jumps: int, share: float, median: float) -> None:
    """Published with the data: slips above 4 mrad, their median in mrad, the stuck share."""
    segmentation = segment(read(REAL / f"openarm/collect_joint_{joint}.csv"))
    large = [abs(s.jump) for s in segmentation.slips if abs(s.jump) > 4e-3]
    assert len(large) == pytest.approx(jumps, rel=0.1)
    assert np.median(large) * 1e3 == pytest.approx(median, rel=0.1)
    assert segmentation.stuck == pytest.approx(share, rel=0.1)
    assert segmentation.step == pytest.approx(0.000383, rel=0.01)


@real
@pytest.mark.parametrize("file", ["DATA_EMPS", "DATA_EMPS_PULSES"])
def test_a_slide_that_never_sticks(file: str) -> None:
    columns = {"time": "t [s]", "position": "qm [m]", "command": "qg [m]"}
    segmentation = segment(read(REAL / f"emps/{file}.mat", columns=columns))
    assert [s.direction for s in segmentation.strokes] == [1, -1] * 4  # seven reversals
    assert not segmentation.slips
    assert segmentation.stuck < 0.03


@real
def test_a_cylinder_at_constant_speed() -> None:
    segmentation = segment(read(REAL / "pneumatic/Kidney_1bar.csv"))
    assert [s.direction for s in segmentation.strokes] == [1, -1] * 10
    assert not segmentation.slips
    assert segmentation.stuck < 0.03
    assert segmentation.step == pytest.approx(4.39e-6, rel=0.01)


def test_a_swing_after_a_release_is_no_slip() -> None:
    """A pendulum held at 0.6 rad falls, swings to the other side, and comes to rest below."""
    t: Array = np.arange(1200, dtype=float) * DT / 2
    s = np.maximum(t - 2.0, 0.0)
    x = 0.6 * np.exp(-1.2 * s) * np.cos(8.0 * s)
    x = 1.5e-3 * np.rint(x / 1.5e-3)
    assert segment(Recording(t, x, rotary=True)).slips == ()


def test_an_axis_does_not_rest_while_its_recorded_velocity_goes_on() -> None:
    """Bursts of ten rows at rest or at 2 mm/s in any order: leaps between them make the pace."""
    rng = np.random.default_rng(2)
    at, v = 0.1 * rng.random(200), 2e-3 * rng.integers(0, 2, 200)
    x = np.repeat(at, 10) + np.repeat(v, 10) * 0.1 * np.tile(np.arange(10), 200)
    t: Array = np.arange(2000, dtype=float) * 0.1
    x = 1e-3 * np.rint(x / 1e-3)
    assert segment(Recording(t, x)).stuck > 0.8
    stuck = segment(Recording(t, x, velocity=np.repeat(v, 10))).stuck
    assert stuck == pytest.approx(np.mean(v == 0), abs=0.1)


def test_an_offset_of_the_recorded_velocity_moves_no_axis() -> None:
    s = staircase(1)
    v = np.gradient(s.x, DT) + 1e-3
    r = Recording(s.t, s.x, velocity=v)
    assert segment(r).stuck == segment(Recording(s.t, s.x)).stuck


def test_what_never_leaves_its_band_rests_throughout() -> None:
    t: Array = np.arange(500, dtype=float) * DT
    s = segment(Recording(t, 1e-4 * np.rint(2 * np.sin(t))))
    assert (s.stuck, s.rests, s.slips) == (1.0, (slice(0, 500),), ())


def test_moves_at_odd_times_are_no_noise_of_a_held_sensor() -> None:
    rng = np.random.default_rng(3)
    dwell = np.where(rng.random(300) < 0.4, 1, rng.integers(8, 25, 300))
    x = np.repeat(rng.integers(-9, 10, 300) * 1e-3, dwell) + 0.03
    x += 1e-4 * (rng.random(len(x)) < 0.02)  # flickers by a step now and then
    t: Array = np.arange(len(x), dtype=float) * 0.1
    assert noise(Recording(t, x)) == 0.0


def test_the_step_of_values_rounded_to_digits_is_that_of_most() -> None:
    rng = np.random.default_rng(5)
    position = rng.uniform(0, 3000, 4000)
    written = np.array([float(f"{value:.3g}") for value in position])
    assert step(written) == pytest.approx(10.0)
    assert step(np.rint(position)) == pytest.approx(1.0)
