"""TDMS (National Instruments), by npTDMS: channels by `group/name`, scaled, on waveform clocks."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...space import Array
from .isolated import IsolatedFormat
from .lazy_log import LazyLog
from .log_file import Channel, Reader, ReadOptions
from .raw_table import RawTable, listed, unique_names

LIBRARIES = ("nptdms",)
_UNITS = ("unit_string", "NI_UnitDescription", "unit", "Unit", "Einheit")


@dataclass(frozen=True)
class _Waveform:
    """When the samples of a channel were taken.

    Args:
        begin: Of the first, s since 1904 or any other common zero.
        step: From one to the next, s; 0 where the file does not say.
        count: Samples.
    """

    begin: float
    step: float
    count: int

    @property
    def clock(self) -> str:
        """Its name: channels of equal waveforms share one."""
        return f"{self.count} samples, {self.step:.6g} s, from {self.begin:.9g} s"


def library_log(path: Path, _options: ReadOptions) -> LazyLog:
    """A TDMS file, in the process that has npTDMS."""
    from nptdms import TdmsFile  # noqa: PLC0415 - an extra

    file = TdmsFile.open(path)
    every = [c for group in file.groups() for c in group.channels()]
    numbers = [c for c in every if len(c) and c.dtype.kind in "iufbM"]
    skipped = [f"{c.group_name}/{c.name}" for c in every if len(c) and c.dtype.kind not in "iufbM"]
    names = unique_names([f"{c.group_name}/{c.name}" for c in numbers])
    by_name = dict(zip(names, numbers, strict=True))
    waveforms = _waveforms(by_name)
    channels = [_channel(name, c, waveforms[name]) for name, c in by_name.items()]

    def load(wanted: Collection[str]) -> tuple[RawTable, ...]:
        return _tables({n: by_name[n] for n in wanted}, waveforms)

    problems = (f"left out, not numbers: {listed(skipped)}",) if skipped else ()
    return LazyLog(tuple(channels), load, problems)


_FORMAT = IsolatedFormat("tdms", LIBRARIES, "a TDMS file")


def _opens(_path: Path, head: bytes) -> bool:
    return head.startswith(b"TDSm")


READER = Reader(
    "tdms",
    "TDMS of LabVIEW, DIAdem, FlexLogger (National Instruments)",
    (".tdms",),
    _opens,
    _FORMAT.open,
    extra="logs",
    library="npTDMS (LGPL-3.0)",
)


def _waveforms(by_name: Mapping[str, Any]) -> dict[str, _Waveform]:
    """Those of all channels; the earliest begins at 0."""
    stamps = {n: c.properties.get("wf_start_time") for n, c in by_name.items()}
    dates = [s for s in stamps.values() if isinstance(s, np.datetime64)]
    first = min(dates, default=None)
    result = {}
    for name, channel in by_name.items():
        stamp = stamps[name]
        begin = (
            float((stamp - first) / np.timedelta64(1, "us")) * 1e-6
            if first is not None and isinstance(stamp, np.datetime64)
            else 0.0
        )
        begin += _number(channel.properties.get("wf_start_offset"))
        step = _number(channel.properties.get("wf_increment"))
        result[name] = _Waveform(begin, max(step, 0.0), len(channel))
    return result


def _began(by_name: Mapping[str, Any]) -> float | None:
    """When the earliest waveform began, s since 1970."""
    stamps = (c.properties.get("wf_start_time") for c in by_name.values())
    dates = [s for s in stamps if isinstance(s, np.datetime64) and not np.isnat(s)]
    return float(_floats(np.array([min(dates)]))[0]) if dates else None


def _number(value: Any) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        return 0.0
    return number if np.isfinite(number) else 0.0


def _channel(name: str, channel: Any, waveform: _Waveform) -> Channel:
    unit = next((str(channel.properties[k]) for k in _UNITS if channel.properties.get(k)), None)
    n = len(channel)
    first, last = (_floats(channel.read_data(k, 1))[0] for k in (0, n - 1))
    ends = (float(first), float(last)) if np.isfinite([first, last]).all() else None
    if channel.dtype.kind == "M":
        unit = "s"
    if not waveform.step:
        return Channel(name, unit, n, ends=ends)
    span = waveform.begin, waveform.begin + waveform.step * (n - 1)
    return Channel(name, unit, n, waveform.clock, 1.0 / waveform.step, span, ends)


def _floats(values: Any) -> Array:
    """Numbers, dates as s since 1970."""
    values = np.asarray(values)
    if values.dtype.kind == "M":
        return np.asarray(values.astype("datetime64[ns]").astype(np.int64) * 1e-9)
    return np.asarray(values, dtype=float)


def _tables(by_name: Mapping[str, Any], waveforms: Mapping[str, _Waveform]) -> tuple[RawTable, ...]:
    """A table for each waveform; channels without one share a table if they are as long."""
    tables: dict[_Waveform, tuple[dict[str, Array], dict[str, str]]] = {}
    began = _began(by_name)
    for name, channel in by_name.items():
        waveform = waveforms[name]
        columns, units = tables.setdefault(
            waveform if waveform.step else _Waveform(0.0, 0.0, waveform.count), ({}, {})
        )
        columns[name] = _floats(channel[:])
        if unit := _channel(name, channel, waveform).unit:
            units[name] = unit
    return tuple(
        RawTable(
            columns,
            np.arange(1, w.count + 1),
            "sample",
            units=units,
            t=w.begin + w.step * np.arange(float(w.count)) if w.step else None,
            clock=w.clock if w.step else "",
            began=began if w.step else None,
        )
        for w, (columns, units) in tables.items()
    )
