"""The table of a fleet: a row per axis, time and parameter, in Parquet by machine and month.

A partition is a file `machine=M/month=2026-01/axes.parquet`; as usual with such folders its two
columns are in the path alone. A row that has no parameter says why its axis was refused.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import polars as pl

from ..errors import InputError
from ..report.folder import replace_tree
from .axis_job import AxisRecord
from .parquet_file import parquet_frame
from .table_check import GREATEST, checked
from .table_columns import COLUMNS, PATH_COLUMNS, SCHEMA, VERSION

#: The table's folder, and its file in each partition.
FOLDER, FILE = "table", "axes.parquet"
#: The month of what has no time.
UNDATED = "undated"


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
    if not card["parameters"]:
        raise ValueError("a card without parameters")
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
    """The table of records, all columns in it; a number that is infinite or none is left out."""
    rows = [row for record in records for row in table_rows(record)]
    texts = pl.DataFrame(rows, schema={**SCHEMA, "when": pl.String()})
    numbers = pl.col(pl.Float64)
    return texts.with_columns(
        pl.col("when").str.to_datetime(time_unit="us"),
        pl.when(numbers.abs() < GREATEST).then(numbers),
    )


def _stored_frame(records: Sequence[AxisRecord], folder: Path) -> pl.DataFrame:
    """The same of records that were kept.

    Raises:
        InputError: one of them was changed by hand.
    """
    try:
        return checked(frame_of(records))
    except (KeyError, TypeError, ValueError, AttributeError, pl.exceptions.PolarsError) as error:
        line = (str(error).splitlines() or [""])[0]
        machine, axis, when = records[0].job.labels
        raise InputError(
            f"{folder}: the records of {machine} from {axis} {when} on are damaged ({line:.200}): "
            "restore a copy of the store or take another folder"
        ) from error


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
            frame = _stored_frame(list(group), folder).drop(PATH_COLUMNS)
            with (path / FILE).open("wb") as file:  # whose errors are the disk's
                frame.write_parquet(file)

    replace_tree(folder, FOLDER, write)


def read_table(folder: Path) -> pl.DataFrame:
    """The table of a fleet's folder, or of the table's own.

    Raises:
        InputError: there is none, it is of another version, or it is damaged: which file, and how.
    """
    place = folder / FOLDER if (folder / FOLDER).is_dir() else folder
    files = sorted(place.glob(f"machine=*/month=*/{FILE}"))
    if not files:
        raise InputError(f"{folder}: there is no table: make one with `fleet MANIFEST --out DIR`")
    return pl.concat([_partition(file) for file in files])


def _partition(file: Path) -> pl.DataFrame:
    """The rows of one file, with the columns that its path holds.

    Every file is read by itself: what stands in the path above the table is then no partition,
    and a file that is empty does not go unseen.
    """
    machine, month = (unquote(p.name.partition("=")[2]) for p in (file.parents[1], file.parent))
    try:
        frame = parquet_frame(file)
        texts = {"machine": pl.lit(machine), "month": pl.lit(month)}
        return checked(frame.drop(PATH_COLUMNS, strict=False)).select(
            *(texts[name].alias(name) if name in texts else pl.col(name) for name in COLUMNS)
        )
    except InputError as error:
        raise InputError(f"{file}: {error}") from error
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError) as error:
        line = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(
            f"{file}: cannot be read ({line:.200}): the command that wrote it writes it anew"
        ) from error
