"""The archive of `mbts`: cells that fill the cube, starts that stand alone, where minima lead."""

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
    """Cells on the unit interval, as if they were all that `drawn` places had brought."""
    known = archive(1)
    known.sample(drawn)
    known.keep(np.array(places)[:, None], np.array(costs))
    return known


def radius(share: float, drawn: int, dim: int) -> float:
    """Multi-level single linkage: a ball that holds about log(n) of n places, up to a constant."""
    return float(share * (np.log(drawn + 1) / drawn) ** (1 / dim))


def taken(known: Archive, share: float) -> tuple[float, float] | None:
    """The next start on the unit interval, and its cost."""
    start = known.start(share)
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
    here, there = (archive(2, seed).sample(50) for seed in (1, 2))
    shift = (there - here) % 1.0
    np.testing.assert_allclose(shift, np.broadcast_to(shift[0], shift.shape), atol=1e-12)
    assert shift[0].min() > 1e-3


def test_the_best_cells_are_kept_and_taken_in_order() -> None:
    known, rng = archive(2), np.random.default_rng(3)
    brought = []
    for n in (30, 1, 500, 20):
        costs = rng.standard_normal(n)
        known.keep(known.sample(n), costs)
        brought.append(costs)
    begun = []
    while start := known.start(1e-9):
        begun.append(start[1])
    assert np.array_equal(begun, np.sort(np.concatenate(brought))[:CELLS])


def test_cells_that_cannot_run_are_no_starts() -> None:
    known = line([0.1, 0.5, 0.9], [np.inf, 2.0, np.inf], drawn=3)
    assert taken(known, 0.01) == (0.5, 2.0)
    assert known.start(0.01) is None


# --- starts


def test_a_start_stands_alone() -> None:
    """By hand: four places drawn, and a radius of 0.25 log(5) / 4 = 0.1006."""
    places, costs = [0.10, 0.15, 0.50, 0.90], [3.0, 1.0, 2.0, 4.0]
    known = line(places, costs, drawn=4)
    found = []
    while start := known.start(0.25):
        known.begin(start[0])
        found.append(float(start[0][0]))
    assert found == [0.15, 0.50, 0.90]  # 0.10 is in the shadow of 0.15

    known.sample(100)  # now it is 0.25 log(105) / 104 = 0.0112
    assert taken(known, 0.25) == (0.10, 3.0)


@pytest.mark.parametrize(("floor", "found"), [(1.5, 0.8), (2.5, 0.5)])
def test_only_a_better_floor_shields(floor: float, found: float) -> None:
    known = line([0.5, 0.8], [2.0, 3.0], drawn=4)
    known.end(np.array([0.52]), floor)
    start = known.start(0.25)
    assert start is not None
    assert start[0] == found


def test_a_start_shields_whatever_its_cell_cost() -> None:
    known = line([0.5, 0.8], [-9.0, 3.0], drawn=4)
    known.begin(np.array([0.45]))
    assert taken(known, 0.25) == (0.8, 3.0)


def test_a_start_is_forgotten_after_many_others() -> None:
    known = line([0.5], [1.0], drawn=4)
    known.begin(np.array([0.5]))
    for _ in range(STARTS - 1):
        known.begin(np.array([0.9]))
    assert known.start(0.25) is None
    known.begin(np.array([0.9]))
    assert taken(known, 0.25) == (0.5, 1.0)


@pytest.mark.parametrize("seed", range(20))
def test_no_better_cell_would_have_stood_alone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    dim = int(rng.integers(1, 5))
    known = archive(dim, seed)
    cells, costs = known.sample(60)[: 10 * dim], rng.standard_normal(10 * dim)
    known.keep(cells, costs)
    minima, their = rng.random((5, dim)), rng.standard_normal(5)
    for floor, cost in zip(minima, their, strict=True):
        known.end(floor, cost)
    begun = rng.random((3, dim))
    for u in begun:
        known.begin(u)
    reach = radius(0.4, 60, dim)

    def shielded(u: Array, cost: float) -> bool:
        close = [c for p, c in zip([*cells, *minima], [*costs, *their], strict=True)
                 if np.linalg.norm(p - u) < reach]  # fmt: skip
        return min(close) < cost or any(np.linalg.norm(u - b) < reach for b in begun)

    alone = [cost for u, cost in zip(cells, costs, strict=True) if not shielded(u, cost)]
    start = known.start(0.4)
    if start is None:
        assert not alone
    else:
        assert start[1] == min(alone)
        assert np.array_equal(start[0], cells[costs == start[1]][0])


# --- what is worth having


