"""Coverage of the intervals: recordings of known truth, identified with the defaults.

    python benchmarks/run.py --only intervals

Every recording that is done is a line of intervals.part.jsonl, beside this file: a run that was
interrupted goes on from there. Once all are done it becomes intervals.jsonl, and the next run
begins anew.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numba
import numpy as np
from scipy.stats import beta

from interval_twins import MEMORY, SWINGS, Known, bed, loop, pendulum
from stribeck import Fit, identify
from stribeck.bench.engines import cores
from stribeck.errors import InputError
from stribeck.report.format import grouped
from stribeck.report.table import Cell, Table
from stribeck.space import Param, Space

FOLDER = Path(__file__).parent
#: One identified recording: its study and number, and its estimates.
Row = dict[str, Any]

VERDICTS = ("identified", "weak", "not identifiable")
#: Goal for the coverage of nominal 95 % intervals of identified parameters.
GOAL = (0.90, 0.99)
#: Data sets a bootstrap draws here; a user's default is 200.
DRAWS = 60
#: Half of a normal distribution lies within so many standard deviations.
QUARTILE = 0.6745
#: Noise of so many seeds on each of a handful of slide beds: some whose interval takes most of a
#: range, some whose interval is short and ends at the range.
SEEDS, BEDS = 20, (2, 14, 19, 25, 28)


@dataclass(frozen=True)
class Study:
    """One kind of recordings.

    Args:
        title: Of its table.
        recording: Recording number k.
        count: How many, and how many in a short pass.
        draws: Data sets of the bootstrap; 0 for none.
        note: Below the table.
    """

    title: str
    recording: Callable[[int], Known]
    count: tuple[int, int]
    draws: int = 0
    note: str = ""


def _seeded(k: int) -> Known:
    return bed(BEDS[k % len(BEDS)], seed=1_000 + k // len(BEDS))


STUDIES = {
    "bed": Study(
        "Slide beds with random true parameters, white noise",
        bed,
        (200, 3),
        note="One stroke each, in turn rightward and leftward; noise of 0.05 to 0.5 mm, 20 to "
        "200 Hz.",
    ),
    "seeds": Study("", _seeded, (SEEDS * len(BEDS), 0)),
    "loop": Study(
        "EMPS loops, white noise on the force",
        loop,
        (100, 2),
        draws=DRAWS,
        note="24 s at 1 kHz, 3 to 30 N of noise before filtering.",
    ),
    "loop, correlated": Study(
        "EMPS loops, noise that forgets within fifty samples",
        lambda k: loop(k, memory=10 * MEMORY),
        (100, 1),
        draws=DRAWS,
        note="Fifty samples of the log are five rows of the balance.",
    ),
    "loop, held": Study(
        "EMPS loops, the force logged as the controller writes it",
        lambda k: loop(k, locked=True),
        (100, 1),
        note="The controller holds its output for a sample, so the logged force is half a sample "
        "ahead of the motion. No interval knows of that: these hold the truth where the noise is "
        "larger than what half a millisecond does.",
    ),
    "pendulum": Study(
        "Servo pendulums, white noise on the angle",
        pendulum,
        (20, 1),
        note=f"{SWINGS} logs each.",
    ),
    "bed, correlated": Study(
        "Slide beds, noise that forgets within five samples",
        lambda k: bed(k, memory=MEMORY),
        (60, 1),
        draws=DRAWS,
        note=f"A first-order autoregression; the bootstrap draws {DRAWS} data sets.",
    ),
}


def measure(quick: bool = False) -> dict[str, Any]:
    """Identify all recordings that are not in the file yet, and count.

    Args:
        quick: A few of each kind.
    """
    folder = FOLDER / "quick" if quick else FOLDER
    folder.mkdir(exist_ok=True)
    part, whole = folder / "intervals.part.jsonl", folder / "intervals.jsonl"
    pairs = [(name, k) for name, s in STUDIES.items() for k in range(s.count[quick])]
    rows = identified(part, pairs)
    part.replace(whole)
    return summary(rows)


# --- recordings, one by one -----------------------------------------------------------------------


def identified(file: Path, pairs: Sequence[tuple[str, int]]) -> list[Row]:
    """The rows of pairs of study and recording, in their order; missing ones are identified."""
    rows = {(r["study"], r["k"]): r for r in read(file)}
    missing = [w for w in pairs if w not in rows]
    with file.open("a", encoding="utf-8") as stream:
        for row in _identified_rows(missing):
            rows[row["study"], row["k"]] = row
            stream.write(json.dumps(row) + "\n")
            stream.flush()
    return [rows[w] for w in pairs]


def read(file: Path) -> list[Row]:
    """The lines of a file; one that was cut off while it was written is left out."""
    if not file.exists():
        return []
    lines = file.read_text(encoding="utf-8").split("\n")
    if lines[-1]:
        file.write_text("".join(f"{line}\n" for line in lines[:-1]), encoding="utf-8")
    return [json.loads(line) for line in lines[:-1]]


def _identified_rows(missing: Sequence[tuple[str, int]]) -> Iterator[Row]:
    if min(cores(), len(missing)) < 2:  # noqa: PLR2004 - one core needs no other process
        numba.set_num_threads(1)
        yield from (identified_row(*w) for w in missing)
        return
    fresh = get_context("spawn")
    with ProcessPoolExecutor(
        min(cores(), len(missing)), fresh, numba.set_num_threads, (1,)
    ) as pool:
        for ended in as_completed([pool.submit(identified_row, *w) for w in missing]):
            yield ended.result()


def identified_row(study: str, k: int) -> Row:
    """The identification of recording k of a study, or the reason of its refusal."""
    axis, draws = STUDIES[study].recording(k), STUDIES[study].draws
    header = {"study": study, "k": k, "noise": axis.noise, "rate": round(axis.rate, 3)}
    start_time = time.perf_counter()
    try:
        fit = identify(list(axis.recordings), rig=axis.rig, law=axis.law, draws=draws)
    except InputError as error:
        return header | {"seconds": 0.0, "refused": str(error), "parameters": {}}
    seconds = time.perf_counter() - start_time
    return header | {
        "misfit": fit.score.value,
        "seconds": round(seconds, 2),
        "parameters": _parameters(fit, axis.truth),
    }


def _parameters(fit: Fit, truth: dict[str, float]) -> dict[str, Row]:
    """The estimate of each parameter, with its place in the search range."""
    names = (q.name for q in fit.parameters.free)
    errors = dict(zip(names, fit.uncertainty.errors.tolist(), strict=False))
    rows = {}
    for q, e in zip(fit.parameters.every, fit.estimates, strict=True):
        if e.verdict != "fixed":
            rows[q.name] = {
                "truth": _short(truth[q.name]),
                "value": _short(e.value),
                "at": round(_at(q, e.value), 5),
                "error": _short(errors.get(q.name, math.nan)),
                "interval": [_short(e.low), _short(e.high)],
                "ended": [e.low_ended, e.high_ended],
                "verdict": e.verdict,
                "resampled": e.resampled and [_short(x) for x in e.resampled],
            }
    return rows


def _at(q: Param, value: float) -> float:
    return float(Space((q,)).encode(np.array([[value]]))[0, 0])


def _short(value: float) -> float | None:
    return float(f"{value:.7g}") if math.isfinite(value) else None


# --- counting -------------------------------------------------------------------------------------


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """The counts of every study."""
    by: dict[str, list[Row]] = {}
    for row in rows:
        by.setdefault(row["study"], []).append(row)
    seeds = by.pop("seeds", [])
    return {
        "draws": DRAWS,
        "seeds": SEEDS,
        "studies": {name: study(group) for name, group in by.items()},
        "spread": spread(seeds),
    }


def study(rows: Sequence[Row]) -> dict[str, Any]:
    """The counts of one study, for each parameter and for all together."""
    refused = [r["refused"] for r in rows if "refused" in r]
    recordings, rows = len(rows), [r for r in rows if "refused" not in r]
    names = list(rows[0]["parameters"]) if rows else []
    counted: dict[str, Any] = {n: _counts([r["parameters"][n] for r in rows]) for n in names}
    counted["all"] = _counts([p for r in rows for p in r["parameters"].values()])
    missed = [
        [r["k"], name, p["verdict"]]
        for r in rows
        for name, p in r["parameters"].items()
        if not _inside(p)
    ]
    return {
        "recordings": recordings,
        "refused": len(refused),
        "refusals": sorted(set(refused)),
        "missed": [" ".join(map(str, m)) for m in missed],
        "seconds": float(np.median([r["seconds"] for r in rows])) if rows else None,
        "parameters": counted,
    }


def _counts(rows: Sequence[Row]) -> dict[str, Any]:
    by = {v: coverage([p for p in rows if p["verdict"] == v]) for v in VERDICTS}
    drawn = [p for p in rows if p["resampled"] and None not in p["resampled"]]
    return {
        **by,
        "every": coverage(rows),
        "bootstrap": {
            estimates: coverage([p for p in drawn if p["verdict"] in verdicts], "resampled")
            for estimates, verdicts in (("identified", VERDICTS[:1]), ("every", VERDICTS))
        }
        if drawn
        else None,
        "z": _z(rows),
    }


def coverage(rows: Sequence[Row], key: str = "interval") -> dict[str, Any]:
    """The share of intervals that hold the truth, with its 95 % interval.

    The half-width is the median of half the interval over the value.
    """
    inside = sum(_inside(p, key) for p in rows)
    widths = [(p[key][1] - p[key][0]) / 2 / abs(p["value"]) for p in rows if p["value"]]
    return {
        "of": len(rows),
        "held": inside,
        "share": list(binomial(inside, len(rows))),
        "half_width": float(np.median(widths)) if widths else None,
    }


def _inside(p: Row, key: str = "interval") -> bool:
    return bool(p[key][0] <= p["truth"] <= p[key][1])


def _z(rows: Sequence[Row]) -> float | None:
    """The scale of errors over standard errors, from their median; 1 if these are right."""
    z = [abs(p["value"] - p["truth"]) / p["error"] for p in rows if p["error"]]
    return float(np.median(z)) / QUARTILE if z else None


def binomial(hits: int, trials: int, level: float = 0.95) -> tuple[float, float]:
    """Clopper and Pearson's interval of a share (1934, doi 10.1093/biomet/26.4.404)."""
    tail = (1 - level) / 2
    low = float(beta.ppf(tail, hits, trials - hits + 1)) if hits else 0.0
    high = float(beta.ppf(1 - tail, hits + 1, trials - hits)) if hits < trials else 1.0
    return low, high


