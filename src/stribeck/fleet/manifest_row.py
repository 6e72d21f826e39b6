"""A row of a manifest: an axis at a time, the logs of it, and how they are identified."""

from __future__ import annotations

import datetime as dt
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

Name = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^\x00-\x1f\x7f]+$")]
#: Between several ranges in one field of a spreadsheet.
SEPARATOR = ";"


def _name(value: object) -> object:
    """A number as the name that it is: spreadsheets hold axis 7 as one."""
    whole = isinstance(value, int) and not isinstance(value, bool)
    return str(value) if whole else value.strip() if isinstance(value, str) else value


def _ranges(value: object) -> object:
    if isinstance(value, str):
        return tuple(text.strip() for text in value.split(SEPARATOR) if text.strip())
    return value


def _when(value: object) -> object:
    """A time as it is compared: naive as it stands, with a zone as UTC without one."""
    if isinstance(value, str):
        value = dt.datetime.fromisoformat(value.strip())
    if isinstance(value, dt.datetime):
        return value if value.tzinfo is None else value.astimezone(dt.UTC).replace(tzinfo=None)
    if isinstance(value, dt.date):
        return dt.datetime(value.year, value.month, value.day)  # noqa: DTZ001 - see above
    return value


Label = Annotated[Name, BeforeValidator(_name)]
Ranges = Annotated[tuple[str, ...], BeforeValidator(_ranges)]
When = Annotated[dt.datetime | None, BeforeValidator(_when)]


class ManifestRow(BaseModel):
    """What a manifest says of one identification; `axis`, `log` and `rig` are enough.

    Args:
        axis: Its name in its machine.
        log: A path from the manifest's folder, `axis.csv@10s:40s` for a part of one; `*` and `?`
            stand for several logs that are identified together.
        rig: A shipped rig, or a TOML file.
        machine: The machine that it is of.
        when: When it was recorded.
        joint: The joint whose columns are taken, where a log has several.
        columns: A TOML file that maps channels to columns, or its table.
        drive: A TOML file with the drive's chain, or its table.
        law: A friction law; the rig's first without one.
        train: Ranges to train on, between semicolons; everything without one.
        holdout: Ranges held out.
        temperature: Of the axis, °C.
        load: What it carries: a number or a word. Axes are compared at the same load.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    axis: Label
    log: Name
    rig: Name
    machine: Label = "-"
    when: When = None
    joint: Label | None = None
    columns: Name | dict[str, Any] | None = None
    drive: Name | dict[str, Any] | None = None
    law: Name | None = None
    train: Ranges = ()
    holdout: Ranges = ()
    temperature: Annotated[float, Field(allow_inf_nan=False, gt=-273.15)] | None = None
    load: Label | None = None
