"""The Dask engine on a real scheduler and real worker processes of this machine."""

import os
import re
import subprocess
import sys
from collections import deque
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from socket import socket
from threading import Thread

import pytest

from patience import PATIENCE
from stribeck import InputError
from stribeck.bench import engines
from stribeck.bench.engines import Dask, Here, engine
from stribeck.bench.record import Job, Record
from stribeck.bench.run import run
from stribeck.bench.worker import run_remote, software
from test_engines import JOBS, contents_of, job

pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
#: The scheduler gives a job up when it has lost one worker, not four: less to start again.
SETTINGS = {
    "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0",
    "SOFTWARE_OF_THE_TEST": "stribeck 2",
}
HARMFUL = Path(__file__).with_name("mortal_worker.py")


class Cluster:
    """A scheduler and its workers."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.running = folder, list[subprocess.Popen[str]]()
        self.address = self._start("scheduler", r"Scheduler at: +tcp://(\S+)", "--port", "0")
        self.name = f"dask://{self.address}"

    def worker(self) -> None:
        """Start one more worker, of one thread."""
        options = ("--nthreads", "1", "--preload", str(HARMFUL))
        self._start("worker", r"Registered to: +(\S+)", f"tcp://{self.address}", *options)

    def _start(self, kind: str, pattern: str, *options: str) -> str:
        """Start a program and read its output up to a pattern."""
        program = subprocess.Popen(
            [sys.executable, "-m", "dask", kind, *options, "--host", "127.0.0.1", "--no-dashboard"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            cwd=self.folder,
            env=os.environ | SETTINGS | {"HARM": str(self.folder)},
        )
        self.running.append(program)
        lines = program.stderr or ()
        heard = next((m[1] for line in lines if (m := re.search(pattern, line))), None)
        assert heard, f"the {kind} did not start"
        Thread(target=deque[str](maxlen=0).extend, args=(lines,), daemon=True).start()
        return heard

    def close(self) -> None:
        for program in reversed(self.running):
            program.terminate()
            program.wait(PATIENCE)
            assert program.stderr
            program.stderr.close()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    started = Cluster(tmp_path_factory.mktemp("cluster"))
    try:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(engines, "REACH", PATIENCE)
            patch.setattr(engines, "STAFF", 0.1)
            with pytest.raises(InputError, match=r": the scheduler has no workers .* start some"):
                engine(started.name)
            patch.setattr(engines, "STAFF", PATIENCE)  # one that was killed is started anew
            started.worker()
            yield started
    finally:
        started.close()


@pytest.fixture(scope="module")
def serial() -> dict[str, str]:
    return contents_of(Here().run(iter(JOBS)))


def test_one_worker_gives_the_same_records(cluster: Cluster, serial: dict[str, str]) -> None:
    pool = engine(cluster.name)
    assert pool == Dask(cluster.address, 1)
    assert contents_of(pool.run(iter(JOBS))) == serial


def test_a_worker_that_joins_is_used(cluster: Cluster, serial: dict[str, str]) -> None:
    pool = engine(cluster.name)
    pulled, delivered, in_flight = 0, 0, 0

    def jobs() -> Iterator[Job]:
        nonlocal pulled, in_flight
        while in_flight <= engines.AT_HAND * pool.workers and pulled < 10_000:
            pulled += 1
            in_flight = pulled - delivered
            yield job("ats", pulled, budget=40)

    for finished in pool.run(jobs()):
        assert isinstance(finished, Record)
        if not delivered:
            assert in_flight == engines.AT_HAND * pool.workers
            cluster.worker()
        delivered += 1
    assert delivered == pulled < 10_000
    enlarged = engine(cluster.name)
    assert enlarged.workers == pool.workers + 1
    assert contents_of(enlarged.run(iter(JOBS))) == serial


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_a_worker_that_is_lost_costs_its_job_at_most(
    cluster: Cluster, serial: dict[str, str]
) -> None:
    killer, mortal = job("ats", label="killer"), job("ats", label="mortal")
    contents = contents_of(engine(cluster.name).run(iter([killer, mortal, *JOBS])))
    assert (cluster.folder / "mortal").exists()
    assert contents.pop(killer.key) == "every worker that ran it died"
    assert contents.pop(mortal.key) == run(mortal).content
    assert contents == serial


def test_who_stops_listening_leaves_nothing_behind(cluster: Cluster) -> None:
    outcomes = engine(cluster.name).run(job("ats", n, budget=40) for n in range(100))
    assert isinstance(next(outcomes), Record)
    outcomes.close()
    last = job("ats", 100, budget=40)
    assert contents_of(engine(cluster.name).run(iter([last]))) == {last.key: run(last).content}


def test_other_software_is_refused(cluster: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    ours = partial(os.getenv, "SOFTWARE_OF_THE_TEST", "stribeck 1")
    monkeypatch.setattr(engines, "software", ours)
    with pytest.raises(InputError, match=r"a worker runs stribeck 2: here it is stribeck 1$"):
        engine(cluster.name)
    with pytest.raises(InputError, match=rf"a worker runs {software()}: the campaign runs other$"):
        run_remote(JOBS[0].text, "other")


def test_a_worker_that_cannot_run_our_function_is_said(
    cluster: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engines, "run_remote", partial(int, base=7))
    outcomes = Dask(cluster.address, 1).run(iter(JOBS))
    with pytest.raises(
        InputError, match=r"is the same stribeck installed there.*Error: "
    ) as refused:
        next(outcomes)
    assert "\n" not in str(refused.value)


def test_where_nobody_answers(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(engines, "REACH", 0.5)
    with socket() as silent:
        silent.bind(("127.0.0.1", 0))  # and does not listen
        port = silent.getsockname()[1]
        with pytest.raises(InputError, match=r"^dask://127.*: no scheduler answers within 0.5 s"):
            engine(f"dask://127.0.0.1:{port}")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("words", [b"", b"SSH-2.0-x\r\n", b"\1" + bytes(7) + b"\2" + bytes(7)])
def test_where_something_else_listens(monkeypatch: pytest.MonkeyPatch, words: bytes) -> None:
    monkeypatch.setattr(engines, "REACH", 0.5)

    def speak() -> None:
        connections.append(listener.accept()[0])
        connections[0].sendall(words)

    connections = list[socket]()
    with socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        Thread(target=speak, daemon=True).start()
        with pytest.raises(InputError, match=r"^dask://127.*: no scheduler answers within 0.5 s"):
            engine(f"dask://127.0.0.1:{listener.getsockname()[1]}")
    connections[0].close()


def test_without_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'stribeck\[cluster\]'$"):
        engine("dask://127.0.0.1:8786")
