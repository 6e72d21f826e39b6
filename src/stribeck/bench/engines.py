"""Engines that run jobs: this process, worker processes of this machine, a Dask cluster.

Every engine gives the same records, bit for bit, in the order in which they are done. It takes a
job when there is room for it, and only after the outcome before it was taken: what it holds is
what its workers run, or (Dask) have at hand for next.
"""

from __future__ import annotations

import asyncio
import logging
import os
import re
import signal
import subprocess
import sys
import time
import warnings
from collections import Counter, deque
from collections.abc import Generator, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from itertools import chain
from queue import Empty, SimpleQueue
from threading import Lock, Thread
from typing import Any, Protocol, TypeVar

from ..errors import InputError
from .work_item import WorkItem
from .worker import answer, one_line, outcome, run_remote, software

Outcome = TypeVar("Outcome")

#: Worker processes that a job may cost before it is given up.
LIVES = 3
#: Seconds between two looks at what does not announce itself: Ctrl-C on Windows, a new worker.
LOOK = 1.0
#: Seconds in which a Dask scheduler must answer, and for which it may be without a worker.
REACH, STAFF = 5.0, 30.0
#: Jobs that a Dask worker holds: one it runs, one at hand for when that is done.
AT_HAND = 2
#: Workers that a job has to kill while nothing else runs before it is given up.
ALONE = 2
#: A worker fills one core: what would start threads of its own is told not to.
ONE_THREAD = {
    f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "NUMBA", "VECLIB_MAXIMUM")
}


class Engine(Protocol):
    """Runs jobs."""

    @property
    def workers(self) -> int:
        """How many jobs run at once."""

    def run(self, jobs: Iterator[WorkItem[Outcome]]) -> Generator[Outcome, None, None]:
        """Run jobs and yield what becomes of each.

        Args:
            jobs: Taken one at a time, as there is room.

        Raises:
            InputError: no worker can be had, or none is left.
        """


def engine(text: str) -> Engine:
    """The engine of a name: "here", "processes", "processes:3", "dask://host:port".

    Raises:
        InputError: there is no such engine, or it cannot be reached.
    """
    if text == "here":
        return Here()
    if text == "processes":
        return Processes(cores())
    if match := re.fullmatch(r"processes:([1-9][0-9]{0,3})", text):
        return Processes(int(match[1]))
    if match := re.fullmatch(r"dask://(\S+:[0-9]{1,5})", text):
        return Dask.at(match[1])
    raise InputError(
        f"no engine {text!r}: there are here, processes, processes:N for N of them, "
        "and dask://host:port"
    )


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class Here:
    """This process, one job after the other."""

    workers: int = 1

    def run(self, jobs: Iterator[WorkItem[Outcome]]) -> Generator[Outcome, None, None]:
        """See `Engine`."""
        for job in jobs:
            yield outcome(job, answer(job.text))


@dataclass(frozen=True)
class Processes:
    """Worker processes on this machine, of one thread each.

    Args:
        workers: How many.
        command: The program that each of them is.
    """

    workers: int
    command: tuple[str, ...] = (sys.executable, "-P", "-m", "stribeck.bench.worker")

    def run(self, jobs: Iterator[WorkItem[Outcome]]) -> Generator[Outcome, None, None]:
        """See `Engine`. A job whose worker dies is run again on a new one, `LIVES` times in all."""
        workers = [_Worker(self.command) for _ in range(self.workers)]
        threads = ThreadPoolExecutor(self.workers, "stribeck-worker")
        running: dict[Future[Outcome], _Worker] = {}

        def give(worker: _Worker) -> None:
            if (job := next(jobs, None)) is not None:
                running[threads.submit(worker.do, job)] = worker

        try:
            for worker in workers:
                give(worker)
            while running:
                for done in wait(running, LOOK, FIRST_COMPLETED).done:
                    worker = running.pop(done)
                    yield done.result()
                    give(worker)
        finally:
            for worker in workers:
                worker.stop()
            threads.shutdown()
            for worker in workers:
                worker.discard()


class _DiedError(Exception):
    """A worker process is no more; the message says how it ended."""


