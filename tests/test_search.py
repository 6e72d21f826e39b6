"""One search in progress: the loop, the record, the stops, the one-call minimisation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.random import SeedSequence

from stribeck.errors import InputError
from stribeck.optimize import (
    METHODS,
    Detailed,
    Search,
    SearchError,
    Target,
    Trace,
    configure,
    lockstep,
    minimize,
    rms,
)
from stribeck.space import Param, Space, box

if TYPE_CHECKING:
    from stribeck.optimize import Moves, Note
    from stribeck.space import Array, Rng

SQUARE = box([(-1.0, 1.0), (-1.0, 1.0)])


@dataclass(frozen=True)
class Scripted:
    """An algorithm that evaluates given batches, and returns a word."""

    batches: tuple[Any, ...]
    word: str | None = None
    name: str = "scripted"

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        del space, rng
        for k, batch in enumerate(self.batches):
            note(round=k)
            yield np.asarray(batch, dtype=float)
        return self.word


def squares(x: Array) -> Array:
    total: Array = (x**2).sum(axis=1)
    return total


def search(*batches: Any, word: str | None = None, budget: int = 100, **options: Any) -> Search:
    return Search(SQUARE, Scripted(batches, word), budget=budget, seed=0, **options)


def test_points_are_asked_in_physical_values_and_stay_until_told() -> None:
    s = search([[0.0, 0.5], [1.0, 1.0]], [[0.25, 0.75]])
    assert np.array_equal(s.ask(), [[-1.0, 0.0], [1.0, 1.0]])
    assert np.array_equal(s.ask(), s.ask())
    s.tell(np.array([1.0, 2.0]))
    assert np.array_equal(s.ask(), [[-0.5, 0.5]])


def test_last_batch_is_cut_before_it_is_evaluated() -> None:
    s = search(np.zeros((4, 2)), np.zeros((4, 2)), budget=6)
    s.tell(np.ones(4))
    assert len(s.ask()) == 2
    s.tell(np.ones(2))
    assert s.ended == "budget"
    assert s.run().evaluations == 6


def test_the_word_of_the_algorithm_is_why_it_ended() -> None:
    assert lockstep_one(search(np.zeros((1, 2)), word="count_max")).ended == "count_max"
    assert lockstep_one(search(np.zeros((1, 2)))).ended == "exhausted"


def lockstep_one(s: Search) -> Any:
    class Squares:
        name = "squares"
        space = SQUARE

        def __call__(self, x: Array, /) -> Array:
            return squares(x)

    return lockstep(Squares(), [s])[0]


def test_a_target_met_by_the_last_evaluation_is_a_target() -> None:
    s = search([[0.5, 0.5]], budget=1, stops=[Target(0.0)])
    assert lockstep_one(s).ended == "target"


@pytest.mark.parametrize("point", [[1.5, 0.0], [-0.1, 0.0], [math.nan, 0.0]])
def test_a_point_outside_the_cube_is_refused(point: Any) -> None:
    with pytest.raises(SearchError, match="outside the unit cube"):
        search([[0.5, 0.2], point, [1.0, 0.0]])


@pytest.mark.parametrize("points", [[0.5, 0.5], [[0.5]], np.empty((0, 2))])
def test_points_of_a_wrong_shape_are_refused(points: Any) -> None:
    with pytest.raises(SearchError, match="shape"):
        search(points)


def test_an_algorithm_that_asks_nothing_is_refused() -> None:
    with pytest.raises(SearchError, match="nothing"):
        search()


def test_a_search_is_not_used_after_its_end() -> None:
    s = search([[0.5, 0.5]])
    s.tell(np.array([1.0]))
    with pytest.raises(SearchError, match="ended: exhausted"):
        s.ask()
    with pytest.raises(SearchError, match="ended: exhausted"):
        s.tell(np.array([1.0]))


def test_a_run_before_any_evaluation_is_refused() -> None:
    with pytest.raises(SearchError, match="nothing yet"):
        search([[0.5, 0.5]]).run()


def test_what_is_not_finite_is_worst_and_counted() -> None:
    s = search(np.full((5, 2), 0.5))
    s.tell(np.array([math.nan, math.inf, -math.inf, 3.0, 4.0]))
    assert s.trace.failed == 3
    assert np.array_equal(s.trace.f, [math.inf, math.inf, math.inf, 3.0, 4.0])
    assert s.run().cost == 3.0


def test_costs_told_are_copied() -> None:
    @dataclass(frozen=True)
    class Writes:
        name: str = "writes"

        def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
            del note
            while True:
                costs = yield space.sample(rng, 3)
                costs[:] = -1.0

    s = Search(SQUARE, Writes(), budget=9, seed=0)
    mine = np.array([1.0, 2.0, 3.0])
    s.tell(mine)
    assert np.array_equal(mine, [1.0, 2.0, 3.0])
    assert np.array_equal(s.trace.f, [1.0, 2.0, 3.0])


def test_notes_belong_to_the_step_they_were_said_before() -> None:
    s = search([[0.0, 0.0]], [[0.1, 0.1]])
    s.tell(np.array([2.0]))
    s.tell(np.array([1.0]))
    assert s.trace.notes == [{"round": 0}, {"round": 1}]
    assert s.trace.rounds() == 2


@pytest.mark.parametrize("budget", [0, -1, 2.5, "many", None])
def test_a_budget_that_is_no_count_is_refused(budget: Any) -> None:
    with pytest.raises(InputError, match="budget"):
        search([[0.5, 0.5]], budget=budget)


@pytest.mark.parametrize("seed", [-1, "x", 1.5])
def test_a_seed_that_is_no_seed_is_refused(seed: Any) -> None:
    with pytest.raises(InputError, match="seed"):
        Search(SQUARE, configure("random"), budget=5, seed=seed)


def test_a_seed_sequence_is_a_seed_and_is_not_used_up() -> None:
    seed = SeedSequence(7, spawn_key=(1, 2))
    a, b = (minimize(squares, SQUARE, method="random", budget=50, seed=seed) for _ in range(2))
    assert np.array_equal(a.trace.u, b.trace.u)


# --- the record


@given(st.lists(st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=90), min_size=1, max_size=9))
def test_a_trace_keeps_every_cost_and_the_first_best(steps: list[list[float]]) -> None:
    trace = Trace(2)
    for k, f in enumerate(steps):
        trace.append(np.full((len(f), 2), k / 10), np.array(f))
    flat = np.concatenate(steps)
    assert np.array_equal(trace.f, flat)
    assert trace.best == int(np.argmin(flat))
    assert trace.cost == flat.min()
    assert np.array_equal(trace.convergence(), np.minimum.accumulate(flat))
    assert trace.reached(float(flat.min())) == trace.best + 1
    assert trace.reached(float(flat.min()) - 1e9) is None
    assert np.array_equal(np.diff([0, *trace.ends]), [len(f) for f in steps])
    assert np.array_equal(
        trace.u[:, 0], np.repeat(np.arange(len(steps)) / 10, np.diff([0, *trace.ends]))
    )


def test_a_trace_is_read_only() -> None:
    trace = Trace(2)
    trace.append(np.zeros((1, 2)), np.zeros(1))
    with pytest.raises(ValueError, match="read-only"):
        trace.f[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        trace.u[0, 0] = 1.0


def after_100(trace: Trace) -> str | None:
    return "enough" if len(trace) >= 100 else None


def test_a_huge_budget_costs_only_what_is_used() -> None:
    run = minimize(squares, SQUARE, method="random", budget=10**12, stops=[after_100])
    assert run.ended == "enough"


def test_rounds_are_counted_by_stage() -> None:
    trace = Trace(1)
    for note in (
        {"stage": "foraging", "round": 1},
        {"stage": "foraging"},
        {"stage": "tabu", "round": 1},
    ):
        trace.append(np.zeros((1, 1)), np.zeros(1), dict(note))
    assert (trace.rounds(), trace.rounds("tabu"), trace.rounds("foraging")) == (2, 1, 1)


FOUR_POINTS = np.arange(8.0).reshape(4, 2) / 8


# --- residuals


@dataclass(frozen=True)
class Curious:
    """An algorithm that requests the residuals of its second batch and keeps the replies."""

    sent: list[Any]
    name: str = "curious"

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        del note
        self.sent.append((yield space.sample(rng, 3)))
        answer = yield Detailed(space.sample(rng, 2))
        self.sent.append(answer)
        yield np.clip(np.full((1, 2), answer.costs.min()), 0.0, 1.0)
        return None


@dataclass(frozen=True)
class Line:
    """A problem with residuals."""

    name: str = "line"
    space: Space = SQUARE

    def __call__(self, x: Array, /) -> Array:
        return rms(self.residuals(x))

    def residuals(self, x: Array, /) -> Array:
        return np.column_stack([x[:, 0] - 0.25, 2.0 * x[:, 1] - 0.5, x.sum(axis=1)])


def curious(seed: int) -> Search:
    return Search(SQUARE, Curious([]), budget=100, seed=seed)


def test_residuals_are_sent_to_those_who_ask_for_them_and_only_then() -> None:
    searches = [curious(1), curious(2)]
    assert [r.ended for r in lockstep(Line(), searches)] == ["exhausted", "exhausted"]
    for s in searches:
        plain, answer = s.algorithm.sent  # type: ignore[attr-defined]
        x = s.space.decode(s.trace.u)
        assert np.array_equal(plain, Line()(x[:3]))
        assert np.array_equal(answer.residuals, Line().residuals(x[3:5]))
        means = [math.fsum(r * r for r in row) / 3 for row in answer.residuals.tolist()]
        assert answer.costs == pytest.approx(np.sqrt(means), rel=1e-15)


def test_a_problem_without_residuals_answers_with_costs_alone() -> None:
    s = curious(1)
    while not s.ended:
        s.tell(squares(s.ask()))
    answer = s.algorithm.sent[1]  # type: ignore[attr-defined]
    assert answer.residuals is None
    assert np.array_equal(answer.costs, squares(s.space.decode(s.trace.u[3:5])))


@pytest.mark.parametrize("shape", [(2,), (3, 4), (2, 0)])
def test_residuals_of_a_wrong_shape_are_refused(shape: tuple[int, ...]) -> None:
    @dataclass(frozen=True)
    class Wrong(Line):
        def __call__(self, x: Array, /) -> Array:
            return squares(x)

        def residuals(self, x: Array, /) -> Array:
            del x
            return np.zeros(shape)

    with pytest.raises(InputError, match=r"residuals of 2 points .* shape \(2, m >= 1\)"):
        lockstep(Wrong(), [curious(0)])


# --- stops


def test_target_is_reached_at_or_below_its_cost() -> None:
    trace = Trace(1)
    trace.append(np.zeros((1, 1)), np.array([1.0]))
    assert Target(1.0)(trace) == "target"
    assert Target(0.999)(trace) is None


def test_a_target_that_cannot_be_meant_is_refused() -> None:
    with pytest.raises(InputError):
        Target(math.nan)


def test_the_first_reason_is_kept() -> None:
    run = minimize(
        squares, SQUARE, method="random", budget=500, target=9.0, stops=[lambda _: "at once"]
    )
    assert run.ended == "target"


def test_a_finished_run_does_not_age() -> None:
    s = search([[0.5, 0.5]])
    s.tell(np.array([1.0]))
    assert s.run().seconds == s.run().seconds


# --- one call


def test_minimize_finds_a_bowl_in_a_box() -> None:
    run = minimize(lambda x: 100 * ((x - [1.0, -2.0]) ** 2).sum(axis=1), [(-5, 5), (-5, 5)], seed=3)
    assert np.allclose(run.x, [1.0, -2.0], atol=0.01)


def test_minimize_takes_a_space_and_settings() -> None:
    space = Space((Param("k", 1.0, 1e4, log=True),))
    run = minimize(
        lambda x: np.log10(x[:, 0] / 100) ** 2, space, method="ts", N=7, budget=1 + 7 * 3, seed=1
    )
    assert run.trace.ends == [1, 8, 15, 22]
    assert 1.0 <= run.x[0] <= 1e4


def test_minimize_stops_at_its_target() -> None:
    run = minimize(squares, SQUARE, method="random", budget=10_000, target=0.01)
    assert run.ended == "target"
    assert run.cost <= 0.01
    assert run.evaluations < 10_000


def test_an_unknown_method_is_told_what_exists() -> None:
    with pytest.raises(InputError, match=r"no method 'pso'.*random, ts, ats, bfo, abfo, ga, bts"):
        minimize(squares, SQUARE, method="pso")


@pytest.mark.parametrize("method", METHODS)
def test_an_unknown_setting_is_told_what_exists(method: str) -> None:
    with pytest.raises(InputError, match=rf"{method} has no setting 'swarm': it has \w+"):
        minimize(squares, SQUARE, method=method, swarm=3)


@pytest.mark.parametrize(
    "cost",
    [
        lambda x: x,  # (n, d)
        lambda x: float(x.sum()),  # a scalar
        lambda x: np.zeros(len(x) + 1),
        lambda x: np.zeros((len(x), 1)),
        lambda x: ["a"] * len(x),
        lambda x: np.zeros(len(x), dtype=complex),
        lambda x: None,  # noqa: ARG005
    ],
)
def test_a_cost_of_wrong_shape_or_kind_is_told_so(cost: Any) -> None:
    with pytest.raises(InputError, match="must be 40 real numbers"):
        minimize(cost, SQUARE, method="random", budget=40)


def test_integer_and_list_costs_are_numbers() -> None:
    run = minimize(lambda x: [1] * len(x), SQUARE, method="random", budget=40)  # type: ignore[arg-type,return-value]
    assert run.cost == 1.0
