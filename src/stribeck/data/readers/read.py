"""A log from a file, whatever its format and heads: a `Recording` in SI, or one line why not."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ...errors import InputError
from ..recording import CHANNELS, Recording, Source
from .budget import LARGEST, ReadBudget
from .columns import Choice, Entry, choose, is_there, mapping
from .delimited import read_text
from .json_log import read_json
from .matlab_file import read_matlab
from .parquet import read_parquet
from .raw_table import RawTable, printable, shortened
from .repair import Mender, filled_extra

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
        return _recording(table, _present(table, mapped) if lenient else mapped, source)
    except InputError as error:
        sentence = str(error).removeprefix(f"{printable(file.name)}: ")
        raise InputError(printable(f"{file.name}: {sentence}")) from error


def _present(table: RawTable, mapped: Mapping[str, Entry]) -> dict[str, Entry]:
    """The mapping without channels whose column is not there; time and position must be."""
    return {
        channel: entry
        for channel, entry in mapped.items()
        if channel in ("time", "position") or is_there(table, entry)
    }


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


def _recording(table: RawTable, mapped: Mapping[str, Entry], source: Source) -> Recording:
    chosen, notes = choose(table, mapped)
    channels = {name: chosen[name].values(table) for name in ("time", *CHANNELS) if name in chosen}
    used = {c.column for c in chosen.values()}
    mender = Mender(table, channels, filled_extra(table, used), list(table.notes))
    mender.notes += [f"column {shortened(n)} left out: it has text" for n in table.text]
    mender.mend()
    return Recording(
        t=mender.channels.pop("time"),
        **mender.channels,
        extra=mender.extra,
        rotary=_rotary(chosen),
        source=source,
        notes=(*mender.notes, *notes, *_scaled(chosen)),
    )


def _scaled(chosen: Mapping[str, Choice]) -> list[str]:
    """A word on a force that is another quantity times a number."""
    force = chosen.get("force")
    if force is None or isinstance(force.factor, str) or abs(force.factor) == 1:
        return []
    note = (
        f"force is {shortened(force.column)} times {force.factor:g}: every parameter of force and "
        "mass scales with that factor, and is no better known than it is"
    )
    return [note]


def _rotary(chosen: Mapping[str, Choice]) -> bool:
    return chosen["position"].unit.dimension == "rad"
