"""Laws that contain each other on two servos: none may end above one that it contains.

    python benchmarks/nested_laws.py [xl330|go1 ...] [--seeds 3] [--laws m1,m2,...] [--intervals]

Each answer of a search, or with `--intervals` each whole identification, goes to nested_laws.json
at once; an interrupted run continues there. The recordings are
read from `../shared/data` (see docs/axes.md). go1 is a torque-controlled motor, taken as one of
25.05 V whose constants are free: its m1 has the same equation.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np

from axis_servo import LAWS, RIG
from stribeck import identify, read
from stribeck.data.recording import Recording
from stribeck.friction import law_named
from stribeck.identify.loss import Loss
from stribeck.identify.multistart import multistart
from stribeck.identify.problem import MotionProblem, problem
from stribeck.identify.search_settings import SearchSettings
from stribeck.report.table import Table
from stribeck.rig.rig import Rig

FILE = Path(__file__).with_name("nested_laws.json")
DATA = Path(__file__).parents[2] / "shared" / "data"
#: Laws that contain others.
CONTAINS = {
    "m2": ("m1",), "m3": ("m1",), "m4": ("m1", "m2", "m3"), "m5": ("m1", "m2", "m3", "m4"),
    "m6": ("m1", "m2", "m3", "m4", "m5"),
}  # fmt: skip
#: A law that ends above one that it contains by less than this share has met the same minimum.
SAME = 2e-3
#: The volts at which a go1 has its greatest torque, 25.05 N m, at k_t = R.
VOLTS = 25.05
#: Ranges of the go1.
_RANGES = {
    "R": (0.05, 20.0), "k_t": (0.05, 2.0), "armature": (1e-3, 1e-1),
    **dict.fromkeys(("F_S", "F_C", "F_V", "K_c", "K_v", "K_cs"), (0.0, 0.5)),
}  # fmt: skip


def axis(name: str) -> tuple[Rig, list[Recording], dict[str, tuple[float, float]]]:
    """A rig, its logs and the ranges that differ from the rig's."""
    if name == "xl330":
        files = sorted((DATA / "bam_xl330" / "logs").glob("*.json"))
        return RIG, [read(file, columns=dict(RIG.columns)) for file in files], {}
    rig = replace(
        RIG,
        name="go1",
        constants=tuple(
            replace(c, value=1 / VOLTS) if c.name == "duty" else c for c in RIG.constants
        ),
    )
    return rig, [_go1(file) for file in sorted((DATA / "go1").glob("*.json"))], _RANGES


def _go1(file: Path) -> Recording:
    log = json.loads(file.read_text(encoding="utf-8"))
    entries = log["entries"]

    def series(name: str) -> np.ndarray:
        return np.array([float(entry[name]) for entry in entries])

    whole = {"mass": log["mass"] + log["arm_mass"] / 2, "length": log["length"], "kp": log["kp"]}
    constant = {n: np.full(len(entries), float(v)) for n, v in (whole | {"vin": VOLTS}).items()}
    return Recording(
        t=series("timestamp"), position=series("position"), command=series("goal_position"),
        velocity=series("speed"), rotary=True,
        extra=constant | {"torque_enable": series("torque_enable")},
    )  # fmt: skip


def searched(name: str, law: str, loss: Loss, seed: int) -> dict[str, Any]:
    """One search as an identification begins with it: before constants are free, no intervals."""
    rig, logs, ranges = axis(name)
    whole = problem(logs, rig=rig, law=LAWS[law], loss=loss, bounds=_own(rig, law, ranges))
    wall, used = time.perf_counter(), time.process_time()
    optimum = multistart(whole, SearchSettings(seed=seed))
    assert isinstance(optimum.problem, MotionProblem)  # noqa: S101 - servos start as measured
    return {
        "error": optimum.problem.reported(optimum.x),
        "evaluations": optimum.search.evaluations,
        "ended": optimum.search.ended,
        "seconds": time.perf_counter() - wall,
        "processor_seconds": time.process_time() - used,
    }


