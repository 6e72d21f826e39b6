"""Profile likelihood: against closed forms, at bounds and at ends of ranges."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy import optimize, stats
from scipy.signal import lfilter

from stribeck import InputError
from stribeck.identify.uncertainty.covariance import quick_look
from stribeck.identify.uncertainty.linearisation import box_of, linearised
from stribeck.identify.uncertainty.profile import Profile, Profiles, profiles
from stribeck.identify.uncertainty.profile_walk import Ray, rechecked
from stribeck.optimize.lockstep import AskTell, Counted, lockstep
from stribeck.optimize.trust_region import minimise
from stribeck.space import Array, Param, Space, box


class Model:
    """Measured data less a formula of the parameters."""

    def __init__(
        self,
        space: Space,
        y: Array,
        formula: Callable[[Array], Array],
        orders: tuple[tuple[int, int], ...] = (),
    ) -> None:
        self.space, self.orders, self.rows = space, orders, 0
        self._y, self._formula = y, formula

    def residuals(self, x: Array, /) -> Array:
        self.rows += len(x)
        return np.array([self._y - self._formula(row) for row in x])


def line(noise: Array, reach: float = 50.0) -> tuple[Model, Array, Array]:
    """A straight line and a wave with noise: the model, its regressor, the exact fit."""
    t = np.linspace(0, 1, len(noise))
    W = np.column_stack([np.ones_like(t), t, np.sin(40 * t)])
    y = W @ [1.0, 2.0, 0.5] + noise
    model = Model(box([(-reach, reach)] * 3), y, lambda x: W @ x)
    return model, W, np.linalg.lstsq(W, y, rcond=None)[0]


def ends(profiled: Profiles) -> Array:
    return np.array([[p.low.end, p.high.end] for p in profiled.profiles])


def end_reasons(profile: Profile) -> tuple[str, str]:
    return profile.low.ended, profile.high.ended


def test_a_linear_problem_has_the_t_interval() -> None:
    noise = 0.1 * np.random.default_rng(0).standard_normal(40)
    model, W, best = line(noise)
    profiled = profiles(model, best, ratio=np.ones(3))
    sd = np.sqrt(np.sum(profiled.residuals**2) / 37 * np.diag(np.linalg.inv(W.T @ W)))
    half = stats.t.ppf(0.975, 37) * sd
    np.testing.assert_allclose(
        ends(profiled), np.stack([best - half, best + half], axis=1), rtol=1e-6
    )
    assert all(end_reasons(p) == ("threshold", "threshold") for p in profiled.profiles)
    assert profiled.rows == model.rows  # every evaluation is counted


def test_an_end_is_refitted_with_slopes_of_its_own() -> None:
    """Where the slopes on the way out do not see how another parameter helps, the end is no end."""
    model, _, best = line(0.1 * np.random.default_rng(0).standard_normal(40))
    counted, frame = Counted(model, 1000), box_of(model)
    fit = linearised(counted, frame, best)
    ray = Ray(model, frame, fit, 0, 1, threshold=0.1, reach=0.01)
    u = fit.u + np.array([0.01, 0.0, 0.0])
    r = model.residuals(frame.x(u)[None])[0]
    blind = replace(fit.moved(u, r), J=np.zeros_like(fit.J), age=1)
    on_the_way = minimise(blind, frame, [1, 2], gain=1e-4, rest="corrected")
    (stuck,) = lockstep(counted, [AskTell("walk", frame.space, on_the_way)])
    assert stuck is not None
    assert stuck[0].squares == blind.squares
    (refit,) = lockstep(counted, [AskTell("check", frame.space, rechecked(ray, blind))])
    assert refit is not None
    others = fit.J[1:].T
    left = r - others @ np.linalg.lstsq(others, r, rcond=None)[0]
    assert refit.squares == pytest.approx(left @ left, rel=1e-3)
    assert refit.u[0] == u[0]


def test_an_exponential_has_the_interval_of_a_plain_profile() -> None:
    """Asymmetric, against a profile by scipy's own minimiser and root finder."""
    t = np.linspace(0, 3, 12)
    y = 2 * np.exp(-1.3 * t) + 0.15 * np.random.default_rng(1).standard_normal(12)
    space = Space((Param("a", 0.01, 100, log=True), Param("k", 0.01, 100, log=True)))
    profiled = profiles(
        Model(space, y, lambda x: x[0] * np.exp(-x[1] * t)), np.array([1.0, 2.0]), ratio=np.ones(2)
    )

    def least(k: float) -> float:  # a is linear: its best is a formula
        e = np.exp(-k * t)
        return float(np.sum((y - (y @ e) / (e @ e) * e) ** 2))

    best = optimize.minimize_scalar(
        least, bounds=(0.5, 3), method="bounded", options={"xatol": 1e-9}
    )
    top = best.fun * (1 + stats.f.ppf(0.95, 1, 10) / 10)
    low = optimize.brentq(lambda k: least(k) - top, 0.5, best.x)
    high = optimize.brentq(lambda k: least(k) - top, best.x, 4)
    k = profiled.profiles[1]
    assert k.value == pytest.approx(best.x, rel=1e-3)
    half = (high - low) / 2
    assert (k.low.end, k.high.end) == pytest.approx((low, high), abs=0.02 * half)
    assert (high - best.x) > 1.05 * (best.x - low)  # it is not symmetric, so neither is ours
    assert profiled.rows < 100


