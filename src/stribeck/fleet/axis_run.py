"""One identification of a fleet, as a pure function of its job."""

from __future__ import annotations

import json
import time
from dataclasses import asdict
from typing import Any

from ..data.readers.opening import each_run
from ..errors import InputError, MissingLibrary
from ..identify.fit import identify
from ..identify.result import Fit
from ..identify.speed_range import speed_range
from ..rig.log_reading import read_for
from ..rig.lookup import rig_named
from .axis_job import AxisJob, AxisRecord


def record_text(text: str) -> str:
    """The text of a job's record, from the job's."""
    return axis_record(AxisJob.parse(text)).text


def axis_record(job: AxisJob) -> AxisRecord:
    """Identify an axis; a log that cannot be used is a record, too."""
    start = time.perf_counter()
    try:
        fit = axis_fit(job)
        card = json.loads(fit.card().text())
    except InputError as error:
        return _without_a_card(job, error, time.perf_counter() - start)
    card["search"]["seconds"] = 0.0
    motion = speed_range(list(fit.recordings))
    seconds = time.perf_counter() - start
    fields = None if motion is None else asdict(motion)
    return AxisRecord(job, "done", card=card, motion=fields, seconds=seconds)


def _without_a_card(job: AxisJob, error: InputError, seconds: float) -> AxisRecord:
    """Refused, or failed where the reason may be gone by the next run with the job as it is."""
    if _is_of_a_library(error):
        return job.failed(str(error))
    if job.inputs_have_changed:
        return job.failed(f"{error} (a log, its map or the rig has changed meanwhile)")
    return AxisRecord(job, "refused", str(error), seconds=seconds)


def _is_of_a_library(error: BaseException | None) -> bool:
    while error is not None and not isinstance(error, MissingLibrary):
        error = error.__cause__
    return error is not None


def axis_fit(job: AxisJob) -> Fit:
    """The fit of a job.

    Raises:
        InputError: a log cannot be read, or not be identified as the row says.
    """
    row = job.row
    if not job.logs:
        raise InputError(f"no file is called {row['log']}")
    rig = rig_named(job.rig[0])
    stated: dict[str, Any] | None = None if job.columns is None else dict(job.columns)
    if job.drive is not None:
        stated = {**(stated or {"columns": dict(rig.columns or {})}), "drive": job.drive}
    recordings = [
        read_for(rig, run, stated, joint=row.get("joint"))
        for path, _, _ in job.logs
        for run in each_run(path, stated)
    ]
    return identify(
        recordings,
        rig=rig,
        law=row.get("law"),
        train=row.get("train") or None,
        holdout=row.get("holdout") or None,
    )
