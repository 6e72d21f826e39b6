"""Parquet and MATLAB files as tables; nothing in them is ever run."""

from __future__ import annotations

import io
import warnings
from typing import Any, cast

import numpy as np

from ..errors import InputError
from .table import LARGEST, Table, shortened

_NUMERIC = {"double", "single", "logical", "int8", "uint8", "int16", "uint16", "int32", "uint32",
            "int64", "uint64"}  # fmt: skip
_HARMLESS = {"char"}


def read_parquet(data: bytes) -> Table:
    """A Parquet file; times and durations in it count in seconds.

    Raises:
        InputError: it is broken, too large unpacked, or has no columns of numbers.
    """
    import polars as pl  # noqa: PLC0415 - a fifth of a second that `--help` need not pay

    if not (data.startswith(b"PAR1") and data.endswith(b"PAR1")):
        raise InputError("is not a whole Parquet file: copy or export it again")
    try:
        lazy = pl.scan_parquet(io.BytesIO(data))
        schema = lazy.collect_schema()
        rows = lazy.select(pl.len()).collect().item()
        _bound(rows * 8 * len(schema))
        frame = lazy.collect()
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError, ValueError) as error:
        raise InputError("is a broken Parquet file: copy or export it again") from error
    columns, text, units, left = {}, {}, {}, []
    for series in frame.iter_columns():
        if series.dtype.is_numeric() or series.dtype == pl.Boolean:
            columns[series.name] = _floats(series)
        elif series.dtype in (pl.Datetime, pl.Duration):
            columns[series.name] = _floats(series.to_physical()) / _ticks(series.dtype)
            units[series.name] = "s"
        elif series.dtype == pl.String and (cells := series.drop_nulls()).len():
            columns[series.name] = np.full(len(series), np.nan)
            text[series.name] = (int(series.is_not_null().arg_max() or 0), str(cells[0]))
        else:
            left.append(shortened(series.name))
    notes = (f"left out, not numbers: {', '.join(left)}",) if left else ()
    return Table(columns, np.arange(1, frame.height + 1), "row", text, {}, units, notes)


def read_matlab(data: bytes) -> Table:
    """A MATLAB 5 to 7 file: vectors are columns, a matrix one column each, single numbers scalars.

    Raises:
        InputError: it is another version, broken, too large unpacked, or holds objects.
    """
    import scipy.io  # noqa: PLC0415 - a tenth of a second that `--help` need not pay

    if data.startswith((b"MATLAB 7.3", b"\x89HDF")):
        raise InputError("is MATLAB 7.3 (HDF5): save it again with save(..., '-v7')")
    if not data.startswith(b"MATLAB 5.0"):
        raise InputError("is not a MATLAB 5 to 7 file: save it again with save(..., '-v7')")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            held = scipy.io.whosmat(cast("str", io.BytesIO(data)))
            if objects := [n for n, _, kind in held if kind in ("object", "function", "opaque")]:
                raise InputError(  # noqa: TRY301 - the file is known to be refused only here
                    f"holds the object {shortened(objects[0])}: save its numbers as plain vectors"
                )
            wanted = [(n, shape) for n, shape, kind in held if kind in _NUMERIC]
            _bound(8 * sum(float(np.prod(np.array(shape, dtype=float))) for _, shape in wanted))
            names = [n for n, _ in wanted]
            loaded = (
                scipy.io.loadmat(cast("str", io.BytesIO(data)), variable_names=names)
                if names
                else {}
            )
    except InputError:
        raise
    except Exception as error:  # scipy raises a dozen kinds of errors over a damaged file
        raise InputError("is a broken MATLAB file: copy or save it again") from error
    left = [f"{n} ({kind})" for n, _, kind in held if kind not in _NUMERIC | _HARMLESS]
    return _vectors({n: loaded[n] for n in names if n in loaded}, left)


def _vectors(variables: dict[str, Any], left: list[str]) -> Table:
    scalars, columns, notes = {}, {}, []
    for name, value in variables.items():
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "buif":
            left.append(f"{name} (not real numbers)")
        elif value.size == 1:
            scalars[name] = float(value.reshape(-1)[0])
        elif value.ndim == 2 and value.size and 1 in value.shape:  # noqa: PLR2004 - a vector
            columns[name] = value.reshape(-1).astype(float)
        elif value.ndim == 2 and value.size:  # noqa: PLR2004 - a matrix
            long = value if value.shape[0] >= value.shape[1] else value.T
            columns |= {f"{name}_{i}": c.astype(float) for i, c in enumerate(long.T, 1)}
    lengths = [len(c) for c in columns.values()]
    rows = max(set(lengths), key=lambda n: (lengths.count(n), n), default=0)
    if odd := [n for n, c in columns.items() if len(c) != rows]:
        notes.append(f"left out, not of the common length {rows}: {', '.join(map(shortened, odd))}")
    if left:
        notes.append(f"left out, not plain numbers: {', '.join(map(shortened, left))}")
    if not rows:
        what = f"only {', '.join(map(shortened, left))}" if left else "nothing"
        raise InputError(f"has no vectors of numbers ({what}): save time and position as vectors")
    kept = {n: c for n, c in columns.items() if len(c) == rows}
    return Table(kept, np.arange(1, rows + 1), "row", {}, scalars, {}, tuple(notes))


def _floats(series: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    import polars as pl  # noqa: PLC0415 - as above

    return np.asarray(series.cast(pl.Float64).to_numpy(), dtype=float)


def _ticks(dtype: Any) -> float:
    return {"ms": 1e3, "us": 1e6, "ns": 1e9}[dtype.time_unit]


def _bound(size: float) -> None:
    if size > LARGEST:
        raise InputError(f"unpacks to {size / 2**30:.3g} GiB, more than 2 GiB: cut it into parts")
