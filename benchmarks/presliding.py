"""Laws on the loops of a contact below breakaway: a real direct-drive joint, three logs.

Each law is identified from each log, with the defaults of `stribeck identify`, and compared with
the other two. Errors are shares of the standard deviation of the angle; the first period,
in which a loop settles, does not count.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from stribeck import Recording, identify, read, validate
from stribeck.data.resolution import step

FOLDER = Path(__file__).parent
RIG = FOLDER / "direct_drive.toml"
DATA = FOLDER.parents[1] / "shared" / "data" / "direct_drive"
LOGS = (1, 2, 3)
LAWS = ("dahl", "lugre", "elasto-plastic", *(f"maxwell-slip:{n}" for n in range(1, 7)), "gms:2")
QUICK = ("dahl", "maxwell-slip:2", "maxwell-slip:3")
#: What counts, and the inertia that the authors of the data give, kg m^2.
SETTLED, CONSTANTS = "2s:11s", {"J": 2.519}


def measure(*, quick: bool = False) -> dict[str, Any]:
    """Errors of every law, trained on each log; with `quick` of a few laws, trained on one."""
    logs = {k: read(DATA / f"sig0_j1_6_exp{k}.csv") for k in LOGS}
    trained = (2,) if quick else LOGS
    return {
        "floor": {k: _floor(logs[k]) for k in LOGS},
        "laws": [
            {"law": law, "fits": [_fit(law, logs, k) for k in trained]}
            for law in (QUICK if quick else LAWS)
        ],
    }


def _fit(law: str, logs: dict[int, Recording], train: int) -> dict[str, Any]:
    start_time = time.perf_counter()
    fit = identify(logs[train], rig=str(RIG), law=law, train=SETTLED, fixed=CONSTANTS)
    errors = {}
    for k, log in logs.items():
        ((_, _, score),) = validate(fit, log, SETTLED)
        errors[k] = score.value * 1e-3 / _size(log)  # shown in mrad
    verdicts = [e.verdict for e in fit.estimates if e.verdict != "fixed"]
    return {
        "train": train,
        "errors": errors,
        "free": len(verdicts),
        "identified": verdicts.count("identified"),
        "evaluations": fit.search.evaluations,
        "seconds": time.perf_counter() - start_time,
    }


def _size(log: Recording) -> float:
    """Standard deviation of the angle after the first period, rad."""
    return float(np.std(log.position[_counts(log)]))


def _floor(log: Recording) -> float:
    """The error of rounding to the encoder's step alone, as such a share."""
    return float(step(log.position) / np.sqrt(12) / _size(log))


def _counts(log: Recording) -> Any:
    return log.t >= float(SETTLED.partition("s")[0])


def tables(results: dict[str, Any]) -> list[str]:
    """Errors of each law: on its own log, on the others."""
    rows = []
    for law in results["laws"]:
        fits = law["fits"]
        training = [fit["errors"][str(fit["train"])] for fit in fits]
        test = [e for fit in fits for k, e in fit["errors"].items() if k != str(fit["train"])]
        row = (
            f"| {law['law']} | {fits[0]['free']} | {_median(fit['identified'] for fit in fits)} "
            f"| {np.median(training):.3f} | **{np.median(test):.3f}** | {max(test):.3f} "
            f"| {_median(fit['evaluations'] for fit in fits):,} "
            f"| {np.median([fit['seconds'] for fit in fits]):.0f} s |"
        )
        rows.append((float(np.median(test)), row))
    floor = np.median(list(results["floor"].values()))
    return [
        "A direct-drive joint under a torque of ±6 N m, which breaks away at 10 N m and more: "
        "three logs of five cycles. Relative error of the angle, medians over the logs trained "
        f"on; rounding to the encoder's step alone makes {floor:.3f}.\n\n"
        "| law | free | identified | own log | other logs | worst of them | evaluations | time |\n"
        "|---|---:|---:|---:|---:|---:|---:|---:|\n" + "\n".join(row for _, row in sorted(rows))
    ]


def _median(values: Any) -> int:
    return int(np.median(list(values)))