def product(upper: float = 10.0) -> Model:
    t = np.linspace(0, 1, 50)
    y = 2 * t + 0.05 * np.random.default_rng(1).standard_normal(50)
    return Model(box([(0.1, upper), (0.1, upper)]), y, lambda x: x[0] * x[1] * t)


def test_of_a_product_neither_factor_is_known() -> None:
    """a b = 2.1 and b <= 10 leave a >= 0.21 and nothing more."""
    profiled = profiles(product(), np.array([1.0, 2.0]))
    for p in profiled.profiles:
        assert p.high.ended == "flat"
        assert p.high.end == pytest.approx(10.0)
        assert 0.19 < p.low.end < 0.24
        along = p.places.prod(axis=1)
        np.testing.assert_allclose(along, along[0], rtol=0.02)  # the others were refitted


def test_a_parameter_at_its_bound_has_an_open_side() -> None:
    model, W, best = line(0.1 * np.random.default_rng(3).standard_normal(60))
    model.space = box([(-5, 5), (best[1] + 0.3, 5), (-5, 5)])
    start = np.array([best[0], best[1] + 0.3, best[2]])
    profile = profiles(model, start, ratio=np.ones(3)).profiles[1]
    assert profile.value == pytest.approx(best[1] + 0.3)
    assert profile.low.ended == "bound"
    assert profile.low.end == pytest.approx(profile.value)
    assert profile.high.ended == "threshold"
    # the threshold counts from the bound: sqrt(squares there + rise) on the same parabola
    residuals = model.residuals(np.array([[*_held(model, W, profile.value)]]))[0]
    rise = np.sum(residuals**2) / 57 * stats.f.ppf(0.95, 1, 57)
    curve = 1 / np.linalg.inv(W.T @ W)[1, 1]
    assert profile.high.end == pytest.approx(best[1] + np.sqrt(0.09 + rise / curve), rel=2e-3)


def _held(model: Model, W: Array, value: float) -> Array:
    """The least-squares parameters at a fixed slope."""
    y = model.residuals(np.zeros((1, 3)))[0]
    refitted = np.linalg.lstsq(W[:, [0, 2]], y - W[:, 1] * value, rcond=None)[0]
    return np.array([refitted[0], value, refitted[1]])


def test_what_the_data_do_not_see_is_flat_on_both_sides() -> None:
    t = np.linspace(0, 1, 30)
    y = t + 0.1 * np.random.default_rng(4).standard_normal(30)
    space = Space((Param("seen", -5, 5), Param("unseen", 1e-3, 10, log=True)))
    profiled = profiles(Model(space, y, lambda x: x[0] * t), np.array([1.0, 0.1]))
    visible, hidden = profiled.profiles
    assert end_reasons(visible) == ("threshold", "threshold")
    assert end_reasons(hidden) == ("flat", "flat")
    assert (hidden.low.end, hidden.high.end) == pytest.approx((1e-3, 10))
    assert profiled.quick.blind.tolist() == [False, True]
    assert np.isinf(profiled.quick.errors[1])


def test_what_is_known_is_what_is_known_wherever_the_unknown_is() -> None:
    """A drop of friction below all speeds shows the level after it, one above them that before."""
    v = np.linspace(1.0, 1.2, 60)
    y = 12.0 + 0.05 * np.random.default_rng(5).standard_normal(len(v))
    space = Space(
        (
            Param("F_S", 0.0, 40.0, "N"),
            Param("F_C", 0.0, 40.0, "N"),
            Param("v_s", 1e-3, 1e3, "m/s", log=True),
        )
    )
    model = Model(space, y, lambda x: x[1] + (x[0] - x[1]) * np.exp(-v / x[2]))
    profiled = profiles(model, np.array([12.0, float(y.mean()), 0.01]), keep=True)
    F_C = profiled.profiles[1]
    assert F_C.low.end < 1.0
    assert F_C.high.end > 30.0
    assert profiled.rows < 70  # slopes at an open end are taken once


