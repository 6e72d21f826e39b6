"""A folder of results: whole or not at all, one writer at a time, however a process ends."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from command import caller
from stribeck import InputError, read_card
from stribeck.draft import PREFIX, Draft, settle
from stribeck.report.folder import check_folder, held, together, write_all, write_files, write_text
from stribeck.report.motion_file import write_twin
from stribeck.rig.twin import TestBed
from test_select_truth import write_directional_logs

#: Kills the process at one of its calls of a function.
KILLED = """
import os, signal, sys
from itertools import count
from pathlib import Path
import {module}
real, calls = {module}.{name}, count(1)

def deadly(*arguments, **options):
    if next(calls) == {nth}:
        os.kill(os.getpid(), signal.SIGKILL)
    return real(*arguments, **options)

{module}.{name} = deadly
"""


def killed(folder: Path, module: str, name: str, nth: int, code: str) -> None:
    """Run code in a process of its own that is killed when it calls a function the nth time."""
    program = KILLED.format(module=module, name=name, nth=nth) + code
    done = subprocess.run([sys.executable, "-c", program], cwd=folder, check=False)
    assert done.returncode == -signal.SIGKILL


def texts(folder: Path) -> dict[str, str]:
    return {f.name: f.read_text(encoding="utf-8") for f in folder.iterdir() if f.is_file()}


OLD = {name: f"old {name}" for name in ("a", "b", "c", "training.png")}
NEW = {name: f"new {name}" for name in ("a", "b", "c", "sub/d")}
WRITE = """
import re
from stribeck.report.folder import together
with together(Path("fit"), re.compile("training.png")) as place:
    (place / "sub").mkdir()
    for name in ("a", "b", "c", "sub/d"):
        (place / name).write_text("new " + name)
