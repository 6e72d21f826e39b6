"""`mbts` as a whole: minima, shares of the budget, stops, and costs that are hard to search."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from stribeck.bench.surfaces import rotation, surface
from stribeck.optimize import MemeticTabuSearch, Run, Search, lockstep, minimize, rms
from stribeck.space import Array, Param, Space, box

Cost = Callable[[Array], Array]


def valley(x: Array) -> Array:
    """Rosenbrock's function in any dimension; its minimum is 0 at 1."""
    cost: Array = (100 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1 - x[:, :-1]) ** 2).sum(axis=1)
    return cost


def rugged(x: Array) -> Array:
    """Rastrigin's function off the centre of its box; its minimum is 0 at 0.3."""
    away = x - 0.3
    cost: Array = (away**2 + 10 * (1 - np.cos(2 * np.pi * away))).sum(axis=1)
    return cost


def terraces(x: Array) -> Array:
    """A long bowl in thirty steps a decade: its slope is 0 almost everywhere."""
    turn = rotation(np.random.default_rng(0), x.shape[1])
    squares = ((x - 0.7) @ turn.T) ** 2 @ 10.0 ** np.linspace(0, 3, x.shape[1])
    cost: Array = 120 + np.floor(30 * np.log10(1e-9 + squares))
    return cost


class Exponential:
    """A fit of two exponential decays to their sum, as residuals and as a cost."""

    name = "decays"
    space = Space(
        (
            Param("a", 0.0, 2.0),
            Param("p", 0.1, 100.0, log=True),
            Param("b", 0.0, 2.0),
            Param("q", 0.1, 100.0, log=True),
        )
    )
    t = np.linspace(0.0, 2.0, 40)
    truth = np.array([[1.3, 0.8, 0.7, 12.0]])

    def __init__(self, hole: float = 0.0) -> None:
        self.hole = hole

    def shape(self, x: Array) -> Array:
        a, p, b, q = x.T[:, :, None]
        sums: Array = a * np.exp(-p * self.t) + b * np.exp(-q * self.t)
        return sums

    def residuals(self, x: Array, /) -> Array:
        shown = self.shape(x) - self.shape(self.truth)
        shown[x[:, 0] < self.hole] = np.nan
        return shown

    def __call__(self, x: Array, /) -> Array:
        return rms(self.residuals(x))


class Plain(Exponential):
    """The same problem without residuals, as a cost alone."""

    residuals = None  # type: ignore[assignment]

    def __call__(self, x: Array, /) -> Array:
        return rms(self.shape(x) - self.shape(self.truth))


class Shown:
    """A problem of given residuals on the unit cube."""

    name = "shown"

    def __init__(self, dim: int, residuals: Cost) -> None:
        self.space, self.shown = box([(0.0, 1.0)] * dim), residuals

    def residuals(self, x: Array, /) -> Array:
        return self.shown(x)

    def __call__(self, x: Array, /) -> Array:
        return rms(self.shown(x))


def run(problem: Any, *, budget: int, seed: int = 0, **settings: Any) -> Run:
    search = Search(problem.space, MemeticTabuSearch(**settings), budget=budget, seed=seed)
    return lockstep(problem, [search])[0]


def evaluations_by_side(result: Run) -> dict[str, int]:
    """Evaluations of each side; cells count as the descents that they start."""
    rows: dict[str, int] = {}
    starts = [0, *result.trace.ends]
    for note, start, end in zip(result.trace.notes, starts, result.trace.ends, strict=False):
        side = "tabu" if note["stage"] == "foraging" else note["stage"]
        rows[side] = rows.get(side, 0) + end - start
    return rows


# --- minima


@pytest.mark.parametrize("name", ["BF", "RF", "SF", "SchF", "ShuF"])
@pytest.mark.parametrize("moved", [False, True])
def test_it_finds_the_least_of_the_papers_surfaces(name: str, moved: bool) -> None:
    """Twenty seeds of twenty; every seed has a twin of its own. The worst of them takes 1,000."""
    evaluations = []
    for seed in range(20):
        problem = surface(name, 2, seed if moved else None)
        result = minimize(problem, problem.space, budget=4000, target=problem.J_min, seed=seed)
        assert result.ended == "target"
        evaluations.append(result.evaluations)
    assert np.median(evaluations) < 400


@pytest.mark.parametrize("dim", [1, 2, 5])
def test_it_leaves_basins_that_are_not_the_best(dim: int) -> None:
    for seed in range(5):
        result = minimize(rugged, [(-3.0, 2.0)] * dim, budget=4000 * dim, target=1e-8, seed=seed)
        assert result.ended == "target"


@pytest.mark.parametrize("dim", [2, 10, 30])
def test_it_follows_a_curved_valley(dim: int) -> None:
    result = minimize(valley, [(-2.0, 2.0)] * dim, budget=1000 * dim, target=1e-6, seed=1)
    assert result.ended == "target"


