"""The settings of a compensator as `compensate --out` leaves them, read back for an export."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..errors import InputError
from ..text_file import json_document, page
from .compensator import SETTINGS, Compensator

SCHEMA = "stribeck-compensation/2"


def read_settings(path: str | Path) -> Compensator:
    """The compensator that a `compensation.json` recommends.

    Raises:
        InputError: no such file, not one of `compensate`, a newer one, or one that recommends
            nothing.
    """
    path = Path(path)
    made_by = "`compensate --out` writes compensation.json"
    try:
        whole = json_document(page(path))
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is no JSON: {made_by}") from error
    schema = whole.get("schema") if isinstance(whole, Mapping) else None
    if schema != SCHEMA:
        raise InputError(f"{path}: its schema is {schema!s:.40}, not {SCHEMA}: {made_by}")
    best = whole.get("recommended")
    if best is None:
        raise InputError(f"{path}: recommends no scale: none was safe on every axis")
    values = {s.name: _value(best, s.name) for s in SETTINGS}
    for name, value in values.items():
        if value is None:
            raise InputError(f"{path}: recommended.settings.{name}.value is no number")
    values_given = {name: value for name, value in values.items() if value is not None}
    if values_given["feedback"] not in (0.0, 1.0):
        raise InputError(f"{path}: feedback is 0 or 1, got {values_given['feedback']:g}")
    try:
        return Compensator(feedback=values_given.pop("feedback") == 1.0, **values_given)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _value(best: object, name: str) -> float | None:
    """A setting's value, None where there is none."""
    at: object = best
    for key in ("settings", name, "value"):
        at = at.get(key) if isinstance(at, Mapping) else None
    if not isinstance(at, int | float) or isinstance(at, bool):
        return None
    try:
        return float(at)
    except OverflowError:  # JSON has whole numbers of any length
        return None
