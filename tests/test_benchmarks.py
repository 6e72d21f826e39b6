"""The benchmarks' arithmetic, and their reference minima."""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import bbob_area
import identification
import run
import scaling
import startup
import surfaces
from overhead import Residuals
from stribeck.bench.record import Job, Record, Steps
from stribeck.optimize import rms
from stribeck.space import Array, Space, box
from twins import FILE, RATE, SLIPS, TOLERANCE, Twin, slips, twins


def record(costs: list[float], at: list[int], dim: int = 2) -> Record:
    """A run that improved to these costs after so many evaluations; the minimum is 0."""
    job = Job("f", "m", 0, 0, 100, None, 0.0, {"bbob": 1}, {})
    steps = Steps(np.array(at), np.array(at), np.array(costs))
    return Record(job, (0.0,) * dim, costs[-1], at[-1], "budget", 0, {}, {}, steps)


# --- twins ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def all_twins() -> list[Twin]:
    return twins()


def test_the_best_known_J_is_found_where_it_is_said_to_be(all_twins: list[Twin]) -> None:
    minima = json.loads(FILE.read_text(encoding="utf-8"))["twins"]
    assert list(minima) == [t.name for t in all_twins]
    for twin in all_twins:
        # Another integrator, as exact, tips a sample or two of the log over an edge of the
        # converter; a fifth of the margin that counts as found is room for some.
        assert twin.problem(twin.best_x[None])[0] == pytest.approx(twin.best, rel=TOLERANCE / 5)


def test_neither_truth_nor_a_random_point_is_below_the_best_known_J(all_twins: list[Twin]) -> None:
    for twin in all_twins:
        u = twin.problem.space.sample(np.random.default_rng(7), 20)
        x = np.vstack([twin.truth, twin.problem.space.decode(u)])
        assert np.nanmin(twin.problem(x)) >= twin.best * (1 - TOLERANCE / 5)


def test_the_best_known_J_is_near_the_noise_it_cannot_fit_away(all_twins: list[Twin]) -> None:
    # Five parameters on hundreds of samples: J is the noise within a few standard errors, and
    # above it where an echo is old or the converter coarse (0.028 mm).
    for twin in all_twins:
        noise = 1e3 * twin.bed.echo_noise
        assert 0.95 * noise < twin.best < 1.05 * math.hypot(noise, 0.03)


def test_random_twins_stick_and_slip_at_rates_and_noises_of_the_range(
    all_twins: list[Twin],
) -> None:
    random = [t for t in all_twins if not t.demo]
    assert len(random) == 20
    assert all(slips(t.truth, t.side) >= SLIPS for t in random)
    assert {t.side for t in random} == {"right", "left"}
    rates = [t.bed.rate for t in random]
    assert RATE[0] <= min(rates) < 30
    assert 300 < max(rates) <= RATE[1]


def test_a_slide_that_never_stops_does_not_slip_anew() -> None:
    # F_S = F_C and much viscous friction: the slide breaks loose once and follows the ramp.
    smooth = np.array([60.0, 60.0, 4000.0, 7e-3, 1500.0])
    assert slips(smooth, "right") == 0


def test_twins_are_the_same_each_time(all_twins: list[Twin]) -> None:
    rebuilt = twins()[5]
    assert np.array_equal(rebuilt.truth, all_twins[5].truth)
    x = rebuilt.truth[None] * 1.01
    assert np.array_equal(rebuilt.problem.residuals(x), all_twins[5].problem.residuals(x))


# --- counting -------------------------------------------------------------------------------------


class Line:
    """A problem on a line, whose J is the distance from 0.5."""

    space: Space = box([(0.0, 1.0)])

    def __call__(self, x: Array) -> Array:
        return np.abs(x[:, 0] - 0.5)

    def residuals(self, x: Array) -> Array:
        return x - 0.5


@pytest.mark.parametrize(
    ("budget", "spent", "reached"), [(100, 3, True), (3, 3, True), (2, 3, False)]
)
def test_a_batch_counts_up_to_the_point_that_is_low_enough(
    budget: int, spent: int, reached: bool
) -> None:
    count = identification.Counted(Line(), 0.1, budget)  # type: ignore[arg-type]
    with pytest.raises(identification.FoundError):
        count.costs(np.array([[0.0], [0.9], [0.55], [0.5]]))
    assert (count.spent, count.reached) == (spent, reached)


def test_points_and_residuals_are_counted_alike() -> None:
    count = identification.Counted(Line(), 0.1, 100)  # type: ignore[arg-type]
    assert count.costs(np.array([[0.0], [np.nan]])).tolist() == [0.5, np.inf]
    assert count.residuals(np.array([0.8])) == pytest.approx(0.3)
    with pytest.raises(identification.FoundError):
        count.residuals(np.array([0.45]))
    assert (count.spent, count.reached) == (4, True)


def test_runs_that_did_not_find_it_are_longer_than_any_that_did() -> None:
    assert identification.spread([7, None, 3, 5]) == (3, 3, 7, math.inf)
    assert identification.spread([None, None, 3]) == (1, 3, math.inf, math.inf)


