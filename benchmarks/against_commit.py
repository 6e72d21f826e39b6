"""What a servo's simulation and identification cost, beside those of an earlier commit and MuJoCo.

    python benchmarks/against_commit.py f7a2082 [--turns 3] [--laws m1,m4,m6] [--seeds 2] [--file F]

The earlier commit's sources are taken from the repository's history into a temporary folder. Both
run in processes of one thread, taken in turn, so that a busy machine hits both alike; what is
compared are processor seconds and counts. A candidate is simulated over the 16 XL330 logs of
../shared/data (96 s), at 8 parameter sets drawn from the ranges; its error is the difference from
a simulation with steps 16 times and tolerances 10,000 times finer. The identification is of m1,
intervals included; with `--laws ''` it is all, and asks nothing of the sources that version 0.1
(1212ef9) lacks. Each turn goes to against_commit.json, or to `--file`.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).parent
FILE = HERE / "against_commit.json"
LOGS = HERE.parents[1] / "shared" / "data" / "bam_xl330" / "logs"
#: Seconds of processor time for each law in a turn.
SPAN = 1.0
#: The step of MuJoCo, s, and what it simulates, s.
STEP, SIMULATED = 2e-3, 200.0
_HINGE = f"""<mujoco><option timestep="{STEP}" gravity="0 0 -9.81"/><worldbody><body>
<joint name="j" type="hinge" axis="0 1 0" damping="0.01" frictionloss="0.02" armature="0.0015"/>
<geom type="capsule" fromto="0 0 0 0 0 -0.1" size="0.01" mass="0.5"/></body></worldbody>
<actuator><position joint="j" kp="1"/></actuator></mujoco>"""


def simulated(law: str) -> dict[str, float]:
    """What a simulated second of a candidate takes, µs, and its error, mrad."""
    from axis_servo import LAWS  # noqa: PLC0415 - imports the sources under test
    from nested_laws import axis  # noqa: PLC0415
    from stribeck.identify.problem import problem  # noqa: PLC0415
    from stribeck.rig.simulated import as_simulated  # noqa: PLC0415

    rig, logs, _ = axis("xl330")
    whole = problem(logs, rig=rig, law=LAWS[law])
    x = whole.space.decode(0.05 + 0.6 * np.random.default_rng(1).random((8, whole.space.dim)))
    residuals = whole.residuals(x)
    seconds = sum(float(s.track.t[-1] - s.track.t[0]) for s in whole.train)
    rows, start = 0, time.process_time()
    while (used := time.process_time() - start) < SPAN:
        whole.residuals(x)
        rows += len(x)
    exact = whole.on(as_simulated(rig).finer(16.0, 1e4)).residuals(x)
    off = np.abs(residuals - exact)
    return {"us": 1e6 * used / rows / seconds, "error": float(np.sqrt(np.mean(off**2)))}


def identified(loss: Any, seed: int) -> dict[str, float]:
    """What an identification of m1 takes, intervals included."""
    from stribeck import RIGS, identify, read  # noqa: PLC0415 - the sources under test

    rig = RIGS["servo-pendulum"]
    logs = [read(file, columns=dict(rig.columns)) for file in sorted(LOGS.glob("*.json"))]
    start = time.process_time()
    fit = identify(logs, rig=rig, law="coulomb-viscous", loss=loss, seed=seed)
    assert fit.uncertainty is not None  # noqa: S101 - an output-error fit has one
    return {
        "processor_seconds": time.process_time() - start,
        "evaluations": fit.search.evaluations,
        "rows": fit.uncertainty.rows,
        "error": fit.score.value,
    }


def mujoco_hinge() -> float:
    """What a simulated second of one hinge takes in MuJoCo, µs."""
    import mujoco  # noqa: PLC0415 - an extra

    model = mujoco.MjModel.from_xml_string(_HINGE)
    state = mujoco.MjData(model)
    state.ctrl[0] = 0.5
    start = time.process_time()
    mujoco.mj_step(model, state, nstep=int(SIMULATED / STEP))
    return 1e6 * (time.process_time() - start) / SIMULATED


def asked(sources: Path, call: str, module: str = "against_commit") -> Any:
    """The value of a call of a module beside this in a process of its own, with these sources."""
    path = os.pathsep.join([str(sources), str(HERE)])
    code = f"import json, {module} as a; print('\\n' + json.dumps(a.{call}))"
    done = subprocess.run(  # noqa: S603 - this interpreter, with a call of this file
        [sys.executable, "-P", "-c", code], check=True, capture_output=True, text=True,
        env={**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    return json.loads(done.stdout.splitlines()[-1])


@contextmanager
def both_sources(commit: str) -> Iterator[dict[str, Path]]:
    """The sources of an earlier commit, in a temporary folder, and those of now."""
    with tempfile.TemporaryDirectory() as folder:
        archive = subprocess.run(  # noqa: S603
            ["git", "archive", commit, "src"],  # noqa: S607 - whichever git there is
            check=True, capture_output=True, cwd=HERE.parent,
        )  # fmt: skip
        with tarfile.open(fileobj=io.BytesIO(archive.stdout)) as tar:
            tar.extractall(folder, filter="data")
        yield {"before": Path(folder) / "src", "now": HERE.parent / "src"}


def measured(
    commit: str, laws: list[str], seeds: int, turns: int, file: Path = FILE
) -> dict[str, Any]:
    """All turns, kept as they come."""
    results: dict[str, Any] = {"commit": commit, "turns": []}
    with both_sources(commit) as sources:
        calls = [f"simulated({law!r})" for law in laws]
        calls += [f"identified({x!r}, {k})" for x in ("absolute", "squares") for k in range(seeds)]
        for who, path in sources.items():  # what one of them compiles is not measured
            asked(path, calls[0])
            print(f"{who}: compiled", flush=True)
        for turn in range(turns):
            for call in calls if turn == 0 or not laws else calls[: len(laws)]:
                row = {who: asked(path, call) for who, path in sources.items()}
                results["turns"].append({"call": call, **row})
                file.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
                print(call, row, flush=True)
            results["turns"].append(
                {"call": "mujoco", "now": {"us": asked(HERE, "mujoco_hinge()")}}
            )
    file.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    return results


def table(results: dict[str, Any]) -> str:
    """Medians over the turns, before and now, and their ratio."""
    from stribeck.report.table import Table  # noqa: PLC0415 - not the sources under test

    calls: dict[str, list[dict[str, Any]]] = {}
    for row in results["turns"]:
        calls.setdefault(row["call"], []).append(row)

    def median(call: str, who: str, name: str) -> float:
        return float(np.median([row[who][name] for row in calls[call]]))

    rows, fits = [], []
    for call in calls:
        if call.startswith("simulated"):
            before, now = (median(call, who, "us") for who in ("before", "now"))
            errors = (f"{median(call, who, 'error'):.1e}" for who in ("before", "now"))
            law = call.split("'")[1]
            rows.append((law, f"{before:.0f}", f"{now:.0f}", f"{now / before:.2f}", *errors))
        elif call.startswith("identified"):
            old, new = (
                {n: median(call, who, n) for n in calls[call][0][who]} for who in ("before", "now")
            )
            ratio = new["processor_seconds"] / old["processor_seconds"]
            cells = [f"{r['evaluations']:.0f} + {r['rows']:.0f}" for r in (old, new)]
            cells += [f"{r['processor_seconds']:.1f}" for r in (old, new)]
            errors = (f"{r['error']:.2f}" for r in (old, new))
            name = call.removeprefix("identified(").rstrip(")").replace("'", "")
            fits.append((name, *cells, f"{ratio:.2f}", *errors))
    first = Table.of_texts(
        f"A simulated second of a candidate, processor µs, {results['commit']} and now",
        ("law", "before", "now", "ratio", "error before / mrad", "error now / mrad"),
        rows,
        labels=range(1),
    )
    second = Table.of_texts(
        f"m1 with intervals, {results['commit']} and now: search + further evaluations, processor "
        "seconds, misfit / mrad",
        (
            "loss, seed",
            "before",
            "now",
            "s before",
            "s now",
            "ratio",
            "misfit before",
            "misfit now",
        ),
        fits,
        labels=range(1),
    )
    parts = [part.text() for part, lines in ((first, rows), (second, fits)) if lines]
    if "mujoco" in calls:
        hinge = median("mujoco", "now", "us")
        parts.append(
            f"MuJoCo, one hinge at {1e3 * STEP:.0f} ms: {hinge:.0f} µs a simulated second."
        )
    return "\n\n".join(parts)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("commit", nargs="?", default="f7a2082")
    parser.add_argument("--laws", default="m1,m2,m3,m4,m6")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--file", type=Path, default=FILE, help="where results are kept")
    parser.add_argument("--show", action="store_true", help="what is kept, and nothing new")
    chosen = parser.parse_args()
    kept = (
        json.loads(chosen.file.read_text(encoding="utf-8"))
        if chosen.show
        else measured(
            chosen.commit,
            [n for n in chosen.laws.split(",") if n],
            chosen.seeds,
            chosen.turns,
            chosen.file,
        )
    )
    print(table(kept))
