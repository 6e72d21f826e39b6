"""`stribeck export`: files whole or not at all, and one line for a refusal."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from command import Completed, caller
from exported import model_of
from stribeck.compensate.compensator import SETTINGS
from stribeck.export import TARGETS

Run = Callable[..., Completed]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> Run:
    monkeypatch.chdir(tmp_path)
    Path("card.json").write_text(model_of("stribeck").card.text(), encoding="utf-8")
    Path("joint.xml").write_text(
        '<mujoco><worldbody><body><joint name="hip" type="slide"/><geom size="1"/></body>'
        "</worldbody></mujoco>\n",
        encoding="utf-8",
    )
    return caller(monkeypatch, capsys)


def refused(completed: Completed, *words: str) -> None:
    assert completed.status == 2
    assert completed.out == ""
    assert completed.err.startswith("stribeck: ")
    assert completed.err.count("\n") == 1
    for word in words:
        assert word in completed.err


def names(folder: Path = Path()) -> list[str]:
    return sorted(file.name for file in folder.iterdir())


def edited(change: Callable[[dict[str, object]], object]) -> None:
    card = json.loads(Path("card.json").read_text(encoding="utf-8"))
    change(card)
    Path("card.json").write_text(json.dumps(card), encoding="utf-8")


def test_c_is_a_folder_that_compiles_and_checks_itself(run: Run) -> None:
    completed = run("export", "card.json", "--to", "c", "--out", "made", "--name", "axis_x")
    assert completed.status == 0, completed.err
    assert names(Path("made")) == ["axis_x.c", "axis_x.h", "selftest.c"]
    build = ["gcc", "-std=c99", "-Wall", "-Werror", "axis_x.c", "selftest.c", "-lm", "-o", "t"]
    try:
        subprocess.run(build, cwd="made", check=True)
    except FileNotFoundError:
        pytest.skip("there is no gcc")
    ran = subprocess.run(["./t"], cwd="made", capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stdout) == (0, "0 of 256 rows differ\n")


def test_settings_reach_the_compensator(run: Run) -> None:
    settings = ("--set", "scale=0.75", "--set", "feedback=1", "--set", "dead_band=0.5")
    assert run("export", "card.json", "--to", "c", "--out", "made", *settings).status == 0
    source = Path("made/friction.c").read_text(encoding="utf-8")
    assert "compensator->c[FRICTION_SCALE] = 0.75;" in source
    assert "compensator->c[FRICTION_FEEDBACK] = 1.0;" in source
    assert "compensator->c[FRICTION_DEAD_BAND] = 0.0005;" in source  # 0.5 mm/s


def test_a_text_goes_to_the_terminal_or_to_a_file_and_is_the_same(run: Run) -> None:
    shown = run("export", "card.json", "--to", "table", "--points", "5")
    written = run("export", "card.json", "--to", "table", "--points", "5", "--out", "t.csv")
    assert (shown.status, written.status, written.out) == (0, 0, "t.csv\n")
    assert Path("t.csv").read_text(encoding="utf-8") == shown.out
    assert sum(not line.startswith("#") for line in shown.out.splitlines()) == 6
    assert "of the largest friction" in shown.err


def test_the_card_goes_through_unchanged(run: Run) -> None:
    completed = run("export", "card.json", "--to", "json")
    assert completed.out == Path("card.json").read_text(encoding="utf-8")


def test_a_patched_file_leaves_the_users_own_as_it_was(run: Run) -> None:
    before = Path("joint.xml").read_bytes()
    options = ("--into", "joint.xml", "--joint", "hip")
    completed = run("export", "card.json", "--to", "mjcf", *options, "--out", "new.xml")
    assert completed.status == 0, completed.err
    assert Path("joint.xml").read_bytes() == before
    assert b"frictionloss=" in Path("new.xml").read_bytes()
    assert "note: " in completed.err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--to", "cobol"), ["cobol", "plcopen"]),
        (("--to", "c"), ["--out", "folder"]),
        (("--to", "fmu"), ["--out", "file"]),
        (("--to", "c", "--out", "card.json"), ["card.json"]),
        (("--to", "table", "--out", "t.txt"), ["t.txt.csv"]),
        (("--to", "c", "--out", "x", "--name", "2nd"), ["2nd", "letter"]),
        (("--to", "c", "--out", "x", "--name", "int"), ["int"]),
        (("--to", "c", "--out", "x", "--name", "a/b"), ["a/b"]),
        (("--to", "c", "--out", "x", "--set", "gain=2"), ["gain", "scale"]),
        (("--to", "c", "--out", "x", "--set", "scale=nan"), ["scale"]),
        (("--to", "c", "--out", "x", "--set", "scale=-1"), ["scale"]),
        (("--to", "c", "--out", "x", "--set", "feedback=0.5"), ["feedback", "0 or 1"]),
        (("--to", "c", "--out", "x", "--points", "5"), ["--points", "means nothing to c"]),
        (("--to", "table", "--points", "1"), ["2 to 1000"]),
        (("--to", "table", "--speed", "-3"), ["above 0"]),
        (("--to", "table", "--joint", "hip"), ["--joint", "means nothing to table"]),
        (("--to", "json", "--name", "x"), ["--name", "no options"]),
        (("--to", "mjcf"), ["--into"]),
        (("--to", "mjcf", "--into", "joint.xml"), ["--joint"]),
        (("--to", "mjcf", "--into", "joint.xml", "--joint", "hop"), ["hop", "hip"]),
        (("--to", "mjcf", "--into", "gone.xml", "--joint", "hip"), ["gone.xml", "no such file"]),
        (("--to", "mjcf", "--into", "card.json", "--joint", "hip"), ["card.json"]),
        (("--to", "urdf", "--into", "joint.xml", "--joint", "hip"), ["joint.xml"]),
        (("--to", "usd"), ["--joint"]),
        (("--to", "usd", "--joint", "hip"), ["hip", "/robot/joints/elbow"]),
        (("--to", "usd", "--joint", "/hip", "--set", "metres=0"), ["metres"]),
    ],
)
def test_what_cannot_be_is_a_line(run: Run, options: tuple[str, ...], words: list[str]) -> None:
    before = names()
    refused(run("export", "card.json", *options), *words)
    assert names() == before


@pytest.mark.parametrize("to", TARGETS)
def test_cards_edited_into_nonsense(run: Run, to: str) -> None:
    def value(card: dict[str, object]) -> None:
        card["parameters"]["F_S"]["value"] = -4.0  # type: ignore[index]

    options: dict[str, tuple[str, ...]] = {"mjcf": ("--into", "joint.xml", "--joint", "hip")}
    options["urdf"] = options["mjcf"]
    options["usd"] = ("--joint", "/robot/hip")
    edited(value)
    before = names()
    refused(run("export", "card.json", "--to", to, "--out", "x", *options.get(to, ())), "")
    assert names() == before


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c.update(schema="stribeck-card/2"), ["stribeck-card/2", "identify"]),
        (lambda c: c.update(law="sticky"), ["sticky"]),
        (lambda c: c["parameters"]["F_S"].update(unit="kg"), ["F_S", "kg"]),
        (lambda c: c["parameters"].pop("F_C"), ["F_C", "missing"]),
        (lambda c: c["parameters"]["F_S"].update(value="much"), ["F_S", "number"]),
        (lambda c: c["parameters"]["v_SS"].update(value=0.0), ["card.json"]),
        (lambda c: c.update(speeds={"low": -1.0, "high": 1.0, "unit": "N"}), ["speeds", "N"]),
        (lambda c: c.update(speeds={"low": 1.0, "high": -1.0, "unit": "m/s"}), ["speeds"]),
        (lambda c: c.update(speeds={"low": -1.0, "high": 1.0, "unit": "parsec"}), ["parsec"]),
        (lambda c: c.update(rig="\ud800"), ["half a character"]),
    ],
)
def test_edited_cards(
    run: Run, change: Callable[[dict[str, object]], object], words: list[str]
) -> None:
    edited(change)
    refused(run("export", "card.json", "--to", "c", "--out", "made"), "card.json", *words)
    assert not Path("made").exists()


def test_files_that_are_no_cards(run: Run) -> None:
    for text in ("", "[]", "{}", "not json", '{"schema": 3}'):
        Path("card.json").write_text(text, encoding="utf-8")
        refused(run("export", "card.json", "--to", "c", "--out", "made"), "card.json")
    refused(run("export", "gone.json", "--to", "c", "--out", "made"), "gone.json", "no such file")
    assert not Path("made").exists()


def test_a_name_cannot_leave_a_comment(run: Run) -> None:
    edited(lambda card: card.update(warnings=["ends */ int x = 1; /* here"], rig='a" */ b'))
    completed = run("export", "card.json", "--to", "c", "--out", "made")
    assert completed.status == 0, completed.err
    header = Path("made/friction.h").read_text(encoding="utf-8")
    assert header.index("*/") > header.index("From card.json")


def test_a_line_end_in_a_name_is_none_in_a_file(run: Run) -> None:
    edited(lambda card: card.update(rig="a *\\\n/ int ??/ x;\n9e9,9e9"))
    assert run("export", "card.json", "--to", "c", "--out", "made").status == 0
    build = ["gcc", "-std=c99", "-Wall", "-Werror", "-c", "friction.c", "-o", "friction.o"]
    try:
        subprocess.run(build, cwd="made", check=True)
    except FileNotFoundError:
        pytest.skip("there is no gcc")
    table = run("export", "card.json", "--to", "table", "--points", "3").out.splitlines()
    assert len([line for line in table if not line.startswith("#")]) == 4


def test_a_friction_that_no_motion_can_be_simulated_with_is_patched_all_the_same(run: Run) -> None:
    edited(lambda card: card["parameters"]["F_S"].update(value=1e30))  # type: ignore[index]
    completed = run("export", "card.json", "--to", "mjcf", "--into", "joint.xml", "--joint", "hip")
    assert completed.status == 0, completed.err
    assert "RMS apart" not in completed.err


def test_bristles_without_coulomb_friction_are_numbers(run: Run) -> None:
    Path("card.json").write_text(model_of("lugre").card.text(), encoding="utf-8")
    edited(lambda card: card["parameters"]["F_C"].update(value=0.0))  # type: ignore[index]
    completed = run("export", "card.json", "--to", "c", "--out", "made")
    assert completed.status == 0, completed.err
    edited(lambda card: card["parameters"]["sigma_1"].update(value=1e305))  # type: ignore[index]
    command = ("export", "card.json", "--to", "c", "--out", "other")
    refused(run(*command), "card.json", "no finite friction")


def test_what_mujoco_holds_beside_two_numbers_is_asked_for(run: Run) -> None:
    options = ("--to", "mjcf", "--into", "joint.xml", "--joint", "hip")
    plain = run("export", "card.json", *options)
    rich = run("export", "card.json", *options, "--set", "firm=1")
    assert "solimpfriction" not in plain.out
    assert "solimpfriction" in rich.out
    refused(run("export", "card.json", *options, "--set", "hard=1"), "hard", "firm")
    refused(run("export", "card.json", *options, "--set", "firm=2"), "0 or 1")


def recommended(**settings: float) -> None:
    values = {s.name: {"value": 0.0, "unit": ""} for s in SETTINGS}
    values |= {name: {"value": value, "unit": ""} for name, value in settings.items()}
    whole = {"schema": "stribeck-compensation/2", "recommended": {"settings": values}}
    Path("compensation.json").write_text(json.dumps(whole), encoding="utf-8")


def test_what_compensate_recommends_goes_into_the_code(run: Run) -> None:
    recommended(scale=0.9, feedback=1.0, dead_band=5e-6, drive=23.5, rest=1e-9)
    options = ("--to", "c", "--out", "made", "--compensation", "compensation.json")
    assert run("export", "card.json", *options, "--set", "scale=0.8").status == 0
    source = Path("made/friction.c").read_text(encoding="utf-8")
    for line in ("SCALE] = 0.8;", "FEEDBACK] = 1.0;", "DEAD_BAND] = 5e-06;", "DRIVE] = 23.5;"):
        assert line in source


def test_the_drives_own_friction_is_overcome_unless_told_otherwise(run: Run) -> None:
    assert run("export", "card.json", "--to", "c", "--out", "made").status == 0
    assert "DRIVE] = 23.5;" in Path("made/friction.c").read_text(encoding="utf-8")  # F_fm


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda w: w.update(schema="stribeck-compensation/3"), "stribeck-compensation/3"),
        (lambda w: w.update(recommended=None), "recommends no scale"),
        (lambda w: w["recommended"].pop("settings"), "settings.scale.value"),
        (lambda w: w["recommended"]["settings"]["rest"].update(value="x"), "settings.rest.value"),
        (lambda w: w["recommended"]["settings"]["scale"].update(value=-1.0), "scale"),
        (lambda w: w["recommended"]["settings"]["scale"].update(value=10**400), "scale.value"),
    ],
)
def test_edited_compensations(run: Run, change: Callable[[Any], object], word: str) -> None:
    recommended(rest=1e-9)
    whole = json.loads(Path("compensation.json").read_text(encoding="utf-8"))
    change(whole)
    Path("compensation.json").write_text(json.dumps(whole), encoding="utf-8")
    options = ("--to", "c", "--out", "made", "--compensation", "compensation.json")
    refused(run("export", "card.json", *options), "compensation.json", word)
    assert not Path("made").exists()


def test_what_is_read_is_not_written_over(run: Run) -> None:
    before = Path("joint.xml").read_bytes(), Path("card.json").read_bytes()
    options = ("--into", "joint.xml", "--joint", "hip", "--out", "joint.xml")
    refused(run("export", "card.json", "--to", "mjcf", *options), "joint.xml", "another place")
    refused(run("export", "card.json", "--to", "json", "--out", "card.json"), "another place")
    assert (Path("joint.xml").read_bytes(), Path("card.json").read_bytes()) == before


def test_an_axis_that_cannot_be_simulated_is_no_unit(run: Run) -> None:
    edited(lambda card: card.update(constants={"m": {"value": 0.0, "unit": "kg"}}))
    refused(run("export", "card.json", "--to", "fmu", "--out", "x.fmu"), "m = 0")
    assert not Path("x.fmu").exists()
