"""The command line on valid input: its output, files and exit status."""

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
from stribeck.space import Array

COMMAND = [sys.executable, "-m", "stribeck"]
QUICK = ("--rig", "slide-bed", "--budget", "40", "--repeats", "2", "--seed", "3")


SPLIT = ("--train", "112:295", "--holdout", "44:112")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a log `up.csv` and a fit of it in `fit`."""
    folder = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for arguments in (
            ["twin", "up.csv", "--direction", "up", "--loop", "ideal", "--seed", "1"],
            ["identify", "up.csv", *QUICK, *SPLIT, "--out", "fit"],
        ):
            patch.setattr(sys, "argv", ["stribeck", *arguments])
            cli.main()
    return folder


@pytest.fixture
def stribeck_(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Any:
    """A function that runs a command in the folder."""
    monkeypatch.chdir(folder)
    return caller(monkeypatch, capsys)


def test_twin_keeps_the_truth_beside_the_log_and_not_in_it(folder: Path) -> None:
    truth = json.loads((folder / "up.truth.json").read_text())
    assert truth["schema"] == "stribeck-truth/1"
    assert (truth["log"], truth["seed"], truth["direction"]) == ("up.csv", 1, "up")
    published = {"F_S+": (144.5463, "N"), "F_C+": (47.8514, "N"), "F_V+": (0.9583, "N s/mm"),
                 "v_SS+": (1.0964, "mm/s"), "k_spring+": (0.96798, "N/mm")}  # fmt: skip
    for name, (value, unit) in published.items():
        assert truth["parameters"][name] == {"value": pytest.approx(value), "unit": unit}
    log = (folder / "up.csv").read_text()
    assert log.splitlines()[0] == "t_s,command_mm,position_mm,velocity_mm_s,current_A,force_N"
    assert "144.54" not in log
    recording = read(folder / "up.csv")
    assert recording.command is not None
    np.testing.assert_allclose(recording.command[[0, -1]], [0.05, 0.35], atol=1e-9)


def test_twin_is_a_function_of_its_seed(stribeck_: Any, folder: Path) -> None:
    for name, seed in (("a.csv", "1"), ("b.csv", "2")):
        completed = stribeck_("twin", name, "--direction", "up", "--loop", "ideal", "--seed", seed)
        assert completed == Completed(0, f"{name}\n{name[0]}.truth.json\n", "")
    repeated, reseeded = (folder / "a.csv").read_bytes(), (folder / "b.csv").read_bytes()
    assert repeated == (folder / "up.csv").read_bytes()
    assert reseeded != repeated


def test_twin_without_noise_rests_where_the_slide_rests(stribeck_: Any, folder: Path) -> None:
    options = ("--noise", "0", "--rate", "50", "--echo-rate", "50", "--speed", "10")
    completed = stribeck_("twin", "quiet.csv", "--direction", "down", *options)
    assert completed.status == 0
    recording = read(folder / "quiet.csv")
    assert recording.dt == pytest.approx(0.02)
    assert recording.position[0] == pytest.approx(0.352, abs=0.4 / 4096)
    assert np.ptp(recording.position[:20]) == 0.0


def test_check(stribeck_: Any) -> None:
    completed = stribeck_("check", "up.csv")
    assert completed.status == 0
    assert not completed.err
    assert "6201 in 62 s, 100 Hz" in completed.out
    assert "stick-slip present" in completed.out
    document = json.loads(stribeck_("check", "up.csv", "--json").out)
    assert document["schema"] == "stribeck-quality/1"
    assert len(document["slips"]) >= 5


def test_a_card_has_the_published_form(stribeck_: Any, folder: Path) -> None:
    completed = stribeck_(
        "identify", "up.csv", *QUICK, "--train", "112:295", "--holdout", "44:112", "--json"
    )
    assert completed.status == 0
    assert not completed.err
    document = json.loads(completed.out)
    assert (document["schema"], document["law"], document["rig"]) == (
        "stribeck-card/1",
        "stribeck",
        "slide-bed",
    )
    assert list(document["parameters"]) == ["F_S", "F_C", "F_V", "v_SS", "k_spring"]
    for part in document["parameters"].values():
        assert {"value", "unit", "low", "high", "at_bound", "verdict"} <= part.keys()
        assert part["low"] <= part["value"] <= part["high"]
    assert document["objective"]["name"] == "position_rmse"
    assert document["objective"]["unit"] == "mm"
    assert [h["range"] for h in document["holdout"]] == ["44:112"]
    assert document["search"]["method"] == "mbts"
    assert document["search"]["seed"] == 3
    assert document["search"]["evaluations"] <= 2 * 40
    (data,) = document["data"]
    assert (data["file"], data["rows"]) == ("up.csv", 6201)
    assert 0 < data["used"] < 6201
    assert document["software"]["stribeck"] == stribeck.__version__
    on_disk = json.loads((folder / "fit" / "card.json").read_text())
    for card in (document, on_disk):
        del card["search"]["seconds"]
    assert document == on_disk  # the same job, the same answer


def test_identify_writes_its_figures_and_tells_the_baselines(stribeck_: Any, folder: Path) -> None:
    assert {p.name for p in (folder / "fit").iterdir()} >= {
        "card.json", "training.png", "training.svg", "holdout_44_112.png", "friction.svg",
        "stribeck_curve.png", "convergence.png",
    }  # fmt: skip
    completed = stribeck_("identify", "up.csv", *QUICK)
    for word in ("F_S", "k_spring", "never moves", "smooth, no stick-slip", "in 2 repeats"):
        assert word in completed.out


def test_set_holds_and_bounds_free_and_ties_bind(stribeck_: Any) -> None:
    fixed = ("--set", "F_fm=20", "--set", "F_S+=150", "--set", "F_S-=150")
    shaped = ("--tie", "F_C-=F_C+", "--bounds", "exponent=0.8:1.2")
    completed = stribeck_("identify", "up.csv", *QUICK, "--directional", *fixed, *shaped, "--json")
    document = json.loads(completed.out)
    values = document["parameters"]
    assert document["law"] == "stribeck-directional"
    assert document["constants"]["F_fm"] == {
        "value": 20.0, "unit": "N", "origin": "yours", "tolerance": 0.0,
    }  # fmt: skip
    assert (values["F_S+"]["value"], values["F_S+"]["verdict"]) == (150.0, "fixed")
    assert values["F_C-"]["value"] == values["F_C+"]["value"]
    assert 0.8 <= values["exponent"]["value"] <= 1.2


def test_an_overlap_of_training_and_hold_out_is_told(stribeck_: Any) -> None:
    disjoint = stribeck_("identify", "up.csv", *QUICK, "--train", "112:295", "--holdout", "44:112")
    shared = stribeck_("identify", "up.csv", *QUICK, "--train", "112:295", "--holdout", "200:300")
    overlapping = stribeck_("identify", "up.csv", *QUICK, "--holdout", "44:112")
    assert "overlaps" not in disjoint.out
    assert "hold-out 200:300 overlaps the training data" in shared.out
    assert "hold-out 44:112 overlaps the training data" in overlapping.out


@pytest.mark.parametrize("budget", [1, 2, 3, 7, 50])
def test_small_budgets_are_kept(stribeck_: Any, budget: int) -> None:
    options = ("--rig", "slide-bed", "--budget", str(budget), "--repeats", "1")
    completed = stribeck_("identify", "up.csv", *options, "--json")
    assert completed.status == 0
    assert not completed.err
    assert 1 <= json.loads(completed.out)["search"]["evaluations"] <= budget


def test_validate_repeats_what_identify_found(stribeck_: Any, folder: Path) -> None:
    card = read_card(folder / "fit" / "card.json")
    completed = stribeck_(
        "validate", "fit/card.json", "up.csv", "--range", "112:295", "--range", "44:112", "--json"
    )
    assert completed.status == 0
    document = json.loads(completed.out)
    assert document["schema"] == "stribeck-validation/1"
    values = [score["value"] for score in document["scores"]]
    assert values == pytest.approx([card.objective.value, card.holdout[0].value], rel=1e-12)
    loose, tight = str(max(values) * 1.01), str(max(values) * 0.99)
    command = ("validate", "fit/card.json", "up.csv", "--range", "112:295", "--range", "44:112")
    assert stribeck_(*command, "--max-error", loose).status == 0
    assert stribeck_(*command, "--max-error", tight).status == 1


def test_validate_says_by_how_much_it_moves_a_log(stribeck_: Any, folder: Path) -> None:
    """The delay of a card's own logs need not be that of others."""
    t: Array = np.arange(2000, dtype=float) * 0.005
    x = 0.05 * np.sin(4.0 * t)
    v, a = 0.2 * np.cos(4.0 * t), -0.8 * np.sin(4.0 * t)
    force = 5.0 * a + 8.0 * np.sign(v) + 20.0 * v + 0.1 * np.random.default_rng(0).standard_normal(
        len(t)
    )  # fmt: skip
    rows = np.column_stack([t, x, force])
    np.savetxt(folder / "late.csv", rows, delimiter=",", header="t [s],x [m],F [N]", comments="")
    options = ("--rig", "forced", "--law", "coulomb-viscous", "--delay", "6", "--no-figures")
    assert stribeck_("identify", "late.csv", *options, "--out", "late").status == 0
    told = stribeck_("validate", "late/card.json", "late.csv")
    assert "taken to be 6 ms after the motion, as in the card's own logs" in told.err
    quiet = stribeck_("validate", "late/card.json", "late.csv", "--delay", "0")
    assert not quiet.err


