"""`stribeck select`: its table, its files, its refusals, and Ctrl-C."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from command import caller
from stribeck import read_card
from stribeck.identify.selection.candidate_fit import candidate_fit
from stribeck.identify.selection.friction_change import friction_change
from stribeck.identify.selection.trained_law import train_law
from test_select_truth import write_directional_logs


@pytest.fixture
def stribeck_(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Any:
    """Run a command in a folder with logs a.csv and b.csv of a directional axis, and map.toml."""
    write_directional_logs(tmp_path, "abc", 10.0)
    monkeypatch.chdir(tmp_path)
    return caller(monkeypatch, capsys)


OPTIONS = ("--rig", "forced", "--laws", "coulomb-viscous,coulomb-viscous-directional,stribeck",
       "--set", "v_SS=10")  # fmt: skip


def test_the_table_names_the_recommended_law_and_says_why(stribeck_: Any) -> None:
    completed = stribeck_("select", "a.csv", *OPTIONS, "--test", "b.csv", "c.csv")
    assert completed.status == 0
    lines = completed.out.splitlines()
    assert lines[0].rstrip() == "laws on forced, held out: 2 test logs; → recommended"
    (recommended,) = [line for line in lines[1:] if line.startswith("→")]
    assert recommended.split()[1] == "coulomb-viscous-directional"
    (sentence,) = [line for line in lines if " is recommended" in line]
    assert sentence.startswith("coulomb-viscous-directional is recommended")
    assert "Parameters of their own for each direction: warranted." in completed.out
    assert [line.split(":")[0] for line in completed.err.splitlines()] == [
        name + part
        for name in ("coulomb-viscous", "coulomb-viscous-directional", "stribeck")
        for part in ("", ", intervals")
    ]


def test_what_was_done_to_a_log_is_told_by_select_and_plan(stribeck_: Any, tmp_path: Path) -> None:
    """A clock that starts anywhere: no warning, and no secret."""
    table = pl.read_csv(tmp_path / "a.csv")
    time = table.columns[0]
    table.with_columns(pl.col(time) + 500.0).write_csv(tmp_path / "a.csv")
    note = "a.csv: time counts from the first sample, 500"
    completed = stribeck_("select", "a.csv", *OPTIONS, "--test", "b.csv")
    assert f"note: {note}" in completed.out
    completed = stribeck_("select", "a.csv", *OPTIONS, "--test", "b.csv", "--json")
    assert any(n.startswith(note) for n in json.loads(completed.out)["notes"])
    stribeck_("identify", "a.csv", "--rig", "forced", "--out", "d", "--no-figures")
    completed = stribeck_("plan", "d/card.json", "a.csv")
    assert completed.status == 0, completed.err
    assert f"note: {note}" in completed.out


def test_the_tables_fit_a_terminal_of_80_columns(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    completed = stribeck_("select", "a.csv", *OPTIONS, "--test", "b.csv")
    names = ("coulomb-viscous", "coulomb-viscous-directional", "stribeck")
    lines = completed.out.splitlines()
    for name in names:  # each law is one line in each of the two tables
        assert sum(name in line.split() for line in lines[: lines.index("") + 6]) == 2
    assert max(map(len, lines)) <= 80


def test_the_folder_has_the_comparison_the_card_and_the_figure(
    stribeck_: Any, tmp_path: Path
) -> None:
    completed = stribeck_("select", "a.csv", *OPTIONS, "--test", "b.csv", "--out", "d", "--json")
    assert completed.status == 0
    files = sorted(p.name for p in (tmp_path / "d").iterdir())
    assert files == ["card.json", "selection.json", "selection.png", "selection.svg"]
    selection = json.loads(completed.out)
    assert (
        json.loads((tmp_path / "d" / "selection.json").read_text())["laws"][0]["law"]
        == (selection["laws"][0]["law"])
    )
    assert selection["schema"] == "stribeck-selection/1"
    assert selection["recommended"] == read_card(tmp_path / "d" / "card.json").law
    assert selection["held_out"]["kind"] == "hold-out"
    assert [d["role"] for d in selection["data"]] == ["train", "test"]
    best = next(law for law in selection["laws"] if law["law"] == selection["best"])
    assert best["against_best"] is None
    for law in selection["laws"]:
        assert best["held_out_error"] <= law["held_out_error"]
    # The card goes on where the comparison ended: the same error on the same log.
    validation = stribeck_("validate", "d/card.json", "b.csv", "--json")
    (score,) = json.loads(validation.out)["scores"]
    recommended = next(law for law in selection["laws"] if law["law"] == selection["recommended"])
    assert score["value"] == pytest.approx(recommended["held_out_error"], rel=1e-9)


def test_ctrl_c_keeps_the_laws_that_are_done(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def interrupted(parameters: Any, *arguments: Any, **options: Any) -> Any:
        if parameters.law.name == "stribeck":
            raise KeyboardInterrupt
        return train_law(parameters, *arguments, **options)

    monkeypatch.setattr("stribeck.identify.selection.select.train_law", interrupted)
    completed = stribeck_("select", "a.csv", *OPTIONS, "--test", "b.csv", "--out", "d")
    assert completed.status == 130
    last = "stribeck: interrupted: the partial result is in d, without stribeck"
    assert completed.err.splitlines()[-1] == last
    assert "Interrupted: stribeck was not compared." in completed.out
    selection = json.loads((tmp_path / "d" / "selection.json").read_text())
    assert selection["interrupted"]
    assert selection["left_out"] == ["stribeck"]
    assert len(selection["laws"]) == 2


def once_interrupted(function: Any) -> Any:
    """The function, interrupted when it is called first."""
    calls: list[int] = []

    def interrupted(*arguments: Any, **options: Any) -> Any:
        calls.append(1)
        if len(calls) == 1:
            raise KeyboardInterrupt
        return function(*arguments, **options)

    return interrupted


def test_ctrl_c_while_laws_are_compared_loses_none(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    compare = once_interrupted(friction_change)
    monkeypatch.setattr("stribeck.identify.selection.select.friction_change", compare)
    completed = stribeck_("select", "a.csv", *OPTIONS, "--test", "b.csv", "--out", "d")
    assert completed.status == 130
    assert completed.err.splitlines()[-1] == "stribeck: interrupted: the result is in d"
    selection = json.loads((tmp_path / "d" / "selection.json").read_text())
    assert selection["interrupted"]
    assert len(selection["laws"]) == 3
    assert (tmp_path / "d" / "card.json").exists()


def test_ctrl_c_while_the_card_is_made_keeps_the_comparison(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    fit = once_interrupted(candidate_fit)
    monkeypatch.setattr("stribeck.identify.selection.select.candidate_fit", fit)
    (tmp_path / "d").mkdir()
    for name in ("card.json", "report.html", "selection.svg", "notes.txt"):
        (tmp_path / "d" / name).write_text("older", encoding="utf-8")
    completed = stribeck_("select", "a.csv", *OPTIONS, "--test", "b.csv", "--out", "d")
    assert completed.status == 130
    last = completed.err.splitlines()[-1]
    assert last.startswith("stribeck: interrupted: the result is in d, without its card of coulomb")
    assert last.endswith(" and figure")
    assert sorted(p.name for p in (tmp_path / "d").iterdir()) == ["notes.txt", "selection.json"]
    assert " is recommended" in completed.out


def test_ctrl_c_before_a_law_is_done_writes_nothing(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def interrupted(*_: Any, **__: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr("stribeck.identify.selection.select.train_law", interrupted)
    completed = stribeck_("select", "a.csv", *OPTIONS, "--out", "d")
    assert completed.status == 130
    assert completed.err.splitlines()[-1] == (
        "stribeck: interrupted before there was a result: nothing was written"
    )
    assert not (tmp_path / "d").exists()


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["a.csv", "--rig", "forced", "--laws", "coulomb"], "no law 'coulomb': there are"),
        (["a.csv", "--rig", "forced", "--laws", ","], "no law was given"),
        (["a.csv", "--rig", "forced", "--set", "bogus=1"], "no law here has a parameter 'bogus'"),
        (["a.csv", "--rig", "forced", "--test", "a.csv"], "the same log as"),
        (["--rig", "forced", "--test", "a.csv", "b.csv"], "Missing argument 'LOG'"),
        (["a.csv", "--rig", "forced", "--holdout", "1s:4s"], "give --train as well"),
        (["a.csv", "--rig", "forced", "--folds", "400"], "is too short for 400 folds"),
        (["a.csv", "--rig", "forced", "--out", "a.csv"], "is a file, not a folder"),
        (["a.csv", "--rig", "forced", "--laws", "lugre"], "inner states"),
    ],
)
def test_what_is_asked_wrongly_is_one_line(
    stribeck_: Any, arguments: list[str], line: str, tmp_path: Path
) -> None:
    before = sorted(tmp_path.iterdir())
    completed = stribeck_("select", *arguments)
    assert completed.status == 2
    assert completed.out == ""
    last = completed.err.splitlines()[-1]
    assert last.startswith("stribeck: ")
    assert line in last
    assert sorted(tmp_path.iterdir()) == before
