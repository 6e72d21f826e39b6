"""The command line and Python say the same things by the same words, and in full."""

from __future__ import annotations

import inspect
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stribeck
from command import caller
from stribeck.cli import command_line
from stribeck.cli.completions import TARGETS

GROUP = command_line()
#: Options of the command line alone: what is printed, and what stands for several words.
PRINTED = {"json", "out", "help", "quiet", "figures"}
#: The keyword of an option that has another name in Python, and why.
OTHER = {
    "identify": {
        "set": "constants",  # and `fixed`, for what is no constant; `set` is a type in Python
        "setting": "settings",  # all at once
        "directional": "law",  # stribeck-directional
        "paper": "method",  # bts, target=4.5, repeats=1, polishing=False
    },
    "select": {"set": "constants"},
    "check": {"rig": "columns"},  # columns=RIGS[name].columns
    "validate": {"range": "within", "max_error": "model"},  # a type in Python; an exit status
    "compensate": {
        "card": "model",  # or the fit
        "resolution": "sensor",  # Sensor(resolution, noise)
        "noise": "sensor",
    },
    "plan": {"card": "model"},
    "simulate": {"card": "model"},
    "export": {"card": "model", "set": "settings"},
    "report": {"folder": "model"},
    "twin": {},
}
OTHER["validate"]["card"] = "model"
#: How logs are read is one argument in Python, `columns={"columns": {...}, "joint": "2"}`, and
#: `read(..., keep_map=True)` keeps it.
READING = dict.fromkeys(
    ("column", "joint", "rate", "time_unit", "stamp", "episode", "save_map"), "columns"
)
#: Keywords of Python alone: objects that no command line can hold, and units, which a map holds.
PYTHON = {
    "identify": {"units", "fixed", "progress", "polishing"},
    "select": {"units", "fixed", "progress"},
    "check": {"units"},
    "validate": {"units"},
    "compensate": {"units", "beside", "progress", "logs"},
    "plan": {"units", "count"},
    "simulate": {"units"},
    "export": set(),
    "report": {"out"},
    "twin": set(),
}


@pytest.mark.parametrize("name", OTHER)
def test_options_and_keywords_have_the_same_names(name: str) -> None:
    keywords = set(inspect.signature(getattr(stribeck, name)).parameters)
    options = {
        (p.opts[0] if p.param_type_name == "option" else p.name or "").strip("-").replace("-", "_")
        for p in GROUP.commands[name].params
    } - PRINTED
    other = OTHER[name] | (READING if "column" in options else {})
    assert set(other) <= options, "an exception that is none"
    in_python = {other.get(option, option) for option in options} - {"model"} | (
        {"model"} & keywords
    )
    assert in_python | PYTHON[name] == keywords


def test_completions_know_the_targets() -> None:
    assert tuple(stribeck.TARGETS) == TARGETS


@pytest.mark.parametrize("name", GROUP.commands)
def test_help_says_types_that_people_read_and_defaults(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = caller(monkeypatch, capsys)(name, "--help").out
    assert "<" not in page.replace("J < 4.5", "")
    assert "[default: 0]" not in page or name in ("twin", "plan")
    assert "None" not in page
    assert all(option.help for option in GROUP.commands[name].params if hasattr(option, "help"))


def test_the_list_of_commands_is_not_cut_off(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    page = caller(monkeypatch, capsys)("--help").out
    assert "..." not in page.replace("[ARGS]...", "")
    assert "--install-completion" in page


# --- completion ---------------------------------------------------------------------------------


def completed(line: str) -> list[str]:
    """What bash is told that may come next."""
    environment = {
        **os.environ,
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(line.split(" ")) - 1),
        "_STRIBECK_COMPLETE": "complete_bash",
    }
    told = subprocess.run(
        [sys.executable, "-m", "stribeck"], capture_output=True, text=True, env=environment,
        check=False,
    )  # fmt: skip
    assert told.stderr == ""
    return told.stdout.split()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("stribeck iden", ["identify"]),
        ("stribeck identify a.csv --rig forced-", ["forced-rotary", "forced-pendulum"]),
        ("stribeck identify a.csv --law dah", ["dahl"]),
        ("stribeck select a.csv --laws stribeck,dah", ["stribeck,dahl"]),
        ("stribeck identify a.csv --method mb", ["mbts"]),
        ("stribeck export card.json --to pl", ["plcopen"]),
        ("stribeck rigs cyl", ["cylinder"]),
        ("stribeck identify a.csv --hol", ["--holdout"]),
        ("stribeck identify my_log", []),  # then bash completes files
    ],
)
def test_a_shell_completes(line: str, words: list[str]) -> None:
    assert completed(line) == words


