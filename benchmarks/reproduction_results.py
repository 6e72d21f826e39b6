"""What is said now of logs of which earlier versions erred, read from the results of studies."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np

import ert_coverage
import nested_laws
import noise_seeds

RESULTS = Path(__file__).with_name("results.json")


def results_of(name: str) -> Any:
    """What a part of `run` has measured."""
    return json.loads(RESULTS.read_text(encoding="utf-8"))[name]["found"]


def fault(kind: str, perturbation: str, *parameters: str) -> str:
    """A row of the fault table: biases, how often identified, and whether the table has it told."""
    rows = [r for r in results_of("faults")["rows"] if r["kind"] == kind]
    row = next(r for r in rows if r["perturbation"] == perturbation)  # with exact constants first
    found = [(n, row["parameters"][n]) for n in parameters or row["parameters"]]
    texts = [
        f"{n} {100 * p['bias']:+.1f} %, identified in {p['identified']} of {p['of']}"
        for n, p in found
    ]
    return "; ".join([*texts, *(["told"] if row["told"] else [])])


def held(study: str, parameter: str) -> str:
    """How many intervals of a study hold the truth."""
    counts = results_of("intervals")["studies"][study]["parameters"][parameter]
    known, every = counts["identified"], counts["every"]
    return (
        f"{every['held']} of {every['of']} intervals hold the truth, "
        f"{known['held']} of {known['of']} of those identified"
    )


def told(kind: str, perturbation: str) -> str:
    """The sentence that names the fault of a row of the fault table."""
    rows = results_of("faults")["rows"]
    return str(
        next(r["told"] for r in rows if (r["kind"], r["perturbation"]) == (kind, perturbation))
    )


def faulty() -> str:
    """How many perturbations of the fault table have an identified value off, and nothing said."""
    rows = [r for r in results_of("faults")["rows"] if not r["clean"]]
    silent = sum(bool(r["lies"]) for r in rows)
    return f"{silent} of {len(rows)} perturbations (more than 3 % off)"


def nested() -> str:
    """Laws of the servos that end above one that they contain, and where m4 ends."""
    results = _nested_results()
    above = list(nested_laws.broken(results))
    best = min(r["error"] for key, r in results.items() if key.startswith("xl330/absolute/m4"))
    return f"{above or 'no law ends above one that it contains'}; m4 {best:.1f} mrad by absolute"


def evaluations(law: str) -> str:
    """What searches of the 16 logs of a servo take, by seed."""
    rows = [
        row for key, row in sorted(_nested_results().items())
        if re.fullmatch(rf"xl330/absolute/{law}/\d+", key)
    ]  # fmt: skip
    counts = [f"{row['evaluations']:,}" for row in rows]
    return f"{', '.join(counts)} by seed"


def guessed(law: str) -> str | None:
    """How many ends of a law's intervals are guesses, where intervals were asked for."""
    rows = [row for key, row in _nested_results().items() if f"/{law}/" in key and "ends" in row]
    if not rows:
        return None
    return f"{sum(r['guessed'] for r in rows)} of {sum(r['ends'] for r in rows)} ends are guesses"


def _nested_results() -> dict[str, Any]:
    return dict(json.loads(nested_laws.FILE.read_text(encoding="utf-8")))


def flips() -> str:
    """Verdicts that another seed of the noise makes others, and how many of them said so."""
    counts = noise_seeds.total(noise_seeds.kept())
    return (
        f"{100 * counts['flips'] / counts['verdicts']:.1f} % ({counts['flips']} of "
        f"{counts['verdicts']}); {counts['foretold']} of them were called borderline"
    )


def running_times() -> str:
    """The shares of intervals of the expected running time that hold it, over all cells."""
    shares = [ert_coverage.shares(of)[1] for of in ert_coverage.kept().values()]
    return f"{min(shares):.0f} to {max(shares):.0f} %, {np.median(shares):.0f} % in the middle"


def breakaway() -> str:
    """F_S of three joints, slip by slip, beside the torques at which their slips began."""
    texts = []
    for number, part in results_of("axes")["joints"].items():
        row, seen = part["by slip"]["all"], part["onsets"]
        value, low, high, verdict = row["estimates"]["F_S"]
        texts.append(
            f"joint {number}: {value:.2f} N m ({low:.2f} to {high:.2f}), {verdict}, scatter "
            f"{row['spread'][0]:.2f} (onsets {seen['F_S']:.2f}, scatter {seen['scatter']:.2f})"
        )
    return "; ".join(texts)
