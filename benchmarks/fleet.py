"""A fleet of simulated axes: killed and resumed, on every engine, and how fast its store is.

    python benchmarks/fleet.py [--axes N] [--quick]
    python benchmarks/fleet.py --turns 3 --axes 300

A fifth of the logs are bad. Writes benchmarks/fleet.json. Wall-clock times say little on a machine
that others use too, so processor times of all processes stand beside them. With `--turns` one and
two Dask workers are measured in turn, so often, and nothing else.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import polars as pl

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "tools")]

from engines_study import cluster  # noqa: E402 - from a folder that is now on the path
from fleet_logs import simulated_fleet  # noqa: E402
from stribeck import InputError, fleet, identify  # noqa: E402
from stribeck.bench.engines import cores  # noqa: E402
from stribeck.fleet.axis_job import AxisJob, AxisRecord, axis_jobs  # noqa: E402
from stribeck.fleet.axis_run import axis_record  # noqa: E402
from stribeck.fleet.fleet_store import FILE, FleetStore  # noqa: E402
from stribeck.fleet.fleet_table import read_table, write_table  # noqa: E402
from stribeck.fleet.manifest import read_manifest  # noqa: E402

OUT = ROOT / "benchmarks" / "fleet.json"
#: How often a fleet is killed, and seconds at most that a store is measured.
KILLS = 10
#: Records of the store's measurement, and of the table's.
RECORDS = (500, 5_000)


def processor_seconds() -> float:
    """Of this process and of all that it has waited for."""
    both = (resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in both)


def timed(work: Callable[[], Any]) -> tuple[Any, dict[str, float]]:
    """What a function gives, and the seconds that it took."""
    wall, processor = time.perf_counter(), processor_seconds()
    result = work()
    seconds = {"wall": time.perf_counter() - wall, "processor": processor_seconds() - processor}
    return result, {name: round(value, 2) for name, value in seconds.items()}


def bits(folder: Path) -> pl.DataFrame:
    """The table without the one column that differs from run to run."""
    return read_table(folder).drop("seconds")


def loop(manifest: Path) -> int:
    """What one writes without a fleet: `identify` for every row; how many it did."""
    done = 0
    for row in pl.read_csv(manifest).iter_rows(named=True):
        try:
            done += bool(identify(row["log"], rig=row["rig"]).card().text())
        except InputError:
            continue
    return done


def killed(manifest: Path, out: Path, axes: int) -> list[int]:
    """How many axes were left each time that a run of the fleet was killed."""
    rng, left = np.random.default_rng(1), list[int]()
    command = [sys.executable, "-P", str(ROOT / "tests" / "fleet_logs.py"), str(manifest), str(out)]
    for _ in range(KILLS):
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603
            for _ in range(int(rng.integers(1, axes // KILLS))):
                line = process.stdout.readline()  # type: ignore[union-attr]
            process.kill()
        left.append(int(line))
    return left


def store(job: AxisJob, folder: Path) -> dict[str, float]:
    """Records a second that a store keeps, its bytes and the table's seconds for a record."""
    record, few, many = axis_record(job), *RECORDS
    kept = AxisRecord(job, record.status, record.reason, record.card, record.motion)

    def numbered(k: int) -> AxisRecord:
        row = {**job.row, "axis": f"axis {k}"}
        return replace(kept, job=replace(job, row=row))

    def keep(records: int, *, claimed: bool) -> float:
        with FleetStore.open(folder / f"{records}-{claimed}") as opened:
            _, adding = timed(lambda: opened.add(numbered(k).job for k in range(records)))
            start = time.perf_counter()
            for k in range(records):
                if claimed:
                    opened.claim()
                opened.keep(numbered(k))
            seconds = time.perf_counter() - start
            result[f"added a second, {records}"] = round(records / adding["wall"])
            if records == many:
                _, table = timed(lambda: write_table(opened.outcomes(), folder / "table"))
                result["table: records a processor second"] = round(many / table["processor"])
        return records / seconds

    result: dict[str, float] = {}
    result["claimed and kept a second, few"] = round(keep(few, claimed=True))
    result["claimed and kept a second, many"] = round(keep(many, claimed=True))
    result["bytes a record"] = round((folder / f"{many}-True" / FILE).stat().st_size / many)
    result["records of many"] = many
    return result


