"""The numbers in a MATLAB 5 to 7 file, read from the published layout and from nothing else.

"MAT-File Format", The MathWorks: a header of 128 bytes, then elements of a tag (type, size) and
data, compressed ones holding one element each. Only numeric arrays are taken; cells, structures,
objects and functions are named and passed by. Every size is checked before it is used, which
`scipy.io.loadmat` does not do: a damaged file can make it crash the process. A variable is
unpacked once its first bytes say that it is numbers, and how many.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from .budget import CELL, ReadBudget, refuse_many
from .file_bytes import whole
from .log_file import Reader, ReadOptions, TablesInMemory
from .raw_table import RawTable, listed, shortened

_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
_TYPES = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}
_KINDS = {1: "cell", 2: "struct", 3: "object", 4: "char", 5: "sparse", 16: "function", 17: "object"}
_NUMERIC = range(6, 16)
_CHAR = 4
_COMPLEX = 0x08
_MOST_DIMENSIONS = 32
_START = 4096  # bytes that have a variable's tag, flags, dimensions and name


@dataclass(frozen=True)
class _MatlabVariable:
    """A variable of the file.

    Args:
        name: Its name.
        kind: What it is instead of real numbers, empty for those.
        shape: Its dimensions.
        values: Its numbers, None as long as it is not unpacked.
    """

    name: str
    kind: str
    shape: tuple[int, ...]
    values: np.ndarray[Any, Any] | None = None

    @property
    def useful(self) -> bool:
        """Whether it can be a column, columns or a single number."""
        rank, rows_and_columns = len(self.shape), 2
        return not self.kind and (rank == rows_and_columns or math.prod(self.shape) == 1)


def read_matlab(data: bytes) -> RawTable:
    """A MATLAB 5 to 7 file: vectors are columns, a matrix one column each, single numbers scalars.

    Raises:
        InputError: it is another version, broken, too large unpacked, or has no vectors.
    """
    if data.startswith((b"MATLAB 7.3", b"\x89HDF")):
        raise InputError("is MATLAB 7.3 (HDF5): save it again with save(..., '-v7')")
    order = {b"IM": "<", b"MI": ">"}.get(data[_HEADER - 2 : _HEADER])
    if not data.startswith(b"MATLAB 5.0") or order is None:
        raise InputError("is not a MATLAB 5 to 7 file: save it again with save(..., '-v7')")
    try:
        return _table(_variables(memoryview(data)[_HEADER:], order, ReadBudget(len(data))))
    except (struct.error, zlib.error, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("is a broken MATLAB file: copy or save it again") from error


def _variables(data: memoryview, order: str, budget: ReadBudget) -> list[_MatlabVariable]:
    """All variables; every one is counted before the first is unpacked."""
    elements = []
    for kind, body in _elements(data, order, padded=False):
        element = _Element(kind, body, order)
        if element.kind == _MATRIX and element.size and (v := _described(element, order, budget)):
            elements.append((v, element))
            refuse_many(len(elements), "variables")
    return [
        replace(v, values=_array(v.shape, element.data(), order)) if v.useful else v
        for v, element in elements
    ]


class _Element:
    """An element of the file.

    Args:
        kind: Its type.
        body: Its data; packed in it is one other element, whose type, size and beginning this is.
        order: Of bytes.
    """

    def __init__(self, kind: int, body: memoryview, order: str) -> None:
        self.kind, self.size, self.head, self._body = kind, len(body), body, body
        self.packed = kind == _COMPRESSED
        if self.packed:
            start = zlib.decompressobj().decompress(body, _START)
            self.kind, self.size = struct.unpack_from(order + "II", start)
            self.head = memoryview(start)[8 : 8 + self.size]

    def data(self) -> memoryview:
        """All of its data.

        Raises:
            ValueError: it is shorter than its tag says, or something comes after it.
        """
        if not self.packed:
            return self._body
        stream = zlib.decompressobj()
        unpacked = stream.decompress(self._body, 8 + self.size)
        if len(unpacked) < 8 + self.size or stream.decompress(stream.unconsumed_tail, 1):
            raise ValueError(self.size)
        return memoryview(unpacked)[8:]


def _elements(
    data: memoryview, order: str, *, padded: bool = True, whole: bool = True
) -> Iterator[tuple[int, memoryview]]:
    """The (type, data) pairs of a stretch of bytes; compressed elements are not padded to 8.

    Unless the stretch is `whole`, the last one may reach beyond it.
    """
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from(order + "II", data, at)
        start, step = at + 8, -(-size // 8) * 8 if padded or kind != _COMPRESSED else size
        if kind >> 16:  # a small element: size and type share a word, the data is in the tag
            kind, size, start, step = kind & 0xFFFF, kind >> 16, at + 4, 0
            if size > 4:  # noqa: PLR2004 - the rest of the tag
                raise ValueError(size)
        if whole and start + size > len(data):
            raise ValueError(size)
        yield kind, data[start : start + size]
        at += 8 + step


def _described(element: _Element, order: str, budget: ReadBudget) -> _MatlabVariable | None:
    """The variable of a matrix, by its first three elements: flags, dimensions and name."""
    (_, flags), (_, shape), (_, name) = islice(_elements(element.head, order, whole=False), 3)
    (word,) = struct.unpack_from(order + "I", flags)
    text = bytes(name).decode("latin-1").rstrip("\0")
    if not text:
        return None
    kind = "complex numbers" if word >> 8 & _COMPLEX else ""
    if word & 0xFF not in _NUMERIC:
        kind = _KINDS.get(word & 0xFF, "unknown")
    dims = tuple(np.frombuffer(shape, dtype=order + "i4").tolist())
    if len(dims) > _MOST_DIMENSIONS or min(dims, default=-1) < 0:
        raise ValueError(dims)
    variable = _MatlabVariable(text, kind, dims)
    if variable.useful:
        if math.prod(dims) > element.size:  # a number has a byte at least
            raise ValueError(dims)
        refuse_many(dims[-1] if dims[0] > 1 else 1, f"columns in {shortened(text)}")
        unpacked = element.size if element.packed else 0
        budget.take(math.prod(dims) * CELL + unpacked, f"the numbers up to {shortened(text)}")
    return variable


def _array(dims: tuple[int, ...], matrix: memoryview, order: str) -> np.ndarray[Any, Any]:
    contents = next(islice(_elements(matrix, order), 3, None), None)
    stored, cells = contents or (9, memoryview(b""))
    if stored not in _TYPES:
        raise ValueError(stored)
    values = np.frombuffer(cells, dtype=order + _TYPES[stored])
    if len(values) != math.prod(dims):  # sizes that contradict each other
        raise ValueError(dims)
    return values.astype(float).reshape(dims, order="F")


def _table(variables: list[_MatlabVariable]) -> RawTable:
    if doubled := sorted(n for n, count in Counter(v.name for v in variables).items() if count > 1):
        raise InputError(f"two variables are named {shortened(doubled[0])}: save it again")
    scalars: dict[str, float] = {}
    columns: dict[str, np.ndarray[Any, Any]] = {}
    notes = []
    skipped = [f"{v.name} ({v.kind})" for v in variables if v.kind not in ("", _KINDS[_CHAR])]
    for variable in variables:
        values = variable.values
        if values is not None and values.size == 1:
            scalars[variable.name] = float(values.reshape(-1)[0])
        elif values is not None and values.ndim == 2 and values.size:  # noqa: PLR2004 - rows, columns
            columns |= _columns(variable.name, values)
            refuse_many(len(columns), "columns")
    lengths = Counter(_length(v.shape) for v in variables if not v.kind and math.prod(v.shape) > 1)
    rows = max(lengths, key=lambda n: (lengths[n], n), default=0)
    if odd := [n for n, c in columns.items() if len(c) != rows]:
        notes.append(f"left out, not of the common length {rows}: {listed(odd)}")
    if skipped:
        notes.append(f"left out, not plain numbers: {listed(skipped)}")
    if not rows:
        content = f"only {listed(skipped)}" if skipped else "nothing"
        raise InputError(
            f"has no vectors of numbers ({content}): save time and position as vectors"
        )
    series = {n: c for n, c in columns.items() if len(c) == rows}
    return RawTable(series, np.arange(1, rows + 1), "row", {}, scalars, {}, tuple(notes))


def _length(shape: tuple[int, ...]) -> int:
    return math.prod(shape) if 1 in shape else shape[0]


def _columns(name: str, values: np.ndarray[Any, Any]) -> dict[str, np.ndarray[Any, Any]]:
    """A vector under its name; the columns of a matrix under its name and their number."""
    if 1 in values.shape:
        return {name: values.reshape(-1)}
    return {f"{name}_{i}": column for i, column in enumerate(values.T, 1)}


def _opens(_path: Path, head: bytes) -> bool:
    return head.startswith(b"MATLAB ")


def _open(path: Path, _options: ReadOptions) -> TablesInMemory:
    return TablesInMemory((read_matlab(whole(path)),))


READER = Reader("matlab", "MATLAB 5 to 7: vectors and matrices", (".mat",), _opens, _open)
