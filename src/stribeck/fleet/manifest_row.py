"""A row of a manifest: an axis at a time, the logs of it, and how they are identified."""

from __future__ import annotations

import datetime as dt
import math
from typing import Annotated, Any
from urllib.parse import quote

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

#: Control characters, ends of lines, and what turns the direction of writing.
_UNSEEN = r"\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069"
Name = Annotated[str, Field(min_length=1, max_length=200, pattern=rf"^[^{_UNSEEN}]+$")]
#: Bytes that the name of a folder may have, as a machine's is one with `machine=` before it.
_FOLDER_NAME = 240
#: Between several ranges in one field of a spreadsheet.
SEPARATOR = ";"


def _name(value: object) -> object:
    """A number as the name that it is: spreadsheets hold axis 7 as one, and as 7.0."""
    if isinstance(value, bool) or (isinstance(value, float) and not math.isfinite(value)):
        return value
    if isinstance(value, int | float):
        return repr(value).removesuffix(".0")
    return value.strip() if isinstance(value, str) else value


def _machine(name: str) -> str:
    if len(quote(f"machine={name}", safe=" ")) > _FOLDER_NAME:
        raise PydanticCustomError("long_name", "is too long for the name of a folder: shorten it")
    return name


def _ranges(value: object) -> object:
    if isinstance(value, str):
        return tuple(text.strip() for text in value.split(SEPARATOR) if text.strip())
    return value


def _when(value: object) -> object:
    """A time as it is compared: naive as it stands, with a zone as UTC without one.

    A number is none: whether it counts seconds, days or digits is not to be guessed.
    """
    if isinstance(value, str):
        value = dt.datetime.fromisoformat(value.strip())
    if isinstance(value, dt.datetime):
        return as_compared(value)
    if isinstance(value, dt.date):
        return dt.datetime(value.year, value.month, value.day)  # noqa: DTZ001 - see above
    if value is None:
        return None
    raise ValueError("no time")


def as_compared(when: dt.datetime) -> dt.datetime:
    """A time as the table has it: naive as it stands, with a zone as UTC without one.

    Raises:
        ValueError: UTC has no such time: it is before the year 1 or after 9999.
    """
    try:
        return when if when.tzinfo is None else when.astimezone(dt.UTC).replace(tzinfo=None)
    except OverflowError as error:
        raise ValueError("no time of UTC") from error


def _celsius(value: object) -> object:
    if isinstance(value, bool):
        raise PydanticCustomError("float_parsing", "is not a number")
    return value


Label = Annotated[Name, BeforeValidator(_name)]
Machine = Annotated[Label, AfterValidator(_machine)]
Ranges = Annotated[tuple[str, ...], BeforeValidator(_ranges)]
When = Annotated[dt.datetime | None, BeforeValidator(_when)]
Celsius = Annotated[float, Field(allow_inf_nan=False, gt=-273.15), BeforeValidator(_celsius)]


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
    machine: Machine = "-"
    when: When = None
    joint: Label | None = None
    columns: Name | dict[str, Any] | None = None
    drive: Name | dict[str, Any] | None = None
    law: Name | None = None
    train: Ranges = ()
    holdout: Ranges = ()
    temperature: Celsius | None = None
    load: Label | None = None
