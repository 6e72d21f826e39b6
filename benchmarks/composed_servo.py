"""A torque-controlled servo as an axis of parts: its fit, and weights that it has not seen.

    python benchmarks/composed_servo.py [--show] [--laws coulomb-viscous,bam-m3] [--seeds 1]

Twelve recordings of a Unitree Go1 motor with a pendulum of 0, 1 and 2 kg, read from
`../shared/data/go1`, on the rig of docs/rigs/go1.toml. Beside each law stand the parameters that
the recordings' own laboratory published, which were fitted on all three weights and a fourth. Each
answer goes to composed_servo.json at once; an interrupted run continues there.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np

from stribeck import read
from stribeck.data.recording import Recording
from stribeck.friction import law_named
from stribeck.identify.multistart import multistart
from stribeck.identify.problem import MotionProblem, problem
from stribeck.identify.search_settings import SearchSettings
from stribeck.report.table import Table
from stribeck.rig.composed import ComposedRig
from stribeck.rig.lookup import rig_named

FILE = Path(__file__).with_name("composed_servo.json")
RIG = Path(__file__).parents[1] / "docs" / "rigs" / "go1.toml"
DATA = Path(__file__).parents[2] / "shared" / "data" / "go1"
#: Model m1 as published (rimim/bam, commit 38071b1), fitted on 0 to 3 kg.
PUBLISHED = {
    "F_C": 0.09139, "F_V": 0.04696, "gain_p": 0.9123, "gain_d": 1.0, "armature": 0.010936,
    "q_offset": -0.00294,
}  # fmt: skip
#: Weights, kg.
WEIGHTS = (0.0, 1.0, 2.0)


def rig() -> ComposedRig:
    """The rig of the file."""
    named = rig_named(str(RIG))
    assert isinstance(named, ComposedRig)  # noqa: S101 - the file has parts
    return named


def logs() -> list[Recording]:
    """All recordings."""
    columns = dict(rig().columns)
    return [read(file, columns=columns) for file in sorted(DATA.glob("*.json"))]


def errors(law: str, p: dict[str, float], recordings: list[Recording]) -> dict[float, float]:
    """Mean absolute errors of whole roll-outs by weight, mrad."""
    axis, friction = rig(), law_named(law)
    row = np.array([[p.get(q.name, q.fixed or 0.0) for q in axis.parameters(friction)]])
    by_weight: dict[float, list[np.ndarray]] = {w: [] for w in WEIGHTS}
    for log in recordings:
        motion = axis.simulate(friction, row, log)
        by_weight[float(log.extra["mass"][0])].append(np.abs(motion.position[0] - log.position))
    return {w: 1e3 * float(np.concatenate(e).mean()) for w, e in by_weight.items()}


def fitted(law: str, left_out: float | None, seed: int) -> dict[str, Any]:
    """A search on the recordings of the other weights, by absolute errors."""
    every = logs()
    training = [log for log in every if log.extra["mass"][0] != left_out]
    used = time.process_time()
    whole = problem(training, rig=rig(), law=law, loss="absolute")
    optimum = multistart(whole, SearchSettings(seed=seed))
    assert isinstance(optimum.problem, MotionProblem)  # noqa: S101 - servos start as measured
    names = [q.name for q in optimum.problem.parameters.free]
    p = dict(zip(names, optimum.x.tolist(), strict=True))
    return {
        "p": p, "errors": {str(w): e for w, e in errors(law, p, every).items()},
        "evaluations": optimum.search.evaluations, "processor_seconds": time.process_time() - used,
    }  # fmt: skip


def shown(results: dict[str, Any]) -> Table:
    """Errors by law and by what was left out, beside the published parameters'."""
    rows = [["published m1", "nothing", "", *_cells(results["published"], None)]]
    for key, result in results.items():
        if key == "published":
            continue
        law, left_out, seed = key.split("/")
        weight = None if left_out == "none" else float(left_out)
        words = "nothing" if weight is None else f"{weight:g} kg"
        rows.append([law, words, seed, *_cells(result["errors"], weight)])
    head = ["law", "left out", "seed", "0 kg", "1 kg", "2 kg", "all"]
    return Table.of_texts("Mean absolute error / mrad (* not seen in training)", head, rows,
                          labels=range(3))  # fmt: skip


def _cells(by_weight: dict[str, float], left_out: float | None) -> list[str]:
    values = [by_weight[str(w)] for w in WEIGHTS]
    marks = ["*" if w == left_out else "" for w in WEIGHTS]
    cells = [f"{v:.2f}{mark}" for v, mark in zip(values, marks, strict=True)]
    return [*cells, f"{np.mean(values):.2f}"]


def main() -> None:
    """Fit what is not there yet, and print all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--show", action="store_true", help="print what is there")
    parser.add_argument("--laws", default="coulomb-viscous,bam-m3")
    parser.add_argument("--seeds", type=int, default=1)
    chosen = parser.parse_args()
    results = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    if not chosen.show:
        tasks = [
            (law, left_out, seed)
            for law in chosen.laws.split(",")
            for left_out in (None, *WEIGHTS)
            for seed in range(chosen.seeds)
        ]
        found = errors("coulomb-viscous", PUBLISHED, logs())
        results["published"] = {str(w): e for w, e in found.items()}
        for law, left_out, seed in tasks:
            key = f"{law}/{'none' if left_out is None else f'{left_out:g}'}/{seed}"
            if key not in results:
                results[key] = fitted(law, left_out, seed)
                FILE.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    print(shown(results).text())


if __name__ == "__main__":
    main()
