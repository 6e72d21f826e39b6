"""Refusals of the store, one line each; a refused file stays unchanged."""

import contextlib
import errno
import multiprocessing as mp
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from filelock import FileLock

from stribeck.bench import database
from stribeck.bench.record import Job, Record, Steps
from stribeck.bench.spreadsheets import write_sheets
from stribeck.bench.store import Store
from stribeck.errors import InputError
from stribeck.report.folder import write_files

SPAWN: Any = mp.get_context("forkserver" if sys.platform == "linux" else "spawn")
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="POSIX limits and users")


def job(repeat: int, budget: int = 100, R: float = 0.2) -> Job:
    method = {"name": "ats", "settings": {"R": R, "N": 30}}
    return Job("BF", "ats", repeat, 5, budget, 1e-9, 0.0, {"surface": "BF"}, method)


def record(job: Job, steps: int = 300) -> Record:
    costs = -np.arange(float(steps)) - job.repeat
    counts = np.arange(1, steps + 1)
    return Record(
        job, (0.0, 1.0), costs[-1], 100, "budget", 0, {}, {}, Steps(counts, counts, costs)
    )


def opened(file: Path, campaign: str = "small", seed: int = 5) -> Store:
    return Store.open(file, campaign=campaign, seed=seed)


def refusal(call: Callable[[], object]) -> str:
    with pytest.raises(InputError) as caught:
        call()
    message = str(caught.value)
    assert "\n" not in message
    return message


