"""Runs in COCO's own form: its data files and its pages, beside the published ones.

`observe` runs jobs again on the suite's own problems with COCO's observer attached; `postprocess`
hands the files to COCO's post-processing.
"""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..optimize import SearchError
from .bbob import Bbob, bbob, cocoex
from .record import Job, Record
from .run import run


def observe(jobs: Iterable[Job], folder: Path) -> Iterator[Record]:
    """Run BBOB jobs once more on the suite's own problems, with COCO watching.

    COCO's files are in `folder/exdata/ALGORITHM`, one for each algorithm's label, once all
    records have been taken. The jobs of an algorithm are run in the suite's order: dimension,
    function, instance; repeats of the same instance are trials of their own.

    Args:
        jobs: Jobs whose surface is a function of the suite.
        folder: Where the files go.

    Yields:
        The record of each job, equal in content to that of `run(job)`.

    Raises:
        InputError: a job is of another problem, or there are files already.
        SearchError: COCO's own count or best value differs from the record's.
    """
    jobs = sorted(jobs, key=lambda job: (job.algorithm, *_place(job)))
    exdata = folder.resolve() / "exdata"
    if '"' in str(exdata):
        raise InputError(f"{folder}: COCO cannot write to a folder with a quotation mark")
    for algorithm, runs in groupby(jobs, key=lambda job: job.algorithm):
        if not re.fullmatch(r"[\w.+-]+", algorithm):
            raise InputError(f"{algorithm!r} cannot be a folder's name: use letters, digits, - _ .")
        if (exdata / algorithm).exists():
            raise InputError(f"{exdata / algorithm} is there already: choose another folder")
        yield from _observed(list(runs), exdata, algorithm)


def _observed(jobs: list[Job], exdata: Path, algorithm: str) -> Iterator[Record]:
    coco = cocoex()
    exdata.mkdir(parents=True, exist_ok=True)
    level = coco.log_level("warning")
    try:
        instances = sorted({job.surface["instance"] for job in jobs})
        suite = coco.Suite("bbob", f"instances: {','.join(map(str, instances))}", "")
        observer = coco.Observer(
            "bbob",
            f'outer_folder: "{exdata}" result_folder: {algorithm} algorithm_name: {algorithm}',
        )
        for job in jobs:
            yield _watched(job, suite, observer)
    finally:
        coco.log_level(level)


def _watched(job: Job, suite: Any, observer: Any) -> Record:
    dim, function, instance, _ = _place(job)
    plain = bbob(function, dim, instance)
    problem = suite.get_problem_by_function_dimension_instance(function, dim, instance)
    try:
        problem.observe_with(observer)
        watched = Bbob(
            function, dim, instance, plain.minimum, lambda x: np.array([problem(row) for row in x])
        )
        record = run(job, watched)
        counted, best = problem.evaluations, problem.best_observed_fvalue1
    finally:
        problem.free()  # COCO ends the process if another is watched before
    if (counted, best) != (record.evaluations, record.cost):
        raise SearchError(
            f"{job.algorithm} on {plain.name}: COCO counts {counted} evaluations and {best} as "
            f"the best value, the record says {record.evaluations} and {record.cost}"
        )
    return record


def _place(job: Job) -> tuple[int, int, int, int]:
    """Where a job stands in the suite's order."""
    spec = job.surface
    if "bbob" not in spec:
        raise InputError(f"{job.problem} is no function of the BBOB suite: COCO cannot watch it")
    return spec["dim"], spec["bbob"], spec["instance"], job.repeat


def postprocess(folder: Path) -> Path:
    """COCO's own pages (tables, ECDF pictures) of everything observed in a folder.

    It takes COCO some seconds for a few functions, minutes for the suite. It asks its archive of
    published data what there is, once, and goes on without where there is no network.

    Args:
        folder: What `observe` wrote to; the pages go to `folder/ppdata`.

    Returns:
        The page to begin with.

    Raises:
        InputError: nothing was observed there, cocopp is not installed, or it fails.
    """
    names = sorted({p.parent.name for p in (folder / "exdata").glob("*/*.info")})
    if not names:
        raise InputError(f"{folder} holds nothing that COCO has observed")
    if not all(importlib.util.find_spec(needed) for needed in ("cocopp", "six")):
        raise InputError("cocopp is not installed: pip install 'stribeck[bench]'")
    command = [sys.executable, "-m", "cocopp", "--no-interactive", "-o", "ppdata"]
    process = subprocess.run(  # noqa: S603 - our own Python
        [*command, *(f"exdata/{name}" for name in names)],
        cwd=folder,
        env=os.environ | {"MPLBACKEND": "Agg"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    page = folder / "ppdata" / "index.html"
    if process.returncode or not page.exists():
        lines = (process.stderr or process.stdout).strip().splitlines() or ["no word"]
        raise InputError(f"cocopp fails on {folder}: {lines[-1]}")
    return page
