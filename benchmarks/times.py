"""What identifications take, in processor seconds and on the clock, and their evaluations.

    python benchmarks/times.py [--only NAME]... [--show]

Each case runs in a process of its own, once more where the first one has compiled something; those
named `first run` begin with an empty folder of compiled code. What makes the log is not timed.
Processor seconds are those of one thread; the clock is that of a second process with as many as
there are, which is what somebody waits for. Results go to times.json, each with the day. A busy
machine makes all of them longer: by a half where two threads share a core.
"""

from __future__ import annotations

import argparse
import datetime as dt
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

FILE = Path(__file__).with_suffix(".json")
#: What is timed, once its log is there.
Work = Callable[[], Any]


def _bed(law: str) -> Callable[[], Work]:
    """The demo's up stroke by a law on the slide bed."""

    def run() -> Work:
        from stribeck import identify  # noqa: PLC0415 - what a first run is timed with
        from stribeck.rig.twin import TestBed  # noqa: PLC0415

        log = TestBed(loop="ideal").run("both").recording
        return lambda: identify(log, rig="slide-bed", law=law, train="112:295")

    return run


def _m6() -> Work:
    """BAM's sixth law on the 16 logs of an XL330."""
    from nested_laws import fitted  # noqa: PLC0415 - beside this file

    return lambda: fitted("xl330", "m6", "squares", 0)


def _presliding(law: str = "maxwell-slip:4") -> Work:
    """Four Maxwell elements on 30 s at 1 kHz of a foreign simulator's cycles, simulated."""
    import foreign_path  # noqa: F401, PLC0415 - before what it finds
    from foreign import presliding  # noqa: PLC0415
    from stribeck import Recording, identify  # noqa: PLC0415

    t = np.asarray(1e-3 * np.arange(30_000), dtype=np.float64)
    force = (2.0 + 8.0 * t / 30.0) * np.sin(2.0 * np.pi * 0.5 * t)
    contact = (np.array([3.0, 3.0, 3.0, 3.0]), 2e-6 * np.array([1.0, 2.5, 6.0, 15.0]), 60.0)
    m = presliding.simulate(12.0, contact, t, force)
    x = m.position + 2e-8 * np.random.default_rng(1).standard_normal(len(t))
    log = Recording(t=t, position=x, force=force)
    return lambda: identify(log, rig="presliding", law=law)


def _select() -> Work:
    """Four static laws on one balance of 16,000 rows: a foreign slide, 160 s at 100 Hz."""
    import foreign_path  # noqa: F401, PLC0415 - before what it finds
    from foreign import driven  # noqa: PLC0415
    from foreign.friction import Curve  # noqa: PLC0415
    from foreign.strokes import sines  # noqa: PLC0415
    from stribeck import Recording, select  # noqa: PLC0415

    t, x = sines(160.0, np.array([0.08, 0.03, 0.004]), np.array([0.31, 0.83, 2.3]))
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=1e-4)
    curve = Curve(20.0, 12.0, 80.0, 0.01)
    m = driven.simulate(10.0, curve, curve, loop, t, x, driven.Extras(offset=3.0))
    force = m.force + 0.5 * np.random.default_rng(1).standard_normal(len(m.t))
    laws = ("coulomb-viscous", "stribeck", "stribeck-gauss", "stribeck-free")
    log = Recording(t=m.t[::10], position=m.position[::10], force=force[::10])
    return lambda: select(log, rig="forced", laws=laws)


def _compensation() -> Work:
    """All modes and scales for the demo's axis, on every axis that its card allows."""
    from stribeck import identify  # noqa: PLC0415 - what a first run is timed with
    from stribeck.compensate.compensation import compensate  # noqa: PLC0415
    from stribeck.rig.twin import TestBed  # noqa: PLC0415

    log = TestBed(loop="ideal").run("both").recording
    card = identify(log, rig="slide-bed", law="stribeck", train="112:295").card()
    return lambda: compensate(card)


def _arm() -> Work:
    """A robot's joint of the coverage study."""
    import interval_axes  # noqa: PLC0415 - beside this file
    from foreign_axes import noisy, recordings  # noqa: PLC0415
    from stribeck import identify  # noqa: PLC0415
    from stribeck.rig.lookup import rig_named  # noqa: PLC0415

    axis = interval_axes.robot(0)
    tables = noisy(axis, np.random.default_rng(0), 0.0)
    rig, logs = rig_named(axis.rig).set(**axis.given), recordings(axis, tables)
    return lambda: identify(logs, rig=rig, law=axis.law)


