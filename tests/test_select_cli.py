"""`stribeck select`: its table, its files, its refusals, and Ctrl-C."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import caller
from stribeck import read_card
from stribeck.identify.selection.trained_law import train_law
from test_select_truth import log


@pytest.fixture
def stribeck_(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Any:
    """Run a command in a folder with logs a.csv and b.csv of a directional axis, and map.toml."""
    for seed, name in enumerate(("a", "b", "c")):
        given = log("coulomb-viscous-directional", seed, seconds=10.0)
        assert given.force is not None
        table = np.column_stack([given.t, given.position, given.force])
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", comments="",
                   header="t [s],position [m],force [N]", fmt="%.9g")  # fmt: skip
    monkeypatch.chdir(tmp_path)
    return caller(monkeypatch, capsys)


ASK = ("--rig", "forced", "--laws", "coulomb-viscous,coulomb-viscous-directional,stribeck",
       "--set", "v_SS=10")  # fmt: skip


def test_the_table_names_the_recommended_law_and_says_why(stribeck_: Any) -> None:
    said = stribeck_("select", "a.csv", *ASK, "--test", "b.csv", "c.csv")
    assert said.status == 0
    lines = said.out.splitlines()
    assert lines[0].rstrip() == "laws on forced, held out: 2 test logs; → recommended"
    (taken,) = [line for line in lines[1:] if line.startswith("→")]
    assert taken.split()[1] == "coulomb-viscous-directional"
    (sentence,) = [line for line in lines if " is recommended" in line]
    assert sentence.startswith("coulomb-viscous-directional is recommended")
    assert "Parameters of their own for each direction: warranted." in said.out
    assert [line.split(":")[0] for line in said.err.splitlines()] == [
        name + part
        for name in ("coulomb-viscous", "coulomb-viscous-directional", "stribeck")
        for part in ("", ", intervals")
    ]


def test_the_tables_fit_a_terminal_of_80_columns(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    said = stribeck_("select", "a.csv", *ASK, "--test", "b.csv")
    names = ("coulomb-viscous", "coulomb-viscous-directional", "stribeck")
    lines = said.out.splitlines()
    for name in names:  # each law is one line in each of the two tables
        assert sum(name in line.split() for line in lines[: lines.index("") + 6]) == 2
    assert max(map(len, lines)) <= 80


def test_the_folder_has_the_comparison_the_card_and_the_figure(
    stribeck_: Any, tmp_path: Path
) -> None:
    said = stribeck_("select", "a.csv", *ASK, "--test", "b.csv", "--out", "d", "--json")
    assert said.status == 0
    files = sorted(p.name for p in (tmp_path / "d").iterdir())
    assert files == ["card.json", "selection.json", "selection.png", "selection.svg"]
    found = json.loads(said.out)
    assert (
        json.loads((tmp_path / "d" / "selection.json").read_text())["laws"][0]["law"]
        == (found["laws"][0]["law"])
    )
    assert found["schema"] == "stribeck-selection/1"
    assert found["recommended"] == read_card(tmp_path / "d" / "card.json").law
    assert found["held_out"]["kind"] == "hold-out"
    assert [d["role"] for d in found["data"]] == ["train", "test"]
    best = next(law for law in found["laws"] if law["law"] == found["best"])
    assert best["against_best"] is None
    for law in found["laws"]:
        assert best["held_out_error"] <= law["held_out_error"]
    # The card goes on where the comparison ended: the same error on the same log.
    again = stribeck_("validate", "d/card.json", "b.csv", "--json")
    (score,) = json.loads(again.out)["scores"]
    taken = next(law for law in found["laws"] if law["law"] == found["recommended"])
    assert score["value"] == pytest.approx(taken["held_out_error"], rel=1e-9)


def test_ctrl_c_keeps_the_laws_that_are_done(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def interrupted(made: Any, *rest: Any, **more: Any) -> Any:
        if made.law.name == "stribeck":
            raise KeyboardInterrupt
        return train_law(made, *rest, **more)

    monkeypatch.setattr("stribeck.identify.selection.select.train_law", interrupted)
    said = stribeck_("select", "a.csv", *ASK, "--test", "b.csv", "--out", "d")
    assert said.status == 130
    last = "stribeck: interrupted: the partial result is in d, without stribeck"
    assert said.err.splitlines()[-1] == last
    assert "Interrupted: stribeck was not compared." in said.out
    found = json.loads((tmp_path / "d" / "selection.json").read_text())
    assert found["interrupted"]
    assert found["left_out"] == ["stribeck"]
    assert len(found["laws"]) == 2


def test_ctrl_c_before_a_law_is_done_writes_nothing(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def interrupted(*_: Any, **__: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr("stribeck.identify.selection.select.train_law", interrupted)
    said = stribeck_("select", "a.csv", *ASK, "--out", "d")
    assert said.status == 130
    assert said.err.splitlines()[-1] == (
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
        (["--rig", "forced", "--test", "a.csv", "b.csv"], "Missing argument 'LOG...'"),
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
    said = stribeck_("select", *arguments)
    assert said.status == 2
    assert said.out == ""
    last = said.err.splitlines()[-1]
    assert last.startswith("stribeck: ")
    assert line in last
    assert sorted(tmp_path.iterdir()) == before
