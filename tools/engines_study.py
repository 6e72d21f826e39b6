"""The speed-up of two workers over one, on processes and on Dask.

Runs the same jobs, the first repeats of the paper's campaign with a budget cut to size, on one
and on two workers in turn, and compares the throughput within each turn, start-up included.
Writes docs/data/engines_study.json.

    python tools/engines_study.py
"""

from __future__ import annotations

import argparse
import json
import platform
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from stribeck.bench.campaign import campaign
from stribeck.bench.engines import Engine, cores, engine
from stribeck.bench.record import Job, Record
from stribeck.bench.worker import software

OUT = Path(__file__).parents[1] / "docs" / "data" / "engines_study.json"
HOST = ("--host", "127.0.0.1", "--no-dashboard")


def started(folder: str, pattern: str, *command: str) -> tuple[subprocess.Popen[bytes], str]:
    """A Dask program, once its log matches a pattern, and the pattern's first group."""
    log = Path(folder, f"{time.monotonic_ns()}.log")
    with log.open("wb") as sink:
        program = subprocess.Popen(  # noqa: S603
            [sys.executable, "-m", "dask", *command, *HOST], stderr=sink, cwd=folder
        )
    while not (match := re.search(pattern, log.read_text())):
        if program.poll() is not None:
            sys.exit(f"dask {command[0]} ended: {log.read_text()[-300:]}")
        time.sleep(0.05)
    return program, match[1]


@contextmanager
def cluster(workers: int) -> Iterator[str]:
    """A scheduler with workers of one thread, and the name of its engine."""
    with TemporaryDirectory() as folder:
        programs = []
        try:
            scheduler = ("scheduler", "--port", "0")
            program, at = started(folder, r"Scheduler at: +tcp://(\S+)", *scheduler)
            programs.append(program)
            for _ in range(workers):
                worker = ("worker", f"tcp://{at}", "--nthreads", "1")
                program, _matched = started(folder, r"Registered to: +(\S+)", *worker)
                programs.append(program)
            yield f"dask://{at}"
        finally:
            for program in reversed(programs):
                program.terminate()
                program.wait()


def throughput(tested: Engine, jobs: list[Job]) -> tuple[float, str]:
    """Evaluations a second from the first job to the last outcome, and the records' bits."""
    start_time = time.perf_counter()
    records = [o for o in tested.run(iter(jobs)) if isinstance(o, Record)]
    seconds = time.perf_counter() - start_time
    if len(records) < len(jobs):
        sys.exit("a job failed")
    bits = "".join(sorted(r.content for r in records))
    return sum(r.evaluations for r in records) / seconds, bits


def main() -> None:
    """Measure and write."""
    parse = argparse.ArgumentParser(description=__doc__)
    parse.add_argument("--repeats", type=int, default=4, help="of the campaign: how many jobs")
    parse.add_argument("--turns", type=int, default=3)
    parse.add_argument("--budget", type=int, default=100_000, help="at most, of a job")
    options = parse.parse_args()
    all_jobs = campaign("paper").trials(options.repeats).jobs()
    jobs = [replace(job, budget=min(job.budget, options.budget)) for job in all_jobs]
    rates: dict[str, list[float]] = {}
    contents = set[str]()
    with cluster(1) as single, cluster(2) as two:
        names = {"processes 1": "processes:1", "processes 2": "processes:2"}
        names |= {"dask 1": single, "dask 2": two}
        for name in names.values():  # Dask workers load their code once, not once a turn
            list(engine(name).run(iter(jobs[:8])))
        for turn in range(options.turns):
            for label in list(names)[:: 1 if turn % 2 == 0 else -1]:
                rate, bits = throughput(engine(names[label]), jobs)
                rates.setdefault(label, []).append(rate)
                contents.add(bits)
                print(f"{label}: {rate:,.0f} evaluations a second")
    ratios = {
        kind: np.array(rates[f"{kind} 2"]) / np.array(rates[f"{kind} 1"])
        for kind in ("processes", "dask")
    }
    document: dict[str, Any] = {
        "command": " ".join(["python tools/engines_study.py", *sys.argv[1:]]),
        "machine": {
            "cores": cores(),
            "system": platform.system(),
            "processor": platform.machine(),
            "python": platform.python_version(),
            "software": software(),
        },
        "jobs": len(jobs),
        "records_are_the_same_on_every_engine": len(contents) == 1,
        "evaluations_a_second": {k: [round(r) for r in v] for k, v in rates.items()},
        "two_workers_over_one": {
            kind: {
                "median": round(float(np.median(r)), 3),
                "least": round(float(r.min()), 3),
                "most": round(float(r.max()), 3),
            }
            for kind, r in ratios.items()
        },
    }
    OUT.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(document["two_workers_over_one"]))


if __name__ == "__main__":
    main()
