"""Motions of random axes on the rigs that are stepped, to compare two versions of the code.

    python benchmarks/rig_motions.py OUT.npz [--compare OTHER.npz]

812 axes: a servo with a pendulum on eight recordings (read from `../shared/data`), a joint with
each way to hold its torque, bristles below breakaway, EMPS in its closed loop. Run it on either
version; `--compare` tells the greatest difference of each kind of axis, m or rad.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from stribeck import RIGS, Recording, read
from stribeck.friction import law_named
from stribeck.rig.rig import Rig
from stribeck.space import Array

DATA = Path(__file__).parents[2] / "shared" / "data"


def motions() -> dict[str, Array]:
    """Positions by kind of axis, (n, N) each."""
    rng, out = np.random.default_rng(1), {}

    def add(key: str, rig: Rig, name: str, log: Recording, n: int) -> None:
        law = law_named(name)
        p = rig.sample(law, rng, 4 * n)
        p = p[np.asarray(law.physical(p[:, : len(law.params)]), dtype=bool)][:n]
        out[f"{key} {name}"] = rig.simulate(law, p, log).position

    servo = RIGS["servo-pendulum"]
    files = sorted((DATA / "bam_xl330" / "logs").glob("*.json"))
    logs = [read(file, columns=dict(servo.columns)) for file in files[:8]]
    for i, log in enumerate(logs):
        for name in ("coulomb-viscous", "bam-m3", "bam-m6"):
            add(f"servo {i}", servo, name, log, 20)
    for hold in (0, 1, 2):
        for name in ("stribeck", "coulomb-viscous"):
            add(f"joint {hold}", RIGS["joint"].set(hold=hold, limit=20), name, logs[0], 40)
    t = np.arange(0.0, 3.0, 1e-3)
    force = 20 * np.sin(2 * t) + 5 * np.sin(17 * t)
    pushed = Recording(t=t, position=np.zeros(len(t)), force=force)
    for name in ("dahl", "lugre", "maxwell-slip:2", "stribeck"):
        add("presliding", RIGS["presliding"], name, pushed, 20)
    emps = RIGS["emps"]
    log = read(DATA / "emps" / "DATA_EMPS.mat", columns=dict(emps.columns))
    for name, levels in (("coulomb-viscous", (20.0, 200.0)), ("stribeck", (25.0, 20.0, 200.0))):
        law = law_named(name)
        p = emps.sample(law, np.random.default_rng(0), 1)[0]
        p[: len(levels)], p[len(law.params) :] = levels, (95.0, -3.0)
        rows = p * rng.uniform(0.8, 1.2, (6, len(p)))
        out[f"emps {name}"] = emps.simulate(law, rows, log).position
    return out


def main() -> None:
    """Simulate, write, and compare."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--compare", type=Path)
    chosen = parser.parse_args()
    now = motions()
    named: dict[str, Any] = dict(now)
    np.savez(chosen.out, **named)
    print(f"{sum(len(x) for x in now.values())} axes in {chosen.out}")
    if chosen.compare is None:
        return
    then = np.load(chosen.compare)
    for key, x in now.items():
        both = np.isfinite(x) & np.isfinite(then[key])
        print(f"{key:24}  {np.abs(x - then[key])[both].max():.1e}  of  {np.abs(x[both]).max():.3g}")


if __name__ == "__main__":
    main()
