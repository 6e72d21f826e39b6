"""The work of a fit in parts, and what is left of it after Ctrl-C."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

Result = TypeVar("Result")


@dataclass
class Work:
    """Whether Ctrl-C has cut the parts of a fit's work short, and the rows that they evaluated.

    Args:
        interrupted: Whether it has.
        rows: Rows of the residuals.
    """

    interrupted: bool = False
    rows: int = 0

    def result(self, part: Callable[[], tuple[Result, int]], without: Result) -> Result:
        """The result of a part of the work; what stands in for it if Ctrl-C came before or comes.

        Args:
            part: Its result and the rows that it evaluated.
            without: What a fit has without it.
        """
        if self.interrupted:
            return without
        try:
            result, rows = part()
        except KeyboardInterrupt:
            self.interrupted = True
            return without
        self.rows += rows
        return result
