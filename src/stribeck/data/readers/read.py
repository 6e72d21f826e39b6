"""A log from a file, whatever its format and heads: a `Recording` in SI, or one line why not."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...drive import DriveChain
from ...errors import InputError
from ..recording import Recording, Source
from . import file_bytes
from .assembly import assembled
from .budget import ReadBudget
from .column_map import chain_of, mapping
from .log_file import ReadOptions
from .raw_table import printable
from .registry import opened

_WINDOW = re.compile(r"(?P<file>.+)@(?P<since>[\d.]+)s:(?P<until>[\d.]+)s")


def read(
    path: str | Path,
    *,
    units: Mapping[str, str] | None = None,
    columns: Mapping[str, Any] | str | Path | None = None,
    joint: str | None = None,
    rate: float | None = None,
    options: ReadOptions | None = None,
    drive: DriveChain | Mapping[str, Any] | None = None,
    lenient: bool = False,
) -> Recording:
    """Read a log of any format of `readers`.

    Columns are known by their heads, which say the unit: `Time [ms]`, `position_mm`, `q_cmd_rad`,
    `tau_meas_Nm`. Where names are other, `columns` maps channels to them:
    `{"position": "qm [m]", "force": {"column": "vir", "factor": "gtau", "unit": "N"}}`, as a dict
    or a TOML file. Every other numeric column is kept in `extra` as written, and so is every
    single number of a MATLAB or JSON file, as a constant column, unless the log is large. Defects
    that do no harm are mended and told in `notes`; the others are refused. Time counts from the
    first sample. A log without a position but with a velocity gets the integral of that.

    Args:
        path: The file, or a folder that is one log; `axis.csv@10s:40s` for a part of it.
        units: Unit by column, as in `{"t": "s", "x": "mm"}`, where the heads do not say it.
        columns: Channel -> "head", "head [unit]", a column's number, or a table with `column`, and,
            if wanted, `unit` and `factor` (a number or the name of a column); or the TOML file
            that says so.
        joint: The joint whose columns are taken, by name or number, where a log has several.
        rate: Samples a second of a log without times.
        options: What else a file may not say about itself.
        drive: The chain from what the drive recorded to the force at the axis, or its table, as a
            TOML file has it in `[drive]`.
        lenient: Whether a mapped column that is not there is no reason to refuse a log: a rig
            says where its logs may have a channel, and asks for it if it needs it.

    Raises:
        InputError: the log cannot be used; the line says what is wrong, where, and what to do.
    """
    mapped = mapping(columns)
    file, used = windowed(Path(path), options or ReadOptions())
    used = used if rate is None else replace(used, rate=rate)
    used = replace(used, drive=chain_of(columns, drive))
    try:
        _, log = opened(file, used)
        budget = ReadBudget(_size(file))
        arguments, rows, signal = assembled(
            log, mapped, joint, used, budget, units=units, lenient=lenient
        )
        source = Source(printable(file.name), file_bytes.sha256(file), rows)
        recording = Recording(**arguments, source=source)
        return recording.through(used.drive, signal) if used.drive and signal else recording
    except InputError as error:
        sentence = str(error).removeprefix(f"{printable(file.name)}: ")
        raise InputError(printable(f"{file.name}: {sentence}")) from error


def windowed(path: Path, options: ReadOptions) -> tuple[Path, ReadOptions]:
    """A path without the window that may follow it, and the options with that.

    Raises:
        InputError: the window is empty.
    """
    match = _WINDOW.fullmatch(path.name)
    if match is None or path.exists():
        return path, options
    since, until = float(match["since"]), float(match["until"])
    if not since < until:
        raise InputError(f"{path.name}: from {since:g} s to {until:g} s is no time")
    return path.with_name(match["file"]), replace(options, window=(since, until))


def _size(file: Path) -> int:
    """Bytes of a file, or of all in a folder."""
    files = [p for p in file.rglob("*") if p.is_file()] if file.is_dir() else [file]
    return sum(p.stat().st_size for p in files)
