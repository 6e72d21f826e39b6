"""Evaluations to J_min on the paper's five functions and on their shifted and rotated twins.

Fifty trials each; every trial of a twin has another shift and rotation, the same for all methods.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from stribeck.bench.record import Record
from stribeck.bench.running_time import ert
from stribeck.bench.statistics import cells, met
from stribeck.report.format import grouped
from stribeck.report.table import Cell, Table
from trials import methods, named, records

SURFACES = ("BF", "RF", "SF", "SchF", "ShuF")
METHODS = {
    "mbts": 'method = "mbts"',
    "bts-restart": 'method = "bts"\nunit_free = true\nsettings = { deadlock = "restart" }',
    "ats-restart": 'method = "ats"\nunit_free = true\nsettings = { deadlock = "restart" }',
    "ga": 'method = "ga"',
    "random": 'method = "random"',
    "scipy dual_annealing": 'method = "dual-annealing"',
    "scipy differential_evolution": 'method = "scipy-de"',
    "scipy direct": 'method = "direct"',
    "pycma IPOP": 'method = "cma-ipop"',
    "pymoo DE": 'method = "pymoo-de"',
}
#: The method that `mbts` is compared with.
RIVAL = "scipy dual_annealing"
TRIALS, BUDGET = 50, 20_000
CAMPAIGN = """
name = "surfaces"
doc = "The paper's five functions and their twins."
seed = 2012
repeats = {repeats}
budget = {budget}

[[problem]]
surface = {surfaces}

[[problem]]
surface = {surfaces}
twin = "each"

{methods}
"""


def measure(quick: bool = False) -> dict[str, Any]:
    """Count evaluations to J_min.

    Args:
        quick: Ten trials of 10,000 evaluations at most.
    """
    trials, budget = (10, 10_000) if quick else (TRIALS, BUDGET)
    text = CAMPAIGN.format(
        repeats=trials, budget=budget, surfaces=named(SURFACES), methods=methods(METHODS)
    )
    counts = cells(records(text))
    return {
        "trials": trials,
        "budget": budget,
        "cells": {
            method: {p: _counted(runs) for (p, m), runs in counts.items() if m == method}
            for method in METHODS
            if any(m == method for _, m in counts)
        },
    }


def _counted(runs: Sequence[Record]) -> dict[str, Any]:
    time = ert(runs)
    at = [met(r) for r in runs]
    return {
        "reached": int(np.isfinite(at).sum()),
        "ert": _finite(time.value),
        "interval": [_finite(time.low), _finite(time.high)],
        "most": _finite(float(np.max(at))),
    }


def _finite(value: float) -> float | None:
    """A finite number, or None: JSON has no other."""
    return value if math.isfinite(value) else None


def mean_ert(by_problem: dict[str, Any]) -> float:
    """The geometric mean of a method's ERT over the problems; inf if one of them is never met."""
    times = [counts["ert"] for counts in by_problem.values()]
    if None in times:
        return math.inf
    return math.exp(sum(map(math.log, times)) / len(times))


def _shown(value: float | None) -> float:
    return math.inf if value is None else value


def tables(results: dict[str, Any]) -> list[str]:
    """The counts, in Markdown."""
    problems = [*SURFACES, *(f"{s}-twin" for s in SURFACES)]
    runs = len(problems) * results["trials"]
    rival = mean_ert(results["cells"][RIVAL]) if RIVAL in results["cells"] else math.nan
    rows = []
    for method, counts in results["cells"].items():
        mean = mean_ert(counts)
        reached = f"{sum(c['reached'] for c in counts.values())}/{runs}"
        rows.append((
            Cell.label(method),
            *(Cell.number(_shown(counts[p]["ert"]), 3) for p in problems),
            Cell.number(mean, 3),
            Cell.number(mean / rival if math.isfinite(rival) else math.nan, 2),
            Cell.label(reached),
        ))  # fmt: skip
    table = Table(
        f"Expected evaluations to J_min, {results['trials']} trials each",
        ("who", *problems, "mean", "ratio", "reached"),
        tuple(rows),
        "Expected running time (ERT): all evaluations spent until J_min or the end of the run, "
        "divided by the trials that reached it; ∞ where none did. Mean: geometric, over all ten. "
        f"Ratio: to {RIVAL}. A run may spend {grouped(results['budget'])} evaluations. Goal for "
        "mbts: reached always, ratio at most 1, better 0.5.",
    )
    return [table.markdown()]
