"""The store: no result lost and no job run twice when processes are killed or interrupted."""

import csv
import json
import math
import multiprocessing as mp
import os
import signal
import sqlite3
import sys
from collections import Counter
from collections.abc import Generator, Iterator
from functools import partial
from itertools import count
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stribeck.bench.engines import Here
from stribeck.bench.lock import Owner, alive
from stribeck.bench.record import Failure, Job, Record, Steps
from stribeck.bench.run import run
from stribeck.bench.runner import conduct
from stribeck.bench.spreadsheets import write_sheets
from stribeck.bench.store import Store
from stribeck.optimize.methods import unit_free
from stribeck.report.folder import write_files

SPAWN: Any = mp.get_context("forkserver" if sys.platform == "linux" else "spawn")
if sys.platform == "linux":
    SPAWN.set_forkserver_preload(
        ["stribeck.bench.run", "stribeck.bench.store", "polars", "hypothesis", "pytest"]
    )


def make(problem: str, algorithm: str, repeat: int, budget: int = 90) -> Job:
    options = {} if algorithm == "random" else unit_free(algorithm, {})
    return Job(
        problem=problem,
        algorithm=algorithm,
        repeat=repeat,
        seed=5,
        budget=budget,
        target=1e-2,
        minimum=0.0,
        surface={"surface": problem, "dim": 2, "twin": None},
        method={"name": algorithm, "settings": options},
    )


def campaign(
    repeats: int = 10, algorithms: tuple[str, ...] = ("bts", "ats", "random")
) -> list[Job]:
    return [make(p, a, r) for r in range(repeats) for p in ("BF", "RF") for a in algorithms]


def opened(file: Path) -> Store:
    return Store.open(file, campaign="small", seed=5)


def work(file: Path, leash: bool, pipe: Connection) -> None:
    """Run the jobs of a store and send each step; on a `leash` wait for a word before each."""
    with opened(file) as store:
        store.add(campaign())
        while (not leash or pipe.recv()) and (job := store.claim()) is not None:
            pipe.send(job.key)
            record = run(job)
            pipe.send("ran")
            store.commit(record)
            pipe.send("committed")
    pipe.send("done")


def start_process(target: Any, *arguments: Any) -> tuple[Any, Connection]:
    ours, theirs = SPAWN.Pipe()
    process = SPAWN.Process(target=target, args=(*arguments, theirs), daemon=True)
    process.start()
    theirs.close()
    return process, ours


def messages(pipe: Connection) -> Iterator[str]:
    try:
        while True:
            yield pipe.recv()
    except (EOFError, ConnectionResetError):
        return


def content(file: Path) -> list[str]:
    """The contents of a store without times and names of processes."""
    with sqlite3.connect(file) as db:
        assert db.execute("SELECT count(*) FROM claims").fetchone() == (0,)
        assert db.execute("SELECT count(*) FROM failures").fetchone() == (0,)
    db.close()
    with Store.read(file) as store:
        return [record.content for record in store.records()]


