"""Slides that creep: what a simulated second takes, beside the stepper that ends steps at samples.

    python benchmarks/creeping.py [--sets 20] [--show]

Parameter sets are drawn from the ranges of each law, the log is the demo's, up and down: 122 s at
100 Hz. Both take the same sets in one run, on one thread; errors are distances from the motion with
a hundredth of the tolerance. Results go to creeping.json.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from stribeck.friction import law_named
from stribeck.report.table import Table
from stribeck.rig.motion.drives import SLIDE
from stribeck.rig.motion.implicit import motions
from stribeck.rig.motion.stiff_slide import trajectories
from stribeck.rig.slide_bed import SLIDE_BED, with_inputs
from stribeck.rig.twin import TestBed
from stribeck.space import Array

FILE = Path(__file__).with_name("creeping.json")
LAWS = ("makkar", "stribeck-smooth", "dahl", "lugre", "elasto-plastic", "maxwell-slip", "gms")


def timed(work: Callable[[], tuple[Array, ...]]) -> tuple[tuple[Array, ...], float]:
    """What some work returns, and the processor seconds of a second run of it."""
    work()
    start = time.process_time()
    result = work()
    return result, time.process_time() - start


def distances(x: Array, exact: Array) -> dict[str, float]:
    """Median and greatest distance of motions, mm RMS."""
    off = 1e3 * np.sqrt(np.mean((x - exact) ** 2, axis=1))
    return {"median": float(np.nanmedian(off)), "worst": float(np.nanmax(off))}


def measured(sets: int) -> dict[str, Any]:
    """Times, µs a simulated second, and errors, by law."""
    log = TestBed(loop="ideal").run("both").recording
    n = len(log)
    track = SLIDE_BED.track(log, slice(0, n), float(log.position[:50].mean()), np.ones(n))
    seconds, rows = float(track.t[-1] - track.t[0]), {}
    for name in LAWS:
        law = law_named(name)
        p = SLIDE_BED.sample(law, np.random.default_rng(1), sets)
        laws, c = SLIDE_BED.split(law, p)
        inputs, step, tolerance = with_inputs(track), SLIDE_BED["step"], SLIDE_BED["tolerance"]
        (stepped, _, _), before = timed(
            partial(motions, law, SLIDE, laws, c, inputs, step, tolerance)
        )
        (x, _), now = timed(partial(trajectories, law, laws, c, track))
        exact = trajectories(law, laws, c, track, 1e-2)[0]
        rows[name] = {
            "stepper_us": 1e6 * before / sets / seconds,
            "us": 1e6 * now / sets / seconds,
            "stepper_mm": distances(stepped, exact),
            "mm": distances(x, exact),
        }
        print(name, rows[name], flush=True)
    return {"sets": sets, "seconds": seconds, "laws": rows}


def table(results: dict[str, Any]) -> str:
    """Times and errors side by side."""
    lines = [
        (
            law,
            f"{row['stepper_us']:.1f}",
            f"{row['us']:.1f}",
            f"{row['stepper_us'] / row['us']:.0f}",
            *(f"{row[k][m]:.0e}" for k in ("stepper_mm", "mm") for m in ("median", "worst")),
        )
        for law, row in results["laws"].items()
    ]
    heads = ("law", "stepper", "now", "ratio", "error / mm", "worst", "error now / mm", "worst")
    title = f"A simulated second, processor µs; {results['sets']} sets each"
    return Table.of_texts(title, heads, lines, labels=range(1)).text()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=20)
    parser.add_argument("--show", action="store_true", help="what is kept, and nothing new")
    chosen = parser.parse_args()
    if not chosen.show:
        os.environ.setdefault("OMP_NUM_THREADS", "1")
        FILE.write_text(json.dumps(measured(chosen.sets), indent=1) + "\n", encoding="utf-8")
    print(table(json.loads(FILE.read_text(encoding="utf-8"))))
