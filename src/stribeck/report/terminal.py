"""The terminal: standard output, tables, paragraphs and warnings on it."""

from __future__ import annotations

import io
import os
import re
import sys
import textwrap
from collections.abc import Sequence
from typing import IO, TYPE_CHECKING, cast

from rich.console import Console
from rich.text import Text

if TYPE_CHECKING:
    from .stopwatch import Stopwatch
    from .table import Table

#: Columns of a line that nobody wraps.
UNCUT = 1000


class _Output(Console):
    """A console that leaves a broken pipe to the command line."""

    def on_broken_pipe(self) -> None:
        raise BrokenPipeError


def show_table(table: Table) -> None:
    """Print a table, its title in a line of its own."""
    out = console()
    if table.title:
        out.print(table.title, style="bold")
    out.print(table.terminal())


class _Unpadded(io.TextIOBase):
    """Standard output without the blanks that fill a table's last column."""

    def write(self, text: str) -> int:
        sys.stdout.write(re.sub(r"[ \t]+(?=\n|$)", "", text))
        return len(text)

    def flush(self) -> None:
        sys.stdout.flush()


def console() -> Console:
    """Standard output; where it is no terminal, lines are as long as they need to be."""
    if sys.stdout.isatty():
        return _Output(highlight=False, markup=False, emoji=False)
    width = None if "COLUMNS" in os.environ else UNCUT
    return _Output(
        file=cast("IO[str]", _Unpadded()), highlight=False, markup=False, emoji=False, width=width
    )


def show_warnings(warnings: Sequence[str], notes: Sequence[str]) -> None:
    """Print warnings and notes, a paragraph each; what is said of several logs is said once."""
    for warning in gathered(warnings):
        show_paragraph(warning, "warning: ")
    for note in gathered(notes):
        show_paragraph(note, "note: ", "dim")


def show_paragraph(text: str, head: str, style: str = "yellow") -> None:
    """Print a paragraph that hangs beside its head."""
    out = console()
    lines = textwrap.wrap(text, max(40, out.width - len(head)), break_on_hyphens=False)
    for k, line in enumerate(lines or [""]):
        out.print(Text.assemble((head, style) if k == 0 else " " * len(head), line))


def gathered(sentences: Sequence[str]) -> list[str]:
    """Sentences of which those that differ in the log and in numbers only are told by the first."""
    alike: dict[str, list[str]] = {}
    for sentence in sentences:
        log, colon, rest = sentence.partition(": ")
        names_log = colon and not re.search(r"\s", log) and "." in log  # the name of a file
        key = re.sub(r"\d+(\.\d+)?", "#", rest) if names_log else sentence
        alike.setdefault(key, []).append(sentence)
    return [_first_of(some) for some in alike.values()]


def _first_of(sentences: Sequence[str]) -> str:
    """The first of sentences that differ in the log or in numbers only, and how many follow."""
    first, *more = sentences
    if not more:
        return first
    if len({sentence.partition(": ")[0] for sentence in sentences}) == 1:  # of one log
        return f"{first} (and {len(more)} more like it)"
    return f"{first} (and much the same of {len(more)} more log{'s' * (len(more) > 1)})"


def show_time(clock: Stopwatch) -> None:
    """Print where the time of a command went, in a quiet line."""
    console().print(Text(clock.line(), style="dim"))
