"""ULog (PX4), by pyulog: topics with their instances, each on a clock of microseconds."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from ...space import Array
from .isolated import IsolatedFormat
from .lazy_log import LazyLog
from .log_file import Channel, Reader, ReadOptions, timing
from .raw_table import RawTable, listed, unique_names

LIBRARIES = ("pyulog",)
_MAGIC = b"ULog\x01\x12\x35"
_MICROSECOND = 1e-6
_TIME = "timestamp"


def library_log(path: Path, _options: ReadOptions) -> LazyLog:
    """A ULog file, in the process that has pyulog, which reads all of it at once."""
    from pyulog import ULog  # noqa: PLC0415 - an extra

    file = ULog(str(path))
    several = {d.name for d in file.data_list if d.multi_id > 0}
    clocks = unique_names([
        f"{d.name}.{d.multi_id}" if d.name in several else d.name for d in file.data_list
    ])  # fmt: skip
    topics = dict(zip(clocks, file.data_list, strict=True))
    channels = [c for clock, topic in topics.items() for c in _channels(clock, topic)]

    def load(wanted: Collection[str]) -> tuple[RawTable, ...]:
        tables = (_table(clock, topic, wanted) for clock, topic in topics.items())
        return tuple(table for table in tables if table.columns)

    return LazyLog(tuple(channels), load, _problems(file, clocks))


_FORMAT = IsolatedFormat("ulog", LIBRARIES, "a ULog file")


def _opens(_path: Path, head: bytes) -> bool:
    return head.startswith(_MAGIC)


READER = Reader(
    "ulog",
    "ULog of PX4",
    (".ulg", ".ulog"),
    _opens,
    _FORMAT.open,
    extra="logs",
    library="pyulog (BSD-3-Clause)",
)


def _fields(clock: str, topic: Any) -> dict[str, Array]:
    """Name -> numbers of a topic, but for its times."""
    return {
        f"{clock}/{field}": values
        for field, values in topic.data.items()
        if field != _TIME and values.dtype.kind in "iufb"
    }


def _channels(clock: str, topic: Any) -> list[Channel]:
    t = topic.data.get(_TIME)
    if t is None or len(t) == 0:
        return []
    rate, span = timing(_MICROSECOND * t)
    result = []
    for name, values in _fields(clock, topic).items():
        ends = (float(values[0]), float(values[-1])) if np.isfinite(values[[0, -1]]).all() else None
        result.append(Channel(name, None, len(values), clock, rate, span, ends))
    return result


def _table(clock: str, topic: Any, wanted: Collection[str]) -> RawTable:
    t = _MICROSECOND * np.asarray(topic.data.get(_TIME, ()), dtype=float)
    columns = {
        name: np.asarray(values, dtype=float)
        for name, values in _fields(clock, topic).items()
        if name in wanted and len(t)
    }
    return RawTable(columns, np.arange(1, len(t) + 1), "message", t=t, clock=clock)


def _problems(file: Any, clocks: list[str]) -> tuple[str, ...]:
    sentences = []
    if lost := sum(d.duration for d in file.dropouts):
        sentences.append(
            f"the logger dropped out {len(file.dropouts)} times, {1e-3 * lost:.4g} s together"
        )
    if file.file_corruption:
        sentences.append("damaged messages were left out")
    if empty := [c for c, d in zip(clocks, file.data_list, strict=True) if not len(d.data[_TIME])]:
        sentences.append(f"without messages: {listed(empty)}")
    return tuple(sentences)
