"""A run is a pure function of its job: here is the function."""

from __future__ import annotations

import time

from ..optimize import METHODS, Search, Stop, Target, configure, lockstep
from ..optimize.methods import unit_free
from .problems import Problem, problem
from .record import Job, Record


def run(job: Job, on: Problem | None = None) -> Record:
    """Run a job: the same record, whenever, wherever and beside whatever it is run.

    Args:
        job: What to run.
        on: The job's problem, where somebody watches it; made from the job if None.

    Raises:
        InputError: the problem or the method cannot be made.
    """
    if on is None:
        on = problem(job.surface)
    name, settings = job.method["name"], job.method.get("settings", {})
    if name not in METHODS:
        from .peers import search  # noqa: PLC0415 - the peers' libraries are an extra

        began = time.perf_counter()
        trace, ended = search(
            name, on, budget=job.budget, target=job.target, seed=job.seeds(), **settings
        )
        x = on.space.decode(trace.u[trace.best : trace.best + 1])[0]
        return Record.of(job, trace, x, ended, time.perf_counter() - began)
    if job.method.get("unit_free"):
        settings = unit_free(name, settings)
    stops: list[Stop] = [] if job.target is None else [Target(job.target)]
    one = Search(
        on.space,
        configure(name, **settings),
        budget=job.budget,
        seed=job.seeds(),
        stops=stops,
    )
    (done,) = lockstep(on, [one])
    return Record.of(job, done.trace, done.x, done.ended, done.seconds)
