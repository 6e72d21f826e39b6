"""ASCII exports of SignalExpress (National Instruments): blocks of names, starts, steps and data.

Lines `channel names:`, `start times:`, `dt:` and `data:`, each with rows of one cell a channel
below it, apart by tabs.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...errors import InputError
from .arrays import TimedSeries, by_times
from .budget import ReadBudget
from .cells import number_columns
from .file_bytes import whole
from .log_file import Reader, ReadOptions, TablesInMemory
from .lvm import LONGEST
from .raw_table import printable, unique_names
from .stamps import instants
from .text_encoding import utf8

_BEGINS = re.compile(rb"(?:\xef\xbb\xbf)?\s*channel names:", re.IGNORECASE)
_BLOCKS = re.compile(
    rb"channel names:[ \t]*\n(?P<names>[^\n]*)\n+"
    rb"(?:start times:[ \t]*\n(?P<starts>[^\n]*)\n+)?"
    rb"dt:[ \t]*\n(?P<steps>[^\n]*)\n+"
    rb"data:[ \t]*\n",
    re.IGNORECASE,
)


def _opens(_path: Path, head: bytes) -> bool:
    return _BEGINS.match(head) is not None


def _open(path: Path, _options: ReadOptions) -> TablesInMemory:
    data = utf8(whole(path))
    blocks = _BLOCKS.search(data[: 1 << 20])
    if blocks is None:
        raise InputError("its heads do not end: export it from SignalExpress again")
    names = [c for c in _cells(blocks["names"]) if c]
    try:
        steps = [float(c.replace(",", ".")) for c in _cells(blocks["steps"]) if c]
    except ValueError as error:
        raise InputError("its steps of time are no numbers: export it again") from error
    if len(steps) != len(names) or not all(0.0 < s < LONGEST for s in steps):
        raise InputError(f"names {len(names)} channels and {len(steps)} steps of time: export it "
                         "again")  # fmt: skip
    import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

    starts = instants(pl.Series(_cells(blocks["starts"] or b"")[: len(names)], dtype=pl.String))
    body = data[blocks.end() :]
    ReadBudget(len(data)).take_cells(body.count(b"\n") + 1, len(names))
    frame = number_columns(body, len(names) + 1, "\t")
    series = []
    for i, name in enumerate(unique_names(names)):
        values = np.asarray(frame[str(i)].to_numpy(), dtype=float)
        values = values[: int(np.isfinite(values).nonzero()[0].max(initial=-1)) + 1]
        start = 0.0 if starts is None or not np.isfinite(starts.t[i]) else float(starts.t[i])
        series.append(TimedSeries(name, start + steps[i] * np.arange(float(len(values))), values))
    if not any(len(s.t) for s in series):
        raise InputError("has heads and no samples")
    line = data.count(b"\n", 0, blocks.end()) + 1
    began = None if starts is None else starts.origin
    tables = by_times((s for s in series if len(s.t)), line)
    return TablesInMemory(tuple(replace(table, began=began) for table in tables))


READER = Reader(
    "signal-express",
    "SignalExpress, ASCII export (National Instruments)",
    (".txt",),
    _opens,
    _open,
)


def _cells(row: bytes) -> list[str]:
    return [printable(c) for c in row.decode(errors="replace").split("\t")]
