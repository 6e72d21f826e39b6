"""The fault table: axes that are not what their rig assumes, identified with the defaults.

    python benchmarks/run.py --only faults
    python benchmarks/faults.py [--only WORDS] [--file FILE]   some rows, or answers of one's own

Every row and seed that is done is a line of faults.part.jsonl, beside this file: a run that was
interrupted goes on from there.
"""

from __future__ import annotations

import argparse
import math
import re
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fault_rows import ROWS, Row, axis_of
from foreign_axes import Axis, noisy, recordings
from intervals import binomial
from resumable import Answer, completed, lines
from stribeck import RIGS, Fit, identify
from stribeck.errors import InputError
from stribeck.report.table import Cell, Table
from stribeck.rig import Rig

FOLDER = Path(__file__).parent
PART, WHOLE = "faults.part.jsonl", "faults.jsonl"
#: An identified value that is further off than this, its interval without the truth, is a lie.
OFF = 0.03
#: Conditions that hold on an axis without a fault: its constants may be uncertain all the same.
FAULTS = {"data", "model", "arithmetic", "search"}
#: Characters of a sentence in the table.
SHORT = 90
#: A parameter's name in a sentence is no part of a longer one.
NAME = r"(?<![\w]){}(?![\w])"


def measure(quick: bool = False) -> dict[str, Any]:
    """Identify all rows that are not in the file yet, and count.

    Args:
        quick: Two rows of each kind, one seed.
    """
    folder = FOLDER / "quick" if quick else FOLDER
    folder.mkdir(exist_ok=True)
    answers = answered(folder / PART, ROWS, seeds=1 if quick else None)
    (folder / PART).replace(folder / WHOLE)
    return summary(answers)


def answered(file: Path, rows: Sequence[Row], seeds: int | None = None) -> list[Answer]:
    """The answers of rows, seed by seed; missing ones are identified."""
    jobs = [(row.key, k) for row in rows for k in range(seeds or row.seeds)]
    return completed(file, jobs, answer, lambda a: (a["key"], a["seed"]))


def answer(key: str, seed: int) -> Answer:
    """The identification of a row with a seed, or the reason of its refusal."""
    row = next(row for row in ROWS if row.key == key)
    axis = axis_of(row)
    rng = np.random.default_rng(seed)
    tables = noisy(axis, rng)
    for fault in row.faults:
        tables = [fault.applied(table, rng) for table in tables]
    header = {"key": key, "seed": seed}
    start_time = time.perf_counter()
    try:
        logs = recordings(axis, tables)
        fit = identify(logs, rig=_rig(row, axis), law=axis.law)
    except InputError as error:
        return header | {
            "seconds": 0.0,
            "refused": str(error),
            "parameters": {},
            "sentences": [],
            "conditions": [],
        }
    sentences = [*fit.warnings, *(note for log in logs for note in log.notes)]
    return header | {
        "seconds": round(time.perf_counter() - start_time, 2),
        "misfit": fit.score.value,
        "sentences": list(dict.fromkeys(sentences)),
        "conditions": sorted({v.condition for v in fit.violations}),
        "parameters": _parameters(fit, axis),
        "sums": [
            [c.parameter, c.constant, c.value, c.low, c.high, c.verdict] for c in fit.combinations
        ],
    }


def _rig(row: Row, axis: Axis) -> Rig:
    given = dict(axis.given) | dict(row.constants)
    rig = RIGS[axis.rig]
    return (rig.exact() if row.exact else rig).set(
        **{name: value for name, value in given.items() if value is not None}
    )


def _parameters(fit: Fit, axis: Axis) -> dict[str, Answer]:
    return {
        q.name: {
            "shown": e.name,
            "truth": axis.truth[q.name],
            "value": e.value,
            "interval": [e.low, e.high],
            "verdict": e.verdict,
            "reason": e.reason,
        }
        for q, e in zip(fit.parameters.every, fit.estimates, strict=True)
        if e.verdict != "fixed"
    }


# --- judging --------------------------------------------------------------------------------------


