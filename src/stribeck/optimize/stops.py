"""Reasons to end a search before its budget is spent; the word they give is kept."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..errors import InputError
from .trace import Trace


@dataclass(frozen=True)
class Target:
    """The cost is low enough: at or below `cost`."""

    cost: float

    def __post_init__(self) -> None:
        if math.isnan(self.cost):
            raise InputError("a target must be a number, got nan")

    def __call__(self, trace: Trace) -> str | None:
        """The word, or None to go on."""
        return "target" if trace.cost <= self.cost else None


@dataclass(frozen=True)
class Stall:
    """This many evaluations in a row brought nothing better."""

    evaluations: int

    def __post_init__(self) -> None:
        if not self.evaluations >= 1:
            raise InputError(f"a stall lasts at least 1 evaluation, got {self.evaluations}")

    def __call__(self, trace: Trace) -> str | None:
        """The word, or None to go on."""
        return "stall" if len(trace) - 1 - trace.best >= self.evaluations else None


@dataclass(frozen=True)
class Deadline:
    """This much wall-clock time has passed since the search began (or was resumed)."""

    seconds: float

    def __post_init__(self) -> None:
        if not self.seconds > 0:
            raise InputError(f"a deadline must be above 0 s, got {self.seconds}")

    def __call__(self, trace: Trace) -> str | None:
        """The word, or None to go on."""
        return "deadline" if trace.seconds >= self.seconds else None
