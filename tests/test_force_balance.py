"""The force balance: recovery, calibrated errors, bounds, filtering without delay, refusals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter
from scipy.stats import chi2

from foreign.tones import axis
from stribeck.data.filtering import (
    DECIMATION_GAIN,
    Filtering,
    bridged,
    decimate,
    even,
    kept,
    smooth,
)
from stribeck.data.recording import Recording
from stribeck.errors import InputError
from stribeck.friction import LAWS
from stribeck.friction.orders import orders
from stribeck.identify.balance import variable_projection
from stribeck.identify.balance.balance import Balance, balance, validate
from stribeck.identify.fit import identify
from stribeck.identify.parameters import Parameters
from stribeck.rig.balanced import BalancedRig
from stribeck.rig.emps import EMPS
from stribeck.rig.forced import FORCED, FORCED_ROTARY
from stribeck.space import Array, Param

COULOMB, DIRECTIONAL = LAWS["coulomb-viscous"], LAWS["coulomb-viscous-directional"]
STRIBECK = LAWS["stribeck"]
TRUTH: dict[str, dict[str, float]] = {
    "coulomb-viscous": {"F_C": 20.0, "F_V": 200.0, "M": 95.0, "offset": -3.0},
    "coulomb-viscous-directional": {
        "F_C+": 20.0, "F_V+": 160.0, "F_C-": 23.0, "F_V-": 240.0, "M": 95.0,
    },
    "stribeck": {
        "F_S": 31.0, "F_C": 20.0, "F_V": 200.0, "v_SS": 0.02, "exponent": 1.0, "M": 95.0,
        "offset": -3.0,
    },
    "stribeck-directional": {
        "F_S+": 31.0, "F_C+": 20.0, "F_V+": 160.0, "v_SS+": 0.02,
        "F_S-": 35.0, "F_C-": 23.0, "F_V-": 240.0, "v_SS-": 0.03, "exponent": 1.0, "M": 95.0,
    },
}  # fmt: skip


def truth(law: str) -> Array:
    return np.array(list(TRUTH[law].values()))


def motion(t: Array) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration of a slow, smooth motion, exact."""
    x, v, a = np.zeros((3, len(t)))
    for size, f, phase in ((0.3, 0.11, 0.3), (0.05, 0.17, 1.1), (0.03, 0.29, 2.0)):
        w = 2 * np.pi * f
        x += size * np.sin(w * t + phase)
        v += size * w * np.cos(w * t + phase)
        a -= size * w**2 * np.sin(w * t + phase)
    return x, v, a


def log(
    law: str = "coulomb-viscous", *, rate: float = 1000.0, seconds: float = 30.0,
    p: Array | None = None, rig: BalancedRig = FORCED, t: Array | None = None,
) -> Recording:  # fmt: skip
    t = np.arange(round(seconds * rate)) / rate if t is None else t
    x, v, a = motion(t)
    force = rig.force(LAWS[law], truth(law) if p is None else p, v, a)
    return Recording(t=t, position=x, force=force, rotary=rig.rotary)


def noisy(recording: Recording, sd: float, rng: np.random.Generator) -> Recording:
    assert recording.force is not None
    return replace(recording, force=recording.force + sd * rng.standard_normal(len(recording)))


@pytest.mark.parametrize("law", list(TRUTH))
def test_exact_motion_gives_the_parameters_back(law: str) -> None:
    result = balance(log(law), Parameters.declared(FORCED, LAWS[law]))
    np.testing.assert_allclose(result.values, truth(law), rtol=1e-6)
    assert result.relative_error < 1e-3
    assert result.at_bound == {}


def test_the_error_of_plain_differences_falls_with_their_square_and_the_default_has_none() -> None:
    """Those of order 2 lose (w T)^2 / 3 of an acceleration: 0.75 g of 95 kg at 250 Hz here."""

    def off(rate: float, accuracy: Literal[2, 6]) -> float:
        fine = Filtering(
            cutoff_hz=rate / 10, edge=(490 / rate, 490 / rate), decimation=1, accuracy=accuracy
        )
        result = balance(log(rate=rate), Parameters.declared(FORCED, COULOMB), filtering=fine)
        return abs(result["M"] / 95.0 - 1)

    assert off(250.0, 2) / off(1000.0, 2) == pytest.approx(16.0, rel=0.15)
    assert off(50.0, 6) < 1e-10 < off(50.0, 2)


