"""An axis of the studio: composed or from a file, its constants, and what makes it no dead end."""

import json
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from typing import Any

import pytest

from conftest import RECORDINGS
from studio_server import Studio, sliding_log, studio

OF_PARTS: dict[str, Any] = {
    "rotary": False,
    "controller": {"none": {}},
    "motor": {"force": {"F_max": "80 nameplate"}},
    "transmission": {"rigid": {}},
    "load": {"mass": {"M": {"free": [0.5, 8.0]}}},
    "ranges": {"F_C": [0, 20]},
}


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Studio]:
    folder = tmp_path_factory.mktemp("axis")
    with studio(folder / "home", sliding_log(folder / "axis.csv", 4.0)) as running:
        yield running


def locks(state: dict[str, Any]) -> dict[str, str]:
    return {step["name"]: step["lock"] for step in state["steps"]}


def card(text: bytes | str) -> Any:
    document = json.loads(text)
    document["search"].pop("seconds")
    return document


def test_an_axis_of_parts_gives_the_card_of_the_command_with_its_file(opened: Studio) -> None:
    state = opened.choose(
        rig="axis.toml", axis=OF_PARTS, law="coulomb-viscous", budget=150, repeats=1
    )
    assert set(locks(state).values()) == {"", "lock.no_fit"}
    blocks = [(b["role"], b["name"]) for b in state["axis"]["composition"]]
    assert blocks == [("controller", "none"), ("motor", "force"), ("transmission", "rigid"),
                      ("load", "mass"), ("sensor", "position")]  # fmt: skip
    assert state["axis"]["constants"]["F_max"]["origin"] == "nameplate"
    job = opened.until(opened.work("identify")["id"], "done", "failed")
    assert job["state"] == "done", job["message"]
    ours = opened.ask("GET", f"{opened.session}/jobs/{job['id']}/files/card.json").body
    shown = opened.ask("GET", f"{opened.session}/script").json
    folder = opened.home.parent
    for name, text in shown["files"].items():
        (folder / name).write_text(text, encoding="utf-8")
    assert tomllib.loads(shown["files"]["axis.toml"]) == OF_PARTS
    words = shown["command"].replace("stribeck", f"{sys.executable} -m stribeck", 1)
    subprocess.run(words, shell=True, cwd=folder, check=True, capture_output=True)  # noqa: S602
    theirs = (folder / "result" / "card.json").read_text(encoding="utf-8")
    assert card(ours) == card(theirs)
    assert abs(card(ours)["parameters"]["M"]["value"] - 2.0) < 0.1


def test_the_time_of_a_search_is_told_before_it_starts(opened: Studio) -> None:
    opened.choose(rig="axis.toml", axis=OF_PARTS, budget=500, repeats=2)
    opened.work_silently("estimate")
    estimate = opened.until_state(lambda state: state["estimate"]["state"] == "done")["estimate"]
    told = estimate["progress"]
    assert told["evaluations"] == 1000
    assert told["seconds"] == pytest.approx(1000 * told["evaluation"])
    assert told["evaluation"] > 0
    assert opened.choose(target="c")["estimate"] == estimate  # no fit depends on it
    assert opened.choose(budget=600)["estimate"] is None  # and on this one it does


@pytest.mark.parametrize(
    ("axis", "line"),
    [
        ({}, "kind"),
        ({"load": {"mass": {"M": "heavy"}}}, "load.mass.M"),
        ({"load": {"mass": {"M": {"free": [2, 1]}}}}, "load.mass.M"),
        ({"load": {"mass": {}}, "motor": {"steam": {}}}, "no motor 'steam'"),
        ({"kind": "nonsense"}, "no kind 'nonsense'"),
        ({"name": "emps", "load": {"mass": {}}}, "that of a shipped rig"),
    ],
)
def test_a_description_of_no_axis_says_so_where_it_can_be_mended(
    opened: Studio, axis: dict[str, Any], line: str
) -> None:
    state = opened.choose(rig="axis.toml", axis=axis, law="", constants={})
    assert (locks(state)["look"], locks(state)["axis"]) == ("", "")
    assert locks(state)["fit"] == "lock.axis"
    detail = next(step["detail"] for step in state["steps"] if step["name"] == "fit")
    assert line in detail
    assert "\n" not in detail


