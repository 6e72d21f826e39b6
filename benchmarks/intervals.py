"""Coverage of the intervals: foreign simulators' recordings, identified with the defaults.

    python benchmarks/run.py --only intervals
    python benchmarks/intervals.py [--only STUDY] [--count N]   some of them, to see how they do
    python benchmarks/intervals.py --only STUDY --show --keep   their counts into results.json

Every recording that is done is a line of intervals.part.jsonl, beside this file: a run that was
interrupted goes on from there. Once all are done it becomes intervals.jsonl, and the next run
begins anew.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest

import interval_axes
import run
from foreign_axes import Axis, noisy, recordings
from resumable import Answer, completed, lines
from stribeck import Fit, identify
from stribeck.errors import InputError
from stribeck.report.table import Cell, Table
from stribeck.rig.lookup import rig_named

FOLDER = Path(__file__).parent
PART, WHOLE = "intervals.part.jsonl", "intervals.jsonl"
#: One identified recording: its study and number, and its estimates.
Row = Answer

VERDICTS = ("identified", "weak", "not identifiable")
#: Goal for the coverage of nominal 95 % intervals, of identified parameters and of all.
GOAL = (0.92, 0.98)
#: Data sets a bootstrap draws here; a user's default is 200.
DRAWS = 60
#: Half of a normal distribution lies within so many standard deviations.
QUARTILE = 0.6745
#: Samples in which noise that remembers falls to 1 / e.
MEMORY = 50.0
#: What the logs of laws with states are whose force is measured.
DRIVEN = (
    "A minute at 1 kHz, sines within and beyond the bristles' way and strokes at 0.5 to 50 mm/s; "
    "an encoder's step of 0.2 to 2 % of the way and noise of half of it, noise of 1 % of F_C on "
    "the force."
)


@dataclass(frozen=True)
class Study:
    """One kind of recordings.

    Args:
        title: of its table.
        axis: axis number k.
        count: how many, and how many in a short pass.
        memory: of the sensors' noise, samples; 0 for white noise.
        draws: data sets of the bootstrap; 0 for none.
        note: below the table.
    """

    title: str
    axis: Callable[[int], Axis]
    count: tuple[int, int]
    memory: float = 0.0
    draws: int = 0
    note: str = ""


STUDIES = {
    "bed": Study(
        "Slide beds, their constants within the tolerances of the default rig",
        interval_axes.slide,
        (150, 2),
        note="A ramp of a minute each, in turn rightward and leftward; noise of 0.05 to 0.5 mm, "
        "20 to 200 Hz.",
    ),
    "balance": Study(
        "Forced slides, noise on the force that forgets within fifty samples",
        interval_axes.balance,
        (200, 2),
        memory=MEMORY,
        draws=DRAWS,
        note="24 s at 1 kHz, 0.5 to 5 N of noise before filtering.",
    ),
    "cylinder": Study(
        "Cylinders", interval_axes.cylinders, (200, 2), note="Three logs each, 1 kHz."
    ),
    "pendulum": Study(
        "Servo pendulums, their duty within its tolerance",
        interval_axes.swing,
        (50, 1),
        note="Three logs each, 100 Hz, 0.5 to 3 mrad of noise.",
    ),
    "joint": Study(
        "Robot joints that stick and slip",
        interval_axes.robot,
        (50, 1),
        note="16 s at 100 Hz, 0.2 to 1 mrad of noise.",
    ),
    "dahl": Study(
        "Dahl's bristles",
        interval_axes.dahl,
        (50, 1),
        note="Six cycles that grow until the axis slides; noise of 1 to 5 % of the bristles' way.",
    ),
    "lugre": Study(
        "LuGre's bristles",
        interval_axes.lugre,
        (50, 1),
        note="Six cycles that grow until the axis slides; noise of 1 to 5 % of the bristles' way.",
    ),
    "driven-gms": Study(
        "Two generalised Maxwell elements, driven by the measured motion",
        interval_axes.driven_gms,
        (50, 1),
        note=DRIVEN,
    ),
    "driven-lugre": Study(
        "LuGre's bristles, driven by the measured motion",
        interval_axes.driven_lugre,
        (50, 1),
        note=DRIVEN,
    ),
    "two-masses": Study(
        "Motor and load with play between them, an encoder on each",
        interval_axes.two_masses,
        (60, 1),
        note="3 s at 500 Hz under a servo loop; play of 20 to 400 um, 50 to 110 Hz of the two "
        "masses against each other; 0.5 to 2 um of noise at the motor, 0.5 to 5 um at the load.",
    ),
}


def measure(quick: bool = False) -> dict[str, Any]:
    """Identify all recordings that are not in the file yet, and count.

    Args:
        quick: A few of each kind.
    """
    folder = FOLDER / "quick" if quick else FOLDER
    folder.mkdir(exist_ok=True)
    jobs = [(name, k) for name, s in STUDIES.items() for k in range(s.count[quick])]
    rows = identified(folder / PART, jobs)
    (folder / PART).replace(folder / WHOLE)
    return summary(rows)


# --- recordings, one by one -----------------------------------------------------------------------


def identified(file: Path, jobs: Sequence[tuple[str, int]]) -> list[Row]:
    """The rows of pairs of study and recording, in their order; missing ones are identified."""
    return completed(file, jobs, identified_row, lambda row: (row["study"], row["k"]))


def identified_row(name: str, k: int) -> Row:
    """The identification of recording k of a study, or the reason of its refusal."""
    study = STUDIES[name]
    axis = study.axis(k)
    tables = noisy(axis, np.random.default_rng(k), study.memory)
    header = {"study": name, "k": k}
    start_time, start_cpu = time.perf_counter(), time.process_time()
    try:
        rig = rig_named(axis.rig).set(**axis.given)
        fit = identify(recordings(axis, tables), rig=rig, law=axis.law, bootstrap=study.draws)
    except InputError as error:
        return header | {"seconds": 0.0, "refused": str(error), "parameters": {}}
    return header | {
        "misfit": fit.score.value,
        "seconds": round(time.perf_counter() - start_time, 2),
        "cpu": round(time.process_time() - start_cpu, 2),
        "parameters": _parameters(fit, axis),
        "violations": [f"{v.condition}: {v.sentence}" for v in fit.violations],
    }


def _parameters(fit: Fit, axis: Axis) -> dict[str, Row]:
    """The estimate of each parameter, and of the sums with constants that are known better."""
    names = (q.name for q in fit.parameters.free)
    errors = dict(zip(names, fit.uncertainty.errors.tolist(), strict=False))
    rows: dict[str, Row] = {}
    for q, e in zip(fit.parameters.every, fit.estimates, strict=True):
        if e.verdict != "fixed":
            rows[q.name] = {
                "truth": _short(axis.truth[q.name]),
                "value": _short(e.value),
                "error": _short(errors.get(q.name, math.nan)),
                "interval": [_short(e.low), _short(e.high)],
                "ended": [e.low_ended, e.high_ended],
                "verdict": e.verdict,
                "reason": e.reason,
                "resampled": e.resampled and [_short(x) for x in e.resampled],
            }
    for c in fit.combinations:
        if c.constant in axis.constants:
            rows[f"{c.parameter} + {c.constant}"] = {
                "truth": _short(axis.truth[c.parameter] + axis.constants[c.constant]),
                "value": _short(c.value),
                "error": None,
                "interval": [_short(c.low), _short(c.high)],
                "verdict": c.verdict,
                "resampled": None,
            }
    return rows


def _short(value: float) -> float | None:
    return float(f"{value:.7g}") if math.isfinite(value) else None


# --- counting -------------------------------------------------------------------------------------


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """The counts of every study."""
    by: dict[str, list[Row]] = {}
    for row in rows:
        by.setdefault(row["study"], []).append(row)
    return {"draws": DRAWS, "studies": {name: study(group) for name, group in by.items()}}


def study(rows: Sequence[Row]) -> dict[str, Any]:
    """The counts of one study, for each parameter and for all together."""
    refused = [r["refused"] for r in rows if "refused" in r]
    recordings, rows = len(rows), [r for r in rows if "refused" not in r]
    names = dict.fromkeys(n for r in rows for n in r["parameters"])
    counted: dict[str, Any] = {
        n: _counts([r["parameters"][n] for r in rows if n in r["parameters"]]) for n in names
    }
    counted["all"] = _counts([p for r in rows for p in r["parameters"].values()])
    missed = [
        [r["k"], name, p["verdict"]]
        for r in rows
        for name, p in r["parameters"].items()
        if not _inside(p)
    ]
    return {
        "recordings": recordings,
        "refused": len(refused),
        "refusals": sorted(set(refused)),
        "missed": [" ".join(map(str, m)) for m in missed],
        "seconds": float(np.median([r["seconds"] for r in rows])) if rows else None,
        "cpu": float(np.median([r.get("cpu", np.nan) for r in rows])) if rows else None,
        "parameters": counted,
    }


def _counts(rows: Sequence[Row]) -> dict[str, Any]:
    by = {v: coverage([p for p in rows if p["verdict"] == v]) for v in VERDICTS}
    drawn = [p for p in rows if p["resampled"] and None not in p["resampled"]]
    return {
        **by,
        "every": coverage(rows),
        "bootstrap": {
            estimates: coverage([p for p in drawn if p["verdict"] in verdicts], "resampled")
            for estimates, verdicts in (("identified", VERDICTS[:1]), ("every", VERDICTS))
        }
        if drawn
        else None,
        "z": _z(rows),
    }


def coverage(rows: Sequence[Row], key: str = "interval") -> dict[str, Any]:
    """The share of intervals that hold the truth, with its 95 % interval.

    The half-width is the median of half the interval over the value.
    """
    inside = sum(_inside(p, key) for p in rows)
    widths = [(p[key][1] - p[key][0]) / 2 / abs(p["value"]) for p in rows if p["value"]]
    return {
        "of": len(rows),
        "held": inside,
        "share": list(binomial(inside, len(rows))),
        "half_width": float(np.median(widths)) if widths else None,
    }


def _inside(p: Row, key: str = "interval") -> bool:
    return bool(p[key][0] <= p["truth"] <= p[key][1])


def _z(rows: Sequence[Row]) -> float | None:
    """The scale of errors over standard errors, from their median; 1 if these are right."""
    z = [abs(p["value"] - p["truth"]) / p["error"] for p in rows if p["error"]]
    return float(np.median(z)) / QUARTILE if z else None


def binomial(hits: int, trials: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share (1927, doi 10.1080/01621459.1927.10502953)."""
    if not trials:
        return 0.0, 1.0
    interval = binomtest(hits, trials).proportion_ci(0.95, method="wilson")
    return float(interval.low), float(interval.high)