def fleet_manifest(folder: Path, axes: int) -> Path:
    """The manifest of so many simulated axes, whose logs lie beside it."""
    manifest = folder / "fleet.csv"
    pl.DataFrame(list(simulated_fleet(folder, axes))).write_csv(manifest)
    return manifest


def in_turns(axes: int, turns: int) -> dict[str, Any]:
    """Wall-clock seconds of a fleet on one and on two Dask workers, one after the other."""
    seconds: list[dict[str, float]] = []
    with TemporaryDirectory() as place:
        folder = Path(place)
        manifest = fleet_manifest(folder, axes)
        for turn in range(turns):
            walls: dict[str, float] = {}
            for workers in (1, 2):
                out = folder / f"{turn}-{workers}"
                with cluster(workers) as engine:
                    few = pl.read_csv(manifest).head(2 * workers)
                    fleet(few, out / "warm", engine=engine)
                    _, taken = timed(partial(fleet, manifest, out, engine=engine))
                walls[str(workers)] = taken["wall"]
            print(walls, flush=True)
            seconds.append(walls)
    ratios = [walls["1"] / walls["2"] for walls in seconds]
    return {"axes": axes, "seconds": seconds, "median ratio": round(float(np.median(ratios)), 2)}


def main() -> None:
    """Measure and write."""
    parse = argparse.ArgumentParser(description=__doc__)
    parse.add_argument("--axes", type=int, default=1000)
    parse.add_argument("--quick", action="store_true", help="24 axes, and nothing is written")
    parse.add_argument("--turns", type=int, default=0, help="of one and two Dask workers alone")
    options = parse.parse_args()
    if options.turns:
        document = json.loads(OUT.read_text(encoding="utf-8"))
        document["dask in turns"] = in_turns(options.axes, options.turns)
        OUT.write_text(f"{json.dumps(document, indent=1)}\n", encoding="utf-8")
        return
    axes = 24 if options.quick else options.axes
    if options.quick:
        globals().update(KILLS=2, RECORDS=(50, 200))
    seconds: dict[str, dict[str, float]] = {}
    same: dict[str, bool] = {}
    with TemporaryDirectory() as place:
        folder = Path(place)
        manifest = fleet_manifest(folder, axes)
        fleet(pl.read_csv(manifest).head(1), folder / "warm")  # compiles what is not compiled yet

        def run(name: str, engine: str) -> None:
            result, seconds[name] = timed(lambda: fleet(manifest, folder / name, engine=engine))
            same[name] = bits(folder / name).equals(bits(folder / "here"))
            print(name, seconds[name], result, flush=True)

        run("here", "here")
        done, seconds["loop over identify"] = timed(lambda: loop(manifest))
        print("loop over identify", seconds["loop over identify"], done, flush=True)
        for workers in (1, 2):
            run(f"processes:{workers}", f"processes:{workers}")
        for workers in (1, 2):
            before, name = processor_seconds(), f"dask, {workers} workers"
            with cluster(workers) as engine:
                few = pl.read_csv(manifest).head(2 * workers)
                fleet(few, folder / f"warm-{workers}", engine=engine)
                run(name, engine)
            # Of workers the time is known once they have ended: with that of their start.
            seconds[name]["processor"] = round(processor_seconds() - before, 2)
        left = killed(manifest, folder / "killed", axes)
        run("killed", "here")
        job = next(j for j in axis_jobs(read_manifest(manifest)) if axis_record(j).card)
        rates = store(job, folder / "store")
        parquet = sum(f.stat().st_size for f in (folder / "here" / "table").rglob("*.parquet"))
        rates["table: bytes an axis, in 21 files"] = round(parquet / axes)
        refused = bits(folder / "here").filter(pl.col("status") == "refused").height
    document = {
        "command": " ".join(["python benchmarks/fleet.py", *sys.argv[1:]]),
        "machine": {
            "cores": cores(), "processor": platform.machine(), "python": platform.python_version(),
            "load": os.getloadavg()[0],
        },
        "axes": axes,
        "refused": refused,
        "left when killed": left,
        "table equals that of an undisturbed run": same,
        "seconds": seconds,
        "store": rates,
    }  # fmt: skip
    text = json.dumps(document, indent=1)
    print(text)
    if not options.quick:
        OUT.write_text(f"{text}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
