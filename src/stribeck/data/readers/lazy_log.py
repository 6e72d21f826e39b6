"""A log whose samples its format reads when they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

from .log_file import Channel
from .raw_table import RawTable


@dataclass(frozen=True, eq=False)
class LazyLog:
    """An open file.

    Args:
        channels: What is in it.
        load: Samples of channels, a table a clock.
        problems: What was left out, or looks wrong, a sentence each.
        text: Column of text -> the place and the content of its first cell that is no number.
        lacking: What has to be said before times are in s, and how.
    """

    channels: tuple[Channel, ...]
    load: Callable[[Collection[str]], tuple[RawTable, ...]]
    problems: tuple[str, ...] = ()
    text: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    lacking: str = ""

    def tables(self, names: Collection[str] | None = None) -> tuple[RawTable, ...]:
        """Samples of these channels, of all if no names are given."""
        wanted = [c.name for c in self.channels if names is None or c.name in names]
        return self.load(wanted)
