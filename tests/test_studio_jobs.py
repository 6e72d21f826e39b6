"""What the studio's workers make is what the command line makes, and survives every kill."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from patience import PATIENCE
from studio_server import Studio, bed_log, sliding_log, start, studio

CHOICES: dict[str, Any] = {
    "rig": "forced",
    "law": "coulomb-viscous",
    "constants": {},
    "train": ["0s:8s"],
    "holdout": ["8s:12s"],
}


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return sliding_log(tmp_path / "axis.csv")


def card(text: bytes | str) -> Any:
    """A card without how long its making took."""
    document = json.loads(text)
    document["search"].pop("seconds")
    return document


def result(opened: Studio, job: int) -> Any:
    answer = opened.ask("GET", f"{opened.session}/jobs/{job}/files/card.json")
    assert answer.status == 200, answer.body
    return card(answer.body)


def workers(home: Path) -> list[int]:
    """The processes that work for a home."""
    numbers = []
    for place in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            words = place.read_bytes().split(b"\0")
            if b"stribeck.studio.job_worker" in words and str(home).encode() in words:
                numbers.append(int(place.parent.name))
    return numbers


def a_worker(home: Path) -> int:
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        if there := workers(home):
            return there[0]
        time.sleep(0.01)
    raise AssertionError("no worker was started")


def test_the_card_is_that_of_the_command_and_of_the_python_that_are_shown(
    tmp_path: Path, log: Path
) -> None:
    with studio(tmp_path / "home", log) as opened:
        opened.choose(**CHOICES)
        job = opened.until(opened.work("identify")["id"], "done", "failed")
        assert job["state"] == "done", job["message"]
        ours = result(opened, job["id"])
        shown = opened.ask("GET", f"{opened.session}/script").json
    assert shown["command"].startswith("stribeck identify axis.csv ")
    words = shown["command"].replace("stribeck", f"{sys.executable} -m stribeck", 1)
    subprocess.run(words, shell=True, cwd=tmp_path, check=True, capture_output=True)  # noqa: S602
    theirs = (tmp_path / "result" / "card.json").read_text(encoding="utf-8")
    assert ours == card(theirs)
    code = f"{shown['python']}\nopen('python.json', 'w').write(fit.card().text())"
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, check=True, capture_output=True)
    by_python = card((tmp_path / "python.json").read_text(encoding="utf-8"))
    # Advice names keywords to who wrote Python, and options to who typed.
    for document in (by_python, ours):
        document.pop("warnings")
        document.pop("notes")
        for condition in document["conditions"]:
            condition.pop("sentence")
    assert by_python == ours


def test_columns_units_and_windows_are_in_both(tmp_path: Path, log: Path) -> None:
    text = log.read_text(encoding="utf-8").replace("t_s,position_mm,force_N", "zeit,weg,kraft")
    log.write_text(text, encoding="utf-8")
    with studio(tmp_path / "home", log) as opened:
        state = opened.ask("GET", opened.session).json
        assert {s["name"]: s["lock"] for s in state["steps"]}["look"] == "lock.unread"
        key = state["choices"]["logs"][0]["id"]
        columns = {"time": "zeit [s]", "position": "weg [mm]", "force": "kraft [N]"}
        state = opened.choose(
            rig="forced", law="coulomb-viscous", columns=columns,
            logs=[{"id": key, "window": "1s:9s"}],
        )  # fmt: skip
        assert {s["lock"] for s in state["steps"][:4]} == {""}
        job = opened.until(opened.work("identify")["id"], "done", "failed")
        assert job["state"] == "done", job["message"]
        ours = result(opened, job["id"])
        shown = opened.ask("GET", f"{opened.session}/script").json["command"]
    words = shown.replace("stribeck", f"{sys.executable} -m stribeck", 1)
    subprocess.run(words, shell=True, cwd=tmp_path, check=True, capture_output=True)  # noqa: S602
    assert ours == card((tmp_path / "result" / "card.json").read_text(encoding="utf-8"))
    assert ours["data"][0]["file"] == "axis.csv@1s:9s"
    assert abs(ours["parameters"]["M"]["value"] - 2.0) < 0.05


def test_an_export_is_that_of_the_command(tmp_path: Path, log: Path) -> None:
    with studio(tmp_path / "home", log) as opened:
        opened.choose(**CHOICES)
        job = opened.until(opened.work("identify")["id"], "done")["id"]
        place = f"{opened.session}/jobs/{job}"
        saved = opened.ask("GET", f"{place}/export?to=st&set=scale%3D0.9&save=1")
        assert saved.headers["content-disposition"] == 'attachment; filename="friction_st.st"'
        packed = opened.ask("GET", f"{place}/export?to=c&save=1")
        assert packed.body.startswith(b"PK")
        refused = opened.ask("GET", f"{place}/export?to=mjcf")
        assert (refused.status, "--into" in refused.json["error"]) == (400, True)
        for query in (
            "to=nonsense",
            "to=st&set=scale",
            "to=st&set=nonsense%3D1",
            "to=table&points=x",
        ):
            assert opened.ask("GET", f"{place}/export?{query}").status == 400
        there = opened.home / "results" / str(job) / "card.json"
        out = subprocess.run(
            [sys.executable, "-m", "stribeck", "export", there, "--to", "st", "--set", "scale=0.9"],
            check=True, capture_output=True,
        ).stdout  # fmt: skip
    assert saved.body == out


@pytest.fixture
def bed(tmp_path: Path) -> Path:
    """A log whose identification takes seconds of search."""
    return bed_log(tmp_path / "bed.csv")


def searching(opened: Studio, job: int) -> None:
    """Wait until a search is under way and has been drawn."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        (state,) = [j for j in opened.ask("GET", opened.session).json["jobs"] if j["id"] == job]
        assert state["state"] in ("waiting", "running"), state
        if state["progress"].get("motion"):
            motion = state["progress"]["motion"]
            assert len(motion["t"]) == len(motion["measured"]) == len(motion["model"])
            return
        time.sleep(0.05)
    raise AssertionError(state)


