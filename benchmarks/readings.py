"""Which reading of the paper prints its Tables 4 and 5?

    python benchmarks/readings.py [--only ATS|ABFO|BTS|GA] [--engine processes:1]
    python benchmarks/readings.py --show | --page

Where section 2 of the paper (doi 10.1155/2012/238563) can be read in more than one way, every
combination of readings below is run on its five functions, TRIALS times each, with the settings of
its Tables 2 and 3. An interrupted run goes on where it was. Means over the trials stand in
readings.json, from which `--show` prints the tables and `--page` draws
docs/figures/study/readings.png. Nothing is fitted: the readings are ranked by how far they end
from the published means, and what chance would agree with stands beside.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import permutations, product
from pathlib import Path
from typing import Any

import numpy as np

from stribeck.bench.campaign import Campaign, Entry, campaign
from stribeck.bench.engines import engine
from stribeck.bench.paper_tables import ROUNDS, SOLUTIONS, SURFACES
from stribeck.bench.record import Record
from stribeck.bench.runner import conduct
from stribeck.bench.statistics import cells
from stribeck.bench.store import Store
from stribeck.bench.surfaces import surface
from stribeck.report.table import Table
from stribeck.space import Array

FILE, STORE = Path(__file__).with_name("readings.json"), Path(__file__).with_name("readings.db")
PICTURE = Path(__file__).parents[1] / "docs" / "figures" / "study" / "readings.png"
#: Trials of each cell; those of ABFO take long.
TRIALS = {"ATS": 6, "ABFO": 4, "BTS": 8, "GA": 12}
#: A mean agrees with the published one within this factor.
AGREE = 1.5
#: A gap to the minimum below this is rounding.
LEAST = 1e-16
#: Readings listed of each method.
LISTED = 5

#: What a reading changes: settings on all functions, or a word that `_on` makes settings of.
Settings = dict[str, Any]
Factor = dict[str, Settings]
DEADLOCK: Factor = {
    "backtrack": {}, "backtrack recent": {"recall": "recent"}, "restart": {"deadlock": "restart"},
}  # fmt: skip
MOVE: Factor = {"better": {}, "best": {"move": "best"}}
NEIGHBOURS: Factor = {"within R": {}, "at R": {"neighbours": "at"}}
RADIUS: Factor = {
    "R by best": {}, "R by current": {"radius_from": "current"},
    "R by deadlocks": {"AR_by": "deadlock"}, "R by best, one stage": {"stages": 1},
    "R by current, one stage": {"stages": 1, "radius_from": "current"},
}  # fmt: skip
SIGNALS: Factor = {"J_cc": {}, "no J_cc": {"d_attract": 0.0, "h_repellant": 0.0}}
STEP: Factor = {
    "C of J": {},
    "C of J - J_target": {"deviation": True},
    "C in widths": {"step": 1.0},
}
SWIM: Factor = {"until worse": {}, "N_s steps": {"swim": "always"}}
LIFE: Factor = {"all lives": {}, "one life": {"N_re": 1, "N_ed": 1}}
FORAGING: Factor = {"N_c 20": {}, "N_c of Table 3": {"N_c": "Table 3"}}
CROSSING: Factor = {c: {"crossing": c} for c in ("scattered", "intermediate", "heuristic")}
FIRST: Factor = {"in the range": {}, "in 0 to 1": {"first": "unit"}}
SHRINK: Factor = {"mutation shrinks": {}, "mutation stays": {"shrink": 0.0}}
LENGTH: Factor = {"100 generations": {}, "10,000 generations": {"generations": 10_000}}
POPULATION: Factor = {"20": {}, "100": {"population": 100}}
#: Our method behind each of the paper's, and the factors of its readings, the literal one first.
DESIGN: dict[str, tuple[str, tuple[Factor, ...]]] = {
    "ATS": ("ats", (DEADLOCK, MOVE, NEIGHBOURS, RADIUS)),
    "ABFO": ("abfo", (SIGNALS, STEP, SWIM, LIFE)),
    "BTS": ("bts", (DEADLOCK, MOVE, SIGNALS, STEP, FORAGING)),
    "GA": ("ga", (CROSSING, FIRST, SHRINK, LENGTH, POPULATION)),
}


# --- the campaign ---------------------------------------------------------------------------------


def readings(paper: str) -> Campaign:
    """The campaign of all readings of one of the paper's methods."""
    whole = campaign("paper")
    base = next(e for e in whole.entries if e.label == DESIGN[paper][0])
    tables = {e.label: e for e in whole.entries}
    entries = tuple(_read(base, words, tables["abfo"]) for words in _combinations(paper))
    return replace(
        whole, name=f"readings-{paper}", repeats=TRIALS[paper], entries=entries,
        reference=entries[0].label,
    )  # fmt: skip


