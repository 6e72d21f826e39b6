"""Samples that repeat because the sensor holds its value, against those of an axis at rest."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck import Recording
from stribeck.data.repeated_samples import is_new
from stribeck.rig.twin import TestBed
from stribeck.space import Array

T: Array = np.arange(2000) * np.float64(0.01)


def sampled_and_held(x: Array, hold: int) -> Recording:
    """A log whose sensor measures every `hold` samples and repeats its value between."""
    return Recording(t=T, position=x[np.arange(len(x)) // hold * hold])


@given(hold=st.integers(2, 8), seed=st.integers(0, 99))
@settings(max_examples=30)
def test_a_noisy_sensor_that_holds(hold: int, seed: int) -> None:
    x = 0.005 * T + 1e-4 * np.random.default_rng(seed).standard_normal(len(T))
    np.testing.assert_array_equal(is_new(sampled_and_held(x, hold)), np.arange(len(T)) % hold == 0)


@pytest.mark.parametrize("hold", [2, 5])
def test_a_moving_sensor_that_holds_without_noise(hold: int) -> None:
    # At one speed the staircase could as well be a coarse scale; a swing has steps of any height.
    x = np.round(0.1 * np.sin(T) / 1e-5) * 1e-5
    new = is_new(sampled_and_held(x, hold))
    assert not new[np.arange(len(T)) % hold > 0].any()
    assert new[::hold].mean() > 0.99  # at its turning points it moves less than a step


@pytest.mark.parametrize("noise", [0.0, 1e-4])
def test_a_sensor_that_measures_every_sample(noise: float) -> None:
    x = 0.005 * T + noise * np.random.default_rng(1).standard_normal(len(T))
    assert is_new(Recording(t=T, position=x)).all()


def test_rest_at_the_resolution_of_a_sensor_is_no_holding() -> None:
    stairs = np.floor(T / 2.0) * 0.02 + np.minimum(T % 2.0, 0.1) * 0.2  # rests 1.9 s in 2 s
    x: Array = np.round(stairs / 1e-3) * 1e-3
    assert (np.diff(x) == 0).mean() > 0.9
    assert is_new(Recording(t=T, position=x)).all()


def test_the_twin_repeats_an_echo_twice() -> None:
    log = TestBed(rate=100.0, echo_rate=50.0).run("up", seed=5).recording
    new = is_new(log)
    # Two echoes within one converter step look like one: 0.1 mm against 0.3 sqrt(2) mm of noise,
    # erf(0.1 / 0.85 / sqrt(2)) = 9 %. None is counted where there was no echo.
    assert not new[1::2].any()
    assert 0.85 < new[::2].mean() < 0.97
    assert is_new(TestBed(rate=50.0, echo_rate=50.0).run("up", seed=5).recording).all()


@pytest.mark.parametrize("n", [2, 3, 5, 30])
def test_logs_too_short_to_tell(n: int) -> None:
    assert is_new(Recording(t=T[:n], position=np.repeat(T, 2)[:n])).shape == (n,)
    assert is_new(Recording(t=T[:n], position=np.zeros(n))).all()