LONG = {"rig": "slide-bed", "method": "bts", "budget": 10**8, "repeats": 2}


def test_a_fit_that_is_stopped_is_kept(tmp_path: Path, bed: Path) -> None:
    with studio(tmp_path / "home", bed) as opened:
        opened.choose(**LONG)
        job = opened.work("identify")["id"]
        searching(opened, job)
        opened.ask("POST", f"{opened.session}/jobs/{job}/cancel", {})
        ended = opened.until(job, "done", "failed")
        assert ended["state"] == "done", ended["message"]
        kept = result(opened, job)
        assert kept["search"]["ended"] == "interrupted"
        assert kept["search"]["evaluations"] < 10**8
        page = opened.ask("GET", f"{opened.session}/jobs/{job}/files/report.html")
        assert (page.status, "sha256-" in page.headers["content-security-policy"]) == (200, True)


def test_a_worker_that_is_killed_begins_anew(tmp_path: Path, bed: Path) -> None:
    with studio(tmp_path / "home", bed) as opened:
        opened.choose(rig="slide-bed", train=["112:295"], budget=400, repeats=1)
        job = opened.work("identify")["id"]
        searching(opened, job)
        os.kill(a_worker(opened.home), signal.SIGKILL)
        assert opened.until(job, "done", "failed")["state"] == "done"
        killed = result(opened, job)
        undisturbed = opened.until(opened.work("identify")["id"], "done")["id"]
        assert result(opened, undisturbed) == killed


@pytest.fixture
def killed(tmp_path: Path, bed: Path) -> Iterator[tuple[Studio, int]]:
    """A studio that was killed while a worker searched."""
    opened = start(tmp_path / "home", bed)
    opened.enter()
    opened.choose(rig="slide-bed", train=["112:295"], budget=3000, repeats=1)
    job = opened.work("identify")["id"]
    searching(opened, job)
    opened.process.kill()
    opened.process.wait(PATIENCE)
    assert opened.process.stdout is not None
    opened.process.stdout.close()
    yield opened, job
    for number in workers(opened.home):
        os.kill(number, signal.SIGKILL)


@pytest.mark.parametrize("with_worker", [False, True])
def test_a_studio_that_is_killed_opens_where_it_was(
    killed: tuple[Studio, int], *, with_worker: bool
) -> None:
    before, job = killed
    if with_worker:
        os.kill(a_worker(before.home), signal.SIGKILL)
    with studio(before.home) as opened:
        opened.session = before.session
        state = opened.ask("GET", opened.session, headers={"Cookie": before.cookie}).json
        assert state["choices"]["train"] == ["112:295"]
        assert opened.until(job, "done", "failed")["state"] == "done"
        assert result(opened, job)["parameters"]


