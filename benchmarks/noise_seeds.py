"""How many verdicts are others when nothing but the noise is, and how many say so.

    python benchmarks/noise_seeds.py [--axes 8] [--show]

Axes of the study of intervals are identified twice, from logs that differ in the seed of the noise.
A verdict that is another the second time is a flip; it was foretold if either of the two was called
borderline. Each identification is a line of noise_seeds.part.jsonl, so that an interrupted run goes
on; the counts go to noise_seeds.json.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from foreign_axes import noisy, recordings
from intervals import STUDIES, binomial
from resumable import Answer, completed
from stribeck import RIGS, identify
from stribeck.errors import InputError
from stribeck.report.table import Cell, Table

FOLDER = Path(__file__).parent
FILE, PART = FOLDER / "noise_seeds.json", FOLDER / "noise_seeds.part.jsonl"
#: Studies of intervals whose axes are taken, and the seeds of the noise on their logs.
KINDS, SEEDS = ("bed", "balance", "cylinder", "pendulum"), (0, 1)

#: Flips and foretold ones, verdicts called borderline, and all: of one kind of axes.
Counts = dict[str, int]


def verdicts(kind: str, k: int, seed: int) -> Answer:
    """The verdict on each parameter of one axis, and whether it was called borderline."""
    study = STUDIES[kind]
    axis = study.axis(k)
    tables = noisy(axis, np.random.default_rng((k, seed)), study.memory)
    header = {"kind": kind, "k": k, "seed": seed}
    try:
        rig = RIGS[axis.rig].set(**axis.given)
        fit = identify(recordings(axis, tables), rig=rig, law=axis.law)
    except InputError as error:
        return header | {"refused": str(error), "verdicts": {}}
    given = {e.name: [e.verdict, e.borderline] for e in fit.estimates if e.verdict != "fixed"}
    return header | {"verdicts": given}


def counted(answers: Sequence[Answer]) -> dict[str, Counts]:
    """The counts of each kind of axes."""
    counts = {kind: dict.fromkeys(("verdicts", "borderline", "flips", "foretold"), 0)
              for kind in KINDS}  # fmt: skip
    for kind, first, second in _pairs(answers):
        known = max(first[1], second[1])
        flipped = first[0] != second[0]
        of = counts[kind]
        of["verdicts"] += 1
        of["borderline"] += known
        of["flips"] += flipped
        of["foretold"] += flipped and known
    return counts


def _pairs(answers: Sequence[Answer]) -> Iterator[tuple[str, tuple[str, bool], tuple[str, bool]]]:
    """Kind of the axis, and both verdicts on a parameter that both seeds have."""
    by = {(a["kind"], a["k"], a["seed"]): a["verdicts"] for a in answers}
    for (kind, k, seed), first in by.items():
        if seed == SEEDS[0]:
            second = by.get((kind, k, SEEDS[1]), {})
            yield from ((kind, first[n], second[n]) for n in first if n in second)


def kept() -> dict[str, Counts]:
    """The counts as they were last made."""
    return dict(json.loads(FILE.read_text(encoding="utf-8")))


def total(counts: dict[str, Counts]) -> Counts:
    """The counts of all kinds together."""
    return {name: sum(of[name] for of in counts.values()) for name in counts[KINDS[0]]}


def table(counts: dict[str, Counts]) -> Table:
    """A row for each kind of axes, and one for all."""
    rows = []
    for kind, of in (counts | {"all": total(counts)}).items():
        low, high = binomial(of["flips"], of["verdicts"])
        share = f"{of['flips']}/{of['verdicts']}, {100 * low:.1f} to {100 * high:.1f} %"
        told = f"{of['foretold']}/{of['flips']}"
        called = f"{of['borderline']}/{of['verdicts']}"
        rows.append(tuple(map(Cell.label, (kind, share, told, called))))
    return Table(
        "Verdicts that another seed of the noise makes others",
        ("axes", "flips, Wilson's 95 %", "flips called borderline", "all called borderline"),
        tuple(rows),
    )


def main() -> None:
    """Identify what is missing, count, and print the table."""
    ask = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    ask.add_argument("--axes", type=int, default=8, help="of each kind")
    ask.add_argument("--show", action="store_true", help="what is kept, and nothing new")
    options = ask.parse_args()
    if not options.show:
        jobs = [(kind, k, s) for kind in KINDS for k in range(options.axes) for s in SEEDS]
        answers = completed(PART, jobs, verdicts, lambda a: (a["kind"], a["k"], a["seed"]))
        FILE.write_text(json.dumps(counted(answers), indent=1) + "\n", encoding="utf-8")
    print(table(kept()).text())


if __name__ == "__main__":
    main()