@pytest.mark.parametrize("rate", [100.0, 125.0, 250.0, 500.0])
def test_fast_strokes_of_a_slow_log_keep_their_mass(rate: float) -> None:
    """Tones up to 7.3 Hz, of which plain differences make 85.1 to 85.8 kg."""
    t, x, force = axis(rate)
    fit = identify(Recording(t=t, position=x, force=force), rig="forced", law="coulomb-viscous")
    mass = next(e for e in fit.estimates if e.name == "M")
    assert mass.verdict == "identified"
    assert mass.low < 85.0 < mass.high
    assert mass.value == pytest.approx(85.0, rel=1e-3)


def test_a_free_exponent_is_found_too() -> None:
    p = truth("stribeck")
    p[4] = 2.0
    params = [replace(q, fixed=None) for q in FORCED.parameters(STRIBECK)]
    result = balance(log("stribeck", p=p), Parameters.declared(FORCED, STRIBECK, params))
    np.testing.assert_allclose(result.values, p, rtol=1e-3)
    assert np.isfinite(result.standard_errors).all()


def test_rotary_axis() -> None:
    p = np.array([0.3, 0.05, 0.02, 0.1])
    result = balance(log(p=p, rig=FORCED_ROTARY), Parameters.declared(FORCED_ROTARY, COULOMB))
    np.testing.assert_allclose(result.values, p, rtol=1e-5)
    assert [q.unit for q in FORCED_ROTARY.parameters(COULOMB)] == [
        "N m", "N m s/rad", "kg m**2", "N m",
    ]  # fmt: skip


# Standard errors


def spreads(filtering: Filtering, runs: int, seed: int) -> tuple[Array, tuple[str, ...]]:
    """Squared errors over estimated variances, summed over runs: chi-square distributed."""
    clean = log(rate=100.0, seconds=20.0)
    exact = balance(clean, Parameters.declared(FORCED, COULOMB), filtering=filtering)
    rng = np.random.default_rng(seed)
    total = np.zeros(4)
    for _ in range(runs):
        result = balance(
            noisy(clean, 2.0, rng), Parameters.declared(FORCED, COULOMB), filtering=filtering
        )
        total += ((result.values - exact.values) / result.standard_errors) ** 2
    return total, exact.names


def test_standard_errors_are_calibrated_for_white_noise() -> None:
    # Without decimation noise stays white. 4 parameters, each two-sided at 1e-4: a false alarm
    # in at most 8e-4 of seeds.
    runs = 200
    total, _ = spreads(Filtering(decimation=1), runs, seed=20190410)
    low, high = (float(chi2.ppf(q, runs)) for q in (1e-4, 1 - 1e-4))
    assert (total > low).all(), total / runs
    assert (total < high).all(), total / runs


def test_after_decimation_the_report_s_standard_errors_are_a_tenth_too_small() -> None:
    # The decimation filter passes 0.8 of the new band, so white noise is left with 1 / 0.8 of its
    # share where a slow motion looks. Same rate of false alarms.
    runs = 200
    total, names = spreads(Filtering(decimation=10), runs, seed=20190411)
    low, high = (float(chi2.ppf(q, runs)) / 0.8 for q in (1e-4, 1 - 1e-4))
    slow = [names.index(n) for n in ("M", "F_V", "offset")]
    assert (total[slow] > low).all(), total / runs
    assert (total[slow] < high).all(), total / runs


def test_robust_errors_hold_where_noise_is_correlated() -> None:
    # First-order autoregressive noise, correlated over (1 + 0.9) / (1 - 0.9) = 19 samples. Sums
    # of squares over 200 runs as above, each end at 1e-4; the estimator itself is known to be
    # small by up to a third in variance at this length (Andrews 1991), hence the factor.
    runs, rho, clean = 200, 0.9, log(rate=100.0, seconds=60.0)
    raw = Filtering(decimation=1)
    exact = balance(clean, Parameters.declared(FORCED, COULOMB), filtering=raw).values
    rng = np.random.default_rng(20190412)
    claimed, robust = np.zeros((2, 4))
    for _ in range(runs):
        noise = lfilter([1.0], [1.0, -rho], rng.standard_normal(len(clean)))
        assert clean.force is not None
        result = balance(
            replace(clean, force=clean.force + noise),
            Parameters.declared(FORCED, COULOMB),
            filtering=raw,
        )
        claimed += ((result.values - exact) / result.standard_errors) ** 2
        robust += ((result.values - exact) / result.robust_errors) ** 2
    low, high = (float(chi2.ppf(q, runs)) for q in (1e-4, 1 - 1e-4))
    assert (claimed > 4 * high).all(), claimed / runs
    assert (robust > low).all(), robust / runs
    assert (robust < 1.5 * high).all(), robust / runs


