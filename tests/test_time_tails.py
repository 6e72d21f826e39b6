"""Expected running times by families of distributions: closed forms, and coverage."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad
from scipy.special import ndtr

from stribeck.bench.running_time import interval_ends, studentised_ends
from stribeck.bench.statistics import resamples
from stribeck.bench.time_tails import (
    FAMILIES,
    FRECHET,
    LOG_LOGISTIC,
    LOG_NORMAL,
    PARETO,
    WEIBULL,
    Family,
    RunTimes,
    likely_times,
    until_budget,
)

#: The same families by scipy: of z = log T at location 0 and scale 1.
OTHERS = (
    (WEIBULL, stats.gumbel_l),
    (LOG_NORMAL, stats.norm),
    (LOG_LOGISTIC, stats.logistic),
    (FRECHET, stats.gumbel_r),
    (PARETO, stats.expon),
)


@pytest.mark.parametrize(("family", "other"), OTHERS)
def test_a_family_is_that_of_scipy(family: Family, other: stats.rv_continuous) -> None:
    z, odds = np.linspace(-3.0, 6.0, 19), np.linspace(-9.0, 9.0, 19)
    assert family.density(z) == pytest.approx(other.logpdf(z), abs=1e-9)
    assert family.survival(z) == pytest.approx(other.logsf(z), abs=1e-9)
    assert family.quantile(odds) == pytest.approx(other.ppf(stats.logistic.cdf(odds)), abs=1e-6)


@pytest.mark.parametrize("scale", [0.05, 0.6, 1.5])
@pytest.mark.parametrize("family", FAMILIES)
def test_time_until_the_budget_is_the_area_below_the_survival(family: Family, scale: float) -> None:
    """Also of tails without a mean, as a run ends at its budget; half a percent is little here."""
    budget, location = 40.0, 0.3

    def survival(t: float) -> float:
        return float(np.exp(family.survival(np.array([(math.log(t) - location) / scale])))[0])

    marks = [math.exp(location) * m for m in (0.5, 0.9, 1.0, 1.1, 2.0)]
    area = quad(survival, 1e-12, budget, points=marks, limit=400)[0]
    at = np.array([location]), np.array([scale])
    mean, share = until_budget(budget, family, *at)
    assert mean[0] == pytest.approx(area, rel=5e-3)
    assert share[0] == pytest.approx(1.0 - survival(budget), rel=1e-9)


def test_many_log_normal_times_have_the_mean_of_their_law() -> None:
    """With 400 runs the standard error of the logarithm is about 0.06 here."""
    rng = np.random.default_rng(0)
    times, budget = rng.lognormal(0.0, 1.0, 400), 50.0
    hit = times <= budget
    runs = RunTimes(np.minimum(times, budget), hit, ~hit, budget)
    mean = math.exp(0.5) * ndtr(math.log(budget) - 1.0) + budget * ndtr(-math.log(budget))
    truth = mean / ndtr(math.log(budget))
    low, high = np.quantile(likely_times(runs, rng), [0.025, 0.975])
    assert low < truth < high
    assert high / low < 1.4


def test_runs_that_end_by_themselves_cost_what_they_spend() -> None:
    """One in two, after 7: on average one such run before each success."""
    rng = np.random.default_rng(0)
    hit = np.arange(400) % 2 == 0
    spent = np.where(hit, rng.exponential(1.0, 400), 7.0)
    runs = RunTimes(spent, hit, np.zeros(400, bool), 1000.0)
    assert np.median(likely_times(runs, rng)) == pytest.approx(8.0, rel=0.1)


def test_the_tail_that_ten_runs_do_not_show_is_reckoned_with() -> None:
    """300 campaigns of 10 log-normal times with a deviation of 1.5, budget 30 mean times.

    The bootstrap alone covers 85 %, so that 276 would have a chance of 2e-4; were the coverage
    97 %, less than 280 would have one of 1e-3.
    """
    budget, law = 30.0, stats.lognorm(1.5, scale=math.exp(-1.125))
    truth = quad(law.sf, 0.0, budget, points=[0.1, 1.0], limit=400)[0] / law.cdf(budget)
    covered, alone = 0, 0
    for seed in range(300):
        rng = np.random.default_rng(seed)
        time = law.rvs(10, random_state=rng)
        hit = time <= budget
        runs = RunTimes(np.minimum(time, budget), hit, ~hit, budget)
        drawn = resamples(10, rng, 500)
        low, high = interval_ends(runs, drawn, rng)
        covered += low <= truth <= high
        low, high = studentised_ends(drawn, runs.spent, hit.astype(float))
        alone += low <= truth <= high
    assert alone < 276
    assert covered >= 280
