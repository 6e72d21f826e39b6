"""Campaign files: their cells, their refusals, and the paper's campaign against its tables."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stribeck.bench.campaign import Campaign, campaign, parsed, shipped
from stribeck.bench.record import Job, Record, Steps
from stribeck.bench.run import run
from stribeck.errors import InputError
from stribeck.optimize import Search, Target, Trace, configure, lockstep

SMALL = """
name = "small"
seed = 7
repeats = 3
budget = 400

[[problem]]
surface = "BF"

[[problem]]
surface = "RF"
dim = [2, 3]
twin = "each"

[[method]]
name = "bts"
method = "bts"
unit_free = true

[[method]]
name = "random"
method = "random"
"""


def jobs_of(plan: Campaign) -> dict[tuple[str, str, int], Job]:
    return {(j.problem, j.algorithm, j.repeat): j for j in plan.jobs()}


# --- what a file spans


def test_lists_span_all_their_problems_and_every_cell_has_its_repeats() -> None:
    plan = parsed(SMALL)
    assert [t.label for t in plan.tasks] == ["BF", "RF-twin", "RF-d3-twin"]
    assert len(plan.cells) == 6
    jobs = list(plan.jobs())
    assert len(jobs) == len({j.key for j in jobs}) == 18
    # Repeats are outermost: cut short, a campaign has some of everything.
    assert [j.repeat for j in jobs] == [0] * 6 + [1] * 6 + [2] * 6


def test_a_list_may_have_the_slide_bed_beside_functions() -> None:
    plan = parsed(SMALL.replace('surface = "BF"', 'surface = ["ShuF", "slide-bed"]\ndim = [1, 3]'))
    assert [t.label for t in plan.tasks[:3]] == ["ShuF-d1", "ShuF-d3", "slide-bed-right"]


def test_each_repeat_of_a_twin_is_another_and_all_methods_share_it() -> None:
    jobs = jobs_of(parsed(SMALL))
    for repeat in range(3):
        assert jobs["RF-twin", "bts", repeat].surface["twin"] == repeat
        assert jobs["RF-twin", "bts", repeat].surface == jobs["RF-twin", "random", repeat].surface
    assert jobs["BF", "bts", 0].surface == jobs["BF", "bts", 2].surface


def test_a_run_ends_at_j_min_unless_the_file_says_otherwise() -> None:
    targets = {
        "": 1e-9,
        "target = 0.5": 0.5,
        'target = "none"': None,
    }
    for line, target in targets.items():
        plan = parsed(SMALL.replace('surface = "BF"', f'surface = "BF"\n{line}'))
        assert jobs_of(plan)["BF", "bts", 0].target == target


def test_budgets_go_from_the_particular_to_the_general() -> None:
    def budget(of_problem: str = "", of_method: str = "") -> int:
        text = SMALL.replace("dim = [2, 3]", f"dim = [2, 3]\n{of_problem}")
        text = text.replace('method = "random"', f'method = "random"\n{of_method}')
        return jobs_of(parsed(text))["RF-d3-twin", "random", 0].budget

    assert budget() == 400
    assert budget("budget = 50") == 50
    assert budget("budget_per_dim = 50") == 150
    assert budget("budget = 50", "budget = 60") == 60
    assert budget("budget = 50", "budget_per_dim = 7") == 21


def test_a_method_like_another_takes_over_what_it_does_not_say() -> None:
    plan = parsed(
        SMALL
        + """
[[method]]
name = "parent"
method = "ats"
budget = 99
problems = ["BF"]
settings = { N = 7, BT = 3 }
on.BF = { R = 0.3, n_re_back = 2 }

