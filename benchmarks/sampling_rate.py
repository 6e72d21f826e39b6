"""What the rates of a log leave of a mass and a friction: of one clock, and of a slower force.

    python benchmarks/sampling_rate.py

A rail carriage of 85 kg under 20 N and 214 N s/m follows tones of 0.31 to 7.3 Hz, which are exact:
nothing is simulated. Its force has noise of 2 N, its position steps of 1 um; a row is six logs of
20 s: means, how many 95 % intervals hold the truth, and how many values are called identified.
Beside what `identify` gives stand differences of order 2, which is what the report on EMPS takes,
and a slower force on straight lines, in the same package.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stribeck import Recording, identify
from stribeck.data.readers.joined import joined
from stribeck.data.readers.raw_table import RawTable
from stribeck.identify.uncertainty.estimates import Estimate
from stribeck.rig.balanced import BalancedRig
from stribeck.rig.forced import FORCED
from stribeck.space import Array

TRUTH = {"F_C": 20.0, "F_V": 214.0, "M": 85.0}
TONES = (0.31, 0.83, 1.7, 3.1, 4.7, 7.3)
SECONDS, SEEDS, STEP, NOISE = 20.0, 6, 1e-6, 2.0
RATES = (1000.0, 500.0, 250.0, 125.0, 100.0)
#: Intervals of the force, ms, beside positions each ms.
INTERVALS = (2, 4, 8, 16, 25, 40)
PLAIN = replace(FORCED, filtering=replace(FORCED.filtering, accuracy=2))


def axis(rate: float, seed: int) -> tuple[Array, Array, Array]:
    """Time, position and force."""
    t = np.arange(round(SECONDS * rate)) / rate
    x, v, a = np.zeros((3, len(t)))
    for f in TONES:
        w, size = 2 * np.pi * f, 0.08 * np.exp(-0.25 * f) / f
        x += size * np.sin(w * t + 1.3 * f)
        v += size * w * np.cos(w * t + 1.3 * f)
        a -= size * w**2 * np.sin(w * t + 1.3 * f)
    rng = np.random.default_rng(seed)
    force = TRUTH["M"] * a + TRUTH["F_C"] * np.sign(v) + TRUTH["F_V"] * v
    force += NOISE * rng.standard_normal(len(t))
    return t, STEP * np.round(x / STEP + rng.uniform(-0.5, 0.5)), force


def of_one_clock(rate: float, seed: int) -> Recording:
    """A log at a rate, Hz."""
    t, x, force = axis(rate, seed)
    return Recording(t=t, position=x, force=force)


def on_lines(every: int, seed: int) -> Recording:
    """A log at 1 kHz whose force was measured in each n-th ms, on straight lines between."""
    t, x, force = axis(1000.0, seed)
    return Recording(t=t, position=x, force=np.interp(t, t[::every], force[::every]))


def as_read(every: int, seed: int) -> Recording:
    """The same as a file of two clocks is read."""
    t, x, force = axis(1000.0, seed)
    tables = (
        RawTable({"x": x}, range(len(t)), t=t),
        RawTable({"F": force[::every]}, range(len(t[::every])), t=t[::every]),
    )
    table = joined(tables, "x", force="F")
    assert table.t is not None  # noqa: S101 - of a table with a clock
    return Recording(t=table.t, position=table.columns["x"], force=table.columns["F"])


def row(name: str, logs: Sequence[Recording], rig: BalancedRig) -> str:
    """Means of the estimates, and how many of the 95 % intervals hold the truth."""
    fits = [identify(log, rig=rig, law="coulomb-viscous").estimates for log in logs]
    cells = []
    for parameter, truth in TRUTH.items():
        of: list[Estimate] = [next(e for e in fit if e.name == parameter) for fit in fits]
        sure = sum(e.verdict == "identified" for e in of)
        held = sum(e.low <= truth <= e.high for e in of)
        cells.append(f"{np.mean([e.value for e in of]):7.2f}  {held}/{len(of)}  {sure}/{len(of)}")
    return f"{name:28}" + "   ".join(cells)


def main() -> None:
    """Print both tables."""
    heads = "   ".join(f"{f'{n} ({v:g})':>7}  in   sure" for n, v in TRUTH.items())
    print(f"{'differences of order':28}{heads}")
    for rate in RATES:
        logs = [of_one_clock(rate, seed) for seed in range(SEEDS)]
        print(row(f"{rate:4g} Hz    2", logs, PLAIN))
        print(row(f"{'':11}6, as they are", logs, FORCED))
    print(f"\n{'a force each':28}{heads}")
    for every in INTERVALS:
        seeds = range(SEEDS)
        print(row(f"{every:2} ms      on lines", [on_lines(every, s) for s in seeds], FORCED))
        print(row(f"{'':11}as it is read", [as_read(every, s) for s in seeds], FORCED))


if __name__ == "__main__":
    main()
