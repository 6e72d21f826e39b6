"""NumPy's `.npz` and `.npy`: arrays of numbers by name; objects, which are programs, are left out.

What the directory of a `.npz` says of sizes is counted before an array is unpacked, and no more
than that is unpacked.
"""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy

from ...errors import InputError
from ...space import Array
from .arrays import by_length, matrix_names
from .budget import CELL, WIDEST, ReadBudget, refuse_many
from .lazy_log import LazyLog
from .log_file import Channel, Reader, ReadOptions
from .raw_table import listed, shortened

_NPY, _ZIP = b"\x93NUMPY", b"PK\x03\x04"
_NUMBERS = "iufb"
_BROKEN = "is a broken NumPy file: copy or save it again"


@dataclass(frozen=True)
class _ArrayHead:
    """What stands before the numbers of an array.

    Args:
        name: Of the array; empty in a `.npy`, which has one.
        member: Of the archive; empty in a `.npy`.
        shape: Of NumPy.
        kind: Of its cells.
    """

    name: str
    member: str
    shape: tuple[int, ...]
    kind: np.dtype[Any]

    @property
    def size(self) -> int:
        """Bytes."""
        return math.prod(self.shape) * self.kind.itemsize

    @property
    def fields(self) -> tuple[str, ...]:
        """Members of its records that are numbers."""
        members: Mapping[str, Any] = self.kind.fields or {}
        return tuple(n for n, (kind, *_) in members.items() if kind.kind in _NUMBERS)

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of its columns; none if it is no columns of numbers."""
        if self.fields and len(self.shape) == 1:
            return tuple(f"{self.name}/{f}" if self.name else f for f in self.fields)
        if self.kind.kind not in _NUMBERS or len(self.shape) not in (1, 2) or 0 in self.shape:
            return ()
        width = self.shape[1] if len(self.shape) == 2 else 1  # noqa: PLR2004 - rows, columns
        if width > WIDEST:
            return ()
        return matrix_names(self.name, width) if self.name else _numbered(width)


@contextmanager
def _damage_told() -> Iterator[None]:
    """What zip and NumPy raise on a damaged, an encrypted or a foreign archive, as one line.

    Raises:
        InputError: the block ended by one of these, or by a line of its own.
    """
    try:
        yield
    except InputError:
        raise
    except (
        ValueError,  # a header of NumPy, a size
        SyntaxError,  # the text of such a header
        EOFError,
        OSError,  # an offset outside of the file
        zipfile.BadZipFile,
        zlib.error,
        RuntimeError,  # a password is asked for, or a compression is not known (its subclass)
    ) as error:
        raise InputError(_BROKEN) from error


def _numbered(width: int) -> tuple[str, ...]:
    return tuple(f"column {i}" for i in range(1, width + 1))


def _opens(_path: Path, head: bytes) -> bool:
    name = head[30 : 30 + int.from_bytes(head[26:28], "little")]
    return head.startswith(_NPY) or (head.startswith(_ZIP) and name.endswith(b".npy"))


def _open(path: Path, _options: ReadOptions) -> LazyLog:
    with _damage_told():
        heads = _heads(path)
    budget = ReadBudget(path.stat().st_size)
    scalars = {h.name: h for h in heads if h.shape in ((), (1,), (1, 1)) and h.member
               and h.kind.kind in _NUMBERS}  # fmt: skip
    series = [h for h in heads if h.name not in scalars and h.columns]
    refuse_many(sum(len(h.columns) for h in series), "columns")
    if not series:
        raise InputError("has no arrays of numbers as columns")
    skipped = [h.name for h in heads if h.name not in scalars and not h.columns]
    numbers = {n: float(_array(path, h, budget).reshape(-1)[0]) for n, h in scalars.items()}
    channels = [
        *(Channel(n, None, h.shape[0]) for h in series for n in h.columns),
        *(Channel(n, None, 1, ends=(v, v), constant=True) for n, v in numbers.items()),
    ]

    def load(wanted: Collection[str]) -> Any:
        own = ReadBudget(path.stat().st_size)
        columns: dict[str, Array] = {}
        for head in series:
            if kept := [n for n in head.columns if n in wanted]:
                own.take(
                    len(kept) * head.shape[0] * CELL, f"the numbers up to {shortened(kept[0])}"
                )
                columns |= _columns(head, _array(path, head, own), kept)
        return by_length(columns, None, {n: v for n, v in numbers.items() if n in wanted})

    problems = (f"left out, not columns of numbers: {listed(skipped)}",) if skipped else ()
    return LazyLog(tuple(channels), load, problems)


READER = Reader("numpy", "NumPy: .npz and .npy, without objects", (".npz", ".npy"), _opens, _open)


def _heads(path: Path) -> list[_ArrayHead]:
    with path.open("rb") as file:
        if file.read(len(_NPY)) == _NPY:
            file.seek(0)
            return [_head("", "", file)]
    with zipfile.ZipFile(path) as archive:
        members = [m for m in archive.infolist() if m.filename.endswith(".npy")]
        refuse_many(len(members), "arrays")
        heads = []
        for member in members:
            with archive.open(member) as file:
                head = _head(member.filename.removesuffix(".npy") or "array", member.filename, file)
            if not head.kind.hasobject and head.size > member.file_size:
                raise ValueError(member.file_size)
            heads.append(head)
    return heads


def _head(name: str, member: str, file: IO[bytes]) -> _ArrayHead:
    version = npy.read_magic(file)
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, kind = read(file)
    if any(n < 0 for n in shape):
        raise ValueError(shape)
    return _ArrayHead(name, member, shape, kind)


def _array(path: Path, head: _ArrayHead, budget: ReadBudget) -> np.ndarray[Any, Any]:
    """The cells of an array.

    Raises:
        InputError: they are more than the budget, or broken.
    """
    budget.take(head.size, f"the cells of {shortened(head.name) or 'the array'}")
    with _damage_told():
        if not head.member:
            return np.asarray(np.load(path, mmap_mode="r", allow_pickle=False))
        with zipfile.ZipFile(path) as archive, archive.open(head.member) as file:
            return np.asarray(npy.read_array(file, allow_pickle=False))


def _columns(
    head: _ArrayHead, values: np.ndarray[Any, Any], kept: Collection[str]
) -> dict[str, Array]:
    if head.fields:
        return {
            name: np.asarray(values[f], dtype=float)
            for name, f in zip(head.columns, head.fields, strict=True)
            if name in kept
        }
    matrix = values.reshape(head.shape[0], -1)
    return {
        name: np.array(matrix[:, i], dtype=float)
        for i, name in enumerate(head.columns)
        if name in kept
    }