def snapshot(folder: Path) -> dict[str, bytes]:
    return {f.name: f.read_bytes() for f in folder.iterdir() if f.is_file()}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A store with twenty finished runs."""
    path = tmp_path / "store.sqlite"
    with opened(path) as store:
        store.add(job(r) for r in range(20))
        while (claimed := store.claim()) is not None:
            store.commit(record(claimed))
    return path


def cut(file: Path) -> None:
    data = file.read_bytes()
    file.write_bytes(data[: len(data) * 3 // 5])


def scramble(file: Path) -> None:
    data = bytearray(file.read_bytes())
    data[4096 : 4096 + 8192] = bytes(range(256)) * 32
    file.write_bytes(data)


def shell(*commands: str) -> Callable[[Path], None]:
    def do(file: Path) -> None:
        db = sqlite3.connect(file)
        for command in commands:
            db.execute(command)
        db.commit()
        db.close()

    return do


def foreign(file: Path) -> None:
    file.unlink()
    shell("CREATE TABLE records (a, b)")(file)


DAMAGES: dict[str, tuple[Callable[[Path], object], str]] = {
    "truncated": (cut, "is damaged ("),
    "scrambled": (scramble, "is damaged"),
    "text": (lambda f: f.write_text("problem,cost\n"), "is not a store of a campaign"),
    "picture": (lambda f: f.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(99)), "is not a store"),
    "only a head": (lambda f: f.write_bytes(f.read_bytes()[:100]), "is damaged"),
    "head cut": (lambda f: f.write_bytes(f.read_bytes()[:40]), "is a database of another program"),
    "empty": (lambda f: f.write_bytes(b""), "is empty, not a store"),
    "of another program": (foreign, "is a database of another program"),
    "newer": (
        shell("PRAGMA user_version = 3"),
        "was written by a newer stribeck (schema 3; this one reads 1)",
    ),
    "older": (
        shell("PRAGMA user_version = 0"),
        "was written by an older stribeck (schema 0; this one reads 1)",
    ),
    "a table dropped": (shell("DROP TABLE traces"), "is damaged (table 'traces' is missing"),
    "a column added": (
        shell("ALTER TABLE records ADD COLUMN mine"),
        "is damaged (table 'records' is",
    ),
    "campaign forgotten": (
        shell("DELETE FROM meta"),
        "is damaged (it does not say which campaign it is of",
    ),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_bad_file_is_refused_and_left_alone(file: Path, damage: str) -> None:
    spoil, words = DAMAGES[damage]
    spoil(file)
    before = snapshot(file.parent)
    for call in (lambda: opened(file), lambda: Store.read(file)):
        message = refusal(call)
        assert message.startswith(f"{file}: {words}")
    assert snapshot(file.parent) == before


def test_what_a_killed_process_left_is_kept_even_beside_a_damaged_store(
    file: Path, tmp_path: Path
) -> None:
    copy = tmp_path / "copy"
    copy.mkdir()
    with opened(file) as store:
        store.add([job(20)])
        store.commit(record(job(20)))
        for name in ("store.sqlite", "store.sqlite-wal"):  # as a kill would leave them
            shutil.copy(tmp_path / name, copy / name)
    before = snapshot(copy)
    cut(copy / "store.sqlite")
    damaged = snapshot(copy)
    assert "is damaged" in refusal(lambda: opened(copy / "store.sqlite"))
    after = snapshot(copy)
    assert {name: after[name] for name in damaged} == damaged
    (copy / "store.sqlite").write_bytes(before["store.sqlite"])
    assert len(stored_records(copy / "store.sqlite")) == 21


@pytest.mark.parametrize(("campaign", "seed"), [("other", 5), ("small", 6)])
def test_the_store_of_another_campaign_is_refused(file: Path, campaign: str, seed: int) -> None:
    before = snapshot(file.parent)
    message = refusal(lambda: opened(file, campaign, seed))
    assert message == (
        f"{file}: is the store of campaign 'small' with seed 5, "
        f"not of {campaign!r} with seed {seed}: take another --out"
    )
    assert snapshot(file.parent) == before


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"budget": 200}, "ats on BF: budget 100 in the store, 200 in the campaign"),
        ({"R": 0.3}, "ats on BF: method.settings.R 0.2 in the store, 0.3 in the campaign"),
    ],
)
def test_a_cell_that_was_run_otherwise_is_refused(
    file: Path, changed: dict[str, Any], words: str
) -> None:
    with opened(file) as store:
        message = refusal(lambda: store.add([job(30), job(1, **changed)]))
        assert message == f"{file}: {words}: take another --out or give the method another name"
        assert (store.left(), store.claim()) == (0, None)  # run 30 was not added either
        store.add([job(31)])
        assert store.left() == 1


@pytest.mark.parametrize("change", ["DELETE FROM traces", "UPDATE records SET x = '[1, '"])
def test_a_record_in_pieces_is_not_passed_over(file: Path, change: str) -> None:
    with contextlib.closing(sqlite3.connect(file)) as db:
        db.execute(change)
        db.commit()
    with Store.read(file) as store:
        message = refusal(lambda: list(store.records()))
    assert message.startswith(f"{file}: is damaged (a record cannot be read: ")


def test_what_is_not_there(tmp_path: Path) -> None:
    file = tmp_path / "store.sqlite"
    resume = refusal(lambda: Store.open(file, campaign="small", seed=5, must_exist=True))
    assert resume.startswith(f"{file}: there is no store to go on with")
    assert refusal(lambda: Store.read(file)).startswith(f"{file}: there is no store")
    assert not list(tmp_path.iterdir())
    with opened(tmp_path / "new" / "store.sqlite"):
        pass


def test_a_folder_is_no_store(tmp_path: Path) -> None:
    for call in (lambda: opened(tmp_path), lambda: Store.read(tmp_path)):
        assert refusal(call) == f"{tmp_path}: is a folder, not a store: name a file"


@pytest.mark.parametrize(
    "hold", [("BEGIN IMMEDIATE",), ("PRAGMA locking_mode = EXCLUSIVE", "BEGIN EXCLUSIVE")]
)
def test_a_store_that_another_program_holds(
    file: Path, hold: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(database, "PATIENCE", 0.05)
    connection = sqlite3.connect(file, isolation_level=None)
    for command in hold:
        connection.execute(command)
    message = refusal(lambda: opened(file))
    assert message.startswith(f"{file}: is locked by another program")
    connection.close()
    with opened(file) as store:
        store.add([job(0)])
        assert store.left() == 0


def unprivileged(file: Path, pipe: Connection) -> None:
    """Read the store as a user without the right to write there; send the outcome."""
    if os.geteuid() == 0:
        os.setgroups([])
        os.setgid(65534)
        os.setuid(65534)
    for use in (opened, Store.read):
        try:
            with use(file) as store:
                pipe.send(str(len(list(store.records()))))
        except InputError as error:
            pipe.send(str(error))


@POSIX
@pytest.mark.parametrize("folder", [0o555, 0o777])
def test_a_store_that_may_only_be_read(folder: int) -> None:
    place = Path(tempfile.mkdtemp())
    file = place / "store.sqlite"
    try:
        with opened(file) as store:
            store.add([job(0)])
            store.commit(record(job(0)))
        file.chmod(0o444)
        place.chmod(folder)
        before = snapshot(place)
        ours, theirs = SPAWN.Pipe()
        process = SPAWN.Process(target=unprivileged, args=(file, theirs), daemon=True)
        process.start()
        assert ours.recv() == f"{file}: cannot be written: make it and its folder writable"
        assert ours.recv() == "1"  # it can be looked at
        process.join()
        after = snapshot(place)
        assert {n: after[n] for n in before} == before
    finally:
        place.chmod(0o755)
        shutil.rmtree(place)


def fill(file: Path, limit: int, pipe: Connection) -> None:
    """Run a campaign whose file may grow to `limit` bytes (0: no bound); send the outcome."""
    if limit:
        import resource  # noqa: PLC0415 - POSIX

        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    committed = -1
    try:
        with opened(file) as store:
            committed = 0
            store.add(job(r) for r in range(60))
            while (claimed := store.claim()) is not None:
                store.commit(record(claimed))
                committed += 1
        pipe.send((committed, "done"))
    except InputError as error:
        pipe.send((committed, str(error)))


def fill_in_process(file: Path, limit: int = 0) -> tuple[int, str]:
    ours, theirs = SPAWN.Pipe()
    process = SPAWN.Process(target=fill, args=(file, limit, theirs), daemon=True)
    process.start()
    theirs.close()
    reply: tuple[int, str] = ours.recv()
    process.join()
    return reply


def stored_records(file: Path) -> list[str]:
    with Store.read(file) as store:
        return [r.content for r in store.records()]


EXPECTED = [record(job(r)).content for r in range(60)]


@POSIX
@pytest.mark.parametrize("limit", [1_000, 40_000, 90_000, 150_000, 300_000])
def test_a_full_disk_loses_nothing(tmp_path: Path, limit: int) -> None:
    file = tmp_path / "store.sqlite"
    committed, message = fill_in_process(file, limit)
    assert message.startswith("the disk is full")
    assert message.endswith("make room and give the same command again")
    if committed >= 0:
        assert f"{committed} finished runs are safe in {file}" in message
        assert stored_records(file) == EXPECTED[:committed]
    else:
        assert f"{file} cannot be made" in message
        assert not list(tmp_path.iterdir())
    assert fill_in_process(file) == (60 - max(committed, 0), "done")
    assert stored_records(file) == EXPECTED
    assert [f.name for f in tmp_path.iterdir()] == ["store.sqlite"]


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 700 kB."""
    place = tmp_path / "disk"
    place.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=700k", "tmpfs", str(place)]
    if sys.platform != "linux" or os.geteuid() != 0:
        pytest.skip("only root can mount a small disk")
    if subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("no disk can be mounted here")
    yield place
    subprocess.run(["umount", str(place)], check=True)  # noqa: S607


