"""The twin: statistics of its sensors, its truth, which is not in the log."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.errors import InputError
from stribeck.friction import LAWS
from stribeck.rig.motion.track import track
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED, published_both
from stribeck.rig.twin import CURRENT_SPAN, POSITION_SPAN, VELOCITY_SPAN, TestBed
from stribeck.space import Array

BED = TestBed()
FINE = replace(BED, bits=32)


def rng() -> np.random.Generator:
    return np.random.default_rng(7)


def test_echoes_are_noisy_as_said_and_held_until_the_next() -> None:
    bed = replace(BED, rate=1000.0, echo_rate=40.0, echo_noise=0.2e-3)
    t = np.arange(100_000) / 1000.0
    x = 0.1 + 5e-3 * t
    echoes = bed._transducer(t, x, rng())  # noqa: SLF001 - the sensor by itself
    runs = echoes.reshape(-1, 25)
    assert (runs == runs[:, :1]).all()  # one value for the 25 samples of each echo
    noise = runs[:, 0] - x.reshape(-1, 25)[:, 0]
    # 4,000 draws: the sample deviation is within 4 of its own deviations (false alarm 6e-5),
    # the mean too; the seed is fixed.
    assert noise.std() == pytest.approx(0.2e-3, rel=4 / math.sqrt(2 * 4000))
    assert abs(noise.mean()) < 4 * 0.2e-3 / math.sqrt(4000)
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 4 / math.sqrt(4000)


def test_without_noise_and_hold_the_transducer_shows_the_position() -> None:
    bed = replace(BED, echo_noise=0.0, echo_rate=100.0)
    t = np.arange(500) / 100.0
    x = np.sin(t)
    np.testing.assert_allclose(bed._transducer(t, x, rng()), x, atol=1e-12)  # noqa: SLF001


@pytest.mark.parametrize("frequency", [0.5, 5.0, 12.0])
def test_the_differentiator_has_the_gain_and_phase_of_its_circuit(frequency: float) -> None:
    # H(s) = s w^2 / (s^2 + sqrt(2) w s + w^2); at 1 kHz the bilinear rule is within 0.3 %.
    bed = replace(BED, rate=1000.0, corner=5.0)
    w, s = 2 * math.pi * 5.0, 2j * math.pi * frequency
    H = s * w**2 / (s**2 + math.sqrt(2) * w * s + w**2)
    t = np.arange(20_000) / 1000.0
    y = bed._differentiate(np.sin(2 * math.pi * frequency * t))  # noqa: SLF001
    settled = t >= 10.0  # whole periods, long after the start
    response = 2j * np.mean(y[settled] * np.exp(-2j * math.pi * frequency * t[settled]))
    assert abs(response) == pytest.approx(abs(H), rel=3e-3)
    assert np.angle(response / H) == pytest.approx(0.0, abs=5e-3)


def test_the_differentiator_of_a_ramp_is_its_speed() -> None:
    t = np.arange(1000) / BED.rate
    y = BED._differentiate(0.3 - 5e-3 * t)  # noqa: SLF001
    assert y[0] == pytest.approx(0.0, abs=1e-3)
    np.testing.assert_allclose(y[500:], -5e-3, rtol=1e-9)


@pytest.mark.parametrize("span", [POSITION_SPAN, VELOCITY_SPAN, CURRENT_SPAN])
def test_the_converter_has_twelve_bits_over_its_span(span: tuple[float, float]) -> None:
    low, high = span
    step = (high - low) / 4096
    values = np.linspace(low - step, high + step, 100_001)
    read = BED._convert(values, span)  # noqa: SLF001
    levels = np.unique(read)
    assert len(levels) == 4096
    np.testing.assert_allclose(np.diff(levels), step, rtol=1e-9)
    inside = (values > low) & (values < high)
    assert np.abs(read - values)[inside].max() <= step / 2 * (1 + 1e-9)
    assert read[0] == levels[0]
    assert read[-1] == levels[-1]


def test_a_position_level_is_a_tenth_of_a_millimetre() -> None:
    read = np.unique(BED.run("up").recording.position)
    assert (POSITION_SPAN[1] - POSITION_SPAN[0]) / 4096 == pytest.approx(0.0977e-3, rel=1e-3)
    codes = read / (0.4 / 4096) - 0.5
    np.testing.assert_allclose(codes, np.round(codes), atol=1e-8)


def test_the_current_is_the_force_of_the_controller_over_the_drive_constant() -> None:
    twin = replace(FINE, current_noise=0.0).run("both")
    assert twin.recording.command is not None
    assert twin.recording.force is not None
    e = twin.recording.command - twin.motion.position[0]
    k_hat = np.where(e > 0, 3500.0, 2800.0)
    assert twin.recording.current is not None
    np.testing.assert_allclose(twin.recording.current, k_hat * e / 101.1021, rtol=1e-5, atol=1e-8)
    np.testing.assert_allclose(twin.recording.force, twin.recording.current * 101.1021, rtol=1e-5)


def test_the_current_sensor_is_noisy_as_said() -> None:
    quiet, noisy = replace(FINE, current_noise=0.0).run("up"), FINE.run("up")
    assert quiet.recording.current is not None
    assert noisy.recording.current is not None
    noise = noisy.recording.current - quiet.recording.current
    n = len(noise)
    # Within 4 deviations of the sample deviation (false alarm 6e-5), seed fixed.
    assert noise.std() == pytest.approx(5e-3, rel=4 / math.sqrt(2 * n))
    assert abs(noise.mean()) < 4 * 5e-3 / math.sqrt(n)


def test_a_seed_is_a_recording_and_another_seed_another() -> None:
    first, repeated, reseeded = BED.run("up", seed=3), BED.run("up", seed=3), BED.run("up", seed=4)
    for name, values in first.recording.channels().items():
        assert values.tobytes() == repeated.recording.channels()[name].tobytes()
    assert (first.recording.position != reseeded.recording.position).any()
    assert not np.array_equal(
        first.recording.channels()["current"], reseeded.recording.channels()["current"]
    )
    # The motion is nature's, not the sensors'.
    np.testing.assert_array_equal(first.motion.position, reseeded.motion.position)


def test_noise_leaves_the_global_generator_alone() -> None:
    before = np.random.get_state(legacy=False)  # noqa: NPY002 - that it is not touched is the point
    BED.run("up")
    after = np.random.get_state(legacy=False)  # noqa: NPY002
    assert str(before) == str(after)


@pytest.mark.parametrize(
    ("direction", "start", "points", "seconds"),
    [("up", 0.044, (0.05, 0.35), 62.0), ("down", 0.352, (0.35, 0.05), 62.0),
     ("both", 0.044, (0.05, 0.35, 0.05), 122.0)],
)  # fmt: skip
def test_runs_go_where_the_paper_says(
    direction: str, start: float, points: tuple[float, ...], seconds: float
) -> None:
    twin = BED.run(direction)  # type: ignore[arg-type]
    recording, truth = twin.recording, twin.motion.position[0]
    assert recording.t[-1] == pytest.approx(seconds, abs=0.011)
    assert np.diff(recording.t) == pytest.approx(0.01)
    assert recording.command is not None
    for i, point in enumerate(points):
        assert recording.command[round((1 + 60 * i) / 0.01)] == pytest.approx(point, abs=1e-9)
    assert recording.position[:50].mean() == pytest.approx(start, abs=2e-4)
    assert np.abs(recording.position - truth).max() < 6e-3  # held for 20 ms at 82 mm/s, and noise
    assert np.median(np.abs(recording.position - truth)) < 0.5e-3


def test_the_truth_is_what_moved_and_is_not_in_the_log() -> None:
    twin = BED.run("both")
    np.testing.assert_array_equal(twin.truth, published_both())
    hidden = [twin.motion.position[0], twin.motion.velocity[0], twin.motion.force[0]]
    channels = twin.recording.channels()
    assert set(channels) == {"position", "command", "velocity", "force", "current"}
    assert not twin.recording.extra
    assert not twin.recording.source.file
    assert not twin.recording.notes
    for name, values in channels.items():
        if name != "command":
            for truth in hidden:
                assert np.mean(np.isclose(values, truth, rtol=1e-9, atol=0)) < 0.01, name
    np.testing.assert_allclose(
        channels["command"], BED.drive("both")[0](twin.recording.t), atol=1e-15
    )


def test_another_truth_moves_otherwise() -> None:
    twin = BED.run("up", law=LAWS["stribeck"], truth=PUBLISHED["left"])
    x: Array = twin.motion.position[0]
    drive, x0 = BED.drive("up")
    log_track = track(drive, twin.recording.t, x0)
    exact = SLIDE_BED.move(LAWS["stribeck"], PUBLISHED["left"][None], log_track).position[0]
    np.testing.assert_array_equal(x, exact)
    assert np.abs(x - BED.run("up").motion.position[0]).max() > 5e-3


@pytest.mark.parametrize(
    ("setting", "message"),
    [({"rate": 0.0}, "rate"), ({"echo_rate": -1.0}, "echo_rate"), ({"speed": 0.0}, "speed"),
     ({"echo_noise": -1e-3}, "echo_noise"), ({"hold": -1.0}, "hold"), ({"corner": 60.0}, "corner"),
     ({"rate": math.nan}, "rate")],
)  # fmt: skip
def test_sensors_that_cannot_be_are_refused(setting: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(BED, **setting)  # type: ignore[arg-type]


def test_an_unknown_direction_is_refused() -> None:
    with pytest.raises(InputError, match="'sideways' is not one of up, down, both"):
        BED.run("sideways")  # type: ignore[arg-type]
