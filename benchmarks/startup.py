"""Time of commands: every figure is of a whole process, Python's own start included."""

from __future__ import annotations

import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

STRIBECK = (sys.executable, "-m", "stribeck")
#: The demo's up stroke, as `make demo` and the README have it.
IDENTIFY = (
    "--rig", "slide-bed", "--law", "stribeck",
    "--train", "112:295", "--holdout", "44:112", "--holdout", "295:352",
)  # fmt: skip
#: The line of `identify` with the time of its steps.
TOOK = re.compile(r"^[\d.]+ s: (start-up .+)$", re.MULTILINE)
#: What comes after the card.
LATER = "figures"


def measure(quick: bool = False) -> dict[str, Any]:
    """Medians over runs of a process, wall and processor seconds; shares of `identify`."""
    runs = 3 if quick else 9
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _timed([*STRIBECK, "twin", str(folder / "twin.csv"), "--direction", "both"])
        identify = [*STRIBECK, "identify", str(folder / "twin.csv"), *IDENTIFY]
        identify += ["--out", str(folder / "fit")]
        first = _timed(identify, NUMBA_CACHE_DIR=str(folder / "cache"))
        _timed(identify)  # whatever is cached is there from here on
        small = {
            "python": [sys.executable, "-c", "pass"],
            "import": [sys.executable, "-c", "import stribeck"],
            "version": [*STRIBECK, "--version"],
        }
        timed: dict[str, list[dict[str, Any]]] = {n: [] for n in (*small, "identify")}
        for _ in range(runs):  # in turn, so that a busy minute of the machine is shared by all
            for n, command in {**small, "identify": identify}.items():
                timed[n].append(_timed(command))
    middle = {n: _middle(timings) for n, timings in timed.items()}
    return {
        "runs": runs,
        "import_above_python": median(
            a["wall"] - b["wall"] for a, b in zip(timed["import"], timed["python"], strict=True)
        ),
        "version": middle["version"],
        "identify": middle["identify"],
        "identify_first": first,
    }


def _timed(command: Sequence[str], **environment: str) -> dict[str, Any]:
    """Seconds of one process, and the shares of its steps where it prints them."""
    before, start_time = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    completed = subprocess.run(  # noqa: S603 - our own command line
        command, check=True, capture_output=True, text=True, env={**os.environ, **environment}
    )
    wall, after = time.perf_counter() - start_time, resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    listed = TOOK.search(completed.stdout)
    pairs = (part.rsplit(" ", 1) for part in listed[1].split(", ")) if listed else ()
    shares = {n: float(seconds) for n, seconds in pairs}
    card = sum(s for n, s in shares.items() if n != LATER)
    return {"wall": wall, "processor": processor, "card": card, "shares": shares}


def _middle(runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The medians of several runs, and the least of them."""
    names = runs[0]["shares"]
    return {
        **{n: median(f[n] for f in runs) for n in ("wall", "processor", "card")},
        "least": {n: min(f[n] for f in runs) for n in ("wall", "processor", "card")},
        "shares": {n: median(f["shares"][n] for f in runs) for n in names},
    }


def tables(results: Mapping[str, Any]) -> list[str]:
    """The times, as Markdown."""
    warm, first, version = (results[n] for n in ("identify", "identify_first", "version"))
    rows = [
        ("`import stribeck`, above bare Python", results["import_above_python"], None, None),
        ("`stribeck --version`", version["wall"], version["processor"], version["least"]["wall"]),
        ("`stribeck identify`, typed to card written", warm["card"], None, warm["least"]["card"]),
        (
            "the same, to its figures drawn and its end",
            warm["wall"],
            warm["processor"],
            warm["least"]["wall"],
        ),
        ("the first after an installation, to card written", first["card"], None, None),
    ]
    conditions = (
        f"Medians over {results['runs']} runs of a process, taken in turn; processor seconds are "
        "those of all its threads. `identify` is the demo's up stroke with the default method. "
        "The first run compiles what later ones find on disk."
    )
    return [
        conditions,
        "",
        "| what | wall / s | processor / s | least wall / s |",
        "|---|---:|---:|---:|",
        *(f"| {command} | {_s(a)} | {_s(b)} | {_s(c)} |" for command, a, b, c in rows),
        "",
        "Where `identify` spends it, warm:",
        "",
        f"| {' | '.join(warm['shares'])} |",
        f"|{'---:|' * len(warm['shares'])}",
        f"| {' | '.join(f'{s:.2f} s' for s in warm['shares'].values())} |",
        "",
    ]


def _s(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds:.2f}"


if __name__ == "__main__":
    print("\n".join(tables(measure(quick=True))))