def test_robust_errors_are_the_plain_ones_for_white_noise() -> None:
    data = noisy(log(), 2.0, np.random.default_rng(16))
    result = balance(data, Parameters.declared(FORCED, COULOMB), filtering=Filtering(decimation=1))
    ratio = result.robust_errors / result.standard_errors
    assert (ratio >= 1.0).all()
    assert (ratio < 1.2).all(), ratio


def test_nothing_correlates_across_logs() -> None:
    rng = np.random.default_rng(17)
    W, e = rng.standard_normal((200, 2)), np.repeat(rng.standard_normal(20), 10)
    variances = variable_projection.robust_variances(W, e, [200])
    np.testing.assert_allclose(
        variable_projection.robust_variances(W, e, [200, 0]), variances, rtol=1e-12
    )
    assert not np.allclose(variable_projection.robust_variances(W, e, [100, 100]), variances)
    blind = variable_projection.robust_variances(np.column_stack([W, np.zeros(200)]), e, [200])
    assert np.isnan(blind[2])
    assert np.isfinite(blind[:2]).all()


def test_a_log_that_is_shorter_than_what_residuals_remember_adds_what_it_has() -> None:
    rng = np.random.default_rng(3)
    W, e = rng.standard_normal((605, 1)), np.repeat([1.0, -1.0, 1.0], [300, 300, 5])
    errors = [variable_projection.robust_variances(W[:n], e[:n], lengths)[0]
              for n, lengths in ((600, [600]), (605, [600, 5]))]  # fmt: skip
    assert errors[1] == pytest.approx(errors[0], rel=0.1)


def test_a_stribeck_fit_of_coulomb_data_is_not_confident() -> None:
    rng = np.random.default_rng(7)
    result = balance(noisy(log(), 2.0, rng), Parameters.declared(FORCED, STRIBECK))
    assert result.standard_error("v_SS") > 0.5 * result["v_SS"]
    F_S_error = result.standard_error("F_S")  # the level at rest, in truth F_C
    assert abs(result["F_S"] - 20.0) < 5 * F_S_error
    assert result["F_S"] >= result["F_C"]
    assert abs(result["M"] - 95.0) < 5 * result.standard_error("M")


@pytest.mark.parametrize("dim", [1, 2])
def test_a_basin_is_searched_that_a_better_grid_point_and_its_neighbours_are_not_in(
    dim: int,
) -> None:
    wide, narrow = np.full(dim, 0.25), np.full(dim, 0.8)

    def residuals(u: Array) -> Array:
        """Of 0.02 at the least in a wide basin, of 0 in one that is five times as narrow."""
        ways = np.append(u - wide, np.sqrt(0.02)), np.append(5.0 * (u - narrow), 0.0)
        return min(ways, key=lambda r: float(r @ r))

    np.testing.assert_allclose(variable_projection.search(residuals, dim), narrow, atol=1e-6)


def test_covariance_is_the_textbook_s_and_says_what_it_cannot_see() -> None:
    rng = np.random.default_rng(1)
    W = rng.standard_normal((50, 3)) * [1.0, 1e-6, 1e6]
    C = variable_projection.covariance(W, 2.0)
    np.testing.assert_allclose(C, 4.0 * np.linalg.inv(W.T @ W), rtol=1e-6, atol=0)
    blind = variable_projection.covariance(np.column_stack([W, np.zeros(50)]), 2.0)
    assert blind[3, 3] == np.inf
    assert np.isnan(blind[3, :3]).all()
    np.testing.assert_allclose(blind[:3, :3], C, rtol=1e-9)
    twins = variable_projection.covariance(np.column_stack([W, W[:, 0]]), 2.0)
    assert (np.diag(twins)[[0, 3]] == np.inf).all()
    assert np.isfinite(np.diag(twins)[[1, 2]]).all()
    assert variable_projection.collinearity(W) < 2
    assert variable_projection.condition(W) > 1e10


# Bounds, order, fixed and tied


def with_(law: str, **changes: dict[str, float]) -> list[Param]:
    params = FORCED.parameters(LAWS[law])
    return [replace(q, **changes.get(q.name, {})) for q in params]  # type: ignore[arg-type]


def test_a_fixed_parameter_stays_and_the_others_make_do() -> None:
    params = with_("coulomb-viscous", M={"fixed": 95.0}, offset={"fixed": -3.0})
    result = balance(log(), Parameters.declared(FORCED, COULOMB, params))
    assert result.free == ("F_C", "F_V")
    assert (result["M"], result["offset"]) == (95.0, -3.0)
    assert np.isnan(result.standard_error("M"))
    assert result.covariance.shape == (2, 2)
    np.testing.assert_allclose(result.values, truth("coulomb-viscous"), rtol=1e-5)


