"""The processes that do the studio's jobs, as many at once as there are cores."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Self

from ..errors import InputError
from .home import Home

#: Seconds between two looks at what waits.
PACE = 0.2


class Workers:
    """Starts a worker for each job that waits, in a thread of its own, while entered.

    Workers that run when it ends go on: their results are in the home when a studio opens it next.

    Args:
        folder: The home.
        count: Workers at once; as many as cores by default.
    """

    def __init__(self, folder: Path, count: int | None = None) -> None:
        self._folder = folder
        self._count = count or os.cpu_count() or 1
        self._started: dict[int, subprocess.Popen[bytes]] = {}
        self._wake, self._over = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *raised: object) -> None:
        self._over.set()
        self._wake.set()
        self._thread.join()

    def wake(self) -> None:
        """Look at once whether a job waits."""
        self._wake.set()

    def _run(self) -> None:
        with Home(self._folder) as home:
            while not self._over.is_set():
                self._wake.wait(PACE)
                self._wake.clear()
                # A disk that is full for a while is no reason to do no more jobs after it.
                try:
                    self._start(home)
                except InputError:
                    continue

    def _start(self, home: Home) -> None:
        self._started = {n: p for n, p in self._started.items() if p.poll() is None}
        jobs = home.unfinished()
        busy = sum(job.state == "running" for job in jobs)
        # Those that were started and have not yet claimed theirs.
        waiting = [job for job in jobs if job.state == "waiting" and job.id not in self._started]
        busy += sum(job.state == "waiting" and job.id in self._started for job in jobs)
        for job in waiting[: max(self._count - busy, 0)]:
            command = [sys.executable, "-m", "stribeck.studio.job_worker"]
            results = home.folder / "results"
            with (results / f"{job.id}.log").open("ab") as log:
                self._started[job.id] = subprocess.Popen(  # noqa: S603 - our own interpreter
                    [*command, str(self._folder), str(job.id)],
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=log,
                    start_new_session=True,
                )
