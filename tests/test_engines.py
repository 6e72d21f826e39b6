"""Engines: the same records from each, also when workers are lost."""

import os
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from patience import PATIENCE
from stribeck import InputError
from stribeck.bench.engines import Engine, Here, Processes, cores, engine
from stribeck.bench.record import Failure, Job, Record
from stribeck.bench.run import run
from stribeck.bench.worker import answer, outcome, refusal

MORTAL = (sys.executable, "-P", str(Path(__file__).with_name("mortal_worker.py")))
posix = pytest.mark.skipif(os.name != "posix", reason="signals and named pipes of POSIX")


SLIDE_BED = {"surface": "slide-bed", "direction": "right", "twin": 0}
LONG_LIFE = {"name": "abfo", "settings": {"N_c": 10**7}}


def job(
    method: str, repeat: int = 0, *, label: str = "", budget: int = 1500, instance: Any = None
) -> Job:
    return Job(
        problem="one",
        algorithm=label or method,
        repeat=repeat,
        seed=2012,
        budget=budget,
        target=None,
        minimum=None,
        surface=instance or {"surface": "BF", "dim": 2, "twin": None},
        method={"name": method, "settings": {}},
    )


JOBS = [
    *(job(method, repeat) for repeat in range(2) for method in ("bts", "ats", "abfo")),
    job("abfo", label="on-slide-bed", budget=130, instance=SLIDE_BED),
    job("no-such-method"),
]


def contents_of(outcomes: Iterator[Record | Failure]) -> dict[str, str]:
    """The record or failure of each job, by key, without its seconds."""
    delivered = list(outcomes)
    by_key = {o.job.key: o.content if isinstance(o, Record) else o.message for o in delivered}
    assert len(by_key) == len(delivered), "an outcome was delivered twice"
    return by_key


@pytest.fixture(scope="module")
def serial() -> dict[str, str]:
    return contents_of(Here().run(iter(JOBS)))


def test_here_is_the_runner(serial: dict[str, str]) -> None:
    *sound, broken = JOBS
    assert [serial[j.key] for j in sound] == [run(j).content for j in sound]
    assert serial[broken.key].startswith("no method 'no-such-method'")


@pytest.mark.parametrize("workers", [1, 2])
def test_processes_give_the_same_records(serial: dict[str, str], workers: int) -> None:
    assert contents_of(engine(f"processes:{workers}").run(iter(JOBS))) == serial


@pytest.mark.parametrize("pool", [Here(), Processes(2)])
def test_a_job_is_taken_when_a_worker_is_free_and_no_sooner(pool: Engine) -> None:
    pulled, delivered, in_flight = 0, 0, []

    def jobs() -> Iterator[Job]:
        nonlocal pulled
        for repeat in range(7):
            pulled += 1
            in_flight.append(pulled - delivered)
            yield job("ats", repeat, budget=40)

    for _ in pool.run(jobs()):
        assert pulled - delivered <= pool.workers  # none was taken before this one was delivered
        delivered += 1
    assert delivered == 7
    assert max(in_flight) == pool.workers


def test_without_jobs_no_worker_is_started() -> None:
    assert list(Processes(2, ("no-such-program",)).run(iter(()))) == []


def test_an_exception_costs_its_job_only() -> None:
    broken = job("ats", instance={"surface": "BF"})
    (failed, finished) = Here().run(iter([broken, job("ats")]))
    assert isinstance(failed, Failure)
    assert failed.job is broken
    assert failed.message == "KeyError: 'dim'"
    assert isinstance(finished, Record)


def test_an_outcome_belongs_to_its_job() -> None:
    first, second = job("ats", 0, budget=40), job("ats", 1, budget=40)
    line = answer(first.text)
    delivered = outcome(first, line)
    assert isinstance(delivered, Record)
    assert delivered.text == line
    with pytest.raises(ValueError, match="another job"):
        outcome(second, line)
    for garbage in ("", "[]", "7", "null", "{}", '{"job": 1}', "\x00", line[:-1]):
        with pytest.raises(ValueError, match=r".+"):
            outcome(first, garbage)


def test_a_message_is_one_line() -> None:
    failure = outcome(JOBS[0], refusal("a\nb\r\n c" + "!" * 10_000))
    assert isinstance(failure, Failure)
    assert failure.message.startswith("a b c!!")
    assert len(failure.message) == 500


