"""The numbers in a MATLAB 5 to 7 file, read from the published layout and from nothing else.

"MAT-File Format", The MathWorks: a header of 128 bytes, then elements of a tag (type, size) and
data, compressed ones holding one element each. Only numeric arrays are taken; cells, structures,
objects and functions are named and passed by. Every size is checked before it is used, which
`scipy.io.loadmat` does not do: a damaged file can make it crash the process.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import InputError
from .raw_table import LARGEST, RawTable, shortened

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


@dataclass(frozen=True)
class _MatlabVariable:
    name: str
    kind: str  # empty for real numbers
    values: np.ndarray[Any, Any] | None


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
        return _table(list(_variables(memoryview(data)[_HEADER:], order)))
    except (struct.error, zlib.error, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("is a broken MATLAB file: copy or save it again") from error


def _variables(data: memoryview, order: str) -> Iterator[_MatlabVariable]:
    room = LARGEST
    for kind, body in _elements(data, order, padded=False):
        if kind == _COMPRESSED:
            unpacked = zlib.decompressobj().decompress(body, room + 1)
            if (room := room - len(unpacked)) < 0:
                raise InputError("unpacks to more than 2 GiB: cut it into parts")
            for inner, matrix in _elements(memoryview(unpacked), order):
                yield from _matrix(inner, matrix, order)
        else:
            yield from _matrix(kind, body, order)


def _elements(
    data: memoryview, order: str, *, padded: bool = True
) -> Iterator[tuple[int, memoryview]]:
    """The (type, data) pairs of a stretch of bytes; compressed elements are not padded to 8."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from(order + "II", data, at)
        start, step = at + 8, -(-size // 8) * 8 if padded or kind != _COMPRESSED else size
        if kind >> 16:  # a small element: size and type share a word, the data is in the tag
            kind, size, start, step = kind & 0xFFFF, kind >> 16, at + 4, 0
            if size > 4:  # noqa: PLR2004 - the rest of the tag
                raise ValueError(size)
        if start + size > len(data):
            raise ValueError(size)
        yield kind, data[start : start + size]
        at += 8 + step


def _matrix(kind: int, body: memoryview, order: str) -> Iterator[_MatlabVariable]:
    if kind != _MATRIX or not len(body):
        return
    elements = list(_elements(body, order))
    (_, flags), (_, shape), (_, name), *contents = elements
    (word,) = struct.unpack_from(order + "I", flags)
    text = bytes(name).decode("latin-1").rstrip("\0")
    if not text:
        return
    if word & 0xFF not in _NUMERIC:
        yield _MatlabVariable(text, _KINDS.get(word & 0xFF, "unknown"), None)
    elif word >> 8 & _COMPLEX:
        yield _MatlabVariable(text, "complex numbers", None)
    else:
        dims = np.frombuffer(shape, dtype=order + "i4")
        stored, cells = contents[0] if contents else (9, memoryview(b""))
        yield _MatlabVariable(text, "", _array(dims.tolist(), stored, cells, order))


def _array(dims: list[int], stored: int, cells: memoryview, order: str) -> np.ndarray[Any, Any]:
    if stored not in _TYPES or len(dims) > _MOST_DIMENSIONS or min(dims, default=-1) < 0:
        raise ValueError(stored)
    values = np.frombuffer(cells, dtype=order + _TYPES[stored]).astype(float)
    return values.reshape(dims, order="F")  # a ValueError where sizes contradict each other


def _table(variables: list[_MatlabVariable]) -> RawTable:
    names = [v.name for v in variables]
    if doubled := sorted({n for n in names if names.count(n) > 1}):
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
    lengths = [_length(v.values) for v in variables if v.values is not None and v.values.size > 1]
    rows = max(set(lengths), key=lambda n: (lengths.count(n), n), default=0)
    if odd := [n for n, c in columns.items() if len(c) != rows]:
        notes.append(f"left out, not of the common length {rows}: {', '.join(map(shortened, odd))}")
    if skipped:
        notes.append(f"left out, not plain numbers: {', '.join(map(shortened, skipped))}")
    if not rows:
        content = f"only {', '.join(map(shortened, skipped))}" if skipped else "nothing"
        raise InputError(
            f"has no vectors of numbers ({content}): save time and position as vectors"
        )
    series = {n: c for n, c in columns.items() if len(c) == rows}
    return RawTable(series, np.arange(1, rows + 1), "row", {}, scalars, {}, tuple(notes))


def _length(values: np.ndarray[Any, Any]) -> int:
    return int(values.size if 1 in values.shape else len(values))


def _columns(name: str, values: np.ndarray[Any, Any]) -> dict[str, np.ndarray[Any, Any]]:
    """A vector under its name; the columns of a matrix under its name and their number."""
    if 1 in values.shape:
        return {name: values.reshape(-1)}
    return {f"{name}_{i}": column.copy() for i, column in enumerate(values.T, 1)}
