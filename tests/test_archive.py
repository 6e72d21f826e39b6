"""The archive of `mbts`: cells that fill the cube, isolated starts, surrogate minima."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import qmc

from stribeck.bench.surfaces import rotation
from stribeck.optimize.archive import CELLS, MINIMA, SAME, STARTS, Archive
from stribeck.space import Array


def archive(dim: int, seed: int = 0) -> Archive:
    return Archive(dim, np.random.default_rng(seed))


def line(places: list[float], costs: list[float], drawn: int) -> Archive:
    """An archive on the unit interval with these cells, after `drawn` places."""
    visited = archive(1)
    visited.sample(drawn)
    visited.keep(np.array(places)[:, None], np.array(costs))
    return visited


def radius(share: float, drawn: int, dim: int) -> float:
    """Multi-level single linkage: a ball that holds about log(n) of n places, up to a constant."""
    return float(share * (np.log(drawn + 1) / drawn) ** (1 / dim))


def next_start(visited: Archive, share: float) -> tuple[float, float] | None:
    """The next start on the unit interval, and its cost."""
    start = visited.start(share)
    return None if start is None else (float(start[0][0]), start[1])


# --- cells


@pytest.mark.parametrize("dim", [1, 2, 3, 5, 10])
def test_cells_fill_the_cube_evenly_whatever_their_number(dim: int) -> None:
    """The wrap-around discrepancy, which no shift changes, against its mean over random places.

    For n independent uniform places the mean of its square is ((3/2)^dim - (4/3)^dim) / n, from
    Hickernell (1998, doi 10.1007/978-1-4612-1702-2_3): a pair adds (4/3)^dim on average.
    """
    cells = archive(dim).sample(400)
    for n in range(4 * dim, 401, 3):
        of_random = ((3 / 2) ** dim - (4 / 3) ** dim) / n
        assert qmc.discrepancy(cells[:n], method="WD") < 0.7 * of_random
    assert qmc.discrepancy(cells, method="WD") < (0.1 if dim < 4 else 0.5) * of_random


def test_more_cells_are_the_next_ones() -> None:
    at_once, in_parts = archive(3), archive(3)
    parts = [in_parts.sample(n) for n in (7, 1, 4)]
    assert np.array_equal(np.vstack(parts), at_once.sample(12))


def test_another_seed_shifts_the_cells_round_the_cube() -> None:
    first, second = (archive(2, seed).sample(50) for seed in (1, 2))
    shift = (second - first) % 1.0
    np.testing.assert_allclose(shift, np.broadcast_to(shift[0], shift.shape), atol=1e-12)
    assert shift[0].min() > 1e-3


def test_the_best_cells_are_kept_and_taken_in_order() -> None:
    visited, rng = archive(2), np.random.default_rng(3)
    brought = []
    for n in (30, 1, 500, 20):
        costs = rng.standard_normal(n)
        visited.keep(visited.sample(n), costs)
        brought.append(costs)
    costs_taken = []
    while start := visited.start(1e-9):
        costs_taken.append(start[1])
    assert np.array_equal(costs_taken, np.sort(np.concatenate(brought))[:CELLS])


def test_cells_that_cannot_run_are_no_starts() -> None:
    visited = line([0.1, 0.5, 0.9], [np.inf, 2.0, np.inf], drawn=3)
    assert next_start(visited, 0.01) == (0.5, 2.0)
    assert visited.start(0.01) is None


# --- starts


def test_a_start_stands_alone() -> None:
    """By hand: four places drawn, and a radius of 0.25 log(5) / 4 = 0.1006."""
    places, costs = [0.10, 0.15, 0.50, 0.90], [3.0, 1.0, 2.0, 4.0]
    visited = line(places, costs, drawn=4)
    starts = []
    while start := visited.start(0.25):
        visited.begin(start[0])
        starts.append(float(start[0][0]))
    assert starts == [0.15, 0.50, 0.90]  # 0.10 is in the shadow of 0.15

    visited.sample(100)  # now it is 0.25 log(105) / 104 = 0.0112
    assert next_start(visited, 0.25) == (0.10, 3.0)


@pytest.mark.parametrize(("floor", "expected"), [(1.5, 0.8), (2.5, 0.5)])
def test_only_a_better_floor_shields(floor: float, expected: float) -> None:
    visited = line([0.5, 0.8], [2.0, 3.0], drawn=4)
    visited.end(np.array([0.52]), floor)
    start = visited.start(0.25)
    assert start is not None
    assert start[0] == expected


def test_a_start_shields_whatever_its_cell_cost() -> None:
    visited = line([0.5, 0.8], [-9.0, 3.0], drawn=4)
    visited.begin(np.array([0.45]))
    assert next_start(visited, 0.25) == (0.8, 3.0)


def test_a_start_is_forgotten_after_many_others() -> None:
    visited = line([0.5], [1.0], drawn=4)
    visited.begin(np.array([0.5]))
    for _ in range(STARTS - 1):
        visited.begin(np.array([0.9]))
    assert visited.start(0.25) is None
    visited.begin(np.array([0.9]))
    assert next_start(visited, 0.25) == (0.5, 1.0)


@pytest.mark.parametrize("seed", range(20))
def test_no_better_cell_would_have_stood_alone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    dim = int(rng.integers(1, 5))
    visited = archive(dim, seed)
    cells, costs = visited.sample(60)[: 10 * dim], rng.standard_normal(10 * dim)
    visited.keep(cells, costs)
    minima, their = rng.random((5, dim)), rng.standard_normal(5)
    for floor, cost in zip(minima, their, strict=True):
        visited.end(floor, cost)
    starts = rng.random((3, dim))
    for u in starts:
        visited.begin(u)
    reach = radius(0.4, 60, dim)

    def shielded(u: Array, cost: float) -> bool:
        close = [c for p, c in zip([*cells, *minima], [*costs, *their], strict=True)
                 if np.linalg.norm(p - u) < reach]  # fmt: skip
        return min(close) < cost or any(np.linalg.norm(u - b) < reach for b in starts)

    alone = [cost for u, cost in zip(cells, costs, strict=True) if not shielded(u, cost)]
    start = visited.start(0.4)
    if start is None:
        assert not alone
    else:
        assert start[1] == min(alone)
        assert np.array_equal(start[0], cells[costs == start[1]][0])


# --- what is worth having


def test_better_is_what_gains_a_millionth_of_what_there_was_to_gain() -> None:
    visited = line([0.1, 0.5, 0.9], [0.0, 10.0, 1000.0], drawn=3)
    assert visited.update(0.0)
    assert visited.worth == 10.0
    assert not visited.update(0.0)
    assert not visited.update(-0.9e-5)
    assert visited.best == -0.9e-5
    assert visited.update(-2.1e-5)
    assert not visited.update(np.inf)


def test_what_cannot_run_is_not_better() -> None:
    visited = archive(2)
    assert not visited.update(np.inf)
    assert visited.worth == 0.0
    assert visited.update(1e300)


# --- minima


def test_minima_close_together_are_one_and_the_better_one_stays() -> None:
    visited, offset = archive(2), np.array([0.9 * SAME, -0.9 * SAME])
    first, second = np.array([0.3, 0.7]), np.array([0.3, 0.7 + 1.1 * SAME])
    visited.end(first, 2.0)
    visited.end(first + offset, 3.0)
    assert np.array_equal(visited.minima, [first])
    assert np.array_equal(visited.costs, [2.0])
    visited.end(first + offset, 1.0)
    assert np.array_equal(visited.minima, [first + offset])
    visited.end(second, 1.0)
    assert np.array_equal(visited.minima, [first + offset, second])
    assert np.array_equal(visited.costs, [1.0, 1.0])


def test_minima_stay_bounded_and_the_best_stay_longest() -> None:
    visited, rng = archive(3), np.random.default_rng(0)
    ended: list[float] = []
    for _ in range(3 * MINIMA):
        ended.append(float(rng.standard_normal()))
        visited.end(rng.random(3), ended[-1])
        assert len(visited.minima) == len(visited.costs) <= MINIMA
        assert visited.costs.min() == min(ended)
    best = np.sort(ended)[: MINIMA // 4]
    assert np.isin(best, visited.costs).all()


# --- where they lead


def bowl(dim: int, floor: Array, seed: int, *, turned: bool = True) -> Archive:
    """Floors that lie on a quadratic of condition 100, none near its least at `floor`."""
    rng = np.random.default_rng(seed)
    turn = rotation(rng, dim) if turned else np.eye(dim)
    visited = archive(dim, seed)
    minima = rng.random((20 * dim * (dim + 1), dim))
    minima = minima[np.linalg.norm(minima - floor, axis=1) > (0.2 if dim < 5 else 0.4)]
    for u in minima[: 3 + dim + dim * (dim + 1)]:
        away = turn @ (u - floor) * 10.0 ** np.linspace(0, 1, dim)
        visited.end(u, 7.0 + float(away @ away))
    return visited


@pytest.mark.parametrize("dim", [1, 2, 3, 5, 8])
@pytest.mark.parametrize("seed", range(3))
def test_minima_on_a_bowl_lead_to_its_least(dim: int, seed: int) -> None:
    floor = 0.3 + 0.4 * np.random.default_rng(seed).random(dim)
    place = bowl(dim, floor, seed).surrogate_minimum()
    assert place is not None
    np.testing.assert_allclose(place, floor, atol=1e-9)


def test_minima_on_an_upright_bowl_lead_to_the_wall_before_its_least() -> None:
    visited = bowl(3, np.array([0.4, 0.6, 1.3]), 1, turned=False)
    place = visited.surrogate_minimum()
    assert place is not None
    np.testing.assert_allclose(place, [0.4, 0.6, 1.0], atol=1e-9)


def test_few_minima_lead_along_the_axes_or_down_a_slope() -> None:
    """In five dimensions: eleven are enough for an upright bowl, seven for a plane, six not."""
    rng = np.random.default_rng(4)
    minima, least = rng.random((11, 5)), np.array([0.3, 0.7, 0.5, 0.4, 0.6])
    upright = archive(5)
    for u in minima:
        upright.end(u, float(((u - least) ** 2) @ [1.0, 2.0, 3.0, 4.0, 5.0]))
    place = upright.surrogate_minimum()
    assert place is not None
    np.testing.assert_allclose(place, least, atol=1e-9)

    plane = archive(5)
    slope = np.array([1.0, -2.0, 3.0, -4.0, 5.0])
    for u in minima[:6]:
        plane.end(u, float(slope @ u))
    assert plane.surrogate_minimum() is None
    plane.end(minima[6], float(slope @ minima[6]))
    place = plane.surrogate_minimum()
    assert place is not None
    assert slope @ place < plane.costs.min()


@pytest.mark.parametrize("seed", range(10))
def test_they_never_lead_to_a_place_already_known(seed: int) -> None:
    """After starts at earlier places, the next keeps a share of the minima' distance."""
    visited = bowl(2, np.array([0.5, 0.5]), seed)
    distances = np.linalg.norm(visited.minima[:, None] - visited.minima, axis=2)
    np.fill_diagonal(distances, np.inf)
    least = 0.2 * np.median(distances.min(axis=1))
    places: list[Array] = []
    while len(places) < 20 and (place := visited.surrogate_minimum()) is not None:
        nearest = np.linalg.norm(np.vstack([visited.minima, *places]) - place, axis=1).min()
        assert nearest >= least
        assert ((place >= 0.0) & (place <= 1.0)).all()
        visited.begin(place)
        places.append(place)
    assert places


@pytest.mark.parametrize("scale", [2.0**-300, 2.0**-20, 2.0**300])
def test_where_they_lead_does_not_hang_on_the_unit_of_the_cost(scale: float) -> None:
    plain, scaled = bowl(3, np.full(3, 0.5), 2), bowl(3, np.full(3, 0.5), 2)
    scaled.costs = scaled.costs * scale
    a, b = plain.surrogate_minimum(), scaled.surrogate_minimum()
    assert a is not None
    assert b is not None
    np.testing.assert_allclose(a, b, atol=1e-9)


def test_the_thinnest_place_is_on_the_side_where_nothing_is_known() -> None:
    """Of 20 random places all fall on the known half once in a million seeds."""
    for seed in range(20):
        visited = archive(2, seed)
        for u in qmc.Halton(2, seed=0).random(60):
            visited.end(u * [0.5, 1.0], 0.0) if seed % 2 else visited.begin(u * [0.5, 1.0])
        assert visited.thinnest()[0] > 0.5
