"""Verdicts, sensitivities, blind directions, noise, posterior of an estimate."""

import sys
from collections.abc import Callable

import numpy as np
import pytest

from stribeck import InputError, Recording, identify, problem
from stribeck.friction import LAWS
from stribeck.identify.balance.force_residuals import BalanceResiduals
from stribeck.identify.balance.regression import System
from stribeck.identify.balance.rows import filtered_logs
from stribeck.identify.card import Card
from stribeck.identify.parameters import Parameters
from stribeck.identify.uncertainty.assessment import uncertainty
from stribeck.identify.uncertainty.blind_directions import directions
from stribeck.identify.uncertainty.covariance import correlation_time, long_run_variance
from stribeck.identify.uncertainty.estimates import range_end
from stribeck.identify.uncertainty.posterior import posterior
from stribeck.identify.uncertainty.profile import IntervalEnd, Profile, profiles
from stribeck.identify.uncertainty.profile_walk import Ended
from stribeck.identify.uncertainty.residuals import orders_of
from stribeck.identify.uncertainty.sensitivity import sensitivities
from stribeck.identify.uncertainty.sensor_noise import rest_noise
from stribeck.identify.uncertainty.verdict import verdict
from stribeck.rig import RIGS
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED
from stribeck.rig.twin import TestBed
from stribeck.space import Array, Param, Space, box
from stribeck.units import percent


class Model:
    """Measured data less a formula of the parameters."""

    def __init__(self, space: Space, y: Array, formula: Callable[[Array], Array]) -> None:
        self.space, self._y, self._formula = space, y, formula

    def residuals(self, x: Array, /) -> Array:
        return np.array([self._y - self._formula(row) for row in x])


T = np.linspace(0, 1, 400)
NOISE = np.random.default_rng(0).standard_normal(400)


def profile_of(
    low: float, high: float, low_ended: Ended = "threshold", high_ended: Ended = "threshold",
    value: float = 1.0,
) -> Profile:  # fmt: skip
    none = np.empty(0)
    sides = IntervalEnd(low, low_ended, 1.0), IntervalEnd(high, high_ended, 1.0)
    return Profile("p", value, *sides, none, none, none, 1.0)


RANGE = Param("p", 0.0, 10.0)
DECADES = Param("p", 0.01, 100.0, log=True)


@pytest.mark.parametrize(
    ("profile", "param", "expected", "reason"),
    [
        (profile_of(0.91, 1.09), RANGE, "identified", ""),
        (profile_of(0.89, 1.05), RANGE, "weak", "wide"),  # 11 % on one side
        # narrow, ended by the range
        (profile_of(0.95, 1.04, high_ended="bound"), RANGE, "weak", "at a bound"),
        # a guess identifies nothing
        (profile_of(0.95, 1.05, low_ended="budget"), RANGE, "weak", "guessed"),
        (profile_of(0.95, 1.05, low_ended="order"), RANGE, "weak", "rests on another"),
        # 94 % of the range
        (profile_of(0.6, 10.0, high_ended="bound"), RANGE, "not identifiable", "wide"),
        (profile_of(4.0, 10.0, high_ended="flat", value=6.0), RANGE, "weak", "wide"),
        # below 4 excluded
        (profile_of(4.0, 10.0, high_ended="flat", value=9.0), RANGE, "weak", "wide"),
        # above 1.2 excluded
        (profile_of(0.0, 1.2, low_ended="bound", value=0.4), RANGE, "weak", "wide"),
        (profile_of(0.02, 6.5), RANGE, "weak", "wide"),  # 65 % of the range
        (profile_of(0.02, 6.8), RANGE, "not identifiable", "wide"),
        (profile_of(0.3, 6.8), DECADES, "weak", "wide"),  # 1.4 of 4 decades
        (profile_of(0.02, 20.0), DECADES, "not identifiable", "wide"),  # 3 of 4
        (profile_of(0.1, 12.0), DECADES, "not identifiable", "wide"),  # 2.1 decades: no idea
        (profile_of(0.0, 0.0, value=0.0), RANGE, "not identifiable", "at a bound"),
        (profile_of(0.5, 2.0, "bound", "bound"), RANGE, "not identifiable", "at a bound"),
        (profile_of(-1.05, -0.95, value=-1.0), Param("p", -5.0, 5.0), "identified", ""),
    ],
)
def test_verdicts(profile: Profile, param: Param, expected: str, reason: str) -> None:
    assert verdict(profile, param) == (expected, reason)