[[method]]
name = "child"
like = "parent"
settings = { BT = 4 }
on.BF = { R = 0.1 }
"""
    )
    child = jobs_of(plan)["BF", "child", 0]
    assert child.method == {
        "name": "ats",
        "settings": {"N": 7, "BT": 4, "R": 0.1, "n_re_back": 2},
    }
    assert child.budget == 99
    assert ("RF-twin", "child") not in plan.cells


def test_precisions_end_where_the_runs_do() -> None:
    plan = parsed(SMALL.replace("seed = 7", "seed = 7\ntargets = [1.0, 1e-3, 1e-8, 1e-10]"))
    targets = plan.targets(plan.jobs())
    assert targets["BF"].tolist() == [1.0, 1e-3, 1e-8, 1e-9]  # J_min of BF is 1e-9
    assert targets["RF-twin"].tolist() == [1.0, 1e-3, 1e-8]


def test_precisions_fall_whichever_end_is_named_first() -> None:
    ends = ("{ from = 1e2, to = 1e-8, count = 11 }", "{ from = 1e-8, to = 1e2, count = 11 }")
    for targets in ends:
        plan = parsed(SMALL.replace("seed = 7", f"seed = 7\ntargets = {targets}"))
        assert np.allclose(np.log10(plan.precisions), np.arange(2, -9, -1))


@pytest.mark.parametrize(("trials", "line"), [(0, "at least 1"), (10**7, "60,000,000 runs")])
def test_trials_that_cannot_be_are_refused(trials: int, line: str) -> None:
    with pytest.raises(InputError, match=line):
        parsed(SMALL).trials(trials)


# --- a record depends on its own job and nothing else


def contents(plan: Campaign) -> dict[tuple[str, str, int], str]:
    return {key: run(job).content for key, job in jobs_of(plan).items()}


def test_added_methods_and_problems_leave_every_record_as_it_was() -> None:
    before = contents(parsed(SMALL))
    extended = SMALL.replace('surface = "BF"', 'surface = ["ShuF", "BF"]')
    extended = extended.replace(
        '[[method]]\nname = "bts"',
        '[[method]]\nname = "ts"\nmethod = "ts"\n\n[[method]]\nname = "bts"',
    )
    after = contents(parsed(extended.replace("repeats = 3", "repeats = 4")))
    assert len(after) == 4 * 4 * 3
    assert {key: after[key] for key in before} == before


def test_methods_problems_and_repeats_have_streams_of_their_own() -> None:
    seeds = [tuple(j.seeds().generate_state(4)) for j in parsed(SMALL).jobs()]
    assert len(set(seeds)) == len(seeds)
    reseeded = [
        tuple(j.seeds().generate_state(4)) for j in parsed(SMALL.replace("= 7", "= 8")).jobs()
    ]
    assert not set(seeds) & set(reseeded)


def test_a_record_comes_back_from_its_line_bit_for_bit() -> None:
    for job in parsed(SMALL).jobs():
        record = run(job)
        parsed_record = Record.parse(record.text)
        assert parsed_record.text == record.text
        assert parsed_record.job.key == job.key
        assert np.array_equal(parsed_record.steps.costs, record.steps.costs)


def test_a_record_is_what_the_search_itself_found() -> None:
    plan = parsed(SMALL.replace("budget = 400", "budget = 3000"))
    job = jobs_of(plan)["BF", "bts", 1]
    instance = plan.tasks[0].problem(0)
    algorithm = configure("bts", **job.method["settings"])
    search = Search(instance.space, algorithm, budget=3000, seed=job.seeds(), stops=[Target(1e-9)])
    (direct,) = lockstep(instance, [search])
    record = run(job)
    assert record.x == tuple(direct.x)
    assert (record.cost, record.evaluations, record.ended) == (direct.cost, 3000, "budget")
    assert record.rounds == {stage: direct.trace.rounds(stage) for stage in ("foraging", "tabu")}
    # The improvements are the convergence curve: it can be drawn from them.
    curve = np.full(3000, math.inf)
    for at, cost in zip(record.steps.evaluations, record.steps.costs, strict=True):
        curve[at - 1 :] = cost
    assert np.array_equal(curve, direct.trace.convergence())


def test_improvements_know_their_rounds_and_skip_what_cannot_be_run() -> None:
    trace = Trace(1)
    for costs, note in (
        ([np.inf, np.inf], {}),
        ([5.0, 4.0], {"round": 1}),
        ([6.0, 4.0], {"event": "swim"}),
        ([3.0, 2.0], {"round": 2}),
    ):
        trace.append(np.zeros((2, 1)), np.array(costs), note)
    steps = Steps.of(trace)
    assert steps.evaluations.tolist() == [3, 4, 7, 8]
    assert steps.rounds.tolist() == [1, 1, 2, 2]
    assert steps.costs.tolist() == [5.0, 4.0, 3.0, 2.0]
    assert (steps.reached(4.0), steps.reached(1.0)) == (4, None)


# --- what is refused, in one line


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("budget = 400", "budget = -1", "budget: input should be greater than or equal to 1"),
        ("budget = 400", "budget = 1.5", "budget: input should be a valid integer, got 1.5"),
        ("budget = 400", "", "problem 'BF' has no budget"),
        ("budget = 400", "budget = 4\nbudget_per_dim = 2", "not both"),
        ("repeats = 3", "repeats = 0", "repeats: input should be greater than or equal to 1"),
        ("repeats = 3", "repeats = 9_999_999", "runs: at most 1,000,000"),
        ("repeats = 3", "repeat = 3", "repeat: there is no such word here"),
        ("seed = 7", "seed = -7", "seed: input should be greater than or equal to 0"),
        ("seed = 7", "seed = ", "not TOML"),
        ('name = "small"', "", "name: is missing"),
        ('name = "small"', 'name = "../up"', "letters, digits"),
        ('surface = "BF"', 'surface = "Ackley"', "no surface 'Ackley': there are BF, RF"),
        ('surface = "BF"', 'surface = "RF"\ntwin = "each"', "problem 'RF-twin' is there twice"),
        ('surface = "BF"', 'surface = "BF"\ndim = 3', "BF is a function of 2 variables"),
        ('surface = "BF"', 'surface = "BF"\ninstance = 2', "instance: means nothing here"),
        ('surface = "BF"', 'surface = "BF"\ndirection = "left"', "direction: means nothing here"),
        ('surface = "BF"', 'surface = "slide-bed"\ndim = 5', "dim: means nothing here"),
        ('surface = "BF"', 'bbob = 1\ntwin = "each"', "twin: means nothing here"),
        ('surface = "BF"', 'surface = "BF"\nbbob = 1', "one of them"),
        ('surface = "BF"', "bbob = 25", "bbob has functions 1 to 24, got 25"),
        ('surface = "BF"', 'surface = "BF"\ntarget = nan', "target"),
        ('surface = "BF"', 'surface = "slide-bed"\ndirection = "up"', "no 'up': there are right"),
        ('method = "random"', 'method = "simulated-annealing"', "no method 'simulated-annealing'"),
        ('method = "random"', 'method = "random"\nsettings = { N = 3 }', "no setting 'N'"),
        ('method = "random"', 'method = "random"\nsettings = { batch = 0 }', "batch must be"),
        ('method = "random"', 'method = "random"\nproblems = ["SF"]', "no problem 'SF'"),
        ('method = "random"', 'method = "random"\non.SF = { batch = 2 }', "no problem 'SF'"),
        ("budget = 400", f"budget = {2**63}", "budget: input should be less than or equal to"),
        ("seed = 7", f"seed = {2**63}", "seed: input should be less than or equal to"),
        ("seed = 7", "seed = 7\ntargets = { from = 1, to = 0.1, count = 1_000_000 }", "count"),
        ('surface = "BF"', 'surface = "BF"\ntarget = 1e308', "target"),
        ('method = "random"', 'method = "scipy-de"\nsettings = { tol = nan }', "settings: Out"),
        ('method = "random"', 'method = "scipy-de"\nsettings = { tol = 2020-01-01 }', "settings: "),
        ('method = "random"', 'method = "direct"\nunit_free = true', "unit_free is for our own"),
        ('method = "random"', 'like = "ts"', "no method 'ts' above it"),
        ('method = "random"', "", "give its method"),
        ('name = "random"', 'name = "bts"', "method 'bts' is there twice"),
        ("seed = 7", 'seed = 7\nreference = "ats"', "reference: no method 'ats': there are bts"),
        ("seed = 7", "seed = 7\ntargets = []", "targets: give at least one"),
        ("seed = 7", "seed = 7\ntargets = [1.0, -1.0]", "targets"),
    ],
)  # fmt: skip
def test_a_malformed_file_is_one_line(old: str, new: str, line: str) -> None:
    assert SMALL.count(old) == 1
    with pytest.raises(InputError) as refused:
        parsed(SMALL.replace(old, new))
    assert line in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("papers", "no campaign 'papers': there are bbob, paper, twins"),
        ("absent.toml", "absent.toml: no such file"),
        (".", "no campaign"),
    ],
)
def test_what_is_no_campaign_is_one_line(name: str, line: str) -> None:
    with pytest.raises(InputError, match=line):
        campaign(name)


# --- the shipped campaigns

WIDTH = {"BF": 4.0, "RF": 4.0, "SF": 80.0, "SchF": 1000.0, "ShuF": 20.0}
#: Table 2 as printed: R, then (J, R) of the stages. BF, and RF's costs, are inferred.
TABLE_2: dict[str, tuple[float, list[tuple[float, float]]]] = {
    "BF": (0.2, [(0.1, 2e-3), (1e-3, 2e-4)]),
    "RF": (0.2, [(0.1, 2e-3), (1e-3, 2e-4)]),
    "SF": (0.8, [(5, 0.5), (2, 0.1)]),
    "SchF": (50, [(100, 25), (10, 10), (1, 1)]),
    "ShuF": (1.0, [(1, 1e-2), (-1, 1e-3)]),
}
#: Table 3 as printed: N_c, alpha, w_repellant. S = 30, N_s = 4, N_re = 4, N_ed = 2, P_ed = 0.25,
#: d_attract = h_repellant = 0.1 and w_attract = 0.2 in every row.
TABLE_3: dict[str, tuple[int, float, float]] = {
    "BF": (20, 10, 1),
    "RF": (200, 100, 1),
    "SF": (500, 0.01, 10),
    "SchF": (2000, 1, 10),
    "ShuF": (1000, 1, 10),
}


def paper_settings(method: str, surface: str) -> dict[str, Any]:
    return dict(jobs_of(campaign("paper").trials(1))[surface, method, 0].method["settings"])


@pytest.mark.parametrize("surface", WIDTH)
@pytest.mark.parametrize("method", ["ats", "ats-restart", "bts", "bts-restart"])
def test_the_paper_campaign_has_table_2(method: str, surface: str) -> None:
    settings, w = paper_settings(method, surface), WIDTH[surface]
    R, stages = TABLE_2[surface]
    assert (settings["N"], settings["count_max"]) == (30, 10_000)
    assert (settings["BT"], settings["n_re_back"]) == (5, 5)
    assert math.isclose(settings["R"] * w, R)
    assert np.allclose([(J, r * w) for J, r in settings["AR"]], stages, rtol=1e-12)
    deadlock = "restart" if "restart" in method else "backtrack"
    assert settings.get("deadlock", "backtrack") == deadlock


@pytest.mark.parametrize("surface", WIDTH)
@pytest.mark.parametrize("method", ["abfo", "bts", "bts-restart", "bfo"])
def test_the_paper_campaign_has_table_3(method: str, surface: str) -> None:
    settings, w = paper_settings(method, surface), WIDTH[surface]
    N_c, alpha, w_repellant = TABLE_3[surface]
    assert (settings["S"], settings["N_s"]) == (30, 4)
    assert (settings["d_attract"], settings["h_repellant"]) == (0.1, 0.1)
    assert math.isclose(settings["w_attract"], 0.2 * w**2)
    assert math.isclose(settings["w_repellant"], w_repellant * w**2)
    if method != "bfo":
        assert settings["alpha"] == alpha
        assert math.isclose(settings["step"], 1 / w)
    if method.startswith("bts"):
        assert settings["N_c"] == 20
        assert "N_re" not in settings
    else:
        assert settings["N_c"] == N_c
        assert (settings["N_re"], settings["N_ed"], settings["P_ed"]) == (4, 2, 0.25)


def test_the_paper_campaign_is_fifty_trials_to_j_min_of_table_1() -> None:
    plan = campaign("paper")
    assert plan.repeats == 50
    targets = {j.problem: j.target for j in plan.trials(1).jobs()}
    assert targets == {"BF": 1e-9, "RF": 1e-8, "SF": 0.9990, "SchF": 1e-1, "ShuF": -186.73}
    assert all(j.surface["dim"] == 2 for j in plan.trials(1).jobs())


def test_unit_cube_and_raw_lengths_are_the_same_search() -> None:
    # The conversion is exact but for rounding: the first steps, before chaos, agree.
    settings, w = paper_settings("bts", "SchF"), WIDTH["SchF"]
    raw = settings | {
        "coordinates": "raw",
        "step": settings["step"] * w,
        "R": settings["R"] * w,
        "AR": [(J, r * w) for J, r in settings["AR"]],
        "w_attract": settings["w_attract"] / w**2,
        "w_repellant": settings["w_repellant"] / w**2,
    }
    cost = campaign("paper").tasks[3].problem(0)
    runs = [
        lockstep(cost, [Search(cost.space, configure("bts", **s), budget=1000, seed=3)])[0]
        for s in (settings, raw)
    ]
    assert np.allclose(runs[0].trace.u, runs[1].trace.u, atol=1e-9)


@pytest.mark.parametrize("surface", WIDTH)
def test_bts_with_restart_reaches_j_min_in_50_of_50_trials(surface: str) -> None:
    # The paper's claim for BTS (section 3). Literal backtracking does not get there.
    plan = campaign("paper")
    chosen = [j for j in plan.jobs() if j.cell == (surface, "bts-restart")]
    assert [run(j).ended for j in chosen] == ["target"] * 50


@pytest.mark.parametrize("surface", ["SF", "SchF"])
def test_literal_ats_stays_in_its_first_basin(surface: str) -> None:
    # Basins lie further apart than R, a move needs J1 < J0: most trials end where they began.
    plan = campaign("paper").trials(10)
    chosen = [j for j in plan.jobs() if j.cell == (surface, "ats")]
    assert sum(run(j).reached for j in chosen) <= 3


@pytest.mark.parametrize("name", shipped())
def test_shipped_campaigns_say_what_they_are(name: str) -> None:
    plan = campaign(name)
    assert plan.name == name
    assert plan.doc
    assert len(plan.cells) == len(set(plan.cells))


def test_every_deadlock_is_counted_as_an_entrapment() -> None:
    # BT = 5 rounds without improvement: a run whose stages begin by cost and that never meets
    # its target is caught about every five rounds, whichever way it gets out.
    plan = campaign("paper").trials(1)
    for algorithm, event in (("bts", "backtrack"), ("bts-restart", "restart")):
        (job,) = [j for j in plan.jobs() if j.cell == ("SF", algorithm)]
        record = run(replace(job, target=None, budget=30_000))
        assert record.entrapments == record.events[event] > 5
        assert record.entrapments <= record.search_rounds / 5


def test_the_file_in_the_documentation_is_a_campaign() -> None:
    page = (Path(__file__).parent.parent / "docs" / "campaigns.md").read_text(encoding="utf-8")
    plan = parsed(page.partition("```toml\n")[2].partition("```")[0])
    assert len(plan.cells) == 18  # 6 twins and 2 slide beds by 2 methods; `de` on 2 twins
    assert plan.reference == "bts"


def test_a_run_that_ends_while_foraging_has_no_tabu_rounds() -> None:
    (job,) = [j for j in campaign("paper").trials(1).jobs() if j.cell == ("SF", "bts")]
    record = run(replace(job, budget=200, target=None))
    assert record.rounds == {"foraging": record.rounds["foraging"]}
    assert (record.search_rounds, record.entrapments) == (0, 0)
    (job,) = [j for j in campaign("paper").trials(1).jobs() if j.cell == ("SF", "ga")]
    record = run(replace(job, budget=200, target=None))
    assert record.search_rounds == 10  # 20 individuals, then 18 children a generation
    assert record.entrapments is None
