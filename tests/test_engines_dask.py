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
from stribeck.bench.worker import errand, software
from test_engines import JOBS, job, told

pytest.importorskip("distributed", reason="the extra `cluster` is not installed")
#: The scheduler gives a job up when it has lost one worker, not four: less to start again.
SETTINGS = {
    "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0",
    "SOFTWARE_OF_THE_TEST": "stribeck 2",
}
HARMFUL = Path(__file__).with_name("mortal_worker.py")


class Cluster:
    """A scheduler, and the workers that it was given."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.running = folder, list[subprocess.Popen[str]]()
        self.address = self._start("scheduler", r"Scheduler at: +tcp://(\S+)", "--port", "0")
        self.name = f"dask://{self.address}"

    def worker(self) -> None:
        """One more, of one thread."""
        options = ("--nthreads", "1", "--preload", str(HARMFUL))
        self._start("worker", r"Registered to: +(\S+)", f"tcp://{self.address}", *options)

    def _start(self, kind: str, said: str, *options: str) -> str:
        """Start a program and read on until it says that it is there."""
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
        heard = next((m[1] for line in lines if (m := re.search(said, line))), None)
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
    made = Cluster(tmp_path_factory.mktemp("cluster"))
    try:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(engines, "REACH", PATIENCE)
            patch.setattr(engines, "STAFF", 0.1)
            with pytest.raises(InputError, match=r": the scheduler has no workers .* start some"):
                engine(made.name)
            patch.setattr(engines, "STAFF", PATIENCE)  # one that was killed is started anew
            made.worker()
            yield made
    finally:
        made.close()


@pytest.fixture(scope="module")
def here() -> dict[str, str]:
    return told(Here().run(iter(JOBS)))


def test_one_worker_gives_the_same_records(cluster: Cluster, here: dict[str, str]) -> None:
    made = engine(cluster.name)
    assert made == Dask(cluster.address, 1)
    assert told(made.run(iter(JOBS))) == here


def test_a_worker_that_joins_is_used(cluster: Cluster, here: dict[str, str]) -> None:
    made = engine(cluster.name)
    pulled, delivered, held = 0, 0, 0

    def jobs() -> Iterator[Job]:
        nonlocal pulled, held
        while held <= engines.AT_HAND * made.workers and pulled < 10_000:
            pulled += 1
            held = pulled - delivered
            yield job("ats", pulled, budget=40)

    for done in made.run(jobs()):
        assert isinstance(done, Record)
        if not delivered:
            assert held == engines.AT_HAND * made.workers
            cluster.worker()
        delivered += 1
    assert delivered == pulled < 10_000
    more = engine(cluster.name)
    assert more.workers == made.workers + 1
    assert told(more.run(iter(JOBS))) == here


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_a_worker_that_is_lost_costs_its_job_at_most(
    cluster: Cluster, here: dict[str, str]
) -> None:
    killer, mortal = job("ats", label="killer"), job("ats", label="mortal")
    found = told(engine(cluster.name).run(iter([killer, mortal, *JOBS])))
    assert (cluster.folder / "mortal").exists()
    assert found.pop(killer.key) == "every worker that ran it died"
    assert found.pop(mortal.key) == run(mortal).content
    assert found == here


def test_who_stops_listening_leaves_nothing_behind(cluster: Cluster) -> None:
    outcomes = engine(cluster.name).run(job("ats", n, budget=40) for n in range(100))
    assert isinstance(next(outcomes), Record)
    outcomes.close()
    last = job("ats", 100, budget=40)
    assert told(engine(cluster.name).run(iter([last]))) == {last.key: run(last).content}


def test_other_software_is_refused(cluster: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    ours = partial(os.getenv, "SOFTWARE_OF_THE_TEST", "stribeck 1")
    monkeypatch.setattr(engines, "software", ours)
    with pytest.raises(InputError, match=r"a worker runs stribeck 2: here it is stribeck 1$"):
        engine(cluster.name)
    with pytest.raises(InputError, match=rf"a worker runs {software()}: the campaign runs other$"):
        errand(JOBS[0].text, "other")


def test_a_worker_that_cannot_run_our_function_is_said(
    cluster: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engines, "errand", partial(int, base=7))
    outcomes = Dask(cluster.address, 1).run(iter(JOBS))
    with pytest.raises(InputError, match=r"is the same stribeck installed there.*Error: ") as said:
        next(outcomes)
    assert "\n" not in str(said.value)


def test_where_nobody_answers(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(engines, "REACH", 0.5)
    with socket() as taken:
        taken.bind(("127.0.0.1", 0))  # and does not listen
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=r"^dask://127.*: no scheduler answers within 0.5 s"):
            engine(f"dask://127.0.0.1:{port}")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("words", [b"", b"SSH-2.0-x\r\n", b"\1" + bytes(7) + b"\2" + bytes(7)])
def test_where_something_else_listens(monkeypatch: pytest.MonkeyPatch, words: bytes) -> None:
    monkeypatch.setattr(engines, "REACH", 0.5)

    def speak() -> None:
        held.append(other.accept()[0])
        held[0].sendall(words)

    held = list[socket]()
    with socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        Thread(target=speak, daemon=True).start()
        with pytest.raises(InputError, match=r"^dask://127.*: no scheduler answers within 0.5 s"):
            engine(f"dask://127.0.0.1:{other.getsockname()[1]}")
    held[0].close()


def test_without_dask(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'stribeck\[cluster\]'$"):
        engine("dask://127.0.0.1:8786")
