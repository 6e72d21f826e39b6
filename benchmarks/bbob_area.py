"""The 24 functions of BBOB: share of the targets met, over evaluations.

Instances 1 to 5 in 2, 3 and 5 dimensions, 2,000 evaluations a dimension, 51 targets from 1e2 to
1e-8 above the minimum. Area: under the share of (function, instance, target) triples met, over
log10 of evaluations per dimension from 1 to 2,000.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from stribeck.bench.bbob import FUNCTIONS, GROUPS
from stribeck.bench.record import Record
from stribeck.bench.statistics import TARGETS, area, hits
from stribeck.report.table import Cell, Table
from stribeck.space import Array
from trials import methods, records

DIMENSIONS, INSTANCES, BUDGET = (2, 3, 5), 5, 2000
METHODS = {
    "mbts": 'method = "mbts"',
    "pycma IPOP": 'method = "cma-ipop"',
    "pycma BIPOP": 'method = "cma-bipop"',
    "scipy differential_evolution": 'method = "scipy-de"',
    "scipy dual_annealing": 'method = "dual-annealing"',
    "pymoo DE": 'method = "pymoo-de"',
    "bts-restart": 'method = "bts"\nunit_free = true\nsettings = { deadlock = "restart" }',
    "ats-restart": 'method = "ats"\nunit_free = true\nsettings = { deadlock = "restart" }',
    "ga": 'method = "ga"',
    "random": 'method = "random"',
}
CAMPAIGN = """
name = "bbob-area"
doc = "BBOB, instances 1 to {instances}."
seed = 2012
repeats = {instances}
budget_per_dim = {budget}

[[problem]]
bbob = {functions}
dim = {dimensions}

{methods}
"""


def measure(quick: bool = False) -> dict[str, Any]:
    """Run all methods on all functions.

    Args:
        quick: Every other function, one instance, 2 and 5 dimensions, 500 evaluations each.
    """
    functions = list(FUNCTIONS)[:: 2 if quick else 1]
    dimensions = (2, 5) if quick else DIMENSIONS
    instances, budget = (1, 500) if quick else (INSTANCES, BUDGET)
    text = CAMPAIGN.format(
        instances=instances,
        budget=budget,
        functions=functions,
        dimensions=list(dimensions),
        methods=methods(METHODS),
    )
    by: dict[str, list[Record]] = {}
    for record in records(text):
        by.setdefault(record.job.algorithm, []).append(record)
    return {
        "functions": functions,
        "dimensions": list(dimensions),
        "instances": instances,
        "budget_per_dim": budget,
        "methods": {method: _areas(by[method], budget) for method in METHODS if method in by},
    }


def _areas(runs: Sequence[Record], limit: float) -> dict[str, Any]:
    """Areas and shares of one method's runs, by dimension, and by function and dimension."""
    by_dim = {dim: [r for r in runs if len(r.x) == dim] for dim in DIMENSIONS}
    return {
        "area": {str(d): area_under(some, limit) for d, some in by_dim.items() if some},
        "share": {str(d): share(some) for d, some in by_dim.items() if some},
        "by_function": {
            str(f): area_under([r for r in runs if r.job.surface["bbob"] == f], limit)
            for f in FUNCTIONS
            if any(r.job.surface["bbob"] == f for r in runs)
        },
        "seconds": sum(r.seconds for r in runs),
        "evaluations": sum(r.evaluations for r in runs),
    }


def share(runs: Iterable[Record], targets: Array = TARGETS) -> float:
    """The share of (run, target) pairs that were met in the end."""
    return float(np.mean([np.isfinite(hits(r, targets)).mean() for r in runs]))


def area_under(runs: Sequence[Record], limit: float) -> float:
    """The area under the share met, up to so many evaluations per dimension."""
    return area(runs, limits={r.job.problem: limit for r in runs}).value


def tables(results: dict[str, Any]) -> list[str]:
    """Areas and shares by dimension, areas by group, and by function, in Markdown."""
    ranked = sorted(results["methods"].items(), key=lambda item: -_mean(item[1]["share"]))
    return [
        _overall(results, dict(ranked)).markdown(),
        _groups(results, dict(ranked)).markdown(),
        _functions(results, dict(ranked)).markdown(),
    ]


def _overall(results: dict[str, Any], ranked: dict[str, Any]) -> Table:
    dims = [str(d) for d in results["dimensions"]]
    rows = [
        (
            Cell.label(method),
            *(_three(v) for by in (row["share"], row["area"]) for v in _by(by, dims)),
        )
        for method, row in ranked.items()
    ]
    dimensions = [f"D = {d}" for d in dims]
    return Table(
        f"BBOB: {len(results['functions'])} functions, instances 1 to {results['instances']}, "
        f"{results['budget_per_dim']:,} evaluations a dimension",
        ("who", "targets met", *dimensions, "area", *dimensions),
        tuple(rows),
        "Targets met: the share of 51 targets from 1e2 to 1e-8 above the minimum that was met in "
        "the end, mean over the dimensions. Area: under that share over log10 of evaluations per "
        "dimension, from 1 to the budget. Goal for mbts: above scipy differential_evolution in "
        "both, better above pycma.",
    )


def _by(values: dict[str, float], dims: Sequence[str]) -> list[float]:
    return [_mean(values), *(values[d] for d in dims)]


def _groups(results: dict[str, Any], ranked: dict[str, Any]) -> Table:
    groups = {g: [f for f in results["functions"] if FUNCTIONS[f].group == g] for g in GROUPS}
    rows = [
        (
            Cell.label(method),
            *(_three(_mean({f: row["by_function"][str(f)] for f in fs})) for fs in groups.values()),
        )
        for method, row in ranked.items()
    ]
    heads = (f"{g} (f{fs[0]}–f{fs[-1]})" for g, fs in groups.items())
    return Table("Area by group of functions", ("who", *heads), tuple(rows))


def _functions(results: dict[str, Any], ranked: dict[str, Any]) -> Table:
    rows = []
    for f in results["functions"]:
        areas = {method: row["by_function"][str(f)] for method, row in ranked.items()}
        best = max(areas, key=lambda method: areas[method])
        title = f"f{f} {FUNCTIONS[f].title}"
        rows.append((Cell.label(title), *(map(_three, areas.values())), Cell.label(best)))
    return Table("Area by function", ("function", *ranked, "best"), tuple(rows))


def _mean(values: dict[Any, float]) -> float:
    return float(np.mean(list(values.values())))


def _three(value: float) -> Cell:
    return Cell(f"{value:.3f}", value)
