"""A trace of CODESYS and its kin (ctrlX, e!COCKPIT): `.trace.csv`.

Lines of `key; value`; for each variable `N.Variable; name`, then `N.Data;` and below it a line
`; time; value` a sample. Times are ms or us, which the file does not say.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ...errors import InputError
from ...units import unit
from ...wording import option
from .budget import ReadBudget, refuse_many
from .file_bytes import whole
from .log_file import Reader, ReadOptions, TablesInMemory
from .raw_table import RawTable, printable, shortened, unique_names
from .text_encoding import utf8

_BEGINS = re.compile(rb"(?:\xef\xbb\xbf)?\s*\[key\]\s*;\s*\[value\]", re.IGNORECASE)
_VARIABLE = re.compile(rb"(?m)^(\d+)\.Variable;[ \t]*(.*?)[ \t]*$")
_DATA = re.compile(rb"(?m)^(\d+)\.Data;[^\n]*\n((?:[ \t]*;[^\n]*(?:\n|$))*)")
_SAMPLE = re.compile(rb"(?m)^[ \t]*;[ \t]*([^;\s]+)[ \t]*;[ \t]*([^;\s]+)")
_WORDS = {b"TRUE": b"1", b"FALSE": b"0"}


def _opens(_path: Path, head: bytes) -> bool:
    return _BEGINS.match(head) is not None


def _open(path: Path, options: ReadOptions) -> TablesInMemory:
    data = utf8(whole(path))
    budget = ReadBudget(len(data))
    names = {number: printable(name.decode(errors="replace"))
             for number, name in _VARIABLE.findall(data)}  # fmt: skip
    refuse_many(len(names), "variables")
    series = [(m[1], m[2], data.count(b"\n", 0, m.start(2))) for m in _DATA.finditer(data)]
    budget.take_cells(sum(body.count(b"\n") + 1 for _, body, _ in series), 1)
    if not any(body.strip() for _, body, _ in series):
        raise InputError("is a trace without samples")
    written = unique_names(
        [names.get(number, f"variable {shortened(number.decode())}") for number, _, _ in series]
    )
    scale = _scale(options)
    tables: list[RawTable] = []
    for name, (_, body, line) in zip(written, series, strict=True):
        times, values = _samples(body, line)
        if len(times):
            _add(tables, name, scale * times, values, line)
    return TablesInMemory(tuple(tables), lacking="" if options.time_unit else _open_time_unit())


READER = Reader("codesys", "CODESYS, ctrlX and kin, trace (.trace.csv)", (".csv",), _opens, _open)


def _scale(options: ReadOptions) -> float:
    """Seconds of a unit of time; 1 as long as it is not known."""
    return float(unit(options.time_unit).factor) if options.time_unit else 1.0


def _open_time_unit() -> str:
    """What is said as long as the unit of time is not."""
    stated = option("columns", {"time_unit": "ms"})
    return f"its times are ms or us, which it does not say: give {stated} or us"


def _samples(body: bytes, line: int) -> tuple[np.ndarray, np.ndarray]:
    """Times as written and values of a variable, (N,).

    Raises:
        InputError: a cell is no number.
    """
    pairs = _SAMPLE.findall(body)
    for word, digit in _WORDS.items():
        pairs = [(t, digit if v == word else v) for t, v in pairs] if word in body else pairs
    try:
        cells = np.array(pairs, dtype="S").astype(float) if pairs else np.empty((0, 2))
    except ValueError:
        k = next(i for i, pair in enumerate(pairs) if not all(map(_is_number, pair)))
        cell = next(c for c in pairs[k] if not _is_number(c)).decode(errors="replace")
        raise InputError(f"line {line + k + 1}: {printable(cell)[:40]!r} is not a number: correct "
                         "it") from None  # fmt: skip
    return cells[:, 0], cells[:, 1]


def _is_number(cell: bytes) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _add(tables: list[RawTable], name: str, t: np.ndarray, values: np.ndarray, line: int) -> None:
    """A variable in the table of its times."""
    for table in tables:
        if table.t is not None and np.array_equal(table.t, t):
            table.columns[name] = values  # type: ignore[index]
            return
    tables.append(
        RawTable({name: values}, line + 1 + np.arange(len(t)), "line", t=t,
                 clock=f"clock {len(tables) + 1}")
    )  # fmt: skip
