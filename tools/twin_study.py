"""Recovery of the twin by `bts`: twenty seeds a direction, the paper's settings (section 4.4).

    python tools/twin_study.py [SEEDS]

Two endings: the paper's (J < 4.5 mm or 1000 rounds), and 1000 rounds whatever J is. Writes the
distributions of J and of evaluations, and how far each parameter ends from the truth, to
docs/data/twin_study.json.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

from stribeck.bench.problems import PAPER_TARGET
from stribeck.identify.problem import MotionProblem, problem
from stribeck.optimize import Run, Search, Target, configure, lockstep
from stribeck.rig.slide_bed import PUBLISHED
from stribeck.rig.twin import TestBed

OUT = Path("docs/data/twin_study.json")
TRAIN = {"right": "112:295", "left": "325:127"}


def main() -> None:
    """Run the study and write its table."""
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    log = TestBed().run("both", seed=1).recording
    study: dict[str, object] = {"command": f"python tools/twin_study.py {seeds}", "seeds": seeds}
    for side, train in TRAIN.items():
        cost = problem(log, rig="slide-bed", law="stribeck", train=train)
        truth = PUBLISHED[side][[0, 1, 2, 3, 5]]
        ended = {}
        for name, stops in (
            ("J < 4.5 or 1000 rounds", [Target(PAPER_TARGET)]),
            ("1000 rounds", []),
        ):
            searches = [
                Search(cost.space, configure("bts"), budget=10**6, seed=s, stops=stops)
                for s in range(seeds)
            ]
            ended[name] = _summary(lockstep(cost, searches), cost, truth)
            print(side, name, json.dumps(ended[name], indent=1), flush=True)
        study[side] = {"train": train, "J_at_truth": float(cost(truth[None])[0]), "endings": ended}
    OUT.write_text(json.dumps(study, indent=1) + "\n")


def _summary(runs: list[Run], cost: MotionProblem, truth: np.ndarray) -> dict[str, object]:
    J = np.array([r.cost for r in runs])
    off = np.array([r.x / truth - 1 for r in runs])
    return {
        "below_4.5": int((J < PAPER_TARGET).sum()),
        "J_mm": _spread(J),
        "evaluations": _spread(np.array([r.evaluations for r in runs])),
        "evaluations_to_4.5": _spread(np.array([r.trace.reached(PAPER_TARGET) for r in runs])),
        "off_from_truth_percent": {
            name: _spread(100 * off[:, k]) for k, name in enumerate(cost.space.names)
        },
    }


def _spread(values: np.ndarray) -> dict[str, float]:
    low, quarter, middle, three, high = np.quantile(
        np.asarray(values, dtype=float), [0, 0.25, 0.5, 0.75, 1]
    )
    named = {"min": low, "q25": quarter, "median": middle, "q75": three, "max": high}
    return {n: float(f"{v:.5g}") for n, v in named.items()}


if __name__ == "__main__":
    main()
