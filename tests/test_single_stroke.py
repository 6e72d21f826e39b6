"""Delays between force and motion on an axis that moves one way: what a stroke shows of them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.stats import chi2, norm

from foreign import driven, sensors
from foreign.clock import Array
from foreign.friction import coulomb_viscous
from stribeck import Recording, identify
from stribeck.identify.balance.lag_evidence import searched_errors
from stribeck.identify.result import Fit

DT = 1e-3
T = DT * np.arange(5000)
STAIRS = (0.0, 0.05, 0.1, 0.2, 0.3, 0.4)
STARTS = np.add.outer(np.arange(5), [0.0, 0.1]).ravel()
#: Speeds over 5 s, all of one sign, and no reversal that would mark an instant.
SPEEDS = {
    "a ramp that ends in motion": np.interp(T, [0.1, 0.2], [0.0, 0.1]),
    "a whole stroke": np.interp(T, [0.1, 0.2, 4.8, 4.9], [0.0, 0.1, 0.1, 0.0]),
    "ever faster": 0.06 * T,
    "nearly steady": 0.05 + 0.002 * T,
    "slowly up and down": 0.1 + 0.02 * np.sin(0.2 * np.pi * T),
    "stairs": np.interp(T, STARTS, np.repeat(STAIRS, 2)[1:-1]),
}  # fmt: skip


@cache
def motion(speeds: str, warming: float) -> dict[str, Array]:
    v = SPEEDS[speeds]
    x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * DT)])
    curve, loop = coulomb_viscous(20.0, 60.0), driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-4)
    extras = driven.Extras(warming=warming, warming_time=2.0)
    return driven.simulate(10.0, curve, curve, loop, T, x, extras)._asdict()


def fitted(speeds: str, seed: int, *, warming: float = 0.0, late: float = 0.0) -> Fit:
    rng = np.random.default_rng(seed)
    table = sensors.noisy(motion(speeds, warming), "force", 1.0, rng, memory=20.0)
    table = sensors.noisy(table, "position", 1e-6, rng)
    if late:
        table = sensors.delayed(table, "force", late)
    log = Recording(table["t"], table["position"], force=table["force"])
    return identify(log, rig="forced", law="coulomb-viscous")


def told(fit: Fit) -> list[str]:
    """What is told of a delay, other than what is assumed of one that the log does not show."""
    delays = [w for w in fit.warnings if "the motion" in w or "by one time" in w]
    return [w for w in delays if "is taken to be half a sample at most" not in w]


@pytest.mark.parametrize("warming", [0.0, 0.3])
@pytest.mark.parametrize("speeds", SPEEDS)
def test_a_stroke_in_step_is_told_no_delay(speeds: str, warming: float) -> None:
    """Noise along a motion without starts fits somewhere better; so does a friction that falls."""
    for seed in range(3):
        fit = fitted(speeds, seed, warming=warming)
        assert told(fit) == []
        assert fit.delay == 0.0


@pytest.mark.parametrize("late", [0.02, 0.2, -0.05])
def test_steps_of_speed_show_a_delay(late: float) -> None:
    fit = fitted("stairs", 0, late=late)
    assert fit.delay == pytest.approx(late, abs=1e-3)
    assert len(told(fit)) == 1


@pytest.mark.parametrize("late", [0.02, 0.05, 0.2])
@pytest.mark.parametrize("speeds", ["a ramp that ends in motion", "nearly steady"])
def test_a_delay_that_may_be_none_moves_nothing(speeds: str, late: float) -> None:
    """A log that was moved must still show the delay: what is told of it excludes 0."""
    for seed in range(2):
        fit = fitted(speeds, seed, late=late)
        (sentence,) = told(fit) or [""]
        assert "(0 to" not in sentence
        assert ("and moved by that" in sentence) == (fit.delay != 0.0)


def test_a_delay_that_the_moved_log_does_not_show_is_told_and_left() -> None:
    fit = fitted("nearly steady", 0, late=0.2)
    (sentence,) = told(fit)
    assert "the log does not show by how much" in sentence
    assert fit.delay == 0.0
    assert "identified" not in {e.verdict for e in fit.estimates}


@pytest.mark.parametrize("late", [0.02, 0.05])
def test_a_start_shows_a_delay(late: float) -> None:
    """Lags that move the start out of the log explain all that is left of it, which is nothing."""
    delays = [fitted("a whole stroke", seed, late=late).delay for seed in (1, 2, 5)]
    assert delays == pytest.approx([late] * 3, abs=2e-3)


@pytest.mark.parametrize("seed", [4, 12])
def test_the_parts_of_a_stroke_whose_starts_are_in_step_are_told_no_drift(seed: int) -> None:
    """A part moved until its start has left the log leaves nothing to explain, nor explains it."""
    assert told(fitted("a whole stroke", seed)) == []


def test_a_stroke_that_accelerates_from_rest_shows_a_delay() -> None:
    """Its start has left the log that is moved: where the rest shows too little, that is told."""
    fits = [fitted("ever faster", seed, late=0.2) for seed in range(8)]
    moved = [fit.delay for fit in fits if fit.delay]
    assert len(moved) >= 4
    assert moved == pytest.approx([0.2] * len(moved), abs=0.025)
    for fit in fits:
        if not fit.delay:
            assert any("the log does not show by how much" in w for w in told(fit))
            assert "identified" not in {e.verdict for e in fit.estimates}


@pytest.mark.parametrize("seed", [1, 3, 9])
def test_a_ramp_shows_its_start_where_it_is(seed: int) -> None:
    """A delay that puts the start before the first row that slides is no explanation of it."""
    fit = fitted("a ramp that ends in motion", seed, late=0.02)
    assert fit.delay == pytest.approx(0.02, abs=4e-3)


def test_a_mass_that_two_starts_show_is_within_its_interval() -> None:
    """The noise forgets within 20 ms, and a start takes 100: there is little of it in a stroke."""
    masses = [
        next(e for e in fitted("a whole stroke", seed).estimates if e.name == "M")
        for seed in range(12)
    ]
    # 12 intervals of 95 % hold fewer than 10 in 2 % of cases
    assert sum(m.low <= 10.0 <= m.high for m in masses) >= 10


def test_an_error_counts_the_lags_that_were_tried() -> None:
    """200 rows that leave 5 % less at a lag 50 rows off: 101 lags lie as near."""
    (error,) = searched_errors(
        np.array([-0.5]), np.array([0.001]), np.array([1.05]), 200.0,
        row=0.01, span=np.inf, reach=2.0,
    )  # fmt: skip
    assert 101 * chi2.sf(200 * np.log(1.05), 1) == pytest.approx(2 * norm.sf(0.5 / error))
    near, none, sure = searched_errors(
        np.array([0.008, 0.5, 0.5]), np.full(3, 0.001), np.array([1.05, 1.0, 50.0]), 200.0,
        row=0.01, span=np.inf, reach=2.0,
    )  # fmt: skip
    assert near == 0.001  # within a row there is one minimum
    assert none == 2.0  # nothing speaks for it
    assert sure == pytest.approx(0.5 / 27.6, rel=0.01)  # sqrt(chi2) of 782, less 101 lags


def test_samples_that_a_lag_exchanges_scatter_by_themselves() -> None:
    """Half of 200 rows for others: their sums of squares over the variance differ by 20 or so."""
    rng = np.random.default_rng(0)
    gone, new = rng.standard_normal((2, 4000, 100))
    scatter = np.std((gone**2).sum(axis=1) - (new**2).sum(axis=1))
    gain = 200 * np.log(1.4)
    (error,) = searched_errors(
        np.array([1.0]), np.array([0.001]), np.array([1.4]), 200.0, row=0.01, span=2.0, reach=9.0
    )
    assert 201 * norm.sf(gain / scatter) == pytest.approx(2 * norm.sf(1.0 / error), rel=0.3)
