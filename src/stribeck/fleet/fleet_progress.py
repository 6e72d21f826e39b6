"""How far a fleet is while it is identified, on standard error: a bar, or lines."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import IO, TYPE_CHECKING, Self

from ..report import duration
from .axis_job import AxisRecord

if TYPE_CHECKING:
    from rich.progress import Progress as RichProgress
    from rich.progress import TaskID

#: Seconds between two lines where there is no terminal; a share of the time gone by if that is
#: more.
PACE, SHARE = 5.0, 1 / 60


@dataclass
class FleetProgress:
    """Counts outcomes and says how much time is left: that of the axes done, for those to come.

    Args:
        file: Where to write.
        clock: Seconds, from anywhere.
    """

    file: IO[str] = field(default_factory=lambda: sys.stderr)
    clock: Callable[[], float] = time.monotonic
    counts: Counter[str] = field(default_factory=Counter)
    _bar: tuple[RichProgress, TaskID] | None = None

    def __post_init__(self) -> None:
        self._began = self._told = self.clock()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar[0].stop()

    def __call__(self, outcome: AxisRecord | int, left: int) -> None:
        """An axis has come to its end, or so many are with other processes; so many are left."""
        if isinstance(outcome, AxisRecord):
            self.counts[outcome.status] += 1
        if self.file.isatty():
            self._draw(outcome, left)
            return
        now = self.clock()
        if left == 0 or now - self._told >= max(PACE, SHARE * (now - self._began)):
            self._told = now
            self.file.write(f"{self.line(outcome, left)}\n")
            self.file.flush()

    def line(self, outcome: AxisRecord | int, left: int) -> str:
        """All of it in a line."""
        done = self.counts.total()
        phrases = [f"{done:,}/{done + left:,} axes"]
        phrases += [f"{self.counts[s]:,} {s}" for s in ("refused", "failed") if self.counts[s]]
        if not isinstance(outcome, AxisRecord):
            phrases.append(f"waiting for {outcome:,} of other processes")
        elif left and done:
            phrases.append(f"{duration((self.clock() - self._began) / done * left)} left")
        return ", ".join(phrases)

    def _draw(self, outcome: AxisRecord | int, left: int) -> None:
        from rich.console import Console  # noqa: PLC0415 - where there is a terminal alone
        from rich.progress import BarColumn, Progress, TextColumn  # noqa: PLC0415

        if self._bar is None:
            console = Console(file=self.file)
            bar = Progress(BarColumn(), TextColumn("{task.description}"), console=console)
            bar.start()
            self._bar = bar, bar.add_task("")
        bar, task = self._bar
        done = self.counts.total()
        bar.update(task, completed=done, total=done + left, description=self.line(outcome, left))
