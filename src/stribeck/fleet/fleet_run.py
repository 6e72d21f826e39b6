"""A fleet identified: every axis of a manifest once, and the table of all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import polars as pl

from ..bench.engines import Engine
from ..bench.engines import engine as engine_named
from ..bench.runner import conduct
from ..report.folder import check_folder, held
from .axis_job import AxisRecord, axis_jobs
from .fleet_page import write_overview
from .fleet_report import write_axis_report
from .fleet_store import FleetStore
from .fleet_table import read_table, write_table
from .manifest import ManifestSource, read_manifest

#: Called with each outcome, or how many axes other processes are at, and how many are left.
Progress = Callable[[AxisRecord | int, int], object]


@dataclass(frozen=True)
class Fleet:
    """What came of a manifest.

    Args:
        folder: Where store and table are.
        done: Axes identified.
        refused: Axes whose logs cannot be used as their rows say.
        failed: Axes whose work ended for another reason: they are tried again next time.
    """

    folder: Path
    done: int
    refused: int
    failed: int

    @property
    def axes(self) -> int:
        """How many rows the manifest has."""
        return self.done + self.refused + self.failed

    def report(self, manifest: ManifestSource, name: str) -> Path:
        """Write the full report of one axis, identified once more.

        Args:
            manifest: The fleet's.
            name: `AXIS`, `MACHINE/AXIS`, or either with `@2026-01-31`; of several times the last.

        Returns:
            The page.

        Raises:
            InputError: there is no such axis, or its log cannot be used.
        """
        return write_axis_report(axis_jobs(read_manifest(manifest)), name, self.folder)

    def table(self) -> pl.DataFrame:
        """Its table, a row per axis, time and parameter; its columns are those of the data set.

        Raises:
            InputError: it has been removed or damaged meanwhile.
        """
        return read_table(self.folder)


def fleet(
    manifest: ManifestSource,
    out: str | Path,
    *,
    engine: str | Engine = "here",
    progress: Progress | None = None,
) -> Fleet:
    """Identify every axis of a manifest that is not identified yet; write table and page of all.

    Every finished axis is kept in the store before the next begins: killed and called again,
    it goes on, and ends with the same table. A log that cannot be used is a row with its reason.

    Args:
        manifest: A TOML, CSV or Parquet file, a frame of polars, or rows as dicts, with columns
            `axis`, `log` and `rig`, and, as wanted, `machine`, `when`, `joint`, `columns`, `drive`,
            `law`, `train`, `holdout`, `temperature` (°C) and `load`.
        out: The folder for `store.sqlite`, `table/` and the page `index.html`.
        engine: `here`, `processes`, `processes:N` or `dask://HOST:PORT`.
        progress: Called with each outcome and how many axes are left.

    Returns:
        How many axes are done and how many are not; `table()` has the rest.

    Raises:
        InputError: the manifest, the engine or the folder cannot be used; one line says why.
    """
    jobs = list(axis_jobs(read_manifest(manifest)))
    runs = engine_named(engine) if isinstance(engine, str) else engine
    folder = Path(out)
    check_folder(folder)
    with FleetStore.open(folder) as store:
        store.add(jobs)
        left = store.left()
        for outcome in conduct(store, runs):
            left -= isinstance(outcome, AxisRecord)
            if progress is not None:
                progress(outcome, left)
        with held(folder, wait=True):
            write_table(store.outcomes(), folder)
            write_overview(read_table(folder), folder)
        counts = store.counts()
    done, refused = counts.get("done", 0), counts.get("refused", 0)
    return Fleet(folder, done, refused, len({job.key for job in jobs}) - done - refused)
