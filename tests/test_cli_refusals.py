"""Refusals of the command line: one line that names the culprit, status 2, no file changed."""

import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from stribeck import cli
from stribeck.cli.arguments import REPEATABLE

Snapshot = dict[str, bytes | None]
QUICK = ("--rig", "slide-bed", "--budget", "20", "--repeats", "1")


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """A log, its card and a few bad files, as bytes by name."""
    folder = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        call(patch, "twin", "up.csv", "--direction", "up", "--loop", "ideal", "--seed", "1")
        call(patch, "identify", "up.csv", *QUICK, "--train", "112:295", "--out", "fit")
    log = (folder / "up.csv").read_text()
    thin = "\n".join(",".join(line.split(",")[:3]) for line in log.splitlines())
    smooth = "".join(f"{i * 0.01:.2f},{i * 0.05:.3f}\n" for i in range(500))
    idle = "".join(f"{i * 0.01:.2f},{i * 0.05:.3f},0\n" for i in range(500))
    dithered = "".join(f"{i * 0.01:.2f},{0.3 * (i % 7):.3f},{i % 7}\n" for i in range(500))
    moving = "".join(
        f"{i * 0.01:.2f},{60 * math.sin(0.05 * i):.3f},{math.copysign(9, math.cos(0.05 * i)):.3f}\n"
        for i in range(200)
    )
    huge = "".join(f"{i * 0.01:.2f},{i}e300,{i}e300\n" for i in range(500))
    angle = log.replace("command_mm", "command_deg").replace("position_mm", "position_deg")
    angle = "\n".join(",".join(line.split(",")[:3]) for line in angle.splitlines())
    return {
        "up.csv": log.encode(),
        "twin of up.csv": log.encode(),
        "thin.csv": thin.encode(),
        "smooth.csv": ("t_s,position_mm\n" + smooth).encode(),
        "angle.csv": angle.encode(),
        "dithered.csv": ("t_s,position_mm,force_N\n" + dithered).encode(),
        "idle.csv": ("t_s,position_mm,force_N\n" + idle).encode(),
        "moving.csv": ("t_s,position_mm,force_N\n" + moving).encode(),
        "huge.csv": ("t_s,position_m,force_N\n" + huge).encode(),
        "text.csv": b"hello world\n",
        "empty.csv": b"",
        "file": b"x",
        "card.json": (folder / "fit" / "card.json").read_bytes(),
    }