@pytest.fixture(scope="module")
def reference_content(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    file = tmp_path_factory.mktemp("undisturbed") / "store.sqlite"
    with opened(file) as store:
        store.add(campaign())
        while (job := store.claim()) is not None:
            store.commit(run(job))
    return content(file)


def test_killed_ten_times_and_resumed_ends_with_the_same_records(
    tmp_path: Path, reference_content: list[str]
) -> None:
    file, rng = tmp_path / "store.sqlite", np.random.default_rng(11)
    runs: Counter[str] = Counter()
    for _ in range(10):
        process, pipe = start_process(work, file, True)
        jobs = int(rng.integers(1, 5))
        for _ in range(jobs):
            pipe.send("go on")
        for _ in range(rng.integers(0, 3 * jobs)):
            runs[pipe.recv()] += 1
        process.join(rng.uniform(0, 0.01))  # any moment: also in the middle of a commit
        process.kill()
        runs.update(messages(pipe))
        process.join()
    assert runs["committed"] < len(reference_content)
    process, pipe = start_process(work, file, False)
    runs.update(messages(pipe))
    process.join()
    assert runs.pop("done") == 1
    assert content(file) == reference_content
    runs.pop("ran")
    runs.pop("committed")
    assert len(runs) == len(reference_content)
    assert runs.total() <= len(reference_content) + 10  # a kill costs the run that was going on
    assert [f.name for f in tmp_path.iterdir()] == ["store.sqlite"]  # no log, no lock left


def test_two_processes_share_the_jobs(tmp_path: Path, reference_content: list[str]) -> None:
    file = tmp_path / "store.sqlite"  # which both of them find missing
    pair = [start_process(work, file, False) for _ in range(2)]
    runs = Counter(word for _, pipe in pair for word in messages(pipe))
    for process, _ in pair:
        process.join()
        assert process.exitcode == 0
    assert runs.pop("done") == 2
    assert runs.pop("ran") == runs.pop("committed") == len(reference_content)
    assert set(runs.values()) == {1}
    assert len(runs) == len(reference_content)
    assert content(file) == reference_content
    assert [f.name for f in tmp_path.iterdir()] == ["store.sqlite"]


def hold(file: Path, pipe: Connection) -> None:
    """Claim a job and wait until killed."""
    with opened(file) as store:
        store.add(campaign(1))
        job = store.claim()
        assert job is not None
        pipe.send(job.key)
        pipe.recv()


def test_a_claim_holds_as_long_as_its_process_lives(tmp_path: Path) -> None:
    file = tmp_path / "store.sqlite"
    process, pipe = start_process(hold, file)
    key = pipe.recv()
    with opened(file) as store:
        store.add(campaign(1))
        while (job := store.claim()) is not None:
            assert job.key != key
            store.commit(run(job))
        assert (store.left(), store.busy()) == (1, 1)
        process.kill()
        process.join()
        reclaimed = store.claim()
        assert reclaimed is not None
        assert reclaimed.key == key
        assert store.busy() == 0
        assert len([f for f in tmp_path.iterdir() if "-owner-" in f.name]) == 1  # ours


def fork(file: Path, pipe: Connection) -> None:
    owner = Owner(file)
    pipe.send(owner.name)
    pipe.send(os.fork() or os.getpid())
    signal.pause()


@pytest.mark.skipif(sys.platform != "linux", reason="forks")
def test_a_forked_child_does_not_keep_its_parent_alive(tmp_path: Path) -> None:
    file = tmp_path / "store.sqlite"
    process, pipe = start_process(fork, file)
    name, pids = pipe.recv(), {pipe.recv(), pipe.recv()}
    (child,) = pids - {process.pid}
    try:
        assert alive(file, name)
        process.kill()
        process.join()
        os.kill(child, 0)
        assert not alive(file, name)
        assert not (tmp_path / name).exists()
    finally:
        os.kill(child, signal.SIGKILL)


def test_an_owner_lives_until_it_is_closed(tmp_path: Path) -> None:
    file = tmp_path / "store.sqlite"
    with Owner(file) as first, Owner(file) as second:
        assert first.name != second.name
        assert alive(file, first.name)
        assert alive(file, second.name)
    assert not alive(file, first.name)
    assert not list(tmp_path.iterdir())


def test_a_name_from_a_file_leads_to_no_other_file(tmp_path: Path) -> None:
    (tmp_path / "precious").touch()
    store = tmp_path / "folder" / "store.sqlite"
    store.parent.mkdir()
    for name in ("../precious", str(tmp_path / "precious"), "store.sqlite-owner-/../../precious"):
        assert not alive(store, name)
    assert (tmp_path / "precious").exists()


def test_claims_come_in_order_and_to_one_store_only(tmp_path: Path) -> None:
    file, jobs = tmp_path / "store.sqlite", campaign(2)
    with opened(file) as first, opened(file) as second:
        first.add(jobs)
        second.add(jobs)
        claims = [store.claim() for store in (first, second) * 6]
        assert [j and j.key for j in claims] == [j.key for j in jobs]
        assert first.claim() is None
        assert second.busy() == 6
        first.close()  # its owner is gone, and with it the claims on every other job
        released = [second.claim() for _ in range(6)]
        assert [j and j.key for j in released] == [j.key for j in jobs[::2]]
        assert second.claim() is None


class InterruptedConnection:
    """A connection that raises Ctrl-C once, after a statement that begins with a word."""

    def __init__(self, db: sqlite3.Connection, word: str) -> None:
        self.db, self.word = db, word

    def __getattr__(self, name: str) -> Any:
        return getattr(self.db, name)

    def execute(self, sql: str, *values: Any) -> sqlite3.Cursor:
        cursor = self.db.execute(sql, *values)
        if self.word and sql.startswith(self.word):
            self.word = ""
            raise KeyboardInterrupt
        return cursor


@pytest.mark.parametrize("word", ["PRAGMA", "BEGIN", "INSERT", "DELETE FROM claims", "COMMIT"])
def test_ctrl_c_within_a_write_leaves_nothing_open(
    tmp_path: Path, word: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, jobs = tmp_path / "store.sqlite", [make("BF", "random", r) for r in range(2)]
    with opened(file) as store:
        store.add(jobs)
        job = store.claim()
        assert job is not None
        with monkeypatch.context() as patch:
            db: Any = vars(store)["_db"]
            patch.setattr(store, "_db", InterruptedConnection(db, word))
            with pytest.raises(KeyboardInterrupt):
                store.commit(run(job))
        committed = word == "COMMIT"
        assert store.left() == len(jobs) - committed
        store.commit(run(job))
        assert store.left() == len(jobs) - 1
    with opened(file) as store:  # closed without a word, and nothing of it is claimed any more
        store.add(jobs)
        assert store.claim() is not None
        assert store.busy() == 0


def test_what_interrupts_a_campaign_stops_its_engine_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Watched:
        workers, running = 1, False

        def run(self, jobs: Iterator[Any]) -> Generator[Any, None, None]:
            self.running = True
            try:
                yield from Here().run(jobs)
            finally:
                self.running = False

    def interrupted(_: Store, __: Any) -> None:
        raise KeyboardInterrupt

    engine = Watched()
    with opened(tmp_path / "store.sqlite") as store:
        store.add([make("BF", "random", 0)])
        monkeypatch.setattr(Store, "commit", interrupted)
        with pytest.raises(KeyboardInterrupt):
            list(conduct(store, engine))
        assert not engine.running


def test_a_job_given_up_is_tried_again_by_the_next_run(tmp_path: Path) -> None:
    file, jobs = tmp_path / "store.sqlite", [make("BF", "random", r) for r in range(2)]
    with opened(file) as store:
        store.add(jobs)
        first = store.claim()
        assert first is not None
        store.fail(Failure(first, "the worker died"))
        second = store.claim()
        assert second is not None
        assert second.key == jobs[1].key
        store.commit(run(second))
        assert store.claim() is None
        assert (store.left(), store.busy()) == (1, 0)
        assert [(f.job.key, f.message) for f in store.failures()] == [
            (jobs[0].key, "the worker died")
        ]
        assert [(p.done, p.given_up, p.jobs) for p in store.progress()] == [(1, 1, 2)]
    with opened(file) as store:
        store.add(jobs)
        retried = store.claim()
        assert retried is not None
        assert retried.key == jobs[0].key
        store.commit(run(retried))
        assert not store.failures()
        assert store.left() == 0


def test_only_what_the_campaign_names_now_counts(tmp_path: Path) -> None:
    file = tmp_path / "store.sqlite"
    smaller, larger = campaign(2, ("random",)), campaign(3, ("ats", "random"))
    with opened(file) as store:
        store.add(larger)
        while (job := store.claim()) is not None:
            store.commit(run(job))
    with opened(file) as store:
        store.add(smaller)
        store.add(smaller)
        assert store.left() == 0
        assert store.claim() is None
        assert {r.job.key for r in store.records()} == {j.key for j in smaller}
        store.add(campaign(1, ("bts",)))
        assert store.left() == 2
        job = store.claim()
        assert job is not None
        assert job.algorithm == "bts"
    with Store.read(file) as store:
        cells = [r.job.cell for r in store.records()]
        assert cells == [(p, a) for p in ("BF", "RF") for a in ("ats", "random") for _ in range(3)]


def test_a_store_can_be_read_while_it_is_written(tmp_path: Path) -> None:
    file, jobs = tmp_path / "store.sqlite", campaign(1)
    with opened(file) as store:
        store.add(jobs)
        with Store.read(file) as reader:
            for committed in range(1, 4):
                job = store.claim()
                assert job is not None
                store.commit(run(job))
                assert len(list(reader.records())) == committed
                assert sum(p.done for p in reader.progress()) == committed
            assert (reader.campaign, reader.seed) == ("small", 5)


def test_the_tables_are_plain(tmp_path: Path) -> None:
    file = tmp_path / "store.sqlite"
    record = run(make("BF", "random", 0))
    with opened(file) as store:
        store.add([record.job])
        store.commit(record)
        store.commit(record)  # again: nothing changes
    db = sqlite3.connect(file)
    rows = db.execute("SELECT problem, algorithm, repeat, cost, evaluations, ended FROM records")
    assert rows.fetchall() == [("BF", "random", 0, record.cost, record.evaluations, record.ended)]
    (blob,) = db.execute("SELECT costs FROM traces").fetchone()
    assert np.array_equal(np.frombuffer(blob, "<f8"), record.steps.costs)
    db.close()


FLOATS = st.floats(allow_nan=False)
WHOLE = st.integers(0, 2**63 - 1)
COUNTS = st.dictionaries(st.text(max_size=5), st.integers(0, 10**9), max_size=3)
WORDS = st.text(st.characters(exclude_categories=["Cs"]), max_size=9)
STEPS = st.lists(st.tuples(WHOLE, WHOLE, FLOATS), max_size=5)
REPEATS = count()


@pytest.fixture(scope="module")
def shared_store(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Store]:
    with opened(tmp_path_factory.mktemp("shelf") / "store.sqlite") as store:
        yield store


@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow])
@given(
    x=st.lists(FLOATS, max_size=4),
    cost=FLOATS,
    words=st.tuples(WORDS, WORDS, WORDS),
    counts=st.tuples(COUNTS, COUNTS),
    whole=st.tuples(WHOLE, WHOLE),
    steps=STEPS,
    seconds=st.floats(0, 1e9),
)
def test_a_record_comes_back_bit_for_bit(
    shared_store: Store,
    x: list[float],
    cost: float,
    words: tuple[str, str, str],
    counts: tuple[dict[str, int], dict[str, int]],
    whole: tuple[int, int],
    steps: list[tuple[int, int, float]],
    seconds: float,
) -> None:
    problem, algorithm, ended = words
    repeat = next(REPEATS)
    job = Job(problem, algorithm, repeat, whole[0], whole[1], cost, None, {"a": x}, {"b": [words]})
    evaluations, rounds, costs = zip(*steps, strict=True) if steps else ((), (), ())
    record = Record(
        job,
        tuple(x),
        cost,
        whole[0],
        ended,
        whole[1],
        *counts,
        Steps(
            np.array(evaluations, np.int64), np.array(rounds, np.int64), np.array(costs, np.float64)
        ),
        seconds,
    )
    shared_store.add([job])
    shared_store.commit(record)
    with Store.read(shared_store.file) as store:
        (restored,) = (r for r in store.records() if r.job.repeat == repeat)
    assert restored.text == record.text
    assert restored.job.key == job.key
    assert math.copysign(1, restored.cost) == math.copysign(1, cost)
    assert restored.steps.costs.tobytes() == record.steps.costs.tobytes()


