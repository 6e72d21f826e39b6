"""Commands for many axes: identify all of them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from .exits import fail
from .interruption import interruption


def fleet(
    manifest: Annotated[Path, typer.Argument(metavar="MANIFEST", help="A TOML, CSV or Parquet file: a row for each axis and time with axis, log and rig.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Where store and table go; what is there is not identified again.")],
    engine: Annotated[str, typer.Option(metavar="E", help="here, processes[:N] or dask://HOST:PORT.")] = "processes",
    json: Annotated[bool, typer.Option("--json", help="Print the table, a row a line.")] = False,
) -> None:  # fmt: skip
    """Identify many axes, each once, into one table."""
    from ..fleet.fleet_progress import FleetProgress
    from ..fleet.fleet_run import fleet as fleet_identified
    from ..fleet.fleet_table import FOLDER

    try:
        with FleetProgress() as progress:
            result = fleet_identified(manifest, out, engine=engine, progress=progress)
    except KeyboardInterrupt:
        fail(
            f"interrupted: what is finished is safe in {out}; the same command goes on",
            interruption.status,
        )
    if json:
        result.table().write_ndjson(sys.stdout.buffer)
    else:
        typer.echo(
            f"{result.axes:,} axes: {result.done:,} done, {result.refused:,} refused, "
            f"{result.failed:,} failed; table in {out / FOLDER}"
        )
    if result.failed:
        fail(f"{result.failed} axes failed: the same command tries them again", 1)