def test_the_mean_of_times_is_geometric_and_a_failure_is_infinite() -> None:
    assert surfaces.mean_ert({"a": {"ert": 10.0}, "b": {"ert": 1000.0}}) == pytest.approx(100)
    assert surfaces.mean_ert({"a": {"ert": 10.0}, "b": {"ert": None}}) == math.inf


def test_share_of_targets_met_in_the_end() -> None:
    targets = np.array([10.0, 1.0, 0.1, 0.01])
    runs = [record([5.0, 0.5], [1, 9]), record([0.01], [50])]
    assert bbob_area.share(runs, targets) == (2 / 4 + 4 / 4) / 2


def test_area_is_one_for_a_run_that_meets_all_at_once_and_half_for_one_that_waits() -> None:
    assert bbob_area.area_under([record([0.0], [1])], 100.0) == 1.0
    assert bbob_area.area_under([record([0.0], [20])], 100.0) == pytest.approx(
        0.5
    )  # 10 a dimension


def test_exponent_of_the_upper_decades() -> None:
    sizes = np.logspace(0, 5, 11)
    slope, begin = scaling.exponent(sizes, 1.0 + 2e-3 * sizes**1.3)
    assert begin == pytest.approx(1e3)
    assert slope == pytest.approx(1.3, abs=0.03)  # the 1.0 is what a call costs in any case


def test_the_free_cost_is_the_root_mean_square_of_its_residuals() -> None:
    free = Residuals()
    x = free.space.decode(free.space.sample(np.random.default_rng(0), 9))
    np.testing.assert_allclose(rms(free.residuals(x)), free(x), rtol=1e-14)
    assert (free.calls, free.rows) == (2, 18)


# --- start-up -------------------------------------------------------------------------------------


def test_another_checkout_is_timed_by_turns_from_its_own_sources(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "old" / "src").mkdir(parents=True)
    sources: list[str] = []
    said = "typed\n2.00 s: start-up 0.50, search 1.00, figures 0.30, report 0.20\n"

    def process(command: list[str], *, env: dict[str, str], **_: Any) -> Any:
        if "identify" in command and "--out" not in command:
            sources.append(env["PYTHONPATH"])
        return subprocess.CompletedProcess(command, 0, said)

    monkeypatch.setattr(subprocess, "run", process)
    times = startup.measure(quick=True, against=tmp_path / "old")
    here, there = str(startup.SOURCES), str(tmp_path / "old" / "src")
    assert sources == [here, there] * 4  # once to warm up
    assert times["identify"]["card"] == 1.5
    times["against"] |= {"wall": 4.0, "processor": 5.0, "least": {"wall": 3.0, "processor": 4.0}}
    times["identify_printed"] |= {"wall": 2.0, "processor": 3.0}
    lines = startup.tables(times)
    assert "| median wall / s | 2.00 | 4.00 | 0.50 |" in lines
    assert "| median processor / s | 3.00 | 5.00 | 0.60 |" in lines


# --- results --------------------------------------------------------------------------------------


def test_a_part_that_cannot_be_written_leaves_those_before_it(tmp_path: Path) -> None:
    file = tmp_path / "results.json"
    run.keep(file, "surfaces", {"found": 1})
    run.keep(file, "kernel", {"found": np.float64(2.5)})
    before = file.read_bytes()
    with pytest.raises(AttributeError):
        run.keep(file, "bbob_area", {"found": object()})
    assert file.read_bytes() == before
    assert list(run.read(file)) == ["kernel", "surfaces"]  # in the order in which they run


def test_rows_that_are_measured_anew_name_their_machine_beside_that_of_the_others(
    tmp_path: Path,
) -> None:
    part = run.read(run.RESULTS)["simulators"]
    elsewhere, here = part["machine"] | {"processor": "Another"}, run.machine()
    run.keep(tmp_path / "results.json", "simulators", part | {"machine": elsewhere})
    for _ in range(2):
        run.renew("simulators", part["found"], tmp_path)
    lines = (tmp_path / "README.md").read_text(encoding="utf-8").splitlines()
    measured = [line for line in lines if line.startswith("Measured on ")]
    hosts = (here, elsewhere)
    assert measured == [f"Measured on {run.described(host)}: simulators." for host in hosts]


def test_markdown_as_aligned_text() -> None:
    markdown = (
        "**A\\_b**\n\n| who | us |\n| --- | ---: |\n| ours | 1 |\n| a \\| b | 10 |\n\nNote.\n"
    )
    assert run.plain(markdown) == (
        "A_b\n\nwho    us\n-----  --\nours    1\na | b  10\n\nNote.\n"
    )  # fmt: skip


def parts() -> Iterator[Any]:
    yield from run.read(run.RESULTS).items()


def test_the_page_says_what_was_measured() -> None:
    assert run.PAGE.read_text(encoding="utf-8") == run.page(dict(parts()))