def summary(answers: Sequence[Answer]) -> dict[str, Any]:
    """The rows of the table, the silent lies, and the share of clean seeds with a false alarm."""
    by: dict[str, list[Answer]] = {}
    for a in answers:
        by.setdefault(a["key"], []).append(a)
    usual = {row.axis: _usual(row.axis, by) for row in ROWS}
    rows = [_judged(row, by[row.key], usual[row.axis]) for row in ROWS if row.key in by]
    clean = [r for r in rows if r["clean"]]
    alarms = sum(len(r["alarms"]) for r in clean)
    seeds = sum(r["seeds"] for r in clean)
    return {
        "rows": rows,
        "lies": sum(bool(r["lies"]) for r in rows),
        "alarms": alarms,
        "clean": seeds,
        "share": list(binomial(alarms, seeds)) if seeds else None,
    }


def _usual(axis: str, by: dict[str, list[Answer]]) -> set[str]:
    """Sentences of an axis without a fault, without their numbers."""
    keys = [row.key for row in ROWS if row.axis == axis and row.clean]
    return {_bare(s) for key in keys for a in by.get(key, []) for s in a["sentences"]}


def _bare(sentence: str) -> str:
    return re.sub(r"[-+−]?\d[\d.,e+-]*", "#", sentence)


def _judged(row: Row, answers: Sequence[Answer], usual: set[str]) -> dict[str, Any]:
    names = list(dict.fromkeys(n for a in answers for n in a["parameters"]))
    fitted = [a for a in answers if "refused" not in a]
    lies = {n: k for n in names if (k := sum(_lies(row, a, n, usual) for a in fitted))}
    return {
        "kind": row.axis,
        "exact": row.exact,
        "perturbation": row.perturbation,
        "clean": row.clean,
        "seeds": len(answers),
        "refused": len(answers) - len(fitted),
        "parameters": {n: _over_seeds([a["parameters"][n] for a in fitted]) for n in names},
        "told": _told(row, answers, usual),
        "lies": lies,
        "alarms": [a["seed"] for a in answers if _alarms(a)] if row.clean else [],
        "sums": [s for a in fitted for s in a["sums"]],
        "seconds": float(np.median([a["seconds"] for a in answers])),
    }


def _over_seeds(estimates: Sequence[Answer]) -> dict[str, Any]:
    verdicts = [e["verdict"] for e in estimates]
    return {
        "bias": float(np.median([e["value"] / e["truth"] - 1.0 for e in estimates])),
        "held": sum(_holds(e) for e in estimates),
        "identified": verdicts.count("identified"),
        "of": len(estimates),
    }


def _holds(e: Answer) -> bool:
    return bool(e["interval"][0] <= e["truth"] <= e["interval"][1])


def _lies(row: Row, a: Answer, name: str, usual: set[str]) -> bool:
    """Whether an identified value is off, its interval without the truth, and nothing said."""
    e = a["parameters"][name]
    off = abs(e["value"] - e["truth"]) > OFF * abs(e["truth"])
    return (
        e["verdict"] == "identified"
        and off
        and not _holds(e)
        and not any(_names(row, s, [e["shown"]], usual) for s in a["sentences"])
    )


def _names(row: Row, sentence: str, parameters: Sequence[str], usual: set[str]) -> bool:
    """Whether a sentence names the fault, or one of the parameters and is not said of any axis."""
    if _bare(sentence) in usual:
        return False
    if row.words and re.search(row.words, sentence, re.IGNORECASE):
        return True
    return any(re.search(NAME.format(re.escape(p)), sentence) for p in parameters)


def _alarms(a: Answer) -> bool:
    """Whether a fault is told of where there is none."""
    reasons = {p["reason"] for p in a["parameters"].values()}
    return "refused" in a or bool(FAULTS & {*a["conditions"], *reasons})


