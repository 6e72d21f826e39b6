"""Files that somebody else's library reads, in a process with limits: `library_process`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, Self

import numpy as np

from ...errors import InputError, MissingLibrary
from ...space import Array
from ...wording import is_command_line
from .budget import ReadBudget, refuse_many
from .interval import Interval
from .log_file import Channel, ReadOptions, TablesInMemory
from .raw_table import RawTable, shortened

#: What reads, and what it finds in its environment.
PROGRAM = Path(__file__).with_name("library_process.py")
ENVIRONMENT = {"RUST_BACKTRACE": "0", "POLARS_MAX_THREADS": "4", "OPENBLAS_NUM_THREADS": "1"}
#: Seconds of the processor that a read may take, and more for each MiB of the file.
_SECONDS, _SECONDS_MIB = 8, 4
#: Bytes of the line of JSON that heads an answer, at most: ten thousand channels.
_LINE = 64 << 20
_PIECE = 8 << 20


@dataclass(frozen=True)
class IsolatedFormat:
    """A format whose module here has `library_log(path, options)` and names its `LIBRARIES`.

    Args:
        module: Of this folder.
        libraries: What is imported to read it.
        content: What a file of it is, as in `an HDF5 file`.
        extra: What is installed for it; empty for what is there.
    """

    module: str
    libraries: tuple[str, ...]
    content: str
    extra: str = "logs"

    def open(self, path: Path, options: ReadOptions) -> IsolatedLog:
        """What is in a file.

        Raises:
            MissingLibrary: the library is not installed.
            InputError: the file is broken.
        """
        if any(find_spec(library.partition(".")[0]) is None for library in self.libraries):
            raise MissingLibrary(f'is {self.content}: pip install "stribeck[{self.extra}]"')
        with _LibraryAnswer(self, path, {"options": asdict(options)}) as answer:
            entry = answer.head
            tables = None if entry["tables"] is None else answer.tables()
        refuse_many(len(entry["channels"]), "channels")
        channels = tuple(_channel(c) for c in entry["channels"])
        if channels and not any(c.count for c in channels):
            raise InputError("is empty")
        if all(c.constant for c in channels):
            left = "; ".join(entry["problems"][:3])
            raise InputError(f"has no channels of numbers{f': {left}' if left else ''}")
        text = {name: (place, cell) for name, (place, cell) in entry["text"].items()}
        kind = SlicedIsolatedLog if entry["sliced"] else IsolatedLog
        return kind(self, path, options, channels, text, tuple(entry["problems"]), tables)


@dataclass(frozen=True, eq=False)
class IsolatedLog:
    """A file that is read by a process when samples are asked for.

    Args:
        format: What reads it.
        path: The file or folder.
        options: How.
        channels: What is in it.
        text: Column of text -> the place and the content of its first cell that is no number.
        problems: A sentence each.
        few: All samples, if they are few enough to come with the contents.
    """

    format: IsolatedFormat
    path: Path
    options: ReadOptions
    channels: tuple[Channel, ...]
    text: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    few: tuple[RawTable, ...] | None = None
    lacking: str = ""

    def tables(self, names: Collection[str] | None = None) -> tuple[RawTable, ...]:
        """Samples of channels, a table a clock.

        Raises:
            InputError: they are broken, or take more memory than the file's size allows.
        """
        asked = [c for c in self.channels if names is None or c.name in names]
        budget = ReadBudget(size_on_disk(self.path))
        for rows, columns in Counter(c.count for c in asked).items():
            budget.take_cells(rows, columns)
        return self._answered(asked)

    def _answered(
        self, asked: Sequence[Channel], interval: Interval | None = None
    ) -> tuple[RawTable, ...]:
        names = [c.name for c in asked]
        if self.few is not None:
            return TablesInMemory(self.few).tables(names)
        request = {
            "options": asdict(self.options),
            "names": names,
            "interval": None if interval is None else asdict(interval),
        }
        with _LibraryAnswer(self.format, self.path, request) as answer:
            return answer.tables()


@dataclass(frozen=True, eq=False)
class SlicedIsolatedLog(IsolatedLog):
    """The same of a format of which a part can be read."""

    def part(self, names: Collection[str], interval: Interval) -> tuple[RawTable, ...]:
        """Samples of channels in an interval, and a few beside it.

        Raises:
            InputError: as `tables` does.
        """
        return self._answered([c for c in self.channels if c.name in names], interval)


def size_on_disk(*files: Path) -> int:
    """Bytes of files, of a folder of all in it."""
    each = (p for file in files for p in (file.rglob("*") if file.is_dir() else [file]))
    return sum(p.stat().st_size for p in each if p.is_file())


def process(arguments: Sequence[str], errors: IO[bytes]) -> subprocess.Popen[bytes]:
    """The program that reads, with pipes to it and from it."""
    return subprocess.Popen(  # noqa: S603 - this Python, this package's own file
        [sys.executable, "-P", str(PROGRAM), *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=errors,
        env={**os.environ, **ENVIRONMENT, "PYTHONPATH": os.pathsep.join(sys.path)},
    )


class _LibraryAnswer:
    """What the process says; used in a `with`, which ends it.

    Raises:
        InputError: the file is broken.
        RuntimeError: the program that reads it has an error.
    """

    def __init__(self, kind: IsolatedFormat, path: Path, request: Mapping[str, Any]) -> None:
        self._size = size = size_on_disk(path)
        seconds = _SECONDS + _SECONDS_MIB * (size >> 20)
        limits = str(ReadBudget(size).total), str(seconds)
        self._kind = kind
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the process
        self._process = process([kind.module, str(path), *limits], self._errors)
        self.head: dict[str, Any] = {}
        self._request = json.dumps({**request, "typed": is_command_line()}).encode()

    def __enter__(self) -> Self:
        try:
            self._stdin.write(self._request)
            self._stdin.close()
            line = self._stdout.readline(_LINE)
        except OSError:  # it ended before it had read that
            line = b""
        try:
            self.head = json.loads(line)
        except ValueError as error:
            self._refuse_own_error()
            self._end()
            raise self._broken("it unpacks to too much, or does not end") from error
        if "refused" in self.head:
            self._end()
            raise InputError(self.head["refused"])
        if "broken" in self.head:
            self._end()
            raise self._broken(self.head["broken"])
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def tables(self) -> tuple[RawTable, ...]:
        """Those that the head of the answer announces.

        Raises:
            InputError: they are more than was asked for, or end early.
        """
        budget = ReadBudget(self._size)
        for head in self.head["tables"]:
            budget.take_cells(head["rows"], len(head["columns"]))
        return tuple(_table(head, self) for head in self.head["tables"])

    def count(self, most: int) -> int:
        """The rows of the next piece.

        Raises:
            InputError: there are none, or more than were announced.
        """
        written = self._stdout.read(8)
        count = int.from_bytes(written, sys.byteorder)
        if not 0 < count <= most:
            raise self._broken("it ends early")
        return count

    def numbers(self, values: Array) -> None:
        """Fill an array with the next of the numbers.

        Raises:
            InputError: there are fewer.
        """
        cells = values.view(np.uint8)
        at = 0
        while at < len(cells):
            piece = self._stdout.read(min(_PIECE, len(cells) - at))
            if not piece:
                raise self._broken("it ends early")
            cells[at : at + len(piece)] = np.frombuffer(piece, dtype=np.uint8)
            at += len(piece)

    @property
    def _stdin(self) -> IO[bytes]:
        assert self._process.stdin is not None  # noqa: S101 - a pipe
        return self._process.stdin

    @property
    def _stdout(self) -> IO[bytes]:
        assert self._process.stdout is not None  # noqa: S101 - a pipe
        return self._process.stdout

    def _refuse_own_error(self) -> None:
        """Tell an error of the program, which ends as Python does, from one of a library.

        Raises:
            RuntimeError: it ended with one.
        """
        if self._process.wait() == 1:
            self._errors.seek(0)
            words = self._errors.read().decode(errors="replace")
            self._end()
            raise RuntimeError(words)

    def _broken(self, words: str) -> InputError:
        library = self._kind.libraries[0].partition(".")[0]
        return InputError(
            f"is {self._kind.content} that {library} cannot read ({shortened(words, 100)}): copy "
            "or export it again"
        )

    def _end(self) -> None:
        self._process.kill()
        self._process.wait()
        self._stdout.close()
        self._errors.close()
        with suppress(OSError):  # what was written and never read
            self._stdin.close()


def _channel(entry: Mapping[str, Any]) -> Channel:
    pairs = {k: tuple(entry[k]) for k in ("span", "ends") if entry[k] is not None}
    return Channel(**{**entry, **pairs})


def _table(head: Mapping[str, Any], answer: _LibraryAnswer) -> RawTable:
    rows, first, at = head["rows"], head["first"], 0
    t = np.empty(rows) if head["timed"] else None
    columns = {name: np.empty(rows) for name in head["columns"]}
    while at < rows and columns:
        count = answer.count(rows - at)
        for values in (*([] if t is None else [t]), *columns.values()):
            answer.numbers(values[at : at + count])
        at += count
    return RawTable(
        columns,
        range(first + 1, first + rows + 1),
        head["word"],
        {name: (place, cell) for name, (place, cell) in head["text"].items()},
        head["scalars"],
        head["units"],
        tuple(head["notes"]),
        t,
        head["clock"],
        began=head["began"],
    )
