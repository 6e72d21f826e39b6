"""A map of channels is chosen once, and found for the next log with the same heads."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from command import caller
from stribeck.data.readers.log_map import FILE
from studio_server import Studio, sliding_log, studio

COLUMNS = {"time": "zeit [s]", "position": "weg [mm]", "force": "kraft [N]"}


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """A log whose heads say nothing."""
    file = sliding_log(tmp_path / "Achse 1.csv", 2.0)
    text = file.read_text(encoding="utf-8").replace("t_s,position_mm,force_N", "zeit,weg,kraft")
    file.write_text(text, encoding="utf-8")
    return file


@pytest.fixture
def opened(tmp_path: Path, foreign: Path) -> Iterator[Studio]:
    with studio(tmp_path / "home", foreign) as running:
        yield running


def contents(opened: Studio) -> Any:
    return opened.ask("GET", f"{opened.session}/logs/0/contents").json


def keep(opened: Studio) -> Any:
    return opened.ask("POST", f"{opened.session}/logs/0/map", {})


def new_session(opened: Studio, name: str, data: bytes) -> Any:
    key = opened.ask("POST", "/api/sessions", {"name": "next"}).json["id"]
    return opened.ask("POST", f"/api/sessions/{key}/files?name={name}", data).json


def test_a_kept_map_reads_the_next_log_with_these_heads(
    opened: Studio, foreign: Path, tmp_path: Path
) -> None:
    assert contents(opened)["mapped"] is False
    refused = keep(opened)
    assert (refused.status, "nothing is chosen" in refused.json["error"]) == (400, True)
    opened.choose(columns=COLUMNS)
    assert (contents(opened)["mapped"], contents(opened)["kept"]) == (True, False)
    assert keep(opened).status == 200
    assert contents(opened)["kept"] is True

    data = foreign.read_bytes()
    sent = new_session(opened, "other.csv", data)
    assert sent["choices"]["columns"] == COLUMNS
    assert sent["steps"][1]["lock"] == ""
    others = new_session(opened, "another.csv", data.replace(b"kraft", b"strom"))
    assert others["choices"]["columns"] == {}

    with studio(tmp_path / "home", foreign) as again:  # named on the command line, after a restart
        assert again.ask("GET", again.session).json["choices"]["columns"] == COLUMNS


def test_a_map_that_is_kept_anew_takes_the_place_of_the_old(opened: Studio, foreign: Path) -> None:
    opened.choose(columns=COLUMNS)
    keep(opened)
    inches = COLUMNS | {"position": "weg [inch]"}
    opened.choose(columns=inches, rate=None)
    assert contents(opened)["kept"] is False
    keep(opened)
    sent = new_session(opened, "other.csv", foreign.read_bytes())
    assert sent["choices"]["columns"] == inches


def test_a_damaged_file_of_maps_is_told_in_a_line(
    tmp_path: Path,
    foreign: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / FILE).write_text("[[log", encoding="utf-8")
    run = caller(monkeypatch, capsys)
    refused = run("studio", str(foreign), "--home", str(tmp_path), "--no-browser")
    assert refused.status == 2
    assert FILE in refused.err
    assert refused.err.count("\n") == 1
