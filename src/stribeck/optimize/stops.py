"""Criteria that end a search before its budget is spent, with their reasons."""

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