def test_export_has_every_run_and_every_improvement(tmp_path: Path) -> None:
    file = tmp_path / "store.sqlite"
    with opened(file) as store:
        store.add(campaign(2))
        while (job := store.claim()) is not None:
            store.commit(run(job))
        records = list(store.records())
    write_files(tmp_path / "tables", partial(write_sheets, records))
    files = sorted((tmp_path / "tables").iterdir())
    assert [f.name for f in files] == ["records.csv", "records.parquet", "traces.parquet"]
    with files[0].open(newline="") as text:
        rows = list(csv.DictReader(text))
    assert [float(row["cost"]) for row in rows] == [r.cost for r in records]
    assert [tuple(json.loads(row["x"])) for row in rows] == [r.x for r in records]
    table = pl.read_parquet(files[1])
    assert table["search_rounds"].to_list() == [r.search_rounds for r in records]
    assert table.columns == list(rows[0])
    trace = pl.read_parquet(files[2])
    assert trace["cost"].to_list() == [c for r in records for c in r.steps.costs.tolist()]
    last = trace.group_by("problem", "algorithm", "repeat", maintain_order=True).last()
    assert last["cost"].to_list() == [r.cost for r in records]
    assert last["algorithm"].to_list() == [r.job.algorithm for r in records]


def test_an_empty_store_is_exported_too(tmp_path: Path) -> None:
    with opened(tmp_path / "store.sqlite") as store:
        write_sheets(store.records(), tmp_path)
    files = [tmp_path / name for name in ("records.csv", "records.parquet", "traces.parquet")]
    assert [pl.read_parquet(f).height for f in files[1:]] == [0, 0]


def test_the_folders_on_the_way_to_a_store_are_made(tmp_path: Path) -> None:
    file = tmp_path / "studies" / "august" / "store.sqlite"
    with opened(file) as store:
        assert store.left() == 0
    assert file.exists()
