"""Other tools on recordings that we identify, too: each as one writes it with that tool.

Each runs in a process of its own, in turn, on one thread, and what is counted is processor time
without imports and compilation. Tools that could not be run are named with the figures that others
published of them.
"""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np

import slide_by_numpy
from stated_model import StatedModel
from stribeck import RIGS, Fit, identify, read, validate
from stribeck.identify.loss import Loss, Objective
from stribeck.report.format import number
from table_head import table_head

FOLDER = Path(__file__).parent
SERVO = FOLDER.parents[1] / "shared" / "data" / "bam_xl330" / "logs"
#: The least-squares estimates of A. Janot, M. Gautier, M. Brunot (2019): M, F_v, F_c, offset.
PUBLISHED = (95.1089, 203.5034, 20.3935, -3.1648)
#: Of an earlier run elsewhere, not of this one: mean absolute error in mrad, evaluations,
#: processor seconds, lines. BAM's own fitter (1.0.2) needs Python 3.12.
CITED = {
    "mujoco.sysid 4.0, cited": ("57.5", "98", "7.0", "77"),
    "BAM's own fitter 1.0.2, cited": ("57.0", "", "99", ""),
}


def sysid_squares() -> dict[str, Any]:
    """`mujoco.sysid` by squares, from the middle of its ranges."""
    import servo_by_mujoco_sysid as servo  # noqa: PLC0415 - needs the extra bench

    return servo.fitted("squares")


def sysid_absolute() -> dict[str, Any]:
    """`mujoco.sysid` by absolute errors, from where squares end; both are counted."""
    import servo_by_mujoco_sysid as servo  # noqa: PLC0415 - the same

    first = servo.fitted("squares")
    then = servo.fitted("absolute", first["x"])
    spent = {n: first[n] + then[n] for n in ("evaluations", "processor_seconds")}
    return {**then, **spent}


def ours_squares() -> dict[str, Any]:
    """`identify` by squares, with intervals."""
    return _ours("squares")


def ours_absolute() -> dict[str, Any]:
    """`identify` by absolute errors, with intervals."""
    return _ours("absolute")


def _ours(loss: Any) -> dict[str, Any]:
    rig = RIGS["servo-pendulum"]
    begun = time.process_time()
    logs = [read(f, columns=dict(rig.columns)) for f in sorted(SERVO.glob("*.json"))]
    fit = identify(logs, rig=rig, law="coulomb-viscous", loss=loss)
    seconds = time.process_time() - begun
    assert fit.uncertainty is not None  # noqa: S101 - an output-error fit has one
    return {
        **_errors(fit, logs),
        "evaluations": fit.search.evaluations,
        "further": fit.uncertainty.rows,
        "processor_seconds": seconds,
    }


def _errors(fit: Fit, logs: list[Any]) -> dict[str, float]:
    """Mean over the logs of their mean absolute errors, and RMS, mrad."""
    errors = {}
    for loss in get_args(Loss):
        model = StatedModel(replace(fit.parameters, objective=Objective(loss)), fit.p)
        values = [score.value for _, _, score in validate(model, logs)]
        power = 1 if loss == "absolute" else 2
        errors[loss] = float(np.mean(np.power(values, power)) ** (1 / power))
    return errors


def numpy_slide() -> dict[str, Any]:
    """Six lines."""
    return slide_by_numpy.fitted()


def our_slide() -> dict[str, Any]:
    """`identify` on the rig `emps`."""
    begun = time.process_time()
    fit = identify(slide_by_numpy.LOG, rig="emps", law="coulomb-viscous")
    seconds = time.process_time() - begun
    names = ("M", "F_v", "F_c", "offset")
    by = {e.name: e for e in fit.estimates}
    return {
        "values": [by[n].value for n in names],
        "errors": [by[n].standard_error for n in names],
        "misfit": fit.score.value,
        "processor_seconds": seconds,
    }


CASES: dict[str, Callable[[], dict[str, Any]]] = {
    f.__name__: f
    for f in (sysid_squares, sysid_absolute, ours_squares, ours_absolute, numpy_slide, our_slide)
}


