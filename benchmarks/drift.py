"""How often drift raises false alarms, how soon and how well it finds a step, and wear.

    python benchmarks/drift.py [--years N] [--quick]

Twins are of `tests/drift_twins.py`, which draws estimates number by number, and the ways in which
estimates scatter while nothing changes are of `tests/drift_scatter.py`: neither has a part of the
package in it. Limits are set to one false alarm a year. Writes benchmarks/drift.json.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from drift_scatter import SCATTER, Draw  # noqa: E402 - from a folder that is now on the path
from drift_twins import Twin  # noqa: E402
from stribeck.monitoring.control_chart import Limits, control_chart  # noqa: E402
from stribeck.monitoring.series import Series  # noqa: E402

OUT = ROOT / "benchmarks" / "drift.json"
#: Charts of a parameter, which share a year's false alarm.
CHARTS = 2
LEVEL, STEP = 1.35, 0.15
#: Logs a year, and how they scatter about 1.35 A: the last but one as the UR10e's joint 1 does.
TWINS = {
    "a log a day, 3 %": (365, Twin(log=0.03 * LEVEL)),
    "a log a day, 5 %": (365, Twin(log=0.05 * LEVEL)),
    "a log a day, 7.7 % (UR10e)": (365, Twin(day=0.087, log=0.057)),
    "three logs a day, 7.7 % (UR10e)": (1095, Twin(day=0.087, log=0.057, logs=3)),
    "a log a week, 3 %": (52, Twin(log=0.03 * LEVEL)),
}
#: Logs before a step, and after it.
BEFORE, AFTER = 60, 30
#: Logs a year of an axis by the way in which its estimates scatter; for each year of the others so
#: many.
SCATTER_LOGS, SCATTER_YEARS = 200, 5
#: Wear, of the level by week; logs after the alarm from which its slope is told, too.
WEAR, MORE = 0.01, 10


def series(twin: Twin, count: int, seed: int) -> Series:
    """So many logs of a twin."""
    days, values, _ = (np.array(c) for c in zip(*twin.estimates(count, seed), strict=True))
    kinds = np.zeros(count, dtype=np.int64)
    return Series(values, np.zeros(count), days.astype(float), kinds)


def first(part: Series, limits: Limits, at: int) -> Any:
    """The first alarm from a log on; None if there is none."""
    return next((a for a in control_chart(part, limits).alarms if a.at >= at), None)


def false_alarms(logs: int, twin: Twin, years: int) -> dict[str, Any]:
    """Alarms of an axis at which nothing changes, in years of so many logs."""
    return alarm_rate((series(twin, logs, k) for k in range(years)), logs)


def scattered(draw: Draw, logs: int, years: int) -> dict[str, Any]:
    """Alarms of an axis at which nothing changes and whose estimates scatter like that."""
    parts = (draw(np.random.default_rng(k), logs) for k in range(years))
    kinds = np.zeros(logs, dtype=np.int64)
    return alarm_rate((Series(10.0 + y, errors, days, kinds) for y, errors, days in parts), logs)


def alarm_rate(steady: Iterable[Series], logs: int) -> dict[str, Any]:
    """Alarms by year of series of a year each, with the interval of a Poisson count."""
    limits = Limits.of(CHARTS * logs)
    counts = [len(control_chart(each, limits).alarms) for each in steady]
    total, years = sum(counts), len(counts)
    low = stats.chi2.ppf(0.025, 2 * total) / 2 / years if total else 0.0
    high = stats.chi2.ppf(0.975, 2 * total + 2) / 2 / years
    return {
        "years": years, "false alarms a year": round(total / years, 3),
        "95 % interval": [round(float(low), 3), round(float(high), 3)],
    }  # fmt: skip


def steps(logs: int, twin: Twin, twins: int) -> dict[str, Any]:
    """Delay and size of a step of 15 %, told at the alarm and 30 logs after the step."""
    limits, size = Limits.of(CHARTS * logs), STEP * LEVEL
    moved = replace(twin, step=size, at=BEFORE)
    delays, early, late = list[int](), list[Any](), list[Any]()
    for k in range(twins):
        whole = series(moved, BEFORE + AFTER, 10_000 + k)
        alarm = first(whole, limits, BEFORE)
        if alarm is None:
            continue
        delays.append(alarm.at - BEFORE + 1)
        late.append(alarm.changes)
        n = alarm.at + 1
        then = Series(whole.values[:n], whole.errors[:n], whole.times[:n], whole.kinds[:n])
        early.append(first(then, limits, BEFORE).changes)
    return {
        "twins": twins,
        "found within 30 logs": round(len(delays) / twins, 3),
        "found within 3 logs": round(sum(d <= 3 for d in delays) / twins, 3),  # noqa: PLR2004
        "mean delay, logs": round(float(np.mean(delays)), 2),
        "at the alarm": sizes(early, size),
        "30 logs after the step": sizes(late, size),
    }


def wear(logs: int, twin: Twin, twins: int) -> dict[str, Any]:
    """When wear of 1 % a week is told that begins after so many logs, and as what."""
    limits = Limits.of(CHARTS * logs)
    every, weekly = round(365 / logs), WEAR * LEVEL
    grown, shapes, ramps = list[float](), list[str](), list[Any]()
    for k in range(twins):
        flat = series(twin, BEFORE + 2 * AFTER, 20_000 + k)
        times = flat.times * every
        worn = flat.values + weekly / 7.0 * np.maximum(0.0, times - times[BEFORE])
        whole = Series(worn, flat.errors, times, flat.kinds)
        alarm = first(whole, limits, BEFORE)
        if alarm is None:
            continue
        grown.append(float(times[alarm.at] - times[BEFORE]) / 7.0)
        n = alarm.at + 1 + MORE
        then = Series(worn[:n], flat.errors[:n], times[:n], flat.kinds[:n])
        changes = first(then, limits, BEFORE).changes
        shapes.append(changes[0].shape)
        ramps += [c for c in changes if c.shape == "ramp"]
    held = sum(7.0 * c.low <= weekly <= 7.0 * c.high for c in ramps)
    return {
        "twins": twins,
        "told": round(len(grown) / twins, 3),
        "mean delay, weeks": round(float(np.mean(grown)), 2),
        "10 logs after the alarm": {
            "likelier a ramp": round(shapes.count("ramp") / len(shapes), 3),
            "median slope, % a week": round(
                700 * float(np.median([c.size for c in ramps])) / LEVEL, 2
            ),
            "intervals that hold 1 %": round(held / len(ramps), 3),
        },
    }


def sizes(changes: list[Any], truth: float) -> dict[str, float]:
    """Mean size beside the truth's, and the share of intervals that hold it."""
    told = [c for each in changes for c in each if c.shape == "step"]
    if not told:
        return {}
    held = sum(c.low <= truth <= c.high for c in told)
    return {
        "mean size, % of the level": round(
            100 * float(np.mean([c.size for c in told] or [0.0])) / LEVEL, 2
        ),
        "intervals that hold 15 %": round(held / len(told), 3),
    }


