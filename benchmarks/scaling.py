"""Growth of time and memory with samples, candidates and strokes.

Time: seconds for one call of J, the least of several. Memory: the peak of a process of its own
that evaluates 10,000 candidates on a log of ten minutes at 1 kHz.

    python benchmarks/scaling.py memory SAMPLES CANDIDATES
"""

from __future__ import annotations

import json
import math
import re
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from stribeck.data import Recording
from stribeck.friction import LAWS
from stribeck.identify.problem import MotionProblem, problem
from stribeck.rig.motion.command import Drive
from stribeck.rig.motion.track import track
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED
from stribeck.space import Array

FIGURE = Path(__file__).with_name("scaling.png")
LAW = LAWS["stribeck"]
#: A stroke: from 50 to 350 mm and back at 5 mm/s, a minute each way.
LOW, HIGH, SPEED = 0.050, 0.350, 0.005
#: Rest before and after, s.
HOLD = 1.0
#: An encoder's noise, m.
NOISE = 1e-6
#: The varied sizes, their values in full and in a short pass; the others stay at FIXED.
VARIED = {
    "samples": (np.logspace(3, 6, 7), np.logspace(3, 5, 3)),
    "candidates": (np.logspace(0, 5, 11), np.logspace(0, 3, 4)),
    "strokes": (np.array([1, 2, 5, 10, 20, 50, 100]), np.array([1, 5, 20])),
}
FIXED = {"samples": 6_000, "candidates": 40, "strokes": 1}
#: Axes of the figure: the varied size, and the values of the others.
LABELS = {
    "samples": "Samples (40 candidates)",
    "candidates": "Candidates (6,000 samples)",
    "strokes": "Strokes (of 6,000 samples)",
}
#: Samples and candidates of the process whose memory is measured: ten minutes at 1 kHz.
MEMORY = (600_000, 10_000)
LIMIT = 2**30
#: Decades at the upper end that the exponent is fitted to: below them fixed costs show.
DECADES = 2.0


def log(samples: int, strokes: int) -> Recording:
    """A recording of so many strokes, to and fro, with so many samples in all."""
    points = [LOW, HIGH] * (strokes // 2 + 1)
    drive = Drive.path(points[: strokes + 1], SPEED, hold=HOLD)
    t = np.linspace(0.0, drive.t[-1], samples)
    motion = SLIDE_BED.move(LAW, PUBLISHED["right"][None], track(drive, t, LOW - 0.006))
    noise = NOISE * np.random.default_rng(0).standard_normal(samples)
    return Recording(t=t, position=motion.position[0] + noise, command=drive(t))


def posed(samples: int, strokes: int) -> MotionProblem:
    """The identification from such a log, all of it."""
    return problem(log(samples, strokes), rig=SLIDE_BED, law=LAW)


def measure(quick: bool = False) -> dict[str, Any]:
    """Time calls of J and measure the memory.

    Args:
        quick: Fewer and smaller sizes.
    """
    results: dict[str, Any] = {"varied": {}}
    for size, (full, short) in VARIED.items():
        sizes = [round(v) for v in (short if quick else full)]
        seconds = _seconds(size, sizes, rounds=2 if quick else 5)
        slope, from_ = exponent(np.array(sizes), np.array(seconds))
        results["varied"][size] = {
            "sizes": sizes,
            "seconds": seconds,
            "exponent": slope,
            "fitted_from": from_,
        }
    samples, candidates = (MEMORY[0] // 10, MEMORY[1] // 10) if quick else MEMORY
    results["memory"] = _memory(samples, candidates) | {
        "samples": samples,
        "candidates": candidates,
    }
    if not quick:
        draw(results)
    return results


def _seconds(size: str, sizes: list[int], rounds: int) -> list[float]:
    """Mean seconds of a call at each size, the least of several rounds.

    No candidate repeats: a processor learns the branches of a few hundred repeated candidates, and
    is then twice as fast as in any search. Rounds go through all sizes, so that a busy moment of
    the machine hits all.
    """
    passes = [_pass(size, n) for n in sizes]
    best = [math.inf] * len(sizes)
    for _ in range(rounds):
        for k, (identification, calls) in enumerate(passes):
            start_time = time.perf_counter()
            for x in calls:
                identification(x)
            best[k] = min(best[k], (time.perf_counter() - start_time) / len(calls))
    return best


def _pass(varied: str, n: int) -> tuple[MotionProblem, list[Array]]:
    """A problem and candidates for as many calls as take a tenth of a second."""
    size = FIXED | {varied: n}
    if varied == "strokes":
        size["samples"] = FIXED["samples"] * n
    identification, rng = posed(size["samples"], size["strokes"]), np.random.default_rng(1)

    def drawn() -> Array:
        return identification.space.decode(identification.space.sample(rng, size["candidates"]))

    identification(x := drawn())
    start_time = time.perf_counter()
    identification(x)
    calls = math.ceil(0.1 / (time.perf_counter() - start_time))
    return identification, [drawn() for _ in range(calls)]


def exponent(sizes: np.ndarray, seconds: np.ndarray) -> tuple[float, float]:
    """Slope of log seconds over log size in the upper decades, and where they begin."""
    upper = sizes >= sizes[-1] / 10**DECADES * (1 - 1e-9)
    slope = np.polyfit(np.log(sizes[upper]), np.log(seconds[upper]), 1)[0]
    return float(slope), float(sizes[upper][0])


def _memory(samples: int, candidates: int) -> dict[str, Any]:
    command = [sys.executable, __file__, "memory", str(samples), str(candidates)]
    completed = subprocess.run(command, check=True, capture_output=True, text=True)  # noqa: S603
    peaks: dict[str, Any] = json.loads(completed.stdout)
    return peaks


def _resident() -> int:
    """The peak of this process's resident memory, bytes."""
    status = Path("/proc/self/status")
    if status.exists():  # getrusage's includes what the parent held when it began this process
        peak = re.search(r"VmHWM:\s*(\d+) kB", status.read_text(encoding="utf-8"))
        if peak:
            return int(peak[1]) * 1024
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def memory(samples: int, candidates: int) -> None:
    """Evaluate the candidates and print the peak of memory, before and after."""
    identification = posed(samples, round(samples / 60_000) or 1)
    x = identification.space.decode(
        identification.space.sample(np.random.default_rng(1), candidates)
    )
    before = _resident()
    start_time = time.perf_counter()
    costs = identification(x)
    seconds = time.perf_counter() - start_time
    finite = int(np.isfinite(costs).sum())
    print(json.dumps({"before": before, "peak": _resident(), "seconds": seconds, "run": finite}))


def draw(results: dict[str, Any]) -> None:
    """The figure: seconds a call over each size, log by log, with a line of exponent 1."""
    import matplotlib as mpl  # noqa: PLC0415 - the process whose memory is measured has none of it
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    from stribeck.report.figures.style import COMMAND, MODEL, STYLE  # noqa: PLC0415

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.6, 3.6), layout="constrained")
        FigureCanvasAgg(figure)
        for axes, (size, row) in zip(
            figure.subplots(1, 3, sharey=True), results["varied"].items(), strict=True
        ):
            sizes, seconds = np.array(row["sizes"], dtype=float), np.array(row["seconds"])
            ends = sizes[[0, -1]]
            axes.plot(ends, seconds[-1] * ends / ends[-1], "--", color=COMMAND, label="linear")
            axes.plot(sizes, seconds, "o-", ms=4, color=MODEL, label="measured")
            axes.set(xscale="log", yscale="log", xlabel=LABELS[size], title=_title(size, row))
        first = figure.axes[0]
        first.set(ylabel="Seconds for one call of J")
        first.legend(loc="upper left")
        figure.savefig(FIGURE, dpi=160, metadata={"Software": None})