def test_residuals_spare_evaluations() -> None:
    """Ten seeds to the same cost of the same problem: less than a third of the evaluations."""
    evaluations = []
    for problem in (Exponential(), Plain()):
        runs = [
            minimize(problem, problem.space, budget=20_000, target=1e-4, seed=seed)
            for seed in range(10)
        ]
        assert all(result.ended == "target" for result in runs)
        evaluations.append([result.evaluations for result in runs])
    assert sum(evaluations[0]) < sum(evaluations[1]) / 3


def test_residuals_need_not_run_everywhere() -> None:
    result = run(Exponential(hole=1.0), budget=1500)
    assert result.cost < 1e-5


@pytest.mark.parametrize(
    "residuals",
    [
        lambda u: (u - 0.3)[:, :1] * 1.0,  # one of them, which one parameter does not move
        lambda u: np.zeros((len(u), 3)),
        lambda u: np.ones((len(u), 3)),
        lambda u: np.hstack([u - 0.3, np.zeros((len(u), 2))]),
        lambda u: np.full((len(u), 2), np.nan),
        lambda u: np.where(u[:, :1] < 0.5, np.nan, u - 0.3),
    ],
)
def test_degenerate_residuals_are_survived(residuals: Cost) -> None:
    result = run(Shown(3, residuals), budget=800)
    reachable = residuals(np.array([[0.5, 0.3, 0.3], [0.3, 0.3, 0.3]]))
    if np.isfinite(reachable).any():
        assert result.cost <= np.nanmin(rms(reachable)) + 1e-4
    assert result.evaluations == 800


def test_log_ranges_are_walked_in_decades() -> None:
    space = Space((Param("a", 1e-9, 1e9, log=True), Param("b", 1e-3, 1e3, log=True)))

    def decades(x: Array) -> Array:
        cost: Array = (np.log10(x[:, 0]) - 4) ** 2 + (np.log10(x[:, 1]) + 2) ** 2
        return cost

    result = minimize(decades, space, budget=300)
    np.testing.assert_allclose(np.log10(result.x), [4, -2], atol=1e-5)


@pytest.mark.parametrize("dim", [1, 2, 30])
def test_a_least_in_a_corner_is_met_exactly(dim: int) -> None:
    result = minimize(lambda x: x.sum(axis=1), [(-1.0, 3.0)] * dim, budget=100 + 50 * dim)
    assert (result.x == -1.0).all()


# --- how the budget is shared


@pytest.mark.parametrize(
    ("cost", "busy", "idle"),
    [(terraces, "neighbourhood", "tabu"), (valley, "tabu", "neighbourhood")],
)
def test_the_side_that_brings_something_goes_on(cost: Cost, busy: str, idle: str) -> None:
    """Until the target is reached the side that improves has most of the budget."""
    totals = {busy: 0, idle: 0}
    for seed in range(10):
        result = minimize(cost, [(-5.0, 5.0)] * 10, budget=20_000, target=1e-6, seed=seed)
        rows = evaluations_by_side(result)
        for stage in totals:
            totals[stage] += rows.get(stage, 0)
    assert totals[busy] > 1.2 * totals[idle]


def test_neither_side_is_ever_given_up() -> None:
    """A search without further improvement gives each side its share of the budget."""
    rows = evaluations_by_side(minimize(rugged, [(-3.0, 2.0)] * 2, budget=20_000, seed=1))
    assert rows["tabu"] > 6000
    assert rows["neighbourhood"] > 6000


@pytest.mark.parametrize("problem", [Exponential(), Plain()])
def test_every_step_says_its_stage_and_round(problem: Any) -> None:
    notes = run(problem, budget=4000, patience=50).trace.notes
    assert {note["stage"] for note in notes} == {"foraging", "tabu", "neighbourhood"}
    assert [note["round"] for note in notes] == list(range(1, len(notes) + 1))


def test_no_two_descents_begin_in_the_same_place() -> None:
    """The first point evaluated after each restart."""
    result = minimize(rugged, [(-3.0, 2.0)] * 2, budget=5000, seed=3)
    trace = result.trace
    starts = [
        trace.u[start] if end - start == 1 else trace.u[start:end].mean(axis=0)
        for note, start, end in zip(trace.notes, [0, *trace.ends], trace.ends, strict=False)
        if note["stage"] == "tabu" and note.get("event") == "restart"
    ]
    assert len(starts) > 20
    distances = [float(np.linalg.norm(a - b)) for a, b in itertools.combinations(starts, 2)]
    assert min(distances) > 1e-3


# --- when it ends


@pytest.mark.parametrize("settle", [10, 100])
def test_settled_is_said_after_as_many_idle_evaluations(settle: int) -> None:
    result = minimize(valley, [(-2.0, 2.0)] * 2, budget=50_000, settle=settle, seed=2)
    assert result.ended == "settled"
    low = result.trace.convergence()
    worth = float(np.median(result.trace.f[1:11])) - low[-1]  # the cells of the first swarm
    last = int(np.flatnonzero(low > low[-1] + 1e-5 * worth)[-1]) + 1
    assert result.evaluations - last >= 2 * settle
    descent_start = result.trace.ends[-2]
    assert descent_start - result.trace.best - 1 < 2 * settle  # not before, and no step later