def test_better_is_what_gains_a_millionth_of_what_there_was_to_gain() -> None:
    known = line([0.1, 0.5, 0.9], [0.0, 10.0, 1000.0], drawn=3)
    assert known.update(0.0)
    assert known.worth == 10.0
    assert not known.update(0.0)
    assert not known.update(-0.9e-5)
    assert known.best == -0.9e-5
    assert known.update(-2.1e-5)
    assert not known.update(np.inf)


def test_what_cannot_run_is_not_better() -> None:
    known = archive(2)
    assert not known.update(np.inf)
    assert known.worth == 0.0
    assert known.update(1e300)


# --- minima


def test_minima_close_together_are_one_and_the_better_one_stays() -> None:
    known, beside = archive(2), np.array([0.9 * SAME, -0.9 * SAME])
    here, there = np.array([0.3, 0.7]), np.array([0.3, 0.7 + 1.1 * SAME])
    known.end(here, 2.0)
    known.end(here + beside, 3.0)
    assert np.array_equal(known.minima, [here])
    assert np.array_equal(known.costs, [2.0])
    known.end(here + beside, 1.0)
    assert np.array_equal(known.minima, [here + beside])
    known.end(there, 1.0)
    assert np.array_equal(known.minima, [here + beside, there])
    assert np.array_equal(known.costs, [1.0, 1.0])


def test_minima_stay_bounded_and_the_best_stay_longest() -> None:
    known, rng = archive(3), np.random.default_rng(0)
    ended: list[float] = []
    for _ in range(3 * MINIMA):
        ended.append(float(rng.standard_normal()))
        known.end(rng.random(3), ended[-1])
        assert len(known.minima) == len(known.costs) <= MINIMA
        assert known.costs.min() == min(ended)
    best = np.sort(ended)[: MINIMA // 4]
    assert np.isin(best, known.costs).all()


# --- where they lead


def bowl(dim: int, floor: Array, seed: int, *, turned: bool = True) -> Archive:
    """Floors that lie on a quadratic of condition 100, none near its least at `floor`."""
    rng = np.random.default_rng(seed)
    turn = rotation(rng, dim) if turned else np.eye(dim)
    known = archive(dim, seed)
    minima = rng.random((20 * dim * (dim + 1), dim))
    minima = minima[np.linalg.norm(minima - floor, axis=1) > (0.2 if dim < 5 else 0.4)]
    for u in minima[: 3 + dim + dim * (dim + 1)]:
        away = turn @ (u - floor) * 10.0 ** np.linspace(0, 1, dim)
        known.end(u, 7.0 + float(away @ away))
    return known


@pytest.mark.parametrize("dim", [1, 2, 3, 5, 8])
@pytest.mark.parametrize("seed", range(3))
def test_minima_on_a_bowl_lead_to_its_least(dim: int, seed: int) -> None:
    floor = 0.3 + 0.4 * np.random.default_rng(seed).random(dim)
    place = bowl(dim, floor, seed).surrogate_minimum()
    assert place is not None
    np.testing.assert_allclose(place, floor, atol=1e-9)


def test_minima_on_an_upright_bowl_lead_to_the_wall_before_its_least() -> None:
    known = bowl(3, np.array([0.4, 0.6, 1.3]), 1, turned=False)
    place = known.surrogate_minimum()
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
    """Whatever begins where they led: the next place keeps a share of the minima' distance."""
    known = bowl(2, np.array([0.5, 0.5]), seed)
    own = np.linalg.norm(known.minima[:, None] - known.minima, axis=2)
    np.fill_diagonal(own, np.inf)
    apart = 0.2 * np.median(own.min(axis=1))
    places: list[Array] = []
    while len(places) < 20 and (place := known.surrogate_minimum()) is not None:
        near = np.linalg.norm(np.vstack([known.minima, *places]) - place, axis=1).min()
        assert near >= apart
        assert ((place >= 0.0) & (place <= 1.0)).all()
        known.begin(place)
        places.append(place)
    assert places


@pytest.mark.parametrize("scale", [2.0**-300, 2.0**-20, 2.0**300])
def test_where_they_lead_does_not_hang_on_the_unit_of_the_cost(scale: float) -> None:
    one, other = bowl(3, np.full(3, 0.5), 2), bowl(3, np.full(3, 0.5), 2)
    other.costs = other.costs * scale
    a, b = one.surrogate_minimum(), other.surrogate_minimum()
    assert a is not None
    assert b is not None
    np.testing.assert_allclose(a, b, atol=1e-9)


def test_the_thinnest_place_is_on_the_side_where_nothing_is_known() -> None:
    """Of 20 random places all fall on the known half once in a million seeds."""
    for seed in range(20):
        known = archive(2, seed)
        for u in qmc.Halton(2, seed=0).random(60):
            known.end(u * [0.5, 1.0], 0.0) if seed % 2 else known.begin(u * [0.5, 1.0])
        assert known.thinnest()[0] > 0.5