"""


@pytest.fixture
def fit_folder(tmp_path: Path) -> Path:
    write_all(tmp_path / "fit", {name: text.encode() for name, text in OLD.items()})
    return tmp_path / "fit"


@pytest.mark.parametrize("nth", [1, 2, 3, 4])
def test_killed_while_files_are_moved_the_next_process_moves_the_others(
    fit_folder: Path, nth: int
) -> None:
    killed(fit_folder.parent, "os", "replace", nth, WRITE)
    assert texts(fit_folder) != OLD
    settle(fit_folder)
    every = {str(f.relative_to(fit_folder)) for f in fit_folder.rglob("*") if f.is_file()}
    assert {name: (fit_folder / name).read_text() for name in every} == NEW


@pytest.mark.parametrize("nth", [1, 2, 4])
def test_killed_before_all_is_written_everything_is_old(fit_folder: Path, nth: int) -> None:
    killed(fit_folder.parent, "pathlib", "Path.write_text", nth, WRITE)
    assert texts(fit_folder) == OLD
    assert any(f.name.startswith(PREFIX) for f in fit_folder.iterdir())
    write_all(fit_folder, {"z": b"z"})
    assert texts(fit_folder) == OLD | {"z": "z"}
    assert not any(f.name.startswith(PREFIX) for f in fit_folder.iterdir())


def test_what_a_living_process_writes_is_left_alone(fit_folder: Path) -> None:
    draft = Draft(fit_folder)
    (draft.files / "a").write_text("new a", encoding="utf-8")
    write_all(fit_folder, {"z": b"z"})
    draft.publish()
    assert texts(fit_folder) == OLD | {"z": "z", "a": "new a"}
    assert not any(f.name.startswith(PREFIX) for f in fit_folder.iterdir())


def test_an_error_leaves_what_was_there(fit_folder: Path) -> None:
    def write(place: Path) -> None:
        (place / "a").write_text("new a", encoding="utf-8")
        raise OSError(28, "No space left on device")

    with pytest.raises(InputError, match="cannot be written: No space left"):
        write_files(fit_folder, write)
    assert texts(fit_folder) == OLD
    with pytest.raises(InputError, match="cannot be written: No space left"):
        write_files(fit_folder.parent / "new", write)
    assert not (fit_folder.parent / "new").exists()


def test_ctrl_c_keeps_what_is_whole(fit_folder: Path) -> None:
    def interrupted() -> None:
        with together(fit_folder) as place:
            write_all(place, {"a": b"new a"})
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert texts(fit_folder) == OLD | {"a": "new a"}


def test_a_folder_in_the_way_is_told_before_anything_moves(fit_folder: Path) -> None:
    (fit_folder / "z").mkdir()
    with pytest.raises(InputError, match="cannot be written: it is a folder"):
        write_all(fit_folder, {"a": b"new a", "z": b"z"})
    assert texts(fit_folder) == OLD


def test_a_strangers_draft_reaches_nothing_outside_its_folder(fit_folder: Path) -> None:
    outside = fit_folder.parent / "mine"
    outside.mkdir()
    (outside / "kept").write_text("kept", encoding="utf-8")
    (fit_folder / "linked").symlink_to(outside)
    draft = fit_folder / f"{PREFIX}strange"
    (draft / "files" / "linked").mkdir(parents=True)
    (draft / "files" / "linked" / "kept").write_text("gone", encoding="utf-8")
    (draft / "complete").write_text("../mine/kept\n", encoding="utf-8")
    with pytest.raises(OSError, match="it is a link"):
        settle(fit_folder)
    assert (outside / "kept").read_text(encoding="utf-8") == "kept"


def test_the_second_writer_is_told(fit_folder: Path) -> None:
    program = (
        "from pathlib import Path\nfrom stribeck.report.folder import held\n"
        "with held(Path('fit')):\n    print(flush=True)\n    input()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], cwd=fit_folder.parent,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as first:  # fmt: skip
        assert first.stdout is not None
        first.stdout.readline()
        with pytest.raises(InputError, match="another stribeck is writing"), held(fit_folder):
            pass
        first.kill()
        first.wait()
    with held(fit_folder):  # the lock has died with its process
        pass
    assert texts(fit_folder) == OLD


def test_a_folder_that_was_held_for_nothing_is_gone(tmp_path: Path) -> None:
    with pytest.raises(InputError), held(tmp_path / "new"):
        raise InputError("nothing came of it")
    assert not (tmp_path / "new").exists()


def test_folders_on_the_way_are_made_and_go_with_it(tmp_path: Path) -> None:
    deep = tmp_path / "a" / "b" / "fit"
    check_folder(deep)
    with pytest.raises(InputError), held(deep):
        raise InputError("nothing came of it")
    assert not (tmp_path / "a").exists()
    write_text(deep / "x.txt", "x")
    assert [p.name for p in deep.iterdir()] == ["x.txt"]


# --- through the command line --------------------------------------------------------------------


@pytest.fixture
def stribeck_(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Any:
    write_directional_logs(tmp_path, "ab", 5.0)
    monkeypatch.chdir(tmp_path)
    return caller(monkeypatch, capsys)


OLDER_FIT = dict.fromkeys(
    ("card.json", "report.json", "report.html", "training.png", "friction.svg"), b"older"
)
PAGE_OF_A_FIT = {"card.json", "report.json", "report.html"}
IDENTIFY = ("identify", "a.csv", "--rig", "forced", "--law", "coulomb-viscous", "--out", "fit")


@pytest.mark.parametrize(
    ("module", "name", "kept"),
    [
        ("stribeck.report.contents.gather", "Contents", {"card.json"}),
        ("stribeck.report.figures.fit_figures", "save", PAGE_OF_A_FIT),
    ],
)
def test_a_fit_that_is_killed_has_its_card_and_nothing_of_the_older_fit(
    stribeck_: Any, tmp_path: Path, module: str, name: str, kept: set[str]
) -> None:
    write_all(tmp_path / "fit", OLDER_FIT)
    words = ["stribeck", *(w.replace("a.csv", "b.csv") for w in IDENTIFY)]
    code = f"sys.argv = {words}\nfrom stribeck.cli import main\nmain()\n"
    killed(tmp_path, module, name, 1, code)
    left = texts_of(tmp_path / "fit")
    assert set(left) == kept
    assert read_card(tmp_path / "fit" / "card.json").data[0].file == "b.csv"
    status = stribeck_("report", "fit").status  # reads card and report as those of one fit
    assert status == (0 if kept == PAGE_OF_A_FIT else 2)
    assert not [p for p in (tmp_path / "fit").iterdir() if p.name.startswith(PREFIX)]


@pytest.mark.usefixtures("stribeck_")
def test_a_comparison_that_is_killed_while_it_is_drawn_is_kept(tmp_path: Path) -> None:
    write_all(tmp_path / "fit", OLDER_FIT)
    words = ["stribeck", "select", "b.csv", "--rig", "forced", "--laws",
             "coulomb-viscous,coulomb-viscous-directional", "--out", "fit"]  # fmt: skip
    code = f"sys.argv = {words}\nfrom stribeck.cli import main\nmain()\n"
    killed(tmp_path, "stribeck.report.selection_report", "figure", 1, code)
    assert set(texts_of(tmp_path / "fit")) == {"card.json", "selection.json"}
    assert read_card(tmp_path / "fit" / "card.json").data[0].file == "b.csv"


def test_a_card_and_a_report_of_two_fits_are_refused(stribeck_: Any, tmp_path: Path) -> None:
    assert stribeck_(*IDENTIFY[:-1], "other").status == 0
    card = tmp_path / "other" / "card.json"
    data = json.loads(card.read_text(encoding="utf-8"))
    data["parameters"]["F_C"]["value"] *= 1.01
    card.write_text(json.dumps(data), encoding="utf-8")
    refused = stribeck_("report", "other")
    assert refused.status == 2
    assert "card.json and report.json are not of one fit" in refused.err


def test_log_and_truth_of_a_twin_move_into_place_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    moved: list[list[str]] = []
    publish = Draft.publish

    def noted(draft: Draft, outdated: Any = ()) -> None:
        moved.append(sorted(f.name for f in draft.files.iterdir()))
        publish(draft, outdated)

    monkeypatch.setattr(Draft, "publish", noted)
    files = write_twin(TestBed(low=0.1, high=0.13), "up", 1, tmp_path / "bed.csv")
    assert moved == [["bed.csv", "bed.truth.json"]]
    assert all(f.exists() for f in files)


def texts_of(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir() if not p.name.startswith(PREFIX)}


def test_a_command_whose_folder_is_held_is_told_before_its_work(
    stribeck_: Any, tmp_path: Path
) -> None:
    (tmp_path / "fit").mkdir()
    lock = f"{PREFIX}lock"
    program = (
        "from filelock import FileLock\n"
        f"with FileLock('fit/{lock}'):\n    print(flush=True)\n    input()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], cwd=tmp_path,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as first:  # fmt: skip
        assert first.stdout is not None
        first.stdout.readline()
        for words in (IDENTIFY, ("select", *IDENTIFY[1:4], "--out", "fit")):
            second = stribeck_(*words)
            assert second.status == 2
            assert second.err.splitlines()[-1] == (
                "stribeck: fit: another stribeck is writing its results there: wait for it, or "
                "take another folder"
            )
        first.kill()
    assert [p.name for p in (tmp_path / "fit").iterdir()] == [lock]
