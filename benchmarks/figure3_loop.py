"""Coverage of intervals on the twin of figure 3, its loop closed through the sensors or ideally.

    python benchmarks/figure3_loop.py [--seeds N] [--show]

Each seed is a ramp up, fitted over 112 to 295 mm with the constants exact: the ideal loop with one
breakaway for all slips; the loop through the sensors so, slip by slip without its force, and as
`identify` does by default: slip by slip, by what the controller read. Answers are lines of
docs/data/figure3_loop.jsonl: an interrupted run goes on from there.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from resumable import Answer, completed, lines
from stribeck import identify
from stribeck.errors import InputError
from stribeck.report.table import Table
from stribeck.rig.slide_bed import PUBLISHED, SLIDE_BED
from stribeck.rig.twin import TestBed

FILE = Path(__file__).parents[1] / "docs" / "data" / "figure3_loop.jsonl"
#: Loop of the log, and how it is fitted: with one breakaway for all slips, slip by slip where the
#: log has no force, or by what the controller read.
FITS = (
    ("ideal", "common"), ("sensors", "common"), ("sensors", "scattered"), ("sensors", "reading"),
)  # fmt: skip
TRUTH = dict(
    zip(("F_S", "F_C", "F_V", "v_SS", "exponent", "k_spring"), PUBLISHED["right"], strict=True)
)
FREE = tuple(name for name in TRUTH if name != "exponent")


def fitted(seed: int, loop: str, breakaway: str) -> Answer:
    """The estimates of one log."""
    log = TestBed(loop=loop).run("up", seed=seed).recording  # type: ignore[arg-type]
    if breakaway == "scattered":
        log = replace(log, force=None, current=None)
    answer: Answer = {"seed": seed, "loop": loop, "breakaway": breakaway}
    try:
        fit = identify(
            log, rig=SLIDE_BED.exact(), law="stribeck", train="112:295",
            breakaway="auto" if breakaway == "reading" else breakaway,  # type: ignore[arg-type]
        )  # fmt: skip
    except InputError as error:  # too few slips to go slip by slip
        return answer | {"refused": str(error)}
    estimates = {
        e.name: [e.value, e.low, e.high, e.verdict] for e in fit.estimates if e.name in FREE
    }
    return answer | {"J_mm": fit.score.value, "estimates": estimates}


def table(answers: list[Answer]) -> Table:
    """By kind of fit and parameter: held, identified, width, and what was off without a word."""
    rows = []
    for loop, breakaway in FITS:
        kind = [
            a for a in answers
            if (a["loop"], a["breakaway"]) == (loop, breakaway) and "estimates" in a
        ]  # fmt: skip
        for name in FREE if kind else ():
            each = [a["estimates"][name] for a in kind]
            truth = TRUTH[name]
            held = [low <= truth <= high for _, low, high, _ in each]
            identified = [verdict == "identified" for *_, verdict in each]
            off = [abs(value / truth - 1.0) > 0.03 for value, *_ in each]  # noqa: PLR2004
            lies = sum(i and o and not h for i, o, h in zip(identified, off, held, strict=True))
            width = float(np.median([(high - low) / truth for _, low, high, _ in each]))
            rows.append([
                loop, breakaway, name, f"{sum(held)} of {len(held)}", str(sum(identified)),
                f"{100 * width:.1f}", str(lies),
            ])  # fmt: skip
    heads = ("loop", "fit", "", "held", "identified", "width / %", "identified, off, outside")
    return Table.of_texts("95 % intervals on the ramp up", heads, rows, (0, 1, 2))


def main() -> None:
    """Fit what is missing, or show what there is."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=100, help="logs of each kind (100)")
    parser.add_argument("--show", action="store_true", help="show the answers that there are")
    options = parser.parse_args()
    if not options.show:
        jobs = [(seed, *kind) for seed in range(options.seeds) for kind in FITS]
        completed(FILE, jobs, fitted, lambda a: (a["seed"], a["loop"], a["breakaway"]))
    print(table(lines(FILE)).text().rstrip())


if __name__ == "__main__":
    main()
