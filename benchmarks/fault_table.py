"""The judge and the tables of `faults`: what is a silent lie, and what a false alarm."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fault_row import SET, Row
from fault_rows import ROWS
from intervals import binomial
from resumable import Answer
from stribeck.report.table import Cell, Table

#: An identified value that is further off than this, its interval without the truth, is a lie.
OFF = 0.03
#: Conditions that hold on an axis without a fault: its constants may be uncertain all the same.
FAULTS = {"data", "model", "arithmetic", "search"}
#: Characters of a sentence in the table.
SHORT = 90
#: Sentences that name parameters of any fit: what they move with, not what is wrong with them.
GENERAL = re.compile(
    r"taken as exact|in proportion|together with|hardly (see|tell)|not of this axis|the data .* see"
    r"|for each ms"
)
#: A parameter's name in a sentence is no part of a longer one.
NAME = r"(?<![\w]){}(?![\w])"


# --- judging --------------------------------------------------------------------------------------


def summary(answers: Sequence[Answer]) -> dict[str, Any]:
    """The rows of the table, the silent lies, and the share of clean seeds with a false alarm."""
    by: dict[str, list[Answer]] = {}
    for a in sorted(answers, key=lambda a: int(a["seed"])):  # not as they ended
        by.setdefault(a["key"], []).append(a)
    usual = {row.axis: _usual(row.axis, by) for row in ROWS}
    return totals([_judged(row, by[row.key], usual[row.axis]) for row in ROWS if row.key in by])


def totals(rows: Sequence[Answer]) -> dict[str, Any]:
    """Judged rows, the silent lies of them, and the share of clean seeds with a false alarm."""
    clean = [r for r in rows if r["clean"]]
    alarms = sum(len(r["alarms"]) for r in clean)
    seeds = sum(r["seeds"] for r in clean)
    return {
        "rows": list(rows),
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
    lies = {
        n: k
        for n in names
        if (k := sum(_lies(row, a, n, usual) for a in fitted if n in a["parameters"]))
    }
    return {
        "kind": row.axis,
        "exact": row.exact,
        "perturbation": row.perturbation,
        "clean": row.clean,
        "seeds": len(answers),
        "refused": len(answers) - len(fitted),
        "parameters": {
            n: _over_seeds([p for a in fitted if (p := a["parameters"].get(n))]) for n in names
        },
        "told": _told(row, answers, usual),
        "lies": lies,
        "alarms": [a["seed"] for a in answers if _alarms(a)] if row.clean else [],
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
    """Whether a sentence names the fault, or one of the parameters.

    One that is said of any axis counts where no log can show the fault.
    """
    if _bare(sentence) in usual or GENERAL.search(sentence):
        return row.standing and _matches(row, sentence)
    if _matches(row, sentence):
        return True
    return any(re.search(NAME.format(re.escape(p)), sentence) for p in parameters)


def _alarms(a: Answer) -> bool:
    """Whether a fault is told of where there is none."""
    reasons = {p["reason"] for p in a["parameters"].values()}
    contested = any(re.search(SET, s) for s in a["sentences"])
    return "refused" in a or contested or bool(FAULTS & {*a["conditions"], *reasons})


def _matches(row: Row, sentence: str) -> bool:
    return bool(row.words and re.search(row.words, sentence, re.IGNORECASE))


def _told(row: Row, answers: Sequence[Answer], usual: set[str]) -> str:
    """The first sentence that names the fault, or why it was refused."""
    for a in answers:
        if "refused" in a:
            return f"refused: {a['refused']}"
        for s in a["sentences"]:
            if _names(row, s, [], usual):
                return str(s)
    return ""


# --- tables ---------------------------------------------------------------------------------------


def tables(results: dict[str, Any]) -> list[str]:
    """The counts; the table is a page of its own."""
    return [f"{_counts(results)} The table: [docs/faults.md](../docs/faults.md)."]


def _table(kind: str, rows: Sequence[dict[str, Any]]) -> Table:
    heads = ("perturbation", "bias / %", "told", "silent")
    return Table(TITLES[kind], heads, tuple(cells(r) for r in rows))


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


def cells(r: dict[str, Any]) -> tuple[Cell, ...]:
    """One row: its perturbation, biases, what was told of it, and what is a lie."""
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
    clean = [r for r in results["rows"] if r["clean"]]
    silent = sum(bool(r["lies"]) for r in faulty)
    known = sum(p["identified"] for r in clean for p in r["parameters"].values())
    off = sum(sum(r["lies"].values()) for r in clean)
    return (
        f"{len(faulty)} perturbations, {silent} with a silent lie: an identified value "
        f"more than {100 * OFF:g} % off, its interval without the truth, and no sentence that "
        f"names the fault or the parameter. False alarms: {results['alarms']} of "
        f"{results['clean']} logs without a fault ({100 * low:.1f} to {100 * high:.1f} %). Of the "
        f"{known} identified values of these logs, too, {off} lie more than {100 * OFF:g} % off, "
        "outside an interval that one in twenty may miss: the last column of their rows."
    )


# --- the page -------------------------------------------------------------------------------------

PAGE = Path(__file__).parents[1] / "docs" / "faults.md"
HEAD = """# When an axis is not what its rig assumes

An estimate is "identified" on conditions: the data are what they seem, the constants of the rig are
right, the model leaves nothing out, the arithmetic is exact enough. Here each of them is broken on
purpose. Simulators that share no line with this package (`tests/foreign`) make logs of an axis that
differs from its rig in one way; each is written as a CSV file, read, and identified with the
defaults. What matters is the last column: a value that is called identified, is more than {off:g} %
off, has an interval without the truth, and not a sentence that names the fault or the parameter.

{counts}

Bias is the median over the seeds, in % of the truth; it stands in brackets where a parameter is
identified in no seed, and has an exclamation mark where the interval of an identified one misses
the truth. "Told" is the first sentence that names the fault. Rows without a perturbation, and those
in which a parameter is set to its true value, show what is said of an axis with which all is well.

`python benchmarks/run.py --only faults` makes the table (`benchmarks/fault_rows.py` has the rows),
and `python benchmarks/faults.py --only WORDS` a part of it.
"""


def page(results: dict[str, Any]) -> str:
    """docs/faults.md."""
    rows = results["rows"]
    texts = [
        _table(kind, [r for r in rows if r["kind"] == kind]).markdown().strip("\n") + "\n"
        for kind in dict.fromkeys(r["kind"] for r in rows)
    ]
    return "\n".join([HEAD.format(off=100 * OFF, counts=_counts(results)), *texts])
