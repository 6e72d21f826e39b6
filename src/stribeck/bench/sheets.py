"""The records of a campaign as tables that other programs read: CSV and Parquet."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from .record import Record, Steps

if TYPE_CHECKING:
    import polars as pl


#: The columns of a table of runs.
_COLUMNS = (
    *("problem", "algorithm", "repeat", "seed", "budget", "target", "minimum", "cost"),
    *("evaluations", "ended", "reached", "failed", "search_rounds", "entrapments", "seconds"),
    *("x", "rounds", "events"),
)


def write_sheets(records: Iterable[Record], folder: Path) -> list[Path]:
    """Write records.csv, records.parquet and traces.parquet, each whole or not at all.

    A row of `records` is a run: problem, algorithm, repeat, seed, budget, target, minimum, cost,
    evaluations, ended, reached, failed, search_rounds (what the paper's Table 4 counts),
    entrapments, seconds; x, rounds and events as JSON. A row of `traces` is an improvement of a
    run: problem, algorithm, repeat, evaluation (from 1), round, cost.

    Returns:
        The files.

    Raises:
        InputError: the folder cannot be written to.
    """
    runs: list[dict[str, Any]] = []
    steps: list[Steps] = []
    for record in records:
        runs.append(_run(record))
        steps.append(record.steps)
    table = _table(runs)
    trace = _trace(table, steps)
    sheets: dict[str, Callable[[Path], Any]] = {
        "records.csv": table.write_csv,
        "records.parquet": table.write_parquet,
        "traces.parquet": trace.write_parquet,
    }
    try:
        folder.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".stribeck-", dir=folder) as place:
            for name, write in sheets.items():
                write(Path(place) / name)
            for name in sheets:
                os.replace(Path(place) / name, folder / name)  # noqa: PTH105 - atomic, and says so
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror or error}") from error
    return [folder / name for name in sheets]


def _run(record: Record) -> dict[str, Any]:
    job = record.job
    return {
        "problem": job.problem,
        "algorithm": job.algorithm,
        "repeat": job.repeat,
        "seed": job.seed,
        "budget": job.budget,
        "target": job.target,
        "minimum": job.minimum,
        "cost": record.cost,
        "evaluations": record.evaluations,
        "ended": record.ended,
        "reached": record.reached,
        "failed": record.failed,
        "search_rounds": record.search_rounds,
        "entrapments": record.entrapments,
        "seconds": record.seconds,
        "x": json.dumps(record.x),
        "rounds": json.dumps(record.rounds),
        "events": json.dumps(record.events),
    }


def _table(runs: list[dict[str, Any]]) -> pl.DataFrame:
    import polars as pl  # noqa: PLC0415 - a fifth of a second that a run need not pay

    counts = ("repeat", "seed", "budget", "evaluations", "failed", "search_rounds", "entrapments")
    kinds: dict[str, Any] = dict.fromkeys(_COLUMNS, pl.String)
    kinds |= dict.fromkeys(counts, pl.Int64)
    kinds |= dict.fromkeys(("target", "minimum", "cost", "seconds"), pl.Float64)
    return pl.DataFrame(runs, schema=kinds | {"reached": pl.Boolean})


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