@pytest.fixture
def workdir(inputs: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory of a case, with the inputs."""
    for name, content in inputs.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "folder").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(patch: pytest.MonkeyPatch, *arguments: str) -> int:
    patch.setattr(sys, "argv", ["stribeck", *arguments])
    try:
        cli.main()
    except SystemExit as end:
        return int(end.code or 0)
    return 0


def content(folder: Path) -> Snapshot:
    return {str(p): p.read_bytes() if p.is_file() else None for p in sorted(folder.rglob("*"))}


@pytest.fixture
def refused(
    workdir: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., str]:
    """Run a command that must be refused, and return its one line."""

    def run(*arguments: str, status: int = 2) -> str:
        before = content(workdir)
        exit_status = call(monkeypatch, *arguments)
        output, text = capsys.readouterr()
        *table, line = text.splitlines(keepends=True)
        assert exit_status == status, text
        assert line.startswith("stribeck: ")
        assert not table or "taken as" in table[2]  # where columns cannot be told: what there is
        assert line.endswith("\n")
        assert line.rstrip("\n").isprintable()
        assert not output
        assert content(workdir) == before
        return line

    return run


IDENTIFY = [
    # the log
    (["nofile.csv"], ["nofile.csv", "no such file"]),
    (["folder"], ["folder", "name a log"]),
    (["text.csv"], ["text.csv", "no rows of numbers"]),
    (["empty.csv"], ["empty.csv", "is empty"]),
    (["file"], ["file", "no rows of numbers"]),
    ([os.devnull], ["null", "not a regular file"]),
    (["a\nb\x1b[31m.csv"], ["a b", "no such file"]),
    (["\udcff.csv"], ["no such file"]),
    (["é" * 3000 + ".csv"], ["too long"]),
    (["smooth.csv"], ["smooth.csv", "never rests"]),
    (["angle.csv"], ["angle.csv", "angle", "slide-bed"]),
    (["up.csv", "up.csv"], ["up.csv", "give it once"]),
    (["up.csv", "smooth.csv"], ["smooth.csv", "never rests"]),
    (["up.csv", "nofile.csv"], ["nofile.csv"]),
    # rig, law, method, settings
    (["up.csv", "--law", "nope"], ["'nope'", "stribeck-directional"]),
    (["up.csv", "--law", ""], ["empty"]),
    (["up.csv", "--out="], ["--out=", "empty"]),
    (["up.csv", "--method", "nope"], ["'nope'", "bts"]),
    (["up.csv", "--setting", "nope=1"], ["'nope'", "patience"]),
    (["up.csv", "--setting", "S=0"], ["S must", ">= 1", "got 0"]),
    (["up.csv", "--setting", "S=nan"], ["S must", "nan"]),
    (["up.csv", "--setting", "N_c"], ["--setting", "'N_c'", "NAME=VALUE"]),
    (["up.csv", "--method", "bts", "--setting", "AR=[1]"], ["AR", "pairs"]),
    (["up.csv", "--setting", "N_c=1", "--setting", "N_c=2"], ["N_c", "twice"]),
    # constants and parameters
    (["up.csv", "--set", "nope=1"], ["--set nope", "F_fm", "F_S"]),
    (["up.csv", "--set", "F_fm=abc"], ["--set F_fm", "'abc'"]),
    (["up.csv", "--set", "F_S=100±5"], ["--set F_S", "only constants have tolerances"]),
    (["up.csv", "--set", "f_s=100"], ["--set f_s", "is F_S meant?"]),
    (["up.csv", "--set", "F_fm=20 N"], ["--set F_fm", "'20 N'"]),
    (["up.csv", "--set", "F_fm=inf"], ["--set F_fm", "finite"]),
    (["up.csv", "--set", "ramp_speed=nan"], ["--set ramp_speed", "finite"]),
    (["up.csv", "--set", "F_fm="], ["--set", "NAME=VALUE"]),
    (["up.csv", "--set", "m=-1"], ["m = -1 kg", "above zero"]),
    (["up.csv", "--set", "F_S=30"], ["F_S = 30", "physical"]),
    (["up.csv", "--set", "F_S=1", "--set", "F_S=2"], ["--set", "F_S", "twice"]),
    (["up.csv", "--set", "F_S=150", "--bounds", "F_S=1:200"], ["F_S", "not two"]),
    (["up.csv", "--bounds", "F_S=2:1"], ["F_S", "2", "not below", "1"]),
    (["up.csv", "--bounds", "F_S=1:inf"], ["--bounds F_S", "finite"]),
    (["up.csv", "--bounds", "F_S=1"], ["--bounds F_S=1", "LO:HI"]),
    (["up.csv", "--bounds", "nope=1:2"], ["'nope'", "F_S"]),
    (["up.csv", "--tie", "F_S=F_S"], ["F_S", "cannot be tied"]),
    (["up.csv", "--tie", "F_S=v_SS"], ["F_S", "v_SS", "cannot be tied"]),
    (["up.csv", "--tie", "F_S"], ["--tie", "NAME=OTHER"]),
    # ranges
    (["up.csv", "--train", "abc"], ["'abc'", "A:B"]),
    (["up.csv", "--train", "112:112"], ["112:112", "differ"]),
    (["up.csv", "--train", "1e999:5"], ["1e999:5", "finite"]),
    (["up.csv", "--train", "900:1000"], ["900:1000", "43", "335"]),
    (["up.csv", "--train", "295:112"], ["295:112", "leftward"]),
    (["up.csv", "--train", "112N:295N"], ["112N:295N", "mm"]),
    (["up.csv", "--train", "112foo:295foo"], ["112foo", "'foo'"]),
    (["up.csv", "--train", "10s:295mm"], ["10s:295mm", "both in s"]),
    (["up.csv", "--train", "40s:10s"], ["40s:10s", "earlier time first"]),
    (["up.csv", "--train", "500s:600s"], ["500s:600s", "62 s"]),
    (["up.csv", "--train", "1:2", "--train", "1 : 2"], ["--train 1:2", "twice"]),
    (["up.csv", "--holdout", "900:1000"], ["900:1000"]),
    # numbers
    (["up.csv", "--seed", "-1"], ["seed", "-1"]),
    (["up.csv", "--seed", "1.5"], ["--seed", "'1.5'", "whole number"]),
    (["up.csv", "--seed", "1", "--seed", "2"], ["--seed", "twice"]),
    (["up.csv", "--target", "nan"], ["--target", "nan"]),
    (["up.csv", "--target", "-1"], ["--target", "-1"]),
    (["up.csv", "--target", "inf"], ["--target", "inf"]),
    # places to write to, files to read
    (["up.csv", "--out", "file"], ["file", "not a folder"]),
    (["up.csv", "--out", "x" * 300], ["too long"]),
    (["up.csv", "--columns", "no.toml"], ["no.toml", "no such file"]),
    (["up.csv", "--columns", "empty.csv"], ["empty.csv", "empty", "position"]),
    (["up.csv", "--columns", "/dev/zero"], ["zero", "not a regular file"]),
    (["up.csv", "--columns", "folder"], ["folder", "name a file"]),
    (["up.csv", "--nonsense"], ["--nonsense"]),
]


@pytest.mark.parametrize(("arguments", "words"), IDENTIFY, ids=lambda a: " ".join(a)[:40])
def test_identify(refused: Callable[..., str], arguments: list[str], words: list[str]) -> None:
    line = refused("identify", *arguments, *QUICK)
    assert [w for w in words if w not in line] == []


#: Ranges of a log of 2 s, of which a force balance takes a row every 0.1 s.
SHORT = [
    (["--train", "0s:0.05s"], ["0s:0.05s holds 5 samples", "widen"]),
    (["--train", "1.9s:2s"], ["fewer than 2 rows", "of the 10 samples", "0.1 s", "widen"]),
    (["--train", "0s:0.4s"], ["fewer than 2 rows", "first 0.49 s", "widen"]),
    (["--train", "0s:0.9s", "--law", "stribeck"], ["4 rows", "cannot tell 6", "widen", "--set"]),
    (["--train", "0s:1.5s", "--holdout", "1s:1.01s"], ["1s:1.01s holds 1 samples", "widen"]),
    (["--train", "0s:1.5s", "--holdout", "1s:1.1s"], ["range 1s:1.1s", "fewer than 2 rows"]),
]


@pytest.mark.parametrize(("arguments", "words"), SHORT, ids=lambda a: " ".join(a)[:40])
def test_ranges_too_short(
    refused: Callable[..., str], arguments: list[str], words: list[str]
) -> None:
    line = refused("identify", "moving.csv", "--rig", "forced", *arguments)
    assert [w for w in words if w not in line] == []


COMMANDS = [
    (["nonsense"], ["'nonsense'", "--help"]),
    (["identify"], ["LOG", "--help"]),
    (["identify", "up.csv", "--rig", "nope"], ["'nope'", "slide-bed"]),
    (["identify", "up.csv", "--rig", "no.toml"], ["no.toml", "no such file"]),
    (["identify", "up.csv", "--rig", "slide-bed", "--budget", "0"], ["budget", "0"]),
    (["identify", "up.csv", "--rig", "slide-bed", "--budget", "1e3"], ["--budget", "'1e3'"]),
    (["identify", "up.csv", "--rig", "slide-bed", "--repeats", "0"], ["repeats", "0"]),
    (
        ["identify", "up.csv", "--rig", "slide-bed", "--paper", "--budget", "5"],
        ["--paper", "--budget"],
    ),
    (
        ["identify", "up.csv", "--rig", "slide-bed", "--paper", "--setting", "N_c=3"],
        ["--paper", "--setting"],
    ),
    (["identify", "up.csv", "--rig", "forced", "--paper"], ["--paper", "forced"]),
    (["identify", "up.csv", "--rig", "forced", "--method", "bts"], ["forced", "method"]),
    (["identify", "up.csv", "--rig", "forced", "--target", "3"], ["forced", "target"]),
    (["identify", "thin.csv", "--rig", "forced"], ["thin.csv", "force"]),
    (["identify", "up.csv", "--rig", "emps"], ["up.csv", "'t [s]'"]),
    (["identify", "idle.csv", "--rig", "forced"], ["no force to explain"]),
    (["identify", "dithered.csv", "--rig", "forced"], ["nowhere beyond its own error"]),
    (["identify", "huge.csv", "--rig", "forced"], ["huge.csv", "position", "unit"]),
    (["check", "huge.csv"], ["huge.csv", "position", "unit"]),
    (["check", "nofile.csv"], ["nofile.csv"]),
    (["check", "up.csv", "thin.csv"], ["thin.csv"]),
    (["check", "up.csv", "--rig", ""], ["empty"]),
    (["twin", "t.txt"], ["t.txt", ".csv"]),
    (["twin", "folder"], ["folder", ".csv"]),
    (["twin", "file/t.csv"], ["file", "not a folder"]),
    (["twin", "x" * 300 + ".csv"], ["too long"]),
    (["twin", "t.csv", "--direction", "left"], ["'left'", "both"]),
    (["twin", "t.csv", "--seed", "-1"], ["seed", "-1"]),
    (["twin", "t.csv", "--noise", "nan"], ["--noise", "nan"]),
    (["twin", "t.csv", "--noise", "1e308"], ["--noise", "1e+308"]),
    (["twin", "t.csv", "--speed", "inf"], ["--speed", "inf"]),
    (["twin", "t.csv", "--speed", "1e9"], ["fewer than 10 samples"]),
    (["twin", "t.csv", "--speed", "1e-300"], ["samples", "move faster"]),
    (["twin", "t.csv", "--rate", "0"], ["--rate", "0"]),
    (["twin", "t.csv", "--rate", "1e308"], ["--rate 1e+308", "sample slower"]),
    (["twin", "t.csv", "--echo-rate", "1e308"], ["--echo-rate 1e+308"]),
    (["twin", "t.csv", "--echo-rate", "1e-9"], ["--echo-rate 1e-09", "sample faster"]),
    (["validate", "nofile.json", "up.csv"], ["nofile.json", "no such file"]),
    (["validate", "/dev/zero", "up.csv"], ["/dev/zero", "not a regular file"]),
    (["validate", "up.csv", "up.csv"], ["up.csv", "not a card"]),
    (["validate", "folder", "up.csv"], ["folder", "name a file"]),
    (["validate", "card.json"], ["LOG"]),
    (["validate", "card.json", "up.csv", "--range", "1:2"], ["up.csv", "1:2"]),
    (["validate", "card.json", "up.csv", "--max-error", "nan"], ["--max-error", "nan"]),
    (["validate", "card.json", "up.csv", "--max-error", "-1"], ["--max-error", "-1"]),
    (["validate", "card.json", "smooth.csv"], ["smooth.csv", "never rests"]),
    (["simulate", "card.json", "up.csv"], ["--out"]),
    (["simulate", "card.json", "up.csv", "--out", "up.csv"], ["up.csv", "the log itself"]),
    (["simulate", "card.json", "up.csv", "--out", "card.json"], ["card.json", ".csv"]),
    (["simulate", "card.json", "up.csv", "--out", "folder"], ["folder", ".csv"]),
    (["simulate", "card.json", "angle.csv", "--out", "x.csv"], ["angle.csv", "linear"]),
    (["laws", "nope"], ["'nope'", "stribeck"]),
    (["methods", "nope"], ["'nope'", "bts"]),
    (["rigs", "nope"], ["'nope'", "slide-bed"]),
    (["version", "extra"], ["extra"]),
]


@pytest.mark.parametrize(("arguments", "words"), COMMANDS, ids=lambda a: " ".join(a)[:40])
def test_the_others(refused: Callable[..., str], arguments: list[str], words: list[str]) -> None:
    line = refused(*arguments)
    assert [w for w in words if w not in line] == []


def _parameter(name: str, **changed: Any) -> Callable[[Any], None]:
    return lambda card: card["parameters"][name].update(changed)


CARDS: list[tuple[Callable[[Any], object], list[str]]] = [
    (lambda c: c.update(schema="stribeck-card/2"), ["stribeck-card/2", "stribeck-card/1"]),
    (lambda c: c.pop("schema"), ["not a card"]),
    (lambda c: c.update(law="nope"), ["'nope'", "stribeck"]),
    (lambda c: c.update(kind="nope"), ["'nope'", "slide-bed"]),
    (lambda c: c.update(extra=1), ["extra"]),
    (lambda c: c.update(search=None), ["search"]),
    (lambda c: c["parameters"].pop("F_S"), ["F_S", "missing"]),
    (lambda c: c["parameters"].update(F_X=c["parameters"]["F_S"]), ["'F_X'", "F_S"]),
    (_parameter("F_S", value=1.0), ["F_S below F_C"]),
    (_parameter("F_S", value="150"), ["F_S.value", "number"]),
    (_parameter("F_S", value=True), ["F_S.value", "number"]),
    (_parameter("F_S", value=float("nan")), ["F_S.value", "finite"]),
    (_parameter("F_S", unit="mm"), ["F_S", "'mm'", "'N'"]),
    (_parameter("F_S", unit="9**9**9"), ["F_S", "unknown unit"]),
    (_parameter("F_S", verdict="sure"), ["F_S.verdict", "identified"]),
    (_parameter("v_SS", value=-1.0), ["above zero"]),
    (_parameter("k_spring", value=-1.0), ["cannot be simulated"]),
    (_parameter("k_spring", value=1e308), ["k_spring", "finite"]),
    (lambda c: c.update(constants={"nope": {"value": 1.0, "unit": "kg"}}), ["'nope'", "F_fm"]),
    (lambda c: c.update(constants={"m": {"value": 1.0, "unit": "mm"}}), ["m", "'mm'", "'kg'"]),
    (lambda c: c.update(constants={"m": {"value": -1.0, "unit": "kg"}}), ["m = -1 kg"]),
    (lambda c: c.update(columns={"position": "nope"}), ["up.csv", "'nope'"]),
    (lambda c: c.update(columns={"nope": "position_mm"}), ["'nope'", "position"]),
]


@pytest.mark.parametrize(
    ("edit", "words"), CARDS, ids=lambda x: " ".join(x) if type(x) is list else ""
)
def test_edited_cards(
    refused: Callable[..., str], workdir: Path, edit: Callable[[Any], object], words: list[str]
) -> None:
    card = json.loads((workdir / "card.json").read_text())
    edit(card)
    (workdir / "card.json").write_text(json.dumps(card))
    line = refused("validate", "card.json", "up.csv")
    assert [w for w in words if w not in line] == []


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "null", "[" * 100_000, '{"schema": 1e400}', "9" * 5000]
)
def test_files_that_are_no_cards(refused: Callable[..., str], workdir: Path, text: str) -> None:
    (workdir / "card.json").write_text(text)
    assert "card.json: not a card" in refused("validate", "card.json", "up.csv")


def test_a_model_that_does_not_hold_is_status_1(
    workdir: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = content(workdir)
    assert call(monkeypatch, "validate", "card.json", "up.csv", "--max-error", "1e-6") == 1
    output, line = capsys.readouterr()
    assert line.startswith("stribeck: the model does not hold: ")
    assert line.count("\n") == 1
    assert "up.csv" in output
    assert content(workdir) == before


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="a system without named pipes")
def test_named_pipes_are_not_waited_for(refused: Callable[..., str], workdir: Path) -> None:
    for name in ("pipe.csv", "pipe.toml", "pipe.json"):
        os.mkfifo(workdir / name)
    assert "pipe.csv" in refused("check", "pipe.csv")
    assert "pipe.toml" in refused("identify", "up.csv", "--rig", "pipe.toml")
    assert "pipe.json" in refused("validate", "pipe.json", "up.csv")
    assert "pipe.csv" in refused("simulate", "card.json", "up.csv", "--out", "pipe.csv")
    assert "pipe.csv" in refused("twin", "pipe.csv")


def test_a_full_disk_leaves_nothing_behind_but_tells_the_result(
    workdir: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object, **__: object) -> int:
        raise OSError(28, "No space left on device")

    before = content(workdir)
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", full)
        status = call(patch, "identify", "up.csv", *QUICK, "--out", "new")
    output, line = capsys.readouterr()
    assert status == 2
    assert line == "stribeck: new: cannot be written: No space left on device\n"
    assert "F_S" in output
    assert content(workdir) == before


def test_a_folder_that_may_not_be_written_to(
    refused: Callable[..., str], workdir: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    allowed = os.access
    folder = workdir / "folder"

    def access(path: Any, mode: int) -> bool:
        return (Path(path).resolve() != folder or not mode & os.W_OK) and allowed(path, mode)

    monkeypatch.setattr(os, "access", access)  # permissions do not bind root
    assert "folder: no permission" in refused("identify", "up.csv", *QUICK, "--out", "folder")
    assert "folder: no permission" in refused("twin", "folder/t.csv")


@pytest.mark.parametrize("command", ["identify", "select"])
def test_a_log_that_is_missing_is_refused_before_anything_is_compiled(command: str) -> None:
    code = f"""
import subprocess
import sys
from stribeck.cli import main
sys.argv = ["stribeck", {command!r}, "nofile.csv", "--rig", "slide-bed"]
try:
    main()
except SystemExit as end:
    print(end.code, "numba" in sys.modules)
"""
    process = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert process.stdout == "2 False\n"
    assert process.stderr == "stribeck: nofile.csv: no such file in .\n"


def test_every_option_with_one_value_is_refused_twice() -> None:
    group: Any = cli.command_line()
    parameters = [p for c in group.commands.values() for p in c.params]
    repeatable = {o for p in parameters if p.multiple for o in p.opts if o.startswith("--")}
    assert repeatable == REPEATABLE