def test_a_bound_holds_and_is_said() -> None:
    result = balance(
        log(), Parameters.declared(FORCED, COULOMB, with_("coulomb-viscous", F_V={"upper": 150.0}))
    )
    assert result["F_V"] == 150.0
    assert result.at_bound == {"F_V": "upper"}
    assert result.standard_error("F_V") == np.inf


def test_friction_never_pushes() -> None:
    p = truth("coulomb-viscous")
    p[1] = -50.0  # a log that no friction explains
    result = balance(log(p=p), Parameters.declared(FORCED, COULOMB))
    assert result["F_V"] == 0.0
    assert result.at_bound == {"F_V": "lower"}


def test_a_level_that_the_data_would_have_negative_is_told_once() -> None:
    p = truth("coulomb-viscous")
    p[1] = -50.0
    told = [w for w in identify(log(p=p), rig=FORCED, law=COULOMB).warnings if w.startswith("F_V ")]
    assert len(told) == 1
    assert told[0].startswith("F_V ended at 0, the least that it may be")


def test_static_friction_may_not_fall_below_coulomb_s() -> None:
    p = truth("stribeck")
    p[0] = 10.0  # the reverse of a Stribeck curve
    result = balance(log("stribeck", p=p), Parameters.declared(FORCED, STRIBECK))
    assert result["F_S"] == result["F_C"]
    assert result.at_bound["F_S"] == "F_C"


@pytest.mark.parametrize(
    ("law", "pairs"),
    [
        ("coulomb-viscous", set()),
        ("coulomb-viscous-directional", set()),
        ("stribeck", {("F_S", "F_C")}),
        ("stribeck-directional", {("F_S+", "F_C+"), ("F_S-", "F_C-")}),
    ],
)
def test_orders_are_asked_of_the_law(law: str, pairs: set[tuple[str, str]]) -> None:
    names = LAWS[law].names
    assert {(names[i], names[j]) for i, j in orders(LAWS[law])} == pairs


def test_both_directions_tied_are_the_symmetric_law() -> None:
    p = truth("coulomb-viscous")
    p[3] = 0.0
    rng = np.random.default_rng(3)
    data = noisy(log(p=p), 2.0, rng)
    tied = {"F_C-": "F_C+", "F_V-": "F_V+"}
    tied_fit = balance(data, Parameters.declared(FORCED, DIRECTIONAL, tied=tied))
    symmetric_fit = balance(
        data, Parameters.declared(FORCED, COULOMB, with_("coulomb-viscous", offset={"fixed": 0.0}))
    )
    np.testing.assert_allclose(tied_fit.values[[0, 1, 4]], symmetric_fit.values[:3], rtol=1e-9)
    assert tied_fit["F_C-"] == tied_fit["F_C+"]
    assert tied_fit.relative_error == pytest.approx(symmetric_fit.relative_error, rel=1e-9)
    assert tied_fit.free == ("F_C+", "F_V+", "M")


def test_equal_directions_are_found_equal() -> None:
    p = truth("coulomb-viscous")
    p[3] = 0.0
    result = balance(log(p=p), Parameters.declared(FORCED, DIRECTIONAL))
    np.testing.assert_allclose(result.values, p[[0, 1, 0, 1, 2]], rtol=1e-5)


matrices = st.integers(0, 2**32 - 1).map(np.random.default_rng)


@given(rng=matrices)
@settings(max_examples=60)
def test_bounded_least_squares_meets_the_conditions_of_a_minimum(rng: np.random.Generator) -> None:
    W, y = rng.standard_normal((30, 4)) * [1.0, 1e3, 1e-3, 1.0], rng.standard_normal(30)
    free = np.linalg.lstsq(W, y, rcond=None)[0]
    lower = free + np.abs(free) * rng.normal(-0.5, 0.5, 4)
    upper = lower + np.abs(free) * rng.uniform(0.1, 2.0, 4)
    x, stops = variable_projection.bounded(W, y, lower, upper)
    assert ((x >= lower) & (x <= upper)).all()
    lengths = np.linalg.norm(W, axis=0)
    slope = W.T @ (W @ x - y) / lengths
    for i in range(4):
        side = stops.get(i)
        assert {"lower": slope[i] > -1e-8, "upper": slope[i] < 1e-8}.get(
            str(side), abs(slope[i]) < 1e-8
        )