def test_validate_says_what_it_takes_for_a_command_that_a_log_lacks(
    stribeck_: Any, folder: Path
) -> None:
    with (folder / "up.csv").open() as f:
        heads, *rows = csv.reader(f)
    kept = [k for k, head in enumerate(heads) if "command" not in head]
    assert len(kept) < len(heads)
    text = "\n".join(",".join(row[k] for k in kept) for row in (heads, *rows))
    (folder / "bare.csv").write_text(text + "\n", encoding="utf-8")
    told = stribeck_("validate", "fit/card.json", "bare.csv")
    assert told.status == 0
    assert "bare.csv: no command is in the log: a ramp from its beginning" in told.err


def test_a_simulated_motion_is_a_log(stribeck_: Any, folder: Path) -> None:
    completed = stribeck_("simulate", "fit/card.json", "up.csv", "--out", "motion.csv")
    assert completed == Completed(0, "motion.csv\n", "")
    motion, log = read(folder / "motion.csv"), read(folder / "up.csv")
    np.testing.assert_allclose(motion.t, log.t, atol=1e-9)
    parameters, p = read_card(folder / "fit" / "card.json").model()
    expected = parameters.rig.simulate(parameters.law, p[None], log)
    np.testing.assert_allclose(motion.position, expected.position[0], atol=1e-11)
    with (folder / "motion.csv").open() as f:
        assert next(csv.reader(f)) == ["t_s", "position_mm", "velocity_mm_s", "force_N"]