def test_it_goes_on_as_long_as_it_is_let() -> None:
    result = minimize(lambda x: np.ones(len(x)), [(0.0, 1.0)] * 2, budget=5000)
    assert (result.ended, result.evaluations) == ("budget", 5000)


# --- costs that are hard to search


def corner(x: Array) -> Array:
    """A cost that is finite in one corner alone."""
    return np.where((x < 0.2).all(axis=1), ((x - 0.1) ** 2).sum(axis=1), np.nan)


def penalised(x: Array) -> Array:
    return np.where(rugged(4 * x) < 30, rugged(4 * x), np.finfo(float).max)


@pytest.mark.parametrize("dim", [1, 2, 3])
@pytest.mark.parametrize(
    "cost",
    [
        lambda x: np.full(len(x), np.nan),
        lambda x: np.full(len(x), np.inf),
        lambda x: np.full(len(x), -np.inf),
        lambda x: np.zeros(len(x)),
        lambda x: np.full(len(x), 1e308),
        lambda x: np.where(x[:, 0] < 0.4, -1.7e308, 1.7e308),
        lambda x: np.where(x[:, 0] < 0.4, np.inf, x.sum(axis=1)),
        lambda x: 1e308 * (0.1 + x.sum(axis=1) / 10),
        lambda x: 1e-300 * x.sum(axis=1),
        lambda x: 5e-324 * np.floor(9 * x.sum(axis=1)),
        lambda x: 1e15 + rugged(x),
        lambda x: np.sign(x[:, 0] - 0.123),
        corner,
        penalised,
    ],
)
def test_strange_costs_warn_of_nothing(cost: Cost, dim: int) -> None:
    """Overflow, 0/0 and the like are errors under pytest."""
    result = minimize(cost, [(0.0, 1.0)] * dim, budget=6000, seed=1)
    assert result.evaluations == 6000


@pytest.mark.parametrize("seed", range(5))
def test_penalties_are_no_part_of_the_landscape(seed: int) -> None:
    result = minimize(penalised, [(-1.0, 1.0)] * 2, budget=6000, target=1e-8, seed=seed)
    assert result.ended == "target"


def test_one_corner_that_runs_is_found_and_searched() -> None:
    """The corner is an eighth of a percent of the cube: one random point in 800."""
    result = minimize(corner, [(0.0, 1.0)] * 3, budget=20_000, target=1e-9, seed=0)
    assert result.ended == "target"


@pytest.mark.parametrize("scale", [2.0**-200, 2.0**200])
def test_it_does_not_know_the_unit_of_the_cost(scale: float) -> None:
    plain = minimize(rugged, [(-3.0, 2.0)] * 2, budget=3000, seed=1)
    scaled = minimize(lambda x: scale * rugged(x), [(-3.0, 2.0)] * 2, budget=3000, seed=1)
    assert np.array_equal(plain.trace.u, scaled.trace.u)


@pytest.mark.parametrize(
    "settings",
    [
        {"S": 1, "tumbles": 0.0, "patience": 1, "N": 4},
        {"S": 2000},
        {"N": 3000},
        {"N": 4, "R_N": 1e-12},
        {"R": 1e-12},
        {"R": 10.0, "R_N": 10.0, "apart": 10.0},
        {"apart": 1e-12},
        {"grow": 1.0},
        {"grow": 1e6},
        {"settle": 1},
    ],
)
@pytest.mark.parametrize("dim", [1, 3])
def test_settings_at_their_ends_hang_nothing(settings: dict[str, Any], dim: int) -> None:
    result = minimize(rugged, [(-3.0, 2.0)] * dim, budget=3000, seed=2, **settings)
    assert (result.ended == "settled") if "settle" in settings else (result.evaluations == 3000)


@pytest.mark.parametrize("budget", [1, 2, 9, 10])
def test_a_budget_smaller_than_the_first_swarm_is_kept(budget: int) -> None:
    result = minimize(valley, [(-2.0, 2.0)] * 2, budget=budget)
    assert (result.evaluations, result.ended) == (budget, "budget")


# --- the same again


@pytest.mark.parametrize("problem", [Exponential(), Plain(), Exponential(hole=1.0)])
def test_side_by_side_it_is_what_it_is_alone(problem: Any) -> None:
    """Searches with and without residuals in one lockstep."""

    def searches() -> list[Search]:
        return [
            Search(problem.space, MemeticTabuSearch(patience=10 + s), budget=700 + s, seed=s)
            for s in range(6)
        ]

    together = lockstep(problem, searches())
    for result, search in zip(together, searches(), strict=True):
        alone = lockstep(problem, [search])[0]
        assert np.array_equal(result.trace.u, alone.trace.u)
        assert np.array_equal(result.trace.f, alone.trace.f)
        assert result.trace.notes == alone.trace.notes
