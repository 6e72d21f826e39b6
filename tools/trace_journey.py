"""The files and functions between the command `identify LOG --out DIR` and its card.

    python tools/trace_journey.py CHECKOUT_SRC LOG [OPTIONS OF identify ...]

Runs the command in this process with the package at CHECKOUT_SRC (such as `src`) and notes each
Python function of the package when it is entered for the first time, with its depth: how many
functions of the package are open around it, counted from the command `identify`, whose depth
is 0. Compiled code, other threads and what a module does while it is imported are not seen. The
way ends when `card.json` is opened for writing, and the command with it.

    functions  entered on the way, each counted once
    files      in which they stand
    path       the files of the functions of at most a depth, in the order of their first entry,
               neighbours of one file taken together
    hops       steps of that path from one file to another
    returns    hops to a file that is on the path before
    reopened   those of the returns to a file in which no caller stands: the reader had closed it

A function that calls a neighbour in its own file after one elsewhere makes a return, but nothing
is opened for it: its file still lies open. The main line, which a reader follows before anything
else, is what lies at most three deep.
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

#: Depths that are shown, and the one whose path is printed.
DEPTHS, PRINTED = (1, 2, 3, 4, 5, 99), 3


@dataclass(frozen=True)
class Entry:
    """The first entry of a function: its file, its name and its depth.

    `still_open` is whether an open function around it stands in the same file.
    """

    file: str
    name: str
    depth: int
    still_open: bool


class _Arrival(BaseException):
    """Raised at the goal; not an Exception, so that no handler of errors catches it."""


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
        self._open: list[str] = []
        self._importing = 0

    def profile(self, frame: FrameType, event: str, _: Any) -> None:
        """Follow one event of `sys.setprofile`.

        Raises:
            _Arrival: The goal is reached.
        """
        code = frame.f_code
        if self.ended:
            raise _Arrival
        if event not in ("call", "return") or not code.co_filename.startswith(self._root):
            return
        if not self._open and not (code.co_name == "identify" and "/cli/" in code.co_filename):
            return
        file = code.co_filename.removeprefix(self._root)
        step = 1 if event == "call" else -1
        self._importing += step * (code.co_name == "<module>")
        if event == "return":
            self._open.pop()
            return
        function = code.co_flags & CO_OPTIMIZED and not code.co_name.startswith("<")
        if function and not self._importing and code not in self._entered:
            self._entered.add(code)
            still_open = file in self._open
            self.entries.append(Entry(file, code.co_qualname, len(self._open), still_open))
        self._open.append(file)

    def audit(self, event: str, args: tuple[Any, ...]) -> None:
        """End the journey where the goal is written."""
        if event == "open" and self.entries and Path(str(args[0])).name.startswith(self._goal):
            self.ended = True


def path(entries: Iterable[Entry], depth: int) -> list[Entry]:
    """The functions of at most a depth with which the file changes, in order."""
    steps: list[Entry] = []
    for entry in entries:
        if entry.depth <= depth and (not steps or steps[-1].file != entry.file):
            steps.append(entry)
    return steps


def returns(steps: Iterable[Entry]) -> list[Entry]:
    """The steps to a file in which an earlier one stands."""
    visited: set[str] = set()
    repeated = []
    for step in steps:
        if step.file in visited:
            repeated.append(step)
        visited.add(step.file)
    return repeated


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
        except _Arrival:
            pass
        finally:
            sys.setprofile(None)
            show(journey)


def show(journey: Journey) -> None:
    """Print the counts, and the path at one depth."""
    entries = journey.entries
    if not journey.ended:
        print("no card was written", file=sys.stderr)
    files = {entry.file for entry in entries}
    print(f"{len(entries)} functions in {len(files)} files on the way to the card")
    print("depth  functions  files  hops  returns  reopened")
    for depth in DEPTHS:
        steps = path(entries, depth)
        repeated = returns(steps)
        print(
            f"{'all' if depth == DEPTHS[-1] else depth:>5}  "
            f"{sum(entry.depth <= depth for entry in entries):9}  "
            f"{len({step.file for step in steps}):5}  {len(steps) - 1:4}  {len(repeated):7}  "
            f"{sum(not step.still_open for step in repeated):8}"
        )
    print(f"the path at depth {PRINTED}:")
    steps = path(entries, PRINTED)
    repeated = returns(steps)
    for step in steps:
        mark = "" if step not in repeated else "  (still open)" if step.still_open else "  (again)"
        print(f"{'  ' * (step.depth + 1)}{step.file}: {step.name}{mark}")


if __name__ == "__main__":
    main()
