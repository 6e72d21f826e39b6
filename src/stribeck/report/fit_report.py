"""A fit on the terminal: its parameters, its misfit, how the axis stuck and slipped, each log."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..identify.uncertainty.verdict import verdict_text
from ..rig.rig import shown_difference, shown_in
from ..units import unit
from .format import DASH, number
from .misfit import SEVERAL, balance_figures, log_errors, misfit_head, score_texts
from .table import Table
from .terminal import console, show_paragraph, show_table, show_warnings

if TYPE_CHECKING:
    from ..identify.combinations import Combination
    from ..identify.result import Fit
    from ..identify.uncertainty.posterior import Posterior

#: How many logs are listed one by one at most.
LISTED = 20


def _parameters(fit: Fit) -> Table:
    """Each parameter with its interval and verdict; published errors where there are some."""
    rows = []
    for q, e in zip(fit.parameters.every, fit.estimates, strict=True):
        if e.verdict == "fixed" and q.fixed == e.value:
            continue

        def shown(x: float, convert: Any = shown_in, q: Any = q) -> float:
            return float(convert(fit.rig, q, x))

        free = e.verdict != "fixed"
        rows.append([
            e.name, number(shown(e.value)), e.unit,
            _end(shown(e.low), e.low_ended) if free else DASH,
            _end(shown(e.high), e.high_ended) if free else DASH,
            *([number(shown(e.standard_error, shown_difference), 3)] if fit.balance else []),
            verdict_text(e.verdict, e.reason, borderline=e.borderline),
        ])  # fmt: skip
    rows += [_sum(fit, c) for c in fit.combinations]
    rows += [
        [
            r.name, number(r.value), r.unit, number(r.low, 4), number(r.high, 4),
            *([DASH] if fit.balance else []),
            verdict_text(r.verdict, r.reason),
        ]
        for r in fit.ratios
    ]  # fmt: skip
    errors = ["std. error"] if fit.balance else []
    heads = ["parameter", "value", "unit", "95 % from", "to", *errors, "verdict"]
    labels = (0, 2, len(heads) - 1)
    return Table.of_texts(f"{fit.law.name} on {fit.rig.name}", heads, rows, labels)


def _sum(fit: Fit, c: Combination) -> list[str]:
    (q,) = [q for q in fit.parameters.every if q.name == c.parameter]
    value, low, high = (number(float(shown_in(fit.rig, q, x)), 4) for x in (c.value, c.low, c.high))
    return [
        f"{fit.rig.label(q.name)} + {c.constant}",
        value,
        c.unit,
        low,
        high,
        verdict_text(c.verdict, c.reason),
    ]


def _breakaways(fit: Fit) -> list[str]:
    """Mean and spread of each breakaway level that varies from slip to slip, a sentence each."""
    sentences = []
    levels = {e.name: (q, e) for q, e in zip(fit.parameters.every, fit.estimates, strict=True)}
    for b in fit.breakaway:
        q, e = levels[fit.rig.label(b.parameter)]
        mean = [number(float(shown_in(fit.rig, q, x)), 4) for x in (b.mean, e.low, e.high)]
        sd = [number(float(shown_difference(fit.rig, q, x)), 2) for x in (b.sd, b.low, b.high)]
        interval = "" if e.verdict == "fixed" else f" ({mean[1]} to {mean[2]})"
        sentences.append(
            f"{e.name} = {mean[0]}{interval} {e.unit}, from slip to slip "
            f"sd {sd[0]} ({sd[1]} to {sd[2]}), {b.slips} slips"
        )
    return sentences


def _end(value: float, ended: str | None) -> str:
    """An end of an interval, and what stopped it if it was not the data."""
    words = {"bound": "range", "flat": "range", "budget": "guessed", "unrunnable": "fails"}
    reason = words.get(ended or "threshold", ended)
    return number(value, 4) if ended in (None, "threshold") else f"{number(value, 4)} ({reason})"


def show_fit(fit: Fit) -> None:
    """Print parameters, the misfit beside its baselines, what was held out, warnings and notes."""
    out = console()
    show_table(_parameters(fit))
    for e in fit.estimates:
        if e.verdict in ("weak", "not identifiable") and e.meaning:
            meaning = re.sub("^(Doubling|Halving)", lambda first: first[0].lower(), e.meaning)
            judged = verdict_text(e.verdict, e.reason, borderline=e.borderline)
            show_paragraph(f"{e.name} is {judged}: {meaning}", "  ")
    for sentence in _breakaways(fit):
        show_paragraph(sentence, "  ")
    for table in (_scores(fit), _staircases(fit), _logs(fit)):
        if table is not None:
            out.print()
            show_table(table)
    if fit.balance is not None:
        rows = balance_figures(fit.balance.figures(), fit.rig.si_unit("force"))
        out.print()
        show_table(Table.of_texts("", ["force balance", ""], rows))
    else:
        search, repeats = fit.search, len(fit.search.runs)
        out.print(
            f"\n{search.method}, seed {search.seed}: {search.evaluations:,} evaluations in "
            f"{repeats} repeat{'s' * (repeats > 1)}, {search.seconds:.1f} s, ended: {search.ended}"
        )
    if fit.posterior is not None:
        out.print()
        show_table(_posterior(fit, fit.posterior))
    show_warnings(fit.warnings, fit.notes)


def _posterior(fit: Fit, drawn: Posterior) -> Table:
    """Medians and central intervals of the posterior's samples."""
    rows = []
    for q in fit.parameters.free:
        i = drawn.names.index(q.name)
        ends = (drawn.median[i], drawn.low[i], drawn.high[i])
        cells = [number(float(shown_in(fit.rig, q, x)), 4) for x in ends]
        rows.append([fit.rig.label(q.name), cells[0], fit.rig.unit_of(q), *cells[1:]])
    title = f"posterior, {len(drawn.samples):,} samples"
    heads = ["parameter", "median", "unit", "95 % from", "to"]
    return Table.of_texts(title, heads, rows, (0, 2))