def _combinations(paper: str) -> Iterator[dict[str, Settings]]:
    for words in product(*(factor.items() for factor in DESIGN[paper][1])):
        yield dict(words)


def _read(base: Entry, words: Mapping[str, Settings], abfo: Entry) -> Entry:
    settings: Settings = {}
    for part in words.values():
        settings |= part
    stages, deviation = settings.pop("stages", None), settings.pop("deviation", False)
    lives = settings.pop("N_c", None)
    on = {name: dict(base.on.get(name, {})) for name in SURFACES}
    for name, own in on.items():
        if stages is not None and "AR" in own:
            own["AR"] = own["AR"][:stages]
        if deviation:
            own["J_target"] = float(surface(name).minimum)
        if lives is not None:
            own["N_c"] = abfo.on[name]["N_c"]
        own |= {key: value for key, value in settings.items() if key in own}
    return replace(base, label=label(words), settings=base.settings | settings, on=on)


def label(words: Mapping[str, Any]) -> str:
    """The name of a reading: its words."""
    return " - ".join(words).replace(",", "")


def measured(paper: str, where: str) -> None:
    """Run what is left of a method's readings, and keep the means."""
    of_method = readings(paper)
    jobs = list(of_method.jobs())
    file = STORE.with_stem(f"{STORE.stem}-{paper}")
    with Store.open(file, campaign=of_method.name, seed=of_method.seed) as store:
        store.add(jobs)
        for k, _ in enumerate(conduct(store, engine(where))):
            if k % 200 == 0:
                print(f"{paper}: {store.left():,} runs left", flush=True)
        records = list(store.records())
    kept = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    kept[paper] = _means(records)
    kept = {of: kept[of] for of in DESIGN if of in kept}
    FILE.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


def _means(records: Sequence[Record]) -> dict[str, dict[str, list[float]]]:
    """Of each reading on each function: mean rounds, mean cost, share that reached, trials."""
    means: dict[str, dict[str, list[float]]] = {}
    for (name, reading), runs in cells(records).items():
        means.setdefault(reading, {})[name] = [
            float(np.mean([r.search_rounds for r in runs])),
            float(np.mean([r.cost for r in runs])),
            float(np.mean([r.reached for r in runs])),
            float(len(runs)),
        ]
    return means


# --- distances ------------------------------------------------------------------------------------


def published(paper: str) -> Array:
    """log10 of mean rounds, and of the mean gap to the minimum, (2, functions).

    ABFO's rounds are nan: the paper gives N_c there, a setting.
    """
    rounds = [np.nan] * len(SURFACES) if paper == "ABFO" else ROUNDS[paper]
    gaps = [_gap(n, SOLUTIONS[paper][n][0]) for n in SURFACES]
    return np.asarray(np.log10(np.array([rounds, gaps], dtype=float)))


def ours(means: Mapping[str, Sequence[float]]) -> Array:
    """The same of a reading."""
    rounds = [max(means[n][0], 0.5) for n in SURFACES]
    gaps = [_gap(n, means[n][1]) for n in SURFACES]
    return np.asarray(np.log10(np.array([rounds, gaps], dtype=float)))


def _gap(name: str, cost: float) -> float:
    """By how much a mean cost lies above the minimum, which Table 5 has to four decimals."""
    return max(cost - float(surface(name).minimum), LEAST)


def distance(off: Array) -> float:
    """The mean size of differences of logarithms, in powers of ten."""
    return float(np.nanmean(np.abs(off)))


def agreeing(off: Array) -> int:
    """How many cells agree within AGREE."""
    return int(np.count_nonzero(np.abs(off) <= np.log10(AGREE)))


def by_chance(paper: str, points: Sequence[Array]) -> list[int]:
    """The most cells in which a reading agrees, for each mix-up of the published functions.

    The published values are dealt out anew to the functions (all ways but the true one), rounds and
    solutions together: what then agrees does so by chance, with as many readings to choose from.
    """
    truth, counts = published(paper), []
    for order in permutations(range(len(SURFACES))):
        if list(order) != sorted(order):
            dealt = truth[:, list(order)]
            counts.append(max(agreeing(p - dealt) for p in points))
    return counts


# --- what is shown --------------------------------------------------------------------------------