@posix
def test_a_worker_that_is_lost_costs_its_job_at_most(
    serial: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HARM", str(tmp_path))
    killer, mortal, babbler, printer = (
        job("ats", label=label) for label in ("killer", "mortal", "babbler", "printer")
    )
    harmful = [killer, mortal, babbler, printer]
    contents = contents_of(Processes(2, MORTAL).run(iter([*harmful, *JOBS])))
    assert contents.pop(killer.key) == "the worker died, 3 times: killed by SIGKILL"
    assert {p.name for p in tmp_path.iterdir()} == {"mortal", "babbler"}
    for survivor in harmful[1:]:
        assert contents.pop(survivor.key) == run(survivor).content
    assert contents == serial


def test_last_words_are_kept_however_much_was_said() -> None:
    chatty = (
        "import sys; sys.stderr.write('so it goes\\n' * 100_000 + 'the end\\n\\n'); sys.exit(3)"
    )
    with pytest.raises(InputError, match=r"exit status 3, and said last: the end$") as raised:
        list(Processes(1, (sys.executable, "-c", chatty)).run(iter(JOBS)))
    assert str(raised.value).startswith("no worker process can be started")


@pytest.mark.parametrize(
    "command", [("no-such-program",), (sys.executable, "-c", "print('hello')")]
)
def test_a_worker_that_cannot_start_is_said_at_once(command: tuple[str, ...]) -> None:
    with pytest.raises(InputError, match=r"no worker process can be started: .+"):
        list(Processes(2, command).run(iter(JOBS)))


class Callers:
    """Worker processes that write their ids to a pipe, and keep it open as long as they live."""

    def __init__(self, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        os.mkfifo(path)
        self.path, self.pids = path, set[int]()
        monkeypatch.setenv("CALLER", str(path))
        self._open = os.open(path, os.O_RDWR)  # blocks no writer, and is never at its end

    def wait(self, count: int) -> None:
        """Wait until `count` workers have written."""
        heard = b""
        while heard.count(b"\n") < count:
            assert select.select([self._open], [], [], PATIENCE)[0], f"no call: {heard!r}"
            heard += os.read(self._open, 100)
        self.pids |= {int(line) for line in heard.split()}
        ours, self._open = self._open, os.open(self.path, os.O_RDONLY | os.O_NONBLOCK)
        os.close(ours)

    def all_end(self) -> bool:
        """Whether all have ended in time: the pipe is at its end once no process has it open."""
        return bool(select.select([self._open], [], [], PATIENCE)[0]) and not os.read(self._open, 1)

    def close(self) -> None:
        os.close(self._open)
        for pid in self.pids:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                continue


@pytest.fixture
def callers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callers]:
    pipe = Callers(tmp_path / "callers", monkeypatch)
    yield pipe
    pipe.close()


ENDLESS = [
    replace(job("abfo", n, label="caller", budget=10**9), method=LONG_LIFE) for n in range(2)
]


@posix
def test_who_stops_listening_stops_the_workers(callers: Callers) -> None:
    outcomes = Processes(3, MORTAL).run(iter([job("ats", budget=40), *ENDLESS]))
    assert isinstance(next(outcomes), Record)
    callers.wait(2)
    outcomes.close()
    assert callers.all_end()
    for pid in callers.pids:
        with pytest.raises(ChildProcessError):  # not even a zombie
            os.waitpid(pid, os.WNOHANG)
    assert not [t for t in threading.enumerate() if t.name.startswith("stribeck-worker")]


@posix
@pytest.mark.parametrize("deadly", [signal.SIGKILL, signal.SIGINT])
def test_no_worker_outlives_its_driver(callers: Callers, deadly: signal.Signals) -> None:
    script = (
        "import sys\n"
        "from stribeck.bench.engines import Processes\n"
        "from stribeck.bench.record import Job\n"
        "jobs = [Job.parse(line) for line in sys.stdin]\n"
        f"list(Processes(2, {MORTAL!r}).run(iter(jobs)))\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as driver:
        assert driver.stdin
        driver.stdin.write("".join(f"{j.text}\n" for j in ENDLESS))
        driver.stdin.close()
        callers.wait(2)
        driver.send_signal(deadly)
        assert callers.all_end()
        assert driver.wait(PATIENCE) == -deadly


@pytest.mark.parametrize(
    ("text", "expected"),
    [("here", Here()), ("processes", Processes(cores())), ("processes:3", Processes(3))],
)
def test_names(text: str, expected: Engine) -> None:
    assert engine(text) == expected
    assert expected.workers in {1, 3, cores()}


@pytest.mark.parametrize(
    "text",
    ["", "there", "here:1", "processes:", "processes:0", "processes:-1", "processes:x",
     "processes:99999", "dask", "dask:", "dask://", "dask://host", "dask://host:port",
     "dask:// :80", "tcp://host:80"],
)  # fmt: skip
def test_other_names_are_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"^no engine .*: there are here, processes.*") as refused:
        engine(text)
    assert "\n" not in str(refused.value)
