"""The full report of one axis of a fleet, identified once more to be drawn."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from urllib.parse import quote

from ..errors import InputError
from ..report.folder import check_folder, together, write_text
from ..wording import option
from .axis_job import AxisJob
from .axis_run import axis_fit

#: The folder of reports in that of a fleet.
FOLDER = "reports"


def write_axis_report(jobs: Iterable[AxisJob], name: str, folder: Path) -> Path:
    """Identify an axis as the fleet did, and write its card and report.

    Args:
        jobs: Of the fleet.
        name: `AXIS`, `MACHINE/AXIS`, or either with `@2026-01-31`; of several times the last.
        folder: Of the fleet.

    Returns:
        The page, in `reports/MACHINE/AXIS/TIME`.

    Raises:
        InputError: there is no such axis, several machines have it, or its log cannot be used.
    """
    from ..report.contents.gather import Contents  # noqa: PLC0415 - figures take time to load
    from ..report.page.html_page import PAGE, write_report  # noqa: PLC0415

    job = axis_named(jobs, name)
    machine, axis, when = job.labels
    parts = (machine, axis, when[:16].replace(":", "-"))
    place = folder.joinpath(FOLDER, *map(_folder_name, parts))
    check_folder(place)
    fit = axis_fit(job)
    with together(place) as draft:
        write_text(draft / "card.json", fit.card().text())
        write_report(Contents(fit).report(["stribeck", "fleet", option("report"), name]), draft)
    return place / PAGE


def _folder_name(label: str) -> str:
    """A label as one folder; `..` is none of a file system."""
    name = quote(label or "undated", safe=" ")
    return name.replace(".", "%2E") if not name.strip(".") else name


def axis_named(jobs: Iterable[AxisJob], name: str) -> AxisJob:
    """The job that a name means: a name with `@` in it, or the part before the last one.

    Raises:
        InputError: there is none, or several machines have such an axis.
    """
    axis, _, when = name.rpartition("@")
    asked = {name: "", **({axis: when} if axis else {})}
    fitting = [
        job
        for job in jobs
        for called in (job.row["axis"], f"{job.machine}/{job.row['axis']}")
        if called in asked and job.labels[2].startswith(asked[called])
    ]
    if not fitting:
        raise InputError(f"report {name}: the manifest has no such axis or time")
    if len(machines := sorted({job.machine for job in fitting})) > 1:
        raise InputError(
            f"report {name}: {', '.join(machines[:5])} have such an axis: write MACHINE/AXIS"
        )
    return max(fitting, key=lambda job: job.labels[2])
