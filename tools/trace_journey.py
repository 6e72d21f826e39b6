"""How far a reader travels who follows `identify LOG --out DIR` from the command to the card.

    python tools/trace_journey.py CHECKOUT_SRC LOG [OPTIONS OF identify ...]

Runs the command in this process with the package at CHECKOUT_SRC (such as `src`) and notes each
Python function of the package when it is entered for the first time, with its depth: how many
functions of the package are open around it, counted from the command `identify`, whose depth
is 0. Compiled code and other threads are not seen. The way to the card ends when `card.json` is
opened for writing.

    functions  entered before that, each counted once
    files      in which they stand
    path       the files of the functions of at most a depth, in the order of their first entry,
               neighbours of one file taken together
    hops       steps of that path from one file to another
    returns    hops to a file that the path had left before: the reader opens it again
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

#: Depths that are told, and the one whose path is printed.
DEPTHS, PRINTED = (1, 2, 3, 4, 5, 99), 3


@dataclass(frozen=True)
class Entry:
    """The first entry of a function: its file, its name, and how deep it lies."""

    file: str
    name: str
    depth: int


class Journey:
    """Functions of a package in the order of their first entry, up to the writing of a file.

    Args:
        root: The package's folder.
        goal: Name of the file whose opening for writing ends the journey.
    """

    def __init__(self, root: Path, goal: str) -> None:
        self._root, self._goal = f"{root}/", goal
        self.entries: list[Entry] = []
        self.ended = False
        self._entered: set[CodeType] = set()
        self._depth = -1

    def profile(self, frame: FrameType, event: str, _: Any) -> None:
        """Follow one event of `sys.setprofile`."""
        code = frame.f_code
        if self.ended or not code.co_filename.startswith(self._root):
            return
        if self._depth < 0 and not (code.co_name == "identify" and "/cli/" in code.co_filename):
            return
        if event == "call":
            self._depth += 1
            function = code.co_flags & CO_OPTIMIZED and not code.co_name.startswith("<")
            if function and code not in self._entered:
                self._entered.add(code)
                file = code.co_filename.removeprefix(self._root)
                self.entries.append(Entry(file, code.co_name, self._depth))
        elif event == "return":
            self._depth -= 1

    def audit(self, event: str, args: tuple[Any, ...]) -> None:
        """End the journey where the goal is written."""
        if event == "open" and self.entries and Path(str(args[0])).name.startswith(self._goal):
            self.ended = True


def path(entries: Iterable[Entry], depth: int) -> list[str]:
    """The files that functions of at most a depth stand in, neighbours of one file as one."""
    files: list[str] = []
    for entry in entries:
        if entry.depth <= depth and (not files or files[-1] != entry.file):
            files.append(entry.file)
    return files


def main() -> None:
    """Run `identify` and print the journey."""
    if len(sys.argv) < 3:  # noqa: PLR2004 - two arguments
        sys.exit(__doc__)
    source, log, *options = sys.argv[1:]
    sys.path.insert(0, str(Path(source).resolve()))
    from stribeck import cli  # noqa: PLC0415 - from the checkout that was named

    journey = Journey(Path(cli.__file__).resolve().parents[1], "card.json")
    with tempfile.TemporaryDirectory() as folder:
        sys.argv = ["stribeck", "identify", log, "--out", folder, *options]
        sys.addaudithook(journey.audit)
        sys.setprofile(journey.profile)
        try:
            cli.main()
        finally:
            sys.setprofile(None)
            tell(journey)


def tell(journey: Journey) -> None:
    """Print the counts, and the path at one depth."""
    entries = journey.entries
    if not journey.ended:
        print("no card was written", file=sys.stderr)
    files = {entry.file for entry in entries}
    print(f"\n{len(entries)} functions in {len(files)} files on the way to the card")
    print("depth  functions  files  hops  returns")
    for depth in DEPTHS:
        way = path(entries, depth)
        few = sum(entry.depth <= depth for entry in entries)
        name = "all" if depth == DEPTHS[-1] else str(depth)
        returns = len(way) - len(set(way))
        print(f"{name:>5}  {few:9}  {len(set(way)):5}  {len(way) - 1:4}  {returns:7}")
    print(f"the path at depth {PRINTED}:")
    met: set[str] = set()
    for file in path(entries, PRINTED):
        print(f"  {file}{'  (again)' if file in met else ''}")
        met.add(file)


if __name__ == "__main__":
    main()