@given(rng=matrices)
@settings(max_examples=60)
def test_ordered_least_squares_is_beaten_by_no_other_ordered_point(
    rng: np.random.Generator,
) -> None:
    W, y = rng.standard_normal((30, 3)), 3 * rng.standard_normal(30)
    lower, upper = np.full(3, -5.0), np.full(3, 5.0)
    x, stops = variable_projection.bounded(W, y, lower, upper, [(0, 1)])
    assert x[0] >= x[1] - 1e-12
    assert (stops.get(0) == 1) == (x[0] == pytest.approx(x[1], abs=1e-9))
    candidates = np.clip(
        x + rng.standard_normal((200, 3)) * rng.choice([1e-3, 0.1, 1.0], (200, 1)), -5, 5
    )
    candidates = candidates[candidates[:, 0] >= candidates[:, 1]]
    squares = ((candidates @ W.T - y) ** 2).sum(axis=1)
    assert (squares >= np.sum((W @ x - y) ** 2) - 1e-9).all()


@given(rng=matrices, k=st.integers(1, 6), extra=st.integers(0, 30))
@settings(max_examples=40)
def test_triangle_keeps_every_length_and_angle(
    rng: np.random.Generator, k: int, extra: int
) -> None:
    A = rng.standard_normal((k + extra, k))
    A[:, rng.integers(k)] *= rng.choice([0.0, 1.0])
    R = variable_projection.triangle(A)
    np.testing.assert_allclose(R.T @ R, A.T @ A, atol=1e-12 * len(A))
    assert (np.tril(R, -1) == 0).all()


# What units, stacking and rows must not change


@pytest.mark.parametrize(("force", "length"), [(1000.0, 1.0), (1.0, 1e-3), (0.2, 30.0)])
def test_other_units_give_the_same_physics(force: float, length: float) -> None:
    data = noisy(log(), 2.0, np.random.default_rng(11))
    metric = balance(data, Parameters.declared(FORCED, COULOMB))
    assert data.force is not None
    scaled = replace(data, force=force * data.force, position=length * data.position)
    wide = [replace(q, lower=-1e9, upper=1e9) for q in FORCED.parameters(COULOMB)]
    rescaled = balance(scaled, Parameters.declared(FORCED, COULOMB, wide))
    factors = np.array([force, force / length, force / length, force])
    np.testing.assert_allclose(rescaled.values, factors * metric.values, rtol=1e-8)
    np.testing.assert_allclose(
        rescaled.standard_errors, factors * metric.standard_errors, rtol=1e-8
    )
    assert rescaled.relative_error == pytest.approx(metric.relative_error, rel=1e-8)
    assert rescaled.collinearity == pytest.approx(metric.collinearity, rel=1e-6)


def test_a_log_twice_is_the_same_answer_with_smaller_errors() -> None:
    data = noisy(log(), 2.0, np.random.default_rng(12))
    single, double = (
        balance(data, Parameters.declared(FORCED, COULOMB)),
        balance([data, data], Parameters.declared(FORCED, COULOMB)),
    )
    np.testing.assert_allclose(double.values, single.values, rtol=1e-9)
    np.testing.assert_allclose(
        double.standard_errors, single.standard_errors / np.sqrt(2), rtol=1e-3
    )
    assert double.rows == 2 * single.rows
    assert len(double.signals) == 2


def test_logs_of_different_rates_stack() -> None:
    result = balance([log(), log(rate=250.0)], Parameters.declared(FORCED, COULOMB))
    np.testing.assert_allclose(result.values, truth("coulomb-viscous"), rtol=1e-4)


def test_signals_are_the_forces_themselves() -> None:
    data = log()
    (s,) = balance(data, Parameters.declared(FORCED, COULOMB)).signals
    _, v, a = motion(s.t)
    inner = slice(20, -20)  # the decimation filter lacks neighbours outside
    assert data.force is not None
    at = np.round(s.t * 1000).astype(int)
    # Where sgn v does not jump, they are the log's within the filter's ripple (2 x 0.05 dB).
    calm = np.abs(v) > 0.1
    np.testing.assert_allclose(s.measured[calm], data.force[at][calm], rtol=0.02)
    np.testing.assert_allclose(s.predicted[inner], s.measured[inner], atol=1e-3)
    np.testing.assert_allclose(s.velocity[inner], v[inner], atol=1e-6)
    np.testing.assert_allclose(s.acceleration[inner], a[inner], atol=1e-5)
    curve = COULOMB.friction(v, truth("coulomb-viscous")[:2])
    np.testing.assert_allclose(s.friction[calm], curve[calm], rtol=0.02)


def test_rows_left_out_do_not_matter() -> None:
    data = log()
    assert data.force is not None
    spoilt = data.force.copy()
    spoilt[12_000:13_000] += 500.0
    spoilt_log = replace(data, force=spoilt)
    keep = np.ones(len(data), dtype=bool)
    keep[11_500:13_500] = False  # and what the decimation filter spreads around them
    result = balance(spoilt_log, Parameters.declared(FORCED, COULOMB), rows=[keep])
    np.testing.assert_allclose(result.values, truth("coulomb-viscous"), rtol=1e-4)
    assert (
        validate(
            spoilt_log, Parameters.declared(FORCED, COULOMB), result.values, rows=[keep]
        ).relative_error
        < 0.01
    )
    assert (
        validate(spoilt_log, Parameters.declared(FORCED, COULOMB), result.values).relative_error
        > 10
    )


