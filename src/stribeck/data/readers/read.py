"""A log from a file, whatever its format and heads: a `Recording` in SI, or one line why not."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ...errors import InputError
from ..recording import Recording, Source
from .assembly import assembled
from .budget import LARGEST, ReadBudget
from .columns import mapping
from .delimited import read_text
from .json_log import read_json
from .matlab_file import read_matlab
from .parquet import read_parquet
from .raw_table import RawTable, printable

_FORMATS: Mapping[str, Callable[[bytes], RawTable]] = {
    **dict.fromkeys((".csv", ".tsv", ".txt", ".dat", ".asc", ".log", ".tab"), read_text),
    **dict.fromkeys((".parquet", ".pq"), read_parquet),
    ".mat": read_matlab,
    ".json": read_json,
}
_MAGIC = {
    b"PK\x03\x04": "a zip or Excel file: save it as CSV",
    b"\xd0\xcf\x11\xe0": "an Excel file: save it as CSV",
    b"\x1f\x8b": "a gzip archive: unpack it first",
    b"\x89HDF": "an HDF5 file: export the log as CSV, Parquet or MATLAB 5",
    b"TDSm": "a TDMS file: export the log as CSV",
    b"%PDF": "a PDF: export the log as CSV",
    b"PAR1": "a Parquet file: name it .parquet",
    b"MATLAB": "a MATLAB file: name it .mat",
}


def read(
    path: str | Path,
    *,
    units: Mapping[str, str] | None = None,
    columns: Mapping[str, Any] | str | Path | None = None,
    lenient: bool = False,
) -> Recording:
    """Read a log: CSV and its kin, Parquet, MATLAB 5 to 7, JSON records.

    Columns are known by their heads, which say the unit: `Time [ms]`, `position_mm`, `q_cmd_rad`,
    `tau_meas_Nm`. Where names are other, `columns` maps channels to them:
    `{"position": "qm [m]", "force": {"column": "vir", "factor": "gtau", "unit": "N"}}`, as a dict
    or a TOML file. Every other numeric column is kept in `extra` as written, and so is every
    single number of a MATLAB or JSON file, as a constant column. Defects that do no harm are
    mended and told in `notes`; the others are refused.

    Args:
        path: The file.
        units: Unit by column, as in `{"t": "s", "x": "mm"}`, where the heads do not say it.
        columns: Channel -> "head", "head [unit]", or a table with `column`, and, if wanted, `unit`
            and `factor` (a number or the name of a column); or the TOML file that says so.
        lenient: Whether a mapped column that is not there is no reason to refuse a log: a rig
            says where its logs may have a channel, and asks for it if it needs it.

    Raises:
        InputError: the log cannot be used; the line says what is wrong, where, and what to do.
    """
    mapped = mapping(columns)
    file = Path(path)
    try:
        data = _bytes(file)
        table = _format(file)(data)
        columns_kept = len(table.columns) + len(table.scalars)  # a scalar becomes a column
        ReadBudget(len(data)).take_cells(len(table.places), columns_kept)
        source = Source(printable(file.name), hashlib.sha256(data).hexdigest(), len(table.places))
        arguments = assembled(table.with_units(units or {}), mapped, lenient=lenient)
        return Recording(**arguments, source=source)
    except InputError as error:
        sentence = str(error).removeprefix(f"{printable(file.name)}: ")
        raise InputError(printable(f"{file.name}: {sentence}")) from error


def _bytes(file: Path) -> bytes:
    try:
        if file.is_dir():
            raise InputError("is a folder: name a log in it")
        if file.exists() and not file.is_file():
            raise InputError("is not a regular file")
        if file.stat().st_size > LARGEST:
            raise InputError("is larger than 2 GiB: cut it into parts")
        data = file.read_bytes()
    except FileNotFoundError as error:
        raise InputError(f"no such file in {file.parent}") from error
    except (OSError, ValueError) as error:  # a zero byte in a path is a ValueError
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be read: {reason}") from error
    if not data:
        raise InputError("is empty")
    return data


def _format(file: Path) -> Callable[[bytes], RawTable]:
    """The reader for a file's extension, unless its first bytes say that it is something else."""
    suffix = file.suffix.lower()
    if suffix not in _FORMATS:
        raise InputError(f"{suffix or 'no extension'} is not read: give CSV, TSV, TXT, Parquet, "
                         "JSON or MATLAB 5 to 7 (.mat)")  # fmt: skip
    if _FORMATS[suffix] is read_text:
        with file.open("rb") as f:
            start = f.read(8)
        if kind := next((w for magic, w in _MAGIC.items() if start.startswith(magic)), None):
            raise InputError(f"is {kind}")
    return _FORMATS[suffix]
