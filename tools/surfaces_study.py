"""Print how often ATS and BTS reach J_min on the paper's surfaces, by reading of a deadlock.

Sections 2 and 3 of the paper, with the settings of its Tables 2 and 3. "Literal" backtracks into
the tabu list as Algorithm 1 says; "restart" begins anew with another initial solution. Rounds
and evaluations are means over the trials that reached J_min; rounds are those of the tabu stage,
as in Table 4, whose published means stand in the last column.
"""

from __future__ import annotations

import argparse

import numpy as np

from stribeck.bench.surfaces import SURFACES, Surface
from stribeck.optimize import Run, Search, Target, configure, lockstep

#: Table 4, average search rounds of ATS and BTS.
PUBLISHED = {
    "BF": {"ats": 616.48, "bts": 151.20},
    "RF": {"ats": 868.28, "bts": 323.30},
    "SF": {"ats": 139.36, "bts": 25.70},
    "SchF": {"ats": 6889.42, "bts": 1469.14},
    "ShuF": {"ats": 68.06, "bts": 55.28},
}
READINGS = {"literal": "backtrack", "restart": "restart"}
ROW = "{:8} {:6} {:8} {:>9} {:>10} {:>12} {:>10}"


def trials(surface: Surface, method: str, deadlock: str, n: int) -> list[Run]:
    """`n` trials, seeds 0 to n-1, to J_min or count_max rounds."""
    algorithm = configure(method, **surface.settings[method], deadlock=deadlock)
    stops = [Target(surface.J_min)]
    searches = [
        Search(surface.space, algorithm, budget=100_000_000, seed=seed, stops=stops)
        for seed in range(n)
    ]
    return lockstep(surface, searches)


def row(runs: list[Run], surface: Surface, method: str, reading: str) -> str:
    """A line of the table."""
    reached = [r for r in runs if r.ended == "target"]
    rounds = f"{np.mean([r.trace.rounds('tabu') for r in reached]):.1f}" if reached else "-"
    evaluations = f"{np.mean([r.evaluations for r in reached]):.0f}" if reached else "-"
    success = f"{len(reached)}/{len(runs)}"
    published = f"{PUBLISHED[surface.name][method]:.1f}"
    return ROW.format(surface.name, method, reading, success, rounds, evaluations, published)


def main() -> None:
    """Run the study and print it line by line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--trials", type=int, default=50, help="trials a cell (50)")
    n = parser.parse_args().trials
    print(
        ROW.format("surface", "method", "deadlock", "reached", "rounds", "evaluations", "Table 4")
    )
    for surface in SURFACES.values():
        for method in ("bts", "ats"):
            for reading, deadlock in READINGS.items():
                runs = trials(surface, method, deadlock, n)
                print(row(runs, surface, method, reading), flush=True)


if __name__ == "__main__":
    main()
