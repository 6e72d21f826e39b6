"""What the rates of a log leave of a mass and a friction: of one clock, and of a slower force.

    python benchmarks/sampling_rate.py

A carriage follows exact tones of 0.31 to 7.3 Hz (tests/foreign/tones.py), its position in steps of
1 um; a row is six logs of 20 s: means, how many 95 % intervals hold the truth, and how many values
are called identified. Beside what `identify` gives stand differences of order 2, which is what the
report on EMPS takes, and a slower or patchy force on straight lines, in the same package.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

import foreign_path  # noqa: F401 - before what it finds
from foreign.tones import TRUTH, axis
from stribeck import Recording, identify
from stribeck.data.readers.joined import joined
from stribeck.data.readers.raw_table import RawTable
from stribeck.report.table import Table
from stribeck.rig.balanced import BalancedRig
from stribeck.rig.forced import FORCED
from stribeck.space import Array

SEEDS, STEP = 6, 1e-6
RATES = (1000.0, 500.0, 250.0, 125.0, 100.0)
#: Intervals of the force, ms, beside positions each ms.
INTERVALS = (2, 4, 8, 16, 25, 40)
#: Shares of rows, or of samples of a force each 8 ms, that are lost by chance.
LOST = (0.01, 0.05)
PLAIN = replace(FORCED, filtering=replace(FORCED.filtering, accuracy=2))


def measured(rate: float, seed: int) -> tuple[Array, Array, Array]:
    """Time, position in steps, and force."""
    t, x, force = axis(rate, seed=seed)
    offset = np.random.default_rng(seed).uniform(-0.5, 0.5)
    return t, STEP * np.round(x / STEP + offset), force


def of_one_clock(rate: float, seed: int, lost: float = 0.0) -> Recording:
    """A log at a rate, Hz, of which a share of the rows is lost."""
    t, x, force = measured(rate, seed)
    kept = np.random.default_rng(100 + seed).random(len(t)) >= lost
    return Recording(t=t[kept], position=x[kept], force=force[kept])


def of_two(every: int, seed: int, lost: float = 0.0, *, lines: bool = False) -> Recording:
    """A log at 1 kHz whose force has a sample each n-th ms, of which a share is lost.

    As a file of two clocks is read, or with the force on straight lines.
    """
    t, x, force = measured(1000.0, seed)
    own = np.arange(0, len(t), every)
    own = own[np.random.default_rng(100 + seed).random(len(own)) >= lost]
    if lines:
        return Recording(t=t, position=x, force=np.interp(t, t[own], force[own]))
    tables = (
        RawTable({"x": x}, range(len(t)), t=t),
        RawTable({"F": force[own]}, range(len(own)), t=t[own]),
    )
    table = joined(tables, "x", force="F")
    assert table.t is not None  # noqa: S101 - of a table with a clock
    return Recording(t=table.t, position=table.columns["x"], force=table.columns["F"])


def row(log: str, way: str, logs: Iterable[Recording], rig: BalancedRig = FORCED) -> list[str]:
    """Means of the estimates, and how many of the 95 % intervals hold the truth."""
    fits = [identify(log, rig=rig, law="coulomb-viscous").estimates for log in logs]
    cells = [log, way]
    for parameter, truth in TRUTH.items():
        estimates = [next(e for e in fit if e.name == parameter) for fit in fits]
        held = sum(e.low <= truth <= e.high for e in estimates)
        sure = sum(e.verdict == "identified" for e in estimates)
        cells.append(f"{np.mean([e.value for e in estimates]):.2f}")
        cells += [f"{count}/{len(estimates)}" for count in (held, sure)]
    return cells


def table(title: str, rows: list[list[str]]) -> Table:
    """Rows under their heads."""
    heads = ["log", "way", *(h for n, v in TRUTH.items() for h in (f"{n} ({v:g})", "in", "sure"))]
    return Table.of_texts(title, heads, rows, labels=(0, 1))


def main() -> None:
    """Print all tables."""
    seeds = range(SEEDS)
    rows = []
    for rate in RATES:
        logs = [of_one_clock(rate, s) for s in seeds]
        rows.append(row(f"{rate:g} Hz", "order 2", logs, PLAIN))
        rows.append(row(f"{rate:g} Hz", "order 6, as they are", logs))
    print(table("Differences of positions and force at one rate", rows).text())
    rows = []
    for every in INTERVALS:
        name = f"each {every} ms"
        rows.append(row(name, "on lines", (of_two(every, s, lines=True) for s in seeds)))
        rows.append(row(name, "as it is read", (of_two(every, s) for s in seeds)))
    print(table("A slower force beside positions each ms", rows).text())
    rows = []
    for lost in LOST:
        name = f"{lost:.0%} of rows"
        rows.append(row(name, "as it is read", (of_one_clock(250.0, s, lost) for s in seeds)))
        name = f"{lost:.0%} of the force"
        rows.append(row(name, "on lines", (of_two(8, s, lost, lines=True) for s in seeds)))
        rows.append(row(name, "as it is read", (of_two(8, s, lost) for s in seeds)))
    print(table("Lost by chance: of the rows at 250 Hz, of a force each 8 ms", rows).text())


if __name__ == "__main__":
    main()
