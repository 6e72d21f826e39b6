"""What the studio keeps: every choice can be undone, and nothing that was kept is lost."""

import shutil
import sqlite3
from pathlib import Path

import pytest

from stribeck.bench.lock import Owner
from stribeck.errors import InputError
from stribeck.studio.choices import Choices
from stribeck.studio.home import STARTS, Home


def test_choices_are_undone_and_redone_one_by_one(tmp_path: Path) -> None:
    with Home(tmp_path) as home:
        key = home.begin("mine", Choices()).id
        home.change(key, {"rig": "emps"})
        home.change(key, {"law": "stribeck"})
        assert home.turn(key, -1).choices == Choices(rig="emps")
        assert home.turn(key, -1).choices == Choices()
        assert home.turn(key, -1).choices == Choices()  # there is nothing before the first
        assert home.turn(key, 1).choices == Choices(rig="emps")
        again = home.change(key, {"law": "dahl"})  # another way from here
        assert (again.undo, again.redo) == (True, False)
        assert home.turn(key, -1).choices == Choices(rig="emps")


def test_a_session_without_a_name_has_that_of_its_first_log(tmp_path: Path) -> None:
    with Home(tmp_path / "home") as home:
        (tmp_path / "axis.csv").write_text("t_s,x_mm\n", encoding="utf-8")
        log = home.keep_log("axis.csv", tmp_path / "axis.csv")
        keys = [home.begin(name, Choices()).id for name in ("mine", "", "")]
        for key in keys[:2]:
            home.change(key, {"logs": [{"id": log.id}]})
        names = {key: name for key, name, _ in home.sessions()}
        assert [names[key] for key in keys] == ["mine", "axis.csv", ""]


def test_two_windows_do_not_overwrite_each_other(tmp_path: Path) -> None:
    with Home(tmp_path) as home, Home(tmp_path) as other:
        session = home.begin("mine", Choices())
        other.change(session.id, {"rig": "emps"}, session.step)
        with pytest.raises(InputError, match="another window"):
            home.change(session.id, {"rig": "forced"}, session.step)
        assert home.session(session.id).choices.rig == "emps"


def test_a_refused_change_changes_nothing(tmp_path: Path) -> None:
    with Home(tmp_path) as home:
        session = home.begin("mine", Choices(rig="emps"))
        with pytest.raises(InputError, match="repeats"):
            home.change(session.id, {"law": "dahl", "repeats": 0})
        assert home.session(session.id) == session


def test_a_home_that_is_copied_while_open_is_whole(tmp_path: Path) -> None:
    """What a kill leaves is what lies on the disk."""
    with Home(tmp_path / "a") as home:
        key = home.begin("mine", Choices()).id
        for seed in range(20):
            home.change(key, {"seed": seed})
            shutil.copytree(tmp_path / "a", tmp_path / f"b{seed}")
            with Home(tmp_path / f"b{seed}") as copy:
                assert copy.session(key).choices.seed == seed


def test_a_job_is_claimed_once_and_waits_again_when_its_worker_is_gone(tmp_path: Path) -> None:
    with Home(tmp_path) as home:
        job = home.ask(home.begin("mine", Choices()).id, "identify")
        for start in range(STARTS):
            (waiting,) = home.unfinished()
            assert waiting.state == "waiting"
            with Owner(home.file) as one, Owner(home.file) as two:
                assert home.claim(job.id, one)
                assert not home.claim(job.id, two)
                assert [j.state for j in home.unfinished()] == ["running"], start
        assert home.unfinished() == []
        assert home.job(job.id).state == "failed"
        assert "three times" in home.job(job.id).message


def test_a_waiting_job_is_cancelled_at_once(tmp_path: Path) -> None:
    with Home(tmp_path) as home, Owner(home.file) as owner:
        job = home.ask(home.begin("mine", Choices()).id, "identify")
        home.cancel(job.id)
        assert home.job(job.id).state == "failed"
        assert not home.claim(job.id, owner)


@pytest.mark.parametrize(
    ("table", "column", "value"),
    [
        ("states", "choices", "{"),
        ("states", "choices", '{"logs": 7}'),
        ("states", "choices", '{"axis": {"a": [[[[[[[[1]]]]]]]]}}'),
        ("states", "choices", '{"axis": {"a": "' + "x" * 30_000 + '"}}'),
        ("states", "choices", '{"__class__": "os.system"}'),
        ("states", "choices", "[" * 100_000),
        ("jobs", "request", "null"),
        ("jobs", "kind", "rm -rf"),
        ("jobs", "progress", "["),
    ],
)
def test_a_session_edited_into_nonsense_is_refused_in_a_line(
    tmp_path: Path, table: str, column: str, value: str
) -> None:
    with Home(tmp_path) as home:
        key = home.begin("mine", Choices()).id
        home.ask(key, "identify")
    with sqlite3.connect(tmp_path / "studio.sqlite") as db:
        db.execute(f"UPDATE {table} SET {column} = ?", (value,))  # noqa: S608
    db.close()
    with Home(tmp_path) as home, pytest.raises(InputError, match="damaged") as refused:
        (home.session if table == "states" else home.jobs)(key)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("content", [b"", b"no database at all" * 100])
def test_another_file_in_its_place_is_refused_or_taken_over(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "studio.sqlite").write_bytes(content)
    if not content:  # SQLite's own empty database
        Home(tmp_path).close()
        return
    with pytest.raises(InputError, match="--home"):
        Home(tmp_path)
    assert (tmp_path / "studio.sqlite").read_bytes() == content


def test_the_database_of_another_program_is_left_alone(tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / "studio.sqlite") as db:
        db.execute("CREATE TABLE theirs (x)")
    db.close()
    with pytest.raises(InputError, match="is not a studio's"):
        Home(tmp_path)
