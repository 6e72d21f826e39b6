"""The pages of a fleet: all its axes at a glance, and what has changed; each a file of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import polars as pl

from ..report import DASH, number
from ..report.folder import write_text
from ..report.format import unit_label
from ..report.page.html_page import laid_out
from .drift_report import alarm_table, summary
from .drift_verdict import Drift, ParameterDrift
from .series_svg import POINTS, drift_picture, sparkline

#: Names of the pages.
OVERVIEW, DRIFT = "index.html", "drift.html"
#: Rows of what was refused, and pictures of what has not changed.
_REFUSED, _PICTURES = 500, 60
_HEADS = (
    "machine", "axis", "parameter", "last value", "interval", "unit", "verdict", "over time",
    "logs", "refused", "last log",
)  # fmt: skip


def write_overview(table: pl.DataFrame, folder: Path) -> Path:
    """Write the page with a row for each axis and parameter, and what was refused.

    Args:
        table: Of the fleet.
        folder: Of the fleet.

    Raises:
        InputError: the disk refuses.
    """
    ordered = table.sort("machine", "axis", "when", "log", maintain_order=True)
    done = ordered.filter(pl.col("status") == "done")
    others = ordered.filter(pl.col("status") != "done")
    axes = table.select("machine", "axis").n_unique()
    tiles = [
        ("axes", f"{axes:,}"),
        (
            "identified or weak, logs",
            f"{done.select('machine', 'axis', 'when', 'log').n_unique():,}",
        ),
        ("logs refused or failed", f"{len(others):,}"),
        ("machines", f"{table['machine'].n_unique():,}"),
    ]
    refused = [
        {**row, "when": _day(row["when"])} for row in others.head(_REFUSED).iter_rows(named=True)
    ]
    title = "1 axis" if axes == 1 else f"{axes:,} axes"
    text = laid_out(
        "fleet.html.j2", {}, "stribeck fleet", title, _lead(table),
        tiles=tiles, heads=_HEADS, rows=_rows(done, others), most=POINTS - 1, refused=refused,
        left_out=max(0, len(others) - _REFUSED),
        folder=folder.name,
    )  # fmt: skip
    write_text(folder / OVERVIEW, text)
    return folder / OVERVIEW


def _lead(table: pl.DataFrame) -> str:
    free = table.filter(pl.col("verdict").is_not_null() & (pl.col("verdict") != "fixed"))
    identified = int((free["verdict"] == "identified").sum())
    first, last = _day(table["when"].min()), _day(table["when"].max())
    times = f", {first} to {last}" * (last != DASH)
    return f"{identified:,} of {len(free):,} estimates are identified{times}."


def _rows(done: pl.DataFrame, others: pl.DataFrame) -> list[dict[str, Any]]:
    """A row for each axis and parameter that is not fixed."""
    counts = {
        (machine, axis): n
        for machine, axis, n in others.group_by("machine", "axis").len().iter_rows()
    }
    free = done.filter(pl.col("verdict") != "fixed")
    return [
        _row(part, counts)
        for part in free.partition_by("machine", "axis", "parameter", "unit", maintain_order=True)
    ]


def _row(part: pl.DataFrame, refused: dict[tuple[str, str], int]) -> dict[str, Any]:
    last = part.row(-1, named=True)
    value, low, high = (part[n].cast(pl.Float64).to_numpy() for n in ("value", "low", "high"))
    ends = f"{number(last['low'], 3)} to {number(last['high'], 3)}"
    return {
        "machine": last["machine"],
        "axis": last["axis"],
        "parameter": last["parameter"],
        "value": f"{last['value']:.6g}",
        "shown": number(last["value"], 4),
        "interval": DASH if last["low"] is None else ends,
        "unit": unit_label(last["unit"]),
        "verdict": last["verdict"],
        "change": f"{abs(value[-1] / value[0] - 1.0) if value[0] else 0.0:.4g}",
        "picture": sparkline(value, low, high),
        "logs": len(part),
        "refused": refused.get((last["machine"], last["axis"]), 0),
        "last": _day(last["when"]),
    }


def _day(when: Any) -> str:
    return DASH if when is None else f"{when:%Y-%m-%d}"


def write_drift_page(result: Drift, folder: Path) -> Path:
    """Write the page with the alarms and a picture of each parameter, those with alarms first.

    Raises:
        InputError: the disk refuses.
    """
    drawn, left_out = _drawn(result)
    verdicts = [p.verdict for p in result.parameters]
    tiles = [("alarms up", f"{len(result.up):,}")]
    tiles += [(f"parameters {v}", f"{verdicts.count(v):,}") for v in ("steady", "undecided")]
    tiles.append(("false alarms a year and axis", number(result.false_alarms, 3)))
    text = laid_out(
        "drift.html.j2", {}, "stribeck drift", "What has changed", summary(result),
        tiles=tiles, alarms=alarm_table(result) if result.up else None, left_out=left_out,
        pictures=[
            (f"{p.machine} {p.axis}: {p.parameter}", drift_picture(p), f"{p.verdict}: {p.why}")
            for p in drawn
        ],
    )  # fmt: skip
    write_text(folder / DRIFT, text)
    return folder / DRIFT


def _drawn(result: Drift) -> tuple[list[ParameterDrift], int]:
    """The parameters that are drawn, and how many are not."""
    dated = [p for p in result.parameters if p.rows["when"].null_count() < len(p.rows)]
    alarmed = [p for p in dated if p.alarms]
    others = [p for p in dated if not p.alarms]
    return alarmed + others[:_PICTURES], max(0, len(others) - _PICTURES)
