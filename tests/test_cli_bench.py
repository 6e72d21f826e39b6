"""`stribeck bench`: results, resuming, and refusals in one line."""

from __future__ import annotations

import csv
import importlib.util
import json
import os
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import polars as pl
import pytest

from command import Completed, caller
from patience import PATIENCE
from stribeck import cli
from stribeck.bench.study import Study

SMALL = """
name = "small"
seed = 3
repeats = 4
budget = 500

[[problem]]
surface = ["BF", "RF"]
target = 0.05

[[method]]
name = "bts"
method = "bts"
unit_free = true

[[method]]
name = "random"
method = "random"
"""
#: Long enough to be interrupted: many short runs, minutes of them.
LONG = SMALL.replace("repeats = 4", "repeats = 1_000")
#: The command line, with a line of progress after every run.
CODE = """
from stribeck.bench import progress
progress.PACE = 0.0
from stribeck.cli import main
main()
"""


def start(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", CODE, "bench", *arguments],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"MPLBACKEND": "agg"},
    )  # fmt: skip


@pytest.fixture
def bench(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Completed]:
    """A function that runs `stribeck bench` in a folder, in this process, without figures."""
    monkeypatch.setattr(Study, "figures", lambda _: iter(()))
    run = caller(monkeypatch, capsys)

    def bench(folder: Path, *arguments: str) -> Completed:
        monkeypatch.chdir(folder)
        return run("bench", *arguments)

    return bench


def content(file: Path) -> list[tuple[object, ...]]:
    """All records and traces, without their seconds."""
    with sqlite3.connect(file) as db:
        return db.execute(
            "SELECT r.problem, r.algorithm, r.repeat, r.cost, r.evaluations, r.ended, r.x, "
            "r.rounds, r.events, t.evaluations, t.rounds, t.costs FROM records r JOIN traces t "
            "USING (job) ORDER BY r.problem, r.algorithm, r.repeat"
        ).fetchall()


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the small campaign, run."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "small.toml").write_text(SMALL)
    process = start(folder, "small.toml", "--engine", "here", "--out", "out")
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    (folder / "printed.txt").write_text(out)
    return folder


def test_a_campaign_leaves_store_tables_figures_and_a_page(finished: Path) -> None:
    folder = finished / "out"
    assert len(content(folder / "store.sqlite")) == 16
    assert (folder / "campaign.toml").read_text() == SMALL
    for ending in ("txt", "md", "tex", "csv"):
        assert (folder / "tables" / f"summary.{ending}").stat().st_size > 0
    for name in ("ecdf", "success", "convergence_rounds", "movements_BF"):
        assert (folder / "figures" / f"{name}.png").read_bytes()[:4] == b"\x89PNG"
        assert "<svg" in (folder / "figures" / f"{name}.svg").read_text()
    assert "<table" in (folder / "summary.html").read_text()
    records = pl.read_parquet(folder / "records.parquet")
    assert records.equals(pl.read_csv(folder / "records.csv", schema=records.schema))
    assert records.height == 16


def test_what_is_printed_is_what_was_written(finished: Path) -> None:
    printed = (finished / "printed.txt").read_text()
    summary = (finished / "out" / "tables" / "summary.txt").read_text()
    assert summary in printed
    rows = content(finished / "out" / "store.sqlite")
    reached = sum(r[:2] == ("BF", "bts") and r[5] == "target" for r in rows)
    (line,) = [k for k in summary.splitlines() if k.startswith("BF") and " bts " in k]
    assert f"{reached}/4" in line


def test_the_store_has_the_records_table_that_scripts_rely_on(finished: Path) -> None:
    with sqlite3.connect(finished / "out" / "store.sqlite") as db:
        rows = db.execute(
            "SELECT problem, algorithm, repeat, cost, evaluations, ended FROM records"
        ).fetchall()
    assert {r[:3] for r in rows} == {
        (p, a, k) for p in ("BF", "RF") for a in ("bts", "random") for k in range(4)
    }
    for _, _, _, cost, evaluations, ended in rows:
        assert (cost <= 0.05) == (ended == "target")
        assert evaluations <= 500


