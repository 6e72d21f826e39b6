"""Tables 4 and 5 of the paper, and the percentages of its section 3, beside our own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..report import DASH, Cell, Table
from ..space import Array
from .record import Record
from .statistics import cells

#: The campaign these tables are of.
NAME = "paper"
#: The paper's methods and, for each, which of ours stands beside it: the literal reading first.
OURS: dict[str, tuple[str, ...]] = {
    "ATS": ("ats", "ats-restart"),
    "ABFO": ("abfo", "abfo-deviation"),
    "BTS": ("bts", "bts-restart"),
    "GA": ("ga",),
}
#: Methods of our own campaign that the paper does not have.
BESIDES = ("ts", "bfo", "random")
SURFACES = ("BF", "RF", "SF", "SchF", "ShuF")

#: Table 4, average search time in seconds (Pentium IV, 2.4 GHz), in the order of SURFACES.
SECONDS = {
    "ATS": (11.66, 14.60, 4.18, 408.58, 3.28),
    "ABFO": (5.75, 48.63, 146.67, 728.87, 182.83),
    "BTS": (6.83, 5.81, 3.69, 172.52, 2.80),
    "GA": (49.12, 11.78, 8.53, 868.32, 3.39),
}
#: Table 4, average search rounds. ABFO's are N_c, by construction.
ROUNDS = {
    "ATS": (616.48, 868.28, 139.36, 6889.42, 68.06),
    "ABFO": (20, 200, 500, 2000, 1000),
    "BTS": (151.20, 323.30, 25.70, 1469.14, 55.28),
    "GA": (1177.18, 225.54, 141.28, 354.44, 34.24),
}
#: Table 5, final costs over 50 trials: average, min, max, standard deviation.
SOLUTIONS: dict[str, dict[str, tuple[float, float, float, float]]] = {
    "ATS": {
        "BF": (4.5090e-10, 7.3184e-11, 9.4151e-10, 2.7476e-10),
        "RF": (5.3478e-09, 2.9051e-10, 9.3771e-09, 2.4328e-09),
        "SF": (0.9982, 0.9980, 0.9989, 0.0002),
        "SchF": (0.0456, 0.0006, 0.0998, 0.0278),
        "ShuF": (-186.7305, -186.7309, -186.7300, 0.0003),
    },
    "ABFO": {
        "BF": (1.0833e-10, 2.2204e-16, 8.8759e-10, 2.0742e-10),
        "RF": (1.1534e-10, 3.5527e-15, 6.7094e-10, 1.4942e-10),
        "SF": (0.9981, 0.9980, 0.9988, 0.0002),
        "SchF": (0.0139, 2.5455e-05, 0.0768, 0.0240),
        "ShuF": (-186.7305, -186.7309, -186.7300, 0.0003),
    },
    "BTS": {
        "BF": (5.30112e-10, 3.569e-12, 9.97229e-10, 3.13515e-10),
        "RF": (5.2460e-09, 5.9587e-10, 9.6620e-09, 2.6721e-09),
        "SF": (0.9983, 0.9980, 0.9990, 0.0003),
        "SchF": (0.0273, 0.0002, 0.0944, 0.0341),
        "ShuF": (-186.7305, -186.7309, -186.7301, 0.0003),
    },
    "GA": {
        "BF": (6.0074e-08, 1.1830e-11, 2.9855e-06, 4.2216e-07),
        "RF": (4.9642e-09, 1.1486e-10, 9.5235e-09, 2.6740e-09),
        "SF": (0.9983, 0.9980, 0.9990, 0.0003),
        "SchF": (0.0439, 0.0008, 0.0982, 0.0281),
        "ShuF": (-186.7304, -186.7309, -186.7300, 0.0002),
    },
}


@dataclass(frozen=True)
class Percentage:
    """A percentage of section 3: how much less of something BTS needs than another method.

    Args:
        what: Of what.
        than: The other method.
        printed: As printed.
        table: The published means it comes from; None where the paper shows no table.
        quantity: The same of one of our records.
    """

    what: str
    than: str
    printed: float
    table: Mapping[str, tuple[float, ...]] | None
    quantity: Callable[[Record], float]

    def published(self) -> float:
        """Recomputed from the published table: the plain mean of the five reductions, in %."""
        if self.table is None:
            return float("nan")
        return reduction(np.array(self.table["BTS"]), np.array(self.table[self.than]))

    def measured(self, records: Sequence[Record], bts: str, other: str) -> float:
        """The same from our means, in %; nan where runs are missing."""
        runs = cells(records)
        if any(not runs.get((s, m)) for s in SURFACES for m in (bts, other)):
            return float("nan")
        ours, theirs = (
            np.array([np.mean([self.quantity(r) for r in runs[s, m]]) for s in SURFACES])
            for m in (bts, other)
        )
        return reduction(ours, theirs)


PERCENTAGES = (
    Percentage("search rounds", "ATS", 63.45, ROUNDS, lambda r: r.search_rounds),
    Percentage("search time", "ATS", 37.15, SECONDS, lambda r: r.seconds),
    Percentage("search time", "ABFO", 68.31, SECONDS, lambda r: r.seconds),
    Percentage("search time", "GA", 58.21, SECONDS, lambda r: r.seconds),
    Percentage("entrapments", "ATS", 73.43, None, lambda r: r.entrapments or 0),
    # Not in the paper, which counts rounds of unequal size: what a user pays.
    Percentage("evaluations", "ATS", float("nan"), None, lambda r: r.evaluations),
    Percentage("evaluations", "ABFO", float("nan"), None, lambda r: r.evaluations),
    Percentage("evaluations", "GA", float("nan"), None, lambda r: r.evaluations),
)


def reduction(ours: Array, theirs: Array) -> float:
    """How much less, in %: the plain mean over the problems, as in section 3.

    A problem on which neither needs any is left out.
    """
    some = theirs > 0
    return float(100 * np.mean(1 - ours[some] / theirs[some])) if some.any() else float("nan")


def table_4(records: Sequence[Record]) -> Table:
    """Time and rounds as the paper has them, and what it left out."""
    rows = []
    for surface, algorithm, paper, runs in _rows(records):
        k = SURFACES.index(surface)
        seconds = SECONDS[paper][k] if paper else None
        rounds = ROUNDS[paper][k] if paper else None
        rows.append([
            Cell.label(surface),
            Cell.label(algorithm),
            _printed(seconds),
            Cell.number(_mean(runs, lambda r: r.seconds), 3),
            _printed(rounds),
            Cell.number(_mean(runs, lambda r: r.search_rounds)),
            Cell.number(_mean(runs, lambda r: r.evaluations)),
            Cell(f"{sum(r.reached for r in runs)}/{len(runs)}", sum(r.reached for r in runs)),
            Cell(DASH) if runs[0].entrapments is None
            else Cell.number(_mean(runs, _entrapments), 3),
        ])  # fmt: skip
    return Table(
        "Table 4: means over the trials, published and ours",
        ("function", "method", "time/s published", "ours", "rounds published", "ours",
         "evaluations", "reached J_min", "entrapments"),
        tuple(map(tuple, rows)),
        "Published times are of a Pentium IV at 2.4 GHz: only ratios compare. Rounds are those of "
        "tabu search for ats and bts, generations for ga; for abfo the paper gives N_c, the "
        "length of one lifetime, and we count the chemotactic steps of all lifetimes. "
        "Entrapments are deadlocks of tabu search: returns to the tabu list or restarts. Ours are "
        "means over all trials; one that failed counts with what it spent until its budget, "
        "count_max or the end of its life.",
    )  # fmt: skip


def table_5(records: Sequence[Record]) -> Table:
    """Final costs: average, min, max and standard deviation, published above ours."""
    rows = []
    for surface, algorithm, paper, runs in _rows(records):
        costs = np.array([r.cost for r in runs])
        if paper and algorithm == OURS[paper][0]:
            names = (surface, f"{paper} (published)")
            printed = map(_printed, SOLUTIONS[paper][surface])
            rows.append([*(Cell.label(n) for n in names), *printed])
        spread = float(costs.std(ddof=1)) if len(costs) > 1 else float("nan")
        ours = (float(costs.mean()), float(costs.min()), float(costs.max()), spread)
        rows.append(_solution(surface, algorithm, ours))
    return Table(
        "Table 5: solutions, published and ours",
        ("function", "method", "average", "min", "max", "std."),
        tuple(map(tuple, rows)),
        "All trials, those that never reached J_min among them. A trial ends at J_min: how far "
        "below it a success came to lie says little of accuracy.",
    )


def percentages(records: Sequence[Record]) -> Table:
    """The percentages of section 3: printed, recomputed from Table 4, and ours."""
    rows = []
    for p in PERCENTAGES:
        other = OURS[p.than][0]
        literal = p.measured(records, "bts", other)
        restart = p.measured(records, "bts-restart", OURS[p.than][-1] if p.than == "ATS" else other)
        rows.append([
            Cell(f"{p.what}, BTS less than {p.than}", p.what),
            _printed(p.printed),
            *(Cell.number(v) for v in (p.published(), literal, restart)),
        ])  # fmt: skip
    return Table(
        "Section 3: how much less BTS needs, % (plain mean over the five functions)",
        ("of what", "printed", "from the published table", "ours, literal", "ours, restart"),
        tuple(map(tuple, rows)),
        "The paper shows no table of entrapments, and counts no evaluations. Ours are of means "
        "over all trials: one that failed counts with what it spent until its budget or count_max, "
        "so that where successes are few the percentage hangs on these limits. Under restart, abfo "
        "and ga are the same as under literal. Seconds are wall-clock times.",
    )


def _rows(records: Sequence[Record]) -> list[tuple[str, str, str | None, list[Record]]]:
    """(surface, method, the paper's method, its runs) of every cell, in the paper's order."""
    order: list[tuple[str, str | None]] = [(m, p) for p, ours in OURS.items() for m in ours]
    order += [(m, None) for m in BESIDES]
    runs = cells(records)
    return [
        (surface, algorithm, paper, runs[surface, algorithm])
        for surface in SURFACES
        for algorithm, paper in order
        if runs.get((surface, algorithm))
    ]


def _solution(surface: str, method: str, values: Sequence[float]) -> list[Cell]:
    digits = 7 if surface == "ShuF" else 5
    return [Cell.label(surface), Cell.label(method), *(Cell.number(v, digits) for v in values)]


def _entrapments(run: Record) -> float:
    return run.entrapments or 0


def _mean(runs: Sequence[Record], quantity: Callable[[Record], float]) -> float:
    return float(np.mean([quantity(r) for r in runs]))


def _printed(value: float | None) -> Cell:
    """A published number, with the digits it was published with."""
    if value is None or np.isnan(value):
        return Cell(DASH, None)
    return Cell(f"{value:,}".replace("e-0", "e-"), value)
