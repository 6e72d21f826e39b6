"""Commands for many axes: identify all of them, and say what has changed."""

from __future__ import annotations

import datetime as dt
from pathlib import Path
from typing import Annotated

import typer

from ..errors import InputError
from .exits import fail
from .interruption import interruption

#: Rows of a table that are printed together.
_ROWS = 1000


def fleet(
    manifest: Annotated[Path, typer.Argument(metavar="MANIFEST", help="A TOML, CSV or Parquet file: a row for each axis and time with axis, log and rig.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Where store and table go; what is there is not identified again.")],
    engine: Annotated[str, typer.Option(metavar="E", help="here, processes[:N] or dask://HOST:PORT.")] = "processes",
    report: Annotated[str | None, typer.Option(metavar="AXIS", help="Write the full report of an axis, too: AXIS, MACHINE/AXIS or AXIS@2026-01-31.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the table, a row a line.")] = False,
) -> None:  # fmt: skip
    """Identify many axes, each once, into one table."""
    from ..fleet.axis_job import axis_jobs
    from ..fleet.fleet_page import OVERVIEW
    from ..fleet.fleet_progress import FleetProgress
    from ..fleet.fleet_report import axis_named
    from ..fleet.fleet_run import fleet as fleet_identified
    from ..fleet.fleet_table import FOLDER
    from ..fleet.manifest import read_manifest

    try:
        if report is not None:  # a name that is none is told before the work
            axis_named(axis_jobs(read_manifest(manifest)), report)
        with FleetProgress() as progress:
            result = fleet_identified(manifest, out, engine=engine, progress=progress)
        page = None if report is None else result.report(manifest, report)
    except KeyboardInterrupt:
        fail(
            f"interrupted: what is finished is safe in {out}; the same command goes on",
            interruption.status,
        )
    if json:
        for part in result.table().iter_slices(_ROWS):
            typer.echo(part.write_ndjson(), nl=False)
    else:
        typer.echo(
            f"{result.axes:,} axes: {result.done:,} done, {result.refused:,} refused, "
            f"{result.failed:,} failed; table in {out / FOLDER}, overview in {out / OVERVIEW}"
        )
        if page is not None:
            typer.echo(f"report in {page}")
    if result.failed:
        fail(f"{result.failed} axes failed: the same command tries them again", 1)


def drift(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that `fleet` wrote.")],
    false_alarms: Annotated[float, typer.Option(metavar="RATE", help="False alarms a year for each axis, to which limits are set.")] = 1.0,
    since: Annotated[str | None, typer.Option(metavar="DATE", help="Alarms before it no longer count.")] = None,
    like: Annotated[float, typer.Option(metavar="FACTOR", help="Within which speeds and travel are alike.")] = 1.5,
    weak: Annotated[bool, typer.Option("--weak", help="Compare weak estimates, too, by their intervals.")] = False,
    page: Annotated[bool, typer.Option("--page/--no-page", help="Whether drift.html is written into the folder.")] = True,
    json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:  # fmt: skip
    """Say what has changed in a fleet; exit status 1 if an alarm is up."""
    from ..fleet.drift import drift as drift_of
    from ..fleet.drift_report import show_drift
    from ..fleet.fleet_page import write_drift_page
    from ..report.format import json_text

    result = drift_of(folder, false_alarms=false_alarms, since=_date(since), like=like, weak=weak)
    place = write_drift_page(result, folder) if page else None
    if json:
        typer.echo(json_text(result.document()), nl=False)
    else:
        show_drift(result)
        if place is not None:
            typer.echo(f"pictures in {place}")
    if result.up:
        raise typer.Exit(1)


def _date(text: str | None) -> dt.datetime | None:
    from ..fleet.manifest_row import as_compared

    if text is None:
        return None
    try:
        return as_compared(dt.datetime.fromisoformat(text))
    except ValueError as error:
        raise InputError(f"--since {text!r}: write 2026-01-31 or 2026-01-31T08:00") from error
