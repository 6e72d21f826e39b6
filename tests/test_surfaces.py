"""The paper's five test surfaces in any dimension, and their twins."""

from __future__ import annotations

import math
import subprocess
import sys
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize, minimize_scalar

from stribeck.bench.surfaces import MOST_OPTIMA, SURFACES, Moved, Surface, rotation, surface
from stribeck.errors import InputError
from stribeck.space import Array

NAMES = list(SURFACES)
ANY_DIM = ["RF", "SchF", "ShuF"]
SIZES = [(name, 2) for name in NAMES] + [(n, d) for n in ANY_DIM for d in (1, 3, 5)]
#: Every size as itself and as two twins.
ALL = [(name, dim, twin) for name, dim in SIZES for twin in (None, 0, 7)]
TWINS = [case for case in ALL if case[2] is not None]


def at(name: str, *point: float) -> float:
    return float(surface(name, len(point))(np.array([point]))[0])


def transform_of(twin: Surface) -> Moved:
    assert isinstance(twin.function, Moved)
    return twin.function


def slack(s: Surface) -> float:
    """The rounding error of a value: some units in the last place of its terms."""
    return 1e-14 * s.ceiling


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
        ("RF", (0.5,), 0.25 + 20.0),
        ("RF", (1.0, 0.5, -0.25), 1.0 + 20.25 + 10.0625),
        ("SchF", (0.0, 0.0), 837.9658),
        ("SchF", (math.pi**2 / 4, 0.0), 837.9658 - math.pi**2 / 4),
        ("SchF", (-(math.pi**2) / 4, 0.0), 837.9658 + math.pi**2 / 4),
        ("SchF", (math.pi**2, 0.0, math.pi**2 / 4), 3 * 418.9829 - math.pi**2 / 4),
        ("ShuF", (0.0, 0.0), sum(i * math.cos(i) for i in range(1, 6)) ** 2),
        ("ShuF", (0.0,), sum(i * math.cos(i) for i in range(1, 6))),
        ("ShuF", (0.0, 2 * math.pi, 0.0), sum(i * math.cos(i) for i in range(1, 6)) ** 3),
    ],
)
def test_values_worked_out_by_hand(name: str, point: tuple[float, ...], value: float) -> None:
    assert math.isclose(at(name, *point), value, rel_tol=1e-12, abs_tol=1e-12)


@given(x=st.floats(-2, 2), y=st.floats(-2, 2))
def test_bf_and_rf_are_the_cosines_of_table_1(x: float, y: float) -> None:
    bf = x**2 + 2 * y**2 - 0.3 * math.cos(3 * math.pi * x) - 0.4 * math.cos(4 * math.pi * y) + 0.7
    rf = x**2 + y**2 - 10 * math.cos(2 * math.pi * x) - 10 * math.cos(2 * math.pi * y) + 20
    assert math.isclose(at("BF", x, y), bf, abs_tol=1e-13)
    assert math.isclose(at("RF", x, y), rf, abs_tol=1e-13)


@pytest.mark.parametrize("name", ["BF", "RF"])
def test_close_to_the_optimum_the_cost_is_what_its_curvature_says(name: str) -> None:
    # At 1e-9 from 0 the cosines of Table 1 have lost every digit; 2 sin^2 has lost none.
    along = {"BF": 1 + 0.15 * (3 * math.pi) ** 2, "RF": 1 + 5 * (2 * math.pi) ** 2}[name]
    assert math.isclose(at(name, 1e-9, 0.0), along * 1e-18, rel_tol=1e-12)


