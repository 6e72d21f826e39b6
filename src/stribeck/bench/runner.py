"""A store's jobs run to their end: the open ones go to an engine, every outcome into the store."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .engines import Engine
    from .job_store import JobStore

#: Seconds between two looks at jobs that another process is busy with.
PACE = 0.5


def conduct(store: JobStore[Any, Any], engine: Engine) -> Generator[Any, None, None]:
    """Run the jobs that are left, wherever they were left.

    An outcome is in the store before it is yielded, and before a job is claimed in its place.

    Args:
        store: Holds the jobs.
        engine: Where they are run.

    Yields:
        Each outcome, a record or a failure; and, once nothing else is left, how many jobs other
        processes on the same store are still busy with.
    """
    while True:
        for outcome in engine.run(_claims(store)):
            store.keep(outcome)
            yield outcome
        if not (busy := store.busy()):
            return
        yield busy
        time.sleep(PACE)  # another process is at work: its jobs come back to us if it dies


def _claims(store: JobStore[Any, Any]) -> Iterator[Any]:
    while (job := store.claim()) is not None:
        yield job