def tables(kept: Mapping[str, Any]) -> Iterator[Table]:
    """A summary, and the best readings of each method."""
    rows = []
    for paper, means in kept.items():
        truth, points = published(paper), {n: ours(m) for n, m in means.items()}
        off = {n: distance(p - truth) for n, p in points.items()}
        best, literal = min(off, key=off.__getitem__), next(iter(_labels(paper)))
        most = max(agreeing(p - truth) for p in points.values())
        chance = by_chance(paper, list(points.values()))
        total = int(np.isfinite(truth).sum())
        rows.append([
            paper, str(len(means)), f"{off[literal]:.2f}", f"{agreeing(points[literal] - truth)}",
            f"{off[best]:.2f}", f"{agreeing(points[best] - truth)}", f"{most} of {total}",
            f"{np.median(chance):.0f}", f"{np.mean(np.array(chance) >= most):.0%}",
        ])  # fmt: skip
    yield Table.of_texts(
        "Readings beside Tables 4 and 5: distance in powers of ten, cells within a factor of 1.5",
        ["method", "readings", "literal", "cells", "nearest", "cells", "most cells", "by chance",
         "as many"],
        rows,
    )  # fmt: skip
    for paper, means in kept.items():
        truth = published(paper)
        order = sorted(means, key=lambda n: distance(ours(means[n]) - truth))
        rows = [
            [
                n, f"{distance(ours(means[n])[0] - truth[0]):.2f}" if paper != "ABFO" else "–",
                f"{distance(ours(means[n])[1] - truth[1]):.2f}",
                str(agreeing(ours(means[n]) - truth)),
                f"{np.mean([means[n][s][2] for s in SURFACES]):.0%}",
            ]
            for n in order[:LISTED]
        ]  # fmt: skip
        yield Table.of_texts(
            f"{paper}: the nearest of {len(means)} readings",
            ["reading", "rounds", "solutions", "cells", "reached J_min"], rows,
        )  # fmt: skip


def _labels(paper: str) -> Iterator[str]:
    return (label(words) for words in _combinations(paper))


def draw(kept: Mapping[str, Any]) -> None:
    """Rounds of every reading beside those published, a panel a method."""
    import matplotlib as mpl  # noqa: PLC0415 - the study needs no picture
    from matplotlib.figure import Figure  # noqa: PLC0415
    from matplotlib.lines import Line2D  # noqa: PLC0415

    from stribeck.report.figures.style import STYLE  # noqa: PLC0415

    shown = [paper for paper in DESIGN if paper in kept and paper != "ABFO"]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3.3 * len(shown), 3.7), layout="constrained")
        for ax, paper in zip(figure.subplots(1, len(shown), sharey=True), shown, strict=True):
            places = np.argsort(np.argsort(ROUNDS[paper]))
            for name, means in kept[paper].items():
                anew = "restart" in name
                ax.semilogy(
                    places + (0.12 if anew else -0.12), [means[n][0] for n in SURFACES], "o",
                    ms=4, alpha=0.35, mew=0, color="#c8553d" if anew else "#2a6f97",
                )  # fmt: skip
            ax.semilogy(places, ROUNDS[paper], "_", ms=22, mew=2, color="#1d2b36")
            ax.set_xticks(places, SURFACES)
            ax.set(title=paper)
            ax.set_xlim(-0.6, len(SURFACES) - 0.4)
        figure.axes[0].set_ylabel("rounds of search")
        handles = [
            Line2D([], [], marker="_", ms=14, mew=2, ls="", color="#1d2b36"),
            Line2D([], [], marker="o", ms=5, ls="", color="#2a6f97"),
            Line2D([], [], marker="o", ms=5, ls="", color="#c8553d"),
        ]
        words = ["published", "a reading", "a reading that begins anew on a deadlock"]
        figure.legend(handles, words, loc="outside lower center", ncols=3, frameon=False)
        figure.savefig(PICTURE, dpi=160, metadata={"Software": None})


def main() -> None:
    """Run, show or draw the readings."""
    ask = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    ask.add_argument("--only", choices=DESIGN, action="append", metavar="METHOD")
    ask.add_argument("--engine", default="processes", help="here or processes[:N]")
    ask.add_argument("--show", action="store_true", help="print the tables")
    ask.add_argument("--page", action="store_true", help="draw the picture")
    options = ask.parse_args()
    if options.show or options.page:
        kept = json.loads(FILE.read_text(encoding="utf-8"))
        if options.page:
            draw(kept)
        if options.show:
            print("\n".join(t.text() for t in tables(kept)))
        return
    for paper in options.only or DESIGN:
        measured(paper, options.engine)


if __name__ == "__main__":
    main()