def test_an_order_holds_and_is_named() -> None:
    """Two levels, upper >= lower; raising the lower one takes the upper one along."""
    t = np.linspace(0, 1, 40)
    split = t > 0.5
    y = np.where(split, 1.0, 1.02) + 0.05 * np.random.default_rng(5).standard_normal(40)
    model = Model(
        Space((Param("high", 0.5, 3), Param("low", 0.9, 4))),
        y,
        lambda x: np.where(split, x[0], x[1]) if x[0] >= x[1] else np.full(40, np.nan),
        orders=((0, 1),),
    )
    profiled = profiles(model, np.array([1.0, 0.99]), ratio=np.ones(2))
    high, low = profiled.profiles
    # the data would have low above high: the best in order is their common mean
    assert profiled.x == pytest.approx([y.mean(), y.mean()], rel=1e-4)
    assert high.low.ended == "threshold"
    assert low.high.ended == "threshold"
    best = np.sum((y - y.mean()) ** 2)
    half = np.sqrt(best / 38 * stats.f.ppf(0.95, 1, 38) / 40)
    assert high.low.end == pytest.approx(y.mean() - half, rel=1e-3)  # both go down together
    model.space = Space((Param("high", 0.5, 3), Param("low", float(y.mean()) - 0.005, 4)))
    middle = profiles(model, np.array([1.02, 1.01]), ratio=np.ones(2)).profiles[0]
    assert middle.low.ended == "order"
    assert middle.low.end == pytest.approx(y.mean() - 0.005, rel=1e-6)


def test_what_a_law_forbids_is_told_from_what_cannot_be_run() -> None:
    t = np.linspace(0, 1, 40)
    y = 1.0 * t + 0.1 * np.random.default_rng(6).standard_normal(40)

    def walled(x: Array) -> Array:
        return x[0] * t if x[0] < 1.02 else np.full(40, np.nan)

    model = Model(box([(0.0, 5.0)]), y, walled)
    p = profiles(model, np.array([1.0]), ratio=np.ones(1)).profiles[0]
    assert p.high.ended == "unrunnable"
    assert p.high.end == pytest.approx(1.02, abs=2e-3)
    assert p.low.ended == "threshold"
    model.physical = lambda x: x[:, 0] < 1.02  # type: ignore[attr-defined]
    assert profiles(model, np.array([1.0]), ratio=np.ones(1)).profiles[0].high.ended == "order"


def test_a_step_in_the_misfit_ends_the_interval_there() -> None:
    t = np.linspace(0, 1, 40)
    y = t + 0.1 * np.random.default_rng(7).standard_normal(40)
    step = float(y @ t / (t @ t)) + 0.02
    model = Model(box([(0.0, 5.0)]), y, lambda x: x[0] * t + (3.0 if x[0] > step else 0.0))
    p = profiles(model, np.array([1.0]), ratio=np.ones(1)).profiles[0]
    assert p.high.end == pytest.approx(step, abs=1e-3)
    assert (p.high.ended, p.low.ended) == ("threshold", "threshold")
    assert p.value - p.low.end > 0.04  # without the step it would be as far


def waves() -> Model:
    """A frequency with many basins, the best at 7.0, and a slope."""
    t = np.linspace(0, 3, 80)
    y = np.sin(7.0 * t) + 0.3 * t + 0.05 * np.random.default_rng(8).standard_normal(80)
    return Model(box([(1.0, 12.0), (-2.0, 2.0)]), y, lambda x: np.sin(x[0] * t) + x[1] * t)


def wells() -> Model:
    """A slope of 1.02 +- 0.05 through a cubic: 0.98 at -1 is a basin, 0.95 at 1 the ridge."""
    t = np.linspace(0, 1, 40)
    e = np.random.default_rng(8).standard_normal(40)
    e -= t * (e @ t) / (t @ t)
    e *= 0.05 * np.sqrt(t @ t) / np.sqrt(e @ e / 39)
    return Model(
        box([(-2.5, 4.0)]), 1.02 * t + e, lambda x: (0.965 + 0.0075 * (x[0] ** 3 - 3 * x[0])) * t
    )


