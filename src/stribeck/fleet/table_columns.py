"""The columns of a fleet's table, as they are documented."""

from __future__ import annotations

from dataclasses import dataclass

import polars as pl

#: The version of the columns: a column that is added leaves it as it is.
VERSION = "stribeck-fleet/1"
#: Columns that are in the paths of the partitions alone.
PATH_COLUMNS = ("machine", "month")


@dataclass(frozen=True)
class TableColumn:
    """A column of the table.

    Args:
        dtype: Its type.
        doc: What it says.
    """

    dtype: pl.DataType
    doc: str


_TEXT, _NUMBER = pl.String(), pl.Float64()
#: The columns in their order; `machine` and `month` are in the paths of the partitions.
COLUMNS = {
    "machine": TableColumn(_TEXT, "machine, as in the manifest"),
    "month": TableColumn(_TEXT, "month of `when`: 2026-01, or undated"),
    "axis": TableColumn(_TEXT, "axis, as in the manifest"),
    "when": TableColumn(pl.Datetime("us"), "time, as in the manifest; UTC where that has a zone"),
    "parameter": TableColumn(_TEXT, "its name, as the rig shows it; null of a refused axis"),
    "value": TableColumn(_NUMBER, "estimate"),
    "low": TableColumn(_NUMBER, "lower end of its 95 % interval; null of a fixed parameter"),
    "high": TableColumn(_NUMBER, "upper end"),
    "unit": TableColumn(_TEXT, "of value, low, high and standard_error"),
    "verdict": TableColumn(_TEXT, "identified, weak, not identifiable or fixed"),
    "verdict_reason": TableColumn(_TEXT, "why it is not identified"),
    "borderline": TableColumn(pl.Boolean(), "whether another log may have the other verdict"),
    "conditions": TableColumn(_TEXT, "conditions that do not hold for it, between semicolons"),
    "standard_error": TableColumn(_NUMBER, "of the estimate"),
    "status": TableColumn(_TEXT, "done, refused (not to be used so) or failed (tried again)"),
    "reason": TableColumn(_TEXT, "why it is not done"),
    "law": TableColumn(_TEXT, "friction law"),
    "rig": TableColumn(_TEXT, "rig, as in the manifest"),
    "error_name": TableColumn(_TEXT, "misfit on the training data: its name"),
    "error": TableColumn(_NUMBER, "its value"),
    "error_unit": TableColumn(_TEXT, "its unit"),
    "holdout_error": TableColumn(_NUMBER, "the greatest misfit on what was held out"),
    "log": TableColumn(_TEXT, "log or logs, as in the manifest"),
    "joint": TableColumn(_TEXT, "joint of the log"),
    "temperature": TableColumn(_NUMBER, "°C, as in the manifest"),
    "load": TableColumn(_TEXT, "load, as in the manifest"),
    "speed_low": TableColumn(_NUMBER, "speed that a tenth of the motion is below, SI"),
    "speed_median": TableColumn(_NUMBER, "speed that half of the motion is below, SI"),
    "speed_high": TableColumn(_NUMBER, "speed that nine tenths of the motion are below, SI"),
    "travel": TableColumn(_NUMBER, "from least to greatest position, SI"),
    "data_hash": TableColumn(_TEXT, "SHA-256 of the logs' bytes; of several, of their hashes"),
    "setup_hash": TableColumn(_TEXT, "digest of the rig's constants, columns and drive"),
    "version": TableColumn(_TEXT, "of stribeck"),
    "seconds": TableColumn(_NUMBER, "reading and identifying took: the only column "
                      "that another run changes"),
    "schema": TableColumn(_TEXT, "version of these columns"),
}  # fmt: skip
SCHEMA = {name: column.dtype for name, column in COLUMNS.items()}