def test_the_same_command_again_runs_nothing_and_says_the_same(
    finished: Path, bench: Callable[..., Completed]
) -> None:
    before = content(finished / "out" / "store.sqlite")
    with sqlite3.connect(finished / "out" / "store.sqlite") as db:
        seconds = db.execute("SELECT job, seconds FROM records").fetchall()
    completed = bench(finished, "small.toml", "--engine", "here", "--out", "out", "--resume")
    assert completed.status == 0
    assert completed.out == (finished / "printed.txt").read_text()
    assert content(finished / "out" / "store.sqlite") == before
    with sqlite3.connect(finished / "out" / "store.sqlite") as db:
        assert db.execute("SELECT job, seconds FROM records").fetchall() == seconds


def test_the_store_says_what_is_done_and_what_is_left(
    finished: Path, tmp_path: Path, bench: Callable[..., Completed]
) -> None:
    completed = bench(finished, "small.toml", "--out", "out", "--status")
    assert completed.status == 0
    assert completed.out.startswith("16 of 16 runs are done\n")
    (tmp_path / "out").mkdir()
    copy = tmp_path / "out" / "store.sqlite"
    copy.write_bytes((finished / "out" / "store.sqlite").read_bytes())
    with sqlite3.connect(copy) as db:
        db.executescript("DELETE FROM traces; DELETE FROM records WHERE problem = 'RF'")
    (tmp_path / "small.toml").write_text(SMALL)
    completed = bench(tmp_path, "small.toml", "--out", "out", "--status")
    assert completed.out.startswith("8 of 16 runs are done\n")
    rows = [
        line.split()[:4] for line in completed.out.splitlines() if line.startswith(("BF", "RF"))
    ]
    assert sorted(rows) == [
        [p, a, n, "4"] for p, n in (("BF", "4"), ("RF", "0")) for a in ("bts", "random")
    ]


def test_a_campaign_as_json(finished: Path, bench: Callable[..., Completed]) -> None:
    """The tables are those of the folder, in full."""
    arguments = ("small.toml", "--engine", "here", "--out", "out")
    answer = json.loads(bench(finished, *arguments, "--json").out)
    assert (answer["campaign"], answer["runs"], answer["failed"]) == ("small", 16, 0)
    table = answer["tables"]["summary"]
    with (finished / "out" / "tables" / "summary.csv").open(newline="") as file:
        heads, *rows = csv.reader(file)
    assert table["heads"] == heads
    finite = [[cell.removeprefix("inf") for cell in row] for row in rows]
    assert [["" if v is None else str(v) for v in row] for row in table["rows"]] == finite
    told = json.loads(bench(finished, *arguments, "--status", "--json").out)
    assert [cell["done"] for cell in told["cells"]] == [4] * 4
    shown = json.loads(bench(finished, "small.toml", "--show", "--json").out)
    assert shown["campaign"]["problem"] == [{"surface": ["BF", "RF"], "target": 0.05}]


def test_more_trials_add_to_what_is_there(
    finished: Path, tmp_path: Path, bench: Callable[..., Completed]
) -> None:
    (tmp_path / "small.toml").write_text(SMALL)
    completed = bench(tmp_path, "small.toml", "--engine", "here", "--trials", "2", "--out", "out")
    assert completed.status == 0
    assert len(content(tmp_path / "out" / "store.sqlite")) == 8
    assert bench(tmp_path, "small.toml", "--engine", "here", "--out", "out").status == 0
    assert content(tmp_path / "out" / "store.sqlite") == content(finished / "out" / "store.sqlite")


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
@pytest.mark.parametrize("engine", ["here", "processes:2"])
def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(tmp_path: Path, engine: str) -> None:
    (tmp_path / "long.toml").write_text(LONG)
    process = start(tmp_path, "long.toml", "--engine", engine, "--out", "out")
    assert process.stderr is not None
    line = process.stderr.readline()  # the first line of progress: work has begun
    assert "runs" in line
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    last = err.splitlines()[-1]
    assert last.startswith("stribeck: interrupted: ")
    assert last.endswith("the others are safe in out/store.sqlite; the same command goes on")
    assert "Traceback" not in err
    assert not (tmp_path / "out" / "tables").exists()


