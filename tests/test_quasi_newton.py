"""BFGS by costs alone: known optima, walls, holes, numbers of evaluations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize

from stribeck.bench.surfaces import rotation
from stribeck.optimize.quasi_newton import BfgsState, quasi_newton
from stribeck.space import Array

Cost = Callable[[Array], Array]  # (n, dim) of the unit cube to (n,)


def descend(cost: Cost, start: Any, **options: float) -> tuple[BfgsState, list[Array]]:
    """The end of a descent from a point or from an interrupted state, and its batches."""
    best = options.pop("best", np.inf)
    if not isinstance(start, BfgsState):
        u = np.array(start, dtype=float)
        start = BfgsState(u, float(cost(u[None])[0]), **options)  # type: ignore[arg-type]
    moves = quasi_newton(start, lambda **_: None, best=best)
    batches: list[Array] = []
    try:
        request = next(moves)
        while True:
            assert isinstance(request, np.ndarray)
            assert request.min() >= 0.0
            assert request.max() <= 1.0
            batches.append(request.copy())
            costs = cost(request)
            request = moves.send(np.where(np.isfinite(costs), costs, np.inf))
    except StopIteration as done:
        return done.value, batches


def rows(batches: list[Array]) -> int:
    return sum(map(len, batches))


def rosenbrock(u: Array) -> Array:
    """Rosenbrock's function over [-2, 2]^dim; its minimum is 0 at 1."""
    x = 4.0 * u - 2.0
    cost: Array = (100.0 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1.0 - x[:, :-1]) ** 2).sum(axis=1)
    return cost


def bowl(dim: int, seed: int, condition: float, outside: float = 0.0) -> tuple[Cost, Array, Array]:
    """A rotated quadratic, its factor and its free minimum, which may lie outside the cube."""
    rng = np.random.default_rng(seed)
    factor = np.sqrt(condition ** np.linspace(0, 1, dim))[:, None] * rotation(rng, dim)
    at = rng.uniform(0.2 - outside, 0.8 + outside, dim)

    def cost(u: Array) -> Array:
        away: Array = (u - at) @ factor.T
        squares: Array = (away**2).sum(axis=1)
        return squares

    return cost, factor, at


def single(cost: Cost) -> Callable[[Array], float]:
    """The cost of one point, as scipy calls it."""
    return lambda u: float(cost(u[None])[0])


# --- how low, and how quick


@pytest.mark.parametrize("dim", [2, 5, 10])
@pytest.mark.parametrize("seed", range(5))
def test_it_sees_a_valley_a_thousand_times_as_long_as_wide(dim: int, seed: int) -> None:
    """Condition 1e6, costs from 1e4 to 1e6 at the start: forward differences, and yet to 1e-7."""
    cost, *_ = bowl(dim, seed, 1e6)
    state, batches = descend(cost, [0.5] * dim)
    assert state.cost < 1e-7
    assert rows(batches) < 15 * dim**2 + 50 * dim


def test_it_ends_lower_than_scipy_does_by_the_same_slopes() -> None:
    """BFGS by scipy, its own forward differences, on the same bowls: stuck a decade higher."""
    ratios = []
    for seed in range(10):
        cost, *_ = bowl(5, seed, 1e6)
        theirs = minimize(single(cost), np.full(5, 0.5), method="BFGS")
        ratios.append(descend(cost, [0.5] * 5)[0].cost / theirs.fun)
    assert np.median(ratios) < 0.1


@pytest.mark.parametrize("dim", [1, 2, 5, 10])
def test_a_round_bowl_takes_a_few_steps(dim: int) -> None:
    """One step shows the curvature, the same all around; the next is Newton's."""
    state, batches = descend(lambda u: 1.0 + ((u - 0.4) ** 2).sum(axis=1), [0.45] * dim)
    np.testing.assert_allclose(state.point, 0.4, atol=1e-7)
    trials = [points[0] for points in batches if len(points) == 1]
    assert any(np.abs(point - 0.4).max() < 1e-6 for point in trials[:4])


@pytest.mark.parametrize("lift", [0.0, 1.0, 1e3, -1e3])
@pytest.mark.parametrize("start", [[0.2, 0.75], [0.05, 0.95], [0.9, 0.1, 0.6, 0.4]])
def test_an_offset_leaves_the_last_digits_within_reach(lift: float, start: list[float]) -> None:
    state, batches = descend(lambda u: rosenbrock(u) + lift, start)
    assert state.cost - lift < 1e-8
    assert rows(batches) < 150 * len(start)


@pytest.mark.parametrize("scale", [2.0**-400, 2.0**-60, 2.0**60, 2.0**400])
def test_the_unit_of_the_cost_does_not_matter(scale: float) -> None:
    _, plain = descend(rosenbrock, [0.2, 0.75])
    state, scaled = descend(lambda u: scale * rosenbrock(u), [0.2, 0.75])
    assert state.cost < 1e-8 * scale
    assert all(np.array_equal(a, b) for a, b in zip(plain, scaled, strict=True))


# --- walls


@pytest.mark.parametrize("dim", [1, 2, 5, 10])
@pytest.mark.parametrize("seed", range(5))
def test_a_minimum_on_walls_is_on_them_exactly(dim: int, seed: int) -> None:
    """Coordinate by coordinate: free minima outside the cube end on its wall, others do not."""
    rng = np.random.default_rng(seed)
    at, steep = rng.uniform(-0.5, 1.5, dim), 10.0 ** rng.uniform(0, 2, dim)
    state, _ = descend(lambda u: ((u - at) ** 2) @ steep, rng.random(dim))
    expected = np.clip(at, 0.0, 1.0)
    clipped = expected != at
    assert np.array_equal(state.point[clipped], expected[clipped])
    np.testing.assert_allclose(state.point, expected, atol=3e-6)