def fitted(name: str, law: str, loss: Loss, seed: int) -> dict[str, Any]:
    """One identification as a user calls it."""
    rig, logs, ranges = axis(name)
    wall, used = time.perf_counter(), time.process_time()
    fit = identify(
        logs, rig=rig, law=LAWS[law], bounds=_own(rig, law, ranges), loss=loss, seed=seed
    )
    assert fit.uncertainty is not None  # noqa: S101 - an output-error fit has one
    ends = [end for e in fit.estimates for end in (e.low_ended, e.high_ended) if end]
    return {
        "error": fit.score.value,
        "evaluations": fit.search.evaluations,
        "rows": fit.uncertainty.rows,
        "guessed": ends.count("budget"),
        "ends": len(ends),
        "ended": fit.search.ended,
        "seconds": time.perf_counter() - wall,
        "processor_seconds": time.process_time() - used,
        "estimates": {e.name: [e.value, e.low, e.high, e.verdict] for e in fit.estimates},
    }


def _own(
    rig: Rig, law: str, ranges: dict[str, tuple[float, float]]
) -> dict[str, tuple[float, float]]:
    names = {q.name for q in rig.parameters(law_named(LAWS[law]))}
    return {n: ends for n, ends in ranges.items() if n in names}


def measured(
    names: list[str], laws: list[str], losses: list[Loss], seeds: int, *, intervals: bool
) -> dict[str, Any]:
    """All answers, each kept as soon as it is there."""
    results: dict[str, Any] = _kept()
    for law in laws:
        for seed in range(seeds):
            for name in names:
                for loss in losses:
                    key = f"{name}/{loss}/{law}/{seed}" + ("/intervals" if intervals else "")
                    if key not in results:
                        row = (fitted if intervals else searched)(name, law, loss, seed)
                        results = _kept() | {key: row}  # another process may have added some
                        FILE.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
                        print(key, f"{row['error']:.2f}", flush=True)
    return results


def _kept() -> dict[str, Any]:
    return dict(json.loads(FILE.read_text(encoding="utf-8"))) if FILE.exists() else {}


def broken(results: dict[str, Any]) -> Iterator[str]:
    """Laws that ended above one that they contain, from the same seed."""
    for key, row in results.items():
        name, loss, law, *rest = key.split("/")
        for simple in CONTAINS.get(law, ()):
            other = results.get("/".join([name, loss, simple, *rest]))
            if other is not None and row["error"] > (1 + SAME) * other["error"]:
                yield f"{key}: {row['error']:.2f} above {simple}'s {other['error']:.2f}"


def table(results: dict[str, Any]) -> str:
    """A row for each law, loss and axis: errors by seed, and the medians of what they took."""
    rows: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for key in sorted(results):
        name, loss, law, _, *rest = key.split("/")
        rows.setdefault((name, loss, law, *rest), []).append(results[key])
    return Table.of_texts(
        "Errors of answers by seed / mrad (RMS by squares, mean by absolute errors)",
        ("axis", "loss", "law", "by seed", "search", "intervals", "guessed", "processor / s"),
        (
            (
                name,
                loss,
                law,
                ", ".join(f"{row['error']:.2f}" for row in some),
                _median(some, "evaluations"),
                _median(some, "rows") if rest else "",
                f"{_total(some, 'guessed')} of {_total(some, 'ends')}" if rest else "",
                _median(some, "processor_seconds"),
            )
            for (name, loss, law, *rest), some in rows.items()
        ),
        labels=range(4),
    ).text()


def _total(rows: list[dict[str, Any]], name: str) -> int:
    return sum(row[name] for row in rows)


def _median(rows: list[dict[str, Any]], name: str) -> str:
    return f"{np.median([row[name] for row in rows]):,.0f}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=["xl330", "go1"])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--laws", default=",".join(LAWS))
    parser.add_argument("--losses", default=",".join(get_args(Loss)))
    parser.add_argument("--intervals", action="store_true")
    parser.add_argument("--show", action="store_true", help="what is kept, and nothing new")
    chosen = parser.parse_args()
    rows = (
        _kept()
        if chosen.show
        else measured(
            chosen.names,
            chosen.laws.split(","),
            chosen.losses.split(","),
            chosen.seeds,
            intervals=chosen.intervals,
        )
    )
    print(table(rows))
    print("\n".join(broken(rows)) or "No law ended above one that it contains.")
