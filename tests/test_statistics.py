"""Statistics of a campaign's runs: by hand, by published numbers, by simulation."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import stats

from stribeck.bench.comparison import (
    a12,
    compare,
    compare_over_problems,
    holm,
    rank_sum,
    scores,
    signed_rank,
)
from stribeck.bench.record import Job, Record, Steps
from stribeck.bench.running_time import ert
from stribeck.bench.statistics import (
    TARGETS,
    area,
    cells,
    convergence,
    ecdf,
    hits,
    limits_of,
    precision,
    problems_of,
    profile,
    ratios,
    success_rate,
    wilson,
)
from stribeck.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

INF = math.inf


def run(
    steps: Sequence[tuple[int, float]],
    repeat: int = 0,
    *,
    problem: str = "BF",
    by: str = "ats",
    dim: int = 1,
    budget: int = 100,
    target: float | None = 1.0,
    minimum: float | None = 0.0,
    spent: int | None = None,
    ended: str = "budget",
    instance: int | None = None,
) -> Record:
    """A record whose best costs were reached at the evaluations of `steps`."""
    surface: dict[str, Any] = {"surface": problem, "twin": instance}
    job = Job(problem, by, repeat, 1, budget, target, minimum, surface, {"name": by})
    at, costs = np.array([e for e, _ in steps], dtype=np.int64), np.array([c for _, c in steps])
    return Record(
        job=job,
        x=(0.5,) * dim,
        cost=float(costs[-1]) if len(costs) else INF,
        evaluations=budget if spent is None else spent,
        ended=ended,
        failed=0,
        rounds={"": 1},
        events={},
        steps=Steps(at, np.arange(len(at), dtype=np.int64), costs),
    )


def hit_at(evaluations: int, repeat: int, **options: Any) -> Record:
    return run([(1, 9.0), (evaluations, 0.5)], repeat, spent=evaluations, ended="target", **options)


def miss(cost: float, repeat: int, **options: Any) -> Record:
    return run([(1, cost)], repeat, **options)


#: The evaluation at which a run met its target, or its final cost.
ends = st.one_of(st.integers(2, 100), st.floats(1.5, 9.0))
some_runs = st.lists(ends, min_size=1, max_size=12).map(
    lambda last_steps: [
        hit_at(end, k) if isinstance(end, int) else miss(end, k) for k, end in enumerate(last_steps)
    ]
)


class TestSuccess:
    @pytest.mark.parametrize(
        ("successes", "runs", "low", "high"),
        [
            (8, 10, 0.4901625, 0.9433178),
            (0, 10, 0.0, 0.2775328),
            (10, 10, 0.7224672, 1.0),
            (81, 263, 0.2553, 0.3662),  # Newcombe 1998, table I
        ],
    )  # fmt: skip
    def test_wilson_interval_of_known_cases(
        self, successes: int, runs: int, low: float, high: float
    ) -> None:
        rate = wilson(successes, runs)
        assert (rate.value, rate.low, rate.high) == pytest.approx(
            (successes / runs, low, high), abs=5e-5
        )

    def test_wilson_is_where_the_score_test_just_rejects(self) -> None:
        z = stats.norm.ppf(0.975)
        rate = wilson(3, 17)
        for end in (rate.low, rate.high):
            assert abs(3 / 17 - end) == pytest.approx(z * math.sqrt(end * (1 - end) / 17))

    def test_no_target_is_no_success_rate(self) -> None:
        assert math.isnan(success_rate([miss(2.0, 0, target=None)]).value)
        assert math.isnan(ert([miss(2.0, 0, target=None)]).value)
        assert math.isnan(wilson(0, 0).value)


class TestRunningTime:
    def test_by_hand_and_an_early_end_counts_what_it_spent(self) -> None:
        runs = [hit_at(10, 0), hit_at(30, 1), miss(2.0, 2, spent=20, ended="count_max")]
        assert ert(runs).value == (10 + 30 + 20) / 2

    def test_evaluations_after_the_target_in_the_same_batch_do_not_count(self) -> None:
        assert ert([run([(7, 0.5)], spent=40, ended="target")]).value == 7.0

    def test_a_precision_of_its_own(self) -> None:
        runs = [run([(5, 3.0), (50, 0.1)], k, minimum=1.0) for k in range(2)]
        assert ert(runs, 2.0).value == 5.0
        assert ert(runs, 1e-9).value == 50.0  # 0.1 lies below the minimum that was declared

    def test_no_success_is_infinite_with_a_finite_lower_end(self) -> None:
        never = ert([miss(2.0, k) for k in range(10)])
        p = wilson(0, 10).high
        assert (never.value, never.high) == (INF, INF)
        assert never.low == pytest.approx(100 * (1 - p) / p)

    def test_few_successes_leave_the_upper_end_open(self) -> None:
        estimate = ert([hit_at(10, 0), *(miss(2.0, k) for k in range(1, 8))])
        assert estimate.value == 710.0
        assert estimate.low < 710.0
        assert estimate.high == INF

    @given(some_runs, st.randoms())
    @settings(max_examples=20)
    def test_the_order_of_the_runs_changes_no_bit(self, runs: list[Record], random: Any) -> None:
        before = ert(runs), area(runs)
        random.shuffle(runs)
        assert repr((ert(runs), area(runs))) == repr(before)

    def test_the_interval_covers(self) -> None:
        """Seed 5, 300 campaigns of 40 runs, success 0.7, times uniform on 1..59.

        Were the coverage 95 %, a count outside 272..297 would have a chance of 7e-4.
        """
        rng = np.random.default_rng(5)
        truth = (0.7 * 30 + 0.3 * 100) / 0.7
        covered = 0
        for _ in range(300):
            ok, times = rng.random(40) < 0.7, rng.integers(1, 60, 40)
            runs = [
                run([(int(t), 0.5)], k, spent=int(t)) if s else miss(2.0, k)
                for k, (s, t) in enumerate(zip(ok, times, strict=True))
            ]
            estimate = ert(runs)
            covered += estimate.low <= truth <= estimate.high
        assert 272 <= covered <= 297


class TestCells:
    def test_jobs_set_order_and_leave_out_strangers(self) -> None:
        mine = [
            hit_at(9, k, problem=p, by=a) for p in ("Z", "A") for a in ("b", "a") for k in (1, 0)
        ]
        jobs = [r.job for r in mine] + [miss(1.0, 0, problem="C").job]
        grouped = cells([*mine[::-1], miss(1.0, 7, problem="D")], jobs)
        assert problems_of(grouped) == ["Z", "A", "C"]
        assert grouped["C", "ats"] == []
        assert [r.job.repeat for r in grouped["Z", "b"]] == [0, 1]
        assert list(cells(mine)) == sorted(grouped)[:2] + sorted(grouped)[3:]

    def test_two_campaigns_in_one_are_refused(self) -> None:
        assert len(cells([miss(1.0, 0), miss(1.0, 0)])["BF", "ats"]) == 1
        with pytest.raises(InputError, match="ats on BF: some repeat is there twice"):
            cells([miss(1.0, 0), miss(1.0, 0, budget=200)])


class TestCurves:
    # two runs in 2 dimensions, three targets: 10 at 4 and 20, 1 at 8 and never, 0.1 never
    RUNS = (
        run([(4, 5.0), (8, 1.0)], 0, dim=2, budget=200),
        run([(2, 50.0), (20, 2.0)], 1, dim=2, budget=200),
    )
    AIMS = np.array([10.0, 1.0, 0.1])

    def test_hits_by_hand(self) -> None:
        assert hits(self.RUNS[0], self.AIMS).tolist() == [4.0, 8.0, INF]
        assert hits(run([]), self.AIMS).tolist() == [INF] * 3
        lifted = run([(3, 6.0)], minimum=5.0)
        assert hits(lifted, self.AIMS).tolist() == [3.0, 3.0, INF]
        assert precision(lifted) == 1.0

    def test_ecdf_by_hand(self) -> None:
        curve = ecdf(self.RUNS, self.AIMS)
        assert curve.at.tolist() == [2.0, 4.0, 10.0]
        assert curve.share == pytest.approx([1 / 6, 2 / 6, 3 / 6])

    def test_area_by_hand_is_the_area_under_the_curve(self) -> None:
        curve = ecdf(self.RUNS, self.AIMS)
        edges = np.log10([*curve.at, 100.0])
        under = float(np.diff(edges) @ curve.share) / 2
        by_hand = ((2 - math.log10(2)) + (2 - math.log10(4)) + (2 - 1)) / 2 / 6
        assert area(self.RUNS, self.AIMS).value == pytest.approx(by_hand)
        assert under == pytest.approx(by_hand)

    def test_every_problem_weighs_the_same(self) -> None:
        records = [hit_at(10, k) for k in range(9)] + [miss(2.0, 0, problem="SF")]
        curve = ecdf(records, np.array([1.0]))
        assert curve.share.tolist() == pytest.approx([0.5])
        assert area(records, np.array([1.0])).value == pytest.approx(0.5 * (1 - 1 / 2))

    def test_targets_by_problem_and_limits_by_the_least_budget(self) -> None:
        runs = [hit_at(10, 0), hit_at(10, 1, budget=1000, problem="SF"), miss(2.0, 2, problem="SF")]
        assert limits_of(runs) == {"BF": 100.0, "SF": 100.0}
        only = {"BF": np.array([0.5]), "SF": np.array([0.5])}
        assert ecdf(runs, only).share[-1] == pytest.approx(0.75)
        assert ecdf(runs, {"BF": np.array([0.5])}).share[-1] > 0.5

    def test_the_default_targets_are_those_of_bbob(self) -> None:
        assert len(TARGETS) == 51
        assert np.allclose(np.diff(np.log10(TARGETS)), -0.2)

    @given(some_runs)
    @settings(max_examples=30)
    def test_ecdf_rises_and_stays_a_share(self, runs: list[Record]) -> None:
        curve = ecdf(runs)
        assert (np.diff(curve.at) > 0).all()
        assert (np.diff(curve.share) > 0).all()
        assert not len(curve.share) or 0 < curve.share[0] <= curve.share[-1] <= 1
        estimate = area(runs)
        assert 0 <= estimate.value <= 1
        assert len(runs) == 1 or 0 <= estimate.low <= estimate.high <= 1

    def test_the_interval_of_the_area_is_that_of_a_mean_of_runs(self) -> None:
        runs = [hit_at(k + 2, k) for k in range(50)]
        gains = 1 - np.log10([r.evaluations for r in runs]) / 2
        ends = stats.t.interval(0.95, 49, gains.mean(), stats.sem(gains))
        estimate = area(runs, np.array([1.0]))
        assert estimate.value == pytest.approx(gains.mean())
        assert (estimate.low, estimate.high) == pytest.approx(ends, abs=0.1 * (ends[1] - ends[0]))

    def test_one_run_has_no_interval(self) -> None:
        assert math.isnan(area([hit_at(5, 0)]).high)
        assert math.isnan(ert([hit_at(5, 0)]).high)

    def test_nothing_to_integrate_says_nothing(self) -> None:
        assert math.isnan(area([]).value)
        assert math.isnan(area([miss(2.0, 0, budget=2, dim=2)]).value)
        assert len(ecdf([]).at) == 0

    def test_convergence_keeps_the_last_value(self) -> None:
        runs = [
            run([(1, 8.0), (5, 4.0)], 0),
            run([(2, 6.0)], 1, spent=3, ended="count_max"),
            run([(1, 9.0), (10, 1.0)], 2),
        ]
        low, middle, high = convergence(runs, [1, 2, 5, 100])
        assert middle.tolist() == [9.0, 8.0, 6.0, 4.0]
        assert low.tolist() == [8.0, 6.0, 4.0, 1.0]
        assert high.tolist() == [INF, 9.0, 9.0, 6.0]
        assert convergence(runs, [0, 1], over="rounds")[1].tolist() == [8.0, 4.0]
        even = convergence(runs[:2], [1, 100])
        assert even[1].tolist() == [INF, 5.0]
        shifted = [run([(1, 8.0)], minimum=3.0)]
        assert convergence(shifted, [1], above_minimum=True)[1].tolist() == [5.0]

    def test_profile_by_hand(self) -> None:
        times = [[10.0, 20.0], [30.0, 10.0], [INF, 5.0], [INF, INF], [math.nan, 1.0]]
        assert ratios(times).tolist() == [[1.0, 2.0], [3.0, 1.0], [INF, 1.0], [INF, INF]]
        first, second = profile(times)
        assert (first.at.tolist(), first.share.tolist()) == ([1.0, 3.0], [0.25, 0.5])
        assert (second.at.tolist(), second.share.tolist()) == ([1.0, 2.0], [0.5, 0.75])


class TestRanks:
    def test_a_success_beats_a_failure_and_ties_share(self) -> None:
        mine, theirs = scores(
            [hit_at(10, 0), miss(3.0, 1), hit_at(90, 2)], [hit_at(10, 0), miss(1.5, 1)]
        )
        assert mine.tolist() == [1.5, 5.0, 3.0]
        assert theirs.tolist() == [1.5, 4.0]

    def test_pairs_only_where_the_instance_changes(self) -> None:
        def compared(*instances: int | None) -> Any:
            ours, their = ([hit_at(9 + k + s, k, instance=i) for k, i in enumerate(instances)]
                           for s in (0, 50))  # fmt: skip
            return compare(ours, their[::-1])

        assert not compared(None, None, None, None).paired
        assert not compared(3, 3, 3, 3).paired
        by_instance = compared(0, 1, 2, 3)
        assert by_instance.paired
        assert by_instance.p == 2 / 2**4
        assert compared(None, None, None, None).p == pytest.approx(2 / math.comb(8, 4))

    def test_other_instances_are_no_pairs_and_lone_repeats_drop_out(self) -> None:
        ours = [hit_at(9 + k, k, instance=k) for k in range(5)]
        unmatched = [hit_at(9 + k, k, instance=k + 1) for k in range(5)]
        assert not compare(ours, unmatched).paired
        assert compare(ours, ours[2:]).runs == (3, 3)
        assert math.isnan(compare(ours, []).p)

    def test_pairing_sees_through_hard_and_easy_instances(self) -> None:
        ours = [hit_at(100 * 2**k, k, instance=k, budget=10**6) for k in range(10)]
        their = [hit_at(110 * 2**k, k, instance=k, budget=10**6) for k in range(10)]
        equal = [hit_at(r.evaluations, k, budget=10**6) for k, r in enumerate(ours)]
        level = [hit_at(r.evaluations, k, budget=10**6) for k, r in enumerate(their)]
        assert compare(ours, their).p == 2 / 2**10
        assert compare(equal, level).p > 0.5

    @given(st.lists(st.integers(-5, 5), min_size=1, max_size=9))
    @settings(max_examples=40)
    def test_signed_rank_counts_every_sign(self, d: list[int]) -> None:
        assume(any(d))
        ranks = stats.rankdata(np.abs(d))[np.array(d) != 0]
        observed = stats.rankdata(np.abs(d))[np.array(d) > 0].sum()
        sums = [sum(itertools.compress(ranks, signs)) for signs in
                itertools.product((0, 1), repeat=len(ranks))]  # fmt: skip
        half = ranks.sum() / 2
        by_hand = np.mean([abs(s - half) >= abs(observed - half) for s in sums])
        assert signed_rank(d) == pytest.approx(float(by_hand))

    def test_signed_rank_agrees_with_scipy(self) -> None:
        rng = np.random.default_rng(3)
        d = rng.normal(0.4, 1, 30)
        assert signed_rank(d) == pytest.approx(float(stats.wilcoxon(d, method="exact").pvalue))
        differences = rng.normal(0.1, 1, 150)
        assert signed_rank(differences) == pytest.approx(float(stats.wilcoxon(differences).pvalue))
        assert signed_rank([0.0, 0.0]) == 1.0

    def test_rank_sum_agrees_with_scipy(self) -> None:
        rng = np.random.default_rng(4)
        x, y = rng.normal(0, 1, 7), rng.normal(1, 1, 6)
        exact = stats.mannwhitneyu(x, y, method="exact").pvalue
        assert rank_sum(x, y) == pytest.approx(float(exact))
        assert rank_sum([1, 1], [1, 1, 1]) == 1.0
        tied, shifted = rng.integers(0, 9, 40), rng.integers(2, 9, 30)
        normal = stats.mannwhitneyu(tied, shifted).pvalue
        assert rank_sum(tied, shifted) == pytest.approx(float(normal))

    def test_false_alarms_are_as_rare_as_said(self) -> None:
        """Seed 6, 2000 unpaired tests at 5 % of equal methods, many ties.

        Were the level 5 %, a count outside 70..130 would have a chance of 2e-3.
        """
        rng = np.random.default_rng(6)
        alarms = sum(
            rank_sum(*np.split(rng.integers(0, 12, 40).astype(float), 2)) < 0.05
            for _ in range(2000)
        )
        assert 70 <= alarms <= 130

    def test_over_problems(self) -> None:
        assert compare_over_problems([0.9, 0.8, 0.7, 0.6, 1.0, math.nan]) == 2 / 2**5
        assert compare_over_problems([0.9, 0.1]) == 1.0
        assert math.isnan(compare_over_problems([]))


class TestHolm:
    def test_textbook(self) -> None:
        # 0.01, 0.04, 0.03, 0.005: rejected at 5 % are 0.005 and 0.01, as in the usual example
        assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])

    @given(st.lists(st.one_of(st.floats(0, 1), st.just(math.nan)), max_size=12))
    def test_no_less_than_raw_in_the_same_order_and_blind_to_tests_not_made(
        self, p: list[float]
    ) -> None:
        adjusted, raw = holm(p), np.array(p, dtype=float)
        tested = ~np.isnan(raw)
        assert np.array_equal(np.isnan(adjusted), ~tested)
        assert (adjusted[tested] >= raw[tested]).all()
        assert (adjusted[tested] <= 1).all()
        assert (np.diff(adjusted[tested][np.argsort(raw[tested])]) >= 0).all()
        assert np.array_equal(holm(raw[tested]), adjusted[tested])


class TestEffect:
    def test_extremes_and_ties(self) -> None:
        assert a12([1, 2], [3, 4, 5]).value == 1.0
        assert a12([3, 4, 5], [1, 2]).value == 0.0
        assert a12([1, 1], [1, 1, 1]).value == 0.5
        assert a12([1, 2, 3], [2, 4]).value == 4.5 / 6

    def test_one_against_one(self) -> None:
        z2 = stats.norm.ppf(0.975) ** 2  # there (1 - t)^2 = z2 t (1 - t)
        assert a12([1.0], [2.0]).low == pytest.approx(1 / (1 + z2))

    @given(*[st.lists(st.integers(0, 6), min_size=1, max_size=15)] * 2)
    def test_turned_round_it_is_the_complement(self, a: list[int], b: list[int]) -> None:
        effect, complement = a12(a, b), a12(b, a)
        assert effect.value == pytest.approx(1 - complement.value)
        assert (effect.low, effect.high) == pytest.approx(
            (1 - complement.high, 1 - complement.low), abs=1e-9
        )
        assert 0 <= effect.low <= effect.value <= effect.high <= 1

    @pytest.mark.parametrize("chance", [0.5, 0.8, 0.97])
    def test_the_interval_covers(self, chance: float) -> None:
        """Seed 7, 400 pairs of 20 exponential samples: A12 = rate / (1 + rate).

        Were the coverage 95 %, a count outside 366..398 would have a chance of 1.2e-3.
        """
        rng = np.random.default_rng(7)
        ratio = chance / (1 - chance)
        covered = 0
        for _ in range(400):
            effect = a12(rng.exponential(1, 20), rng.exponential(ratio, 20))
            covered += effect.low <= chance <= effect.high
        assert 366 <= covered <= 398


def test_a_single_run_is_no_sample() -> None:
    assert math.isnan(rank_sum([1.0], [2.0]))
    assert math.isnan(rank_sum([1.0, 2.0, 3.0], [0.5]))
    assert rank_sum([1.0, 2.0], [3.0, 4.0]) == pytest.approx(1 / 3)  # 2 of 6 arrangements
