"""The file of a rig that is dropped on the page, as a session's own axis."""

from __future__ import annotations

import json
import tomllib
from pathlib import PurePath
from typing import Any

from ..errors import InputError
from .choices import AXIS


def axis_of(text: str, name: str) -> dict[str, Any]:
    """What a rig's file says; without a name in it, the rig has that of the file.

    Raises:
        InputError: it is no TOML, or has what no rig has, a date say.
    """
    try:
        table = tomllib.loads(text)
        json.dumps(table, allow_nan=False)
    except (ValueError, TypeError, RecursionError) as error:
        raise InputError(f"{name}: not the TOML of a rig: {error}") from error
    return {"name": PurePath(name).stem, **table}


def chosen(axis: dict[str, Any]) -> dict[str, Any]:
    """The choices of a session whose axis is another."""
    other = {"constants": {}, "fixed": {}, "bounds": {}, "law": ""}
    return {"rig": AXIS, "axis": axis, **other, "velocity": "auto", "breakaway": "auto"}