def _title(size: str, row: dict[str, Any]) -> str:
    return f"{size.capitalize()}: exponent {row['exponent']:.2f}"


def tables(results: dict[str, Any]) -> list[str]:
    """Exponents and memory, in Markdown."""
    from stribeck.report.table import Cell, Table  # noqa: PLC0415

    rows = []
    for size, row in results["varied"].items():
        sizes, seconds = row["sizes"], row["seconds"]
        span = f"{sizes[0]:,} to {sizes[-1]:,}"
        rows.append((
            Cell.label(size),
            Cell.label(span),
            Cell.number(1e3 * seconds[0], 3),
            Cell.number(1e3 * seconds[-1], 3),
            Cell.number(1e6 * seconds[-1] / sizes[-1], 3),
            Cell(f"{row['exponent']:.2f}", row["exponent"]),
        ))  # fmt: skip
    growth = Table(
        "How the time of one call of J grows",
        ("what grows", "range", "first/ms", "last/ms", "last, µs each", "exponent"),
        tuple(rows),
        f"Else 1 stroke, {FIXED['samples']:,} samples a stroke, {FIXED['candidates']} candidates; "
        "no candidate is asked twice in a pass. The exponent is fitted over the last "
        f"{DECADES:g} decades: 1 is linear.",
    )
    m = results["memory"]
    text = f"{m['peak'] / 2**20:,.0f} MiB"
    memory_table = Table(
        f"Peak memory: {m['candidates']:,} candidates on a log of {m['samples']:,} samples (1 kHz)",
        ("peak", "before the call", "limit", "seconds"),
        (
            (
                Cell(text, m["peak"]),
                Cell(f"{m['before'] / 2**20:,.0f} MiB", m["before"]),
                Cell(f"{LIMIT / 2**20:,.0f} MiB", LIMIT),
                Cell.number(m["seconds"], 3),
            ),
        ),
        "Resident memory of the whole process, Python and its libraries included.",
    )
    return [growth.markdown(), memory_table.markdown()]


if __name__ == "__main__":
    if len(sys.argv) == 4 and sys.argv[1] == "memory":  # noqa: PLR2004
        memory(int(sys.argv[2]), int(sys.argv[3]))
    else:
        sys.exit(__doc__)