def test_validation_of_the_same_log_repeats_the_fit_s_numbers() -> None:
    data = noisy(log(), 2.0, np.random.default_rng(13))
    result = balance(data, Parameters.declared(FORCED, COULOMB))
    validation = validate(data, Parameters.declared(FORCED, COULOMB), result.values)
    assert validation.relative_error == pytest.approx(result.relative_error, rel=1e-12)
    assert validation.residual_sd == pytest.approx(result.residual_sd, rel=1e-12)
    # White noise of 2 N keeps 0.8 of a tenth of its power.
    assert result.residual_sd == pytest.approx(2.0 * np.sqrt(0.08) * DECIMATION_GAIN, rel=0.05)


# Filtering


def test_filtering_has_no_delay() -> None:
    rng = np.random.default_rng(14)
    x = np.cumsum(rng.standard_normal(4000)) * 1e-4
    q, v, a = smooth(x, 1000.0, Filtering())
    back_q, back_v, back_a = smooth(x[::-1], 1000.0, Filtering())
    inner = slice(200, -200)
    np.testing.assert_allclose(q[inner], back_q[::-1][inner], atol=1e-9)
    np.testing.assert_allclose(v[inner], -back_v[::-1][inner], atol=1e-6)
    np.testing.assert_allclose(a[inner], back_a[::-1][inner], atol=1e-3)


@pytest.mark.parametrize("f", [0.5, 5.0, 20.0, 60.0])
def test_low_pass_is_a_butterworth_run_both_ways(f: float) -> None:
    t = np.arange(8000) / 1000.0
    tone, w = 2 * np.pi * f * t, 2 * np.pi * f / 1000
    q, v, a = smooth(np.sin(tone), 1000.0, Filtering())
    _, plain, _ = smooth(np.sin(tone), 1000.0, Filtering(accuracy=2))
    # |H|^2 of a bilinear Butterworth filter, whose frequencies are warped by tan.
    ratio = np.tan(np.pi * f / 1000) / np.tan(np.pi * 100 / 1000)
    gain = 1 / (1 + ratio**8)
    inner = slice(500, -500)
    np.testing.assert_allclose(q[inner], gain * np.sin(tone)[inner], atol=1e-8)
    slope = gain * np.sin(w) * 1000
    np.testing.assert_allclose(plain[inner], slope * np.cos(tone)[inner], atol=1e-5)
    # Those of order 6 are off by no more than the next term of their series, w^6 / 140.
    off = w**6 / 140
    slope = gain * w * 1000
    np.testing.assert_allclose(v[inner], slope * np.cos(tone)[inner], atol=slope * off + 1e-5)
    slope *= 1000 * w
    np.testing.assert_allclose(a[inner], -slope * np.sin(tone)[inner], atol=2 * slope * off + 1e-2)