def test_a_better_fit_met_on_the_way_is_taken() -> None:
    """The search ended in the poor basin; the ridge is lower than the threshold."""
    model, ratio = wells(), np.ones(1)
    basin = profiles(model, np.array([-1.0]), ratio=ratio, keep=True)
    assert basin.x == pytest.approx([-1.0])
    assert basin.improved == 0
    profiled = profiles(model, np.array([-1.1]), ratio=ratio)
    assert profiled.improved == 1
    best = optimize.brentq(lambda x: 0.0075 * (x**3 - 3 * x) - 0.055, 1, 4)
    assert profiled.x == pytest.approx([best], rel=1e-3)
    assert profiled.squares < profiled.before
    # both basins are in the interval: down to where the slope is 2 x 0.05 too small
    p = profiled.profiles[0]
    low = 1.02 - 0.05 * np.sqrt(stats.f.ppf(0.95, 1, 39))
    crossing = optimize.brentq(lambda x: 0.965 + 0.0075 * (x**3 - 3 * x) - low, -2.5, -1)
    assert p.low.end == pytest.approx(crossing, abs=0.1)
    repeated = profiles(model, profiled.x, ratio=ratio)
    assert repeated.improved == 0
    np.testing.assert_allclose(ends(repeated), ends(profiled), rtol=1e-2)


def test_a_run_is_the_same_twice() -> None:
    a, b = (profiles(waves(), np.array([6.8, 0.2])) for _ in range(2))
    assert np.array_equal(ends(a), ends(b))
    assert a.rows == b.rows


def test_a_budget_is_kept_and_told() -> None:
    model = waves()
    profiled = profiles(model, np.array([7.0, 0.3]), budget=7)
    assert model.rows <= 7
    assert not profiled.complete
    assert {"budget"} <= {s.ended for p in profiled.profiles for s in (p.low, p.high)}
    full = profiles(model, np.array([7.0, 0.3]))
    assert full.complete
    # ends extrapolated from the slopes are near those of the walks: the basin is round
    np.testing.assert_allclose(ends(profiled), ends(full), rtol=0.02)
    with pytest.raises(InputError, match="budget of 2 rows"):
        profiles(model, np.array([7.0, 0.3]), budget=2)


def test_refusals() -> None:
    model = waves()
    with pytest.raises(InputError, match="no free parameter 'x9'"):
        profiles(model, np.array([7.0, 0.3]), chosen_names=["x9"])
    all_nan = Model(box([(0.0, 1.0)]), np.zeros(9), lambda _: np.full(9, np.nan))
    with pytest.raises(InputError, match="cannot be run"):
        profiles(all_nan, np.array([0.5]))
    underdetermined = Model(box([(0.0, 1.0)] * 3), np.zeros(3), lambda x: x)
    with pytest.raises(InputError, match="3 rows cannot tell 3"):
        profiles(underdetermined, np.full(3, 0.5))
    model.logs = (40, 41)  # type: ignore[attr-defined]
    with pytest.raises(InputError, match="81 rows in all"):
        profiles(model, np.array([7.0, 0.3]))


def red_noise(rng: np.random.Generator, n: int, a: float) -> Array:
    """First-order autoregression of unit variance."""
    noise: Array = lfilter([np.sqrt(1 - a * a)], [1, -a], rng.standard_normal(n + 100))[100:]
    return noise


def test_each_parameter_pays_for_correlation_by_its_own_ratio() -> None:
    """A level pays (1 + a) / (1 - a) = 4; a wave at half the sampling rate gains, and pays 1."""
    a, n, trials = 0.6, 4000, 12
    W = np.stack([np.ones(n), np.cos(np.pi * np.arange(n))])
    ratios = []
    for seed in range(trials):
        r = red_noise(np.random.default_rng(seed), n, a)
        r = r - (r @ W.T / n) @ W
        ratios.append(quick_look(W, r, (n,)).ratio)
    # a ratio scatters by some 15 %, the mean of 12 by 4 %; allow 3.5 standard errors
    assert np.mean(ratios, axis=0) == pytest.approx([4.0, 1.0], rel=0.15)


def test_a_parameter_that_few_rows_show_pays_for_the_correlation_of_all() -> None:
    """Ten rows of 4000 show it: their own residuals tell nothing of how these are correlated."""
    a, n, rows = 0.6, 4000, 10
    pulse = np.zeros((1, n))
    pulse[0, 1000 : 1000 + rows] = 1.0
    lags = np.abs(np.subtract.outer(np.arange(rows), np.arange(rows)))
    exact = np.sum(a**lags) / rows  # the variance of a mean of ten rows over that of white ones
    ratios = []
    for seed in range(12):
        r = red_noise(np.random.default_rng(seed), n, a)
        ratios.append(quick_look(pulse, r - pulse[0] * (r @ pulse[0]) / rows, (n,)).ratio[0])
    assert min(ratios) > 0.85 * exact
    assert np.median(ratios) == pytest.approx(exact, rel=0.1)


