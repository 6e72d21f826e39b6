"""The BBOB functions of the COCO platform, and its own data files and pages of our runs.

A function of the suite is evaluated through COCO's bare form, which takes many points at once and
gives the same bits as the suite's problems. Where COCO's data files are wanted, `observe` runs
jobs again on the suite's own problems with an observer attached, and `postprocess` hands the
files to COCO's post-processing, so that our runs stand beside the published ones.

Hansen, Auger, Ros, Mersmann, Tušar, Brockhoff (2021): COCO: a platform for comparing continuous
optimizers in a black-box setting, doi:10.1080/10556788.2020.1808977.
"""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from operator import index
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ..errors import InputError
from ..optimize import SearchError
from ..space import Array, Space, box
from .record import Job, Record
from .runner import run

#: The suite's names of its groups, in its order.
GROUPS = (
    "separable",
    "low or moderate conditioning",
    "high conditioning, unimodal",
    "multi-modal, adequate structure",
    "multi-modal, weak structure",
)
#: The suite's dimensions.
DIMENSIONS = (2, 3, 5, 10, 20, 40)
#: The instances that may be asked for: the suite makes one for every number.
INSTANCES = range(1, 10_000)
#: How far above the minimum a function counts as solved: the suite's last target.
PRECISION = 1e-8


@dataclass(frozen=True)
class Function:
    """What a function of the suite is called.

    Args:
        title: Its name.
        group: One of GROUPS.
    """

    title: str
    group: str


def _functions(*groups: tuple[str, ...]) -> dict[int, Function]:
    named = [Function(t, g) for g, titles in zip(GROUPS, groups, strict=True) for t in titles]
    return dict(enumerate(named, 1))


#: The 24 functions by their number (Finck, Hansen, Ros, Auger 2009, INRIA RR-6829).
FUNCTIONS = _functions(
    ("Sphere", "Ellipsoid", "Rastrigin", "Büche-Rastrigin", "Linear slope"),
    ("Attractive sector", "Step ellipsoid", "Rosenbrock", "Rosenbrock, rotated"),
    ("Ellipsoid, rotated", "Discus", "Bent cigar", "Sharp ridge", "Different powers"),
    (
        "Rastrigin, rotated",
        "Weierstrass",
        "Schaffers F7",
        "Schaffers F7, ill-conditioned",
        "Griewank-Rosenbrock",
    ),
    ("Schwefel", "Gallagher, 101 peaks", "Gallagher, 21 peaks", "Katsuura", "Lunacek bi-Rastrigin"),
)


@dataclass(frozen=True, eq=False)
class Bbob:
    """A function of the suite in one dimension and instance; a Problem that knows its answer.

    Args:
        function: Its number, 1 to 24.
        dim: Number of variables.
        instance: Which shift and rotation of it.
        minimum: The least value.
        evaluate: (n, dim) points to (n,) values.
    """

    function: int
    dim: int
    instance: int
    minimum: float
    evaluate: Callable[[Array], Array] = field(repr=False)

    @property
    def name(self) -> str:
        """Such as "f01-d2-i1"."""
        return f"f{self.function:02d}-d{self.dim}-i{self.instance}"

    @property
    def title(self) -> str:
        """Its name in words."""
        return FUNCTIONS[self.function].title

    @property
    def J_min(self) -> float:
        """The value at or below which it counts as solved."""
        return self.minimum + PRECISION

    @cached_property
    def space(self) -> Space:
        """The suite's region of interest, [-5, 5] in every coordinate."""
        return box([(-5.0, 5.0)] * self.dim)

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) points to (n,) values; rows are independent, bit for bit."""
        return self.evaluate(np.ascontiguousarray(x, dtype=float))


def bbob(function: int, dim: int, instance: int) -> Bbob:
    """A function of the suite.

    Args:
        function: Its number, 1 to 24: see FUNCTIONS.
        dim: One of DIMENSIONS.
        instance: Which shift and rotation of it, one of INSTANCES.

    Raises:
        InputError: there is no such function, or coco-experiment is not installed.
    """
    # COCO ends the process where it is asked for what it does not have.
    function = _one_of("function", function, FUNCTIONS, "1 to 24")
    dim = _one_of("dimension", dim, DIMENSIONS, ", ".join(map(str, DIMENSIONS)))
    instance = _one_of("instance", instance, INSTANCES, f"1 to {INSTANCES[-1]}")
    bare = _cocoex().BareProblem("bbob", function, dim, instance)
    return Bbob(function, dim, instance, float(bare.best_value()), bare)


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
    cocoex = _cocoex()
    exdata.mkdir(parents=True, exist_ok=True)
    level = cocoex.log_level("warning")
    try:
        instances = sorted({job.surface["instance"] for job in jobs})
        suite = cocoex.Suite("bbob", f"instances: {','.join(map(str, instances))}", "")
        observer = cocoex.Observer(
            "bbob",
            f'outer_folder: "{exdata}" result_folder: {algorithm} algorithm_name: {algorithm}',
        )
        for job in jobs:
            yield _watched(job, suite, observer)
    finally:
        cocoex.log_level(level)


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
    done = subprocess.run(  # noqa: S603 - our own Python
        [*command, *(f"exdata/{name}" for name in names)],
        cwd=folder,
        env=os.environ | {"MPLBACKEND": "Agg"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    page = folder / "ppdata" / "index.html"
    if done.returncode or not page.exists():
        said = (done.stderr or done.stdout).strip().splitlines() or ["no word"]
        raise InputError(f"cocopp fails on {folder}: {said[-1]}")
    return page


def _one_of(what: str, value: Any, known: Iterable[int], shown: str) -> int:
    try:
        number = index(value)
    except TypeError:
        number = -1
    if number not in known:
        raise InputError(f"BBOB has no {what} {value!r}: it has {shown}")
    return number


def _cocoex() -> ModuleType:
    try:
        return importlib.import_module("cocoex")
    except ImportError:
        raise InputError(
            "coco-experiment is not installed: pip install 'stribeck[bench]'"
        ) from None