def spread(rows: Sequence[Row]) -> list[Row]:
    """For every bed and parameter: counts of the verdicts, and the spread of the estimates."""
    spreads = []
    for n, k in enumerate(BEDS):
        of_bed = [r for r in rows if r["k"] % len(BEDS) == n and r["parameters"]]
        if not of_bed:
            continue
        for name in of_bed[0]["parameters"]:
            estimates = [r["parameters"][name] for r in of_bed]
            verdicts = [p["verdict"] for p in estimates]
            low, high = np.percentile([p["at"] for p in estimates], [5, 95])
            spreads.append({
                "bed": k,
                "parameter": name,
                "seeds": len(estimates),
                "verdict": max(VERDICTS, key=verdicts.count),
                "so_often": max(verdicts.count(v) for v in VERDICTS),
                "spread": float(high - low),
            })  # fmt: skip
    return spreads


# --- tables ---------------------------------------------------------------------------------------


def tables(results: dict[str, Any]) -> list[str]:
    """The counts, in Markdown."""
    texts = [
        _table(STUDIES[name], counts).markdown() for name, counts in results["studies"].items()
    ]
    if results["spread"]:
        texts.append(_spread(results).markdown())
    return texts


def _table(study: Study, counts: dict[str, Any]) -> Table:
    counted: dict[str, Any] = counts["parameters"]
    drawn = counted["all"]["bootstrap"] is not None
    heads = ("parameter", "identified", "± / %", "weak", "± / %", "not identifiable", "every")
    rows = []
    for name, c in counted.items():
        cells = [Cell.label(name), *_coverage_cells(c["identified"]), *_coverage_cells(c["weak"])]
        cells += [_coverage_cells(c["not identifiable"])[0], _coverage_cells(c["every"])[0]]
        if drawn:
            cells += [
                _coverage_cells(c["bootstrap"][verdict])[0] for verdict in ("identified", "every")
            ]
        rows.append((*cells, Cell.number(math.nan if c["z"] is None else c["z"], 3)))
    return Table(
        f"{study.title}: how often a nominal 95 % interval holds the truth",
        (*heads, *(("bootstrap: identified", "every") if drawn else ()), "z"),
        tuple(rows),
        " ".join(_notes(study, counts)),
    )