def measure(*, quick: bool = False) -> dict[str, Any]:
    """All that the recordings and the installed tools allow; quick: the slide alone."""
    names = [n for n in CASES if n.endswith("slide")] if quick else list(CASES)
    there = slide_by_numpy.LOG.exists() and SERVO.exists()
    return {name: _alone(name) for name in names} if there else {}


def _alone(name: str) -> dict[str, Any]:
    """A case in a process of its own, the second time it is asked if it compiles."""
    times = 2 if name.startswith("our") else 1
    code = f"import json, other_tools as o; r = [o.CASES[{name!r}]() for _ in range({times})]"
    done = subprocess.run(  # noqa: S603 - this file
        [sys.executable, "-c", f"{code}; print('\\n' + json.dumps(r[-1]))"],
        check=True, capture_output=True, text=True, cwd=FOLDER,
        env={**os.environ, "OMP_NUM_THREADS": "1",
             "PYTHONPATH": os.pathsep.join([str(FOLDER.parent / "src"), *sys.path])},
    )  # fmt: skip
    row: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    print(name, row, flush=True)
    return row


def lines_of(module: str) -> int:
    """Lines of a file that are neither empty nor comment nor docstring."""
    text = (FOLDER / f"{module}.py").read_text(encoding="utf-8")
    bare = ast.unparse(ast.parse(text))
    return sum(bool(line.strip()) for line in bare.splitlines())


def tables(found: dict[str, Any]) -> list[str]:
    """A table for each recording."""
    texts = []
    if "ours_squares" in found:
        texts.append("\n".join(_servo(found)))
    if "our_slide" in found:
        texts.append("\n".join(_slide(found)))
    return texts or ["The recordings are not there."]


def _servo(found: dict[str, Any]) -> list[str]:
    sysid_lines = lines_of("servo_by_mujoco_sysid")
    rows = [*table_head(
        "XL330, 16 logs, Coulomb and viscous friction (m1)",
        "who | by | mean abs. error / mrad: | RMS / mrad: | evaluations: | processor s: | lines: | "
        "intervals",
    )]  # fmt: skip
    for name, who, lines, intervals in (
        ("ours_absolute", "stribeck", "1 command", "profiles, verdicts"),
        ("ours_squares", "stribeck", "1 command", "profiles, verdicts"),
        ("sysid_absolute", "mujoco.sysid 4.0", str(sysid_lines), "Jacobian"),
        ("sysid_squares", "mujoco.sysid 4.0", str(sysid_lines), "Jacobian"),
    ):
        row = found[name]
        evaluations = f"{row['evaluations']:,}"
        if "further" in row:
            evaluations += f" + {row['further']:,}"
        rows.append(
            f"| {who} | {name.rpartition('_')[2]} | {row['absolute']:.2f} | {row['squares']:.1f} "
            f"| {evaluations} | {row['processor_seconds']:.1f} | {lines} | {intervals} |"
        )
    for who, (error, evaluations, seconds, lines) in CITED.items():
        rows.append(f"| {who} | absolute | {error} | | {evaluations} | {seconds} | {lines} | |")
    note = (
        "Evaluations of all 16 logs, those of finite differences too; of ours the second number is "
        "of the intervals. Cited: of an earlier run elsewhere, and of other seconds than these."
    )
    return [*rows, "", note]


def _slide(found: dict[str, Any]) -> list[str]:
    rows = [*table_head(
        "EMPS, mass, Coulomb and viscous friction, offset",
        "who | M / kg | F_v / N s/m | F_c / N | offset / N | relative error / %: | "
        "processor s: | lines:",
    )]  # fmt: skip
    rows.append(f"| published | {' | '.join(number(x, 6) for x in PUBLISHED)} | 4.083 | | |")
    for name, who, lines in (
        ("our_slide", "stribeck", "1 command"), ("numpy_slide", "NumPy", "6"),
    ):  # fmt: skip
        row = found[name]
        pairs = zip(row["values"], row["errors"], strict=True)
        cells = " | ".join(f"{number(x, 6)} ± {number(s, 2)}" for x, s in pairs)
        rows.append(
            f"| {who} | {cells} | {row['misfit']:.3f} | {row['processor_seconds']:.2f} | {lines} |"
        )
    return [*rows, "", "±: one standard error."]
