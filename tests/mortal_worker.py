"""A worker with jobs that kill or disturb it: run as a program, or loaded into a Dask worker.

The label of a job's algorithm decides what the job does to its worker:
    killer   kills it in the middle of the search, every time
    mortal   the same, the first time
    babbler  answers with a line that is no outcome, the first time
    printer  prints while it runs, from Python and to the file descriptor
    caller   writes the worker's process id to the pipe $CALLER, which it keeps open

A file named like the label, in the folder $HARM, marks that the first time has passed.
"""

import os
import signal
from pathlib import Path
from typing import Any

from stribeck.bench import run, worker
from stribeck.bench.problems import BenchProblem, problem
from stribeck.bench.record import Job, Record
from stribeck.space import Array

if worker.answer.__module__ == worker.__name__:  # Dask loads a file, and reloads it
    run_job, answer = run.run, worker.answer


class Deadly:
    """A problem that kills the process at its fifth evaluation."""

    def __init__(self, instance: BenchProblem) -> None:
        self.instance, self.calls = instance, 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self.instance, name)

    def __call__(self, x: Array, /) -> Array:
        self.calls += 1
        if self.calls == 5:
            os.kill(os.getpid(), signal.SIGKILL)
        return self.instance(x)


def first_time(label: str) -> bool:
    mark = Path(os.environ["HARM"]) / label
    harmed_before = mark.exists()
    mark.touch()
    return not harmed_before


def harmful(job: Job, instance: BenchProblem | None = None) -> Record:
    label = job.algorithm
    kill = label == "killer" or (label == "mortal" and first_time(label))
    if label == "printer":
        print('{"failure": "printed"}', flush=True)  # noqa: T201 - that is the point
        os.write(1, b"\xff printed from below\n")
    if label == "caller":
        os.write(os.open(os.environ["CALLER"], os.O_WRONLY), f"{os.getpid()}\n".encode())
    return run_job(job, Deadly(problem(job.surface)) if kill else instance)


def babbling(text: str) -> str:
    label = Job.parse(text).algorithm
    return "no outcome" if label == "babbler" and first_time(label) else answer(text)


run.run, worker.answer = harmful, babbling

if __name__ == "__main__":
    worker.main()