def _coverage_cells(c: dict[str, Any]) -> tuple[Cell, Cell]:
    if not c["of"]:
        return Cell("–"), Cell("–")
    low, high = c["share"]
    text = f"{c['held']}/{c['of']}, {100 * low:.1f} to {100 * high:.1f} %"
    return Cell.label(text), Cell.number(100 * (c["half_width"] or math.nan), 2)


def _notes(study: Study, counts: dict[str, Any]) -> Iterable[str]:
    yield f"{counts['recordings']} recordings. {study.note}"
    if counts["refused"]:
        yield f"{counts['refused']} were refused: {' '.join(f'“{r}”' for r in counts['refusals'])}."
    yield "Held/of, and the binomial 95 % interval of that share (Clopper and Pearson);"
    yield "±: median half-width over the value;"
    yield "z: error over standard error, the median over the normal's 0.6745, 1 if it is right."
    yield f"Goal: {GOAL[0]:.0%} to {GOAL[1]:.0%} of the identified: {_met(counts['parameters'])}."


def _met(counted: dict[str, Any]) -> str:
    """The parameters that miss the goal, by their share and by its binomial interval."""
    low, high = GOAL
    missed: list[str] = []
    insignificant: list[str] = []
    for name, by in counted.items():
        c = by["identified"]
        if name == "all" or not c["of"] or low <= c["held"] / c["of"] <= high:
            continue
        significant = c["share"][1] < low or c["share"][0] > high
        (missed if significant else insignificant).append(f"{name} ({c['held']}/{c['of']})")
    clauses = [f"missed by {', '.join(missed)}"] if missed else []
    clauses += (
        [f"outside, but within their binomial interval: {', '.join(insignificant)}"]
        if insignificant
        else []
    )
    return "; ".join(clauses) or "met by each"


def _spread(results: dict[str, Any]) -> Table:
    rows = [
        (
            Cell(str(s["bed"]), s["bed"]),
            Cell.label(s["parameter"]),
            Cell.label(s["verdict"]),
            Cell(f"{s['so_often']}/{s['seeds']}", f"{s['so_often']}/{s['seeds']}"),
            Cell.number(100 * s["spread"], 2),
        )
        for s in results["spread"]
    ]
    least = min((s["spread"] for s in results["spread"] if s["verdict"] == VERDICTS[-1]), default=0)
    least_spread = (
        f"Least among the not identifiable: {grouped(100 * least, 2)} %." if least else ""
    )
    return Table(
        "Estimates across seeds of the noise: the share of the search range that they take",
        ("bed", "parameter", "verdict", "so often", "spread / %"),
        tuple(rows),
        f"{results['seeds']} seeds each; from the 5th to the 95th percentile, in the scale of the "
        f"search; the verdict is the one given most often. {least_spread}".strip(),
    )