@pytest.mark.parametrize("n", [1000, 1001, 1009])
def test_decimation_keeps_phase_the_last_sample_and_its_gain(n: int) -> None:
    t = np.arange(n) / 1000.0
    x = np.column_stack([np.ones(n), np.sin(2 * np.pi * 3 * t)])
    y, at = decimate(x, 10), t[kept(n, 10)]
    assert at[-1] == t[-1]
    assert len(y) == len(at) == -(-n // 10)
    np.testing.assert_allclose(y[:, 0], DECIMATION_GAIN, rtol=1e-9)
    # No delay: the sine stays a sine of its own, within the ripple of 0.05 dB each way.
    z, sine = y[20:-20, 1], np.sin(2 * np.pi * 3 * at)[20:-20]
    gain = z @ sine / (sine @ sine)
    assert DECIMATION_GAIN <= gain <= 1.0
    np.testing.assert_allclose(z, gain * sine, atol=5e-4)


def test_filtering_follows_the_rate() -> None:
    f = Filtering()
    assert (f.cutoff(1000.0), f.factor(1000.0), f.edges(1000.0)) == (100.0, 10, (49, 49))
    assert (f.cutoff(100.0), f.factor(100.0), f.edges(100.0)) == (10.0, 10, (49, 49))
    assert (f.cutoff(5000.0), f.factor(5000.0), f.edges(5000.0)) == (100.0, 50, (245, 245))


def test_irregular_sampling_is_resampled_and_said() -> None:
    rng = np.random.default_rng(15)
    t = np.cumsum(rng.uniform(0.5e-3, 1.5e-3, 30_000))
    result = balance(log(t=t), Parameters.declared(FORCED, COULOMB))
    np.testing.assert_allclose(result.values, truth("coulomb-viscous"), rtol=1e-3)
    assert any("sampled irregularly, resampled" in note for note in result.notes)


def test_what_lies_in_a_gap_is_not_used() -> None:
    t = np.arange(30_000) / 1000.0
    whole = log(t=t)
    holed = np.r_[0:9_000, 12_000:30_000]
    data = log(t=t[holed])
    e = even(data, np.zeros(len(data)))
    missing = (e.t > 8.9995) & (e.t < 11.9995)
    assert e.known is not None
    assert not e.known[missing].any()
    assert e.known[~missing].all()
    result = balance(data, Parameters.declared(FORCED, COULOMB))
    assert result.rows == pytest.approx(
        0.9 * balance(whole, Parameters.declared(FORCED, COULOMB)).rows, abs=2
    )
    np.testing.assert_allclose(result.values, truth("coulomb-viscous"), rtol=2e-3)


def stuck_between_strokes() -> Recording:
    """Strokes of 6 s with pauses of 4 s, in which a force below breakaway is held."""
    t = np.arange(40_000) / 1000.0
    moving = (t % 10) < 6
    phase = np.where(moving, t % 10, 6.0) * 2 * np.pi / 6
    x = 0.1 * (1 - np.cos(phase))
    v = np.where(moving, 0.1 * 2 * np.pi / 6 * np.sin(phase), 0.0)
    a = np.where(moving, 0.1 * (2 * np.pi / 6) ** 2 * np.cos(phase), 0.0)
    force = FORCED.force(COULOMB, truth("coulomb-viscous"), v, a)
    return Recording(t=t, position=x, force=np.where(moving, force, 15.0))


def test_rest_is_left_out() -> None:
    data, parameters = stuck_between_strokes(), Parameters.declared(FORCED, COULOMB)
    result = balance(data, parameters)
    np.testing.assert_allclose(result.values, truth("coulomb-viscous"), rtol=1e-3)
    assert result.rows < 0.62 * len(data) / 10
    kept = balance(data, parameters, filtering=Filtering(reversals=True))
    assert abs(kept["offset"] + 3.0) > 1.0  # rest pulls it away
    assert any("at or near rest" in note for note in kept.notes)
    assert not any("at or near rest" in note for note in result.notes)


@pytest.mark.parametrize(("noise", "counts"), [(0.0, 0.0), (2e-5, 0.0), (0.0, 5e-5)])
def test_about_a_reversal_no_sign_is_taken_that_noise_may_have_made(
    noise: float, counts: float
) -> None:
    """Of what is kept, no row in ten thousand moves the other way in truth."""
    data = log()
    x = data.position + noise * np.random.default_rng(21).standard_normal(len(data))
    x = counts * np.round(x / counts) if counts else x
    system = balance(replace(data, position=x), Parameters.declared(FORCED, COULOMB)).system
    (rows,) = system.logs
    true_v = np.interp(rows.clock, data.t, motion(data.t)[1])
    wrong = (np.sign(rows.v[:]) != np.sign(true_v)) & ~rows.unsure
    assert wrong.mean() < 1e-4
    assert rows.unsure.mean() < 0.25  # most of the log stays


def test_a_balance_whose_sides_are_bridged_alike_stays_one() -> None:
    rng = np.random.default_rng(22)
    x, gaps = rng.standard_normal((300, 2)), np.zeros(300, dtype=bool)
    gaps[:7] = gaps[100:150] = gaps[-4:] = True
    both = bridged(x @ [2.0, -3.0], gaps)
    np.testing.assert_allclose(both, bridged(x, gaps) @ [2.0, -3.0], atol=1e-12)
    assert (both[:7] == both[7]).all()
    np.testing.assert_allclose(np.diff(both[99:151], 2), 0.0, atol=1e-12)
    assert (both[~gaps] == (x @ [2.0, -3.0])[~gaps]).all()


# Small axes


def test_intervals_of_a_small_motor_are_those_of_a_press_in_its_own_unit() -> None:
    """What a range of 1e7 N m s/rad moves at motor speed was taken for rounding of the torque."""
    press = noisy(log(rig=FORCED_ROTARY, seconds=10.0), 5.0, np.random.default_rng(4))
    assert press.force is not None
    motor = replace(press, force=1e-6 * press.force)
    large, small = (identify(r, rig=FORCED_ROTARY, law=COULOMB).estimates for r in (press, motor))
    for a, b in zip(large, small, strict=True):
        np.testing.assert_allclose([1e6 * b.value, 1e6 * b.low, 1e6 * b.high],
                                   [a.value, a.low, a.high], rtol=1e-3)  # fmt: skip


# Short ranges


def short_motion(kind: str, t: Array) -> tuple[Array, Array]:
    """Position and velocity: to and fro, one speed, strokes with rests, or ever faster."""
    if kind == "to and fro":
        return 0.1 * np.sin(2.5 * t), 0.25 * np.cos(2.5 * t)
    v = {
        "one speed": np.full(len(t), 0.05),
        "rests": 0.05 * np.sign(np.round(np.sin(2 * np.pi * t / 3))),
        "ever faster": 0.02 * t,
    }[kind]
    return np.cumsum(v) / 100.0, v


@pytest.mark.parametrize("noise", [0.0, 0.1])
@pytest.mark.parametrize("kind", ["to and fro", "one speed", "rests", "ever faster"])
def test_a_range_however_short_is_fitted_or_refused(kind: str, noise: float) -> None:
    t = np.arange(400) / 100.0
    x, v = short_motion(kind, t)
    force = 12.0 * np.sign(v) + 30.0 * v + noise * np.random.default_rng(3).standard_normal(len(t))
    recording = Recording(t=t, position=x, force=force)
    fits, refusals = [], []
    for seconds in (0.1, 0.7, 1.0, 1.5):
        for train in (f"0s:{seconds}s", f"{4 - seconds}s:4s"):
            try:
                fits.append(identify(recording, rig=FORCED, law=COULOMB, train=train))
            except InputError as refusal:
                refusals.append(str(refusal))
    assert fits
    assert refusals
    assert [r for r in refusals if "widen the range" not in r or "\n" in r] == []
    assert [e for fit in fits for e in fit.estimates if not e.low <= e.value <= e.high] == []


# Refusals

T2 = np.arange(3000) / 1000.0


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (
            lambda: balance(Recording(t=T2, position=T2), Parameters.declared(FORCED, COULOMB)),
            "needs the measured force",
        ),
        (
            lambda: balance(Recording(t=T2, position=T2), Parameters.declared(EMPS, COULOMB)),
            "needs the measured force",
        ),
        (
            lambda: balance(log(), Parameters.declared(FORCED_ROTARY, COULOMB)),
            "position is a length",
        ),
        (
            lambda: balance(log(rig=FORCED_ROTARY), Parameters.declared(FORCED, COULOMB)),
            "position is an angle",
        ),
        (
            lambda: balance(log(seconds=0.1), Parameters.declared(FORCED, COULOMB)),
            "too few to filter",
        ),
        (lambda: balance([], Parameters.declared(FORCED, COULOMB)), "no recording"),
        (
            lambda: balance(log(), Parameters.declared(FORCED, COULOMB), rows=[None, None]),
            "2 of 1 recordings",
        ),
        (
            lambda: balance(log(), Parameters.declared(FORCED, COULOMB), rows=[slice(0, 0)]),
            "fewer than 2 rows are left of the 0 samples",
        ),
        (
            lambda: balance(log(), Parameters.declared(FORCED, COULOMB), rows=[slice(0, 80)]),
            "3 rows, one every 0.01 s, cannot tell 4",
        ),
        (
            lambda: balance(log(), Parameters.declared(FORCED, COULOMB, fixed_all())),
            "no parameter is left",
        ),
        (
            lambda: balance(log(), Parameters.declared(FORCED, COULOMB, tied={"F_C": "F_Q"})),
            "cannot be tied",
        ),
        (lambda: Filtering(order=0), "order 0"),
        (lambda: Filtering(cutoff_hz=0.0), "cutoff_hz"),
        (lambda: Filtering(edge=(-1.0, 0.0)), "edge"),
        (lambda: Filtering(decimation=0), "decimation 0"),
        (lambda: Filtering(slowest=-1.0), "slowest"),
    ],
)
def test_refusals(call: Any, says: str) -> None:
    with pytest.raises(InputError, match=says) as caught:
        call()
    assert "\n" not in str(caught.value)


def fixed_all() -> list[Param]:
    return [replace(q, fixed=1.0) for q in FORCED.parameters(COULOMB)]


def test_force_that_motion_does_not_explain_is_said() -> None:
    fit = identify(noisy(log(), 200.0, np.random.default_rng(18)), rig=FORCED, law=COULOMB)
    assert fit.score.value > 25
    assert any("is not explained by this model" in warning for warning in fit.warnings)


def test_few_rows_are_said() -> None:
    result: Balance = balance(log(), Parameters.declared(FORCED, COULOMB), rows=[slice(0, 300)])
    assert any("standard errors are too small" in note for note in result.notes)
