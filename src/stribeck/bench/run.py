"""One run of a search, as a pure function of its job."""

from __future__ import annotations

import time

from ..optimize import METHODS, Run, Search, Stop, Target, configure, lockstep
from .problems import BenchProblem, problem
from .record import Job, Record
from .third_party import search


def run(job: Job, instance: BenchProblem | None = None) -> Record:
    """Run a job: the same record, whenever, wherever and beside whatever it is run.

    Args:
        job: What to run.
        instance: The job's problem, where somebody watches it; made from the job if None.

    Raises:
        InputError: the problem or the method cannot be made.
    """
    done = trial(job, problem(job.surface) if instance is None else instance)
    return Record.of(job, done.trace, done.x, done.ended, done.seconds)


def record_text(text: str) -> str:
    """The text of a job's record, from the job's."""
    return run(Job.parse(text)).text


def trial(job: Job, instance: BenchProblem) -> Run:
    """The run of a job with its whole trace, every point and cost.

    Raises:
        InputError: the method cannot be made.
    """
    name, settings = job.method["name"], job.method["settings"]
    if name in METHODS:
        algorithm = configure(name, **settings)
        stops: list[Stop] = [] if job.target is None else [Target(job.target)]
        driver = Search(instance.space, algorithm, budget=job.budget, seed=job.seeds(), stops=stops)
        return lockstep(instance, [driver])[0]
    start = time.perf_counter()
    trace, ended = search(
        name, instance, budget=job.budget, target=job.target, seed=job.seeds(), **settings
    )
    x = instance.space.decode(trace.u[trace.best : trace.best + 1])[0]
    seconds = time.perf_counter() - start
    return Run(x, trace.cost, len(trace), ended, seconds, trace)