def test_two_fits_run_at_once_and_a_refused_one_says_why(tmp_path: Path, log: Path) -> None:
    with studio(tmp_path / "home", log) as opened:
        opened.choose(**CHOICES)
        first = opened.work("identify")["id"]
        opened.choose(law="gms:900")
        second = opened.work("identify")["id"]
        assert opened.until(first, "done", "failed")["state"] == "done"
        refused = opened.until(second, "done", "failed")
        assert refused["state"] == "failed"
        assert "gms:900" in refused["message"]
        assert "\n" not in refused["message"]
        for path in ("result", "files/card.json", "export?to=st"):
            assert opened.ask("GET", f"{opened.session}/jobs/{second}/{path}").status == 400
        elsewhere = opened.ask("POST", "/api/sessions", {"name": "other"}).json["id"]
        answer = opened.ask("GET", f"/api/sessions/{elsewhere}/jobs/{first}/result")
        assert answer.json == {"error": "there is no such job"}


@pytest.mark.parametrize("content", [b"\0\1\2", b"a,b\n1,2\n", b"PK\3\4nonsense", b"{" * 10_000])
def test_a_wrong_file_locks_the_steps_and_is_removed_again(
    tmp_path: Path, log: Path, content: bytes
) -> None:
    with studio(tmp_path / "home", log) as opened:
        sent = opened.ask("POST", f"{opened.session}/files?name=wrong.csv", content).json
        look = sent["steps"][1]
        assert look["lock"] == "lock.unread"
        assert look["detail"]
        assert "\n" not in look["detail"]
        undone = opened.ask("POST", f"{opened.session}/undo", {}).json
        assert undone["steps"][1]["lock"] == ""


DATA = Path(__file__).parents[2] / "shared" / "data"


@pytest.mark.recordings("emps")
def test_a_matlab_file_is_read_as_the_rig_has_it_and_gives_the_published_mass(
    tmp_path: Path,
) -> None:
    with studio(tmp_path / "home", DATA / "emps" / "DATA_EMPS.mat") as opened:
        contents = opened.ask("GET", f"{opened.session}/logs/0/contents").json
        assert contents["rig"] == "emps"
        opened.choose(rig=contents["rig"], law="coulomb-viscous")
        job = opened.until(opened.work("identify")["id"], "done", "failed")
        assert job["state"] == "done", job["message"]
        assert round(result(opened, job["id"])["parameters"]["M"]["value"], 4) == 95.1089


def test_a_log_that_was_judged_is_drawn_as_such_when_many_others_were_read_since(
    tmp_path: Path,
) -> None:
    logs = [sliding_log(tmp_path / f"axis{k}.csv", 4.0 + k) for k in range(6)]
    with studio(tmp_path / "home", *logs) as opened:
        place = f"{opened.session}/logs/0/lines?since=0&until=2&pixels=300"
        assert "velocity" not in opened.ask("GET", f"{place}&mended=0").json["lines"]
        opened.ask("GET", f"{opened.session}/logs/0/overview")
        before = opened.ask("GET", f"{place}&mended=1").json
        for k in range(1, 6):
            opened.ask("GET", f"{opened.session}/logs/{k}/overview")
        assert "velocity" in before["lines"]
        assert opened.ask("GET", f"{place}&mended=1").json == before


@pytest.mark.recordings("bam_xl330")
def test_sixteen_logs_of_a_servo_are_read_together(tmp_path: Path) -> None:
    logs = sorted((DATA / "bam_xl330" / "logs").glob("*.json"))[:16]
    assert len(logs) == 16
    with studio(tmp_path / "home", *logs) as opened:
        assert (
            opened.ask("GET", f"{opened.session}/logs/15/contents").json["rig"] == "servo-pendulum"
        )
        state = opened.choose(rig="servo-pendulum")
        assert {s["name"]: s["lock"] for s in state["steps"]}["fit"] == ""
        overview = opened.ask("GET", f"{opened.session}/logs/15/overview").json
        assert overview["rig"] == "servo-pendulum"
        lines = opened.ask(
            "GET", f"{opened.session}/logs/15/lines?since=0&until=100&pixels=300&mended=1"
        ).json
        assert len(lines["t"]) == len(lines["lines"]["position"]) > 100