def test_the_end_of_a_range_is_one_of_its_scale() -> None:
    stiffness = Param("sigma_0", 1.0, 1e7, log=True)
    assert [range_end(x, stiffness) for x in (1.001, 3237.0, 9.9e6)] == ["lower", None, "upper"]
    assert [range_end(x, RANGE) for x in (0.009, 0.02, 9.995)] == ["lower", None, "upper"]


@pytest.mark.parametrize(("n", "reach"), [(40, 7), (40, 1), (5, 9), (7, 7), (1, 3)])
def test_a_long_run_variance_weighs_products_by_their_lag(n: int, reach: int) -> None:
    """Over windows and over pairs of rows it is the same: Newey and West's 1 - lag / reach."""
    rng = np.random.default_rng(n + reach)
    logs = [rng.standard_normal((2, n)), rng.standard_normal((2, n + 3)), np.empty((2, 0))]
    total = np.zeros(2)
    for log in logs:
        for i in range(log.shape[1]):
            for j in range(log.shape[1]):
                total += max(1 - abs(i - j) / reach, 0.0) * log[:, i] * log[:, j]
    np.testing.assert_allclose(long_run_variance(logs, reach), total, rtol=1e-10)


def test_correlation_alone_demotes_nobody() -> None:
    """Level and slope far from the data correlate by 0.99, and are known to 2 % all the same."""
    t = T + 8.0
    model = Model(box([(-10, 30), (0, 4)]), 10 + 2 * t + 0.01 * NOISE, lambda x: x[0] + x[1] * t)
    assessment = uncertainty(model, np.array([10.0, 2.0]))
    assert abs(assessment.correlation[0, 1]) > 0.99
    for p, param in zip(assessment.profiles.profiles, model.space, strict=True):
        assert verdict(p, param)[0] == "identified"


def test_what_doubling_does_is_what_it_does() -> None:
    """One parameter and known noise: J at twice the value has a formula."""
    y = 3 * T + 0.1 * NOISE
    model = Model(box([(0.0, 10.0)]), y, lambda x: x[0] * T)
    profiled = profiles(model, np.array([3.0]))
    (effect,), rows = sensitivities(model, profiled)
    least, at_twice = (np.sqrt(np.mean((y - k * profiled.x[0] * T) ** 2)) for k in (1, 2))
    assert effect.kind == "doubling"
    assert effect.value == pytest.approx(2 * profiled.x[0])
    assert effect.change == pytest.approx(at_twice / least - 1, rel=1e-6)
    assert rows > 0


def test_doubling_refits_the_others() -> None:
    """Doubling one factor of a product changes nothing, as the other halves."""
    model = Model(box([(0.1, 10)] * 2), 2 * T + 0.1 * NOISE, lambda x: x[0] * x[1] * T)
    profiled = profiles(model, np.array([1.0, 2.0]))
    for effect in sensitivities(model, profiled)[0]:
        assert effect.kind == "doubling"
        assert effect.change == pytest.approx(0.0, abs=1e-4)


def test_halving_and_ends_where_doubling_leaves_the_range() -> None:
    y = 3 * T + 0.1 * NOISE
    for upper, lower, kind, value in ((5.0, 0.0, "halving", 1.5), (5.0, 2.0, "end", 5.0)):
        model = Model(box([(lower, upper)]), y, lambda x: x[0] * T)
        (effect,), _ = sensitivities(model, profiles(model, np.array([3.0])))
        assert effect.kind == kind
        assert effect.value == pytest.approx(value, rel=0.01)


def test_a_blind_direction_is_put_into_words() -> None:
    model = Model(
        Space((Param("a", 0.1, 10), Param("b", 0.1, 10), Param("c", -5, 5))),
        2 * T + 1 + 0.05 * NOISE,
        lambda x: x[0] * x[1] * T + x[2],
    )
    profiled = profiles(model, np.array([1.0, 2.0, 1.0]))
    (blind,) = directions(model.space, profiled)
    assert set(blind.names) == {"a", "b"}
    a, b = (blind.changes[blind.names.index(n)] for n in "ab")
    assert (1 + a) * (1 + b) == pytest.approx(1.0, abs=0.01)
    assert abs(blind.changes[0]) >= 0.1
    assert "together with" in blind.text()
    assert blind.text().endswith("only their combination is known")
    assert blind.misfit < 0.001
    line_model = Model(box([(0, 4), (-5, 5)]), 2 * T + 1 + 0.05 * NOISE, lambda x: x[0] * T + x[1])
    assert directions(line_model.space, profiles(line_model, np.array([2.0, 1.0]))) == ()


