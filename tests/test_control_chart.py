"""Control charts of estimates: independent differences, false alarms at their rate, steps found."""

import numpy as np
import pytest
from scipy import stats

from drift_scatter import SCATTER
from drift_twins import Twin
from stribeck.monitoring.control_chart import Limits, control_chart
from stribeck.monitoring.covariate import covariate_effect
from stribeck.monitoring.detectable import detectable_step
from stribeck.monitoring.innovations import GRID, PRIOR
from stribeck.monitoring.series import ScatterModel, Series


def series(twin: Twin, count: int, seed: int, *, error: float = 0.0, warm: bool = False) -> Series:
    rows = twin.estimates(count, seed)
    days, values, warmth = (np.array(column) for column in zip(*rows, strict=True))
    zeros = np.zeros(count, dtype=np.int64)
    return Series(
        values, np.full(count, error), days.astype(float), zeros, warmth if warm else None
    )


def test_differences_are_those_of_a_regression_by_dense_matrices() -> None:
    """Each point of the grid by generalised least squares on all that was before, no recursion."""
    draw = np.random.default_rng(5)
    n, gaps = 14, [0, 1, 0, 0, 2, 1, 1, 0, 3, 1, 1, 0, 1, 1]
    days = np.cumsum(gaps).astype(float)
    errors, warmth = draw.uniform(0.02, 0.2, n), draw.normal(20.0, 3.0, n)
    values = 1.35 + 0.02 * warmth + draw.normal(0.0, 0.1, n)
    estimates = Series(values, errors, days, np.zeros(n, dtype=np.int64), warmth)
    found = control_chart(estimates, Limits.of(1e6)).differences
    assert np.isnan(found[:4]).all()  # two for level and slope, two for the scatter
    for at in range(4, n):
        weights, probabilities = [], []
        for r, c, a in GRID.tolist():
            apart = np.abs(days[: at + 1, None] - days[: at + 1])
            squares = 1.0 - c + c * np.square(errors[: at + 1]) / np.median(np.square(errors[:10]))
            covariance = r * np.where(apart == 0, 1.0, a**apart) + np.diag((1.0 - r) * squares)
            x = np.column_stack([np.ones(at + 1), warmth[: at + 1]])
            old, new = np.linalg.inv(covariance[:at, :at]), covariance[at, :at]
            precision = x[:at].T @ old @ x[:at]
            beta = np.linalg.solve(precision, x[:at].T @ old @ values[:at])
            rest = values[:at] - x[:at] @ beta
            row = x[at] - new @ old @ x[:at]
            variance = covariance[at, at] - new @ old @ new
            variance += row @ np.linalg.solve(precision, row)
            dof, squares_sum = at - 2, float(rest @ old @ rest)
            # The restricted likelihood with s^2 profiled, Harville 1977.
            _, log_v = np.linalg.slogdet(covariance[:at, :at])
            _, log_p = np.linalg.slogdet(precision)
            weights.append(-0.5 * (log_v + log_p + dof * np.log(squares_sum)))
            residual = values[at] - x[at] @ beta - new @ old @ rest
            spread = max(np.sqrt(variance * squares_sum / dof), errors[at])
            probabilities.append(stats.t.cdf(residual / spread, dof))
        share = PRIOR * np.exp(np.array(weights) - max(weights))
        mixed = float(share @ probabilities / share.sum())
        assert found[at] == pytest.approx(stats.norm.ppf(mixed), abs=1e-4)


def test_what_comes_later_changes_no_difference() -> None:
    twin = Twin(day=0.087, logs=2)
    whole = control_chart(series(twin, 40, 3, error=0.02), Limits.of(1e6)).differences
    part = control_chart(series(twin, 25, 3, error=0.02), Limits.of(1e6)).differences
    assert np.array_equal(whole[:25], part, equal_nan=True)


@pytest.mark.parametrize("twin", [Twin(), Twin(day=0.087, logs=3)])
def test_while_nothing_changes_differences_are_independent_and_normal(twin: Twin) -> None:
    """Tests of level 0.001 each, on fixed seeds."""
    runs = [control_chart(series(twin, 60, seed), Limits.of(1e9)).differences for seed in range(25)]
    z = np.array(runs)[:, 12:]  # by then the days are known
    assert stats.kstest(z.ravel(), "norm").pvalue > 0.001
    neighbours = stats.pearsonr(z[:, 1:].ravel(), z[:, :-1].ravel())
    assert neighbours.pvalue > 0.001


