"""How often intervals of the expected running time hold it: heavy-tailed times, few runs.

    python benchmarks/ert_coverage.py [--campaigns 1000]

Prints the table of docs/campaigns.md: the share of simulated campaigns whose 95 % interval holds
the true expected running time, by the distribution of the times, the success rate and the number
of runs; the percentile bootstrap alone, and joined with the studentised one as `stribeck bench`
reports it.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from stribeck.bench.statistics import RESAMPLES, percentile_ends, studentised_ends

Array = NDArray[np.float64]
Times = Callable[[np.random.Generator, int], Array]

#: Times with mean 1: exponential, log-normal of two widths, Weibull, and Pareto with a variance
#: and without.
TIMES: dict[str, Times] = {
    "exponential": lambda rng, n: rng.exponential(1.0, n),
    "log-normal, s = 1": lambda rng, n: rng.lognormal(-0.5, 1.0, n),
    "log-normal, s = 1.5": lambda rng, n: rng.lognormal(-1.125, 1.5, n),
    "Weibull, k = 0.5": lambda rng, n: 0.5 * rng.weibull(0.5, n),
    "Pareto, a = 2.5": lambda rng, n: 0.6 * (1 + rng.pareto(2.5, n)),
    "Pareto, a = 1.5": lambda rng, n: (1 + rng.pareto(1.5, n)) / 3,
}
RATES, RUNS = (1.0, 0.7), (10, 25, 50)
#: What a run without success spends, in mean times of those with.
SPENT = 2.0


def covered(times: Times, rate: float, n: int, campaigns: int) -> tuple[float, float]:
    """The share of campaigns whose percentile, and studentised, interval holds the truth."""
    truth = 1.0 + SPENT * (1 - rate) / rate
    hits = np.zeros(2)
    for seed in range(campaigns):
        rng = np.random.default_rng((seed, n))
        hit = (rng.random(n) < rate).astype(float)
        spent = np.where(hit > 0, times(rng, n), SPENT)
        if not hit.any():
            hits += 1  # both are then the time at the upper end of Wilson's interval, and more
            continue
        drawn = rng.multinomial(n, np.full(n, 1 / n), size=RESAMPLES // 5).astype(float)
        ends = [percentile_ends(drawn, spent, hit), studentised_ends(drawn, spent, hit)]
        hits += [low <= truth <= high for low, high in ends]
    return float(hits[0] / campaigns), float(hits[1] / campaigns)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--campaigns", type=int, default=1000)
    campaigns = parser.parse_args().campaigns
    half = 1.96 * math.sqrt(0.95 * 0.05 / campaigns)
    print(f"{campaigns} campaigns a cell: ± {100 * half:.1f} at 95 %\n")
    heads = [f"{r:.0%}, {n} runs" for r in RATES for n in RUNS]
    print(f"| times | {' | '.join(heads)} |")
    print(f"|---|{'---|' * len(heads)}")
    for name, times in TIMES.items():
        cells = [covered(times, r, n, campaigns) for r in RATES for n in RUNS]
        texts = [f"{100 * before:.0f} → {100 * after:.0f}" for before, after in cells]
        print(f"| {name} | {' | '.join(texts)} |")


if __name__ == "__main__":
    main()
