"""Where the time of a command went, from its process's own start."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self


@dataclass
class Stopwatch:
    """Seconds by what they were spent on, in the order in which they passed.

    Args:
        began: When it was started, on its clock.
        now: The clock, s.
    """

    began: float
    now: Callable[[], float] = time.perf_counter
    laps: dict[str, float] = field(default_factory=dict, init=False)

    @classmethod
    def of_process(cls) -> Self:
        """Started when the process was, Python's own start included."""
        return cls(time.perf_counter() - process_age())

    @property
    def total(self) -> float:
        """Seconds until the last lap."""
        return sum(self.laps.values())

    def lap(self, name: str, seconds: float | None = None) -> None:
        """Name the time since the last lap, or `seconds` of it: the rest is the next lap's."""
        since = self.now() - self.began - self.total
        spent = since if seconds is None else min(seconds, since)
        self.laps[name] = self.laps.get(name, 0.0) + spent

    def line(self) -> str:
        """All of it in a line."""
        parts = ", ".join(f"{name} {seconds:.2f}" for name, seconds in self.laps.items())
        return f"{self.total:.2f} s: {parts}"


def process_age() -> float:
    """Seconds since this process was started; what it computed where the system does not say."""
    try:
        stat = Path("/proc/self/stat").read_text(encoding="ascii", errors="replace")
        born = float(stat.rpartition(")")[2].split()[19]) / os.sysconf("SC_CLK_TCK")
        return max(time.clock_gettime(time.CLOCK_BOOTTIME) - born, 0.0)
    except (OSError, ValueError, IndexError, AttributeError):  # not Linux
        return time.process_time()