@pytest.mark.skipif(
    not all(map(importlib.util.find_spec, ("cocoex", "cocopp", "six"))),
    reason="COCO is not installed",
)
def test_bbob_runs_can_be_had_in_cocos_own_form(
    tmp_path: Path, bench: Callable[..., Completed], monkeypatch: pytest.MonkeyPatch
) -> None:
    # COCO's own pages take long: that they are made is shown where it is called, in test_coco.
    monkeypatch.setattr("stribeck.bench.coco.postprocess", lambda folder: folder / "page.html")
    bbob = SMALL.replace('surface = ["BF", "RF"]', "bbob = 1").replace("repeats = 4", "repeats = 2")
    (tmp_path / "small.toml").write_text(bbob)
    theirs = tmp_path / "out" / "exdata" / "random"  # the user's own, of another study
    theirs.mkdir(parents=True)
    completed = bench(tmp_path, "small.toml", "--engine", "here", "--out", "out", "--coco")
    assert completed.status == 0, completed.err
    assert "COCO's report: out/coco/page.html" in completed.out
    runs = sorted(p.name for p in (tmp_path / "out" / "coco" / "exdata").iterdir())
    assert runs == ["bts", "random"]
    assert theirs.exists()


def test_a_shipped_campaign_can_be_printed_and_changed(
    tmp_path: Path, bench: Callable[..., Completed]
) -> None:
    shown = bench(tmp_path, "paper", "--show")
    assert shown.status == 0
    assert 'name = "paper"' in shown.out
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["papers"], "no campaign 'papers': there are bbob, paper, twins"),
        (["none.toml"], "none.toml: no such file"),
        (["bad.toml"], "bad.toml: not TOML"),
        (["unknown.toml"], "unknown.toml: method 'bts' on BF: no method 'bfs'"),
        (["negative.toml"], "negative.toml: budget: input should be greater than or equal to 1"),
        (["twice.toml"], "twice.toml: problem 'BF' is there twice"),
        (["small.toml", "--trials", "0"], "--trials must be at least 1, got 0"),
        (["small.toml", "--trials", "x"], "--trials: 'x' is not a whole number"),
        (["small.toml", "--engine", "gpu"], "no engine 'gpu': there are here, processes"),
        (["small.toml", "--engine", "processes:0"], "no engine 'processes:0': there are"),
        (["small.toml", "--engine", "dask://nowhere"], "no engine 'dask://nowhere': there are"),
        (["small.toml", "--status"], "bench-small/store.sqlite: there is no store"),
        (["small.toml", "--coco"], "--coco: campaign small has no problem of BBOB"),
        (["small.toml", "--resume"], "there is no store to go on with"),
        (["small.toml", "--out", "small.toml"], "small.toml: is a file, not a folder"),
        (["small.toml", "--out", "foreign"], "foreign/store.sqlite: is not a store of a campaign"),
        (["small.toml", "--out", "other"], "not of 'small' with seed 4: take another --out"),
        ([], "Missing argument"),
    ],
    ids=lambda v: " ".join(v) if isinstance(v, list) else "",
)  # fmt: skip
def test_what_cannot_be_done_is_one_line(
    finished: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    arguments: list[str],
    line: str,
) -> None:
    files = {
        "small.toml": SMALL,
        "bad.toml": "name = ",
        "unknown.toml": SMALL.replace('method = "bts"', 'method = "bfs"'),
        "negative.toml": SMALL.replace("budget = 500", "budget = -500"),
        "twice.toml": SMALL.replace('"RF"', '"BF"'),
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / "store.sqlite").write_text("this is a diary, not a data base")
    (tmp_path / "other").mkdir()
    theirs = (finished / "out" / "store.sqlite").read_bytes()
    (tmp_path / "other" / "store.sqlite").write_bytes(theirs)
    if "other" in arguments:
        (tmp_path / "small.toml").write_text(SMALL.replace("seed = 3", "seed = 4"))
    before = {p: p.read_bytes() for p in sorted(tmp_path.rglob("*")) if p.is_file()}
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["stribeck", "bench", *arguments])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    out, err = capfd.readouterr()
    assert ended.value.code == 2
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("stribeck: ")
    assert line in err
    assert {p: p.read_bytes() for p in sorted(tmp_path.rglob("*")) if p.is_file()} == before


def test_a_campaign_of_methods_that_are_not_installed_runs_nothing(
    bench: Callable[..., Completed], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    present = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "dfols" else present(name)
    )
    answer = bench(tmp_path, "twins", "--out", "twins")
    assert answer.status == 2
    assert "methods need dfols, not installed here: pip install 'stribeck[bench]'" in answer.err
    assert not (tmp_path / "twins").exists()
    assert bench(tmp_path, "twins", "--show").status == 0