@dataclass(eq=False)
class _Worker:
    """A worker: one process after the other. It does jobs in a thread, and is stopped from ours."""

    command: tuple[str, ...]
    _process: _Process | None = None
    _stopped: bool = False
    _lock: Lock = field(default_factory=Lock)

    def do(self, job: WorkItem[Outcome]) -> Outcome:
        """Run a job on as many processes as it takes and is allowed.

        Raises:
            InputError: no process can be started.
        """
        end, greeted = "", False
        for _ in range(LIVES):
            try:
                process = self._ready()
                greeted = True
                return outcome(job, process.ask(job.text))
            except (_DiedError, ValueError) as error:
                end = str(error)
                self.discard()
        if not greeted:
            raise InputError(f"no worker process can be started: {end}")
        return job.failed(one_line(f"the worker died, {LIVES} times: {end}"))

    def _ready(self) -> _Process:
        """The process, a new one if need be, ready for a job."""
        with self._lock:
            if self._stopped:
                raise _DiedError("it was stopped")
            if self._process is None:
                self._process = _Process(self.command)
        self._process.greet()
        return self._process

    def stop(self) -> None:
        """End it at once, also in the middle of a job."""
        with self._lock:
            self._stopped = True
            if self._process is not None:
                self._process.popen.kill()

    def discard(self) -> None:
        """Kill the process and close its pipes."""
        with self._lock:
            if self._process is not None:
                self._process.end(0.0)
                self._process = None


class _Process:
    """A running worker program, and the pipes to it."""

    def __init__(self, command: tuple[str, ...]) -> None:
        try:
            self.popen = subprocess.Popen(  # noqa: S603 - our own program
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env=os.environ | ONE_THREAD,
                encoding="utf-8",
                errors="replace",
                bufsize=1,
            )
        except OSError as error:
            raise _DiedError(str(error)) from error
        self._greeted = False
        self._last_words = deque[str](maxlen=1)
        lines = filter(str.strip, self.popen.stderr or ())
        # Read at all times: a full pipe would stop the program.
        self._stderr_reader = Thread(target=self._last_words.extend, args=(lines,), daemon=True)
        self._stderr_reader.start()

    def greet(self) -> None:
        """Hear its first line, once."""
        if not self._greeted and (greeting := self._hear()) != software():
            raise ValueError(
                f"it is not this version: {greeting[:200]!r} in place of {software()!r}"
            )
        self._greeted = True

    def ask(self, text: str) -> str:
        """A line for a line.

        Raises:
            _DiedError: it ended before it answered.
        """
        try:
            self.popen.stdin.write(f"{text}\n")  # type: ignore[union-attr]
        except OSError as error:
            raise _DiedError(self.end(1.0)) from error
        return self._hear()

    def _hear(self) -> str:
        line: str = self.popen.stdout.readline()  # type: ignore[union-attr]
        if not line.endswith("\n"):
            raise _DiedError(self.end(1.0))
        return line.rstrip("\n")

    def end(self, patience: float) -> str:
        """Kill it if it has not ended by then, and say how it ended and what it said last."""
        try:
            status = self.popen.wait(patience)
        except subprocess.TimeoutExpired:
            self.popen.kill()
            status = self.popen.wait()
        self._stderr_reader.join(1.0)  # a program that it started may hold the pipe for longer
        for pipe in (self.popen.stdin, self.popen.stdout, self.popen.stderr):
            _close(pipe)
        words = "".join(self._last_words).strip()
        return _how(status) + (f", and said last: {words}" if words else "")


def _close(pipe: Any) -> None:
    try:
        pipe.close()
    except OSError:  # what was still to be written finds nobody to read it
        return


def _how(status: int) -> str:
    """How a process ended, from its status."""
    try:
        return f"killed by {signal.Signals(-status).name}"
    except ValueError:
        return f"exit status {status}"


@dataclass(frozen=True)
class Dask:
    """The workers of a Dask scheduler, those that join later among them.

    A job whose worker is lost is run again on another: the scheduler sees to it.

    Args:
        address: Of the scheduler, "host:port".
        workers: How many there were when it was asked.
    """

    address: str
    workers: int

    @classmethod
    def at(cls, address: str) -> Dask:
        """The cluster at an address, as it is now.

        Raises:
            InputError: `distributed` is not installed, no scheduler answers, it has no workers,
                or they run other software than we do.
        """
        with _client(address) as client:
            return cls(address, len(client.nthreads()))

    def run(self, jobs: Iterator[WorkItem[Outcome]]) -> Generator[Outcome, None, None]:
        """See `Engine`."""
        for first in jobs:  # where there is nothing to do there is nothing to connect to
            with _client(self.address) as client:
                yield from _DaskRun(client, self.address, chain([first], jobs)).outcomes()


