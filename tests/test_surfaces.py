"""The paper's five test surfaces, its settings for them, and that BTS solves them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stribeck.bench.surfaces import SURFACES, Surface
from stribeck.optimize import METHODS, Search, Target, configure, lockstep

NAMES = list(SURFACES)


def at(name: str, *point: float) -> float:
    return float(SURFACES[name](np.array([point]))[0])


@pytest.mark.parametrize(
    ("name", "point", "value"),
    [
        ("BF", (0.0, 0.0), 0.0),
        ("BF", (1.0, 1.0), 1 + 2 + 0.3 - 0.4 + 0.7),
        ("BF", (0.5, 0.25), 0.25 + 0.125 - 0.0 + 0.4 + 0.7),
        ("BF", (2.0, -2.0), 4 + 8 - 0.3 - 0.4 + 0.7),
        ("RF", (0.0, 0.0), 0.0),
        ("RF", (1.0, -1.0), 2.0),
        ("RF", (0.5, 0.5), 0.5 + 40.0),
        ("RF", (0.25, 0.0), 0.0625 + 10.0),
        ("SchF", (0.0, 0.0), 837.9658),
        ("SchF", (math.pi**2 / 4, 0.0), 837.9658 - math.pi**2 / 4),
        ("SchF", (-(math.pi**2) / 4, 0.0), 837.9658 + math.pi**2 / 4),
        ("ShuF", (0.0, 0.0), sum(i * math.cos(i) for i in range(1, 6)) ** 2),
    ],
)
def test_values_worked_out_by_hand(name: str, point: tuple[float, float], value: float) -> None:
    assert math.isclose(at(name, *point), value, abs_tol=1e-12)


@pytest.mark.parametrize("j", range(1, 26))
def test_each_foxhole_is_as_deep_as_its_number(j: int) -> None:
    # At hole j its own term is 1/j; the other 24, at least 16 away, add 24/16^6 at most.
    hole = (-32.0 + 16 * ((j - 1) % 5), -32.0 + 16 * ((j - 1) // 5))
    terms = 1 / at("SF", *hole) - 1 / 500
    assert 1 / j < terms < 1 / j + 24 / 16**6


def test_foxholes_far_from_every_hole_is_its_ceiling() -> None:
    assert 490 < at("SF", 40.0, -8.0) < 500


@pytest.mark.parametrize("name", NAMES)
def test_each_optimum_takes_the_least_value_and_meets_j_min(name: str) -> None:
    surface = SURFACES[name]
    costs = surface(np.array(surface.optima))
    assert np.allclose(costs, surface.minimum, rtol=1e-12, atol=1e-12)
    assert np.all(costs <= surface.J_min)
    assert surface.minimum < surface.J_min or surface.minimum == 0.0


@pytest.mark.parametrize("name", NAMES)
def test_no_place_is_lower_than_the_minimum(name: str) -> None:
    surface = SURFACES[name]
    rng = np.random.default_rng(12)
    wide = surface.space.decode(rng.random((200_000, 2)))
    near = np.repeat(np.array(surface.optima), 2000, axis=0)
    near = near + 1e-3 * rng.standard_normal(near.shape)
    assert surface(wide).min() >= surface.minimum - 1e-12
    assert surface(near).min() >= surface.minimum - 1e-12 * abs(surface.minimum)


def test_published_minima() -> None:
    # Table 1: "18 different locations" of -186.7309; Table 5, ABFO, SchF: 2.5455e-05; SF 0.9980.
    shubert = SURFACES["ShuF"]
    assert len(set(shubert.optima)) == 18
    assert round(shubert.minimum, 4) == -186.7309
    assert all(abs(c) <= 10 for optimum in shubert.optima for c in optimum)
    assert f"{SURFACES['SchF'].minimum:.4e}" == "2.5455e-05"
    assert round(SURFACES["SF"].minimum, 4) == 0.9980


@pytest.mark.parametrize("name", ["RF", "SchF", "ShuF"])
@given(x=st.floats(-1, 1), y=st.floats(-1, 1))
def test_both_coordinates_count_alike(name: str, x: float, y: float) -> None:
    half = SURFACES[name].half
    assert math.isclose(at(name, x * half, y * half), at(name, y * half, x * half), abs_tol=1e-9)


@pytest.mark.parametrize("name", ["BF", "RF"])
@given(x=st.floats(-1, 1), y=st.floats(-1, 1))
def test_even_surfaces_are_even(name: str, x: float, y: float) -> None:
    half = SURFACES[name].half
    assert math.isclose(at(name, x * half, y * half), at(name, -x * half, y * half), abs_tol=1e-9)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("n", [1, 2, 3, 8, 31, 100])
def test_rows_are_independent_bit_for_bit(name: str, n: int) -> None:
    surface = SURFACES[name]
    x = surface.space.decode(np.random.default_rng(n).random((n, 2)))
    alone = np.concatenate([surface(row[None]) for row in x])
    assert np.array_equal(surface(x), alone)
    assert np.array_equal(surface(x[::-1]), alone[::-1])


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("method", ["ats", "abfo", "bts"])
def test_settings_are_those_of_a_method(name: str, method: str) -> None:
    algorithm = configure(method, **SURFACES[name].settings[method])
    assert isinstance(algorithm, METHODS[method])


def test_settings_as_printed() -> None:
    # Table 2, SchF; Table 3, SF; section 3: "adapted for the BTS with N_c = 20".
    ats = SURFACES["SchF"].settings["ats"]
    assert (ats["N"], ats["R"], ats["count_max"]) == (30, 50.0, 10_000)
    assert ats["AR"] == ((100.0, 25.0), (10.0, 10.0), (1.0, 1.0))
    abfo = SURFACES["SF"].settings["abfo"]
    assert (abfo["N_c"], abfo["alpha"], abfo["w_repellant"]) == (500, 0.01, 10.0)
    assert all(s.settings["bts"]["N_c"] == 20 for s in SURFACES.values())


def test_printed_lengths_are_lengths_on_the_surface() -> None:
    # R = 50 on SchF is 50 in x, 5 % of the box: a neighbourhood spans at most 100.
    surface = SURFACES["SchF"]
    search = Search(surface.space, configure("ats", **surface.settings["ats"]), budget=31, seed=0)
    start = search.ask()
    search.tell(surface(start))
    reach = np.abs(search.ask() - start)
    assert reach.max() <= 50.0 + 1e-9
    assert reach.max() > 40.0  # 60 uniform draws all below 0.8: one in 10^6


def trials(surface: Surface, method: str, n: int, budget: int, **settings: object) -> list[str]:
    algorithm = configure(method, **surface.settings[method], **settings)
    stops = [Target(surface.J_min)]
    searches = [
        Search(surface.space, algorithm, budget=budget, seed=seed, stops=stops) for seed in range(n)
    ]
    return [run.ended for run in lockstep(surface, searches)]


@pytest.mark.parametrize("name", NAMES)
def test_bts_with_restart_reaches_j_min_in_50_of_50_trials(name: str) -> None:
    # The paper's claim for BTS (section 3). Literal backtracking does not get there: see
    # tools/surfaces_study.py.
    ended = trials(SURFACES[name], "bts", 50, 300_000, deadlock="restart")
    assert ended == ["target"] * 50


@pytest.mark.parametrize("name", ["SF", "SchF"])
def test_literal_ats_stays_in_its_first_basin(name: str) -> None:
    # Basins lie further apart than R, a move needs J1 < J0: most trials end where they began.
    ended = trials(SURFACES[name], "ats", 20, 15_000)
    assert ended.count("target") <= 5
