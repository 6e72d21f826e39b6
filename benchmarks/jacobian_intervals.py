"""Intervals of `identify` beside those of the Jacobian, on logs of known truth.

    python benchmarks/jacobian_intervals.py [--only KIND] [--count N]
    python benchmarks/jacobian_intervals.py --show

The logs are the first of each kind of the coverage study (`interval_axes`), from simulators that
share nothing with ours. The opponent is what a least-squares fit prints beside its estimates:
s² (JᵀJ)⁻¹ at the minimum, times Student's t, the rig's constants taken as exact and the residuals
as independent (`scipy.optimize.curve_fit`, lmfit, `mujoco.sysid.calculate_intervals`). It has our
model, and starts at our answer, so that intervals alone differ. A force balance has its ordinary
standard errors, those that are published for the EMPS.

Each log is a line of jacobian_intervals.part.jsonl until all are done; an interrupted run goes on
there. Counts go to jacobian_intervals.json.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from foreign_axes import noisy, recordings
from intervals import STUDIES
from resumable import Answer, completed
from stribeck import Fit, identify
from stribeck.errors import InputError
from stribeck.identify.problem import MotionProblem
from stribeck.report.table import Table
from stribeck.rig.lookup import rig_named
from stribeck.space import Array

FILE = Path(__file__).with_suffix(".json")
PART = FILE.with_suffix(".part.jsonl")
#: Kinds of axes by their study, as the table names them.
KINDS = {
    "bed": "slide bed that sticks and slips",
    "joint": "robot joint that sticks and slips",
    "pendulum": "servo pendulum, three logs",
    "balance": "slide with measured force",
}
COUNT = 20
#: Length of the central differences, in search ranges.
DIFFERENCE = 1e-4


def compared(kind: str, k: int) -> Answer:
    """Both intervals of each parameter of log k of a kind, or the reason of a refusal."""
    study = STUDIES[kind]
    axis = study.axis(k)
    logs = recordings(axis, noisy(axis, np.random.default_rng(k), study.memory))
    rig = rig_named(axis.rig).set(**axis.given)
    answer: Answer = {"kind": kind, "k": k}
    try:
        fit = identify(logs, rig=rig, law=axis.law)
    except InputError as error:
        return answer | {"refused": str(error), "parameters": {}}
    ends = _ordinary(fit) if fit.balance else _jacobian(fit)
    rows = {
        e.name: {
            "truth": axis.truth[e.name], "low": e.low, "high": e.high, "verdict": e.verdict,
            "jacobian": ends[e.name],
        }
        for e in fit.estimates if e.name in ends
    }  # fmt: skip
    return answer | {"parameters": rows}


def _ordinary(fit: Fit) -> dict[str, tuple[float, float]]:
    """The intervals of ordinary least squares of a force balance."""
    assert fit.balance is not None  # noqa: S101 - the caller has looked
    solved = fit.balance
    far = float(student.ppf(0.975, solved.rows - len(solved.names)))
    return {
        name: _ends(fit.values[name], far * solved.standard_error(name)) for name in solved.names
    }


def _jacobian(fit: Fit) -> dict[str, tuple[float, float]]:
    """The intervals of the Jacobian at the minimum that is nearest to our answer."""
    cost = MotionProblem(fit.parameters, fit.train)
    names = cost.space.names

    def residuals(u: Array) -> Array:
        shown: Array = cost.residuals(cost.space.decode(u[None]))[0]
        return shown

    (start,) = cost.space.encode(np.array([[fit.values[name] for name in names]]))
    steps = np.full(len(names), DIFFERENCE)
    solved = least_squares(
        residuals, np.clip(start, 0.0, 1.0), "3-point", (0.0, 1.0), diff_step=steps
    )
    freedom = len(solved.fun) - len(names)
    slopes: Array = np.asarray(solved.jac)
    covariance = np.linalg.pinv(slopes.T @ slopes) * 2.0 * solved.cost / freedom
    half = student.ppf(0.975, freedom) * np.sqrt(np.diag(covariance))
    lows, highs = cost.space.decode(np.stack([solved.x - half, solved.x + half]))
    return {name: (float(a), float(b)) for name, a, b in zip(names, lows, highs, strict=True)}


def _ends(value: float, half: float) -> tuple[float, float]:
    return value - half, value + half


def counted(answers: Sequence[Answer]) -> dict[str, Any]:
    """Counts of a kind: logs, parameters, intervals that hold the truth, and their widths."""
    rows = [row for answer in answers for row in answer["parameters"].values()]
    named = [row for row in rows if row["verdict"] == "identified"]
    ratios = [
        (row["high"] - row["low"]) / (row["jacobian"][1] - row["jacobian"][0]) for row in rows
    ]
    return {
        "logs": len(answers),
        "refused": sum("refused" in answer for answer in answers),
        "parameters": len(rows),
        "ours": sum(row["low"] <= row["truth"] <= row["high"] for row in rows),
        "jacobian": sum(_held(row) for row in rows),
        "identified": len(named),
        "identified, ours": sum(row["low"] <= row["truth"] <= row["high"] for row in named),
        "identified, jacobian": sum(_held(row) for row in named),
        "wider": float(np.median(ratios)) if ratios else math.nan,
    }


def _held(row: Answer) -> bool:
    low, high = row["jacobian"]
    return bool(low <= row["truth"] <= high)


def table(counts: dict[str, Any]) -> Table:
    """A row for each kind of axis, and one of all."""
    numbers = [name for name in next(iter(counts.values())) if name != "wider"]
    rows = {KINDS[kind]: row for kind, row in counts.items()}
    rows["all"] = {name: sum(row[name] for row in counts.values()) for name in numbers}
    logs, all_ = rows["all"]["logs"], rows["all"]
    refused = f"; {all_['refused']} logs were refused" if all_["refused"] else ""
    return Table.of_texts(
        f"Of the true parameters in {logs} logs of foreign simulators, 95 % intervals hold",
        ("axis", "logs", "ours", "Jacobian's", "identified: ours", "Jacobian's", "times as wide"),
        (
            (
                name,
                str(row["logs"]),
                _share(row["ours"], row["parameters"]),
                _share(row["jacobian"], row["parameters"]),
                _share(row["identified, ours"], row["identified"]),
                _share(row["identified, jacobian"], row["identified"]),
                f"{row['wider']:.1f}" if "wider" in row else "",
            )
            for name, row in rows.items()
        ),
        note="Both from the same model at the same minimum. Times as wide: our interval over the "
        f"Jacobian's, median{refused}.",
    )


def _share(held: int, of: int) -> str:
    return f"{held} of {of}"


def main() -> None:
    """Compare the logs of some kinds, and print the table."""
    ask = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    ask.add_argument("--only", action="append", choices=KINDS, help="this kind of axis")
    ask.add_argument("--count", type=int, default=COUNT, help="of logs of each kind")
    ask.add_argument("--show", action="store_true", help="what is kept, and nothing new")
    chosen = ask.parse_args()
    if chosen.show:
        print(table(json.loads(FILE.read_text(encoding="utf-8"))).text())
        return
    kinds = chosen.only or list(KINDS)
    jobs = [(kind, k) for kind in kinds for k in range(chosen.count)]
    answers = completed(PART, jobs, compared, lambda answer: (answer["kind"], answer["k"]))
    counts = {kind: counted([a for a in answers if a["kind"] == kind]) for kind in kinds}
    if kinds == list(KINDS) and chosen.count == COUNT:
        FILE.write_text(json.dumps(counts, indent=1) + "\n", encoding="utf-8")
    print(table(counts).text())


if __name__ == "__main__":
    main()