# --- tables ---------------------------------------------------------------------------------------


def tables(results: dict[str, Any]) -> list[str]:
    """The counts, in Markdown."""
    return [_table(STUDIES[n], counts).markdown() for n, counts in results["studies"].items()]


def _table(study: Study, counts: dict[str, Any]) -> Table:
    counted: dict[str, Any] = counts["parameters"]
    drawn = counted["all"]["bootstrap"] is not None
    heads = ("parameter", "identified", "± / %", "weak", "± / %", "not identifiable", "every")
    rows = []
    for name, c in counted.items():
        cells = [Cell.label(name), *_coverage_cells(c["identified"]), *_coverage_cells(c["weak"])]
        cells += [_coverage_cells(c["not identifiable"])[0], _coverage_cells(c["every"])[0]]
        if drawn:
            cells += [
                _coverage_cells(c["bootstrap"][verdict])[0] for verdict in ("identified", "every")
            ]
        rows.append((*cells, Cell.number(math.nan if c["z"] is None else c["z"], 3)))
    return Table(
        f"{study.title}: how often a nominal 95 % interval holds the truth",
        (*heads, *(("bootstrap: identified", "every") if drawn else ()), "z"),
        tuple(rows),
        " ".join(_notes(study, counts)),
    )


def _coverage_cells(c: dict[str, Any]) -> tuple[Cell, Cell]:
    if not c["of"]:
        return Cell("–"), Cell("–")
    low, high = c["share"]
    text = f"{c['held']}/{c['of']}, {100 * low:.1f} to {100 * high:.1f} %"
    return Cell.label(text), Cell.number(100 * (c["half_width"] or math.nan), 2)


