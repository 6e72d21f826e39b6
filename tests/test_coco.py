"""The BBOB functions, and COCO's own files and pages of our runs."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck.bench.bbob import DIMENSIONS, FUNCTIONS, GROUPS, bbob
from stribeck.bench.coco import observe, postprocess
from stribeck.bench.problems import problem
from stribeck.bench.record import Job, Record
from stribeck.bench.run import run
from stribeck.errors import InputError

cocoex = pytest.importorskip("cocoex", reason="coco-experiment is not installed")


def points(dim: int, n: int = 40) -> np.ndarray:
    return np.random.default_rng(dim).uniform(-5, 5, (n, dim))


@pytest.fixture(scope="module")
def suite() -> Any:
    return cocoex.Suite("bbob", "instances: 1-3,71", "")


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize(("dim", "instance"), [(2, 1), (3, 71), (10, 2), (40, 3)])
def test_the_values_are_the_suites(suite: Any, function: int, dim: int, instance: int) -> None:
    ours = bbob(function, dim, instance)
    theirs = suite.get_problem_by_function_dimension_instance(function, dim, instance)
    x = np.vstack([points(dim), 7 * np.ones(dim), np.full(dim, -5.0)])
    assert np.array_equal(ours(x), [theirs(row) for row in x])
    assert (ours.space.lower == theirs.lower_bounds).all()
    assert (ours.space.upper == theirs.upper_bounds).all()
    theirs.free()


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("dim", [2, 5, 20])
def test_the_minimum_is_taken_in_the_box_and_nowhere_undercut(function: int, dim: int) -> None:
    ours = bbob(function, dim, 4)
    at = np.array([cocoex.BareProblem("bbob", function, dim, 4).best_parameter()])
    assert (np.abs(at) <= 5).all()
    assert ours(at)[0] == ours.minimum
    neighbours = (
        at + np.random.default_rng(0).normal(0, 1, (300, dim)) * np.logspace(-8, 0.5, 300)[:, None]
    )
    assert ours(np.clip(neighbours, -5, 5)).min() >= ours.minimum
    assert ours.J_min == ours.minimum + 1e-8


@pytest.mark.parametrize("dim", DIMENSIONS)
def test_the_first_is_a_sphere(dim: int) -> None:
    """f1(x) = |x - x_opt|^2 + f_opt, x_opt in [-4, 4] (RR-6829): four points give its centre."""
    sphere = bbob(1, dim, 7)
    step = np.eye(dim)
    centre = (sphere(-step) - sphere(step)) / 4
    assert (np.abs(centre) <= 4).all()
    x = points(dim)
    closed = ((x - centre) ** 2).sum(axis=1) + sphere.minimum
    assert sphere(x) == pytest.approx(closed, rel=1e-12, abs=1e-9)


def test_the_fifth_is_linear_between_the_bounds() -> None:
    """f5 is a slope of 10**(i / (D - 1)) along x_i, down to a corner of the box (RR-6829)."""
    slope = bbob(5, 5, 3)
    x = np.vstack([np.zeros(5), np.eye(5)])
    falls = np.diff(slope(x)[[0, 1]])[0], *(slope(x)[2:] - slope(x)[0])
    assert np.abs(falls) == pytest.approx(10 ** (np.arange(5) / 4), rel=1e-9)
    corner = -5 * np.sign([falls])
    assert slope(corner)[0] == pytest.approx(slope.minimum, abs=1e-9)


@given(
    function=st.sampled_from(sorted(FUNCTIONS)),
    rows=st.lists(st.integers(0, 39), min_size=1, max_size=12),
)
@settings(max_examples=60)
def test_rows_are_independent(function: int, rows: list[int]) -> None:
    ours, x = bbob(function, 3, 1), points(3)
    assert np.array_equal(ours(x[rows]), ours(x)[rows])
    assert np.array_equal(ours(np.asfortranarray(x)), ours(x))


def test_instances_and_dimensions_differ() -> None:
    values = {bbob(f, d, i)(np.ones((1, d)))[0] for f, d, i in product((1, 15), (2, 3), (1, 2))}
    assert len(values) == 8


@pytest.mark.parametrize(
    ("spec", "says"),
    [
        ((0, 2, 1), "BBOB has no function 0: it has 1 to 24"),
        ((25, 2, 1), "BBOB has no function 25"),
        ((1.5, 2, 1), "BBOB has no function 1.5"),
        ((1, 4, 1), "BBOB has no dimension 4: it has 2, 3, 5, 10, 20, 40"),
        ((1, 2, 0), "BBOB has no instance 0"),
        ((1, 2, "1"), "BBOB has no instance '1'"),
    ],
)
def test_what_the_suite_does_not_have_is_refused(spec: tuple[int, int, int], says: str) -> None:
    with pytest.raises(InputError) as error:
        bbob(*spec)
    assert str(error.value).startswith(says)


def test_a_missing_suite_is_said_with_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cocoex", None)
    with pytest.raises(InputError, match=r"pip install 'stribeck\[bench\]'"):
        bbob(1, 2, 1)


def test_the_functions_are_grouped_as_published() -> None:
    sizes = [sum(f.group == group for f in FUNCTIONS.values()) for group in GROUPS]
    assert sizes == [5, 4, 5, 5, 5]
    for number, title in [(1, "Sphere"), (8, "Rosenbrock"), (13, "Sharp ridge"), (23, "Katsuura")]:
        assert FUNCTIONS[number].title == title


def jobs(algorithm: str, *, repeats: int = 1, budget: int = 150) -> Iterator[Job]:
    """Jobs in an order unlike COCO's."""
    for function, dim, instance, repeat in product((8, 1), (3, 2), (2, 1), range(repeats)):
        cost = bbob(function, dim, instance)
        yield Job(
            problem=f"f{function:02d}-d{dim}-i{instance}",
            algorithm=algorithm,
            repeat=repeat,
            seed=1,
            budget=budget + function,
            target=cost.J_min,
            minimum=cost.minimum,
            surface={"bbob": function, "dim": dim, "instance": instance},
            method={"name": algorithm, "settings": {}},
        )


