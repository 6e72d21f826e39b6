"""Time of commands: every figure is of a whole process, Python's own start included.

    python benchmarks/startup.py [--quick] [--against CHECKOUT]

`--against` times `identify` of another checkout, too, by turns with this one: the same Python and
libraries, its own sources. Processor seconds and ratios hold on a busy machine as well.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

STRIBECK = (sys.executable, "-m", "stribeck")
SOURCES = Path(__file__).parents[1] / "src"
#: The demo's up stroke, as `make demo` and the README have it.
IDENTIFY = (
    "--rig", "slide-bed", "--law", "stribeck",
    "--train", "112:295", "--holdout", "44:112", "--holdout", "295:352",
)  # fmt: skip
#: The line of `identify` with the time of its steps.
TOOK = re.compile(r"^[\d.]+ s: (start-up .+)$", re.MULTILINE)
#: What comes after the card.
LATER = ("figures", "report")
#: What is timed of a process, and how tables call it.
TIMES = {"wall": "wall / s", "processor": "processor / s"}


def measure(quick: bool = False, against: Path | None = None) -> dict[str, Any]:
    """Medians over runs of a process, wall and processor seconds; shares of `identify`.

    Args:
        quick: Whether a third of the runs will do.
        against: Another checkout, whose `identify` is timed by turns with this one's.
    """
    runs = 3 if quick else 9
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        here = _environment(SOURCES)
        _timed([*STRIBECK, "twin", str(folder / "twin.csv"), "--direction", "both"], here)
        printed = [*STRIBECK, "identify", str(folder / "twin.csv"), *IDENTIFY]
        written = [*printed, "--out", str(folder / "fit")]
        first = _timed(written, here | {"NUMBA_CACHE_DIR": str(folder / "cache")})
        processes = {
            "python": ([sys.executable, "-c", "pass"], here),
            "import": ([sys.executable, "-c", "import stribeck"], here),
            "version": ([*STRIBECK, "--version"], here),
            "printed": (printed, here),
            "written": (written, here),
        }
        if against is not None:
            there = _environment(against / "src")
            caches = {"NUMBA_CACHE_DIR": "there", "PYTHONPYCACHEPREFIX": "bytecode"}
            there |= {k: str(folder / v) for k, v in caches.items()}  # nothing is left behind there
            processes["there"] = (printed, there)
        times: dict[str, list[dict[str, Any]]] = {n: [] for n in processes}
        for command, environment in processes.values():
            _timed(command, environment)  # whatever is cached is there from here on
        for _ in range(runs):  # in turn, so that a busy minute of the machine is shared by all
            for n, (command, environment) in processes.items():
                times[n].append(_timed(command, environment))
    middle = {n: _middle(timings) for n, timings in times.items()}
    return {
        "runs": runs,
        "import_above_python": median(
            a["wall"] - b["wall"] for a, b in zip(times["import"], times["python"], strict=True)
        ),
        "version": middle["version"],
        "identify_printed": middle["printed"],
        "identify": middle["written"],
        "identify_first": first,
        "against": {} if against is None else {"checkout": against.name, **middle["there"]},
    }


def _environment(sources: Path) -> dict[str, str]:
    """What a process sees that runs the sources of a checkout, and may keep its bytecode."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    return environment | {"PYTHONPATH": str(sources.resolve())}


def _timed(command: Sequence[str], environment: Mapping[str, str]) -> dict[str, Any]:
    """Seconds of one process, and the shares of its steps where it prints them."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    process = subprocess.run(  # noqa: S603 - our own command line
        command, check=True, capture_output=True, text=True, env=environment
    )
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    line = TOOK.search(process.stdout)
    pairs = (part.rsplit(" ", 1) for part in line[1].split(", ")) if line else ()
    shares = {n: float(seconds) for n, seconds in pairs}
    card = sum(s for n, s in shares.items() if n not in LATER)
    return {"wall": wall, "processor": processor, "card": card, "shares": shares}


def _middle(runs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The medians of several runs, and the least of them."""
    names = runs[0]["shares"]
    return {
        **{n: median(r[n] for r in runs) for n in (*TIMES, "card")},
        "least": {n: min(r[n] for r in runs) for n in (*TIMES, "card")},
        "shares": {n: median(r["shares"][n] for r in runs) for n in names},
    }


def tables(results: Mapping[str, Any]) -> list[str]:
    """The times, as Markdown."""
    warm, first, version = (results[n] for n in ("identify", "identify_first", "version"))
    printed = results["identify_printed"]
    rows = [
        ("`import stribeck`, above bare Python", results["import_above_python"], None, None),
        ("`stribeck --version`", version["wall"], version["processor"], version["least"]["wall"]),
        (
            "`stribeck identify`, typed to card printed",
            printed["wall"],
            printed["processor"],
            printed["least"]["wall"],
        ),
        (
            "with `--out`, to its figures drawn and its page written",
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
        *(f"| {what} | {_s(a)} | {_s(b)} | {_s(c)} |" for what, a, b, c in rows),
        "",
        "Where `identify --out` spends it, warm:",
        "",
        f"| {' | '.join(warm['shares'])} |",
        f"|{'---:|' * len(warm['shares'])}",
        f"| {' | '.join(f'{s:.2f} s' for s in warm['shares'].values())} |",
        "",
        *_comparison(printed, results["against"]),
    ]


def _comparison(here: Mapping[str, Any], there: Mapping[str, Any]) -> Iterator[str]:
    """This checkout beside another one: `identify` from typed to card printed."""
    if not there:
        return
    yield f"`stribeck identify`, typed to card printed, beside the checkout `{there['checkout']}`:"
    yield ""
    yield "| | here | there | here / there |"
    yield "|---|---:|---:|---:|"
    for kind, (a, b) in {
        "median": (here, there),
        "least": (here["least"], there["least"]),
    }.items():
        for n, head in TIMES.items():
            yield f"| {kind} {head} | {_s(a[n])} | {_s(b[n])} | {_s(a[n] / b[n])} |"
    yield ""


def _s(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds:.2f}"


def main() -> None:
    """Measure, and print the tables."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    options.add_argument("--quick", action="store_true", help="a third of the runs")
    options.add_argument("--against", type=Path, metavar="CHECKOUT", help="another checkout")
    chosen = options.parse_args()
    if chosen.against is not None and not (chosen.against / "src" / "stribeck").is_dir():
        sys.exit(f"{chosen.against}: no checkout of stribeck: it has no src/stribeck")
    print("\n".join(tables(measure(chosen.quick, chosen.against))))


if __name__ == "__main__":
    main()