def test_a_slow_error_under_the_noise_of_a_sensor_is_seen() -> None:
    """Half white, half of a time constant of 50 rows: a level pays (1 + 99) / 2 = 50."""
    n, ratios = 3000, []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        r = rng.standard_normal(n) + red_noise(rng, n, 0.98)
        ratios.append(quick_look(np.ones((1, n)), r - r.mean(), (n,)).ratio[0])
    # Bartlett weights see some 85 % of it; a ratio scatters by half, the mean of 12 by a seventh
    assert np.mean(ratios) == pytest.approx(45.0, rel=0.45)


def test_nothing_correlates_across_logs() -> None:
    """Steps from log to log are no correlation within them: 40 logs of 50 rows, each white."""
    rng = np.random.default_rng(9)
    r = rng.standard_normal(2000)
    W = np.ones((1, 2000))
    whole = quick_look(W, np.repeat(rng.standard_normal(40), 50), (2000,)).ratio[0]
    assert whole > 20  # levels of 50 rows look correlated
    assert quick_look(W, r - r.mean(), (50,) * 40).ratio[0] < 1.5


def test_an_end_of_a_range_that_holds_the_fit_is_no_correlation() -> None:
    """White noise, and a second parameter held at 0, ten standard errors from where it would be."""
    n, ratios = 400, []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        first, second, noise = rng.standard_normal((3, n))
        J = np.stack([first, 0.9 * first + np.sqrt(1 - 0.9**2) * second])
        y = noise + 10 / np.sqrt(n) * J[1]
        ratios.append(quick_look(J, y - J[0] * (J[0] @ y) / (J[0] @ J[0]), (n,)).ratio)
    assert np.mean(ratios, axis=0) == pytest.approx([1.1, 1.1], abs=0.1)


@pytest.mark.parametrize(("a", "least"), [(0.0, 0.93), (0.7, 0.91)])
def test_intervals_hold_the_truth(a: float, least: float) -> None:
    """300 lines with white or red noise, 3 parameters each, 600 rows.

    At the nominal 95 %, 300 trials fall below 0.93 by chance with probability 0.05 (one
    parameter), and the mean of the three, which vary little together, below 0.93 with less than
    0.02; the seed is fixed. With red noise the variance is estimated from 600 / 5.7 independent
    rows: 0.91 is what that may cost.
    """
    hits = np.zeros(3)
    for seed in range(300):
        model, _, best = line(0.3 * red_noise(np.random.default_rng(seed), 600, a))
        e = ends(profiles(model, best))
        hits += (e[:, 0] <= [1.0, 2.0, 0.5]) & (e[:, 1] >= [1.0, 2.0, 0.5])
    assert least <= np.mean(hits / 300) <= 0.985


class Kinked:
    """Parameter b makes up for a; c has a kink at its best, and a steep wall beside it."""

    orders: tuple[tuple[int, int], ...] = ()

    def __init__(self) -> None:
        self.space, self.rows = box([(0.0, 1.0)] * 3), 0
        self.slope = 0.1 * np.linspace(-1, 1, 60)
        self.noise = 1e-3 * np.random.default_rng(0).standard_normal(60)

    def residuals(self, x: Array, /) -> Array:
        self.rows += len(x)
        a, b, c = np.asarray(x).T - 0.5
        line = self.noise + self.slope * a[:, None]
        kink = np.stack([100.0 * (a + b), 0.02 + 0.01 * np.abs(c), 10.0 * c * c], axis=1)
        return np.concatenate([line, kink], axis=1)


def test_a_promise_of_a_weak_slope_does_not_lead_a_walk_astray() -> None:
    """To one side of a kink, c seems to lower what is left over: c moves far, whatever a does."""
    model = Kinked()
    profiled = profiles(model, np.array([0.5, 0.5, 0.5]))
    a = 0.5 - np.sum(model.slope * model.noise) / np.sum(model.slope**2)
    squares = np.sum((model.noise + model.slope * (a - 0.5)) ** 2) + 0.02**2
    half = stats.t.ppf(0.975, 60) * np.sqrt(squares / 60 / np.sum(model.slope**2))
    assert end_reasons(profiled.profiles[0]) == ("threshold", "threshold")
    assert ends(profiled)[0] == pytest.approx([a - half, a + half], abs=0.1 * half)
    assert model.rows < 150  # astray, it is 237
