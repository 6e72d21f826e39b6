"""What is in a log, how it is said which column is which, and how that is kept."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from command import Completed, caller
from stribeck import identify
from stribeck.data import read
from stribeck.data.readers.log_contents import contents
from stribeck.data.readers.log_map import FILE, LogMap, save_map, saved_maps
from stribeck.errors import ChoiceError, InputError
from stribeck.identify.card import read_card
from stribeck.identify.card_logs import logs_beside

LOGS = Path(__file__).parents[1] / ".." / "shared" / "data" / "logs"
real = pytest.mark.recordings

Run = Callable[..., Completed]


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    called = caller(monkeypatch, capsys)
    return lambda *words: called(*map(str, words))


N = 400
T = 0.01 * np.arange(N)
V = 0.5 * np.sin(3.0 * T)
X = (1.0 - np.cos(3.0 * T)) / 6.0
#: 2 kg, 4 N of Coulomb friction and 3 N s/m.
F = 2.0 * 1.5 * np.cos(3.0 * T) + 4.0 * np.sign(V) + 3.0 * V
F += 0.05 * np.random.default_rng(1).standard_normal(N)
HEADS = "stamp,a_pos,a_load,b_pos,b_load"


def axes(folder: Path, name: str = "axes.csv", heads: str = HEADS) -> Path:
    """A log of two joints without units; the second one is an axis with friction."""
    rows = (f"{t:.2f},1.0,2.0,{x:.17g},{f:.17g}" for t, x, f in zip(T, X, F, strict=True))
    path = folder / name
    path.write_text("\n".join([heads, *rows]) + "\n", encoding="utf-8")
    return path


COLUMNS = {"time": "stamp [s]", "position": "b_pos [m]", "force": "5 [N]"}
OPTIONS = [word for c, h in COLUMNS.items() for word in ("--column", f"{c}={h}")]


def test_what_is_in_a_log(tmp_path: Path) -> None:
    result = contents(axes(tmp_path), columns=COLUMNS)
    assert result.format == "text"
    assert [c.name for c in result.channels] == HEADS.split(",")
    assert {n: c.column for n, c in result.taken.items()} == {
        "time": "stamp", "position": "b_pos", "force": "b_load",
    }  # fmt: skip
    channel = result.channels[3]
    assert channel.count == N
    assert channel.rate == pytest.approx(100.0)
    np.testing.assert_allclose(channel.span or (), (0.0, T[-1]))
    np.testing.assert_allclose(channel.ends or (), (0.0, X[-1]))
    assert result.guesses == {"a_pos": ("position",)}
    assert result.lacking == ""


def test_contents_say_what_cannot_be_told_and_what_to_type(tmp_path: Path, run: Run) -> None:
    result = contents(axes(tmp_path))
    turning = " (rad, deg or rev where it turns)"
    assert result.lacking.endswith(f'as in units={{"stamp": "s", "a_pos": "mm"}}{turning}')
    done = run("contents", axes(tmp_path), "--json")
    assert done.status == 0
    answer = json.loads(done.out)
    assert answer["format"] == "text"
    assert [c["name"] for c in answer["channels"]] == HEADS.split(",")
    assert answer["channels"][0]["count"] == N
    assert answer["problems"][-1].endswith(
        f'--column time="stamp [s]" --column position="a_pos [mm]"{turning}'
    )


def test_a_choice_that_cannot_be_made_shows_the_channels(tmp_path: Path, run: Run) -> None:
    path = axes(tmp_path)
    with pytest.raises(ChoiceError):
        read(path)
    done = run("check", path)
    assert done.status == 2
    table, _, line = done.err.rstrip().rpartition("\n")
    assert [name in table for name in HEADS.split(",")] == [True] * 5
    assert line.startswith("stribeck: axes.csv: columns stamp and a_pos without a unit")


def test_columns_by_name_and_number_are_kept_for_the_next_log(tmp_path: Path, run: Run) -> None:
    first = axes(tmp_path)
    done = run("check", first, *OPTIONS, "--save-map")
    assert done.status == 0, done.err
    assert (tmp_path / FILE).is_file()
    second = axes(tmp_path, "later.csv")
    log = read(second)
    np.testing.assert_allclose(log.position, X)
    assert log.force is not None
    np.testing.assert_allclose(log.force, F)
    assert any(FILE in note for note in log.notes)
    other = axes(tmp_path, "other.csv", HEADS.replace("a_pos", "c_pos"))
    with pytest.raises(ChoiceError):
        read(other)


def test_the_card_knows_the_columns(tmp_path: Path, run: Run) -> None:
    log = axes(tmp_path)
    out = tmp_path / "fit"
    done = run("identify", log, "--rig", "forced", *OPTIONS, "--out", out)
    assert done.status == 0, done.err
    card = read_card(out / "card.json")
    assert card.columns["columns"]["position"] == {"column": "b_pos", "unit": "m"}
    assert card.parameters["F_C"].value == pytest.approx(4.0, rel=0.02)
    again = run("validate", out / "card.json", axes(tmp_path, "later.csv"))
    assert again.status == 0, again.err


def test_a_card_names_the_part_of_a_log_that_it_is_of(tmp_path: Path, run: Run) -> None:
    part, out = f"{axes(tmp_path)}@0.5s:3.5s", tmp_path / "fit"
    done = run("identify", part, "--rig", "forced", *OPTIONS, "--out", out)
    assert done.status == 0, done.err
    card = read_card(out / "card.json")
    assert card.data[0].file == "axes.csv@0.5s:3.5s"
    (log,) = logs_beside(card, out / "card.json")
    again = read(log, columns=card.columns)
    np.testing.assert_array_equal(again.position, X[50:350])


def test_a_joint_and_its_map(tmp_path: Path) -> None:
    log = axes(tmp_path, heads="stamp [s],a_pos [m],a_load [N],b_pos [m],b_load [N]")
    result = contents(log, joint="b")
    assert result.taken["position"].column == "b_pos [m]"
    read(log, joint="b", columns={"force": "b_load [N]"}, keep_map=True)
    ((heads, kept),) = saved_maps(tmp_path)
    assert heads == [c.name for c in result.channels]
    assert kept == LogMap(
        {
            "time": {"column": "stamp [s]", "unit": "s"},
            "position": {"column": "b_pos [m]", "unit": "m"},
            "force": {"column": "b_load [N]", "unit": "N"},
        },
        joint="b",
    )


def test_maps_of_several_heads_stand_beside_each_other(tmp_path: Path) -> None:
    one, two = LogMap({"position": 'say "x" [mm]'}, rate=250.0), LogMap({"force": "Kraft [N]"})
    save_map(tmp_path, ["x", "Weg ä"], two)
    save_map(tmp_path, ["y"], two)
    save_map(tmp_path, ["x", "Weg ä"], one)
    assert saved_maps(tmp_path) == [(["y"], two), (["x", "Weg ä"], one)]


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "rate": ({"rate": -5, "columns": {}}, "rate: give a number of Hz above 0"),
    "truth": ({"rate": True, "columns": {}}, "rate: give a number"),
    "stamp": ({"stamp": "now", "columns": {}}, "stamp: give header or log"),
    "joint": ({"joint": 2, "columns": {}}, "joint: give text"),
    "channel": ({"columns": {"posit": "x"}}, "no channel 'posit'"),
    "columns": ({"columns": 3}, "columns must be a table"),
    "nothing": ({"columns": {}}, "the mapping is empty"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_map_that_makes_no_sense(name: str) -> None:
    table, words = WRONG[name]
    with pytest.raises(InputError, match=words):
        LogMap.of(table)


def test_a_broken_file_of_maps_is_told(tmp_path: Path) -> None:
    log = axes(tmp_path)
    for text in ("[[log", "log = 3"):
        (tmp_path / FILE).write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match=FILE):
            read(log)


@real
def test_contents_of_a_drives_export() -> None:
    result = contents(LOGS / "mr_configurator" / "a3MR.csv")
    assert result.guesses["Servo motor speed"] == ("velocity",)
    assert result.guesses["Torque"] == ("force",)
    assert result.channels[0].unit == "ms"
    assert 'units={"Servo motor speed": "r/min"' in result.lacking


def test_everything_that_was_chosen_is_kept(tmp_path: Path) -> None:
    """Episode, joint, rate and drive of a log of several, for the next of its kind."""
    for name, end in (("one.h5", 1), ("two.h5", 2)):
        with h5py.File(tmp_path / name, "w") as file:
            for k in range(2):
                file[f"run_{k}/elbow_way"] = X + k * end
                file[f"run_{k}/elbow_load"] = F * end
                file[f"run_{k}/wrist_way"] = X
    drive = {"signal": "% of rated force", "rated_force": "50 N ± 5 %", "efficiency": 0.9}
    columns = {"position": "elbow_way [m]", "force": "elbow_load [%]"}
    first = read(
        tmp_path / "one.h5", columns=columns, joint="elbow", rate=100.0, episode="run_1",
        drive=drive, keep_map=True,
    )  # fmt: skip
    again = read(tmp_path / "one.h5")
    np.testing.assert_array_equal(again.position, first.position)
    assert again.drive == first.drive
    later = read(tmp_path / "two.h5")
    np.testing.assert_allclose(later.position, X + 2)
    assert later.force is not None
    assert first.force is not None
    np.testing.assert_allclose(later.force, 2.0 * first.force, rtol=1e-6)
    assert any(FILE in note for note in later.notes)


def test_a_number_of_the_drive_in_a_map_is_set_there(tmp_path: Path, run: Run) -> None:
    log = axes(tmp_path)
    (tmp_path / "map.toml").write_text(
        '[columns]\ntime = "stamp [s]"\nposition = "b_pos [m]"\nforce = "b_load [A]"\n'
        '[drive]\nsignal = "A rms"\nkt = "1.1 N/A rms"\n'
    )
    line = "kt is a number of a drive, and rig forced states none: a [drive] in the map of the logs"
    for value in ("1.2", "1.2 N/A rms"):
        words = ("--columns", tmp_path / "map.toml", "--set", f"kt={value}")
        done = run("identify", log, "--rig", "forced", *words)
        assert done.status == 2
        assert done.err.startswith(f"stribeck: {line}")
    with pytest.raises(InputError, match="kt is a number of a drive"):
        identify(log, rig="forced", columns=tmp_path / "map.toml", constants={"kt": 1.2})
