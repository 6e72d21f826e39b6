"""Least squares by residuals: known optima, walls, holes, numbers of evaluations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from stribeck.optimize import Answer, rms
from stribeck.optimize.box import Box, box_minimum
from stribeck.optimize.moves import Detailed
from stribeck.optimize.trust_region import Minimum, least_squares
from stribeck.space import Array, box

Residuals = Callable[[Array], Array]  # (n, dim) of the unit cube to (n, m)


def descend(
    residuals: Residuals, start: list[float], **options: Any
) -> tuple[Minimum, list[Array]]:
    """The minimum, and every batch evaluated."""
    moves = least_squares(np.array(start), Box(box([(0.0, 1.0)] * len(start))), **options)
    batches: list[Array] = []
    try:
        request = next(moves)
        while True:
            assert isinstance(request, Detailed)
            assert request.points.min() >= 0.0
            assert request.points.max() <= 1.0
            batches.append(request.points.copy())
            shown = residuals(request.points)
            costs = rms(shown)
            request = moves.send(Answer(np.where(np.isfinite(costs), costs, np.inf), shown))
    except StopIteration as done:
        return done.value, batches


def rosenbrock(u: Array) -> Array:
    """Residuals of Rosenbrock's function over [-2, 2]^2; the minimum is 0 at (1, 1)."""
    x, y = (4.0 * u - 2.0).T
    return np.stack([10.0 * (y - x**2), 1.0 - x], axis=1)


# NIST StRD, Misra1a (Misra 1978, doi 10.18434/T43G6C): volume against pressure.
PRESSURE, VOLUME = np.array(
    [
        (77.6, 10.07), (114.9, 14.73), (141.1, 17.94), (190.8, 23.93), (239.9, 29.61),
        (289.0, 35.18), (332.8, 40.02), (378.4, 44.82), (434.8, 50.76), (477.3, 55.05),
        (536.8, 61.01), (593.1, 66.40), (689.1, 75.47), (760.0, 81.78),
    ]
).T  # fmt: skip
MISRA = np.array([1000.0, 2e-3])  # the upper ends; the lower are 0


def misra1a(u: Array) -> Array:
    b1, b2 = (MISRA * u).T[:, :, None]
    misfit: Array = VOLUME - b1 * (1.0 - np.exp(-b2 * PRESSURE))
    return misfit


def test_rosenbrock_from_the_classical_start() -> None:
    minimum, _ = descend(rosenbrock, [0.2, 0.75], tolerance=1e-12)  # (-1.2, 1)
    np.testing.assert_allclose(minimum.point, 0.75, atol=1e-9)
    assert minimum.cost < 1e-9


@pytest.mark.parametrize("start", [[0.5, 0.05], [0.25, 0.25], [1.0, 1.0], [0.9, 0.1]])
def test_misra1a_ends_at_the_certified_values(start: list[float]) -> None:
    minimum, _ = descend(misra1a, start, tolerance=1e-13)
    certified = np.array([2.3894212918e02, 5.5015643181e-04])
    np.testing.assert_allclose(MISRA * minimum.point, certified, rtol=1e-7)
    np.testing.assert_allclose(14 * minimum.cost**2, 1.2455138894e-01, rtol=1e-10)


def test_a_minimum_on_a_wall_is_reached_exactly() -> None:
    """Rosenbrock's valley cut by x <= 0.5: there y = x^2 = 0.25 and the second residual is 0.5."""

    def cut(u: Array) -> Array:
        return rosenbrock(np.stack([0.625 * u[:, 0], u[:, 1]], axis=1))

    minimum, _ = descend(cut, [0.3, 0.8], tolerance=1e-12)
    assert minimum.point[0] == 1.0
    np.testing.assert_allclose(minimum.point[1], (0.25 + 2.0) / 4.0, atol=1e-9)
    np.testing.assert_allclose(minimum.cost, 0.5 / np.sqrt(2), rtol=1e-9)


def test_it_starts_and_ends_in_a_corner() -> None:
    minimum, batches = descend(lambda u: u + 1.0, [1.0, 1.0, 1.0])
    assert (minimum.point == 0.0).all()
    assert minimum.ended == "flat"
    assert len(batches) < 12


def test_what_cannot_run_is_stepped_round() -> None:
    """Rosenbrock with a hole that covers the straight way; neighbours inside it cost no descent."""

    def holed(u: Array) -> Array:
        r = rosenbrock(u)
        r[np.abs(u[:, 0] - 0.5) + np.abs(u[:, 1] - 0.8) < 0.2] = np.nan
        return r

    minimum, _ = descend(holed, [0.2, 0.75], tolerance=1e-12)
    np.testing.assert_allclose(minimum.point, 0.75, atol=1e-7)