@pytest.mark.parametrize("dim", [2, 5, 10])
@pytest.mark.parametrize("seed", range(5))
def test_a_rotated_bowl_cut_by_walls_ends_where_scipy_says(dim: int, seed: int) -> None:
    cost, factor, at = bowl(dim, seed, 1e3, outside=0.7)
    state, _ = descend(cost, [0.5] * dim)
    exact = lsq_linear(factor, factor @ at, bounds=(0.0, 1.0), tol=1e-14)
    walls = exact.active_mask != 0
    assert np.array_equal(state.point[walls], np.round(exact.x[walls]))
    np.testing.assert_allclose(state.cost, 2.0 * exact.cost, rtol=1e-9, atol=1e-10)


def test_it_starts_and_ends_in_a_corner() -> None:
    state, batches = descend(lambda u: u.sum(axis=1), [1.0] * 4)
    assert (state.point == 0.0).all()
    assert state.ended == "flat"
    assert rows(batches) < 60


def test_a_start_at_the_least_corner_ends_by_its_slopes() -> None:
    state, batches = descend(lambda u: u.sum(axis=1), [0.0] * 4)
    assert state.ended == "flat"
    assert [len(points) for points in batches] == [4]


# --- costs of nan, costs without slope


@pytest.mark.parametrize("level", [0.0, 1.0, -1e300])
def test_a_plateau_ends_at_once(level: float) -> None:
    state, batches = descend(lambda u: np.full(len(u), level), [0.3, 0.5])
    assert state.ended == "flat"
    assert [len(points) for points in batches] == [2]


def test_a_step_into_what_cannot_run_is_shortened() -> None:
    """Rosenbrock with a hole that covers the straight way down."""

    def holed(u: Array) -> Array:
        cost = rosenbrock(u)
        cost[np.abs(u[:, 0] - 0.45) + np.abs(u[:, 1] - 0.75) < 0.1] = np.nan
        return cost

    state, _ = descend(holed, [0.2, 0.75])
    assert np.isfinite(state.cost)
    assert state.cost < 0.5 * float(rosenbrock(np.array([[0.2, 0.75]]))[0])


def test_where_no_neighbour_can_run_it_gives_up_at_once() -> None:
    def alone(u: Array) -> Array:
        return np.where((u == 0.5).all(axis=1), 1.0, np.nan)

    state, batches = descend(alone, [0.5, 0.5])
    assert state.ended == "rough"
    assert state.cost == 1.0
    assert rows(batches) <= 4


def edge(u: Array) -> Array:
    """A cost that is nan beyond u1 = 0.5; along that edge the minimum is at u2 = 0.6."""
    cost: Array = np.where(u[:, 0] > 0.5, np.nan, ((u - 0.6) ** 2).sum(axis=1))
    return cost


def test_slopes_at_the_edge_of_what_runs_come_from_its_other_side() -> None:
    state, batches = descend(edge, [0.3, 0.2])  # 0.25 there; with one side alone it stays at 0.028
    assert state.point[0] == pytest.approx(0.5, abs=1e-3)
    assert state.cost < 0.02
    assert rows(batches) < 300


@pytest.mark.parametrize("power", [1.0, 0.5])
def test_a_crease_ends_it_close_by(power: float) -> None:
    state, batches = descend(lambda u: (np.abs(u - 0.4) ** power).sum(axis=1), [0.9, 0.2])
    assert state.cost < 1e-3
    assert rows(batches) < 300


def test_it_only_ever_goes_down() -> None:
    rng = np.random.default_rng(0)

    def noisy(u: Array) -> Array:
        cost: Array = ((u - 0.4) ** 2).sum(axis=1) + 0.1 * rng.random(len(u))
        return cost

    for _ in range(20):
        start = BfgsState(rng.random(3), 2.0)
        state, batches = descend(noisy, start)
        assert state.cost <= 2.0
        assert rows(batches) < 500


# --- interrupted, resumed, abandoned


def test_what_is_left_when_it_is_slow_goes_on_as_if_it_had_never_been() -> None:
    """A steep descent, then a long valley: interrupted there, resumed with a smaller `worth`."""
    whole, at_once = descend(rosenbrock, [0.2, 0.75])
    part, batches = descend(rosenbrock, [0.2, 0.75], worth=1.0)
    assert part.ended == "slow"
    assert part.cost > 1e-3
    while part.ended == "slow":
        part, further = descend(rosenbrock, part._replace(worth=0.1 * part.worth))
        assert further
        batches += further
    assert all(np.array_equal(a, b) for a, b in zip(at_once, batches, strict=True))
    assert np.array_equal(part.point, whole.point)
    assert (part.cost, part.ended) == (whole.cost, whole.ended)


def test_a_basin_that_cannot_be_the_best_is_abandoned() -> None:
    cost, *_ = bowl(4, 2, 1e4)
    lifted, least = (lambda u: 1.0 + cost(u)), 0.5
    whole, at_once = descend(lifted, [0.5] * 4)
    state, batches = descend(lifted, [0.5] * 4, best=least)
    assert state.ended == "poor"
    assert rows(batches) < 0.8 * rows(at_once)
    assert state.cost >= whole.cost