def _scores(fit: Fit) -> Table:
    s = fit.score
    trained = ", ".join(r.text for r in fit.train_ranges) or "all"
    rows = [[f"training {trained}", *score_texts(s)]]
    rows += [[f"held out {_within(h)}", *score_texts(h.score)] for h in fit.holdout]
    heads = [misfit_head(s), "model", "smooth, no stick-slip", "never moves", "samples"]
    if not math.isfinite(s.smooth):
        rows = [[row[0], row[1], row[-1]] for row in rows]
        heads = [heads[0], heads[1], heads[-1]]
    return Table.of_texts("", heads, rows)


def _staircases(fit: Fit) -> Table | None:
    """How often and how far the axis slipped, and how the model did."""
    rows = []
    every = [("training", fit.score), *((f"held out {_within(h)}", h.score) for h in fit.holdout)]
    shown = fit.rig.unit_shown("position")
    for name, score in every:
        for mover, s in (("axis", score.measured), ("model", score.modelled)):
            if s is not None:
                jump = float(unit(shown).from_si(s.jump))
                rows.append([f"{name}, {mover}", str(s.slips), number(jump, 3), f"{s.stuck:.0%}"])
    heads = ["stick-slip", "slips", f"median jump / {shown}", "time at rest"]
    return Table.of_texts("", heads, rows) if rows else None


def _within(held: Any) -> str:
    return held.within.text if held.within else "all"


def _logs(fit: Fit) -> Table | None:
    """The error on each log, where there are several; the greatest of very many."""
    if len(fit.recordings) < SEVERAL:
        return None
    rows = log_errors(fit)
    validated = any(math.isfinite(error) for _, _, errors in rows for error in errors[1:])
    order = sorted(range(len(rows)), key=lambda k: np.nan_to_num(-_worst(rows[k][2])))[:LISTED]
    which = "each log" if len(rows) <= LISTED else f"the {LISTED} worst of {len(rows)} logs"
    heads = [f"{which}, {misfit_head(fit.score)}", "training", "samples", "held out"]
    cells = [
        [log, number(errors[0], 4), f"{samples:,}", number(_worst(errors[1:]), 4)][: 3 + validated]
        for log, samples, errors in (rows[k] for k in sorted(order))
    ]
    return Table.of_texts("", heads[: 3 + validated], cells)


def _worst(errors: Sequence[float]) -> float:
    return max((e for e in errors if math.isfinite(e)), default=math.nan)
