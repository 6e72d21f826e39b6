"""The table of a fleet: a row per axis, time and parameter, in Parquet by machine and month.

A partition is a file `machine=M/month=2026-01/axes.parquet`; as usual with such folders its two
columns are in the path alone. A row that has no parameter says why its axis was refused.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any
from urllib.parse import quote

import polars as pl

from ..errors import InputError
from ..report.folder import replace_tree
from .axis_job import AxisRecord

#: The version of the columns: a column that is added leaves it as it is.
VERSION = "stribeck-fleet/1"
#: The table's folder, and its file in each partition.
FOLDER, FILE = "table", "axes.parquet"
#: The month of what has no time.
UNDATED = "undated"


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


def table_rows(record: AxisRecord) -> Iterator[dict[str, Any]]:
    """The rows of a record, one per parameter; a single one of a record without a card."""
    row, when = record.job.row, record.job.row.get("when")
    shared: dict[str, Any] = {
        "machine": record.job.machine,
        "month": when[:7] if when else UNDATED,
        "axis": row["axis"],
        "when": when,
        "status": record.status,
        "reason": record.reason or None,
        "rig": row["rig"],
        "law": row.get("law"),
        "log": row["log"],
        "joint": row.get("joint"),
        "temperature": row.get("temperature"),
        "load": row.get("load"),
        "seconds": record.seconds,
        "schema": VERSION,
    }
    if record.motion is not None:
        speeds = {f"speed_{n}": record.motion[n] for n in ("low", "median", "high")}
        shared |= {**speeds, "travel": record.motion["travel"]}
    card = record.card
    if card is None:
        yield shared
        return
    objective, held = card["objective"], [h["value"] for h in card.get("holdout", [])]
    shared |= {
        "law": card["law"],
        "error_name": objective["name"],
        "error": objective["value"],
        "error_unit": objective["unit"],
        "holdout_error": max(held, default=None),
        "data_hash": _data_hash([d["sha256"] for d in card["data"]]),
        "setup_hash": _digest({n: card.get(n) for n in ("constants", "columns", "drive", "axis")}),
        "version": card["software"]["stribeck"],
    }
    for name, parameter in card["parameters"].items():
        yield {
            **shared,
            "parameter": name,
            "conditions": _conditions(card, name),
            "borderline": parameter.get("borderline", False),
            "verdict_reason": parameter.get("reason") or None,
            **{n: parameter.get(n) for n in ("value", "low", "high", "unit", "verdict")},
            "standard_error": parameter.get("standard_error"),
        }


def _conditions(card: Mapping[str, Any], parameter: str) -> str:
    """The conditions that do not hold for a parameter."""
    names = [
        c["condition"]
        for c in card.get("conditions", [])
        if c["parameters"] is None or parameter in c["parameters"]
    ]
    return "; ".join(dict.fromkeys(names))


def _data_hash(hashes: list[str]) -> str:
    return hashes[0] if len(hashes) == 1 else hashlib.sha256("".join(hashes).encode()).hexdigest()


def _digest(value: Any) -> str:
    text = json.dumps(value, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def frame_of(records: Iterable[AxisRecord]) -> pl.DataFrame:
    """The table of records, all columns in it."""
    rows = [row for record in records for row in table_rows(record)]
    texts = pl.DataFrame(rows, schema={**SCHEMA, "when": pl.String()})
    return texts.with_columns(pl.col("when").str.to_datetime(time_unit="us"))


def write_table(records: Iterable[AxisRecord], folder: Path) -> None:
    """Write the table in place of the one that is there, whole or not at all.

    Args:
        records: In the order of partitions.
        folder: Of the fleet.

    Raises:
        InputError: the disk refuses.
    """

    def partition(record: AxisRecord) -> tuple[str, str]:
        return record.job.machine, (record.job.row.get("when") or UNDATED)[:8].rstrip("-")

    def write(place: Path) -> None:
        for (machine, month), group in groupby(records, partition):
            path = place / f"machine={quote(machine, safe=' ')}" / f"month={month}"
            path.mkdir(parents=True)
            frame_of(group).drop("machine", "month").write_parquet(path / FILE)

    replace_tree(folder, FOLDER, write)


def read_table(folder: Path) -> pl.DataFrame:
    """The table of a fleet's folder, or of the table's own.

    Raises:
        InputError: there is none, or it is of another version.
    """
    place = folder / FOLDER if (folder / FOLDER).is_dir() else folder
    files = sorted(place.glob(f"machine=*/month=*/{FILE}"))
    if not files:
        raise InputError(f"{folder}: there is no table: make one with `fleet MANIFEST --out DIR`")
    try:
        frame = pl.read_parquet(
            place / "machine=*" / "month=*" / FILE,
            hive_partitioning=True,
            hive_schema={"machine": pl.String(), "month": pl.String()},
        )
        versions = frame["schema"].unique().to_list()
        if versions != [VERSION]:
            raise InputError(
                f"{folder}: its table is {versions[0]!s:.40}: this program reads {VERSION}"
            )
        return frame.select(*COLUMNS)
    except (pl.exceptions.PolarsError, OSError) as error:
        raise InputError(
            f"{folder}: its table cannot be read: {str(error).splitlines()[0]:.200}"
        ) from error
