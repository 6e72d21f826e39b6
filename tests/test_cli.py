"""The command line where nothing is wrong: what it prints, writes and returns."""

import csv
import json
import os
import re
import signal
import subprocess
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stribeck
from command import Completed, caller
from patience import PATIENCE
from stribeck import LAWS, METHODS, RIGS, cli, read, read_card
from stribeck.identify.polish import polish_run

COMMAND = [sys.executable, "-m", "stribeck"]
QUICK = ("--rig", "slide-bed", "--budget", "40", "--repeats", "2", "--seed", "3")


SPLIT = ("--train", "112:295", "--holdout", "44:112")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a log `up.csv` and a fit of it in `fit`."""
    folder = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for arguments in (
            ["twin", "up.csv", "--direction", "up", "--seed", "1"],
            ["identify", "up.csv", *QUICK, *SPLIT, "--out", "fit"],
        ):
            patch.setattr(sys, "argv", ["stribeck", *arguments])
            cli.main()
    return folder


@pytest.fixture
def stribeck_(
    made: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Any:
    """Run a command in the folder of `made`."""
    monkeypatch.chdir(made)
    return caller(monkeypatch, capsys)


def test_twin_keeps_the_truth_beside_the_log_and_not_in_it(made: Path) -> None:
    truth = json.loads((made / "up.truth.json").read_text())
    assert truth["schema"] == "stribeck-truth/1"
    assert (truth["log"], truth["seed"], truth["direction"]) == ("up.csv", 1, "up")
    published = {"F_S+": (144.5463, "N"), "F_C+": (47.8514, "N"), "F_V+": (0.9583, "N s/mm"),
                 "v_SS+": (1.0964, "mm/s"), "k_spring+": (0.96798, "N/mm")}  # fmt: skip
    for name, (value, unit) in published.items():
        assert truth["parameters"][name] == {"value": pytest.approx(value), "unit": unit}
    log = (made / "up.csv").read_text()
    assert log.splitlines()[0] == "t_s,command_mm,position_mm,velocity_mm_s,current_A,force_N"
    assert "144.54" not in log
    recording = read(made / "up.csv")
    assert recording.command is not None
    np.testing.assert_allclose(recording.command[[0, -1]], [0.05, 0.35], atol=1e-9)


def test_twin_is_a_function_of_its_seed(stribeck_: Any, made: Path) -> None:
    for name, seed in (("a.csv", "1"), ("b.csv", "2")):
        said = stribeck_("twin", name, "--direction", "up", "--seed", seed)
        assert said == Completed(0, f"{name}\n{name[0]}.truth.json\n", "")
    same, other = (made / "a.csv").read_bytes(), (made / "b.csv").read_bytes()
    assert same == (made / "up.csv").read_bytes()
    assert other != same


def test_twin_without_noise_rests_where_the_slide_rests(stribeck_: Any, made: Path) -> None:
    said = stribeck_("twin", "quiet.csv", "--direction", "down", "--noise", "0", "--rate", "50",
                     "--echo-rate", "50", "--speed", "10")  # fmt: skip
    assert said.status == 0
    recording = read(made / "quiet.csv")
    assert recording.dt == pytest.approx(0.02)
    assert recording.position[0] == pytest.approx(0.352, abs=0.4 / 4096)
    assert np.ptp(recording.position[:20]) == 0.0


def test_check(stribeck_: Any) -> None:
    said = stribeck_("check", "up.csv")
    assert said.status == 0
    assert not said.err
    assert "6201 in 62 s, 100 Hz" in said.out
    assert "stick-slip present" in said.out
    found = json.loads(stribeck_("check", "up.csv", "--json").out)
    assert found["schema"] == "stribeck-quality/1"
    assert len(found["slips"]) >= 5


def test_a_card_has_the_published_form(stribeck_: Any, made: Path) -> None:
    said = stribeck_(
        "identify", "up.csv", *QUICK, "--train", "112:295", "--holdout", "44:112", "--json"
    )
    assert said.status == 0
    assert not said.err
    found = json.loads(said.out)
    assert (found["schema"], found["law"], found["rig"]) == (
        "stribeck-card/1",
        "stribeck",
        "slide-bed",
    )
    assert list(found["parameters"]) == ["F_S", "F_C", "F_V", "v_SS", "k_spring"]
    for part in found["parameters"].values():
        assert {"value", "unit", "low", "high", "at_bound", "verdict"} <= part.keys()
        assert part["low"] <= part["value"] <= part["high"]
    assert found["objective"]["name"] == "position_rmse"
    assert found["objective"]["unit"] == "mm"
    assert [h["range"] for h in found["holdout"]] == ["44:112"]
    assert found["search"]["method"] == "mbts"
    assert found["search"]["seed"] == 3
    assert found["search"]["evaluations"] <= 2 * 40
    (data,) = found["data"]
    assert (data["file"], data["rows"]) == ("up.csv", 6201)
    assert 0 < data["used"] < 6201
    assert found["software"]["stribeck"] == stribeck.__version__
    on_disk = json.loads((made / "fit" / "card.json").read_text())
    for card in (found, on_disk):
        del card["search"]["seconds"]
    assert found == on_disk  # the same job, the same answer


def test_identify_writes_its_figures_and_tells_the_baselines(stribeck_: Any, made: Path) -> None:
    assert {p.name for p in (made / "fit").iterdir()} >= {
        "card.json", "training.png", "training.svg", "holdout_44_112.png", "friction.svg",
        "stribeck_curve.png", "convergence.png",
    }  # fmt: skip
    said = stribeck_("identify", "up.csv", *QUICK)
    for word in ("F_S", "k_spring", "never moves", "smooth, no stick-slip", "in 2 repeats"):
        assert word in said.out


def test_set_holds_and_bounds_free_and_ties_bind(stribeck_: Any) -> None:
    held = ("--set", "F_fm=20", "--set", "F_S+=150", "--set", "F_S-=150")
    shaped = ("--tie", "F_C-=F_C+", "--bounds", "exponent=0.8:1.2")
    said = stribeck_("identify", "up.csv", *QUICK, "--directional", *held, *shaped, "--json")
    found = json.loads(said.out)
    values = found["parameters"]
    assert found["law"] == "stribeck-directional"
    assert found["constants"] == {"F_fm": {"value": 20.0, "unit": "N"}}
    assert (values["F_S+"]["value"], values["F_S+"]["verdict"]) == (150.0, "fixed")
    assert values["F_C-"]["value"] == values["F_C+"]["value"]
    assert 0.8 <= values["exponent"]["value"] <= 1.2


def test_an_overlap_of_training_and_hold_out_is_told(stribeck_: Any) -> None:
    apart = stribeck_("identify", "up.csv", *QUICK, "--train", "112:295", "--holdout", "44:112")
    shared = stribeck_("identify", "up.csv", *QUICK, "--train", "112:295", "--holdout", "200:300")
    every = stribeck_("identify", "up.csv", *QUICK, "--holdout", "44:112")
    assert "overlaps" not in apart.out
    assert "hold-out 200:300 overlaps the training data" in shared.out
    assert "hold-out 44:112 overlaps the training data" in every.out


@pytest.mark.parametrize("budget", [1, 2, 3, 7, 50])
def test_small_budgets_are_kept(stribeck_: Any, budget: int) -> None:
    one = ("--rig", "slide-bed", "--budget", str(budget), "--repeats", "1")
    said = stribeck_("identify", "up.csv", *one, "--json")
    assert said.status == 0
    assert not said.err
    assert 1 <= json.loads(said.out)["search"]["evaluations"] <= budget


def test_validate_repeats_what_identify_found(stribeck_: Any, made: Path) -> None:
    card = read_card(made / "fit" / "card.json")
    said = stribeck_(
        "validate", "fit/card.json", "up.csv", "--range", "112:295", "--range", "44:112", "--json"
    )
    assert said.status == 0
    found = json.loads(said.out)
    assert found["schema"] == "stribeck-validation/1"
    values = [score["value"] for score in found["scores"]]
    assert values == pytest.approx([card.objective.value, card.holdout[0].value], rel=1e-12)
    loose, tight = str(max(values) * 1.01), str(max(values) * 0.99)
    again = ("validate", "fit/card.json", "up.csv", "--range", "112:295", "--range", "44:112")
    assert stribeck_(*again, "--max-error", loose).status == 0
    assert stribeck_(*again, "--max-error", tight).status == 1


def test_a_simulated_motion_is_a_log(stribeck_: Any, made: Path) -> None:
    said = stribeck_("simulate", "fit/card.json", "up.csv", "--out", "motion.csv")
    assert said == Completed(0, "motion.csv\n", "")
    motion, log = read(made / "motion.csv"), read(made / "up.csv")
    np.testing.assert_allclose(motion.t, log.t, atol=1e-9)
    made_, p = read_card(made / "fit" / "card.json").model()
    expected = made_.rig.simulate(made_.law, p[None], log)
    np.testing.assert_allclose(motion.position, expected.position[0], atol=1e-11)
    with (made / "motion.csv").open() as f:
        assert next(csv.reader(f)) == ["t_s", "position_mm", "velocity_mm_s", "force_N"]


@pytest.mark.parametrize(
    ("command", "table"), [("laws", LAWS), ("methods", METHODS), ("rigs", RIGS)]
)
def test_lists_name_everything_and_explain_each(stribeck_: Any, command: str, table: Any) -> None:
    said = stribeck_(command)
    assert said.status == 0
    for name in table:
        assert f"\n{name} " in said.out
        each = stribeck_(command, name)
        assert each.status == 0
        assert each.out.startswith(f"{name}: ")


def test_every_setting_of_every_method_has_a_meaning(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    for name in METHODS:
        said = stribeck_("methods", name).out
        for setting in fields(METHODS[name]):  # type: ignore[arg-type]
            row = rf'^ *{setting.name} +(\S+|\(.*\)|<.*>) +[A-Z"]\S+'
            assert re.search(row, said, re.MULTILINE), f"{name}: {setting.name}"


def test_version_and_help(stribeck_: Any) -> None:
    for asked in ("version", "--version"):
        assert stribeck_(asked) == Completed(0, f"{stribeck.__version__}\n", "")
    for arguments in ([], ["--help"], ["-h"], ["identify", "--help"]):
        said = stribeck_(*arguments)
        assert said.status == 0
        assert said.out.startswith("Usage: stribeck")
        assert not said.err


def test_names_with_brackets_are_names(stribeck_: Any, made: Path) -> None:
    rig = made / "r.toml"
    rig.write_text('kind = "slide-bed"\nname = "[red]axis[/x] :smile:"\n')
    said = stribeck_("identify", "up.csv", "--rig", "r.toml", "--budget", "5", "--repeats", "1")
    assert "stribeck on [red]axis[/x] :smile:" in said.out


def test_the_reader_of_the_output_may_leave(made: Path) -> None:
    for arguments in (["laws"], ["version"], ["validate", "fit/card.json", "up.csv"]):
        read_end, write_end = os.pipe()
        os.close(read_end)
        done = subprocess.run(
            [*COMMAND, *arguments], cwd=made, stdout=write_end, stderr=subprocess.PIPE, check=False
        )
        os.close(write_end)
        assert (done.returncode, done.stderr) == (141, b"")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a system without /dev/full")
def test_an_output_that_is_full_is_one_line(made: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*COMMAND, "laws"],
            cwd=made,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == "stribeck: output: No space left on device\n"


def searching(folder: Path, *more: str) -> subprocess.Popen[str]:
    """A search without end, after it has told its first progress."""
    process = subprocess.Popen(
        [*COMMAND, "identify", "up.csv", "--rig", "slide-bed", "--method", "bts",
         "--setting", "count_max=1000000000", "--budget", "1000000000", *more],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stderr is not None
    line = process.stderr.readline()
    assert "evaluations, best J" in line
    assert line.startswith(tuple("123456789"))
    return process


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_ctrl_c_leaves_a_usable_partial_result(made: Path, stribeck_: Any) -> None:
    process = searching(made, "--train", "112:295", "--out", "partial")
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    last = err.splitlines()[-1]
    assert last == "stribeck: interrupted: the partial result is in partial/card.json"
    assert "Traceback" not in err
    assert "warning: interrupted" in out
    card = read_card(made / "partial" / "card.json")
    assert card.search.ended == "interrupted"
    said = stribeck_("validate", "partial/card.json", "up.csv", "--range", "112:295", "--json")
    (score,) = json.loads(said.out)["scores"]
    assert score["value"] == pytest.approx(card.objective.value, rel=1e-12)


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_ctrl_c_before_a_folder_was_named_prints_the_result(made: Path) -> None:
    before = sorted(made.iterdir())
    process = searching(made, "--json")
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert err.splitlines()[-1] == "stribeck: interrupted: the partial result is printed above"
    assert json.loads(out)["search"]["ended"] == "interrupted"
    assert sorted(made.iterdir()) == before


def test_ctrl_c_before_anything_was_evaluated(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, made: Path
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    before = sorted(made.iterdir())
    monkeypatch.setattr("stribeck.data.read", interrupted)
    said = stribeck_("identify", "up.csv", *QUICK, "--out", "never")
    line = "stribeck: interrupted before there was a result: nothing was written\n"
    assert said == Completed(130, "", line)
    assert sorted(made.iterdir()) == before


def test_ctrl_c_while_polishing_keeps_the_search(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, made: Path
) -> None:
    polish = polish_run

    def interrupted(problem: Any, run: Any, allowance: int) -> Any:
        if allowance:
            raise KeyboardInterrupt
        return polish(problem, run, allowance)

    monkeypatch.setattr("stribeck.identify.multistart.polish_run", interrupted)
    said = stribeck_("identify", "up.csv", *QUICK, "--method", "bts", "--out", "unpolished")
    assert said.status == 130
    assert said.err == "stribeck: interrupted: the partial result is in unpolished/card.json\n"
    assert read_card(made / "unpolished" / "card.json").search.evaluations == 2 * 30


@pytest.mark.skipif(sys.platform != "linux", reason="a pseudo-terminal as Linux has it")
def test_a_terminal_sees_a_progress_bar(made: Path) -> None:
    import pty  # noqa: PLC0415 - not on every system

    parent, child = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, "identify", "up.csv", *QUICK], cwd=made, stdout=subprocess.PIPE, stderr=child,
        env=os.environ | {"TERM": "xterm", "COLUMNS": "100"}, text=True,
    )  # fmt: skip
    os.close(child)
    shown = b""
    try:
        while part := os.read(parent, 4096):
            shown += part
    except OSError:  # how Linux says that the other end was closed
        pass
    out, _ = process.communicate(timeout=PATIENCE)
    os.close(parent)
    assert process.returncode == 0
    assert b"evaluations" in shown
    assert "━".encode() in shown
    assert "━" not in out