def _notes(study: Study, counts: dict[str, Any]) -> Iterable[str]:
    yield f"{counts['recordings']} recordings. {study.note}"
    if counts.get("cpu"):
        yield f"Median of the processor's time: {counts['cpu']:.2g} s."
    if counts["refused"]:
        yield f"{counts['refused']} were refused: {' '.join(f'“{r}”' for r in counts['refusals'])}."
    yield "Held/of, and the 95 % interval of that share (Wilson);"
    yield "±: median half-width over the value;"
    yield "z: error over standard error, the median over the normal's 0.6745, 1 if it is right."
    goal = f"{GOAL[0]:.0%} to {GOAL[1]:.0%}"
    yield f"Goal: {goal} of the identified, and of all: {_met(counts['parameters'])}."


def _met(counted: dict[str, Any]) -> str:
    """What misses the goal, by its share and by the share's interval: parameters, and all."""
    low, high = GOAL
    missed: list[str] = []
    insignificant: list[str] = []
    classes = [(name, by["identified"]) for name, by in counted.items()]
    for name, c in [*classes, ("every estimate", counted["all"]["every"])]:
        if not c["of"] or low <= c["held"] / c["of"] <= high:
            continue
        significant = c["share"][1] < low or c["share"][0] > high
        (missed if significant else insignificant).append(f"{name} ({c['held']}/{c['of']})")
    clauses = [f"missed by {', '.join(missed)}"] if missed else []
    clauses += (
        [f"outside, but within the interval of their share: {', '.join(insignificant)}"]
        if insignificant
        else []
    )
    return "; ".join(clauses) or "met by each"


