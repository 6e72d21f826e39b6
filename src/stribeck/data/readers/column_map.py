"""Maps from channels to columns, as people write them: a dict, a TOML file, options."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...drive import DriveChain, drive_from
from ...errors import InputError
from ...text_file import page
from ..channels import CHANNELS
from .raw_table import printable, shortened

#: One entry: "head", "head [unit]", a column's number, or a table of column, unit and factor.
Entry = str | Mapping[str, str | float]


def mapping(columns: Mapping[str, Any] | str | Path | None) -> Mapping[str, Entry]:
    """A mapping from a dict or a TOML file (its `[columns]` table, or the whole of it).

    Raises:
        InputError: the file is missing or not TOML, a key is no channel, an entry makes no sense.
    """
    if columns is None:
        return {}
    if isinstance(columns, Mapping):
        name, read = "columns", columns
    else:
        name, read = _toml(Path(columns))
    for channel, entry in read.items():
        if channel not in ("time", *CHANNELS):
            raise InputError(f"{name}: no channel {shortened(str(channel))!r}: there are time, "
                             f"{', '.join(CHANNELS)}")  # fmt: skip
        _checked(f"{name}: {channel}", entry)
    return read


def chain_of(
    columns: Mapping[str, Any] | str | Path | None, drive: DriveChain | Mapping[str, Any] | None
) -> DriveChain | None:
    """The drive chain of a caller, or that of the `[drive]` table of a TOML file.

    Raises:
        InputError: both are there, or a table is no chain.
    """
    stated = drive_from(Path(columns)) if isinstance(columns, str | Path) else None
    if drive is None:
        return stated
    chain = drive if isinstance(drive, DriveChain) else DriveChain.of_table(drive)
    if stated is not None and stated != chain:
        raise InputError(f"the rig and {Path(str(columns)).name} both state a drive: state it once")
    return chain


def _toml(file: Path) -> tuple[str, Mapping[str, Entry]]:
    name = printable(file.name)
    try:
        read = tomllib.loads(page(file))
    except InputError as error:
        raise InputError(f"{name}: cannot read the mapping: {error}") from error
    except (ValueError, RecursionError) as error:  # TOML and UTF-8 errors are ValueErrors
        raise InputError(f"{name}: the mapping is not TOML: {printable(str(error))}") from error
    table = read.get("columns", {n: entry for n, entry in read.items() if n != "drive"})
    if not table and "drive" in read:
        return name, {}
    if not isinstance(table, dict):
        raise InputError(f'{name}: columns must be a table such as position = "x [mm]"')
    if not table:
        raise InputError(f'{name}: the mapping is empty: write position = "x [mm]", say')
    return name, table


def _checked(place: str, entry: object) -> None:
    if isinstance(entry, str):
        return
    if not isinstance(entry, Mapping) or not isinstance(entry.get("column"), str):
        raise InputError(f'{place}: write "head [unit]" or {{column = "head", unit = "N"}}')
    if odd := set(entry) - {"column", "unit", "factor"}:
        raise InputError(f"{place}: {min(map(str, odd))!r} is none of column, unit, factor")
    if not isinstance(entry.get("unit", ""), str):
        raise InputError(f'{place}: the unit must be text such as "mm"')
    factor = entry.get("factor", 1.0)
    number = isinstance(factor, (int, float)) and not isinstance(factor, bool)
    # TOML has integers of any length: none that no float can be is a factor.
    if not isinstance(factor, str) and not (number and 0 < abs(factor) <= sys.float_info.max):
        raise InputError(f"{place}: factor must be a number other than 0, or a column's name")
