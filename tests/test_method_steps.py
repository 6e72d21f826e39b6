"""The steps of each method, against numbers worked out by hand from the paper's equations."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stribeck.errors import InputError
from stribeck.optimize import (
    AdaptiveForaging,
    AdaptiveTabuSearch,
    BacterialForaging,
    ForagingTabuSearch,
    GeneticAlgorithm,
    TabuSearch,
    minimize,
)
from stribeck.optimize.genetic import expectation, scattered, stochastic_uniform
from stribeck.optimize.tabu import admitted
from stribeck.optimize.unit_cube import inside, neighbourhood, widths
from stribeck.space import Param, Space, box

if TYPE_CHECKING:
    from stribeck.optimize import Run
    from stribeck.space import Array, Rng

BOWL = Space((Param("a", -5, 5), Param("b", -5, 5), Param("c", 1e-3, 1e3, log=True)))


def bowl(x: Array) -> Array:
    cost: Array = 10 * ((x[:, 0] - 1) ** 2 + (x[:, 1] + 2) ** 2 + np.log10(x[:, 2]) ** 2)
    return cost


def run(method: str, *, budget: int, **settings: Any) -> Run:
    return minimize(bowl, BOWL, method=method, budget=budget, seed=5, **settings)


# --- lengths and walls


@given(st.lists(st.floats(-9, 9), min_size=1, max_size=20))
def test_reflection_is_a_mirror_and_clipping_a_wall(values: list[float]) -> None:
    u = np.array(values)
    mirrored, clipped = inside(u, "reflect"), inside(u, "clip")
    for v, m, c in zip(values, mirrored, clipped, strict=True):
        assert 0.0 <= m <= 1.0
        assert c == min(max(v, 0.0), 1.0)
        assert math.isclose(math.cos(math.pi * m), math.cos(math.pi * v), abs_tol=1e-9)


def test_raw_lengths_are_those_of_the_parameters() -> None:
    space = box([(0.0, 4.0), (-1.0, 1.0)])
    assert np.array_equal(widths(space, "raw"), [4.0, 2.0])
    assert np.array_equal(widths(space, "unit"), [1.0, 1.0])
    neighbours = neighbourhood(
        np.random.default_rng(0), np.array([0.5, 0.5]), 0.2 / widths(space, "raw"), 4000, "clip"
    )
    # Uniform over a square of half-width 0.2 in both parameters; 4000 points leave less than
    # 1 % of a side empty at either end, except once in 10^17.
    reach = np.abs(space.decode(neighbours) - [2.0, 0.0]).max(axis=0)
    assert np.all(reach <= 0.2 + 1e-12)
    assert np.all(reach > 0.198)


@pytest.mark.parametrize("name", ["ts", "ats", "bfo", "abfo", "bts"])
def test_raw_lengths_on_a_log_range_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=r"log range of c: use 'unit'"):
        run(name, budget=10, coordinates="raw")


# --- the steps of foraging: section 2.3, Steps 3 to 5


class ScriptedGenerator:
    """A random generator that returns given numbers."""

    def __init__(self, *values: Any) -> None:
        self.values = [np.asarray(v, dtype=float) for v in values]

    def uniform(self, low: float, high: float, shape: tuple[int, ...]) -> Array:
        assert (low, high) == (-1.0, 1.0)
        return self._next(shape)

    def random(self, shape: tuple[int, ...]) -> Array:
        return self._next(shape)

    def _next(self, shape: tuple[int, ...]) -> Array:
        value = self.values.pop(0) if len(self.values) > 1 else self.values[0]
        return np.broadcast_to(value, shape).copy()


def silent(**entries: Any) -> None:
    del entries


PAIR = np.array([[0.5, 0.5], [0.5, 0.7]])
SIGNALS: dict[str, Any] = {
    "S": 2,
    "d_attract": 0.1,
    "w_attract": 0.2,
    "h_repellant": 0.2,
    "w_repellant": 10.0,
}


def test_signals_follow_equation_2_1() -> None:
    swarm = BacterialForaging(**SIGNALS)
    # Each cell: itself -0.1 + 0.2, the other at squared distance 0.04:
    # -0.1 exp(-0.2 * 0.04) + 0.2 exp(-10 * 0.04) = -0.0992032 + 0.1340640.
    J_cc = swarm.J_cc(PAIR, np.arange(2), PAIR, np.ones(2))
    assert np.allclose(J_cc, [0.1348608, 0.1348608], atol=1e-7)
    # A cell that has left its place takes its own member along: squared distance 0.05 to the
    # other, -0.1 exp(-0.01) + 0.2 exp(-0.5) = -0.0990050 + 0.1213061, and 0.1 for itself.
    moved = swarm.J_cc(np.array([[0.6, 0.5]]), np.array([0]), PAIR, np.ones(2))
    assert np.allclose(moved, [0.1223011], atol=1e-7)


def test_signals_and_steps_in_raw_coordinates_do_not_see_the_cube() -> None:
    swarm = BacterialForaging(**SIGNALS, coordinates="raw")
    width = np.array([40.0, 8.0])
    assert np.allclose(
        swarm.J_cc(PAIR / width, np.arange(2), PAIR / width, width), [0.1348608] * 2, atol=1e-7
    )


@pytest.mark.parametrize("coordinates", ["unit", "raw"])
@pytest.mark.parametrize("quiet", [{}, {"d_attract": 0.0}, {"d_attract": 0.0, "h_repellant": 0.0}])
def test_signals_are_equation_2_1_cell_by_cell(coordinates: Any, quiet: dict[str, float]) -> None:
    rng = np.random.default_rng(3)
    places, width = rng.random((6, 3)), np.array([2.0, 0.5, 7.0])
    moved, cells = rng.random((2, 3)), np.array([4, 1])
    bacteria = BacterialForaging(**{**SIGNALS, "S": 6, **quiet}, coordinates=coordinates)
    sides = width if coordinates == "raw" else np.ones(3)
    by_cell = []
    for place, cell in zip(moved, cells, strict=True):
        rest = [p for i, p in enumerate(places) if i != cell]
        squares = [0.0] + [float((((place - p) * sides) ** 2).sum()) for p in rest]
        by_cell.append(
            sum(bacteria.h_repellant * math.exp(-10.0 * d2) for d2 in squares)
            - sum(bacteria.d_attract * math.exp(-0.2 * d2) for d2 in squares)
        )
    assert np.allclose(bacteria.J_cc(moved, cells, places, sides), by_cell, rtol=1e-12, atol=1e-14)


def chemotaxis(swarm: Any, replies: list[list[float]], **options: Any) -> tuple[list[Array], Any]:
    """One chemotactic step of PAIR: the points evaluated, batch by batch, and its result."""
    Delta = [[1.0, 0.0], [3.0, -4.0]]
    width = np.array(options.get("width", [1.0, 1.0]))
    moves = swarm.chemotaxis(
        PAIR.copy(),
        np.array([1.0, 2.0]),
        np.array([0.1, 0.2]),
        width,
        cast("Rng", ScriptedGenerator(Delta)),
        silent,
    )
    evaluated = [next(moves).copy()]
    for costs in replies:
        try:
            evaluated.append(moves.send(np.array(costs)).copy())
        except StopIteration as done:
            return evaluated, done.value
    raise AssertionError("the step needs more costs")


def test_a_chemotactic_step_by_hand() -> None:
    # J_last = J + J_cc = 1.1348608 and 2.1348608 (see above). The tumble, equation (2.3), is
    # C Delta/|Delta| = (0.1, 0) and (0.12, -0.16). Cell 0 then costs 1.01 + 0.1223011 =
    # 1.1323011: worse than before without the signals, better with them, so it swims. Cell 1
    # costs 2.5: it stops, where it is. Cell 0 gets worse and stays there: no undoing.
    evaluated, (theta, J, J_next) = chemotaxis(
        BacterialForaging(**SIGNALS, N_s=4), [[1.01, 2.5], [3.0]]
    )
    assert np.allclose(evaluated[0], [[0.6, 0.5], [0.62, 0.54]])
    assert np.allclose(evaluated[1], [[0.7, 0.5]])
    assert len(evaluated) == 2
    assert np.allclose(theta, [[0.7, 0.5], [0.62, 0.54]])
    assert np.array_equal(J, [3.0, 2.5])
    assert np.all(J_next > J)


def test_a_raw_step_is_as_long_in_the_parameters_as_printed() -> None:
    evaluated, _ = chemotaxis(BacterialForaging(**SIGNALS, N_s=0), [[1.0, 1.0]], width=[2.0, 8.0])
    assert np.allclose(evaluated[0], PAIR + np.array([[0.1 / 2, 0.0], [0.12 / 2, -0.16 / 8]]))


def test_a_swim_is_n_s_steps_at_most() -> None:
    evaluated, _ = chemotaxis(BacterialForaging(**SIGNALS, N_s=2), [[0.5, 9.0], [0.4], [0.3]])
    assert [len(a) for a in evaluated] == [2, 1, 1]


def test_the_reading_of_4_4_swims_in_any_case() -> None:
    swarm = BacterialForaging(**SIGNALS, N_s=2, swim="always")
    evaluated, _ = chemotaxis(swarm, [[9.0, 9.0], [9.0, 9.0], [9.0, 9.0]])
    assert [len(a) for a in evaluated] == [2, 2, 2]
    assert np.allclose(evaluated[2], PAIR + 3 * np.array([[0.1, 0.0], [0.12, -0.16]]))


@pytest.mark.parametrize(("improve", "batches"), [("<", 1), ("<=", 2)])
def test_equal_costs_improve_only_by_the_other_reading(improve: Any, batches: int) -> None:
    mute: dict[str, Any] = SIGNALS | {"d_attract": 0.0, "h_repellant": 0.0}
    evaluated, _ = chemotaxis(BacterialForaging(**mute, improve=improve), [[1.0, 3.0], [2.0]])
    assert len(evaluated) == batches


def test_adaptive_step_follows_equation_2_2() -> None:
    J = np.array([0.0, -1000.0, 3000.0, np.inf])
    assert np.allclose(AdaptiveForaging(alpha=1e3).step_length(J, J), [0.0, 0.5, 0.75, 1.0])
    halved = AdaptiveForaging(alpha=1e3, step=0.5).step_length(J, J)
    assert np.allclose(halved, [0.0, 0.25, 0.375, 0.5])
    aimed = AdaptiveForaging(alpha=1e3, J_target=-1000.0).step_length(J, J)
    assert np.allclose(aimed, [0.5, 0.0, 0.8, 1.0])


def test_a_step_without_alpha_does_not_depend_on_the_unit_of_cost() -> None:
    cells = AdaptiveForaging(alpha=None)
    J, first = np.array([1.0, 2.0, 5.0]), np.array([1.0, 2.0, np.inf, 3.0])
    assert np.allclose(cells.step_length(J, first), [1 / 3, 1 / 2, 5 / 7])  # alpha = 2
    assert np.allclose(cells.step_length(1e-6 * J, 1e-6 * first), cells.step_length(J, first))
    assert np.array_equal(cells.step_length(J, np.full(3, np.inf)), J / (J + 1.0))


def test_the_healthier_half_splits_in_place() -> None:
    # Steps of negligible length: cells keep their places; the second lifetime shows the survivors.
    result = run("bfo", budget=10**4, S=6, N_c=3, N_s=0, C=1e-12, N_re=2, N_ed=1, P_ed=0.0)
    assert result.trace.ends == [6 * k for k in range(1, 8)]
    first, second = result.trace.u[:6], result.trace.u[24:30]
    best = first[np.argsort(result.trace.f[:6])[:3]]
    assert np.allclose(second, np.tile(best, (2, 1)), atol=1e-9)
    assert result.ended == "N_ed"
    assert result.trace.rounds("foraging") == 2 * 3


@pytest.mark.parametrize(("P_ed", "dispersed"), [(0.0, 0), (1.0, 6)])
def test_dispersal_takes_cells_with_its_probability(P_ed: float, dispersed: int) -> None:
    result = run("abfo", budget=10**4, S=6, N_c=1, N_s=0, N_re=1, N_ed=1, P_ed=P_ed)
    assert result.evaluations == 6 + 6 + dispersed


# --- the steps of adaptive tabu search: Steps 8 to 14, Algorithms 1 and 2


def tabu_by_hand(costs: list[float], **settings: Any) -> tuple[list[float], list[dict[str, Any]]]:
    """Points evaluated and events where the one neighbour is S0 + R; `costs` in their order."""
    notes: list[dict[str, Any]] = []
    base: dict[str, Any] = {"N": 1, "R": 0.1, "BT": 2, "n_re_back": 2, "AR": ()}
    algorithm = AdaptiveTabuSearch(**(base | settings))
    rng = cast("Rng", ScriptedGenerator([[1.0]]))
    moves: Any = algorithm.refine(
        np.array([0.0]), 10.0, 0, box([(0.0, 1.0)]), rng, lambda **kw: notes.append(kw)
    )
    evaluated = [float(next(moves)[0, 0])]
    for cost in costs:
        try:
            evaluated.append(float(moves.send(np.array([cost]))[0, 0]))
        except StopIteration:
            break
    return evaluated, [s for s in notes if "event" in s]


def test_backtracking_takes_the_ranked_entry_of_the_tabu_list() -> None:
    # Round 1: 8 at 0.1 beats 10 at 0.0, which goes on the list. Rounds 2 and 3 fail at 0.2
    # with 9 and 12: a deadlock. Ranked list: 9 at 0.2, 10 at 0.0, 12 at 0.2. Its 2nd entry is
    # S0 = 0.0 of cost 10, which 9.5 then beats.
    evaluated, events = tabu_by_hand([8.0, 9.0, 12.0, 9.5])
    assert np.allclose(evaluated, [0.1, 0.2, 0.2, 0.1, 0.2])
    assert events == [{"event": "backtrack"}]


def test_a_deadlock_is_failures_in_a_row() -> None:
    evaluated, events = tabu_by_hand([12.0, 8.0, 9.0])
    assert np.allclose(evaluated, [0.1, 0.1, 0.2, 0.2])
    assert events == []


def test_backtracking_by_recency_takes_what_was_stored_last_but_one() -> None:
    # Stored in order: 10 at 0.0, 9 at 0.2, 12 at 0.2. Last but one: 0.2 of cost 9, which 9.5
    # does not beat.
    evaluated, _ = tabu_by_hand([8.0, 9.0, 12.0, 9.5], recall="recent")
    assert np.allclose(evaluated, [0.1, 0.2, 0.2, 0.3, 0.3])


def test_backtracking_beyond_the_list_takes_its_end() -> None:
    evaluated, _ = tabu_by_hand([8.0, 9.0, 12.0], n_re_back=50)
    assert np.allclose(evaluated, [0.1, 0.2, 0.2, 0.3])  # 12 at 0.2


AR = ((9.0, 0.05), (5.0, 0.01))


def test_the_radius_shrinks_with_the_best_cost_and_never_grows() -> None:
    # 8 < 9 begins stage 1 from the second round on; backtracking to a cost of 10 does not end it.
    evaluated, _ = tabu_by_hand([8.0, 9.0, 12.0, 11.0, 4.0], AR=AR)
    assert np.allclose(evaluated, [0.1, 0.15, 0.15, 0.05, 0.05, 0.06])


def test_the_radius_follows_the_current_cost_by_the_other_reading() -> None:
    # After backtracking to 0.0 of cost 10 the radius is 0.1 again.
    evaluated, _ = tabu_by_hand([8.0, 9.0, 12.0, 4.0], AR=AR, radius_from="current")
    assert np.allclose(evaluated, [0.1, 0.15, 0.15, 0.1, 0.11])


def test_the_radius_shrinks_by_deadlocks_whatever_the_costs() -> None:
    evaluated, _ = tabu_by_hand([8.0, 9.0, 12.0, 11.0, 13.0], AR=AR, AR_by="deadlock")
    # Second deadlock after rounds 4 and 5: ranked 9 at .2, 10 at 0, 11 at .05, ...: 0.0 again.
    assert np.allclose(evaluated, [0.1, 0.2, 0.2, 0.05, 0.05, 0.01])


def test_a_deadlock_ends_the_descent_where_a_restart_is_wanted() -> None:
    evaluated, events = tabu_by_hand([8.0, 9.0, 12.0, 1.0], deadlock="restart")
    assert np.allclose(evaluated, [0.1, 0.2, 0.2])
    assert events == [{"event": "restart"}]


def test_a_restart_by_deadlocks_waits_for_the_last_stage() -> None:
    table = [8.0, 9.0, 12.0, 11.0, 13.0, 11.0, 13.0, 1.0]
    evaluated, events = tabu_by_hand(table, AR=AR, AR_by="deadlock", deadlock="restart")
    assert np.allclose(evaluated, [0.1, 0.2, 0.2, 0.15, 0.15, 0.11, 0.11])
    assert events == [{"event": "restart"}]


def test_by_one_reading_the_search_moves_to_a_worse_neighbour() -> None:
    # 12 at 0.1 replaces 10 at 0.0, then 11 at 0.2 that: neither beats 10, so two rounds are a
    # deadlock. Ranked list: 10 at 0.0, 12 at 0.1. Its 2nd entry is 0.1.
    evaluated, events = tabu_by_hand([12.0, 11.0, 13.0], move="best")
    assert np.allclose(evaluated, [0.1, 0.2, 0.2, 0.3])
    assert events == [{"event": "backtrack"}]


def test_by_one_reading_neighbours_lie_at_the_radius() -> None:
    draws = np.random.default_rng(3)
    points = neighbourhood(draws, np.array([0.5, 0.5]), np.array([0.2, 0.2]), 50, "clip", "at")
    assert np.allclose(np.linalg.norm(points - 0.5, axis=1), 0.2)


@pytest.mark.parametrize("name", ["ts", "ats", "bts"])
def test_count_max_is_rounds_exactly(name: str) -> None:
    settings: dict[str, Any] = {"deadlock": "restart"} if name != "ts" else {}
    result = run(name, budget=10**6, N=3, count_max=41, **settings)
    assert result.ended == "count_max"
    stage = None if name == "ts" else "tabu"
    assert result.trace.rounds(stage) == 41


def test_literal_ats_cannot_leave_a_basin_and_a_restart_can() -> None:
    # Two wells, the deeper one far away; neighbours reach 0.05 of the range.
    def wells(x: Array) -> Array:
        return np.minimum((x[:, 0] - 0.2) ** 2 * 100 + 1, (x[:, 0] - 0.8) ** 2 * 100)

    options: dict[str, Any] = {"method": "ats", "R": 0.05, "AR": (), "budget": 4000, "target": 0.1}
    successes = {
        deadlock: sum(
            minimize(wells, [(0.0, 1.0)], seed=s, deadlock=deadlock, **options).ended == "target"
            for s in range(20)
        )
        for deadlock in ("backtrack", "restart")
    }
    starts = [
        minimize(wells, [(0.0, 1.0)], method="ats", budget=1, seed=s).x[0] > 0.5 for s in range(20)
    ]
    assert successes["restart"] == 20
    assert successes["backtrack"] < 20
    assert abs(successes["backtrack"] - sum(starts)) <= 3  # those that began in its basin


# --- the steps of plain tabu search


NEIGHBOURS = np.array([[0.0], [0.5], [1.0], [1.5]])


@pytest.mark.parametrize(
    ("tabu", "costs", "best", "chosen"),
    [
        ([[9.0]], [4.0, 3.0, 2.0, 5.0], 1.0, 2),  # nothing banned: the cheapest
        ([[1.0]], [4.0, 3.0, 2.0, 5.0], 1.0, 1),  # the cheapest is tabu
        ([[1.0]], [4.0, 3.0, 2.0, 5.0], 2.5, 2),  # aspiration: it beats the best
        ([[1.0]], [4.0, 3.0, 2.0, 5.0], 2.0, 1),  # to equal the best is not enough
        ([[0.0], [0.5], [1.0], [1.5]], [4.0, 3.0, 2.0, 5.0], 1.0, 0),  # the oldest ban goes
        ([[0.0], [0.5], [1.0], [1.5], [0.0]], [4.0, 3.0, 2.0, 5.0], 1.0, 1),  # renewed
        ([[1.05]], [4.0, 3.0, 2.0, 5.0], 1.0, 1),  # a ban is a ball, not a point
    ],
)
def test_the_tabu_list_forbids_and_aspiration_forgives(
    tabu: list[list[float]], costs: list[float], best: float, chosen: int
) -> None:
    assert admitted(NEIGHBOURS, np.array(costs), np.array(tabu), 0.1, best) == chosen


def test_aspiration_asks_for_better_than_ever_before() -> None:
    # From 0.5 (cost 5) to 0.6 (3) to 0.7 (8). There 0.6 is tabu and its 3.5 beats the 4 of the
    # last round, not the 3 of the first: on to 0.8, and the next candidates are 0.9 and 0.7.
    algorithm = TabuSearch(N=2, R=0.1, r_tabu=0.05, tenure=2)
    rng = cast("Rng", ScriptedGenerator([[0.5]], [[1.0], [0.5]], [[1.0], [0.0]]))
    moves = algorithm.moves(box([(0.0, 1.0)]), rng, silent)
    evaluated = [next(moves)]
    evaluated += [moves.send(np.array(c)) for c in ([5.0], [3.0, 9.0], [8.0, 4.0], [9.0, 3.5])]
    assert np.allclose(
        np.concatenate(evaluated)[:, 0], [0.5, 0.6, 0.5, 0.7, 0.5, 0.8, 0.6, 0.9, 0.7]
    )


@pytest.mark.parametrize(("tenure", "wanders"), [(1, False), (10, True)])
def test_tabu_search_walks_out_of_a_bowl_as_its_memory_grows(tenure: int, wanders: bool) -> None:
    # Each visited point bans 0.05 about it and a step reaches 0.1. Ten bans cover more than a
    # third of the line about the bottom, and the search has to leave it; one ban does not.
    result = minimize(
        lambda x: 100 * np.abs(x[:, 0] - 0.5),
        [(0.0, 1.0)],
        method="ts",
        budget=1 + 20 * 40,
        seed=2,
        N=20,
        R=0.1,
        r_tabu=0.05,
        tenure=tenure,
    )
    centres = [b.mean() for b in np.split(result.trace.u[:, 0], result.trace.ends[:-1])[1:]]
    furthest = np.abs(np.array(centres[10:]) - 0.5).max()
    assert (furthest > 0.18) == wanders


# --- the operators of the genetic algorithm


def test_expectation_falls_with_the_root_of_the_rank() -> None:
    share = expectation(np.array([5.0, 1.0, np.inf, 3.0]))
    root = 1 / np.sqrt([3, 1, 4, 2])
    assert np.allclose(share, root / root.sum())


@given(
    st.integers(0, 10**6), st.integers(1, 60), st.lists(st.floats(0.01, 1), min_size=1, max_size=25)
)
def test_selection_gives_each_its_expectation_within_one(
    seed: int, n: int, shares: list[float]
) -> None:
    share = np.array(shares) / np.sum(shares)
    drawn = stochastic_uniform(share, n, np.random.default_rng(seed))
    counts = np.bincount(drawn, minlength=len(share))
    assert counts.sum() == n
    assert np.all(np.abs(counts - n * share) < 1 + 1e-9)


def test_selection_mates_in_random_order() -> None:
    drawn = stochastic_uniform(np.full(50, 0.02), 50, np.random.default_rng(1))
    assert sorted(drawn) == list(range(50))
    assert list(drawn) != list(range(50))  # 1 in 50! that a shuffle does nothing


def test_scattered_crossover_takes_each_gene_from_a_parent() -> None:
    mother, father = np.zeros((4000, 3)), np.ones((4000, 3))
    child = scattered(mother, father, np.random.default_rng(4))
    assert set(np.unique(child)) == {0.0, 1.0}
    # A fair coin for every gene alone: eight patterns, 500 each; 5 sigma is 105.
    patterns = np.bincount((child @ [1, 2, 4]).astype(int), minlength=8)
    assert np.all(np.abs(patterns - 500) < 105)


def test_elites_live_and_are_not_evaluated_again() -> None:
    result = run("ga", budget=10**4, generations=30, elite=3)
    sizes = np.diff([0, *result.trace.ends])
    assert list(sizes[:31]) == [20] + [17] * 30
    assert sizes[31] == 20  # past `generations` a new population
    assert result.trace.notes[31]["event"] == "restart"


def test_children_lie_between_their_parents_or_beyond_the_better_one() -> None:
    # Two parents only: the better one at 0.4, the other at 0.6 in both coordinates.
    alive, costs = np.repeat([[0.4, 0.4], [0.6, 0.6]], 10, axis=0), np.repeat([1.0, 2.0], 10)
    between = GeneticAlgorithm(crossover=1.0, crossing="intermediate")
    children = between.children(alive, costs, 1, np.random.default_rng(0))
    assert np.all((children >= 0.4) & (children <= 0.6))
    assert np.allclose(children[:, 0], children[:, 1])
    assert 0.42 < children.mean() < 0.58
    beyond = GeneticAlgorithm(crossover=1.0, crossing="heuristic")
    children = beyond.children(alive, costs, 1, np.random.default_rng(0))
    assert set(np.round(children[:, 0], 12)) == {0.36, 0.4, 0.6}  # 0.6 + 1.2 (0.4 - 0.6), or twins


def test_the_toolbox_begins_between_0_and_1_unless_told() -> None:
    result = run("ga", budget=20, first="unit")
    first = BOWL.decode(result.trace.u)
    assert np.all((first >= 0.0) & (first <= 1.0))


def test_mutation_shrinks_to_nothing() -> None:
    ga = GeneticAlgorithm(crossover=0.0, generations=10)
    alive = np.full((20, 2), 0.5)
    spread = [
        float(ga.children(alive, np.zeros(20), g, np.random.default_rng(0)).std())
        for g in (1, 5, 9, 10)
    ]
    assert spread == sorted(spread, reverse=True)
    assert spread[-1] == 0.0


# --- the hybrid: section 2.3


def test_bts_hands_over_the_best_place_of_the_bacteria() -> None:
    result = run("bts", budget=5000, S=10, N_c=5, R=0.02)
    notes = result.trace.notes
    (k,) = [i for i, n in enumerate(notes) if n.get("event") == "hand-over"]
    assert {n["stage"] for n in notes[:k]} == {"foraging"}
    assert {n["stage"] for n in notes[k:]} == {"tabu"}
    end = result.trace.ends[k - 1]
    S0 = result.trace.u[:end][result.trace.f[:end].argmin()]
    cells = result.trace.u[end : result.trace.ends[k]]
    assert len(cells) == 40
    assert np.all(np.abs(cells - S0) <= 0.02 + 1e-12)
    assert result.trace.rounds("foraging") == 5  # N_c steps, no reproduction, no elimination


def test_the_first_of_equally_good_places_is_handed_over() -> None:
    flat: dict[str, Any] = {"method": "bts", "S": 4, "N_c": 1, "R": 1e-3, "budget": 100}
    result = minimize(lambda x: np.ones(len(x)), [(0, 1)], **flat)
    (k,) = [i for i, n in enumerate(result.trace.notes) if n.get("event") == "hand-over"]
    handed = result.trace.u[result.trace.ends[k - 1]]
    assert np.allclose(handed, result.trace.u[0], atol=1e-3)


def test_bts_forages_again_where_a_restart_is_wanted() -> None:
    result = run("bts", budget=5000, S=10, N_c=3, N=4, deadlock="restart")
    notes = result.trace.notes
    restarts = [i for i, n in enumerate(notes) if "start" in n]
    handed = [i for i, n in enumerate(notes) if n.get("event") == "hand-over"]
    assert len(restarts) > 2
    assert all(a < b for a, b in zip(restarts, handed, strict=False))
    rounds = [n["round"] for n in notes if n.get("stage") == "tabu"]
    assert rounds == list(range(1, len(rounds) + 1))  # count goes on over restarts
    first = [i for i in handed if i + 1 < len(notes)]
    assert all(notes[i]["radius"] == 0.15 for i in first)  # and the radius starts anew


def test_bts_can_start_all_cells_at_the_best_of_step_2() -> None:
    result = run("bts", budget=20, S=10, start="best", step=1e-9)
    u, f = result.trace.u, result.trace.f
    assert np.allclose(u[10:], u[:10][f[:10].argmin()], atol=1e-8)


def test_the_defaults_of_bts_are_those_of_section_4_4() -> None:
    bts = ForagingTabuSearch()
    assert (bts.S, bts.N_c, bts.N_s, bts.alpha) == (30, 20, 4, 1e3)
    assert (bts.d_attract, bts.w_attract, bts.h_repellant, bts.w_repellant) == (0.1, 0.2, 0.1, 0.1)
    assert (bts.R, bts.N, bts.count_max, bts.BT, bts.n_re_back) == (0.15, 40, 1000, 5, 5)
    assert bts.AR == ((15.0, 0.0375), (8.0, 0.0095), (3.0, 0.0025))
