"""Maps from channels to columns, as people write them: a dict, a TOML file, options."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...text_file import page
from ..channels import CHANNELS
from .raw_table import printable, shortened

#: One entry: "head", "head [unit]", a column's number, or a table of column, unit and factor.
Entry = str | Mapping[str, str | float]


def mapping(columns: Mapping[str, Any], name: str = "columns") -> Mapping[str, Entry]:
    """A mapping that makes sense; `name` is how messages call it.

    Raises:
        InputError: a key is no channel, or an entry makes no sense.
    """
    for channel, entry in columns.items():
        if channel not in ("time", *CHANNELS):
            raise InputError(f"{name}: no channel {shortened(str(channel))!r}: there are time, "
                             f"{', '.join(CHANNELS)}")  # fmt: skip
        _checked(f"{name}: {channel}", entry)
    return columns


def toml_table(file: Path) -> tuple[str, Mapping[str, Any]]:
    """How messages call a TOML file, and what is in it.

    Raises:
        InputError: it is missing or not TOML.
    """
    name = printable(file.name)
    try:
        return name, tomllib.loads(page(file))
    except InputError as error:
        raise InputError(f"{name}: cannot read the mapping: {error}") from error
    except (ValueError, RecursionError) as error:  # TOML and UTF-8 errors are ValueErrors
        raise InputError(f"{name}: the mapping is not TOML: {printable(str(error))}") from error


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
