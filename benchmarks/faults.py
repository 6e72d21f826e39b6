"""The fault table: axes that are not what their rig assumes, identified with the defaults.

    python benchmarks/run.py --only faults
    python benchmarks/faults.py --page                         and writes docs/faults.md of them
    python benchmarks/faults.py [--only WORDS] [--file FILE]   some rows, or answers of one's own
    python benchmarks/faults.py --only WORDS --show --keep     rows of whole axes into results.json

Every row and seed that is done is a line of faults.part.jsonl, beside this file: a run that was
interrupted goes on from there.
"""

from __future__ import annotations

import argparse
import json
import re
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import reproductions
import run
from fault_row import Row, axis_of
from fault_rows import ROWS
from fault_table import PAGE, cells, page, summary, tables, totals
from foreign_axes import Axis, noisy, recordings
from resumable import Answer, completed, lines
from stribeck import RIGS, Fit, identify
from stribeck.errors import InputError
from stribeck.friction import law_named
from stribeck.rig import Rig
from stribeck.rig.rig import shown_in

__all__ = ["measure", "tables"]

FOLDER = Path(__file__).parent
REPRODUCED = """## What earlier versions said

Faults that were met on logs like these, with what was said of them then and what is now. Biases and
counts are those of the tables above and of [validation.md](validation.md); the rest is tried by
`python benchmarks/reproductions.py`.
"""
PART, WHOLE = "faults.part.jsonl", "faults.jsonl"


def measure(quick: bool = False) -> dict[str, Any]:
    """Identify all rows that are not in the file yet, and count.

    Args:
        quick: One seed of each row.
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
    logged = noisy(axis, rng)
    for fault in row.faults:
        logged = [fault.applied(table, rng) for table in logged]
    header = {"key": key, "seed": seed}
    start_time = time.perf_counter()
    try:
        logs = recordings(axis, logged)
        rig = _rig(row, axis)
        fit = identify(logs, rig=rig, law=axis.law, fixed=_fixed(row, axis, rig))
    except InputError as error:
        return header | {
            "seconds": 0.0,
            "refused": str(error),
            "parameters": {},
            "sentences": [],
            "conditions": [],
        }
    sentences = [*fit.warnings, *fit.notes]
    return header | {
        "seconds": round(time.perf_counter() - start_time, 2),
        "misfit": fit.score.value,
        "sentences": list(dict.fromkeys(sentences)),
        "conditions": sorted({v.condition for v in fit.violations if v.caps}),
        "parameters": _parameters(fit, axis),
    }


def _rig(row: Row, axis: Axis) -> Rig:
    given = dict(axis.given) | dict(row.constants)
    rig = RIGS[axis.rig]
    return (rig.exact() if row.exact else rig).set(
        **{name: value for name, value in given.items() if value is not None}
    )


def _fixed(row: Row, axis: Axis, rig: Rig) -> dict[str, float]:
    """The parameters that the user of a row sets, in the units of the rig."""
    by_name = {q.name: q for q in rig.parameters(law_named(axis.law))}
    return {
        name: float(shown_in(rig, by_name[name], times * axis.truth[name]))
        for name, times in row.values.items()
    }


def _parameters(fit: Fit, axis: Axis) -> dict[str, Answer]:
    """The estimates, and those of the sums of a parameter and a constant that are known."""
    estimates = {
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
    sums = {
        f"{c.parameter} + {c.constant}": {
            "shown": c.parameter,
            "truth": axis.truth[c.parameter] + axis.constants[c.constant],
            "value": c.value,
            "interval": [c.low, c.high],
            "verdict": c.verdict,
            "reason": None,
        }
        for c in fit.combinations
        if c.constant in axis.constants
    }
    return estimates | sums


# --- some rows ------------------------------------------------------------------------------------


def _report(rows: Sequence[Row], answers: Sequence[Answer]) -> Iterator[str]:
    for r in summary(answers)["rows"]:
        if any(r["perturbation"] == row.perturbation and r["kind"] == row.axis for row in rows):
            flag = "LIE" if r["lies"] else "alarm" if r["alarms"] else "ok"
            yield " | ".join(
                [flag, r["kind"], *(c.text for c in cells(r)), f"{r['seconds']:.1f} s"]
            )


def _keep(rows: Sequence[Row], answers: Sequence[Answer]) -> None:
    """Put the rows of some axes beside those of the others; an axis is judged by all its rows."""
    axes = {row.axis for row in rows}
    jobs = {(row.key, k): row.axis for row in ROWS if row.axis in axes for k in range(row.seeds)}
    done = [a for a in answers if (a["key"], a["seed"]) in jobs]
    if lacking := {jobs[job] for job in jobs.keys() - {(a["key"], a["seed"]) for a in done}}:
        raise SystemExit(f"rows or seeds are not done yet: {', '.join(sorted(lacking))}")
    found = run.read(run.RESULTS)["faults"]["found"]["rows"]
    judged = summary(done)["rows"] + [r for r in found if r["kind"] not in axes]
    of_axis = {
        axis: zip(
            [row for row in ROWS if row.axis == axis],
            [r for r in judged if r["kind"] == axis],
            strict=True,
        )
        for axis in {row.axis for row in ROWS}
    }
    run.renew("faults", totals([next(of_axis[row.axis])[1] for row in ROWS]))


def whole_page(results: dict[str, Any]) -> str:
    """docs/faults.md, with what earlier versions said below the tables."""
    return f"{page(results)}\n{REPRODUCED}\n{reproductions.table().markdown()}"


def main() -> None:
    """Identify some rows, and print them."""
    ask = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    ask.add_argument("--only", default="", help="rows whose axis and perturbation match this")
    ask.add_argument("--file", type=Path, default=FOLDER / PART, help="where answers are kept")
    ask.add_argument("--seeds", type=int, help="of each row")
    ask.add_argument("--show", action="store_true", help="identify nothing")
    ask.add_argument("--page", action="store_true", help="write docs/faults.md of what is measured")
    ask.add_argument("--keep", action="store_true", help="put rows into results.json")
    options = ask.parse_args()
    if options.page:
        part = json.loads((FOLDER / "results.json").read_text(encoding="utf-8"))["faults"]
        PAGE.write_text(whole_page(part["found"]), encoding="utf-8")
        return
    rows = [r for r in ROWS if re.search(options.only, f"{r.axis}: {r.perturbation}")]
    if not options.show:
        answered(options.file, rows, options.seeds)
    if options.keep:
        _keep(rows, lines(options.file))
    print("\n".join(_report(rows, lines(options.file))))


if __name__ == "__main__":
    main()