@pytest.fixture(scope="module")
def watched(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Record]]:
    folder = tmp_path_factory.mktemp("a place")
    all_jobs = [*jobs("dual-annealing"), *jobs("random", repeats=2)]
    return folder, list(observe(all_jobs, folder))


def test_observed_runs_are_the_runs(watched: tuple[Path, list[Record]]) -> None:
    _, records = watched
    assert len(records) == 8 + 16
    assert {r.ended for r in records} == {"target", "budget"}
    assert [r.content for r in records] == [run(r.job).content for r in records]


def trials(folder: Path, algorithm: str) -> dict[tuple[int, int], list[list[str]]]:
    """The last line of each trial of COCO's files, by function and dimension."""
    last_lines = {}
    for function, dim in product((1, 8), (2, 3)):
        path = folder / "exdata" / algorithm / f"data_f{function}"
        text = (path / f"bbobexp_f{function}_DIM{dim}.tdat").read_text()
        lines = text.splitlines()
        heads = [i for i, line in enumerate(lines) if line.startswith("%")]
        ends = [*heads[1:], len(lines)]
        last_lines[function, dim] = [lines[end - 1].split() for end in ends]
    return last_lines


def test_coco_writes_what_we_counted(watched: tuple[Path, list[Record]]) -> None:
    folder, records = watched
    for algorithm in ("dual-annealing", "random"):
        written = trials(folder, algorithm)
        for (function, dim), lines in written.items():
            ours = [
                r
                for r in records
                if r.job.algorithm == algorithm
                and (r.job.surface["bbob"], r.job.surface["dim"]) == (function, dim)
            ]
            assert [int(line[0]) for line in lines] == [r.evaluations for r in ours]
            precision = [r.cost - (r.job.minimum or 0.0) for r in ours]
            assert [float(line[2]) for line in lines] == pytest.approx(precision, rel=1e-8)


@pytest.mark.skipif(
    not all(map(importlib.util.find_spec, ("cocopp", "six"))), reason="cocopp is not installed"
)
def test_coco_makes_its_pages(tmp_path: Path) -> None:
    spheres = [j for j in jobs("random") if (j.surface["bbob"], j.surface["dim"]) == (1, 2)]
    list(observe(spheres, tmp_path))
    page = postprocess(tmp_path)
    assert page == tmp_path / "ppdata" / "index.html"
    pictures = {p.name for p in (tmp_path / "ppdata").rglob("pprldmany*.svg")}
    assert "pprldmany_f001.svg" in pictures


def test_what_cannot_be_observed_is_refused(
    watched: tuple[Path, list[Record]], tmp_path: Path
) -> None:
    folder, records = watched
    with pytest.raises(InputError, match="dual-annealing is there already: choose another folder"):
        list(observe([records[0].job], folder))
    job = next(jobs("random"))
    changed = Job.parse(job.text.replace('"bbob":8', '"surface":"BF"'))
    with pytest.raises(InputError, match="is no function of the BBOB suite"):
        list(observe([changed], tmp_path))
    named = Job.parse(job.text.replace('"algorithm":"random"', '"algorithm":"a/b"'))
    with pytest.raises(InputError, match="'a/b' cannot be a folder's name"):
        list(observe([named], tmp_path))
    with pytest.raises(InputError, match="holds nothing that COCO has observed"):
        postprocess(tmp_path)


def test_a_job_finds_it_by_its_table() -> None:
    cost = problem({"bbob": 15, "dim": 3, "instance": 2})
    assert np.array_equal(cost(points(3)), bbob(15, 3, 2)(points(3)))
    assert (cost.name, cost.minimum) == ("f15-d3-i2", bbob(15, 3, 2).minimum)
