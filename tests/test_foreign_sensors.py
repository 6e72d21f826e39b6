"""What the foreign sensors do to a table of channels."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from foreign import sensors
from foreign.clock import Array
from foreign.sensors import Table


@pytest.fixture
def table() -> Table:
    """Ten seconds at 1 kHz: a slow sine and a faster one."""
    t = 1e-3 * np.arange(10_001)
    return {"t": t, "position": np.sin(t), "force": np.cos(3.0 * t)}


def changed(table: Table, other: Table, channel: str) -> Array:
    """Where a channel differs; nothing else may."""
    for name in table:
        if name != channel:
            assert_array_equal(table[name], other[name])
    differs: Array = table[channel] != other[channel]
    return differs


def test_samples_are_taken_between_steps(table: Table) -> None:
    log = sensors.sampled(table, 0.0125)
    assert_allclose(np.diff(log["t"]), 0.0125)
    assert_allclose(log["position"], np.sin(log["t"]), atol=1e-6)
    rough = sensors.sampled(table, 0.0125, np.random.default_rng(1), jitter=0.3)
    spans = np.diff(rough["t"])
    assert 0.4 * 0.0125 < spans.min() < 0.6 * 0.0125
    assert_allclose(rough["position"], np.sin(rough["t"]), atol=1e-6)


@pytest.mark.parametrize("memory", [0.0, 5.0, 20.0])
def test_noise_has_its_size_and_its_memory(memory: float) -> None:
    white = np.random.default_rng(4).standard_normal(400_000)
    noise = sensors.autoregressive(white, memory)
    assert noise.std() == pytest.approx(1.0, abs=0.02)
    lag = max(int(memory), 1)
    alike = np.mean(noise[lag:] * noise[:-lag])
    assert alike == pytest.approx(np.exp(-1.0) if memory else 0.0, abs=0.03)


def test_noise_is_its_generators(table: Table) -> None:
    one, again, other = (
        sensors.noisy(table, "force", 0.3, np.random.default_rng(seed), 3.0) for seed in (1, 1, 2)
    )
    assert_array_equal(one["force"], again["force"])
    assert changed(one, other, "force").all()
    assert (one["force"] - table["force"]).std() == pytest.approx(0.3, rel=0.1)


def test_steps_are_whole_and_err_by_half(table: Table) -> None:
    log = sensors.quantised(table, "position", 0.01)
    changed(table, log, "position")
    steps = log["position"] / 0.01
    assert_allclose(steps, np.round(steps), atol=1e-9)
    assert np.abs(log["position"] - table["position"]).max() <= 0.005 + 1e-12


def test_faults_of_a_value_are_where_they_are_put(table: Table) -> None:
    t, x, force = table["t"], table["position"], table["force"]
    clip = sensors.clipped(table, "force", 0.8)
    assert_array_equal(changed(table, clip, "force"), np.abs(force) > 0.8)
    again = sensors.reset(table, "position", 4.0)
    assert_array_equal(changed(table, again, "position"), t >= 4.0)
    assert again["position"][4000] == 0.0
    assert_allclose(np.diff(again["position"][4000:]), np.diff(x[4000:]))
    wrap = sensors.wrapped(table, "position", -0.5, 0.5)["position"]
    assert wrap.min() >= -0.5
    assert wrap.max() < 0.5
    assert_allclose(wrap - x, np.round(wrap - x), atol=1e-12)
    ice = sensors.frozen(table, "force", 2.0, 3.0)
    assert_array_equal(changed(table, ice, "force"), (t > 2.0) & (t < 3.0))
    assert np.ptp(ice["force"][2000:3000]) == 0.0
    jump = sensors.jumped(table, "position", 7.0, 0.25)
    assert_array_equal(changed(table, jump, "position"), t >= 7.0)
    far = sensors.outlying(table, "force", 0.01, 5.0, np.random.default_rng(2))
    hit = changed(table, far, "force")
    assert hit.sum() == 100
    assert_allclose(np.abs(far["force"] - force)[hit], 5.0)
    assert_array_equal(sensors.gap(table, 1.0, 2.5)["t"], t[(t < 1.0) | (t >= 2.5)])


def test_faults_of_time_are_as_late_as_is_said(table: Table) -> None:
    t = table["t"]
    inner = (t > 0.1) & (t < 9.9)
    late = sensors.delayed(table, "force", 0.02)
    changed(table, late, "force")
    assert_allclose(late["force"][inner], np.cos(3.0 * (t - 0.02))[inner], atol=2e-6)
    drift = sensors.drifting(table, "force", 0.0, 0.05)
    changed(table, drift, "force")
    assert_allclose(drift["force"][inner], np.cos(3.0 * (t - 0.005 * t))[inner], atol=2e-6)
    slow = sensors.held(table, "force", 0.02)
    changed(table, slow, "force")
    assert_allclose(slow["force"], np.cos(3.0 * 0.02 * np.floor(t / 0.02 + 1e-6)), atol=2e-6)
    soft = sensors.low_passed(table, "force", 2.0)
    changed(table, soft, "force")
    lag = np.arctan(3.0 / (2.0 * np.pi * 2.0))  # of a first-order filter at 3 rad/s
    expected = np.cos(lag) * np.cos(3.0 * t - lag)
    assert_allclose(soft["force"][inner & (t > 2.0)], expected[inner & (t > 2.0)], atol=3e-3)


def test_a_fast_ripple_shows_up_as_a_slow_one() -> None:
    """99 Hz seen at 100 Hz is 1 Hz backwards."""
    t = 0.01 * np.arange(500)
    log = sensors.aliased({"t": t, "force": np.zeros(500)}, "force", 2.0, 99.0)
    assert_allclose(log["force"], -2.0 * np.sin(2.0 * np.pi * t), atol=1e-9)
