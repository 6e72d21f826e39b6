"""Control charts of estimates: independent differences, false alarms at their rate, steps found."""

import statistics

import numpy as np
import pytest
from scipy import stats

from drift_twins import Twin
from stribeck.monitoring.control_chart import Limits, control_chart
from stribeck.monitoring.series import Series


def series(twin: Twin, count: int, seed: int, *, error: float = 0.0, warm: bool = False) -> Series:
    rows = twin.estimates(count, seed)
    days, values, warmth = (np.array(column) for column in zip(*rows, strict=True))
    zeros = np.zeros(count, dtype=np.int64)
    return Series(
        values, np.full(count, error), days.astype(np.int64), zeros, warmth if warm else None
    )


def test_with_a_log_a_day_differences_are_those_of_a_self_starting_chart() -> None:
    """Hawkins 1987: the t of each value over those before it, as a normal quantile."""
    estimates = series(Twin(), 12, 1)
    found = control_chart(estimates, Limits.of(1e6)).differences
    x = estimates.values.tolist()
    for n in range(3, 12):
        before = x[:n]
        t = (x[n] - statistics.mean(before)) / statistics.stdev(before) * (n / (n + 1)) ** 0.5
        assert found[n] == pytest.approx(stats.norm.ppf(stats.t.cdf(t, n - 1)), abs=1e-6)
    assert np.isnan(found[:3]).all()


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


def test_false_alarms_come_at_the_rate_they_are_set_to() -> None:
    """Of charts set to one in 60 logs each, which together give at most one in 30.

    A Poisson count of that mean exceeds the bound with a probability below 0.001.
    """
    runs, logs = 25, 100
    limits = Limits.of(60.0)
    twin = Twin(day=0.05, log=0.05)
    count = sum(len(control_chart(series(twin, logs, s), limits).alarms) for s in range(runs))
    most = stats.poisson.ppf(0.999, runs * logs / 30.0)
    assert runs * logs / 60.0 * 0.6 < count <= most


def test_a_step_of_15_per_cent_is_found_within_three_logs_and_its_size_is_right() -> None:
    """At one false alarm a year of a log a day, where logs scatter by 3 %."""
    limits, delays, held = Limits.of(2 * 365), [], 0
    step = 0.15 * 1.35
    for seed in range(20):
        twin = Twin(log=0.03 * 1.35, step=step, at=40)
        alarms = control_chart(series(twin, 48, seed), limits).alarms
        alarm = next(a for a in alarms if a.at >= 40)
        delays.append(alarm.at - 40 + 1)
        assert alarm.change
        assert alarm.change.at == pytest.approx(40, abs=1)
        held += alarm.change.low <= step <= alarm.change.high
        assert alarm.change.level == pytest.approx(1.35, rel=0.02)
    assert max(delays) <= 3
    assert held >= 16  # of 20 at 95 %: fewer with a probability of 0.003


def test_after_a_step_the_charts_begin_anew() -> None:
    twin = Twin(log=0.03, step=0.5, at=30)
    chart = control_chart(series(twin, 90, 4), Limits.of(1e4))
    assert [a.at for a in chart.alarms] == [30]
    assert np.nanmax(chart.up[31:]) < chart.limits.cusum


def test_slow_wear_is_found() -> None:
    twin = Twin(log=0.05, wear=0.004)
    assert control_chart(series(twin, 120, 5), Limits.of(2 * 365)).alarms


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
    apart = Series(shifted, estimates.errors, estimates.days, kinds)
    chart = control_chart(apart, Limits.of(1e4))
    assert not chart.alarms
    assert chart.scatter == pytest.approx(0.03, rel=0.3)