def test_slopes_at_the_edge_of_what_runs_come_from_its_other_side() -> None:
    def edge(u: Array) -> Array:
        return np.where(u > 0.5, np.nan, u - 0.2)

    minimum, _ = descend(edge, [0.5, 0.5])
    np.testing.assert_allclose(minimum.point, 0.2, atol=1e-9)


def test_a_start_that_cannot_run_ends_at_once() -> None:
    minimum, batches = descend(lambda u: np.full_like(u, np.nan), [0.5, 0.5])
    assert minimum.ended == "nowhere"
    assert np.isinf(minimum.cost)
    assert len(batches) == 1


@pytest.mark.parametrize("moves", [[0.0, 0.0], [0.0, 1.0]])
def test_a_parameter_that_changes_nothing_stays(moves: list[float]) -> None:
    minimum, _ = descend(lambda u: (u - 0.3) * moves + 0.1, [0.6, 0.6])
    assert minimum.point[0] == 0.6
    assert minimum.ended == "flat"


def test_without_residuals_it_says_so() -> None:
    moves = least_squares(np.array([0.5]), Box(box([(0.0, 1.0)])))
    next(moves)
    with pytest.raises(StopIteration) as stopped:
        moves.send(Answer(np.array([1.0]), None))
    assert stopped.value.value.ended == "no residuals"


@pytest.mark.parametrize("power", [-200, -1, 200])
def test_the_unit_of_the_residuals_is_nothing_to_it(power: int) -> None:
    plain, plain_batches = descend(rosenbrock, [0.2, 0.75])
    scaled, scaled_batches = descend(lambda u: rosenbrock(u) * 2.0**power, [0.2, 0.75])
    np.testing.assert_array_equal(np.vstack(scaled_batches), np.vstack(plain_batches))
    assert scaled.cost == plain.cost * 2.0**power


@pytest.mark.parametrize("dim", [2, 5, 10])
def test_linear_residuals_take_one_step(dim: int) -> None:
    """Start, its neighbours, all at once, the step; fresh slopes there promise no more."""
    rng = np.random.default_rng(dim)
    slopes, optimum = rng.standard_normal((3 * dim, dim)), 0.4 + 0.2 * rng.random(dim)
    misfit = rng.standard_normal(3 * dim)
    misfit -= slopes @ np.linalg.lstsq(slopes, misfit, rcond=None)[0]
    minimum, batches = descend(lambda u: (u - optimum) @ slopes.T + misfit, [0.5] * dim)
    np.testing.assert_allclose(minimum.point, optimum, atol=1e-7)
    assert [len(points) for points in batches] == [1, dim, 1, 1, dim, 1]


def test_corrected_slopes_spare_evaluations() -> None:
    """A chained Rosenbrock in ten dimensions: far fewer than dim + 1 evaluations a step."""

    def chained(u: Array) -> Array:
        x = 4.0 * u - 2.0
        return np.hstack([3.0 * (x[:, 1:] - x[:, :-1] ** 2), 1.0 - x])

    minimum, batches = descend(chained, [0.6] * 10, tolerance=1e-10)
    assert minimum.cost < 1e-6
    steps = sum(len(points) == 1 for points in batches) - 1
    assert sum(map(len, batches)) < 4 * steps


def test_slopes_are_not_taken_twice_at_a_point() -> None:
    """Where no step is any good the trust region shrinks, and the slopes are known."""

    def pit(u: Array) -> Array:  # its slopes point over the edge, wherever one stands in it
        return np.where(np.abs(u - 0.5).max(axis=1, keepdims=True) < 1e-6, u + 1.0, 5.0)

    _, batches = descend(pit, [0.5, 0.5])
    assert sum(len(points) == 2 for points in batches) == 1


def test_a_curvature_lost_in_rounding_has_no_step() -> None:
    tiny = np.diag([1e-313, 0.0])  # nothing of it is left to keep the second direction apart
    with pytest.raises(np.linalg.LinAlgError):
        box_minimum(tiny, np.ones(2), np.full(2, -1.0), np.ones(2))


@pytest.mark.parametrize("seed", range(40))
def test_the_box_minimum_is_that_of_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    dim = int(rng.integers(1, 8))
    J = rng.standard_normal((dim + 2, dim)) * 10.0 ** rng.uniform(-2, 2, dim)
    r = 10.0 * rng.standard_normal(dim + 2)
    lower, upper = -rng.random(dim), rng.random(dim)
    lower[rng.random(dim) < 0.2] = 0.0  # it stands on the wall already
    s, gain = box_minimum(J.T @ J, J.T @ r, lower, upper)
    best = lsq_linear(J, -r, bounds=(lower - 1e-300, upper), method="bvls", tol=1e-14)
    assert ((lower <= s) & (s <= upper)).all()
    np.testing.assert_allclose(
        gain, float(r @ r) - 2 * best.cost, rtol=1e-7, atol=1e-9 * float(r @ r)
    )