@pytest.mark.parametrize(
    ("scatter", "times"),
    [
        ("normal", 1),
        ("heavy tails", 1),
        ("log-normal", 1),
        ("outliers", 1),
        ("unequal intervals", 1),
        ("irregular dates", 1),
        ("days alike, 0.3", 2),
        ("days alike, 0.6", 2),
    ],
)
def test_false_alarms_come_at_most_at_the_rate_they_are_set_to(scatter: str, times: int) -> None:
    """Of two charts set to one in 200 logs each, over 8,000 logs: at most 80 are expected.

    Days that are alike may raise twice as many.

    A Poisson count of that mean exceeds the bound with a probability below 0.001. With limits for
    single logs, heavy tails raise four times as many, days that are alike three to seven times.
    """
    runs, logs, limits = 40, 200, Limits.of(200.0)
    count = 0
    for seed in range(runs):
        draw = np.random.default_rng(seed)
        values, errors, days = SCATTER[scatter](draw, logs)
        estimates = Series(10.0 + 0.5 * values, 0.5 * errors, days, np.zeros(logs, dtype=np.int64))
        count += len(control_chart(estimates, limits).alarms)
    assert 20 < count <= stats.poisson.ppf(0.999, times * runs * logs / 100.0)


def test_no_log_alone_raises_an_alarm_and_two_do() -> None:
    draw = np.random.default_rng(3)
    limits = Limits.of(730.0)
    for size in (8.0, 50.0):
        values = 1.0 + 0.03 * draw.normal(size=60)
        values[40] += 0.03 * size
        alone = control_chart(whole(values), limits)
        assert not [a for a in alone.alarms if a.at >= 40]
        values[41] += 0.03 * size
        assert [a.at for a in control_chart(whole(values), limits).alarms if a.at >= 40] == [41]


def whole(values: np.ndarray) -> Series:
    """A log a day without an interval of its own."""
    count = len(values)
    zeros = np.zeros(count)
    return Series(values, zeros, np.arange(count, dtype=float), zeros.astype(np.int64))


def test_a_step_of_15_per_cent_is_found_within_three_logs_and_its_size_is_right() -> None:
    """At one false alarm a year of a log a day, where logs scatter by 3 %."""
    limits, delays, held = Limits.of(2 * 365), [], 0
    step = 0.15 * 1.35
    for seed in range(20):
        twin = Twin(log=0.03 * 1.35, step=step, at=40)
        alarms = control_chart(series(twin, 48, seed), limits).alarms
        alarm = next(a for a in alarms if a.at >= 40)
        delays.append(alarm.at - 40 + 1)
        change = alarm.changes[0]
        assert change.shape == "step"
        assert change.at == pytest.approx(40, abs=1)
        held += change.low <= step <= change.high
        assert change.level == pytest.approx(1.35, rel=0.02)
    assert max(delays) <= 3
    assert held >= 16  # of 20 at 95 %: fewer with a probability of 0.003


def test_after_a_step_the_charts_begin_anew() -> None:
    twin = Twin(log=0.03, step=0.5, at=30)
    chart = control_chart(series(twin, 90, 4), Limits.of(1e4))
    assert [a.at for a in chart.alarms] == [31]
    assert np.nanmax(chart.up[32:]) < chart.limits.cusum


def test_a_large_step_that_was_told_is_no_scatter_and_the_next_one_is_told() -> None:
    """A log a week that scatters by 0.15, with two steps of 4, ten logs and six logs apart.

    While the first one waits for a second log it counts as scatter: where that hides it, as in two
    of the twelve series, one alarm is of both.
    """
    told = 0
    for seed in range(12):
        scatter = 0.15 * np.random.default_rng(seed).normal(size=19)
        values = 20.0 + 4.0 * (np.arange(19) >= 10) + 4.0 * (np.arange(19) >= 16) + scatter
        zeros, days = np.zeros(19), 7.0 * np.arange(19, dtype=float)
        estimates = Series(values, zeros, days, zeros.astype(np.int64))
        chart = control_chart(estimates, Limits.of(313.0))
        steps = [alarm.changes[0] for alarm in chart.alarms]
        if [(c.shape, c.at) for c in steps] == [("step", 10), ("step", 16)]:
            told += 1
            assert all(c.low < 4.0 < c.high for c in steps)
            assert 0.075 < chart.deviation < 0.3
            assert detectable_step(estimates, chart, 3) < 4.0
    assert told >= 10


