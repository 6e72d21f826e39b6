"""Coverage of the intervals of the expected running time, by how the times are distributed.

    python benchmarks/ert_coverage.py [--campaigns 400]     simulate what is missing
    python benchmarks/ert_coverage.py --show                the table of docs/campaigns.md

Campaigns are simulated whose expected running time is known: times of mean 1 of ten kinds, of which
six are of a family that the interval reckons with; runs end without success at some chance, or at
their budget. The table has the share of campaigns whose 95 % interval holds the truth, by the
bootstrap alone and as `stribeck bench` reports it. Each cell goes to ert_coverage.json at once.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.integrate import quad

from stribeck.bench.running_time import interval_ends, studentised_ends
from stribeck.bench.statistics import labelled_rng, resamples
from stribeck.bench.time_tails import RunTimes
from stribeck.report.table import Cell, Table

Array = NDArray[np.float64]
FILE = Path(__file__).with_name("ert_coverage.json")
#: Chances of a run not to end for a reason of its own, and runs of a campaign.
RATES, RUNS = (1.0, 0.7, 0.3), (10, 25, 50)
#: What a run that ends for a reason of its own has spent, and the budget, in mean times.
OWN, BUDGET = 2.0, 30.0
#: Resamples of the bootstrap, fewer than those of a campaign's report.
DRAWN = 1000


@dataclass(frozen=True)
class Times:
    """Times to success, of mean 1.

    Args:
        draw: So many of them.
        survival: Probability of a longer one.
    """

    draw: Callable[[np.random.Generator, int], Array]
    survival: Callable[[float], float]

    def expected(self, rate: float) -> float:
        """The expected running time of runs that end by themselves at a chance of 1 - rate."""
        marks = [0.01, 0.1, 0.3, 1.0, 3.0, 10.0]
        spent = quad(self.survival, 0.0, BUDGET, points=marks, limit=500)[0]
        return float(spent + (1.0 - rate) / rate * OWN) / (1.0 - self.survival(BUDGET))


def _of(distribution: Any) -> Times:
    """Times of a distribution of scipy."""
    return Times(lambda rng, n: distribution.rvs(n, random_state=rng), distribution.sf)


def _mixed(share: float, first: Any, second: Any) -> Times:
    """Times of one distribution by that share, else of another."""

    def draw(rng: np.random.Generator, n: int) -> Array:
        chosen = rng.random(n) < share
        pair = (d.rvs(n, random_state=rng) for d in (first, second))
        times: Array = np.where(chosen, *pair)
        return times

    return Times(draw, lambda t: float(share * first.sf(t) + (1.0 - share) * second.sf(t)))


#: The first six are of a family that the interval reckons with, the others of none.
TIMES = {
    "exponential": _of(stats.expon()),
    "log-normal, s = 1": _of(stats.lognorm(1.0, scale=math.exp(-0.5))),
    "log-normal, s = 1.5": _of(stats.lognorm(1.5, scale=math.exp(-1.125))),
    "Weibull, k = 0.5": _of(stats.weibull_min(0.5, scale=0.5)),
    "Pareto, a = 2.5": _of(stats.pareto(2.5, scale=0.6)),
    "Pareto, a = 1.5": _of(stats.pareto(1.5, scale=1.0 / 3.0)),
    "gamma, k = 4": _of(stats.gamma(4.0, scale=0.25)),
    "inverse Gauss, 1/2": _of(stats.invgauss(2.0, scale=0.5)),
    "one in ten tenfold": _mixed(0.9, stats.expon(scale=1 / 1.9), stats.expon(scale=10 / 1.9)),
    "two modes": _mixed(
        0.7, stats.lognorm(0.2, scale=0.3 / 0.5202), stats.lognorm(0.2, scale=1.0 / 0.5202)
    ),
}


def campaign(times: Times, rate: float, n: int, rng: np.random.Generator) -> RunTimes:
    """The runs of one campaign."""
    own, time = rng.random(n) >= rate, times.draw(rng, n)
    cut = ~own & (time > BUDGET)
    spent = np.where(own, OWN, np.minimum(time, BUDGET))
    return RunTimes(spent, ~own & ~cut, cut, BUDGET)


def covered(name: str, rate: float, n: int, campaigns: int) -> dict[str, Any]:
    """Counts of campaigns, of those without success, and of those whose intervals hold."""
    times = TIMES[name]
    truth = times.expected(rate)
    counts = {"campaigns": campaigns, "none": 0, "bootstrap": 0, "reported": 0}
    tops = []
    for seed in range(campaigns):
        runs = campaign(times, rate, n, np.random.default_rng((seed, n)))
        if not runs.hit.any():
            counts["none"] += 1  # their interval is Wilson's
            continue
        rng = labelled_rng(name, str(seed))
        drawn = resamples(n, rng, DRAWN)
        alone = studentised_ends(drawn, runs.spent, runs.hit.astype(float))
        ends = interval_ends(runs, drawn, rng)
        counts["bootstrap"] += alone[0] <= truth <= alone[1]
        counts["reported"] += ends[0] <= truth <= ends[1]
        tops.append((alone[1], ends[1]))
    tops = np.median(np.array(tops) / truth, axis=0).tolist()
    return {k: int(v) for k, v in counts.items()} | {"upper": [round(top, 3) for top in tops]}


def kept() -> dict[str, Any]:
    """The counts by distribution, rate and number of runs, as they were last made."""
    return dict(json.loads(FILE.read_text(encoding="utf-8"))) if FILE.exists() else {}


def shares(of: dict[str, Any]) -> tuple[float, float]:
    """The shares of campaigns whose bootstrap, and whose reported interval holds, in percent."""
    able = of["campaigns"] - of["none"]
    return 100.0 * of["bootstrap"] / able, 100.0 * of["reported"] / able


def table(counts: dict[str, Any]) -> Table:
    """A row for each kind of times."""
    cells = [f"{rate:g}/{n}" for rate in RATES for n in RUNS]
    heads = [f"{100 * rate:.0f} %, {n}" for rate in RATES for n in RUNS]
    rows = []
    for name in TIMES:
        of = [counts.get(f"{name}/{cell}") for cell in cells]
        texts = ["–" if c is None else "{:.0f} → {:.0f}".format(*shares(c)) for c in of]
        rows.append(tuple(map(Cell.label, (name, *texts))))
    note = ""
    if counts:
        fewest = min(c["campaigns"] for c in counts.values())
        half = 196.0 * math.sqrt(0.95 * 0.05 / fewest)
        every = [shares(c)[1] for c in counts.values()]
        note = (
            f"At least {fewest} campaigns a cell: ± {half:.1f} at 95 %. As reported, "
            f"{min(every):.0f} to {max(every):.0f} %, {np.median(every):.0f} % in the middle."
        )
    return Table(
        "Campaigns whose 95 % interval holds the expected running time / %: the bootstrap alone → "
        "as reported, by the share of runs that do not end by themselves, and their number",
        ("times", *heads), tuple(rows), note,
    )  # fmt: skip


def main() -> None:
    """Simulate the cells that are missing, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--campaigns", type=int, default=400)
    parser.add_argument("--show", action="store_true", help="what is kept, and nothing new")
    options = parser.parse_args()
    counts = kept()
    for name, rate, n in (
        [] if options.show else [(t, r, n) for t in TIMES for r in RATES for n in RUNS]
    ):
        key = f"{name}/{rate:g}/{n}"
        if counts.get(key, {}).get("campaigns", 0) < options.campaigns:
            counts[key] = covered(name, rate, n, options.campaigns)
            FILE.write_text(json.dumps(counts, indent=1) + "\n", encoding="utf-8")
    print(table(counts).text())


if __name__ == "__main__":
    main()