@pytest.mark.parametrize("j", range(1, 26))
def test_each_foxhole_is_as_deep_as_its_number(j: int) -> None:
    # At hole j its own term is 1/j; the other 24, at least 16 away, add 24/16^6 at most.
    hole = (-32.0 + 16 * ((j - 1) % 5), -32.0 + 16 * ((j - 1) // 5))
    terms = 1 / at("SF", *hole) - 1 / 500
    assert 1 / j < terms < 1 / j + 24 / 16**6


def test_foxholes_is_the_sum_of_table_1() -> None:
    x = np.random.default_rng(2).uniform(-40, 40, (50, 2))
    holes = [(a1, a2) for a2 in range(-32, 33, 16) for a1 in range(-32, 33, 16)]
    for point, cost in zip(x, SURFACES["SF"](x), strict=True):
        terms = [
            1 / (j + sum((c - a) ** 6 for c, a in zip(point, hole, strict=True)))
            for j, hole in enumerate(holes, 1)
        ]
        assert math.isclose(cost, 1 / (1 / 500 + sum(terms)), rel_tol=1e-12)


@pytest.mark.parametrize("name", ANY_DIM)
@pytest.mark.parametrize("dim", [2, 3, 5])
def test_more_variables_are_sums_or_products_of_one(name: str, dim: int) -> None:
    x = surface(name, dim).space.decode(np.random.default_rng(dim).random((40, dim)))
    factors = np.stack([surface(name, 1)(column[:, None]) for column in x.T])
    together = factors.prod(axis=0) if name == "ShuF" else factors.sum(axis=0)
    np.testing.assert_allclose(surface(name, dim)(x), together, rtol=1e-12, atol=1e-10)


@pytest.mark.parametrize(("name", "dim", "twin"), ALL)
def test_each_optimum_takes_the_least_value_and_meets_j_min(
    name: str, dim: int, twin: int | None
) -> None:
    s = surface(name, dim, twin)
    costs = s(s.optima)
    assert s.optima.shape[1] == dim
    assert np.all(np.abs(s.optima) <= s.half)
    assert np.all(np.abs(costs - s.minimum) <= slack(s))
    assert np.all(costs <= s.J_min)
    assert s.minimum < s.J_min


@pytest.mark.parametrize(("name", "dim", "twin"), ALL)
def test_no_place_is_lower_than_the_minimum(name: str, dim: int, twin: int | None) -> None:
    s = surface(name, dim, twin)
    rng = np.random.default_rng(12)
    uniform = s.space.decode(rng.random((50_000, dim)))
    neighbours = np.repeat(s.optima[:20], 500, axis=0)
    neighbours = neighbours + 1e-3 * s.half * rng.standard_normal(neighbours.shape)
    costs = s(np.vstack([uniform, neighbours]))
    assert costs.min() >= s.minimum - slack(s)
    if twin is None:
        assert costs[: len(uniform)].max() <= s.ceiling


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("twin", [None, 7])
def test_descents_from_the_best_of_a_grid_end_at_a_listed_optimum_or_above(
    name: str, twin: int | None
) -> None:
    s = surface(name, 2, twin)
    axis = np.linspace(-s.half, s.half, 301)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    starts = grid[np.argsort(s(grid))[:15]]
    limits = [(-s.half, s.half)] * 2

    def cost(p: Array) -> float:
        return float(s(p[None])[0])

    ends = [
        minimize(
            cost,
            start,
            method="Nelder-Mead",
            bounds=limits,
            options={"xatol": 1e-9 * s.half, "fatol": 1e-13},
        )
        for start in starts
    ]
    assert min(end.fun for end in ends) == pytest.approx(s.minimum, rel=1e-12, abs=1e-11)
    for end in ends:
        assert end.fun >= s.minimum - slack(s)
        if end.fun < s.minimum + 1e-9 * s.ceiling:
            assert np.abs(s.optima - end.x).max(axis=1).min() < 1e-4 * s.half


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_shubert_is_least_where_a_dense_scan_and_polishing_say(dim: int) -> None:
    # A product of factors, each with its own coordinate, is least among the products of their
    # turning values: in each coordinate it is least or greatest where that factor is.
    s, factor = surface("ShuF", dim), surface("ShuF", 1)
    x = np.linspace(-10, 10, 200_001)
    f = factor(x[:, None])
    turns = np.flatnonzero(np.diff(f[:-1]) * np.diff(f[1:]) <= 0) + 1
    at = np.array([_polished(factor, x[k - 1], x[k + 1], upwards=f[k] > f[k - 1]) for k in turns])
    values = factor(at[:, None])
    levels = np.unique(np.concatenate([values.round(9), f[[0, -1]]]))
    lowest = min(math.prod(some) for some in product(levels, repeat=dim))
    assert lowest == pytest.approx(s.minimum, rel=1e-9)
    high, low = (at[np.abs(values - level) < 1e-9] for level in (values.max(), values.min()))
    assert len(high) == len(low) == 3
    expected = [
        place
        for k in range(dim)
        for place in product(*(low if j == k else high for j in range(dim)))
    ]
    gaps = np.abs(s.optima[:, None] - np.array(expected)).max(axis=2)
    assert gaps.shape == (dim * 3**dim, dim * 3**dim)
    assert gaps.min(axis=0).max() < 1e-6
    assert gaps.min(axis=1).max() < 1e-6


def _polished(factor: Surface, lower: float, upper: float, *, upwards: bool) -> float:
    """The turning point of a function of one variable between two places."""
    sign = -1.0 if upwards else 1.0
    turning_point = minimize_scalar(
        lambda x: sign * float(factor(np.array([[x]]))[0]),
        bounds=(lower, upper),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return float(turning_point.x)


def test_published_minima() -> None:
    # Table 1: "18 different locations" of -186.7309; Table 5, ABFO, SchF: 2.5455e-05; SF 0.9980.
    shubert = SURFACES["ShuF"]
    assert len(np.unique(shubert.optima.round(9), axis=0)) == 18
    assert round(shubert.minimum, 4) == -186.7309
    assert f"{SURFACES['SchF'].minimum:.4e}" == "2.5455e-05"
    assert round(SURFACES["SF"].minimum, 4) == 0.9980
    printed = {"BF": 1e-9, "RF": 1e-8, "SF": 0.9990, "SchF": 1e-1, "ShuF": -186.73}
    assert {name: s.J_min for name, s in SURFACES.items()} == printed


@pytest.mark.parametrize("dim", [1, 2, 3, 5, 20, 256])
def test_the_answer_in_other_dimensions(dim: int) -> None:
    assert surface("RF", dim).minimum == 0.0
    assert surface("SchF", dim).minimum == pytest.approx(dim * 2.5455132587e-5 / 2, rel=1e-10)
    shubert = surface("ShuF", dim)
    closeness = (shubert.J_min - shubert.minimum) / abs(shubert.minimum)
    assert closeness == pytest.approx((186.7309088310238 - 186.73) / 186.7309088310238, rel=1e-6)
    assert np.isfinite(shubert.ceiling)


def test_shubert_lists_no_more_optima_than_can_be_used() -> None:
    assert len(surface("ShuF", 6).optima) == 6 * 3**6
    seven_dimensional = surface("ShuF", 7)
    assert len(seven_dimensional.optima) == 7 < 7 * 3**7 > MOST_OPTIMA
    assert np.all(np.abs(seven_dimensional.optima) < math.pi)


@pytest.mark.parametrize("name", ANY_DIM)
@given(x=st.floats(-1, 1), y=st.floats(-1, 1), z=st.floats(-1, 1))
def test_all_coordinates_count_alike(name: str, x: float, y: float, z: float) -> None:
    s = surface(name, 3)
    a, b = s(s.half * np.array([[x, y, z], [z, x, y]]))
    assert math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-9)


@pytest.mark.parametrize("name", ["BF", "RF"])
@given(x=st.floats(-1, 1), y=st.floats(-1, 1))
def test_even_surfaces_are_even(name: str, x: float, y: float) -> None:
    half = SURFACES[name].half
    assert at(name, x * half, y * half) == at(name, -x * half, y * half)


@pytest.mark.parametrize(("name", "dim", "twin"), [case for case in ALL if case[2] != 0])
@pytest.mark.parametrize("n", [1, 2, 3, 8, 31, 100])
def test_rows_are_independent_bit_for_bit(name: str, dim: int, twin: int | None, n: int) -> None:
    s = surface(name, dim, twin)
    x = s.space.decode(np.random.default_rng(n).random((n, dim)))
    alone = np.concatenate([s(row[None]) for row in x])
    assert np.array_equal(s(x), alone)
    assert np.array_equal(s(x[::-1]), alone[::-1])
    assert np.array_equal(s(np.asfortranarray(x)), alone)


@pytest.mark.parametrize("name", ANY_DIM)
@pytest.mark.parametrize("twin", [None, 7])
def test_rows_of_many_variables_are_independent_too(name: str, twin: int | None) -> None:
    # From 8 terms on NumPy's own sum would add in pairs, but only where there is a single row.
    s = surface(name, 40, twin)
    x = s.space.decode(np.random.default_rng(4).random((31, 40)))
    assert np.array_equal(s(x), np.concatenate([s(row[None]) for row in x]))


@pytest.mark.parametrize(
    ("name", "dim", "twin", "says"),
    [
        ("XF", 2, None, "no surface 'XF': there are BF, RF, SF, SchF, ShuF"),
        ("BF", 3, None, "BF is a function of 2 variables, not of 3"),
        ("SF", 1, 4, "SF is a function of 2 variables, not of 1"),
        ("RF", 0, None, "RF: dim is a whole number from 1 to 256, got 0"),
        ("RF", 257, None, "RF: dim is a whole number from 1 to 256, got 257"),
        ("RF", True, None, "RF: dim is a whole number from 1 to 256, got True"),
        ("RF", 2.0, None, "RF: dim is a whole number from 1 to 256, got 2.0"),
        ("RF", 2, -1, "RF: twin is a seed, a whole number from 0, got -1"),
        ("RF", 2, "7", "RF: twin is a seed, a whole number from 0, got '7'"),
    ],
)
def test_what_is_no_surface_is_refused_in_a_line(
    name: str, dim: int, twin: int | None, says: str
) -> None:
    with pytest.raises(InputError) as refusal:
        surface(name, dim, twin)
    assert str(refusal.value) == says


# ---- twins -------------------------------------------------------------------------------------


@pytest.mark.parametrize("dim", [1, 2, 3, 5, 40])
def test_a_rotation_keeps_lengths_angles_and_hands(dim: int) -> None:
    turn = rotation(np.random.default_rng(5), dim)
    np.testing.assert_allclose(turn @ turn.T, np.eye(dim), atol=1e-14)
    assert np.linalg.det(turn) == pytest.approx(1.0, abs=1e-12)


def test_rotations_of_the_plane_are_uniform_in_angle() -> None:
    # Kolmogorov-Smirnov of 2000 angles; above 1.95/sqrt(n) by chance once in 1000 seeds.
    rng = np.random.default_rng(8)
    turns = np.stack([rotation(rng, 2) for _ in range(2000)])
    angles = np.sort(np.arctan2(turns[:, 1, 0], turns[:, 0, 0]) / (2 * np.pi) + 0.5)
    steps = np.arange(2001) / 2000
    assert max(np.max(steps[1:] - angles), np.max(angles - steps[:-1])) < 1.95 / math.sqrt(2000)


def test_rotations_of_space_send_an_axis_anywhere_alike() -> None:
    # Archimedes: a coordinate of a uniform direction in space is uniform. Same test, same rate.
    rng = np.random.default_rng(9)
    turns = np.stack([rotation(rng, 3) for _ in range(2000)])
    for row, column in product(range(3), repeat=2):
        heights = np.sort(turns[:, row, column]) / 2 + 0.5
        steps = np.arange(2001) / 2000
        off = max(np.max(steps[1:] - heights), np.max(heights - steps[:-1]))
        assert off < 2.4 / math.sqrt(2000)  # nine of them: once in 5000


@pytest.mark.parametrize(("name", "dim", "twin"), TWINS)
def test_a_twin_is_its_surface_moved_rigidly(name: str, dim: int, twin: int) -> None:
    original, twin_surface = surface(name, dim), surface(name, dim, twin)
    map_ = transform_of(twin_surface)
    y = original.space.decode(np.random.default_rng(3).random((4000, dim)))
    x = map_.images(y)
    a, b = np.linalg.norm(np.diff(y, axis=0), axis=1), np.linalg.norm(np.diff(x, axis=0), axis=1)
    np.testing.assert_allclose(a, b, rtol=1e-12)
    # The same values up to slope times the rounding of x.
    np.testing.assert_allclose(twin_surface(x), original(y), rtol=0, atol=1e-10 * original.ceiling)


@pytest.mark.parametrize(("name", "dim", "twin"), TWINS)
def test_a_twins_optimum_is_where_it_was_drawn(name: str, dim: int, twin: int) -> None:
    original, twin_surface = surface(name, dim), surface(name, dim, twin)
    assert np.all(np.abs(twin_surface.optima[0]) <= 0.8 * twin_surface.half)
    assert twin_surface(twin_surface.optima[:1])[0] == pytest.approx(
        original.minimum, abs=slack(original)
    )
    assert (twin_surface.half, twin_surface.J_min, twin_surface.minimum) == (
        original.half,
        original.J_min,
        original.minimum,
    )


@pytest.mark.parametrize("twin", range(5))
def test_a_twin_lists_just_the_optima_that_are_left_in_the_box(twin: int) -> None:
    original, twin_surface = SURFACES["ShuF"], surface("ShuF", 2, twin)
    images = transform_of(twin_surface).images(original.optima)
    inside = images[np.abs(images).max(axis=1) <= original.half]
    assert len(twin_surface.optima) == len(inside) >= 1
    gaps = np.abs(twin_surface.optima[:, None] - inside).max(axis=2)
    assert gaps.min(axis=1).max() < 1e-12


@pytest.mark.parametrize(("name", "dim", "twin"), TWINS)
def test_beyond_the_wall_a_twin_costs_the_wall_and_the_distance(
    name: str, dim: int, twin: int
) -> None:
    original, twin_surface = surface(name, dim), surface(name, dim, twin)
    map_ = transform_of(twin_surface)
    x = twin_surface.space.decode(np.random.default_rng(6).random((20_000, dim)))
    y = map_.from_ + (x - map_.to) @ map_.turn.T
    wall = np.clip(y, -original.half, original.half)
    out = np.linalg.norm(y - wall, axis=1)
    penalty = out / original.half * (original.ceiling - original.minimum)
    np.testing.assert_allclose(
        twin_surface(x), original(wall) + penalty, rtol=1e-11, atol=1e-10 * original.ceiling
    )
    assert np.all(twin_surface(x)[out > 0] > original.minimum)


@pytest.mark.parametrize(("name", "dim", "twin"), TWINS)
def test_a_twin_is_continuous_across_the_wall(name: str, dim: int, twin: int) -> None:
    # Points on the wall, and steps out of it and into it: changes shrink with the step.
    original, twin_surface = surface(name, dim), surface(name, dim, twin)
    rng = np.random.default_rng(10)
    y = original.space.decode(rng.random((2000, dim)))
    side = rng.integers(dim, size=2000), rng.choice([-1.0, 1.0], size=2000)
    y[np.arange(2000), side[0]] = side[1] * original.half
    changes = []
    for step in (1e-3, 1e-5, 1e-7):
        out = np.zeros_like(y)
        out[np.arange(2000), side[0]] = side[1] * step * original.half
        map_ = transform_of(twin_surface)
        leap = np.abs(twin_surface(map_.images(y + out)) - twin_surface(map_.images(y - out)))
        changes.append(leap.max() / original.ceiling)
    assert changes[1] < changes[0] / 50
    assert changes[2] < changes[1] / 50 < 1e-4


def test_the_same_seed_is_the_same_twin_and_others_differ() -> None:
    assert surface("RF", twin=7) is surface("RF", 2, 7)
    assert SURFACES["RF"] is surface("RF") is surface("RF", 2)
    places = [surface("RF", 2, seed).optima[0] / 2.0 for seed in range(20)]
    assert len(np.unique(np.round(places, 6), axis=0)) == 20
    for seed in range(300):  # more than are kept
        surface("RF", 1, seed)
    assert SURFACES["RF"] is surface("RF")


def test_another_process_has_the_same_twin_bit_for_bit() -> None:
    code = (
        "import numpy as np; from stribeck.bench.surfaces import surface; "
        "s = surface('SchF', 5, 7); x = np.linspace(-500, 500, 50).reshape(10, 5); "
        "print(s.optima.tobytes().hex(), s(x).tobytes().hex())"
    )
    completed = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    s, x = surface("SchF", 5, 7), np.linspace(-500, 500, 50).reshape(10, 5)
    assert completed.stdout.split() == [s.optima.tobytes().hex(), s(x).tobytes().hex()]


def test_one_seed_moves_different_surfaces_differently() -> None:
    first = [surface(name, dim, 7).optima[0, 0] / surface(name, dim).half for name, dim in SIZES]
    assert len(np.unique(np.round(first, 6))) == len(SIZES)


def test_optima_are_drawn_all_over_the_middle() -> None:
    # 400 uniform places: all four quadrants hold 100 +- 35, which fails by chance once in 10^4.
    places = np.array([surface("SchF", 2, seed).optima[0] / 400 for seed in range(400)])
    quadrants = np.bincount((places > 0) @ np.array([1, 2]), minlength=4)
    assert np.all(np.abs(places) <= 1)
    assert np.abs(places).max() > 0.98
    assert np.all(np.abs(quadrants - 100) < 35)


def test_names_tell_sizes_and_twins_apart() -> None:
    assert surface("RF").name == "RF"
    assert surface("RF", 5).name == "RF-d5"
    assert surface("ShuF", 3, 11).name == "ShuF-d3-twin11"
    assert surface("BF", None, 0).title == "Bohachevsky, twin 0"


def test_what_is_handed_out_cannot_be_changed() -> None:
    places: Array = surface("ShuF", 2, 7).optima
    with pytest.raises(ValueError, match="read-only"):
        places[0, 0] = 0.0
