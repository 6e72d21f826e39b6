"""The `[drive]` table of a rig or a column map."""

from __future__ import annotations

import tomllib
from pathlib import Path

from ..errors import InputError
from ..text_file import page
from .chain import DriveChain


def drive_from(file: Path) -> DriveChain | None:
    """The chain that a TOML file has in its `[drive]` table; None where it has none.

    Raises:
        InputError: no such file, no TOML, or a table that is no chain.
    """
    try:
        table = tomllib.loads(page(file)).get("drive")
    except InputError as error:
        raise InputError(f"{file.name}: {error}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{file.name}: not TOML: {error}") from error
    if table is None:
        return None
    if not isinstance(table, dict):
        raise InputError(f'{file.name}: drive must be a table: [drive], signal = "A rms", say')
    return DriveChain.of_table(table, f"{file.name}: drive")