class _DaskRun:
    """The state of one run on a Dask cluster: jobs submitted, and deaths of workers by job."""

    def __init__(self, client: Any, address: str, jobs: Iterator[WorkItem[Any]]) -> None:
        self.client, self.address, self.jobs = client, address, jobs
        self.running: dict[str, tuple[WorkItem[Any], Any]] = {}
        self.suspects = deque[WorkItem[Any]]()
        self.deaths = Counter[str]()
        self.done = SimpleQueue[Any]()
        self.room, self.looked, self.staffed = 0, -LOOK, time.monotonic()

    def outcomes(self) -> Generator[Any, None, None]:
        """Run all jobs; those that may have killed workers last, and each alone, ALONE times.

        A dead worker counts against every job that it held: which of them killed it is unknown.
        """
        while True:
            self._look()
            while len(self.running) < self.room and (job := next(self.jobs, None)):
                self._submit(job)
            if alone := not self.running and bool(self.suspects):
                self._submit(self.suspects.popleft())
            if not self.running:
                return
            job, line = self._next()
            if line is not None:
                yield outcome(job, line)
                continue
            self.deaths[job.key] += alone  # else one beside it may have been the cause
            if self.deaths[job.key] == ALONE:
                yield job.failed("every worker that ran it died")
            else:
                self.suspects.append(job)

    def _submit(self, job: WorkItem[Any]) -> None:
        future = self.client.submit(run_remote, job.text, software(), pure=False)
        self.running[future.key] = job, future
        future.add_done_callback(self.done.put)

    def _next(self) -> tuple[WorkItem[Any], str | None]:
        """The next job that is done and its line, None if the scheduler gave it up."""
        distributed = _distributed(self.address)
        while True:
            try:
                future = self.done.get(timeout=LOOK)
                break
            except Empty:
                self._look()
        job, _ = self.running.pop(future.key)
        try:
            return job, future.result()
        except distributed.KilledWorker:
            return job, None
        except InputError:
            raise
        except (OSError, CancelledError) as error:
            raise InputError(f"dask://{self.address}: the scheduler is gone") from error
        except Exception as error:
            raise InputError(_cannot(self.address, error)) from error

    def _look(self) -> None:
        """See how many jobs the workers can hold, every now and then: they come and go."""
        if (now := time.monotonic()) - self.looked < LOOK:
            return
        self.looked = now
        try:
            workers = len(self.client.nthreads())
        except (OSError, CancelledError) as error:
            raise InputError(f"dask://{self.address}: the scheduler is gone") from error
        self.room = AT_HAND * workers
        if workers:
            self.staffed = now
        elif now - self.staffed > STAFF:
            raise InputError(_unstaffed(self.address))


def _distributed(address: str) -> Any:
    """Dask's own library, which is an extra."""
    try:
        return import_module("distributed")
    except ImportError as error:
        raise InputError(
            f"dask://{address}: Dask is not installed: pip install 'stribeck[cluster]'"
        ) from error


@contextmanager
def _client(address: str) -> Iterator[Any]:
    """A connection to a scheduler whose workers can run our jobs."""
    distributed = _distributed(address)
    with _quiet():
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of versions: those that matter are checked below
                asyncio.run(_greet(address))
                client = distributed.Client(address, timeout=REACH, set_as_default=False)
        except Exception as error:  # what is no scheduler may say anything
            raise InputError(
                f"dask://{address}: no scheduler answers within {REACH:g} s: "
                "is it running, and is the port open?"
            ) from error
        try:
            _check(client, address)
            yield client
        finally:
            client.close()


async def _greet(address: str) -> None:
    """Hear a scheduler's first words: `Client` waits for them for ever."""
    tied = import_module("distributed").Security().get_connection_args("client")
    connect = import_module("distributed.comm").connect
    (await asyncio.wait_for(connect(address, timeout=REACH, **tied), REACH)).abort()


def _check(client: Any, address: str) -> None:
    """See that there are workers, and that their numbers are ours."""
    try:
        client.wait_for_workers(1, timeout=STAFF)
    except TimeoutError as error:
        raise InputError(_unstaffed(address)) from error
    for versions in client.run(software, on_error="return").values():
        if isinstance(versions, BaseException):
            raise InputError(_cannot(address, versions))
        if versions != software():
            raise InputError(f"dask://{address}: a worker runs {versions}: here it is {software()}")


def _unstaffed(address: str) -> str:
    return (
        f"dask://{address}: the scheduler has no workers (waited {STAFF:g} s): "
        f"start some: dask worker tcp://{address} --nthreads 1"
    )


def _cannot(address: str, error: BaseException) -> str:
    return one_line(
        f"dask://{address}: a worker or the scheduler cannot import or run our jobs, "
        f"is the same stribeck installed there? "
        f"{type(error).__name__}: {error}"
    )


@contextmanager
def _quiet() -> Iterator[None]:
    """Dask's own handlers say nothing: what matters comes as an InputError."""
    handlers = [
        h for n in ("distributed", "tornado.application") for h in logging.getLogger(n).handlers
    ]
    levels = [h.level for h in handlers]
    for handler in handlers:
        handler.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for handler, level in zip(handlers, levels, strict=True):
            handler.setLevel(level)