@pytest.mark.parametrize("room", [0, 20_000, 100_000, 200_000, 400_000])
def test_a_disk_that_is_really_full_loses_nothing(disk: Path, room: int) -> None:
    file, filler = disk / "store.sqlite", disk / "ballast"
    filler.write_bytes(bytes(shutil.disk_usage(disk).free - room))
    committed, message = fill_in_process(file)
    assert message.startswith("the disk is full")
    assert str(file) in message
    filler.unlink()
    if committed >= 0:
        assert f"{committed} finished runs are safe" in message
        assert stored_records(file) == EXPECTED[:committed]
    subprocess.run(["mount", "-o", "remount,size=9m", str(disk)], check=True)  # noqa: S607
    assert fill_in_process(file) == (60 - max(committed, 0), "done")
    assert stored_records(file) == EXPECTED


def test_no_room_for_the_lock(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def disk_full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with opened(file) as store:
        store.add([job(40)])
        monkeypatch.setattr(FileLock, "acquire", disk_full)
        assert refusal(store.claim) == (
            f"the disk is full: 20 finished runs are safe in {file}; "
            "make room and give the same command again"
        )


def test_tables_cannot_be_written_into_a_file(file: Path) -> None:
    with Store.read(file) as store:
        assert "cannot be written" in refusal(
            lambda: write_files(file, partial(write_sheets, store.records()))
        )
