"""What is in a log is looked for once, however often a window asks."""

from pathlib import Path
from typing import Any

import pytest

from stribeck.data.readers.log_map import LogMap, save_map
from stribeck.errors import InputError
from stribeck.studio import routes
from stribeck.studio.choices import Choices
from stribeck.studio.home import Home
from stribeck.studio.log_view import log_contents
from stribeck.studio.routes import Routes
from stribeck.studio.session_request import Request
from stribeck.studio.workers import Workers
from studio_server import sliding_log


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The logs that were looked into, each time anew."""
    looked: list[Path] = []

    def counted(request: Any, log: int) -> dict[str, Any]:
        looked.append(Path(request.path(log)))
        return log_contents(request, log)

    monkeypatch.setattr(routes, "log_contents", counted)
    return looked


@pytest.mark.parametrize("readable", [True, False])
def test_a_log_is_looked_into_once_also_where_it_cannot_be_read(
    tmp_path: Path, looks: list[Path], *, readable: bool
) -> None:
    file = sliding_log(tmp_path / "axis.csv")
    if not readable:
        file.write_bytes(b"\0\1\2")
    with Home(tmp_path / "home") as home:
        log = home.keep_log(file.name, file)
        session = home.begin("mine", Choices().changed({"logs": [{"id": log.id}]}))
        answers = Routes(home, Workers(home.folder))
        states = [answers.document(session)["steps"][1]["lock"] for _ in range(5)]
        assert states == ["" if readable else "lock.unread"] * 5
        assert looks == [file]
        home.change(session.id, {"rate": 100.0})  # read otherwise, it is another log
        answers.document(home.session(session.id))
        assert len(looks) == 2


def test_a_refusal_is_tried_again_by_who_opens_the_page_and_not_by_who_follows_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What kept a log from being read may pass without a trace in the file."""
    refusals = [InputError("the disk is away")]

    def once(request: Any, log: int) -> dict[str, Any]:
        if refusals:
            raise refusals.pop()
        return log_contents(request, log)

    monkeypatch.setattr(routes, "log_contents", once)
    file = sliding_log(tmp_path / "axis.csv")
    with Home(tmp_path / "home") as home:
        log = home.keep_log(file.name, file)
        session = home.begin("mine", Choices().changed({"logs": [{"id": log.id}]}))
        answers = Routes(home, Workers(home.folder))
        assert [answers.document(session)["steps"][1]["detail"] for _ in range(3)] == [
            "the disk is away"
        ] * 3
        request = Request(session.choices, {log.id: file})
        assert answers.contents_of(request, 0, again=True)["lacking"] == ""
        assert answers.document(session)["steps"][1]["lock"] == ""


def test_a_map_beside_a_log_changes_what_is_in_it(tmp_path: Path, looks: list[Path]) -> None:
    file = sliding_log(tmp_path / "axis.csv")
    text = file.read_text(encoding="utf-8").replace("t_s,position_mm,force_N", "zeit,weg,kraft")
    file.write_text(text, encoding="utf-8")
    with Home(tmp_path / "home") as home:
        log = home.keep_log(file.name, file)
        session = home.begin("mine", Choices().changed({"logs": [{"id": log.id}]}))
        answers = Routes(home, Workers(home.folder))
        assert answers.document(session)["steps"][1]["lock"] == "lock.unread"
        columns = {"time": "zeit [s]", "position": "weg [mm]", "force": "kraft [N]"}
        save_map(tmp_path, ["zeit", "weg", "kraft"], LogMap.of(columns))
        assert answers.document(session)["steps"][1]["lock"] == ""
        assert len(looks) == 2