# --- some studies ---------------------------------------------------------------------------------


def _keep(studies: dict[str, Any]) -> None:
    """Put the counts of some studies beside those of the others."""
    results = run.read(run.RESULTS)["intervals"]["found"]
    known = results["studies"] | studies
    run.renew("intervals", results | {"studies": {n: known[n] for n in STUDIES if n in known}})


def main() -> None:
    """Identify some recordings, and print how often their intervals hold the truth."""
    ask = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    ask.add_argument("--only", action="append", choices=STUDIES, help="this study")
    ask.add_argument("--count", type=int, help="of recordings of each")
    ask.add_argument("--file", type=Path, default=FOLDER / PART, help="where answers are kept")
    ask.add_argument("--show", action="store_true", help="identify nothing")
    ask.add_argument("--keep", action="store_true", help="put the counts into results.json")
    options = ask.parse_args()
    chosen = options.only or list(STUDIES)
    if not options.show:
        for name in chosen:
            count = options.count or STUDIES[name].count[0]
            identified(options.file, [(name, k) for k in range(count)])
    rows = [row for row in lines(options.file) if row["study"] in chosen]
    counted = summary(rows)["studies"]
    if options.keep:
        _keep(counted)
    for name, counts in counted.items():
        print(_table(STUDIES[name], counts).text())
        print("missed:", "; ".join(counts["missed"]), end="\n\n")


if __name__ == "__main__":
    main()
