"""The least misfit that pycma finds on the cost of a servo's law, beside what `identify` ends at.

    python benchmarks/foreign_minima.py [m1|...|m6] [--seeds 6] [--evaluations 12000] [--further]

The cost is that of `identify` with `loss="absolute"`: a pseudo-Huber loss of the errors of 16 logs
(benchmarks/nested_laws.py), over the unit cube of the search ranges. pycma starts anywhere in it on
the samples that a search takes, and goes on from there on all samples, with a knee so low that the
loss is the mean absolute error. With `--further` it goes on from the least of these answers, on all
samples. Nothing of stribeck's own search or descent has a part in it. Each answer goes to
foreign_minima.json at once; an interrupted run continues there.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import cma
import numpy as np

from axis_servo import LAWS
from nested_laws import axis
from stribeck.identify.problem import MotionProblem, problem
from stribeck.report.table import Table
from stribeck.space import Array

FILE = Path(__file__).with_name("foreign_minima.json")
#: First standard deviations: of the search, and of what follows on all samples.
WIDE, NEAR = 0.3, 0.02
#: The share of the evaluations that is kept for all samples.
LAST = 0.25
#: The key of what goes on from the least answer.
FURTHER = "further"


def least(law: str, seed: int, evaluations: int) -> dict[str, Any]:
    """What pycma ends at from one seed."""
    rig, logs, _ = axis("xl330")
    whole = problem(logs, rig=rig, law=LAWS[law], loss="absolute")
    used = time.process_time()
    start = np.random.default_rng(seed).random(whole.space.dim)
    last = int(LAST * evaluations)
    u = _minimum(whole.thinned(), start, WIDE, seed + 1, evaluations - last)
    return _answer(whole.finer(), u, seed, last) | {
        "evaluations": evaluations, "processor_seconds": time.process_time() - used,
    }  # fmt: skip


def further(law: str, start: dict[str, float], evaluations: int) -> dict[str, Any]:
    """What pycma ends at from one of its answers, on all samples."""
    rig, logs, _ = axis("xl330")
    whole = problem(logs, rig=rig, law=LAWS[law], loss="absolute")
    used = time.process_time()
    (u,) = whole.space.encode(np.array([[start[name] for name in whole.space.names]]))
    return _answer(whole.finer(), u, 0, evaluations) | {
        "evaluations": evaluations, "processor_seconds": time.process_time() - used,
    }  # fmt: skip


def _answer(cost: MotionProblem, u: Array, seed: int, rows: int) -> dict[str, Any]:
    x = cost.space.decode(_minimum(cost, u, NEAR, seed + 1, rows)[None])[0]
    return {
        "error": cost.reported(x), "x": dict(zip(cost.space.names, x.tolist(), strict=True)),
    }  # fmt: skip


def _minimum(cost: MotionProblem, u: Array, deviation: float, seed: int, rows: int) -> Array:
    """The best point of a CMA-ES from a point of the unit cube; what cannot be run counts most."""
    strategy = cma.CMAEvolutionStrategy(
        u, deviation,
        {"bounds": [0.0, 1.0], "seed": seed, "maxfevals": rows, "verbose": -9, "popsize": 24,
         "tolfun": 1e-6, "tolflatfitness": 20},
    )  # fmt: skip
    while not strategy.stop():
        points = strategy.ask()
        costs = cost(cost.space.decode(np.clip(points, 0.0, 1.0)))
        strategy.tell(points, np.where(np.isfinite(costs), costs, 1e9).tolist())
    best: Array = np.clip(strategy.result.xbest, 0.0, 1.0)
    return best


def table(results: dict[str, Any]) -> str:
    """A row for each law: where pycma ended by seed, and the least that `identify` ended at."""
    kept = json.loads(FILE.with_name("nested_laws.json").read_text(encoding="utf-8"))
    rows: dict[str, list[float]] = {}
    for key in sorted(results):
        if not key.endswith(FURTHER):
            rows.setdefault(key.split("/")[0], []).append(results[key]["error"])
    beyond = {law: results.get(f"{law}/{FURTHER}", {}).get("error") for law in rows}
    return Table.of_texts(
        "XL330, 16 logs: mean absolute error where pycma ends, by seed / mrad",
        ("law", "pycma by seed", "least", "further", "`identify`, least by seed"),
        (
            (
                law,
                ", ".join(f"{error:.2f}" for error in errors),
                f"{min(errors):.2f}",
                "" if beyond[law] is None else f"{beyond[law]:.2f}",
                f"{min(r['error'] for k, r in kept.items() if _same(k, law)):.2f}",
            )
            for law, errors in rows.items()
        ),
        labels=range(2),
    ).text()


def _same(key: str, law: str) -> bool:
    return key.startswith(f"xl330/absolute/{law}/") and not key.endswith("intervals")


def _kept() -> dict[str, Any]:
    return dict(json.loads(FILE.read_text(encoding="utf-8"))) if FILE.exists() else {}


def _keep(key: str, row: dict[str, Any]) -> None:
    FILE.write_text(json.dumps(_kept() | {key: row}, indent=1) + "\n", encoding="utf-8")
    print(key, f"{row['error']:.2f}", flush=True)


def _of(law: str) -> list[dict[str, Any]]:
    return [row for key, row in _kept().items() if key.startswith(f"{law}/")]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("laws", nargs="*", default=["m4"])
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--evaluations", type=int, default=12_000)
    parser.add_argument("--further", action="store_true", help="go on from the least answer")
    parser.add_argument("--show", action="store_true", help="what is kept, and nothing new")
    chosen = parser.parse_args()
    for name in [] if chosen.show else chosen.laws:
        for number in range(chosen.seeds):
            if (key := f"{name}/{number}") not in _kept():
                _keep(key, least(name, number, chosen.evaluations))
        if chosen.further:
            start = min(_of(name), key=lambda row: row["error"])["x"]
            _keep(f"{name}/{FURTHER}", further(name, start, chosen.evaluations))
    print(table(_kept()))
