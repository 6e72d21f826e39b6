"""The best known J of each twin: the least of several long searches.

    python benchmarks/best_known.py [NAME ...]

For each twin: scipy's differential evolution, several seeds, to tight tolerances, each polished
by bounded least squares; least squares from the truth; least squares from the best of many random
points. The least of them is walked downhill once more without slopes (Nelder and Mead), as J has
small corners that least squares stops at. Nothing of stribeck's own searches is in it. Writes
best_known.json; with names, for these twins alone.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from typing import Any, cast

import numpy as np
from scipy.optimize import Bounds, differential_evolution, least_squares, minimize

from stribeck.identify.problem import MotionProblem
from stribeck.space import Array
from twins import FILE, Twin, twins

SEEDS, POPULATION, GENERATIONS = 3, 20, 400
RANDOM, STARTS = 2000, 12
#: Steps of the slopes, as shares of the box: small ones feel the corners, large ones the curve.
STEPS = (1e-3, 1e-4, 1e-6)
WORST = 1e3  # what costs nothing finite costs this, mm


def main() -> None:
    """Search the twins named, or all, and write their minima."""
    names = sys.argv[1:]
    minima = json.loads(FILE.read_text(encoding="utf-8"))["twins"] if FILE.exists() else {}
    for twin in twins():
        if names and twin.name not in names:
            continue
        start_time = time.perf_counter()
        minima[twin.name] = search(twin)
        minimum = minima[twin.name]
        write(minima)
        print(
            f"{twin.name}: J {minimum['J']:.6f} mm by {minimum['by']}, at the truth "
            f"{minimum['J_at_truth']:.6f}, {time.perf_counter() - start_time:.0f} s",
            flush=True,
        )


def write(minima: dict[str, object]) -> None:
    """Write the best minima so far."""
    document = {
        "command": "python benchmarks/best_known.py",
        "unit": "mm",
        "search": f"scipy differential_evolution, {SEEDS} seeds, popsize {POPULATION}, at most "
        f"{GENERATIONS} generations, tol 1e-10, each polished; bounded least squares from the "
        f"truth and from the best {STARTS} of {RANDOM} random points; the least of all, by "
        "Nelder and Mead",
        "twins": minima,
    }
    FILE.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


def search(twin: Twin) -> dict[str, object]:
    """The least J of a twin, its place and the search that reached it."""
    problem = twin.problem
    truth = float(problem(twin.truth[None])[0])
    minima = {"the truth": (truth, problem.space.encode(twin.truth[None])[0])}
    for by, u in _starts(problem, twin):
        minima[by] = min((_polished(problem, u, step) for step in STEPS), key=lambda ju: ju[0])
    by = min(minima, key=lambda name: minima[name][0])

    def clipped(u: Array) -> float:
        return float(_costs(problem, np.clip(u, 0.0, 1.0)[None])[0])

    last = minimize(
        clipped,
        minima[by][1],
        method="Nelder-Mead",
        options=cast("Any", {"xatol": 1e-9, "fatol": 1e-12, "maxfev": 3000, "adaptive": True}),
    )
    u = min((minima[by], (float(last.fun), np.clip(last.x, 0, 1))), key=lambda ju: ju[0])[1]
    x = problem.space.decode(u[None])
    evolutions = {name: J for name, (J, _) in minima.items() if name.startswith("DE")}
    return {
        "J": float(problem(x)[0]),
        "x": x[0].tolist(),
        "by": by,
        "J_at_truth": truth,
        "J_from_truth": minima["least squares from the truth"][0],
        "J_from_random": min(J for name, (J, _) in minima.items() if "random" in name),
        "J_of_DE": list(evolutions.values()),
    }


def _starts(problem: MotionProblem, twin: Twin) -> Iterator[tuple[str, Array]]:
    """Starting points of least squares, (dim,) in the cube, by name."""
    for seed in range(SEEDS):
        minimum = differential_evolution(
            cast("Any", lambda u: _costs(problem, u.T)),  # vectorised: (dim, n) to (n,)
            Bounds(np.zeros(problem.space.dim), np.ones(problem.space.dim)),
            popsize=POPULATION,
            maxiter=GENERATIONS,
            tol=1e-10,
            atol=0.0,
            polish=False,
            vectorized=True,
            updating="deferred",
            rng=seed,
        )
        yield f"DE, seed {seed}", np.asarray(minimum.x, dtype=float)
    yield "least squares from the truth", problem.space.encode(twin.truth[None])[0]
    u = problem.space.sample(np.random.default_rng(0), RANDOM)
    for k, i in enumerate(np.argsort(_costs(problem, u))[:STARTS]):
        yield f"least squares from random point {k}", u[i]


def _costs(problem: MotionProblem, u: Array) -> Array:
    """J, (n,), at points of the cube, (n, dim); WORST where the simulation fails."""
    return np.nan_to_num(problem(problem.space.decode(u)), nan=WORST, posinf=WORST)


def _polished(problem: MotionProblem, u: Array, step: float) -> tuple[float, Array]:
    """Least squares from a point of the cube, slopes from both sides."""

    def residuals(u: Array) -> Array:
        return np.asarray(problem.residuals(problem.space.decode(u[None]))[0])

    def slopes(u: Array) -> Array:
        low, high = (
            np.clip(u - step * np.eye(len(u)), 0, 1),
            np.clip(u + step * np.eye(len(u)), 0, 1),
        )
        steps = np.diag(high - low)
        moved = problem.residuals(problem.space.decode(np.vstack([low, high])))
        return np.asarray(((moved[len(u) :] - moved[: len(u)]) / steps[:, None]).T)

    start = float(_costs(problem, u[None])[0])
    try:
        minimum = least_squares(
            residuals,
            np.clip(u, 1e-9, 1 - 1e-9),
            slopes,
            bounds=(0.0, 1.0),
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-12,
            max_nfev=100,
        )
    except ValueError:  # a neighbour that cannot be simulated
        return start, u
    J = float(_costs(problem, minimum.x[None])[0])
    return (J, np.asarray(minimum.x)) if start > J else (start, u)


if __name__ == "__main__":
    main()
