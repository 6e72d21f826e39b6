"""A fleet: each axis identified once, the same table however often it is killed."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import polars as pl
import pytest

import fleet_logs
from browser import CHROMIUM, NO_CHROMIUM, browser
from fleet_logs import TRUE, force_log, simulated_fleet
from stribeck import InputError, fleet, identify
from stribeck.fleet.axis_job import AxisRecord, axis_jobs
from stribeck.fleet.fleet_progress import FleetProgress
from stribeck.fleet.fleet_table import read_table
from stribeck.fleet.manifest import read_manifest
from stribeck.fleet.table_columns import COLUMNS, VERSION

AXES, BAD = 12, 2


def table_of(folder: Path) -> pl.DataFrame:
    """The table without the one column that differs from run to run."""
    return read_table(folder).drop("seconds")


@pytest.fixture(scope="module")
def manifest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fleet")
    rows = list(simulated_fleet(folder, AXES))
    pl.DataFrame(rows).write_csv(folder / "fleet.csv")
    return folder / "fleet.csv"


@pytest.fixture(scope="module")
def undisturbed(manifest: Path, tmp_path_factory: pytest.TempPathFactory) -> pl.DataFrame:
    out = tmp_path_factory.mktemp("undisturbed")
    result = fleet(manifest, out)
    assert (result.done, result.refused, result.failed) == (AXES - 3, 3, 0)
    return table_of(out)


def test_killed_twice_and_resumed_ends_with_the_same_table(
    manifest: Path, undisturbed: pl.DataFrame, tmp_path: Path
) -> None:
    command = [sys.executable, "-P", fleet_logs.__file__, str(manifest), str(tmp_path)]
    lines = []
    for kills in range(2):
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout
            lines += [int(process.stdout.readline()) for _ in range(3 + kills)]
            process.kill()
    finished: list[int] = []
    result = fleet(manifest, tmp_path, progress=lambda _, left: finished.append(left))
    assert (result.done, result.refused) == (AXES - 3, 3)
    assert lines[:3] == [AXES - 1, AXES - 2, AXES - 3]
    assert lines[3] < lines[2]  # it went on, and did not begin anew
    assert len(finished) < AXES - 6
    assert table_of(tmp_path).equals(undisturbed)
    again: list[Any] = []
    fleet(manifest, tmp_path, progress=lambda outcome, _: again.append(outcome))
    assert again == []  # nothing is run twice
    assert table_of(tmp_path).equals(undisturbed)


def test_processes_give_the_same_table(
    manifest: Path, undisturbed: pl.DataFrame, tmp_path: Path
) -> None:
    fleet(manifest, tmp_path, engine="processes:2")
    assert table_of(tmp_path).equals(undisturbed)


def test_the_table_has_what_identify_finds(manifest: Path, undisturbed: pl.DataFrame) -> None:
    row = next(
        r for r in read_manifest(manifest).rows if (manifest.parent / r.log).stat().st_size > 999
    )
    fit = identify(row.log, rig="forced")
    rows = undisturbed.filter(pl.col("axis") == row.axis)
    assert rows["parameter"].to_list() == list(fit.card().parameters)
    for name, parameter in fit.card().parameters.items():
        (entry,) = rows.filter(pl.col("parameter") == name).to_dicts()
        assert entry["value"] == parameter.value
        assert (entry["low"], entry["high"]) == (parameter.low, parameter.high)
        assert (entry["unit"], entry["verdict"]) == (parameter.unit, parameter.verdict)
    assert rows["data_hash"].unique().to_list() == [fit.recordings[0].source.sha256]
    assert rows["travel"][0] == pytest.approx(0.0993, rel=0.001)  # cos^2 t = 0.13/0.24
    assert rows["speed_high"][0] < 0.05 + 0.06  # its greatest speed


def test_a_bad_log_is_one_row_with_its_reason(undisturbed: pl.DataFrame) -> None:
    refused = undisturbed.filter(pl.col("status") == "refused")
    assert len(refused) == refused["axis"].n_unique() == 3
    assert refused["parameter"].null_count() == 3
    assert all(".csv" in reason for reason in refused["reason"])
    assert undisturbed.columns == [c for c in COLUMNS if c != "seconds"]


def test_a_log_that_has_changed_is_identified_anew(tmp_path: Path) -> None:
    rows = [{"axis": "x", "log": str(tmp_path / "x.csv"), "rig": "forced"}]
    force_log(tmp_path / "x.csv")
    before = fleet(rows, tmp_path / "out").table()
    force_log(tmp_path / "x.csv", F_C=2 * TRUE["F_C"])
    after = fleet(rows, tmp_path / "out").table()
    levels = [t.filter(pl.col("parameter") == "F_C")["value"].item() for t in (before, after)]
    assert levels[1] / levels[0] == pytest.approx(2.0, rel=0.05)


def test_what_left_the_manifest_left_the_table(tmp_path: Path) -> None:
    rows = list(simulated_fleet(tmp_path, 4, bad=1.0))
    fleet(rows, tmp_path / "out")
    fleet(rows[:1], tmp_path / "out")
    assert read_table(tmp_path / "out")["axis"].to_list() == ["axis 0"]
    assert len(list((tmp_path / "out" / "table").rglob("*.parquet"))) == 1


def test_a_pattern_stands_for_rows(tmp_path: Path) -> None:
    for machine, axis, day in [("M1", "x", "03"), ("M1", "y", "03"), ("M2", "x", "14")]:
        folder = tmp_path / "logs" / machine
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{axis}_202603{day}.csv").touch()
    (tmp_path / "fleet.toml").write_text(
        '[defaults]\nrig = "forced"\ntemperature = 21\n'
        '[[pattern]]\nlog = "logs/{machine}/{axis}_{when}.csv"\nwhen_format = "%Y%m%d"\n'
        '[[axis]]\naxis = 7\nlog = "*.csv"\nholdout = "1:2; 3:4"\n',
        encoding="utf-8",
    )
    rows = read_manifest(tmp_path / "fleet.toml").rows
    assert [(r.machine, r.axis, r.when and f"{r.when:%d}") for r in rows] == [
        ("-", "7", None), ("M1", "x", "03"), ("M1", "y", "03"), ("M2", "x", "14"),
    ]  # fmt: skip
    assert rows[0].holdout == ("1:2", "3:4")
    assert {r.temperature for r in rows} == {21.0}


def test_csv_toml_parquet_and_rows_say_the_same(tmp_path: Path) -> None:
    row = {"axis": "x", "log": str(tmp_path / "x.csv"), "rig": "forced", "when": "2026-05-04T10:00"}
    pl.DataFrame([row]).write_csv(tmp_path / "a.csv")
    pl.DataFrame([row]).write_csv(tmp_path / "b.csv", separator=";")
    pl.DataFrame([row]).with_columns(pl.col("when").str.to_datetime()).write_parquet(
        tmp_path / "a.parquet"
    )
    lines = [f"{name} = {json.dumps(value)}" for name, value in row.items()]
    (tmp_path / "a.toml").write_text("[[axis]]\n" + "\n".join(lines), encoding="utf-8")
    sources: list[Any] = [[row], *(tmp_path / n for n in ("a.csv", "b.csv", "a.parquet", "a.toml"))]
    assert len({next(axis_jobs(read_manifest(s))).key for s in sources}) == 1


def test_the_page_has_every_axis_and_every_reason(
    manifest: Path, undisturbed: pl.DataFrame, tmp_path: Path
) -> None:
    fleet(manifest, tmp_path)
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    for row in undisturbed.iter_rows(named=True):
        assert f"<td>{row['axis']}</td>" in text
        assert row["reason"] is None or row["reason"] in text
    assert text.count('<svg class="series"') == undisturbed.height - BAD - 1
    assert "src=" not in text  # it needs no other file


@pytest.mark.skipif(CHROMIUM is None, reason=NO_CHROMIUM)
def test_the_heads_of_the_page_sort(manifest: Path, tmp_path: Path) -> None:
    fleet(manifest, tmp_path)
    body = "[...document.querySelector('.sortable tbody').rows]"
    shown = f"{body}.map(r => r.cells[3].dataset.value)"
    press = "document.querySelectorAll('.sortable thead button')[3].click()"
    with browser(tmp_path) as page:
        page.open(tmp_path / "index.html")
        before = [float(v) for v in page.run(shown)]
        page.run(press)
        upwards = [float(v) for v in page.run(shown)]
        page.run(press)
        downwards = [float(v) for v in page.run(shown)]
        assert page.complaints == []
    assert before != sorted(before)
    assert upwards == sorted(before)
    assert downwards == upwards[::-1]


def test_the_report_of_an_axis_is_of_the_fit_in_the_table(
    manifest: Path, undisturbed: pl.DataFrame, tmp_path: Path
) -> None:
    result = fleet(manifest, tmp_path)
    axis = undisturbed.filter(pl.col("status") == "done")["axis"][0]
    page = result.report(manifest, axis)
    card = json.loads((page.parent / "card.json").read_text(encoding="utf-8"))
    rows = undisturbed.filter(pl.col("axis") == axis)
    values = dict(rows.select("parameter", "value").iter_rows())
    assert {name: p["value"] for name, p in card["parameters"].items()} == values
    with pytest.raises(InputError, match=r"^report nobody: the manifest has no such axis"):
        result.report(manifest, "nobody")


def test_the_columns_are_documented() -> None:
    page = (Path(__file__).parents[1] / "docs" / "fleet.md").read_text(encoding="utf-8")
    assert f"version `{VERSION}`" in page
    for name, column in COLUMNS.items():
        assert re.search(rf"\| `{name}` \| [a-z ]+ \| {re.escape(column.doc)} \|", page), name


BAD_MANIFESTS = {
    "axis,log\nx,x.csv\n": "row 1: column rig: is missing",
    "axis,log,rig\nx,x.csv,forced\n,y.csv,forced\n": "row 2: column axis: is missing",
    "axis,log,rig,wen\nx,x.csv,forced,\n": "row 1: column wen: is no column: there are axis, log",
    "axis,log,rig,when\nx,x.csv,forced,14.3.2026\n": "row 1: column when: '14.3.2026' is no time",
    "axis,log,rig,law\nx,x.csv,forced,dahhl\n": "row 1: column law: no law 'dahhl'",
    "axis,log,rig,temperature\nx,x.csv,forced,warm\n": "column temperature: 'warm' is not a number",
    "axis,log,rig,columns\nx,x.csv,forced,no.toml\n": "row 1: column columns: no.toml",
    "axis,log,rig\nx,x.csv,forced\nx,x.csv,forced\n": "row 2: the same machine, axis, time and log",
    "axis,log,rig\n": "has no rows",
    "": "cannot be read as CSV",
}  # fmt: skip


@pytest.mark.parametrize("text", BAD_MANIFESTS)
def test_a_bad_manifest_is_refused_with_row_and_column(text: str, tmp_path: Path) -> None:
    file = tmp_path / "fleet.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as refused:
        fleet(file, tmp_path / "out")
    assert str(refused.value).startswith(f"{file}: ")
    assert BAD_MANIFESTS[text] in str(refused.value)
    assert not (tmp_path / "out").exists()


def test_time_left_is_that_of_the_axes_to_come(
    manifest: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    now = 0.0
    clock: Callable[[], float] = lambda: now  # noqa: E731 - a clock that is set by hand
    progress = FleetProgress(sys.stderr, clock)
    job = next(axis_jobs(read_manifest(manifest)))
    for now in (10.0, 20.0):
        progress(AxisRecord(job, "done"), 8 - int(now / 10))
    progress(AxisRecord(job, "refused", "no table"), 5)
    progress(3, 5)
    now = 30.0
    progress(AxisRecord(job, "done"), 0)
    assert capsys.readouterr().err.splitlines() == [
        "1/8 axes, 70 s left",
        "2/8 axes, 60 s left",
        "4/4 axes, 1 refused",
    ]