def _told(row: Row, answers: Sequence[Answer], usual: set[str]) -> str:
    """The first sentence that names the fault, or why it was refused."""
    for a in answers:
        if "refused" in a:
            return f"refused: {a['refused']}"
        for s in a["sentences"]:
            if row.words and re.search(row.words, s, re.IGNORECASE) and _bare(s) not in usual:
                return str(s)
    return ""


# --- tables ---------------------------------------------------------------------------------------


def tables(results: dict[str, Any]) -> list[str]:
    """One table for each kind of axis, in Markdown, and the counts."""
    kinds = dict.fromkeys(r["kind"] for r in results["rows"])
    return [
        *(_table(k, [r for r in results["rows"] if r["kind"] == k]).markdown() for k in kinds),
        _counts(results),
    ]


def _table(kind: str, rows: Sequence[dict[str, Any]]) -> Table:
    heads = ("perturbation", "bias / %", "told", "silent")
    return Table(TITLES[kind], heads, tuple(_cells(r) for r in rows), LEGEND)


TITLES = {
    "forced": "A slide under a measured force",
    "forced_pendulum": "A pendulum under a measured torque",
    "emps": "The published slide under its cascade",
    "rod": "A cylinder",
    "bed": "The slide bed",
    "pendulum": "A pendulum on a servo",
    "arm": "A robot joint",
    "bristles": "Below breakaway",
}
LEGEND = (
    "Bias: the median over the seeds, in % of the truth; in brackets where it is not identified in "
    "any seed, ! where an identified one's interval misses the truth."
)


def _cells(r: dict[str, Any]) -> tuple[Cell, ...]:
    biases = "; ".join(_bias(n, p) for n, p in r["parameters"].items())
    told = r["told"] if len(r["told"]) <= SHORT else r["told"][: SHORT - 1] + "…"
    constants = ", constants exact" if r["exact"] else ""
    return (
        Cell.label((r["perturbation"] or "none") + constants),
        Cell.label(biases or "–"),
        Cell.label(told or "–"),
        Cell.label(", ".join(r["lies"]) or "–"),
    )


def _bias(name: str, p: dict[str, Any]) -> str:
    percent = 100.0 * p["bias"]
    missed = "!" if p["held"] < p["of"] and p["identified"] else ""
    text = f"{name} {percent:+.1f}{missed}".replace("-", "−")
    return text if p["identified"] else f"({text})"


def _counts(results: dict[str, Any]) -> str:
    low, high = results["share"] or (math.nan, math.nan)
    faulty = [r for r in results["rows"] if not r["clean"]]
    return (
        f"{len(faulty)} perturbations, {results['lies']} with a silent lie: an identified value "
        f"more than {100 * OFF:g} % off, its interval without the truth, and no sentence that "
        f"names the fault or the parameter. False alarms: {results['alarms']} of "
        f"{results['clean']} logs without a fault ({100 * low:.1f} to {100 * high:.1f} %)."
    )


# --- some rows ------------------------------------------------------------------------------------


def _report(rows: Sequence[Row], answers: Sequence[Answer]) -> Iterator[str]:
    for r in summary(answers)["rows"]:
        if any(r["perturbation"] == row.perturbation and r["kind"] == row.axis for row in rows):
            flag = "LIE" if r["lies"] else "alarm" if r["alarms"] else "ok"
            yield " | ".join(
                [flag, r["kind"], *(c.text for c in _cells(r)), f"{r['seconds']:.1f} s"]
            )


def main() -> None:
    """Identify some rows, and print them."""
    ask = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    ask.add_argument("--only", default="", help="rows whose axis and perturbation match this")
    ask.add_argument("--file", type=Path, default=FOLDER / PART, help="where answers are kept")
    ask.add_argument("--seeds", type=int, help="of each row")
    ask.add_argument("--show", action="store_true", help="identify nothing")
    options = ask.parse_args()
    rows = [r for r in ROWS if re.search(options.only, f"{r.axis}: {r.perturbation}")]
    if not options.show:
        answered(options.file, rows, options.seeds)
    print("\n".join(_report(rows, lines(options.file))))


if __name__ == "__main__":
    main()