@pytest.mark.parametrize(
    ("command", "table"), [("laws", LAWS), ("methods", METHODS), ("rigs", RIGS)]
)
def test_lists_name_everything_and_explain_each(stribeck_: Any, command: str, table: Any) -> None:
    completed = stribeck_(command)
    assert completed.status == 0
    for name in table:
        assert f"\n{name} " in completed.out
        explained = stribeck_(command, name)
        assert explained.status == 0
        assert explained.out.startswith(f"{name}: ")


def test_every_setting_of_every_method_has_a_meaning(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "400")
    for name in METHODS:
        output = stribeck_("methods", name).out
        for setting in fields(METHODS[name]):  # type: ignore[arg-type]
            row = rf'^ *{setting.name} +(\S+|\(.*\)|<.*>) +[A-Z"]\S+'
            assert re.search(row, output, re.MULTILINE), f"{name}: {setting.name}"


def test_version_and_help(stribeck_: Any) -> None:
    for option in ("version", "--version"):
        assert stribeck_(option) == Completed(0, f"{stribeck.__version__}\n", "")
    for arguments in ([], ["--help"], ["-h"], ["identify", "--help"]):
        completed = stribeck_(*arguments)
        assert completed.status == 0
        assert completed.out.startswith("Usage: stribeck")
        assert not completed.err


def test_names_with_brackets_are_names(stribeck_: Any, folder: Path) -> None:
    rig = folder / "r.toml"
    rig.write_text('kind = "slide-bed"\nname = "[red]axis[/x] :smile:"\n')
    completed = stribeck_(
        "identify", "up.csv", "--rig", "r.toml", "--budget", "5", "--repeats", "1"
    )
    assert "stribeck on [red]axis[/x] :smile:" in completed.out


