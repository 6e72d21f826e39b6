"""The figures of a campaign: their curves are those of the statistics."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from stribeck.bench import campaign_figures, running_time, statistics
from stribeck.bench.campaign_figures import CampaignFigure, draw, figures, looks
from stribeck.bench.movements import foraging_tracks, movements, tabu_path
from stribeck.bench.record import Job, Record, Steps
from stribeck.bench.surfaces import surface
from stribeck.optimize import METHODS, Search, lockstep

METHODS_18 = [
    "bts", "bts-restart", "ats", "ats-restart", "ts", "abfo", "bfo", "ga", "random", "scipy-de",
    "dual-annealing", "direct", "shgo", "cma-ipop", "cma-bipop", "pymoo-ga", "pymoo-de",
    "niapy-bfo",
]  # fmt: skip


def record(
    problem: str, method: str, repeat: int, rng: np.random.Generator, *, dim: int = 2,
    target: float | None = 1e-3, minimum: float | None = 0.0,
) -> Record:  # fmt: skip
    """A run that improves twelve times, at random places."""
    job = Job(problem, method, repeat, 1, 1000, target, minimum, {}, {"name": method})
    at = np.sort(rng.choice(np.arange(2, 1000), 12, replace=False))
    steps = Steps(
        np.concatenate([[1], at]),
        np.concatenate([[0], at // 30]),
        10.0 ** -np.sort(np.concatenate([[0.0], rng.uniform(-1, 6, 12)])),
    )
    cost = float(steps.costs[-1])
    return Record(job, (0.0,) * dim, cost, 1000, "budget", 0, {"": 33}, {}, steps, 1.0)


@pytest.fixture(scope="module")
def records() -> list[Record]:
    rng = np.random.default_rng(1)
    return [
        record(problem, method, repeat, rng, dim=dim)
        for problem, dim in (("A", 2), ("B", 2), ("C", 3))
        for method in ("x", "x-restart", "y")
        for repeat in range(5)
    ]


@pytest.fixture(scope="module")
def drawn(records: list[Record]) -> dict[str, CampaignFigure]:
    return {drawing.name: drawing for drawing in figures(records)}


def line(figure: Figure, panel: str, gid: str) -> tuple[np.ndarray, np.ndarray]:
    """The data of a line that is drawn in a panel."""
    (axes,) = [a for a in figure.axes if a.get_title(loc="left") == panel]
    (curve,) = [k for k in axes.lines if k.get_gid() == gid]
    return np.asarray(curve.get_xdata(), float), np.asarray(curve.get_ydata(), float)


def test_a_campaign_has_its_figures(drawn: dict[str, CampaignFigure]) -> None:
    assert set(drawn) == {
        "ecdf", "success", "evaluations", "profile", "convergence_evaluations",
        "convergence_rounds",
    }  # fmt: skip
    assert all(drawing.title and len(drawing.caption) > 40 for drawing in drawn.values())


def test_shares_drawn_are_the_ecdf(records: list[Record], drawn: dict[str, CampaignFigure]) -> None:
    for dim, panel in ((None, "All problems"), (2, "2 dimensions"), (3, "3 dimensions")):
        chosen = [r for r in records if r.job.algorithm == "y" and dim in {None, len(r.x)}]
        curve = statistics.ecdf(chosen)
        x, y = line(drawn["ecdf"].figure, panel, "share:y")
        for at, share in zip(curve.at, curve.share, strict=True):
            assert y[np.searchsorted(x, at, side="right") - 1] == share
        assert (np.diff(y) >= 0).all()


def test_the_band_holds_the_curve_and_closes_with_the_runs(records: list[Record]) -> None:
    chosen = [r for r in records if r.job.algorithm == "y"]
    grid = np.geomspace(1, 500, 40)
    low, high = statistics.ecdf_band(chosen, grid)
    curve = statistics.ecdf(chosen)
    share = np.concatenate([[0.0], curve.share])[np.searchsorted(curve.at, grid, side="right")]
    assert (low <= share + 1e-12).all()
    assert (share <= high + 1e-12).all()
    assert (high - low).max() > 0.01
    alone = [r for r in chosen if r.job.repeat == 0]  # one run a cell: nothing to draw again
    assert np.isnan(statistics.ecdf_band(alone, grid)).all()


@pytest.mark.parametrize("over", ["evaluations", "rounds"])
def test_convergence_drawn_is_the_median(
    records: list[Record], drawn: dict[str, CampaignFigure], over: str
) -> None:
    figure = drawn[f"convergence_{over}"].figure
    for problem in "ABC":
        x, y = line(figure, problem, "median:x-restart")
        chosen = [r for r in records if r.job.cell == (problem, "x-restart")]
        _, median, _ = statistics.convergence(chosen, x, over=over, above_minimum=True)  # type: ignore[arg-type]
        np.testing.assert_allclose(y, median)
        (axes,) = [a for a in figure.axes if a.get_title(loc="left") == problem]
        assert axes.get_yscale() == "log"
        assert any(set(np.asarray(k.get_ydata())) == {1e-3} for k in axes.lines)  # the target


def test_costs_below_zero_are_drawn_on_a_plain_axis() -> None:
    rng = np.random.default_rng(2)
    runs = [record("A", m, k, rng, minimum=None, target=None) for m in "xy" for k in range(3)]
    for r in runs:
        r.steps.costs[:] -= 5.0
        object.__setattr__(r, "cost", float(r.steps.costs[-1]))
    drawings = {drawing.name: drawing for drawing in figures(runs)}
    assert set(drawings) == {"ecdf", "convergence_evaluations", "convergence_rounds"}
    axes = drawings["convergence_evaluations"].figure.axes[0]
    assert axes.get_yscale() == "linear"
    _, y = line(drawings["convergence_evaluations"].figure, "A", "median:x")
    assert y[-1] < 0


def test_a_run_that_hits_the_minimum_itself_stays_on_the_log_axis() -> None:
    rng = np.random.default_rng(3)
    runs = [record("A", m, k, rng) for m in "xy" for k in range(3)]
    for r in runs:
        r.steps.costs[-1] = 0.0
        object.__setattr__(r, "cost", 0.0)
    drawings = {drawing.name: drawing for drawing in figures(runs)}
    _, y = line(drawings["convergence_evaluations"].figure, "A", "median:x")
    assert (y > 0).all()
    assert y[-1] < 1e-3  # below the target


@pytest.mark.parametrize("name", ["success", "evaluations"])
def test_dots_are_the_estimates(
    records: list[Record], drawn: dict[str, CampaignFigure], name: str
) -> None:
    estimate = {"success": statistics.success_rate, "evaluations": running_time.ert}[name]
    for problem in "ABC":
        (axes,) = [a for a in drawn[name].figure.axes if a.get_title(loc="left") == problem]
        dots = {
            int(np.asarray(k.get_ydata())[0]): float(np.asarray(k.get_xdata())[0])
            for k in axes.lines if k.get_gid() == "estimate"
        }  # fmt: skip
        never = {int(np.asarray(k.get_ydata())[0]) for k in axes.lines if k.get_gid() == "never"}
        for row, method in enumerate(["x", "x-restart", "y"]):
            value = estimate([r for r in records if r.job.cell == (problem, method)]).value
            if math.isfinite(value):
                assert dots[row] == value
            else:
                assert row in never
    first = drawn[name].figure.axes[0]
    assert [t.get_text() for t in first.get_yticklabels()] == ["x", "x-restart", "y"]


def test_what_no_run_reached_is_marked_as_such() -> None:
    rng = np.random.default_rng(4)
    runs = [record("A", m, k, rng, target=t) for m, t in (("x", 1e-9), ("y", 1.0)) for k in (0, 1)]
    (drawing,) = [d for d in figures(runs) if d.name == "evaluations"]
    (axes,) = [a for a in drawing.figure.axes if a.axison]
    never = [k for k in axes.lines if k.get_gid() == "never"]
    assert [float(np.asarray(k.get_ydata())[0]) for k in never] == [0.0]
    assert float(np.asarray(never[0].get_xdata())[0]) > running_time.ert(runs[2:]).value


def test_the_profile_drawn_is_dolan_and_mores(
    records: list[Record], drawn: dict[str, CampaignFigure]
) -> None:
    methods = ["x", "x-restart", "y"]
    by_cell = statistics.cells(records)
    times = [[running_time.ert(by_cell[p, m]).value for m in methods] for p in "ABC"]
    for method, curve in zip(methods, statistics.profile(times), strict=True):
        x, y = line(drawn["profile"].figure, "Performance profile", f"profile:{method}")
        for at, share in zip(curve.at, curve.share, strict=True):
            assert y[np.searchsorted(x, at, side="right") - 1] == pytest.approx(share)


def test_the_ecdf_is_of_the_cells_that_the_ranking_compares() -> None:
    rng = np.random.default_rng(5)
    runs = [record(p, m, k, rng) for p in "AB" for m in "xy" for k in range(2)]
    runs += [record("A", "z", k, rng) for k in range(2)]  # meant for A alone
    planned = [r.job for r in runs]
    late = [r for r in runs if r.job.cell != ("B", "y")]  # y on B has not been run yet
    (drawing,) = [d for d in figures(late, planned) if d.name == "ecdf"]
    _, y = line(drawing.figure, "All problems", "share:x")
    chosen = [r for r in runs if r.job.cell == ("A", "x")]
    assert y[-1] == statistics.ecdf(chosen).share[-1]
    assert "Not meant for every problem, hence not drawn: z." in drawing.caption
    assert "Drawn for 1 of 2 problems" in drawing.caption


def test_nothing_run_is_nothing_drawn(records: list[Record]) -> None:
    assert figures([], [r.job for r in records]) == []


def test_many_problems_are_spread_over_sheets() -> None:
    rng = np.random.default_rng(6)
    runs = [record(f"f{k:02}", m, 0, rng) for k in range(30) for m in "xy"]
    names = [drawing.name for drawing in figures(runs)]
    assert {"success_1", "success_2", "convergence_evaluations_2"} <= set(names)
    assert len(names) == len(set(names))


@pytest.mark.parametrize("methods", [METHODS_18, [f"m{k}" for k in range(20)]])
def test_no_two_methods_look_alike(methods: list[str]) -> None:
    styles = looks(methods)
    assert list(styles) == methods
    assert len({(style.colour, style.dash) for style in styles.values()}) == len(methods)


def test_variants_share_their_colour() -> None:
    styles = looks(METHODS_18)
    assert styles["bts"].colour == styles["bts-restart"].colour
    assert styles["bts"].colour != styles["ats"].colour


def test_files_are_png_and_svg_and_the_same_each_time(
    records: list[Record], tmp_path: Path
) -> None:
    two_repeats = [r for r in records if r.job.repeat < 2]
    bytes_of = []
    for k in ("one", "two"):
        (tmp_path / k).mkdir()
        drawings = [d for d in figures(two_repeats) if d.name in {"ecdf", "evaluations"}]
        files = draw(drawings, tmp_path / k)
        assert [f.name for f in files] == [
            "ecdf.png", "ecdf.svg", "evaluations.png", "evaluations.svg",
        ]  # fmt: skip
        bytes_of.append([f.read_bytes() for f in files])
    assert bytes_of[0] == bytes_of[1]


def test_one_run_alone_has_figures() -> None:
    alone = record("A", "x", 0, np.random.default_rng(4))
    drawn = {drawing.name: drawing for drawing in figures([alone])}
    assert set(drawn) == {
        "ecdf", "success", "evaluations", "convergence_evaluations", "convergence_rounds",
    }  # fmt: skip
    x, y = line(drawn["convergence_evaluations"].figure, "A", "median:x")
    at = np.searchsorted(alone.steps.evaluations, x, side="right") - 1
    np.testing.assert_array_equal(y, alone.steps.costs[at])


def test_one_evaluation_has_figures() -> None:
    counts = np.ones(1, dtype=np.int64)
    job = Job("A", "x", 0, 1, 1, None, 0.0, {}, {"name": "x"})
    run = Record(
        job, (0.0, 0.0), 2.0, 1, "budget", 0, {}, {}, Steps(counts, counts, np.array([2.0]))
    )
    for sheet in figures([run]):  # a warning is an error here
        left, right = sheet.figure.axes[0].get_xlim()
        assert left < right


def test_runs_without_a_finite_cost_are_no_line_and_no_success(records: list[Record]) -> None:
    none = Steps(np.array([], dtype=np.int64), np.array([], dtype=np.int64), np.array([]))
    lost = [
        replace(r, job=replace(r.job, algorithm="lost"), cost=math.inf, failed=1000, steps=none)
        for r in records
        if r.job.algorithm == "y" and r.job.problem == "A"
    ]
    finite = [r for r in records if r.job.problem == "A"]
    for runs in (lost, [*finite, *lost]):  # alone, and with others
        drawn = {drawing.name: drawing for drawing in figures(runs)}
        _, y = line(drawn["convergence_evaluations"].figure, "A", "median:lost")
        assert np.isnan(y).all()
        panels = [a for a in drawn["evaluations"].figure.axes if a.axison]
        assert [k for a in panels for k in a.lines if k.get_gid() == "never"]


# --- movements -------------------------------------------------------------------------------


def run(method: str, name: str = "BF", budget: int = 4000, **settings: object):  # type: ignore[no-untyped-def]  # noqa: ANN201
    cost = surface(name, 2, None)
    search = Search(cost.space, METHODS[method](**settings), budget=budget, seed=3)
    return cost, lockstep(cost, [search])[0].trace


def test_tracks_are_the_cells_after_each_tumble() -> None:
    cost, trace = run("bts", S=6, N_c=7)
    tracks = foraging_tracks(cost, trace)
    assert tracks.shape == (8, 6, 2)
    np.testing.assert_array_equal(tracks[0], cost.space.decode(trace.u[:6]))
    tumbles = [
        k for k, n in enumerate(trace.notes) if n.get("stage") == "foraging" and "round" in n
    ]
    for row, k in zip(tracks[1:], tumbles, strict=True):
        start = trace.ends[k - 1]
        np.testing.assert_array_equal(row, cost.space.decode(trace.u[start : start + 6]))


def test_the_path_begins_at_the_hand_over_and_falls_to_the_best() -> None:
    cost, trace = run("bts", S=6, N_c=7)
    path = tabu_path(cost, trace)
    costs = cost(path)
    assert (np.diff(costs) < 0).all()
    assert costs[-1] == trace.cost
    handed = trace.ends[[n.get("stage") for n in trace.notes].index("tabu") - 1]
    assert costs[0] == trace.f[:handed].min()


def test_a_swarm_alone_has_tracks_that_break_where_cells_die() -> None:
    cost, trace = run("bfo", S=4, N_c=3, N_re=2, N_ed=2)
    tracks = foraging_tracks(cost, trace)
    gaps = np.isnan(tracks).all(axis=(1, 2))
    assert gaps.sum() == 3  # between the four lifetimes
    assert (~gaps).sum() == 1 + 2 * 2 * 3
    assert len(tabu_path(cost, trace)) == 0


def test_after_a_restart_the_last_whole_story_is_drawn() -> None:
    cost, trace = run("bts", "SchF", 6000, S=6, N_c=4, deadlock="restart", AR_by="deadlock")
    restarts = [k for k, n in enumerate(trace.notes) if "start" in n]
    tabu = [k for k, n in enumerate(trace.notes) if n.get("stage") == "tabu"]
    assert len(restarts) > 1
    last = max(k for k in restarts if k < tabu[-1])
    first = foraging_tracks(cost, trace)[0]
    np.testing.assert_array_equal(
        first, cost.space.decode(trace.u[trace.ends[last - 1] : trace.ends[last]])
    )


@pytest.mark.parametrize(("method", "panels"), [("bts", 2), ("abfo", 1)])
def test_movements_show_tracks_path_and_optimum(method: str, panels: int) -> None:
    cost, trace = run(method, S=6, N_c=5)
    drawing = movements(cost, trace, optima=cost.optima.tolist(), title="a run")
    assert len(drawing.figure.axes) == panels
    left = drawing.figure.axes[0]
    shown = [np.column_stack([k.get_xdata(), k.get_ydata()]) for k in left.lines]
    tracks = foraging_tracks(cost, trace)
    for k in range(6):
        np.testing.assert_array_equal(shown[k], tracks[:, k])
    assert any(k.shape == cost.optima.shape and np.array_equal(k, cost.optima) for k in shown)
    if panels == 2:
        assert any(np.array_equal(k, tabu_path(cost, trace)) for k in shown)


def test_the_paper_has_at_most_as_many_methods_as_there_are_markers() -> None:
    assert len(set(campaign_figures.MARKERS)) == len(campaign_figures.MARKERS) >= 10
