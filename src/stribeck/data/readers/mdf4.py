"""MDF 4 and 3 (ASAM; Vector, ETAS, dSPACE), by asammdf: channel groups are clocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...space import Array
from .isolated import IsolatedFormat
from .log_file import Channel, Reader, ReadOptions
from .raw_table import RawTable, listed, unique_names
from .sliced_log import SlicedLog, SlicedRows

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
    from asammdf import MDF  # noqa: PLC0415 - an extra

    file: Any = MDF(path)
    places, written = [], []
    for i, group in enumerate(file.groups):
        if group.channel_group.cycles_nr:
            master = file.masters_db.get(i)
            kept = [k for k in range(len(group.channels)) if k != master]
            places += [_Place(i, k) for k in kept]
            written += [group.channels[k].name for k in kept]
    channels, units, where, skipped = [], {}, {}, []
    spans = {i: _span(file, i) for i in {p.group for p in places}}
    for name, place in zip(unique_names(written), places, strict=True):
        ends = _ends(file, place)
        if ends is None:
            skipped.append(name)
            continue
        count = int(file.groups[place.group].channel_group.cycles_nr)
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
        timed = spans[where[names[0]].group] is not None
        if rows:  # at once: the library begins at the first record for each piece
            count = int(file.groups[where[names[0]].group].channel_group.cycles_nr)
            part = {"record_offset": rows.start, "record_count": len(rows)}
            places = {n: where[n] for n in names}
            yield _piece(file, places, {} if len(rows) == count else part, timed=timed)

    problems = (f"left out, not numbers: {listed(skipped)}",) if skipped else ()
    return SlicedLog(tuple(channels), empty, pieces, problems=problems)


_FORMAT = IsolatedFormat("mdf4", LIBRARIES, "an MDF file")


def _opens(_path: Path, head: bytes) -> bool:
    return head.startswith((b"MDF     ", b"UnFinMF "))


READER = Reader(
    "mdf4",
    "MDF 4 and 3 (ASAM)",
    (".mf4", ".mdf", ".dat"),
    _opens,
    _FORMAT.open,
    extra="logs",
    library="asammdf (LGPL-3.0)",
)


def _span(file: Any, group: int) -> tuple[float, float] | None:
    """First and last instant of a group that has times, s."""
    if file.masters_db.get(group) is None:
        return None
    count = int(file.groups[group].channel_group.cycles_nr)
    first, last = (
        float(file.get_master(group, record_offset=k, record_count=1)[0]) for k in (0, count - 1)
    )
    return first, last


def _ends(file: Any, place: _Place) -> tuple[float, float, str] | None:
    """First and last number of a channel and its unit; None if it has no plain numbers."""
    count = int(file.groups[place.group].channel_group.cycles_nr)
    numbers = []
    unit = ""
    for k in (0, count - 1):
        signal = _signal(file, place, record_offset=k, record_count=1)
        values = np.asarray(signal.samples)
        if values.dtype.kind not in "iufb" or values.shape != (1,):
            return None
        numbers.append(float(values[0]))
        unit = str(signal.unit)
    return numbers[0], numbers[1], unit


def _signal(file: Any, place: _Place, **part: int) -> Any:
    """A channel scaled by its conversion; where that makes words of it, as it was stored."""
    where = {"group": place.group, "index": place.index}
    signal = file.get(**where, **part)
    if signal.samples.dtype.kind in "SUO":
        signal = file.get(**where, **part, raw=True)
    return signal


def _values(signal: Any) -> Array:
    """Its numbers, nan where the file marks them as invalid."""
    values = np.array(signal.samples, dtype=float)
    invalid = signal.invalidation_bits
    if invalid is not None and len(invalid) == len(values):
        values[np.asarray(invalid, dtype=bool)] = np.nan
    return values


def _piece(
    file: Any, places: dict[str, _Place], part: dict[str, int], *, timed: bool
) -> SlicedRows:
    """Some records of channels of one group."""
    columns: dict[str, Array] = {}
    t: Array | None = None
    for name, place in places.items():
        signal = _signal(file, place, **part)
        columns[name] = _values(signal)
        t = np.asarray(signal.timestamps, dtype=float) if timed and t is None else t
    return SlicedRows(t, columns)


def _began(file: Any) -> float | None:
    """When the measurement began, s since 1970."""
    try:
        return float(file.header.start_time.timestamp())
    except (AttributeError, ValueError, OverflowError, OSError):
        return None
