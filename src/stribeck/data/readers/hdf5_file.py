"""HDF5 and MATLAB 7.3, by h5py: datasets are channels by their path, columns of a matrix by number.

Only what lies in the file itself is followed: links to other files are passed by. MATLAB writes
its matrices transposed, and cells and structures as references into `#refs#`, which are no samples.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from .arrays import matrix_names
from .budget import WIDEST
from .isolated import IsolatedFormat
from .log_file import Channel, Reader, ReadOptions
from .raw_table import RawTable, listed, shortened
from .sliced_log import SlicedLog, SlicedRows

LIBRARIES = ("h5py",)
_MAGIC = b"\x89HDF\r\n\x1a\n"
_MATLAB = b"MATLAB 7.3"
#: HDF5 may begin at 0, or behind a block of 512 bytes or twice that, and so on.
_STARTS = (0, 512, 1024, 2048)
_UNITS = ("unit", "units", "Unit", "Units", "UNIT", "UNITS")
_MATLAB_NUMBERS = ("double", "single", "logical", *(f"{u}int{n}" for u in ("", "u")
                                                    for n in (8, 16, 32, 64)))  # fmt: skip
_MOST_OBJECTS = 20_000
_BLOCK = 1 << 20  # numbers that are read at a time


@dataclass(frozen=True)
class _DatasetColumns:
    """A dataset that is columns.

    Args:
        path: Of the dataset.
        dataset: Of h5py.
        names: A name for each of its columns.
        fields: The members of its records, empty for plain numbers.
        transposed: Whether its rows are columns.
        count: Samples.
        unit: As its attributes state it.
    """

    path: str
    dataset: Any
    names: tuple[str, ...]
    fields: tuple[str, ...]
    transposed: bool
    count: int
    unit: str | None

    def rows(self, start: int, stop: int) -> np.ndarray[Any, Any]:
        """A block of samples, (rows, columns)."""
        if self.fields:
            records = self.dataset[start:stop]
            return np.column_stack([records[f].astype(float) for f in self.fields])
        if self.dataset.ndim == 1:
            return np.asarray(self.dataset[start:stop], dtype=float)[:, None]
        if self.transposed:
            return np.asarray(self.dataset[:, start:stop], dtype=float).T
        return np.asarray(self.dataset[start:stop], dtype=float)

    @property
    def block(self) -> int:
        """Rows that are read at a time: so that each of its chunks is unpacked once."""
        block = max(_BLOCK // len(self.names), 1)
        if self.dataset.chunks and not self.transposed:
            return int(-(-block // self.dataset.chunks[0]) * self.dataset.chunks[0])
        return block


def library_log(path: Path, options: ReadOptions) -> SlicedLog:
    """An HDF5 file, in the process that has h5py.

    Raises:
        InputError: it has no group of the name that was asked for.
    """
    import h5py  # noqa: PLC0415 - an extra

    file = h5py.File(path, "r")
    prefix = "" if options.episode is None else _group(file, options.episode)
    found = [(p.removeprefix(prefix), d) for p, d in _datasets(file) if p.startswith(prefix)]
    lengths = {d.shape[0] for _, d in found if d.ndim == 1}
    series: list[_DatasetColumns] = []
    scalars: dict[str, float] = {}
    skipped = []
    for name, dataset in found:
        if _is_scalar(dataset):
            scalars[name] = float(np.asarray(dataset[()], dtype=float).reshape(-1)[0])
        elif entry := _series(name, dataset, lengths):
            series.append(entry)
        else:
            skipped.append(name)
    channels = [c for s in series for c in _channels(s)]
    channels += [Channel(n, None, 1, ends=(v, v), constant=True) for n, v in scalars.items()]

    owners = {name: (one, i) for one in series for i, name in enumerate(one.names)}

    def empty(names: Sequence[str]) -> RawTable:
        units = {n: unit for n in names if (unit := owners[n][0].unit)}
        none = np.empty(0)
        return RawTable(dict.fromkeys(names, none), np.empty(0, np.int64), "row", units=units)

    def pieces(names: Sequence[str], rows: range) -> Iterator[SlicedRows]:
        own = [one for one in series if set(one.names).intersection(names)]
        block = max((one.block for one in own), default=1)
        stops = range(rows.start - rows.start % block + block, rows.stop + block, block)
        for start, stop in pairwise([rows.start, *(min(stop, rows.stop) for stop in stops)]):
            if start < stop:
                values = {id(one): one.rows(start, stop) for one in own}
                columns = {n: values[id(owners[n][0])][:, owners[n][1]] for n in names}
                yield SlicedRows(None, columns)

    problems = (f"left out, not columns of numbers: {listed(skipped)}",) if skipped else ()
    return SlicedLog(tuple(channels), empty, pieces, scalars, problems)


_FORMAT = IsolatedFormat("hdf5_file", LIBRARIES, "an HDF5 file")


def _opens(_path: Path, head: bytes) -> bool:
    return any(head[k : k + len(_MAGIC)] == _MAGIC for k in _STARTS) or head.startswith(_MATLAB)


READER = Reader(
    "hdf5",
    "HDF5 and MATLAB 7.3: datasets by path",
    (".h5", ".hdf5", ".hdf", ".mat"),
    _opens,
    _FORMAT.open,
    extra="logs",
    library="h5py (BSD-3-Clause)",
)


def _datasets(file: Any) -> Iterator[tuple[str, Any]]:
    """Datasets with their paths; each object once, and none of another file."""
    import h5py  # noqa: PLC0415 - an extra

    waiting = [("", file)]
    passed = set()
    while waiting:
        path, group = waiting.pop()
        inside = []
        for name in group:
            if name.startswith("#") or not isinstance(group.get(name, getlink=True), h5py.HardLink):
                continue
            entry = group[name]
            address = h5py.h5o.get_info(entry.id).addr
            if address in passed:
                continue
            passed.add(address)
            if len(passed) > _MOST_OBJECTS:
                raise InputError(f"has more than {_MOST_OBJECTS:,} objects: is it a log?")
            if isinstance(entry, h5py.Group):
                inside.append((f"{path}{name}/", entry))
            elif isinstance(entry, h5py.Dataset) and not (entry.is_virtual or entry.external):
                yield f"{path}{name}", entry
        waiting += reversed(inside)


def _group(file: Any, part: str) -> str:
    """The path of a group by its whole path or its last name, with a slash behind it."""
    paths = {f"{p.rpartition('/')[0]}/" for p, _ in _datasets(file) if "/" in p}
    parents = {p[: i + 1] for p in paths for i, c in enumerate(p) if c == "/"}
    part = part.strip("/")
    fits = [p for p in parents if p == f"{part}/" or p.endswith(f"/{part}/")]
    if not fits:
        raise InputError(f"has no group {shortened(part)}: there are {listed(sorted(parents))}")
    return min(fits, key=len)


def _is_scalar(dataset: Any) -> bool:
    return dataset.shape is not None and dataset.size == 1 and _numbers(dataset)


def _numbers(dataset: Any) -> bool:
    """Whether its cells are numbers, and no text or references that are kept as such."""
    kind = dataset.attrs.get("MATLAB_class")
    if kind is not None and _text(kind) not in _MATLAB_NUMBERS:
        return False
    return dataset.dtype.kind in "iufb" and "MATLAB_empty" not in dataset.attrs


def _series(name: str, dataset: Any, lengths: Collection[int]) -> _DatasetColumns | None:
    """A dataset as columns, None if it is none."""
    shape = dataset.shape
    if not shape or 0 in shape or len(shape) > 2:  # noqa: PLR2004 - rows, columns
        return None
    unit = _unit(dataset.attrs)
    members = dataset.dtype.fields
    if members and len(shape) == 1:
        fields = tuple(f for f, (kind, *_) in members.items() if kind.kind in "iufb")
        names = tuple(f"{name}/{f}" for f in fields)
        return (
            _DatasetColumns(name, dataset, names, fields, False, shape[0], unit) if fields else None
        )
    if not _numbers(dataset):
        return None
    if len(shape) == 1:
        return _DatasetColumns(name, dataset, (name,), (), False, shape[0], unit)
    transposed = _is_transposed(dataset, lengths)
    count, width = reversed(shape) if transposed else shape
    if width > WIDEST:
        return None
    names = matrix_names(name, width)
    return _DatasetColumns(name, dataset, names, (), transposed, count, unit)


def _is_transposed(dataset: Any, lengths: Collection[int]) -> bool:
    """Whether samples run along the second axis.

    As MATLAB writes a column, and its matrices of rows of samples; elsewhere where that axis alone
    is as long as a vector beside it, or as most samples are more than most channels.
    """
    first, second = dataset.shape
    if "MATLAB_class" in dataset.attrs:
        return bool(second > 1 and first <= WIDEST)
    if (first in lengths) != (second in lengths):
        return second in lengths
    return bool(second > first and (first == 1 or second > WIDEST))


def _unit(attributes: Mapping[str, Any]) -> str | None:
    written = next((attributes[k] for k in _UNITS if k in attributes), None)
    return None if written is None else _text(written) or None


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray):
        value = value.reshape(-1)[0] if value.size else ""
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


def _channels(series: _DatasetColumns) -> list[Channel]:
    ends = series.rows(0, 1)[0], series.rows(series.count - 1, series.count)[0]
    return [
        Channel(
            name,
            series.unit,
            series.count,
            ends=(float(a), float(b)) if np.isfinite([a, b]).all() else None,
        )
        for name, a, b in zip(series.names, *ends, strict=True)
    ]
