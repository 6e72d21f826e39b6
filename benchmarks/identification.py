"""Simulated candidates until the slide bed's five parameters are identified.

An answer counts as found when J is within 0.5 % of the best known J of that twin
(best_known.json). Rows of the cost are counted, those of finite differences too.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.random import SeedSequence
from scipy.optimize import least_squares

import run as bench
from stribeck.bench import third_party
from stribeck.identify.problem import MotionProblem
from stribeck.optimize import Search, Target, configure, lockstep
from stribeck.report.table import Cell, Table
from stribeck.space import Array
from twins import TOLERANCE, Twin, twins

#: Evaluations to the answer, or None where the budget was spent without it.
Count = int | None
#: (twin, seed, budget) to the count.
Contestant = Callable[[Twin, int, int], Count]

#: The goal for `mbts`: always found, half of the times within the first count, always the second.
MEDIAN, MOST = 350, 2000
SKETCH = "100 random, then least squares"
#: SciPy's solver at its best: screened starts, slopes over a length that suits a simulation.
SCREENED = "scipy least_squares, best of 20 random"
DFO_LS = "DFO-LS, best of 20 random"


def ours(method: str, **settings: Any) -> Contestant:
    """A method of stribeck."""

    def run(twin: Twin, seed: int, budget: int) -> Count:
        problem, stops = twin.problem, [Target(twin.target)]
        search = Search(
            problem.space, configure(method, **settings), budget=budget, seed=seed, stops=stops
        )
        (searched,) = lockstep(problem, [search])
        return searched.trace.reached(twin.target)

    return run


def theirs(peer: str, **settings: Any) -> Contestant:
    """A third-party optimizer."""

    def run(twin: Twin, seed: int, budget: int) -> Count:
        trace, _ = third_party.search(
            peer,
            twin.problem,
            budget=budget,
            target=twin.target,
            seed=SeedSequence(seed),
            **settings,
        )
        return trace.reached(twin.target)

    return run


class FoundError(Exception):
    """The answer is found, or the budget is spent."""


class Counted:
    """Residuals over the unit cube, every row counted, until J is low enough."""

    def __init__(self, problem: MotionProblem, target: float, budget: int) -> None:
        self.problem, self.target, self.budget = problem, target, budget
        self.spent, self.reached = 0, False

    def costs(self, u: Array) -> Array:
        """(n, dim) points to their J."""
        self._count(J := self.problem(self.problem.space.decode(u)))
        return np.where(np.isfinite(J), J, np.inf)

    def residuals(self, u: Array) -> Array:
        """(dim,) point to its residuals."""
        r: Array = self.problem.residuals(self.problem.space.decode(u[None]))[0]
        self._count(np.sqrt(np.mean(r**2, keepdims=True)))
        return r

    def _count(self, J: Array) -> None:
        low = np.flatnonzero(self.target >= J)
        self.reached = bool(len(low)) and self.spent + low[0] < self.budget
        self.spent += int(low[0]) + 1 if len(low) else len(J)
        if self.reached or self.spent >= self.budget:
            raise FoundError


def sketch(twin: Twin, seed: int, budget: int) -> Count:
    """The ten-line approach: 100 random points, scipy's least squares from the best.

    From the best five in turn, 30 iterations at most; then another hundred. The step of the slopes
    and the tolerance are the best of those tried by hand: with scipy's own it takes longer.
    """
    problem, rng = twin.problem, np.random.default_rng(seed)
    count, steps = Counted(problem, twin.target, budget), [1e-3] * problem.space.dim
    try:
        while True:
            u = problem.space.sample(rng, 100)
            for start in u[np.argsort(count.costs(u), kind="stable")[:5]]:
                try:
                    least_squares(
                        count.residuals,
                        start,
                        bounds=(0.0, 1.0),
                        diff_step=steps,
                        max_nfev=30,
                        ftol=1e-4,
                        xtol=1e-4,
                    )
                except ValueError:  # residuals that are not finite
                    continue
    except FoundError:
        return count.spent if count.reached else None


#: Contestants on the demo's twins: (contestant, seeds, budget), and the same in a short pass.
CONTESTANTS: dict[str, tuple[Contestant, tuple[int, int], tuple[int, int]]] = {
    "mbts": (ours("mbts"), (100, 5_000), (10, 5_000)),
    SKETCH: (sketch, (20, 20_000), (5, 20_000)),
    SCREENED: (
        theirs("least-squares", screened=20, diff_step=1e-3, ftol=1e-4, xtol=1e-4),
        (20, 20_000),
        (5, 20_000),
    ),
    DFO_LS: (theirs("dfo-ls", screened=20), (10, 5_000), (2, 5_000)),
    "pycma lq-CMA-ES": (theirs("cma-lq"), (6, 5_000), (1, 2_000)),
    "scipy differential_evolution": (theirs("scipy-de"), (6, 60_000), (1, 30_000)),
    "scipy dual_annealing": (theirs("dual-annealing"), (6, 30_000), (1, 5_000)),
    "pycma IPOP": (theirs("cma-ipop"), (6, 20_000), (1, 5_000)),
    "bts": (ours("bts"), (6, 30_000), (1, 5_000)),
    "ats-restart": (ours("ats", deadlock="restart"), (6, 30_000), (1, 5_000)),
}
#: Contestants on the random twins, as the heads of a table there call them.
RANDOM = {"mbts": "mbts", SKETCH: "100 random", SCREENED: "scipy", DFO_LS: "DFO-LS"}
#: Seeds on each random twin.
SEEDS = 10


def measure(quick: bool = False) -> dict[str, Any]:
    """Count evaluations to the answer.

    Args:
        quick: Fewer seeds, smaller budgets, four of the twenty random twins.
    """
    demo = {t.name: _raced(t, list(CONTESTANTS), quick) for t in twins(random=False)}
    random = twins(demo=False)
    some = random[:: len(random) // 4] if quick else random
    seeds = 3 if quick else SEEDS
    return {
        "within": TOLERANCE,
        "demo": demo,
        "random": {t.name: _raced(t, list(RANDOM), quick, seeds) for t in some},
    }


def _raced(
    twin: Twin, names: Sequence[str], quick: bool, most: int | None = None
) -> dict[str, Any]:
    counts = {}
    for name in names:
        run, full, short = CONTESTANTS[name]
        seeds, budget = short if quick else full
        if most is not None:
            seeds = min(seeds, most)
        evaluations = [run(twin, seed, budget) for seed in range(seeds)]
        counts[name] = {"budget": budget, "evaluations": evaluations}
    problem = twin.problem
    return {
        "side": twin.side,
        "rate": twin.bed.rate,
        "noise": twin.bed.echo_noise,
        "samples": problem.samples,
        "best": twin.best,
        "at_truth": float(problem(twin.truth[None])[0]),
        "counts": counts,
    }


def spread(counts: Sequence[Count]) -> tuple[int, float, float, float]:
    """Number of answers, and the least, median and greatest count; inf where not found."""
    all_ = np.sort([np.inf if c is None else float(c) for c in counts])
    # Of an even number the upper one of the middle two: no mean with infinity.
    return int(np.isfinite(all_).sum()), all_[0], all_[len(all_) // 2], all_[-1]


def added(results: dict[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """Results with the counts of some contestants anew, those of the others as they were."""
    known = {twin.name: twin for twin in twins()}
    for group, contestants, most in (("demo", CONTESTANTS, None), ("random", RANDOM, SEEDS)):
        for name, row in results[group].items():
            some = [contestant for contestant in contestants if contestant in names]
            counts = row["counts"] | _raced(known[name], some, quick=False, most=most)["counts"]
            row["counts"] = {c: counts[c] for c in contestants if c in counts}
            print(name, {c: spread(counts[c]["evaluations"]) for c in some}, flush=True)
    return results


def tables(results: dict[str, Any]) -> list[str]:
    """The counts, in Markdown."""
    return [_demo(results).markdown(), _random(results).markdown(), _pooled(results).markdown()]


def _demo(results: dict[str, Any]) -> Table:
    rows = [
        (
            Cell.label(name),
            Cell.label(twin["side"]),
            *_cells(counts["evaluations"]),
            _budget(counts),
        )
        for name in CONTESTANTS
        for twin in results["demo"].values()
        if (counts := twin["counts"].get(name))
    ]
    return Table(
        f"Evaluations until J is within {results['within']:.1%} of the best known, the demo's twin "
        "(0.3 mm noise, 100 Hz)",
        ("who", "direction", "found", "least", "median", "most", "budget"),
        tuple(rows),
        f"Goal for mbts: found by all, median at most {MEDIAN}, none above {MOST:,}. ∞: not "
        "within the budget.",
    )


def _random(results: dict[str, Any]) -> Table:
    rows = []
    for name, twin in results["random"].items():
        fixed = (
            Cell.label(name),
            Cell.label(twin["side"]),
            Cell.number(twin["rate"], 3),
            Cell.number(1e3 * twin["noise"], 2),
            Cell.number(twin["best"], 4),
        )
        by = {m: _cells(c["evaluations"]) for m in RANDOM if (c := twin["counts"].get(m))}
        found, _, median, most = by.pop("mbts")
        rows.append((*fixed, found, median, most, *(cells[2] for cells in by.values())))
    mbts, *others = RANDOM.values()
    return Table(
        "The same on twins with random true parameters",
        ("twin", "direction", "rate/Hz", "noise/mm", "best J/mm", mbts, "median", "most", *others),
        tuple(rows),
        "The last columns are medians of the three below mbts in the table above.",
    )


def _pooled(results: dict[str, Any]) -> Table:
    """A row for each contestant over all random twins."""
    rows = []
    for method in next(iter(results["random"].values()))["counts"]:
        counts = [c for t in results["random"].values() for c in t["counts"][method]["evaluations"]]
        rows.append((Cell.label(method), *_cells(counts)))
    return Table(
        "All random twins together", ("who", "found", "least", "median", "most"), tuple(rows)
    )


def _cells(counts: Sequence[Count]) -> tuple[Cell, Cell, Cell, Cell]:
    hits, least, median, most = spread(counts)
    text = f"{hits}/{len(counts)}"
    return Cell.label(text), Cell.number(least), Cell.number(median), Cell.number(most)


def _budget(counts: dict[str, Any]) -> Cell:
    return Cell(f"{counts['budget']:,}", counts["budget"])


def main() -> None:
    """Count some contestants anew, and keep that with what is known of the others."""
    ask = argparse.ArgumentParser(description=main.__doc__)
    ask.add_argument("names", nargs="+", choices=CONTESTANTS, metavar="WHO")
    results = bench.read(bench.RESULTS)["identification"]["found"]
    bench.renew("identification", added(results, ask.parse_args().names))


if __name__ == "__main__":
    main()