#: Cases, with the goal in seconds; those that begin with an empty folder.
CASES: dict[str, tuple[Callable[[], Work], float]] = {
    "slide bed, dahl": (_bed("dahl"), 10.0),
    "slide bed, makkar": (_bed("makkar"), 10.0),
    "slide bed, lugre": (_bed("lugre"), 10.0),
    "BAM m6, 16 logs": (_m6, 30.0),
    "presliding, maxwell-slip:4, 30 s at 1 kHz": (_presliding, 20.0),
    "select, four laws, 16,000 rows": (_select, 8.0),
    "compensate, slide bed": (_compensation, 6.0),
    "arm joint": (_arm, np.inf),
    "first run, arm joint": (_arm, np.inf),
}


def timed(name: str) -> dict[str, Any]:
    """What a case takes in this process, without what makes its log."""
    work = CASES[name][0]()
    start, at = time.process_time(), time.monotonic()
    answer = work()
    seconds, clock = time.process_time() - start, time.monotonic() - at
    row: dict[str, Any] = {"seconds": round(seconds, 2), "clock": round(clock, 2)}
    search = getattr(answer, "search", None)
    if search is not None:
        row["search"] = int(search.evaluations)
    if isinstance(answer, dict):
        row |= {"search": int(answer["evaluations"]), "further": int(answer["rows"])}
    row["peak_mb"] = round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    return row


def asked(name: str) -> dict[str, Any]:
    """A case by one thread, and its clock by all of them; compiled before unless a first run."""
    row = _asked(name, {"OMP_NUM_THREADS": "1"})
    if row["told"] and not name.startswith("first run"):
        row = _asked(name, {"OMP_NUM_THREADS": "1"})  # what it compiles is not measured
    del row["told"]
    return row | {"clock": _asked(name, {})["clock"]}


def _asked(name: str, threads: dict[str, str]) -> dict[str, Any]:
    """A case in a process of its own."""
    code = f"import json, times; print('\\n' + json.dumps(times.timed({name!r})))"
    paths = [str(Path(__file__).parents[1] / "src"), str(Path(__file__).parent)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)} | threads
    first = name.startswith("first run")
    with tempfile.TemporaryDirectory() as folder:
        if first:
            environment["NUMBA_CACHE_DIR"] = folder
        done = subprocess.run(  # noqa: S603 - this interpreter, with a call of this file
            [sys.executable, "-P", "-c", code],
            check=True, capture_output=True, text=True, env=environment,
        )  # fmt: skip
    row: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    row["told"] = [line for line in done.stderr.splitlines() if "compiled" in line]
    return row


def table(rows: dict[str, Any]) -> str:
    """Seconds beside their goals."""
    from stribeck.report.table import Table  # noqa: PLC0415 - see `timed`

    lines = []
    for name, (_, goal) in CASES.items():
        if name in rows:
            row = rows[name]
            counts = " + ".join(str(row[k]) for k in ("search", "further") if k in row)
            lines.append((
                name, f"{row['seconds']:.1f}", f"{row['clock']:.1f}" if "clock" in row else "",
                "" if np.isinf(goal) else f"{goal:.0f}", counts, f"{row['peak_mb']}", row["day"],
            ))  # fmt: skip
    return Table.of_texts(
        "What an identification takes: processor seconds, and seconds on the clock",
        ("what", "seconds", "clock", "goal", "evaluations", "peak / MB", "measured"),
        lines,
    ).text()


def main() -> None:
    """Measure, keep, show."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", action="append", choices=list(CASES), help="by default all")
    parser.add_argument("--show", action="store_true", help="what is kept, without a run")
    arguments = parser.parse_args()
    rows = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    if not arguments.show:
        for name in arguments.only or CASES:
            rows[name] = asked(name) | {"day": dt.datetime.now(dt.UTC).date().isoformat()}
            print(name, rows[name], flush=True)
            FILE.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    print(table(rows))


if __name__ == "__main__":
    main()
