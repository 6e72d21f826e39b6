"""The cost of a method itself: time per evaluation on an almost free cost, in 5-D.

The sphere, at each method's default population. The time of as many calls of the sphere alone, with
as many points, is subtracted. Rounds are interleaved: a busy moment of the machine hits all.
"""

from __future__ import annotations

import importlib
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from stribeck.optimize import METHODS, Search, configure, lockstep
from stribeck.space import Array, Space, box

DIM, BUDGET, ROUNDS = 5, 20_000, 9
#: The sphere's minimum: off the middle, inside the box [-5, 5].
AT = np.array([1.3, -2.1, 0.7, 3.2, -0.4])
BOUNDS = [(-5.0, 5.0)] * DIM
#: Goals, us an evaluation.
GOALS = {"bts": 2.0, "ats": 2.0, "abfo": 2.0, "bfo": 2.0, "ga": 2.0, "mbts": 10.0}


class Sphere:
    """A cost of next to nothing that counts its calls and their rows."""

    name = "sphere"

    def __init__(self) -> None:
        self.calls = self.rows = 0

    @property
    def space(self) -> Space:
        """The box."""
        return box(BOUNDS)

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) points to (n,) costs."""
        self.calls += 1
        self.rows += len(x)
        cost: Array = ((x - AT) ** 2).sum(axis=1)
        return cost

    def value(self, x: Array) -> float:
        """(dim,) point to its cost."""
        self.calls += 1
        self.rows += 1
        return float(((x - AT) ** 2).sum())


class Residuals(Sphere):
    """The sphere as a problem of least squares."""

    def __call__(self, x: Array, /) -> Array:
        """(n, dim) points to (n,) costs."""
        root: Array = np.sqrt(super().__call__(x) / DIM)
        return root

    def residuals(self, x: Array, /) -> Array:
        """(n, dim) points to (n, dim) residuals, whose root mean square is the cost."""
        self.calls += 1
        self.rows += len(x)
        off: Array = x - AT
        return off


#: Minimises a sphere within a budget, with a seed.
Contestant = Callable[[Sphere, int, int], None]


def _ours(method: str) -> Contestant:
    def run(sphere: Sphere, budget: int, seed: int) -> None:
        lockstep(sphere, [Search(sphere.space, configure(method), budget=budget, seed=seed)])

    return run


def _scipy_de(sphere: Sphere, budget: int, seed: int) -> None:
    optimize = importlib.import_module("scipy.optimize")
    generations = budget // (15 * DIM) - 1
    optimize.differential_evolution(
        sphere.value, BOUNDS, maxiter=generations, tol=0.0, polish=False, rng=seed
    )


def _dual_annealing(sphere: Sphere, budget: int, seed: int) -> None:
    optimize = importlib.import_module("scipy.optimize")
    optimize.dual_annealing(sphere.value, BOUNDS, maxiter=budget, maxfun=budget, rng=seed)


def _pycma(sphere: Sphere, budget: int, seed: int) -> None:
    cma = importlib.import_module("cma")
    options = {"bounds": [-5.0, 5.0], "verbose": -9, "verb_log": 0, "signals_filename": None}
    rng = np.random.default_rng(seed)
    while sphere.rows < budget:
        settings = options | {
            "maxfevals": budget - sphere.rows,
            "seed": int(rng.integers(1, 2**31)),
        }
        cma.fmin2(sphere.value, rng.uniform(-5.0, 5.0, DIM), 2.5, settings)


def _niapy_bfo(sphere: Sphere, budget: int, seed: int) -> None:
    bfo = importlib.import_module("niapy.algorithms.basic.bfo")
    core, task = importlib.import_module("niapy.problems"), importlib.import_module("niapy.task")
    kind = type("Counted", (core.Problem,), {"_evaluate": lambda _, x: sphere.value(x)})
    swarm = bfo.BacterialForagingOptimization(seed=seed)
    swarm.run(task.Task(kind(dimension=DIM, lower=-5.0, upper=5.0), max_evals=budget))


def _pymoo(module: str, name: str) -> Contestant:
    def run(sphere: Sphere, budget: int, seed: int) -> None:
        kind = getattr(importlib.import_module(f"pymoo.algorithms.soo.nonconvex.{module}"), name)
        core = importlib.import_module("pymoo.core.problem").Problem
        optimize = importlib.import_module("pymoo.optimize")

        def evaluate(_: Any, x: Array, out: dict[str, Array], *__: Any, **___: Any) -> None:
            out["F"] = sphere(x)[:, None]

        counted = type("Counted", (core,), {"_evaluate": evaluate})
        problem = counted(n_var=DIM, n_obj=1, xl=-5.0, xu=5.0)
        optimize.minimize(problem, kind(), ("n_eval", budget), seed=seed)

    return run


CONTESTANTS: dict[str, tuple[Contestant, type[Sphere]]] = {
    **{name: (_ours(name), Sphere) for name in METHODS},
    "mbts, on residuals": (_ours("mbts"), Residuals),
    "scipy differential_evolution": (_scipy_de, Sphere),
    "scipy dual_annealing": (_dual_annealing, Sphere),
    "pycma": (_pycma, Sphere),
    "NiaPy BFO": (_niapy_bfo, Sphere),
    "pymoo GA": (_pymoo("ga", "GA"), Sphere),
    "pymoo DE": (_pymoo("de", "DE"), Sphere),
}


def measure(quick: bool = False) -> dict[str, Any]:
    """Time every method, in rounds.

    Args:
        quick: Three rounds of 5,000 evaluations.
    """
    rounds, budget = (3, 5_000) if quick else (ROUNDS, BUDGET)
    results: dict[str, Any] = {name: {"us": []} for name in CONTESTANTS}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # theirs, of the sphere being solved
        for name in CONTESTANTS:
            _timed(name, budget // 10, 0)  # what is imported and compiled
        for seed in range(1, rounds + 1):
            for name in CONTESTANTS:
                seconds, sphere = _timed(name, budget, seed)
                results[name]["us"].append(1e6 * seconds / sphere.rows)
                results[name]["rows_a_call"] = sphere.rows / sphere.calls
                results[name]["evaluations"] = sphere.rows
    return {"dim": DIM, "budget": budget, "rounds": rounds, "methods": results}


def _timed(name: str, budget: int, seed: int) -> tuple[float, Sphere]:
    """Seconds of a run without those of its calls of the sphere, and the sphere."""
    run, kind = CONTESTANTS[name]
    sphere = kind()
    start_time = time.perf_counter()
    run(sphere, budget, seed)
    seconds = time.perf_counter() - start_time
    return seconds - _called(sphere), sphere


def _called(sphere: Sphere) -> float:
    """Seconds of as many calls of the sphere alone, with as many rows each."""
    calls, rows = sphere.calls, sphere.rows
    alone, x = type(sphere)(), np.zeros((max(round(rows / calls), 1), DIM))
    start_time = time.perf_counter()
    if rows == calls:
        for _ in range(calls):
            alone.value(x[0])
    else:
        for _ in range(calls):
            alone(x)
    return time.perf_counter() - start_time


def tables(results: dict[str, Any]) -> list[str]:
    """Microseconds per evaluation, in Markdown."""
    from stribeck.report.table import Cell, Table  # noqa: PLC0415 - slow, and not timed

    rows = []
    for name, row in results["methods"].items():
        least, middle = min(row["us"]), float(np.median(row["us"]))
        goal = GOALS.get(name)
        met = "" if goal is None else f"at most {goal:g}: {'met' if least <= goal else 'missed'}"
        rows.append((
            Cell.label(name),
            Cell.number(least, 2),
            Cell.number(middle, 2),
            Cell.number(row["rows_a_call"], 3),
            Cell(met, met or None),
        ))  # fmt: skip
    table = Table(
        f"The optimizer's own cost, µs per evaluation: the sphere in {results['dim']}-D, "
        f"{results['budget']:,} evaluations, {results['rounds']} interleaved runs",
        ("who", "least", "median", "points a call", "goal"),
        tuple(rows),
        "The cost of calling the sphere is subtracted. Goals are held against the least: what else "
        "runs on the machine can only make a run longer.",
    )
    return [table.markdown()]
