"""What a fleet's table has to be to be read: its version, its columns, and numbers in them."""

from __future__ import annotations

import polars as pl

from ..errors import InputError
from .table_columns import PATH_COLUMNS, SCHEMA, VERSION

#: What no row lacks, and what no row of a parameter lacks.
_EVERYWHERE, _PARAMETER = ("axis", "status"), ("value", "unit", "verdict")
#: Beyond it nothing is measured, and squares of numbers are none.
GREATEST = 1e100


def checked(frame: pl.DataFrame) -> pl.DataFrame:
    """A table with the columns of a fleet's in their order and of their types.

    Columns that only look otherwise are taken: numbers and times of another precision, and what is
    nowhere stated.

    Args:
        frame: The table, or what a partition's file has of it.

    Raises:
        InputError: it is of another version, lacks a column, or has cells that are no estimate.
    """
    _check_version(frame)
    wanted = {
        name: dtype
        for name, dtype in SCHEMA.items()
        if name in frame.columns or name not in PATH_COLUMNS
    }
    for name, dtype in wanted.items():
        if name not in frame.columns:
            raise InputError(f"has no column {name}")
        if not _is_like(there := frame.schema[name], dtype):
            raise InputError(f"column {name} is {there}: it has to be {dtype}")
    rows = frame.select(pl.col(name).cast(dtype) for name, dtype in wanted.items())
    _check_cells(rows)
    return rows


def _check_version(frame: pl.DataFrame) -> None:
    if "schema" not in frame.columns:
        raise InputError("has no column schema: is it the table of a fleet?")
    others = [v for v in frame["schema"].unique().to_list() if v != VERSION]
    if others:
        raise InputError(f"is of version {others[0]!s:.40}: this program reads {VERSION}")


def _is_like(there: pl.DataType, wanted: pl.DataType) -> bool:
    """Whether cells of a type can be taken for those of another as they are."""
    if there in (wanted, pl.Null):
        return True
    if wanted == pl.Float64:
        return there.is_numeric()
    if isinstance(wanted, pl.Datetime):
        return isinstance(there, pl.Datetime) and there.time_zone is None
    return wanted == pl.String and there in (pl.Categorical, pl.Enum)


def _check_cells(rows: pl.DataFrame) -> None:
    """Refuse cells without which a row says nothing, and numbers that are none."""
    states_parameter = pl.col("parameter").is_not_null()
    tests = [(f"{name} is missing", pl.col(name).is_null()) for name in _EVERYWHERE]
    tests += [
        (f"{name} is missing", states_parameter & pl.col(name).is_null()) for name in _PARAMETER
    ]
    numbers = [name for name, dtype in rows.schema.items() if dtype == pl.Float64]
    tests += [
        (f"{name} is no number to compare", ~(pl.col(name).abs() < GREATEST)) for name in numbers
    ]
    tests.append(("low is above high", pl.col("low") > pl.col("high")))
    for words, test in tests:
        wrong = rows.select(test.fill_null(value=False)).to_series().arg_true()
        if len(wrong):
            raise InputError(f"row {wrong[0] + 1}: {words}")
