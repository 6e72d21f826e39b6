"""The program that reads a file by somebody else's library, for `isolated`: path in, numbers out.

    python -P library_process.py MODULE PATH BYTES SECONDS < request.json > answer

A damaged file can make a library crash, loop, or ask for all memory there is. So it runs in a
process of its own, with `BYTES` of memory beside what its imports took, and `SECONDS` of the
processor. `MODULE` is a module of this folder that has `library_log`. The request says with which
options, which channels and of what time; the answer is a line of JSON and then the numbers,
float64, piece by piece. Of this package only what that module imports is loaded, not what
`stribeck` as a whole is.
"""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict
from importlib import import_module
from math import ceil
from pathlib import Path
from time import process_time
from types import ModuleType
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from .log_file import LogFile
    from .raw_table import RawTable

#: Memory that threads of libraries take beside what they read: bytes.
THREADS = 128 << 20
#: As many numbers come with the contents.
FEW = 1 << 20
_CHUNK = 1 << 20
_PACKAGES = ("stribeck", "stribeck.data", "stribeck.data.readers")


class _AskedTable(NamedTuple):
    """A table, its rows, and its samples in pieces."""

    table: RawTable
    rows: range
    pieces: Iterator[Any]


def main() -> None:
    """Read the request from standard input, write the answer."""
    module, path, memory, seconds = sys.argv[1:]
    output, sys.stdout = sys.stdout.buffer, sys.stderr  # some libraries print
    request = json.load(sys.stdin)
    answer(loaded(module), Path(path), request, (int(memory), int(seconds)), output)


def loaded(module: str) -> ModuleType:
    """A module of this folder with the libraries that it reads by."""
    warnings.simplefilter("ignore")
    _bare_packages()
    reader = import_module(f"{_PACKAGES[-1]}.{module}")
    for library in reader.LIBRARIES:
        import_module(library)
    return reader


def answer(
    reader: ModuleType,
    path: Path,
    request: Mapping[str, Any],
    limits: tuple[int, int],
    output: BinaryIO,
) -> None:
    """Read what is asked for and write it; this process has its limits from then on."""
    memory, seconds = limits
    _limit(THREADS + memory, seconds)
    words = import_module(f"{_PACKAGES[0]}.wording")
    try:
        options = import_module(f"{_PACKAGES[-1]}.log_file").ReadOptions(**request["options"])
        with words.on_command_line(entered=request.get("typed", False)):
            log = reader.library_log(path, options)
            if "names" in request:
                _write_tables(_parts(log, request), output)
            else:
                _write_contents(log, output)
    except MemoryError:
        _write_line({"broken": "it unpacks to too much"}, output)
    except BaseException as error:  # noqa: BLE001 - whatever a library raises on a damaged file
        kind = "refused" if type(error).__name__ == "InputError" else "broken"
        _write_line({kind: str(error) or type(error).__name__}, output)


def _bare_packages() -> None:
    """Packages without what their `__init__` imports: a compiler, among others."""
    root = Path(__file__).resolve().parents[2]
    for name in _PACKAGES:
        package = ModuleType(name)
        package.__path__ = [str(root.joinpath(*name.split(".")[1:]))]
        sys.modules[name] = package


def _limit(memory: int, seconds: int) -> None:
    """No more bytes and seconds than these beside what this process took; on Linux alone."""
    with suppress(ImportError, ValueError, OSError):
        import resource  # noqa: PLC0415 - there is none on Windows

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[5])
        hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
        used = pages * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_DATA, (used + memory, hard))
        hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
        resource.setrlimit(resource.RLIMIT_CPU, (ceil(process_time()) + seconds, hard))


def _write_contents(log: LogFile, output: BinaryIO) -> None:
    """The channels, and their samples as well if these are few: it saves another process."""
    contents = {
        "channels": [asdict(channel) for channel in log.channels],
        "text": dict(log.text),
        "problems": log.problems,
    }
    few = sum(channel.count for channel in log.channels) <= FEW
    tables = list(_parts(log, {})) if few else None
    heads = None if tables is None else [_head(*table) for table in tables]
    _write_line({**contents, "sliced": hasattr(log, "pieces"), "tables": heads}, output)
    _write_numbers(tables or (), output)


def _parts(log: Any, request: Mapping[str, Any]) -> Iterator[_AskedTable]:
    """The tables that are asked for, each with its pieces as they are read."""
    names, interval = request.get("names"), request.get("interval")
    if not hasattr(log, "pieces"):
        for table in log.tables(names):
            rows = range(len(table.places))
            yield _AskedTable(
                table, rows, iter([(table.t, table.columns)] if rows and table.columns else [])
            )
        return
    kind = import_module(f"{_PACKAGES[-1]}.interval").Interval
    for table, rows in log.parts(names, None if interval is None else kind(**interval)):
        yield _AskedTable(table, rows, log.pieces(list(table.columns), rows))


def _write_tables(parts: Iterable[_AskedTable], output: BinaryIO) -> None:
    every = list(parts)
    _write_line({"tables": [_head(*part) for part in every]}, output)
    _write_numbers(every, output)


def _head(table: RawTable, rows: range, _pieces: Any) -> Mapping[str, Any]:
    return {
        "first": rows.start,
        "rows": len(rows),
        "columns": list(table.columns),
        "timed": table.t is not None,
        "clock": table.clock,
        "began": table.began,
        "word": table.word,
        "units": dict(table.units),
        "scalars": dict(table.scalars),
        "text": dict(table.text),
        "notes": table.notes,
    }


def _write_numbers(parts: Iterable[_AskedTable], output: BinaryIO) -> None:
    """The pieces of each table: how many rows, then their instants, then column by column."""
    for part in parts:
        for t, columns in part.pieces:
            output.write(np.int64(len(next(iter(columns.values())))).tobytes())
            for values in (*([] if t is None else [t]), *columns.values()):
                for start in range(0, len(values), _CHUNK):
                    piece = np.asarray(values[start : start + _CHUNK], dtype=np.float64)
                    output.write(piece.tobytes())


def _write_line(entry: Mapping[str, Any], output: BinaryIO) -> None:
    output.write(json.dumps(entry).encode() + b"\n")


if __name__ == "__main__":
    main()
