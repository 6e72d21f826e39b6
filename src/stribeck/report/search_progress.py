"""How far a search is while it runs, on standard error; and how Ctrl-C ends it."""

from __future__ import annotations

import math
import signal
import sys
import threading
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Self

from .format import number

if TYPE_CHECKING:
    from rich.progress import Progress
    from rich.status import Status

    from ..optimize import Search

#: Seconds between lines of progress where there is no terminal.
PACE = 2.0


class SearchProgress:
    """A progress bar on a terminal, plain lines elsewhere; both on standard error.

    While it is entered, Ctrl-C ends a search between two steps, where its record is whole; a
    second one, or one outside the search, interrupts at once. So does a SIGTERM that is handled.
    """

    def __init__(self, unit: str, *, quiet: bool = False) -> None:
        self._quiet = quiet
        self._unit, self._last_line = unit, time.monotonic()
        self._bar: Progress | None = None
        self._searching = False
        self._before: dict[int, Any] = {}
        self._signal: int | None = None

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for end in (signal.SIGINT, signal.SIGTERM):
                if callable(before := signal.getsignal(end)):
                    self._before[end] = before
                    signal.signal(end, self._interrupt)
        return self

    def __exit__(self, *_: object) -> None:
        for end, before in self._before.items():
            signal.signal(end, before)
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, searches: Sequence[Search]) -> None:
        """Say how far the searches are.

        Raises:
            KeyboardInterrupt: Ctrl-C was pressed during the step.
        """
        self._step(searches)
        if self._quiet:
            return
        done = sum(len(s.trace) for s in searches)
        total = sum(s.budget if s.ended is None else len(s.trace) for s in searches)
        best = f"{number(min(s.shown for s in searches), 4)} {self._unit}"
        if sys.stderr.isatty():
            self._draw(done, total, best)
        elif time.monotonic() - self._last_line >= PACE:
            self._last_line = time.monotonic()
            print(f"{done:,}/{total:,} evaluations, best J {best}", file=sys.stderr, flush=True)  # noqa: T201

    def _step(self, searches: Sequence[Search]) -> None:
        """Between two steps of searches: the place to end them.

        Raises:
            KeyboardInterrupt: Ctrl-C was pressed during the step.
        """
        self._searching = self._signal is None and any(s.ended is None for s in searches)
        if self._signal is not None:
            self._before[self._signal](self._signal, None)

    def _interrupt(self, end: int, frame: object) -> None:
        if not self._searching or self._signal is not None:
            self._before[end](end, frame)
        self._signal = end

    def _draw(self, done: int, total: int, best: str) -> None:
        if self._bar is None:
            from rich.console import Console  # noqa: PLC0415 - on a terminal alone
            from rich.progress import (  # noqa: PLC0415
                BarColumn,
                Progress,
                TextColumn,
                TimeElapsedColumn,
            )

            self._bar = Progress(
                TextColumn("{task.description}"), BarColumn(bar_width=24),
                TextColumn("{task.completed:,}/{task.total:,} evaluations"),
                TextColumn("best J {task.fields[best]}"), TimeElapsedColumn(),
                console=Console(stderr=True), transient=True,
            )  # fmt: skip
            self._bar.add_task("searching", total=total, best="")
            self._bar.start()
        (task,) = self._bar.task_ids
        stage = "searching" if self._searching else "polishing"
        self._bar.update(task, description=stage, completed=done, total=total, best=best)


class SelectionProgress(SearchProgress):
    """Progress of a comparison: what is being fitted, and how far its search is.

    It ends a search between two steps upon Ctrl-C, as `SearchProgress` does.
    """

    def __init__(self, unit: str) -> None:
        super().__init__(unit)
        self._task = ""
        self._status: Status | None = None
        self._last_line = -math.inf

    def __exit__(self, *error: object) -> None:
        super().__exit__(*error)
        if self._status is not None:
            self._status.stop()

    def step(self, task: str, searches: Sequence[Search]) -> None:
        """Say what is being done.

        Raises:
            KeyboardInterrupt: Ctrl-C was pressed during the step.
        """
        if searches:
            self._step(searches)
        else:
            self._searching = False
        best = min((s.shown for s in searches), default=math.inf)
        done = sum(len(s.trace) for s in searches)
        text = f"{task}: {done:,} evaluations, best {number(best, 4)}" if searches else task
        if sys.stderr.isatty():
            if self._status is None:
                from rich.console import Console  # noqa: PLC0415 - on a terminal alone
                from rich.status import Status  # noqa: PLC0415

                self._status = Status(text, console=Console(stderr=True))
                self._status.start()
            self._status.update(text)
        elif task != self._task or time.monotonic() - self._last_line >= PACE:
            self._last_line = time.monotonic()
            print(text, file=sys.stderr, flush=True)  # noqa: T201
        self._task = task
