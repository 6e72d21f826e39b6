"""Long logs: filtered in blocks, in bounded memory, with the results of short ones."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, cheby1, sosfiltfilt

from stribeck import Recording, identify
from stribeck.data.derived_channel import Slope, picked
from stribeck.data.filtering import Bridged, Gaps, bridged
from stribeck.data.gate.leaps import middle_of_seven
from stribeck.data.resolution import LONG, noise_of, step
from stribeck.data.runs import within
from stribeck.data.zero_phase import BLOCK, zero_phase
from stribeck.rig.forced import FORCED
from stribeck.space import Array


def log(n: int, rate: float = 1000.0, seed: int = 0) -> Recording:
    """Two tones of 5 kg under 12 N, 30 N s/m and 0.5 N, whose force has noise of 0.3 N."""
    rng, t = np.random.default_rng(seed), np.arange(n) / rate
    w, w2 = 2 * np.pi * 0.23, 2 * np.pi * 0.031
    v = 0.1 * w * np.cos(w * t) + 0.05 * w2 * np.cos(w2 * t + 1)
    a = -0.1 * w * w * np.sin(w * t) - 0.05 * w2 * w2 * np.sin(w2 * t + 1)
    force = 12 * np.sign(v) + 30 * v + 5 * a + 0.5 + 0.3 * rng.standard_normal(n)
    x = 0.1 * np.sin(w * t) + 0.05 * np.sin(w2 * t + 1) + 1e-7 * rng.standard_normal(n)
    return Recording(t=t, position=x, force=force)


@pytest.mark.parametrize("n", [30, BLOCK, BLOCK + 1, 3 * BLOCK - 20])
@pytest.mark.parametrize("every", [1, 10])
def test_blocks_are_filtered_as_everything_at_once_is(n: int, every: int) -> None:
    x = np.random.default_rng(1).standard_normal((n, 2)).cumsum(axis=0)
    for sections in (butter(4, 0.2, output="sos"), cheby1(8, 0.05, 0.08, output="sos")):
        kept = slice((n - 1) % every, n, every)
        ours = zero_phase(sections, lambda at: x[at], n, 24, kept)
        theirs = sosfiltfilt(sections, x, axis=0, padlen=24)[kept]
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(x).max())


@pytest.mark.parametrize("order", [1, 2, 7, 8, 9, 17])
def test_a_filter_has_any_number_of_sections(order: int) -> None:
    sections = butter(order, 0.3, output="sos")
    x = np.random.default_rng(7).standard_normal((900, 3))
    theirs = sosfiltfilt(sections, x, axis=0, padlen=60)
    ours = zero_phase(sections, lambda at: x[at], len(x), 60, slice(0, len(x), 1))
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12)


@pytest.mark.parametrize("accuracy", [2, 6])
@pytest.mark.parametrize("n", [2, 6, 7, 30])
def test_differences_are_exact_for_polynomials_of_their_order(accuracy: int, n: int) -> None:
    """Where they have all neighbours, whichever samples are asked for, and at once or not."""
    t, reach = (np.arange(n) - 3.0) / 4.0, accuracy // 2
    curve = np.polynomial.Polynomial(np.arange(1.0, accuracy + 2.0))
    slope, exact = Slope(curve(t), 4.0, accuracy), curve.deriv()(t)
    inner = slice(reach, max(n - reach, reach))
    np.testing.assert_allclose(slope[:][inner], exact[inner], rtol=1e-9)
    ends = np.gradient(curve(t), t)
    for end in (slice(0, min(reach, n)), slice(max(n - reach, 0), n)):
        np.testing.assert_allclose(slope[:][end], ends[end], rtol=1e-9)
    for part in (slice(1, n - 1), slice(0, n, 3), np.array([n - 1, 0]), slice(n, n)):
        np.testing.assert_array_equal(slope[part], slope[:][part])


def test_samples_of_a_channel_are_picked_block_by_block() -> None:
    """A slope of a slope at places close together and far apart, and at every so many samples."""
    n = 3 * BLOCK + 11
    x = np.random.default_rng(6).standard_normal(n).cumsum()
    slope = Slope(Slope(x, 10.0), 10.0)
    whole = slope[:]
    near = np.arange(0, 900, 7)
    places = np.concatenate([near, [BLOCK - 1, BLOCK, n - 2, n - 1]])
    for channel in (slope, whole):
        np.testing.assert_array_equal(picked(channel, places), whole[places])
        assert picked(channel, places[:0]).shape == (0,)
    np.testing.assert_array_equal(slope[5::20_000], whole[5::20_000])


def test_gaps_are_bridged_block_by_block_as_all_at_once() -> None:
    rng = np.random.default_rng(2)
    x, gaps = rng.standard_normal(1000), within(rng.random(1000) < 0.02, 7)
    assert 0.1 < gaps.mean() < 0.9
    whole, blocks = bridged(x, gaps), Bridged(lambda at: x[at], Gaps(gaps))
    parts = [blocks(slice(k, min(k + 37, 1000))) for k in range(0, 1000, 37)]
    np.testing.assert_array_equal(np.concatenate(parts), whole)
    np.testing.assert_array_equal(blocks(np.arange(0, 1000, 3)), whole[::3])
    sure = np.flatnonzero(~gaps)
    np.testing.assert_allclose(whole, np.interp(np.arange(1000), sure, x[sure]), atol=1e-12)


def test_within_reaches_as_far_as_counting_says() -> None:
    marked = np.random.default_rng(3).random(300) < 0.05
    at = np.flatnonzero(marked)
    for reach in (0, 1, 6, 400):
        near = [bool((np.abs(at - i) <= reach).any()) for i in range(300)]
        np.testing.assert_array_equal(within(marked, reach), near)
    assert not within(np.zeros(5, dtype=bool), 2).any()


def test_the_network_of_comparisons_finds_medians() -> None:
    rows = np.random.default_rng(4).integers(0, 5, (20_000, 7)).astype(float)
    np.testing.assert_array_equal(middle_of_seven(rows), np.median(rows, axis=1))


def test_a_long_channel_shows_its_step_and_noise_in_stretches() -> None:
    rng, n = np.random.default_rng(5), LONG + 100_000
    smooth = np.sin(np.arange(n) / 3000.0)
    counted = 1e-4 * np.round(smooth / 1e-4)
    assert step(counted) == pytest.approx(1e-4, rel=1e-6)
    assert noise_of(smooth + 1e-3 * rng.standard_normal(n)) == pytest.approx(1e-3, rel=0.02)


def test_a_short_log_gives_what_it_gave_before_logs_were_filtered_in_blocks() -> None:
    plain = replace(FORCED, filtering=replace(FORCED.filtering, accuracy=2))
    fit = identify(log(40_000), rig=plain)
    np.testing.assert_allclose(
        fit.p, [11.995674753598298, 30.03029321715115, 4.9977794294942, 0.5005913779134454],
        rtol=1e-9,
    )  # fmt: skip
    assert fit.balance is not None
    assert fit.balance.relative_error == pytest.approx(0.5869036140454393, rel=1e-9)


def test_a_balance_takes_a_hundred_and_fifty_bytes_a_row_beside_its_log() -> None:
    """A hundred of a log ten times as long, of which blocks are a smaller part."""
    recording = log(300_000)
    identify(log(20_000), rig="forced")  # what is loaded once
    tracemalloc.start()
    try:
        identify(recording, rig="forced")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 150 * len(recording)


@pytest.mark.parametrize("rate", [50.0, 1000.0])
def test_a_force_in_time_is_not_moved_for_its_noise(rate: float) -> None:
    """Slow tones show a delay to some 20 ms: noise that interpolation lowers shows none."""
    for seed in (5, 7):
        fit = identify(log(int(rate * 100), rate, seed), rig="forced")
        (mass,) = (e for e in fit.estimates if e.name == "M")
        assert fit.delay == 0.0
        assert mass.low < 5.0 < mass.high


def test_arrays_of_a_recording_are_shared_and_others_are_copied() -> None:
    first = log(100)
    again = Recording(t=first.t, position=first.position, force=first.force)
    assert np.shares_memory(again.position, first.position)
    mine: Array = np.linspace(0.0, 1.0, 100)
    view = mine.view()
    view.setflags(write=False)
    assert not np.shares_memory(Recording(t=first.t, position=view).position, mine)