def test_percents_for_people() -> None:
    assert [percent(x) for x in (3e-5, 1e-3, -0.096, 1.234, 3.7)] == [
        "less than 0.01 %", "0.1 %", "-9.6 %", "123 %", "370 %",
    ]  # fmt: skip


@pytest.fixture(scope="module")
def log() -> Recording:
    return TestBed().run("both", seed=1).recording


def test_rests_show_the_noise_of_the_sensor(log: Recording) -> None:
    """0.3 mm of the transducer and a converter step of 0.098 mm; 3,000 samples pin it to 2 %."""
    assert rest_noise([log]) == pytest.approx(np.hypot(0.3e-3, 0.4 / 4096 / np.sqrt(12)), rel=0.04)
    moving = Recording(t=np.linspace(0.0, 1.99, 200), position=np.linspace(0, 0.2, 200))
    assert np.isnan(rest_noise([moving]))


def test_the_order_of_a_law_is_known_to_its_problem(log: Recording) -> None:
    objective = problem(log, rig="slide-bed", train="112:295")
    assert orders_of(objective) == ((0, 1),)  # F_S >= F_C
    directional = problem(log, rig="slide-bed", law="stribeck-directional", tie={"F_C-": "F_C+"})
    names = directional.space.names
    assert {(names[i], names[j]) for i, j in orders_of(directional)} == {
        ("F_S+", "F_C+"),
        ("F_S-", "F_C+"),
    }


def test_a_force_balance_shows_its_residuals() -> None:
    """One point at a time or many of a shape, which are affine: the same to rounding."""
    t = np.arange(0, 4, 1e-3)
    x = 0.1 * np.sin(2 * np.pi * t) + 0.03 * np.sin(2 * np.pi * 3.1 * t)
    force = 5.0 * np.sign(np.gradient(x, t)) + 0.2 * np.random.default_rng(2).standard_normal(
        len(t)
    )
    parameters = Parameters.declared(RIGS["forced"], LAWS["stribeck"])
    logs = filtered_logs([Recording(t=t, position=x, force=force)], parameters, None, None)
    system = System(parameters, logs)
    objective = BalanceResiduals(system)
    at = objective.space.decode(objective.space.sample(np.random.default_rng(3), 12))
    F_S, F_C, v_SS = (objective.space.names.index(n) for n in ("F_S", "F_C", "v_SS"))
    at[:, F_S] = at[:, F_C] + 1.0
    at[4:, v_SS] = at[3, v_SS]
    at[11, F_S] -= 2.0  # below F_C: not allowed
    residuals = objective.residuals(at)
    assert objective.logs == (len(system.y),)
    assert np.isnan(residuals[11]).all()
    whole = system.parameters.full(at[:11])
    pointwise = [system.y - system.predicted(p[None])[:, 0] for p in whole]
    np.testing.assert_allclose(
        residuals[:11], pointwise, rtol=1e-9, atol=1e-9 * np.abs(system.y).max()
    )


def test_intervals_of_a_twin_hold_the_truth_and_say_why_they_end(log: Recording) -> None:
    """A 95 % interval each; the five of this seed all hold."""
    fit = identify(log, rig=SLIDE_BED.exact(), train="112:295", fixed={"exponent": 1.0})
    truth = dict(zip(("F_S", "F_C", "F_V", "v_SS", "k_spring"), PUBLISHED["right"][[0, 1, 2, 3, 5]],
                     strict=True))  # fmt: skip
    for e in fit.estimates:
        if e.verdict == "fixed":
            assert e.low_ended is None
            continue
        assert e.low <= truth[e.name] <= e.high
        assert e.meaning
        assert (e.low_ended == "bound") == (e.low == pytest.approx(_range(fit, e.name)[0]))
    named = {e.name: e for e in fit.estimates}
    assert named["F_S"].verdict == "identified"
    assert named["v_SS"].verdict != "identified"
    assert fit.uncertainty.rows < 3_000