def test_completion_is_installed_into_a_home(tmp_path: Path) -> None:
    named = {"HOME": str(tmp_path), "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}
    environment = {**os.environ, **named}
    subprocess.run(
        [sys.executable, "-m", "stribeck", "--install-completion", "bash"],
        env=environment, check=True, capture_output=True,
    )  # fmt: skip
    (script,) = tmp_path.rglob("*stribeck*")
    assert "_STRIBECK_COMPLETE=complete_bash" in script.read_text()
    assert "complete -o default" in script.read_text()  # files, where nothing else fits


# --- what is printed ----------------------------------------------------------------------------

T = np.arange(0, 8, 0.004)
V = 0.2 * np.sin(2 * T)
X = 0.1 * (1 - np.cos(2 * T))
F = 4.0 * np.sign(V) + 10.0 * V + 2.0 * 0.4 * np.cos(2 * T)


def write(path: Path, **columns: np.ndarray) -> None:
    rows = zip(*columns.values(), strict=True)
    text = [",".join(columns), *(",".join(f"{v:.9g}" for v in row) for row in rows)]
    path.write_text("\n".join(text) + "\n")


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    write(tmp_path / "force.csv", t_s=T, x_m=X, F_N=F)
    write(tmp_path / "bare.csv", t_s=T, x_m=X)
    write(tmp_path / "joint.csv", t_s=T, q_rad=X, q_cmd_rad=X)
    write(tmp_path / "torque.csv", t_s=T, q_rad=X, tau_Nm=F)
    write(tmp_path / "valve.csv", t_s=T, x_m=X, F_N=F, p_bar=F)
    monkeypatch.chdir(tmp_path)
    return caller(monkeypatch, capsys)


@pytest.mark.parametrize(
    ("log", "rig"),
    [("force.csv", "forced"), ("torque.csv", "forced-rotary"), ("valve.csv", "cylinder"),
     ("joint.csv", "joint")],
)  # fmt: skip
def test_a_log_without_a_rig_is_told_the_likely_one_and_the_command(
    run: Any, log: str, rig: str
) -> None:
    told = run("identify", log, "--law", "coulomb-viscous")
    assert told.status == 2
    assert re.search(f"^→ +{rig} ", told.out, re.MULTILINE)
    (line,) = told.err.splitlines()
    assert f"{log} suggests {rig} (" in line
    assert line.endswith(f"): stribeck identify {log} --law coulomb-viscous --rig {rig}")
    assert json.loads(run("check", log, "--json").out)["rig"] == rig


def test_a_log_that_suggests_no_rig_says_what_it_lacks(run: Any) -> None:
    told = run("select", "bare.csv", "--json")
    assert (told.status, told.out) == (2, "")
    assert "suggests none: no measured force and no stick-slip: record the force" in told.err


def test_a_force_in_percent_is_named_where_no_rig_is_suggested(run: Any, tmp_path: Path) -> None:
    rows = "\n".join(f"{k},{k % 7},{k % 3}" for k in range(50))
    (tmp_path / "percent.csv").write_text(f"Time [ms],ActPos [mm],ActTorque [%]\n{rows}\n")
    for options in ((), ("--rig", "forced")):
        told = run("identify", str(tmp_path / "percent.csv"), *options)
        assert told.status == 2
        assert "column ActTorque [%] is in %" in told.err
        assert "`stribeck drives` shows what that can be" in told.err


def test_quiet_prints_nothing_and_no_figures_draws_none(run: Any, tmp_path: Path) -> None:
    command = ("identify", "force.csv", "--rig", "forced", "--law", "coulomb-viscous")
    told = run(*command, "--out", "fit", "--quiet", "--no-figures")
    assert told == (0, "", "")
    assert sorted(p.name for p in (tmp_path / "fit").iterdir()) == [
        "card.json", "report.html", "report.json",
    ]  # fmt: skip
    assert run(*command, "--quiet").status == 2
    assert run(*command, "--no-figures").status == 2
    quiet = run(*command, "--quiet", "--json")
    assert json.loads(quiet.out)["law"] == "coulomb-viscous"


def test_an_export_gets_the_extension_of_its_format(run: Any, tmp_path: Path) -> None:
    run("identify", "force.csv", "--rig", "forced", "--law", "coulomb-viscous", "--out", "fit",
        "--quiet", "--no-figures")  # fmt: skip
    card = "fit/card.json"
    assert run("export", card, "--to", "table", "--out", "axis").out == "axis.csv\n"
    assert (tmp_path / "axis.csv").read_text()
    assert "name it" in run("export", card, "--to", "table", "--out", "axis.txt").err
    document = json.loads(run("export", card, "--to", "c", "--out", "c", "--json").out)
    assert [Path(f).name for f in document["files"]] == ["friction.h", "friction.c", "selftest.c"]
    (note,) = json.loads(run("export", card, "--to", "table", "--out", "a", "--json").out)["notes"]
    assert note.startswith("the table is off by at most")


@pytest.mark.parametrize("name", ["laws", "methods", "rigs", "drives", "readers"])
def test_lists_are_json_too_and_nothing_is_padded(run: Any, name: str) -> None:
    document = json.loads(run(name, "--json").out)
    first = next(iter(document))
    assert set(json.loads(run(name, first, "--json").out)) == {first}
    for told in (run(name), run(name, first)):
        assert told.status == 0
        assert not [line for line in told.out.splitlines() if line != line.rstrip()]


def test_how_a_log_was_read_is_a_note_and_no_warning(run: Any, tmp_path: Path) -> None:
    """The same log, its rows named otherwise and some of them twice: nothing speaks against it."""
    rows = (tmp_path / "force.csv").read_text().splitlines()
    (tmp_path / "twice.csv").write_text("\n".join([*rows[:9], *rows[8:]]) + "\n")
    for name in ("force", "twice"):
        run("identify", f"{name}.csv", "--rig", "forced", "--law", "coulomb-viscous", "--out", name,
            "--no-figures")  # fmt: skip
    once, twice = (json.loads((tmp_path / n / "card.json").read_text()) for n in ("force", "twice"))
    assert twice["warnings"] == once["warnings"]
    assert (once["notes"], twice["notes"]) == ([], ["twice.csv: 1 exact duplicate row dropped"])
    verdicts = [[p["verdict"] for p in c["parameters"].values()] for c in (once, twice)]
    assert verdicts[0] == verdicts[1]
    told = run("identify", "twice.csv", "--rig", "forced", "--law", "coulomb-viscous")
    assert "note: twice.csv: 1 exact duplicate row dropped" in told.out.splitlines()
    page = (tmp_path / "twice" / "report.html").read_text()
    assert '<p class="note">Note: twice.csv: 1 exact duplicate row dropped.</p>' in page
    assert f"{len(once['warnings'])} warning" in page
    assert re.search(
        r"^note +1 exact duplicate row dropped$", run("check", "twice.csv").out, re.MULTILINE
    )


# --- before a log is read -----------------------------------------------------------------------

ASKED = {
    "identify": [
        ("law", "strbeck", "no law 'strbeck'"),
        ("rig", "slide-bd", "no rig 'slide-bd'"),
        ("method", "mbtz", "no method 'mbtz'"),
        ("loss", "squared", "loss 'squared' is not one of squares, absolute"),
        ("breakaway", "any", "breakaway 'any' is not one of"),
        ("velocity", "best", "velocity 'best': give auto, recorded, position"),
        ("velocity", "recorded", "rig slide-bed is simulated: it reads no velocity"),
        ("repeats", 0, "repeats must be a whole number >= 1"),
    ],
    "select": [
        ("laws", "strbeck", "no law 'strbeck'"),
        ("rig", "slide-bd", "no rig 'slide-bd'"),
        ("loss", "squared", "loss 'squared' is not one of squares, absolute"),
        ("velocity", "best", "velocity 'best': give auto, recorded, position"),
        ("folds", 1, "folds must be a whole number >= 2"),
    ],
}  # fmt: skip


@pytest.mark.parametrize(
    ("command", "name", "value", "words"),
    [(command, *row) for command, rows in ASKED.items() for row in rows],
)
def test_what_is_misspelt_is_refused_before_a_log_is_read(
    run: Any, tmp_path: Path, command: str, name: str, value: Any, words: str
) -> None:
    (tmp_path / "not_a.log").write_text("Dear colleague,\nthe log follows.\n")
    options = {"rig": "slide-bed", name: value}
    typed = [w for n, v in options.items() for w in (f"--{n}", str(v))]
    told = run(command, "not_a.log", *typed)
    assert (told.status, told.out) == (2, "")
    assert (f"--{words}" if words.startswith(f"{name} ") else words) in told.err
    if name == "laws":
        options[name] = [value]
    with pytest.raises(stribeck.InputError, match=re.escape(words)):
        getattr(stribeck, command)(tmp_path / "not_a.log", **options)
