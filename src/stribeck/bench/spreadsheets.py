"""The records of a campaign as tables that other programs read: CSV and Parquet."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .record import Record, Steps

if TYPE_CHECKING:
    import polars as pl


#: The columns of a table of runs: the type in polars, and what stands there.
_COLUMNS: dict[str, tuple[str, Callable[[Record], Any]]] = {
    "problem": ("String", lambda r: r.job.problem),
    "algorithm": ("String", lambda r: r.job.algorithm),
    "repeat": ("Int64", lambda r: r.job.repeat),
    "seed": ("Int64", lambda r: r.job.seed),
    "budget": ("Int64", lambda r: r.job.budget),
    "target": ("Float64", lambda r: r.job.target),
    "minimum": ("Float64", lambda r: r.job.minimum),
    "cost": ("Float64", lambda r: r.cost),
    "evaluations": ("Int64", lambda r: r.evaluations),
    "ended": ("String", lambda r: r.ended),
    "reached": ("Boolean", lambda r: r.reached),
    "failed": ("Int64", lambda r: r.failed),
    "search_rounds": ("Int64", lambda r: r.search_rounds),
    "entrapments": ("Int64", lambda r: r.entrapments),
    "seconds": ("Float64", lambda r: r.seconds),
    "x": ("String", lambda r: json.dumps(r.x)),
    "rounds": ("String", lambda r: json.dumps(r.rounds)),
    "events": ("String", lambda r: json.dumps(r.events)),
}


def write_sheets(records: Iterable[Record], folder: Path) -> None:
    """Write records.csv, records.parquet and traces.parquet.

    A row of `records` is a run: problem, algorithm, repeat, seed, budget, target, minimum, cost,
    evaluations, ended, reached, failed, search_rounds (what the paper's Table 4 counts),
    entrapments, seconds; x, rounds and events as JSON. A row of `traces` is an improvement of a
    run: problem, algorithm, repeat, evaluation (from 1), round, cost.
    """
    runs: list[dict[str, Any]] = []
    steps: list[Steps] = []
    for record in records:
        runs.append({name: of(record) for name, (_, of) in _COLUMNS.items()})
        steps.append(record.steps)
    table = _table(runs)
    table.write_csv(folder / "records.csv")
    table.write_parquet(folder / "records.parquet")
    _trace(table, steps).write_parquet(folder / "traces.parquet")


def _table(runs: list[dict[str, Any]]) -> pl.DataFrame:
    import polars as pl  # noqa: PLC0415 - a fifth of a second that a run need not pay

    return pl.DataFrame(
        runs, schema={name: getattr(pl, kind) for name, (kind, _) in _COLUMNS.items()}
    )


def _trace(table: pl.DataFrame, steps: list[Steps]) -> pl.DataFrame:
    import polars as pl  # noqa: PLC0415 - as above

    rows = np.repeat(np.arange(len(steps)), [len(s.costs) for s in steps])
    evaluations = np.concatenate([np.empty(0, np.int64), *(s.evaluations for s in steps)])
    rounds = np.concatenate([np.empty(0, np.int64), *(s.rounds for s in steps)])
    costs = np.concatenate([np.empty(0), *(s.costs for s in steps)])
    labels = table.select("problem", "algorithm", "repeat")[rows]
    return labels.with_columns(
        pl.Series("evaluation", evaluations), pl.Series("round", rounds), pl.Series("cost", costs)
    )