def _range(fit: object, name: str) -> tuple[float, float]:
    (q,) = (q for q in fit.parameters.free if q.name == name)  # type: ignore[attr-defined]
    return q.lower, q.upper


def test_a_linear_posterior_is_the_normal_one() -> None:
    """Mean and covariance of a normal; over 16 seeds the means scatter by 0.037 of a deviation."""
    W = np.column_stack([np.ones(400), T])
    y = W @ [1.0, 2.0] + 0.3 * NOISE
    model = Model(box([(-50, 50)] * 2), y, lambda x: W @ x)
    best = np.asarray(np.linalg.lstsq(W, y, rcond=None)[0], dtype=float)
    draws = posterior(model, best, walkers=24, samples=25_200, seed=1)
    residuals = y - W @ best
    C = np.linalg.inv(W.T @ W) * (residuals @ residuals) / 398 * correlation_time(residuals)
    sd = np.sqrt(np.diag(C))
    assert draws.samples.mean(axis=0) == pytest.approx(best, abs=0.15 * sd.max())
    assert np.cov(draws.samples.T) == pytest.approx(C, rel=0.2)
    np.testing.assert_allclose((draws.high - draws.low) / (2 * 1.96 * sd), 1.0, atol=0.1)
    for share, z in ((5, -1.6449), (25, -0.6745), (50, 0.0), (75, 0.6745), (95, 1.6449)):
        quantile = np.percentile(draws.samples, share, axis=0)
        np.testing.assert_allclose((quantile - best) / sd, z, atol=0.25)
    np.testing.assert_array_equal(draws.median, np.percentile(draws.samples, 50, axis=0))
    assert draws.settled
    repeated = posterior(model, best, walkers=24, samples=840, seed=1)
    assert np.array_equal(
        repeated.samples, posterior(model, best, walkers=24, samples=840, seed=1).samples
    )


def test_without_emcee_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "emcee", None)
    model = Model(box([(0.0, 10.0)]), 3 * T, lambda x: x[0] * T)
    with pytest.raises(InputError, match=r"pip install 'stribeck\[posterior\]'"):
        posterior(model, np.array([3.0]))


def test_walkers_too_few_are_refused() -> None:
    pytest.importorskip("emcee")
    model = Model(box([(0.0, 10.0)]), 3 * T, lambda x: x[0] * T)
    with pytest.raises(InputError, match="give at least 2 and 1"):
        posterior(model, np.array([3.0]), walkers=1)


def test_posterior_and_profile_of_a_twin_agree(log: Recording) -> None:
    """Two roads to one interval: ends within a third of its width, and the truth in both.

    An end of the range cuts the prior, and the posterior is narrower than the profile beside it.
    """
    pytest.importorskip("emcee")
    fit = identify(log, rig="slide-bed", train="112:295", fixed={"exponent": 1.0}, posterior=4_000)
    truth = dict(zip(("F_S", "F_C", "F_V", "v_SS", "k_spring"), PUBLISHED["right"][[0, 1, 2, 3, 5]],
                     strict=True))  # fmt: skip
    drawn = fit.posterior
    assert drawn is not None
    assert drawn.samples.shape == (4_000, len(drawn.names))
    names = [q.name for q in fit.parameters.free]
    assert list(drawn.names[:5]) == names == list(truth)  # starts of motions come after them
    by_name = {e.name: e for e in fit.estimates}
    for k, name in enumerate(names):
        low, high = by_name[name].low, by_name[name].high
        width = high - low
        assert low < drawn.median[k] < high
        assert drawn.low[k] <= truth[name] <= drawn.high[k]
        assert low - 0.35 * width < drawn.low[k] < drawn.high[k] < high + 0.35 * width
        if by_name[name].low_ended == by_name[name].high_ended == "threshold":
            assert drawn.low[k] == pytest.approx(low, abs=0.35 * width)
            assert drawn.high[k] == pytest.approx(high, abs=0.35 * width)
    written = fit.card()
    assert written.posterior is not None
    assert list(written.posterior.parameters) == names
    assert written.posterior.parameters["F_S"].low == pytest.approx(drawn.low[0])
    assert Card.model_validate_json(written.text()) == written
    assert '"posterior":' not in written.model_copy(update={"posterior": None}).text()
