"""A force balance over ten million rows, beside the commit that version 0.1 ended with.

    python benchmarks/long_balance.py [1212ef9] [--rows 1e6,1e7] [--delays 0,3]
    python benchmarks/long_balance.py --show

The log is made in memory, and alike for both: 5 kg under 12 N, 30 N s/m and an offset of 0.5 N at
1 kHz, with noise on its force, which may be so many samples late. Each identification is one of a
process with one thread, the commit before the sources of now for each log; what is counted are the
processor seconds of `identify` alone, and the most memory of the process less what it had with its
log. Results go to long_balance.json.
"""

from __future__ import annotations

import argparse
import json
import resource
import time
from pathlib import Path
from typing import Any

import numpy as np

from against_commit import asked, both_sources

FILE = Path(__file__).with_suffix(".json")
RATE = 1000.0
TRUTH = {"F_C": 12.0, "F_V": 30.0, "M": 5.0, "offset": 0.5}


def log(rows: int, delay: int) -> Any:
    """A recording whose force is some samples late."""
    from stribeck import Recording  # noqa: PLC0415 - the sources under test

    t = np.arange(rows) / RATE
    x, force = np.empty(rows), np.empty(rows)
    rng = np.random.default_rng(0)
    w, w2 = 2 * np.pi * 0.23, 2 * np.pi * 0.031
    for start in range(0, rows, 1 << 17):
        part = slice(start, start + (1 << 17))
        s, late = t[part], t[part] - delay / RATE
        x[part] = 0.1 * np.sin(w * s) + 0.05 * np.sin(w2 * s + 1)
        x[part] += 1e-7 * rng.standard_normal(len(s))
        v = 0.1 * w * np.cos(w * late) + 0.05 * w2 * np.cos(w2 * late + 1)
        a = -0.1 * w * w * np.sin(w * late) - 0.05 * w2 * w2 * np.sin(w2 * late + 1)
        force[part] = TRUTH["F_C"] * np.sign(v) + TRUTH["F_V"] * v + TRUTH["M"] * a
        force[part] += TRUTH["offset"] + 0.3 * rng.standard_normal(len(s))
    return Recording(t=t, position=x, force=force)


def identified(rows: int, delay: int) -> dict[str, Any]:
    """What an identification takes in this process: seconds, MB beside the log, and its answer."""
    from stribeck import identify  # noqa: PLC0415 - the sources under test

    identify(log(20_000, delay), rig="forced")  # imports and compiles
    recording = log(rows, delay)
    statm = Path("/proc/self/statm").read_text(encoding="ascii")
    resident = int(statm.split()[1]) * resource.getpagesize()
    start = time.process_time()
    fit = identify(recording, rig="forced")
    seconds = time.process_time() - start
    peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {
        "seconds": round(seconds, 2),
        "bytes_a_row": round((peak - resident) / rows, 1),
        "peak_MB": round(peak / 1e6),
        "estimates": {e.name: [e.value, e.low, e.high, e.verdict] for e in fit.estimates},
    }


def measured(commit: str, rows: list[int], delays: list[int]) -> dict[str, Any]:
    """All pairs, kept as they come."""
    results: dict[str, Any] = {"commit": commit, "fits": []}
    with both_sources(commit) as sources:
        for count in rows:
            for delay in delays:
                call = f"identified({count}, {delay})"
                pair = {who: asked(path, call, "long_balance") for who, path in sources.items()}
                results["fits"].append({"rows": count, "delay": delay, **pair})
                FILE.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
                print(call, pair, flush=True)
    return results


def table(results: dict[str, Any]) -> str:
    """Seconds and memory, before and now, and the mass that either answers."""
    from stribeck.report.table import Table  # noqa: PLC0415 - not the sources under test

    lines = []
    for row in results["fits"]:
        before, now = row["before"], row["now"]
        ratio = now["seconds"] / before["seconds"]
        cells = [f"{row['rows']:,}", f"{row['delay']}"]
        cells += [f"{r['seconds']:.1f}" for r in (before, now)] + [f"{ratio:.2f}"]
        cells += [f"{r['bytes_a_row']:.0f}" for r in (before, now)]
        for r in (before, now):
            value, low, high, verdict = r["estimates"]["M"]
            cells.append(f"{value:.4f} ({low:.4f} to {high:.4f}), {verdict}")
        lines.append(cells)
    heads = ["rows", "late", "s, 0.1", "s, now", "ratio", "B/row, 0.1", "B/row, now"]
    title = f"A force balance by {results['commit']} (0.1) and now: processor seconds, bytes a row"
    note = "late: of the force, samples; bytes a row beside the log; the mass is 5 kg."
    heads += ["M, 0.1", "M, now"]
    return Table.of_texts(title, heads, lines, labels=(7, 8), note=note).text()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("commit", nargs="?", default="1212ef9")
    parser.add_argument("--rows", default="1e6,1e7")
    parser.add_argument("--delays", default="0,3")
    parser.add_argument("--show", action="store_true", help="what is kept, and nothing new")
    chosen = parser.parse_args()
    print(
        table(
            json.loads(FILE.read_text(encoding="utf-8"))
            if chosen.show
            else measured(
                chosen.commit,
                [int(float(n)) for n in chosen.rows.split(",")],
                [int(n) for n in chosen.delays.split(",")],
            )
        )
    )
