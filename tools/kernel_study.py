"""Differences of the fast integrator from the plain reference, over the whole search box.

Random parameter sets of the slide bed (uniform in its search ranges), both directions, the ramp
of 5 mm/s of section 4.5 for 36.6 s sampled at 100 Hz: agreement, error at looser tolerances, and
smoothness of the error, on which finite differences of the motion depend. Writes
docs/data/kernel_study.json.
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from stribeck.friction import LAWS
from stribeck.optimize.slopes import SHORT
from stribeck.rig.motion import reference
from stribeck.rig.motion.command import Drive
from stribeck.rig.motion.event_driven import trajectories
from stribeck.rig.motion.track import Track, track
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED
from stribeck.space import Array

LAW = LAWS["stribeck"]
SECONDS, RATE, SPEED = 36.6, 100, 5e-3
OUT = Path(__file__).parents[1] / "docs" / "data" / "kernel_study.json"


def spread(error: Array) -> dict[str, float]:
    """Errors in m as mm: their median, 99th percentile and worst."""
    mm = 1e3 * error
    return {
        "median_mm": float(np.median(mm)),
        "p99_mm": float(np.percentile(mm, 99)),
        "worst_mm": float(mm.max()),
    }


def study(direction: int, n: int, dt: float, coarse: Array) -> dict[str, Any]:
    """One direction: agreement over the box, and the order over a part of it."""
    t = np.arange(round(SECONDS * RATE) + 1) / RATE
    x0 = 0.112 if direction > 0 else 0.325
    stroke = track(Drive.line(0.0, x0, SECONDS, direction * SPEED), t, x0)
    p, c = SLIDE_BED.split(LAW, SLIDE_BED.sample(LAW, np.random.default_rng(2012 + direction), n))
    x, v = trajectories(LAW, p, c, stroke)
    tight, _ = trajectories(LAW, p, c, stroke, 1e-3)

    def error(k: int, step: float, against: Array) -> float:
        y, _ = reference.trajectory(LAW, p[k], c[k], stroke, step)
        return float(np.sqrt(np.mean((y - against[k]) ** 2)))

    error(0, 1e-3, x)  # compiled once, before the threads
    with ThreadPoolExecutor() as pool:
        distances = np.array(list(pool.map(lambda k: error(k, dt, x), range(n))))
        part = range(0, n, max(1, n // 50))
        medians = [
            float(np.median(list(pool.map(lambda k, s=step: error(k, s, tight), part))))
            for step in coarse
        ]
    slips = ((v[:, 1:] != 0) & (v[:, :-1] == 0)).sum(axis=1)
    return {
        "sets": n,
        "reference_step_s": dt,
        "fast_against_reference_rms": spread(distances),
        "fast_against_a_thousandth_of_its_tolerance_rms": spread(
            np.sqrt(np.mean((x - tight) ** 2, axis=1))
        ),
        "fast_against_the_same_by_tolerance": by_tolerance(p, c, stroke, tight),
        "finite_differences": differences(direction, stroke),
        "slips_a_set": {"least": int(slips.min()), "most": int(slips.max())},
        "reference_order": {
            "steps_s": coarse.tolist(),
            "median_rms_mm": [1e3 * m for m in medians],
            "order": float(np.polyfit(np.log(coarse), np.log(medians), 1)[0]),
        },
    }


def by_tolerance(p: Array, c: Array, stroke: Track, tight: Array) -> list[dict[str, float]]:
    """Error and work of the fast integrator at looser and tighter tolerances."""
    rows = []
    for tolerance in (0.1, 1.0, 3.0, 10.0):
        x, _ = trajectories(LAW, p, c, stroke, tolerance)
        error = spread(np.sqrt(np.mean((x - tight) ** 2, axis=1)))
        rows.append({"tolerance": tolerance, **error})
    return rows


def differences(direction: int, stroke: Track, n: int = 100) -> list[dict[str, float]]:
    """Relative error of a column of finite differences of the motion, by tolerance.

    Steps of least squares, from `n` sets.
    """
    params = SLIDE_BED.parameters(LAW)
    free = [k for k, q in enumerate(params) if q.fixed is None]
    sets = np.repeat(
        SLIDE_BED.sample(LAW, np.random.default_rng(99 + direction), n)[:, None],
        len(free) + 1,
        axis=1,
    )
    for i, k in enumerate(free):
        sets[:, i + 1, k] += SHORT * (params[k].upper - params[k].lower)
    p, c = SLIDE_BED.split(LAW, sets.reshape(-1, len(params)))

    def columns(tolerance: float) -> Array:
        x, _ = trajectories(LAW, p, c, stroke, tolerance)
        x = x.reshape(n, len(free) + 1, -1)
        return x[:, 1:] - x[:, :1]

    exact = columns(1e-4)
    scale = np.linalg.norm(exact, axis=2)
    rows = []
    for tolerance in (1.0, 3.0, 10.0):
        share = np.linalg.norm(columns(tolerance) - exact, axis=2) / scale
        rows.append({
            "tolerance": tolerance, "median": float(np.median(share)), "worst": float(share.max())
        })  # fmt: skip
    return rows


def printed(direction: str, steps: list[float]) -> list[dict[str, float]]:
    """The printed scheme's distance from the fast motion, for a published set, by step."""
    sign = 1 if direction == "right" else -1
    t = np.arange(round(SECONDS * RATE) + 1) / RATE
    stroke = track(Drive.line(0.0, 0.0, SECONDS, sign * SPEED), t, 0.0)
    (p,), (c,) = SLIDE_BED.split(LAW, PUBLISHED[direction])
    (x,), _ = trajectories(LAW, p[None], c[None], stroke)
    rows = []
    for dt in steps:
        row = {"step_s": dt}
        for scheme, name in (("implicit", "reference_rms_mm"), ("paper", "paper_rms_mm")):
            y, _ = reference.trajectory(LAW, p, c, stroke, dt, scheme)
            row[name] = 1e3 * float(np.sqrt(np.mean((x - y) ** 2)))
        rows.append(row)
    return rows


def main() -> None:
    """Run the study, print it and write it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--sets", type=int, default=1000, help="parameter sets a direction (1000)")
    parser.add_argument("--step", type=float, default=2e-5, help="the reference's step, s (2e-5)")
    parser.add_argument("--out", type=Path, default=OUT, help="the file to write")
    options = parser.parse_args()
    coarse = np.array([2e-4, 1e-4, 5e-5, 2.5e-5])
    steps = [1e-3, 3e-4, 1e-4, 3e-5, 1e-5]
    results = {
        "ramp": {"speed_mm_s": 1e3 * SPEED, "seconds": SECONDS, "rate_hz": RATE},
        "right": study(1, options.sets, options.step, coarse),
        "left": study(-1, options.sets, options.step, coarse),
        "published_sets": {name: printed(name, steps) for name in PUBLISHED},
    }
    text = json.dumps(results, indent=2)
    options.out.write_text(text + "\n")
    print(text)


if __name__ == "__main__":
    main()