def test_a_constant_that_is_none_locks_the_fit_and_not_its_own_step(opened: Studio) -> None:
    state = opened.choose(rig="slide-bed", constants={"F_fm": "much"}, law="")
    assert [locks(state)[step] for step in ("look", "axis", "fit")] == ["", "", "lock.axis"]
    opened.choose(constants={})


def upload(opened: Studio, name: str, text: str) -> Any:
    return opened.ask("POST", f"{opened.session}/rig?name={name}", text.encode())


def test_the_file_of_a_rig_is_the_axis_under_its_name(opened: Studio) -> None:
    text = 'kind = "forced"\nlaw = "stribeck"\nranges = { F_C = [1, 9] }\n'
    state = upload(opened, "..%2FPress%201.toml", text).json
    assert state["choices"]["rig"] == "axis.toml"
    assert state["choices"]["axis"]["name"] == "Press 1"
    assert state["axis"]["laws"][0] == "stribeck"
    assert state["axis"]["parameters"]["F_C"]["high"] == 9


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("load = [", "not the TOML of a rig"),
        ("a = 1979-05-27", "not the TOML of a rig"),
        ("a = nan", "not the TOML of a rig"),
        ("a = " + "[" * 300, "axis.toml"),
        ("a = [[[[[[[[1]]]]]]]]", "nested too deeply"),
        ('a = "' + "x" * 30_000 + '"', "too long"),
    ],
)
def test_what_is_no_rig_is_refused_in_a_line(opened: Studio, text: str, line: str) -> None:
    before = opened.ask("GET", opened.session).json["choices"]
    answer = upload(opened, "axis.toml", text)
    assert answer.status == 400
    assert line in answer.json["error"]
    assert "\n" not in answer.json["error"]
    assert opened.ask("GET", opened.session).json["choices"] == before


@pytest.mark.parametrize("name", ["/etc/axis.toml", "../axis.toml", "pyproject.toml", "steam"])
def test_no_file_of_the_machine_is_a_rig(opened: Studio, name: str) -> None:
    secret = opened.home.parent / "secret.toml"
    secret.write_text('kind = "forced"\n', encoding="utf-8")
    for rig in (name, str(secret)):
        state = opened.choose(rig=rig, axis={}, constants={}, law="")
        fit = next(step for step in state["steps"] if step["name"] == "fit")
        assert (fit["lock"], fit["detail"].startswith("no rig")) == ("lock.axis", True)


@pytest.mark.recordings("bam_xl330")
def test_a_constant_that_the_log_states_is_told_with_its_value(opened: Studio) -> None:
    """The servo's gain is 200 in this log, where the rig has 400."""
    log = RECORDINGS / "bam_xl330" / "logs" / "2026-01-15_10h28m49.json"
    opened.ask("POST", f"{opened.session}/files?name={log.name}", log.read_bytes())
    opened.choose(logs=opened.ask("GET", opened.session).json["choices"]["logs"][-1:])
    contents = (
        opened.choose(rig="servo-pendulum")
        and opened.ask("GET", f"{opened.session}/logs/0/contents").json
    )
    assert contents["as_rig"] == "servo-pendulum"
    units = {c["name"]: c["unit"] for c in contents["channels"]}
    assert (units["position"], units["mass"]) == ("rad", None)
    overview = opened.ask("GET", f"{opened.session}/logs/0/overview").json
    assert overview["stated"] == {"kp": 200.0, "vin": 7.4, "m": 0.49, "l": 0.1}


def test_a_drive_says_what_it_makes_of_its_signal(opened: Studio) -> None:
    drive = {"convention": "mitsubishi-mr", "rated_torque": "1.3 N m", "lead": "10 mm"}
    state = opened.choose(rig="", axis={}, drive=drive)
    assert "1 % is 8.168 N at the axis" in state["drive"]["sentence"]  # 2 π 1.3 N m / 1 m
    state = opened.choose(drive={"convention": "mitsubishi-mr"})
    assert "rated_torque" in state["drive"]["error"]
    opened.choose(drive={})
