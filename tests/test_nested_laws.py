"""A search starts from contained laws and from another loss, and ends once it is confirmed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from foreign import servo
from stribeck import RIGS
from stribeck.data.recording import Recording
from stribeck.friction import law_named
from stribeck.identify.free_constants import FreeConstantsProblem, with_free_constants
from stribeck.identify.loss import Loss, Objective
from stribeck.identify.multistart import Optimum, multistart
from stribeck.identify.nested_answers import contained, descended, nested_answers
from stribeck.identify.other_loss import other_loss_violations
from stribeck.identify.parameters import partition
from stribeck.identify.polish import polish
from stribeck.identify.problem import MotionProblem
from stribeck.identify.refined_answer import no_worse
from stribeck.identify.refinement import Refined, explored, turned
from stribeck.identify.score import scores
from stribeck.identify.search_settings import QUIET_ROUGH, SearchSettings
from stribeck.identify.segment import segments
from stribeck.identify.selection.nesting import carried, placed
from stribeck.identify.uncertainty.estimates import Estimate, without_partners
from stribeck.identify.valley import along_valley
from stribeck.optimize import Search, rms
from stribeck.rig.simulated import as_simulated
from stribeck.space import Array, box

RIG = RIGS["servo-pendulum"]
AXIS = servo.Servo(kp=300.0, q_offset=0.02)
PLAIN = servo.Bam(0.03, 0.008)
LOADED = servo.Bam(0.01, 0.008, 0.02, 0.8, 1.3, 0.15, 0.15, 0.1, 0.1)


def log_of(bam: servo.Bam, seed: int = 0, noise: float = 5e-4) -> Recording:
    """Two sines of the goal, then a free swing."""
    t = np.arange(0.0, 4.0, 0.01)
    goal = 1.1 * np.sin(2.5 * t) + 0.3 * np.sin(9.0 * t)
    enabled = (t < 3.0).astype(float)
    q = servo.simulate(AXIS, bam, t, goal, enabled).position
    q = q + noise * np.random.default_rng(seed).standard_normal(len(t))
    return Recording(
        t=t, position=q, command=goal, rotary=True,
        extra={"torque_enable": enabled, "kp": np.full_like(t, AXIS.kp)},
    )  # fmt: skip


def problem_of(law: str, log: Recording, loss: Loss = "squares", **fixed: float) -> MotionProblem:
    parameters = partition(RIG, law_named(law), fixed=fixed, objective=Objective(loss))
    return MotionProblem(parameters, segments([log], as_simulated(RIG), None))


def test_a_law_contains_those_with_a_part_of_its_ingredients() -> None:
    def names(law: str) -> list[str]:
        return [p.law.name for p in contained(partition(RIG, law_named(law)))]

    assert names("coulomb-viscous") == []
    assert names("bam-m4") == ["coulomb-viscous", "bam-m3", "stribeck"]  # its exponent free
    assert names("bam-m6")[-2:] == ["bam-m4", "bam-m5"]


def test_a_contained_law_keeps_ranges_and_values() -> None:
    rich = partition(RIG, law_named("bam-m4"), bounds={"K_c": (0.0, 0.4)}, fixed={"q_offset": 10.0})
    simple = contained(rich)[0]
    ranges = {q.name: (q.lower, q.upper) for q in simple.free}
    assert ranges["F_C"] == (0.0, 0.4)
    assert "q_offset" not in ranges
    assert simple.fixed["q_offset"] == pytest.approx(0.01)


def test_answers_of_contained_laws_cost_the_same_in_the_richer_one() -> None:
    log = log_of(PLAIN)
    rich = problem_of("bam-m4", log)
    costs = []

    def solve(simple: MotionProblem) -> Refined:
        x = simple.space.decode(np.full((1, simple.space.dim), 0.4))[0]
        costs.append(float(simple(x[None])[0]))
        return Refined(x, costs[0], 1, None)

    points, spent = nested_answers(rich, solve)
    assert len(costs) == 1  # the others start from there
    assert len(points) == 3
    assert spent > 1
    # A law that feels the load takes it from a second pass of each step: other rounding.
    assert rich(points[0][None])[0] == pytest.approx(costs[0], rel=1e-6)
    assert (rich(np.array(points)) <= costs[0] * (1 + 1e-6)).all()


class Drop:
    """A drop of friction that helps above a speed, and below it makes things worse."""

    orders: tuple[tuple[int, int], ...] = ()

    def __init__(self) -> None:
        self.space = box([(0.0, 1.0), (0.0, 1.0)])

    def residuals(self, x: Array, /) -> Array:
        drop, speed = np.asarray(x).T
        return np.stack([1.0 + drop * (0.5 - speed), 0.1 * drop, 0.1 + 0.0 * drop], axis=1)

    def __call__(self, x: Array, /) -> Array:
        return rms(self.residuals(x))

    def by_other_loss(self) -> Drop:
        return self


def test_a_drop_that_is_nil_in_a_contained_law_is_looked_for_at_several_speeds() -> None:
    problem: Any = Drop()
    start = np.array([0.0, 0.3])
    stuck = polish(problem, start, None, 100)
    assert stuck.x == pytest.approx(start)
    assert descended(problem, [start]).x == pytest.approx([1.0, 1.0])


@pytest.mark.parametrize("seed", [0, 3])
def test_a_law_is_never_worse_than_one_it_contains(seed: int) -> None:
    """A budget that does not suffice to search in eleven dimensions."""
    log = log_of(LOADED)
    settings = SearchSettings(seed=seed, budget=250, repeats=1)
    ends = {law: multistart(problem_of(law, log), settings) for law in ("bam-m3", "bam-m4")}
    costs = {law: float(o.problem(o.x[None])[0]) for law, o in ends.items()}
    assert costs["bam-m4"] <= costs["bam-m3"] * (1 + 1e-3)


def traces(law: str, settings: SearchSettings) -> tuple[Optimum, dict[int, list[Array]]]:
    """A search, and the misfits that the repeats met, for each number of dimensions."""
    met: dict[int, list[Array]] = {}

    def note(searches: Sequence[Search]) -> None:
        met[searches[0].space.dim] = [s.trace.f.copy() for s in searches]

    return multistart(problem_of(law, log_of(LOADED), "absolute"), settings, note), met


def test_a_law_of_many_parameters_starts_where_the_richest_that_it_contains_ends() -> None:
    """That one is searched as by itself, at the same evaluations, and what follows only lowers."""
    settings = SearchSettings(seed=1, budget=250, repeats=1)
    simple, alone = traces("bam-m4", settings)
    rich, within = traces("bam-m5", settings)
    assert set(within) == {13, *alone}
    for dim, repeats in alone.items():
        for one, other in zip(repeats, within[dim], strict=True):
            assert np.array_equal(one, other)
    assert rich.search.evaluations > simple.search.evaluations
    least = float(simple.problem(simple.x[None])[0])
    assert float(rich.problem(rich.x[None])[0]) <= least * (1 + 1e-6)


def test_a_known_answer_is_kept_where_no_evaluations_are_left() -> None:
    """On fewer samples, and with a higher knee of the loss, another place may be lower."""
    problem = problem_of("bam-m5", log_of(LOADED), "absolute")
    finest = problem.finer()
    x = np.array([*LOADED[:9], AXIS.k_t, AXIS.R, AXIS.armature, AXIS.q_offset])
    known = polish(finest, x, None, 400)
    answer = Refined(x, float(finest(x[None])[0]), 0)
    assert known.cost < answer.cost
    end = no_worse(finest, answer, [known.x], 0)
    assert float(finest(end.x[None])[0]) <= known.cost * (1 + 1e-9)


def test_a_search_that_is_stopped_amid_a_contained_law_has_what_that_has() -> None:
    log = log_of(LOADED)
    simple, met = problem_of("bam-m4", log), []

    def stop(searches: Sequence[Search]) -> None:
        if searches[0].space.dim == simple.space.dim and len(searches[0].trace) > 300:
            met.append(searches[0].run().x)
            raise KeyboardInterrupt

    end = multistart(problem_of("bam-m5", log), SearchSettings(budget=350, repeats=1), stop)
    assert end.interrupted
    (x,) = met
    cost = float(end.problem(end.x[None])[0])
    assert cost <= float(simple(x[None])[0]) * (1 + 1e-6)
    own = float(end.problem(end.search.runs[0].x[None])[0])  # its search had fewer samples
    assert cost <= own * (1 + 1e-6)


def test_an_answer_beyond_the_default_ranges_is_carried_over_in_wider_ones() -> None:
    log = log_of(LOADED)
    simple, rich = problem_of("bam-m4", log), problem_of("bam-m5", log)
    beyond = {q.name: 3.0 * q.upper for q in simple.space.params if q.name in {"K_l", "armature"}}
    x = simple.space.decode(np.full((1, simple.space.dim), 0.4))[0]
    x = np.array([beyond.get(n, v) for n, v in zip(simple.space.names, x, strict=True)])
    p = simple.parameters.full(x[None])[0]
    (clipped,) = carried(simple.parameters, p, rich.parameters)
    wider = rich.parameters.reaching(placed(simple.parameters, p, rich.parameters))
    (point,) = carried(simple.parameters, p, wider)
    cost = float(simple(x[None])[0])
    assert float(rich(clipped[None])[0]) != pytest.approx(cost, rel=0.01)
    assert float(rich.over(wider)(point[None])[0]) == pytest.approx(cost, rel=1e-6)
    widths = {q.name: q.upper for q in wider.free}
    assert widths["K_m"] >= beyond["K_l"]
    assert widths["K_c"] == rich.parameters.free[0].upper  # what holds it stays


def test_a_range_of_the_users_own_is_kept_though_an_answer_lies_beyond() -> None:
    own = partition(RIG, law_named("bam-m5"), bounds={"K_m": (0.0, 0.2)})
    x = own.middle
    places = {q.name: k for k, q in enumerate(own.free)}
    x[[places["K_m"], places["K_e"]]] = 50.0
    ranges = {q.name: (q.lower, q.upper) for q in own.reaching(x).free}
    assert ranges["K_m"] == (0.0, 0.2)
    assert ranges["K_e"][1] >= 50.0


def test_a_law_of_many_parameters_has_one_repeat_beside_the_laws_that_it_contains() -> None:
    optimum = multistart(problem_of("bam-m4", log_of(LOADED)), SearchSettings())
    (run,) = optimum.search.runs
    cost = float(optimum.problem(optimum.x[None])[0])
    assert cost < 0.55  # mrad; the noise is 0.5
    assert run.evaluations < 0.5 * optimum.search.evaluations


def test_repeats_end_once_they_confirm_each_other() -> None:
    log = log_of(PLAIN)
    optimum = multistart(problem_of("coulomb-viscous", log), SearchSettings())
    assert [run.ended for run in optimum.search.runs] == ["confirmed"] * 2
    assert optimum.search.evaluations < 800
    assert float(optimum.problem(optimum.x[None])[0]) < 0.55  # mrad; the noise is 0.5


def test_three_repeats_confirm_a_misfit_beyond_the_noise() -> None:
    """The law leaves out what the load does to the friction: a better minimum may be elsewhere."""
    optimum = multistart(problem_of("coulomb-viscous", log_of(LOADED)), SearchSettings())
    costs = np.array([run.cost for run in optimum.search.runs])
    assert costs.min() > 2.0  # mrad; the noise is 0.5
    assert np.count_nonzero(costs < 1.01 * costs.min()) >= 3


def test_a_repeat_that_has_confirmed_an_answer_waits_for_the_others() -> None:
    """Those that agreed first ask for nothing while the third one looks for the same."""
    problem = problem_of("coulomb-viscous", log_of(LOADED))
    runs = multistart(problem, SearchSettings()).search.runs
    best = min(run.cost for run in runs)
    agreed = [run for run in runs if run.ended == "confirmed" and run.cost < 1.01 * best]
    assert len(agreed) >= 3
    quiet = QUIET_ROUGH * problem.space.dim
    for run in agreed:
        batch = int(np.diff(run.trace.ends).max())
        assert len(run.trace) - (run.trace.reached(1.01 * best) or 0) < quiet + batch


class Hollows:
    """A misfit with hollows that another loss does not have."""

    def __init__(self, depth: float) -> None:
        self.space = box([(-3.0, 3.0)])
        self._depth = depth

    def residuals(self, x: Array, /) -> Array:
        u = np.asarray(x)[:, :1] - 1.0
        return np.hstack([u, self._depth * (1 - np.cos(12.0 * u)), np.full_like(u, 0.01)])

    def __call__(self, x: Array, /) -> Array:
        return rms(self.residuals(x))

    def by_other_loss(self) -> Hollows:
        return Hollows(0.0)


def test_the_other_loss_leads_out_of_a_hollow() -> None:
    problem: Any = Hollows(0.5)
    start = np.array([1.0 - 2 * np.pi / 12 * 2])
    there = turned(problem, start, float(problem(start[None])[0]), 60)
    assert there.x == pytest.approx([1.0], abs=1e-4)
    assert there.other == pytest.approx([1.0], abs=1e-4)


class Valley:
    """Two parameters that replace each other, on a floor with a hollow at every 0.25 of one."""

    orders: tuple[tuple[int, int], ...] = ()

    def __init__(self, lowest: float) -> None:
        self.space, self.rows = box([(0.0, 2.0), (0.0, 1.0)]), 0
        self._lowest = lowest

    def residuals(self, x: Array, /) -> Array:
        self.rows += len(x)
        a, b = np.asarray(x).T
        bend = np.sin(2.0 * a)
        rough = 0.2 * np.cos(8.0 * np.pi * (a - self._lowest))
        off = a - self._lowest
        return np.stack([30.0 * (b - 0.4 - 0.3 * bend), off, rough - 0.2, 0.5 + 0 * a], axis=1)

    def __call__(self, x: Array, /) -> Array:
        return rms(self.residuals(x))

    def widened(self, x: Array) -> None:
        """No range is wider."""


@pytest.mark.parametrize("lowest", [0.5, 1.5])
def test_a_walk_along_a_valley_leads_to_its_lowest_minimum(lowest: float) -> None:
    problem: Any = Valley(lowest)
    start = polish(problem, np.array([1.0, 0.67]), None, 60)  # a minimum, and not the lowest
    assert abs(start.x[0] - lowest) > 0.4
    again = turned_nowhere(problem, start.x)
    assert again == pytest.approx(start.x, abs=1e-3)
    before = problem.rows
    end = along_valley(problem, start.x, start.cost, 400)
    assert end.x[0] == pytest.approx(lowest, abs=1e-3)
    assert end.cost == pytest.approx(0.25, rel=1e-3)
    assert end.evaluations == problem.rows - before <= 400


def turned_nowhere(problem: Any, x: Array) -> Array:
    """Where a descent from beside a minimum ends."""
    return polish(problem, x + 0.01, None, 60).x


def test_a_valley_is_walked_as_far_as_evaluations_go() -> None:
    problem: Any = Valley(1.5)
    start = polish(problem, np.array([1.0, 0.67]), None, 60)
    before = problem.rows
    end = along_valley(problem, start.x, start.cost, 12)
    assert problem.rows - before <= 12
    assert end.cost <= start.cost


class DeepValley(Valley):
    """The same with eight more parameters, which all have their minimum at 0.3."""

    def __init__(self, lowest: float) -> None:
        super().__init__(lowest)
        self.space = box([(0.0, 2.0), *[(0.0, 1.0)] * 9])

    def residuals(self, x: Array, /) -> Array:
        x = np.asarray(x)
        return np.concatenate([super().residuals(x[:, :2]), 20.0 * (x[:, 2:] - 0.3)], axis=1)

    def by_other_loss(self) -> DeepValley:
        """Squares have their minima where absolute errors have theirs."""
        return self


@pytest.mark.parametrize("lowest", [0.25, 1.75])
def test_in_many_dimensions_a_valley_is_walked_before_an_evolution_strategy(lowest: float) -> None:
    problem: Any = DeepValley(lowest)
    start = polish(problem, np.array([2.0 - lowest, 0.67, *[0.3] * 8]), None, 300)
    assert abs(start.x[0] - lowest) > 0.4  # a minimum, and not the lowest
    best = Refined(start.x, start.cost, 5)
    least = 0.5 / np.sqrt(12)
    ended = [explored(problem, best, seed, 9_000, valley=True)[1].cost for seed in range(3)]
    assert ended == pytest.approx([least] * 3, rel=1e-4)
    without = [explored(problem, best, seed, 9_000, valley=False)[1].cost for seed in range(3)]
    assert max(without) > 1.01 * least  # an evolution strategy alone may stay in its hollow
    before = problem.rows
    _, end = explored(problem, best, 0, 2_000, valley=True)
    assert end.evaluations == problem.rows - before + 5 <= 2_005


class NarrowValley(DeepValley):
    """The same, in a range that may be made wider, and its rows are those of the wider ones."""

    def __init__(self, lowest: float, upper: float) -> None:
        super().__init__(lowest)
        self.upper, self.wider = upper, list[NarrowValley]()
        self.space = box([(0.0, upper), *[(0.0, 1.0)] * 9])

    def widened(self, x: Array) -> NarrowValley | None:  # type: ignore[override]
        """In twice the range, where a point is at its end."""
        if x[0] < (1 - 1e-3) * self.upper:
            return None
        self.wider.append(NarrowValley(self._lowest, 2 * self.upper))
        return self.wider[-1]

    @property
    def every(self) -> int:
        return self.rows + sum(wide.every for wide in self.wider)


@pytest.mark.parametrize(("lowest", "upper", "end"), [(1.75, 1.0, 2.0), (0.75, 0.25, 1.0)])
def test_a_valley_is_followed_beyond_a_default_range(
    lowest: float, upper: float, end: float
) -> None:
    """From a minimum amid the range, whose valley falls towards its end and on from there."""
    problem: Any = NarrowValley(lowest, upper)
    start = polish(problem, np.array([0.4 * upper, 0.55, *[0.3] * 8]), None, 300)
    assert start.x[0] < 0.9 * upper
    assert problem.widened(start.x) is None
    rows = problem.every
    wide, best = explored(problem, Refined(start.x, start.cost, 7), 0, 9_000, valley=True)
    assert best.x[0] == pytest.approx(lowest, abs=1e-3)
    assert best.cost == pytest.approx(0.5 / np.sqrt(12), rel=1e-4)
    assert wide.space.params[0].upper == end
    assert best.evaluations == problem.every - rows + 7


def judged(problem: MotionProblem, x: Array, share: float) -> list[Estimate]:
    """Estimates with intervals of a share of the value to either side."""
    p, nan = problem.parameters.full(x[None])[0], float("nan")
    rows = zip(problem.parameters.every, p.tolist(), (share * np.abs(p)).tolist(), strict=True)
    return [Estimate(q.name, v, nan, nan, v - h, v + h, None, "identified", "") for q, v, h in rows]


@pytest.mark.parametrize(
    ("bam", "leaves"), [(servo.Bam(0.01, 0.008, 0.06, 0.5, 1.0), True), (PLAIN, False)]
)
def test_an_interval_that_another_loss_leaves_is_told(bam: servo.Bam, leaves: bool) -> None:
    """Friction that drops with speed, by a law without a drop; and by one that is right."""
    problem = problem_of("coulomb-viscous", log_of(bam))
    start = np.array([0.03, 0.008, 0.4, 4.0, 1e-3, 0.02])
    x = polish(problem, start, float(problem(start[None])[0]), 150).x
    violations, _ = other_loss_violations(problem, x, judged(problem, x, 0.05))
    assert bool(violations) == leaves
    for violation in violations:
        assert violation.condition == "model"
        assert violation.parameters
        assert 'loss="absolute" puts' in violation.sentence
        assert not other_loss_violations(problem, x, judged(problem, x, 10.0))[0]


def test_constants_that_were_estimated_are_so_by_the_other_loss() -> None:
    """Then the answer is another than with the constants held."""
    problem = problem_of("coulomb-viscous", log_of(servo.Bam(0.01, 0.008, 0.06, 0.5, 1.0)))
    start = np.array([0.03, 0.008, 0.4, 4.0, 1e-3, 0.02])
    whole, x, _ = with_free_constants(problem, start)
    assert isinstance(whole, FreeConstantsProblem)
    left, _ = other_loss_violations(whole, x, judged(problem, start, 1e-9))
    held, _ = other_loss_violations(problem, start, judged(problem, start, 1e-9))
    assert left
    assert left[0].sentence != held[0].sentence


def test_what_is_known_only_with_an_unknown_is_not_identified() -> None:
    problem = problem_of("coulomb-viscous", log_of(PLAIN))
    x = np.array([0.03, 0.008, 0.4, 4.0, 1e-3, 0.02])
    known = judged(problem, x, 0.01)
    known[3] = replace(known[3], verdict="not identifiable")  # R
    correlation = np.eye(6)
    correlation[2, 3] = correlation[3, 2] = -0.98  # with k_t
    after = without_partners(problem.parameters, known, correlation)
    assert [e.verdict for e in after].count("identified") == 4
    assert (after[2].verdict, after[2].reason) == ("weak", "rests on another")


def test_progress_shows_what_the_result_reports() -> None:
    log = log_of(PLAIN)
    absolute = partition(RIG, law_named("coulomb-viscous"), objective=Objective("absolute"))
    problem = MotionProblem(absolute, segments([log], as_simulated(RIG), None))
    (search,) = SearchSettings().searches(problem, smooth=True, n=1)
    for _ in range(3):
        x = search.ask()
        search.tell(problem(x), problem.residuals(x))
    best = search.run().x
    score = scores(absolute, absolute.full(best[None])[0], problem.train)
    assert score.name == "position_mae"
    assert search.shown == pytest.approx(score.value, rel=1e-9)
    assert search.shown != pytest.approx(search.trace.cost, rel=0.01)