def test_the_reader_of_the_output_may_leave(folder: Path) -> None:
    for arguments in (["laws"], ["version"], ["validate", "fit/card.json", "up.csv"]):
        read_end, write_end = os.pipe()
        os.close(read_end)
        completed = subprocess.run(
            [*COMMAND, *arguments],
            cwd=folder,
            stdout=write_end,
            stderr=subprocess.PIPE,
            check=False,
        )
        os.close(write_end)
        assert (completed.returncode, completed.stderr) == (141, b"")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a system without /dev/full")
def test_an_output_that_is_full_is_one_line(folder: Path) -> None:
    with Path("/dev/full").open("w") as full:
        completed = subprocess.run(
            [*COMMAND, "laws"],
            cwd=folder,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert completed.returncode == 2
    assert completed.stderr == "stribeck: output: No space left on device\n"


def searching(folder: Path, *options: str) -> subprocess.Popen[str]:
    """A search without end, after its first line of progress."""
    process = subprocess.Popen(
        [*COMMAND, "identify", "up.csv", "--rig", "slide-bed", "--method", "bts",
         "--setting", "count_max=1000000000", "--budget", "1000000000", *options],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stderr is not None
    line = process.stderr.readline()
    assert "evaluations, best J" in line
    assert line.startswith(tuple("123456789"))
    return process


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_ctrl_c_leaves_a_usable_partial_result(folder: Path, stribeck_: Any) -> None:
    process = searching(folder, "--train", "112:295", "--out", "partial")
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    last = err.splitlines()[-1]
    assert last == "stribeck: interrupted: the partial result is in partial/card.json"
    assert "Traceback" not in err
    assert "warning: interrupted" in out
    card = read_card(folder / "partial" / "card.json")
    assert card.search.ended == "interrupted"
    completed = stribeck_("validate", "partial/card.json", "up.csv", "--range", "112:295", "--json")
    (score,) = json.loads(completed.out)["scores"]
    assert score["value"] == pytest.approx(card.objective.value, rel=1e-12)


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
def test_ctrl_c_before_a_folder_was_named_prints_the_result(folder: Path) -> None:
    before = sorted(folder.iterdir())
    process = searching(folder, "--json")
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert err.splitlines()[-1] == "stribeck: interrupted: the partial result is printed above"
    assert json.loads(out)["search"]["ended"] == "interrupted"
    assert sorted(folder.iterdir()) == before


def test_ctrl_c_before_anything_was_evaluated(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, folder: Path
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    before = sorted(folder.iterdir())
    monkeypatch.setattr("stribeck.rig.log_reading.read", interrupted)
    completed = stribeck_("identify", "up.csv", *QUICK, "--out", "never")
    line = "stribeck: interrupted before there was a result: nothing was written\n"
    assert completed == Completed(130, "", line)
    assert sorted(folder.iterdir()) == before


def test_ctrl_c_while_polishing_keeps_the_search(
    stribeck_: Any, monkeypatch: pytest.MonkeyPatch, folder: Path
) -> None:
    polish = polish_run

    def interrupted(problem: Any, run: Any, allowance: int) -> Any:
        if allowance:
            raise KeyboardInterrupt
        return polish(problem, run, allowance)

    monkeypatch.setattr("stribeck.identify.search_repeats.polish_run", interrupted)
    completed = stribeck_("identify", "up.csv", *QUICK, "--method", "bts", "--out", "unpolished")
    assert completed.status == 130
    assert completed.err == "stribeck: interrupted: the partial result is in unpolished/card.json\n"
    assert read_card(folder / "unpolished" / "card.json").search.evaluations == 2 * 30


@pytest.mark.skipif(sys.platform != "linux", reason="a pseudo-terminal as Linux has it")
def test_a_terminal_sees_a_progress_bar(folder: Path) -> None:
    import pty  # noqa: PLC0415 - not on every system

    parent, child = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, "identify", "up.csv", *QUICK], cwd=folder, stdout=subprocess.PIPE, stderr=child,
        env=os.environ | {"TERM": "xterm", "COLUMNS": "100"}, text=True,
    )  # fmt: skip
    os.close(child)
    shown = b""
    try:
        while part := os.read(parent, 4096):
            shown += part
    except OSError:  # on Linux, once the other end is closed
        pass
    out, _ = process.communicate(timeout=PATIENCE)
    os.close(parent)
    assert process.returncode == 0
    assert b"evaluations" in shown
    assert "━".encode() in shown
    assert "━" not in out