def table(document: dict[str, Any]) -> str:
    """The measurements as a table."""
    heads = (
        "", "false alarms a year", "mean delay", "in 3 logs", "size, %", "held", "wear told",
        "slope, % a week", "held",
    )  # fmt: skip
    rows = [heads]
    for name in TWINS:
        if name not in document:
            continue
        step, steady = document[name]["step"], document[name].get("steady", {})
        low, high = steady.get("95 % interval", ("", ""))
        at = step["at the alarm"]
        worn = document[name].get("wear")
        slope = worn and worn["10 logs after the alarm"]
        rows.append((
            name, f"{steady.get('false alarms a year', '')} [{low}, {high}]",
            f"{step['mean delay, logs']}", f"{step['found within 3 logs']:.0%}",
            f"{at['mean size, % of the level']}", f"{at['intervals that hold 15 %']:.0%}",
            f"{worn['mean delay, weeks']} weeks" if worn else "",
            f"{slope['median slope, % a week']}" if worn else "",
            f"{slope['intervals that hold 1 %']:.0%}" if worn else "",
        ))  # fmt: skip
    return aligned(rows)


def scatter_table(document: dict[str, Any]) -> str:
    """False alarms by the way in which estimates scatter, as a table."""
    rows = [("200 logs a year, by scatter", "false alarms a year", "95 % interval")]
    for name, rate in document["scatter"].items():
        low, high = rate["95 % interval"]
        rows.append((name, f"{rate['false alarms a year']:.2f}", f"[{low:.2f}, {high:.2f}]"))
    return aligned(rows)


def aligned(rows: Sequence[tuple[str, ...]]) -> str:
    """Rows with their columns below each other, the first to the left."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "  ".join(cell.ljust(w) if k == 0 else cell.rjust(w) for k, (cell, w) in enumerate(pairs))
        for pairs in (list(zip(row, widths, strict=True)) for row in rows)
    ]
    return "\n".join(lines)


def main() -> None:
    """Measure and write."""
    parse = argparse.ArgumentParser(description=__doc__)
    parse.add_argument("--years", type=int, default=40)
    parse.add_argument("--twins", type=int, default=100)
    parse.add_argument("--quick", action="store_true", help="2 years and 4 twins; nothing is kept")
    parse.add_argument("--table", action="store_true", help="print what was measured, and stop")
    options = parse.parse_args()
    if options.table:
        kept = json.loads(OUT.read_text(encoding="utf-8"))
        print(f"{table(kept)}\n\n{scatter_table(kept)}")
        return
    years, twins = (2, 4) if options.quick else (options.years, options.twins)
    document: dict[str, Any] = {"command": " ".join(["python benchmarks/drift.py", *sys.argv[1:]])}
    document["scatter"] = {}
    for name, draw in SCATTER.items():
        document["scatter"][name] = scattered(draw, SCATTER_LOGS, years * SCATTER_YEARS)
        print(name, json.dumps(document["scatter"][name]), flush=True)
    for name, (logs, twin) in TWINS.items():
        document[name] = {"step": steps(logs, twin, twins)}
        print(name, json.dumps(document[name]), flush=True)
        if twin.logs == 1:
            document[name]["wear"] = wear(logs, twin, twins)
            print(name, json.dumps(document[name]["wear"]), flush=True)
        document[name]["steady"] = false_alarms(logs, twin, max(2, years * 365 // logs))
        print(name, json.dumps(document[name]["steady"]), flush=True)
        if not options.quick:
            OUT.write_text(f"{json.dumps(document, indent=1)}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
