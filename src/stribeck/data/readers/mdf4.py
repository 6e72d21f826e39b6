"""MDF 4 and 3 (ASAM; Vector, ETAS, dSPACE), by asammdf: channel groups are clocks.

Records are read a few MiB at a time, and all channels that are asked for are taken of each piece:
`MDF.get` reads a channel from end to end, whatever part of it is wanted. The file is given to the
library open, not by its name, as it would be mapped into memory as a whole.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...space import Array
from .isolated import IsolatedFormat
from .log_file import Channel, Reader, ReadOptions
from .raw_table import RawTable, listed, unique_names
from .sliced_log import SlicedLog, SlicedRows

#: How a file begins that was not ended as it should; bytes of records that are read at a time.
_UNENDED, _PIECE = b"UnFinMF ", 8 << 20
LIBRARIES = ("asammdf", "asammdf.blocks.mdf_v4", "asammdf.blocks.mdf_v3")


@dataclass(frozen=True)
class _Place:
    """Where a channel stands in the file.

    Args:
        group: Its channel group.
        index: Its number in that.
    """

    group: int
    index: int


def library_log(path: Path, _options: ReadOptions) -> SlicedLog:
    """An MDF file, in the process that has asammdf."""
    with ExitStack() as stack:
        log = _opened(_source(path, stack))
        weakref.finalize(log, stack.pop_all().close)
    return log


def _opened(source: Any) -> SlicedLog:
    from asammdf import MDF  # noqa: PLC0415 - an extra

    file: Any = MDF(source)
    file.configure(read_fragment_size=_PIECE)
    places, written = [], []
    for i, group in enumerate(file.groups):
        if group.channel_group.cycles_nr:
            master = file.masters_db.get(i)
            kept = [k for k in range(len(group.channels)) if k != master]
            places += [_Place(i, k) for k in kept]
            written += [group.channels[k].name for k in kept]
    channels, units, where, skipped = [], {}, {}, []
    groups = sorted({p.group for p in places})
    spans = {i: _span(file, i) for i in groups}
    outer = {i: [next(_records(file, i, k, 1)) for k in (0, _count(file, i) - 1)] for i in groups}
    for name, place in zip(unique_names(written), places, strict=True):
        ends = _ends(file, place, outer[place.group])
        if ends is None:
            skipped.append(name)
            continue
        count = _count(file, place.group)
        unit = ends[2].strip() or None
        span = spans[place.group]
        rate = (count - 1) / (span[1] - span[0]) if span and span[1] > span[0] else None
        clock = f"group {place.group}" if span else ""
        finite = ends[:2] if np.isfinite(ends[:2]).all() else None
        channels.append(Channel(name, unit, count, clock, rate, span, finite))
        where[name] = place
        if unit:
            units[name] = unit

    def empty(names: Sequence[str]) -> RawTable:
        timed = spans[where[names[0]].group] is not None
        return RawTable(
            {n: np.empty(0) for n in names},
            np.empty(0, np.int64),
            "record",
            units={n: units[n] for n in names if n in units},
            t=np.empty(0) if timed else None,
            clock=f"group {where[names[0]].group}" if timed else "",
            began=_began(file) if timed else None,
        )

    def pieces(names: Sequence[str], rows: range) -> Iterator[SlicedRows]:
        if rows:
            group = where[names[0]].group
            places = {n: where[n] for n in names}
            for piece in _records(file, group, rows.start, len(rows)):
                yield _rows(file, places, piece, timed=spans[group] is not None)

    problems = (f"left out, not numbers: {listed(skipped)}",) if skipped else ()
    return SlicedLog(tuple(channels), empty, pieces, problems=problems)


_FORMAT = IsolatedFormat("mdf4", LIBRARIES, "an MDF file")


def _opens(_path: Path, head: bytes) -> bool:
    return head.startswith((b"MDF     ", _UNENDED))


READER = Reader(
    "mdf4",
    "MDF 4 and 3 (ASAM)",
    (".mf4", ".mdf", ".dat"),
    _opens,
    _FORMAT.open,
    extra="logs",
    library="asammdf (LGPL-3.0)",
)


def _source(path: Path, stack: ExitStack) -> Any:
    """What the library opens: a file that was not ended as it should it has to copy and mend."""
    file = stack.enter_context(path.open("rb"))
    ended = not file.read(len(_UNENDED)).startswith(_UNENDED)
    file.seek(0)
    return file if ended else path


def _count(file: Any, group: int) -> int:
    return int(file.groups[group].channel_group.cycles_nr)


def _records(file: Any, group: int, first: int, count: int) -> Iterator[Any]:
    """Records of a group in pieces, as `MDF.get` takes them for its `data`."""
    # The library makes them for itself alone, each time that it reads a channel.
    inner = file._mdf  # noqa: SLF001
    yield from inner._load_data(file.groups[group], first, count)  # noqa: SLF001


def _span(file: Any, group: int) -> tuple[float, float] | None:
    """First and last instant of a group that has times, s."""
    if file.masters_db.get(group) is None:
        return None
    first, last = (
        float(file.get_master(group, record_offset=k, record_count=1)[0])
        for k in (0, _count(file, group) - 1)
    )
    return first, last


def _ends(file: Any, place: _Place, outer: Sequence[Any]) -> tuple[float, float, str] | None:
    """First and last number of a channel and its unit; None if it has no plain numbers."""
    numbers = []
    unit = ""
    for record in outer:
        signal = _signal(file, place, record)
        values = np.asarray(signal.samples)
        if values.dtype.kind not in "iufb" or values.shape != (1,):
            return None
        numbers.append(float(values[0]))
        unit = str(signal.unit)
    return numbers[0], numbers[1], unit


def _signal(file: Any, place: _Place, piece: Any) -> Any:
    """A channel scaled by its conversion; where that makes words of it, as it was stored.

    Samples that the file marks as invalid are among them.
    """
    where = {"group": place.group, "index": place.index, "data": piece}
    signal = file.get(**where, ignore_invalidation_bits=True)
    if signal.samples.dtype.kind in "SUO":
        signal = file.get(**where, ignore_invalidation_bits=True, raw=True)
    return signal


def _values(signal: Any) -> Array:
    """Its numbers, nan where the file marks them as invalid."""
    values = np.array(signal.samples, dtype=float)
    invalid = signal.invalidation_bits
    if invalid is not None and len(invalid) == len(values):
        values[np.asarray(invalid, dtype=bool)] = np.nan
    return values


def _rows(file: Any, places: dict[str, _Place], piece: Any, *, timed: bool) -> SlicedRows:
    """Channels of one group in a piece of its records."""
    columns: dict[str, Array] = {}
    t: Array | None = None
    for name, place in places.items():
        signal = _signal(file, place, piece)
        columns[name] = _values(signal)
        t = np.array(signal.timestamps, dtype=float) if timed and t is None else t
    return SlicedRows(t, columns)


def _began(file: Any) -> float | None:
    """When the measurement began, s since 1970."""
    try:
        return float(file.header.start_time.timestamp())
    except (AttributeError, ValueError, OverflowError, OSError):
        return None