def test_wear_of_one_per_cent_a_week_is_told_as_a_ramp_with_its_slope() -> None:
    """A log a week that scatters by 3 %, 20 before the wear begins: told before it is 16 %.

    Sizes are of ten weeks more. Of 20 intervals at 95 % fewer than 16 hold with a probability of
    0.003; as seldom a step is more than e^3 times likelier than the ramp.
    """
    ramps = held = 0
    for seed in range(20):
        draw = np.random.default_rng(seed)
        days = np.arange(0.0, 420.0, 7.0)
        values = 1.0 + 0.03 * draw.normal(size=60) + 0.01 * np.maximum(0, np.arange(60) - 20)
        kinds = np.zeros(60, dtype=np.int64)
        alarms = control_chart(Series(values, np.zeros(60), days, kinds), Limits.of(104.0)).alarms
        first = next(a for a in alarms if a.at >= 20)
        assert first.at < 36
        end = first.at + 11
        early = Series(values[:end], np.zeros(end), days[:end], kinds[:end])
        told = next(a for a in control_chart(early, Limits.of(104.0)).alarms if a.at >= 20)
        (ramp,) = (c for c in told.changes if c.shape == "ramp")
        ramps += told.changes[0].log_likelihood - ramp.log_likelihood < 3.0
        held += 7.0 * ramp.low <= 0.01 <= 7.0 * ramp.high
    assert ramps >= 16
    assert held >= 16


def test_a_season_alarms_where_its_temperature_is_not_known() -> None:
    twin = Twin(log=0.03, slope=-0.03, season=8.0)
    unknown = control_chart(series(twin, 300, 6), Limits.of(2e4))
    known = control_chart(series(twin, 300, 6, warm=True), Limits.of(2e4))
    assert unknown.alarms
    assert not known.alarms
    assert known.compared > 280


def test_nothing_is_standardised_by_less_than_its_own_interval() -> None:
    twin = Twin(log=0.01, step=0.1, at=30)
    assert control_chart(series(twin, 60, 7, error=0.005), Limits.of(1e4)).alarms
    assert not control_chart(series(twin, 60, 7, error=0.2), Limits.of(1e4)).alarms


def test_kinds_have_levels_of_their_own() -> None:
    estimates = series(Twin(log=0.03), 60, 8)
    kinds = np.arange(60, dtype=np.int64) % 2
    shifted = estimates.values + 5.0 * kinds
    apart = Series(shifted, estimates.errors, estimates.times, kinds)
    chart = control_chart(apart, Limits.of(1e4))
    assert not chart.alarms
    assert chart.deviation == pytest.approx(0.03, rel=0.3)


@pytest.mark.parametrize("before", [20, 60])
def test_half_of_all_steps_of_the_detectable_size_are_told_by_their_third_log(before: int) -> None:
    """Of 80 the share is 0.5 give or take 0.2: 3.5 binomial errors, and what is approximate."""
    limits, told, twins = Limits.of(400.0), 0, 0
    for seed in range(80):
        draw = np.random.default_rng(seed)
        values = 10.0 + 0.4 * draw.normal(size=before + 3)
        known = whole(values[:before])
        chart = control_chart(known, limits)
        step = detectable_step(known, chart, 3)
        if chart.alarms:  # a false one; at the last log, nothing is known of its level
            continue
        twins += 1
        values[before:] += step
        told += any(a.at >= before for a in control_chart(whole(values), limits).alarms)
    assert 0.3 < told / twins < 0.7


def test_after_five_logs_no_step_can_be_told_within_three() -> None:
    """The scatter is hardly known, and the first log of a step is taken for more of it."""
    known = whole(10.0 + 0.4 * np.random.default_rng(1).normal(size=5))
    limits = Limits.of(400.0)
    assert detectable_step(known, control_chart(known, limits), 3) == np.inf
    values = np.append(known.values, [30.0, 30.0, 30.0])
    assert not control_chart(whole(values), limits).alarms


def test_a_covariate_has_its_slope_and_tells_when_it_goes_with_time() -> None:
    """Of 40 intervals at 95 % fewer than 34 hold with a probability of 0.003."""
    held, scatter = 0, ScatterModel(0.0, 0.0, 0.0)
    for seed in range(40):
        draw = np.random.default_rng(seed)
        warmth = draw.normal(20.0, 4.0, 50)
        times, kinds = np.arange(50.0), np.zeros(50, dtype=np.int64)
        values = 1.0 - 0.02 * warmth + draw.normal(0.0, 0.1, 50) + 0.5 * (times >= 30)
        estimates = Series(values, np.zeros(50), times, kinds, warmth)
        effect = covariate_effect(estimates, warmth, scatter, [30])
        held += effect.low <= -0.02 <= effect.high
        assert effect.shared < 0.4
    assert held >= 34
    for warmth in (20.0 + 0.1 * times, np.where(times < 20, 20.0, 31.0)):
        collinear = Series(values, np.zeros(50), times, kinds, warmth)
        assert covariate_effect(collinear, warmth, scatter, []).shared > 0.999
