"""The tables of a fit's page: cells as a reader sees them."""

from __future__ import annotations

import re

import numpy as np

from ...identify.card import Card, HoldoutCard, ObjectiveCard, ParameterCard
from ...identify.uncertainty.sensitivity import ENDS
from ...units import percent, unit
from ..contents.schema import LogRecord, Report
from ..figures.motion_plots import APART, part_name
from ..format import DASH, number, unit_label, with_error
from ..misfit import balance_figures, misfit_name
from ..table import Table

#: Slips listed of a log, and logs listed by their errors.
LISTED = 200
#: A parameter ended elsewhere than its search if it moved by more than this share of it.
MOVED = 0.01
#: A chance below this is told as being so.
LEAST = 1e-6
#: What a meaning says of the ends of an interval has a column of its own.
_ENDED = re.compile(
    r"; (both ends of its interval are|the lower end of its interval is) set by[^;]*"
)


#: What a sum and a ratio are, for people.
_TOGETHER = {
    "+": "a parameter and a constant of the rig together",
    "/": "a ratio, which an error common to all forces leaves as it is",
}


def parameters(card: Card) -> Table:
    """Value, interval, why it ends, verdict and meaning of each parameter."""
    errors = any(p.standard_error is not None for p in card.parameters.values())
    errors = errors and bool(card.balance)
    heads = ["parameter", "value", "unit", "95 % from", "to", "ended by"]
    heads += ["std. error"] * errors + ["verdict", "what the data say"]
    rows = []
    for name, p in card.parameters.items():
        free = p.verdict != "fixed"
        rows.append([
            name, number(p.value), unit_label(p.unit),
            _known(p.low) if free else DASH, _known(p.high) if free else DASH, _ended(p),
            *([_known(p.standard_error, 3)] if errors else []),
            p.verdict_text,
            _ENDED.sub("", p.meaning) + _bound(p),
        ])  # fmt: skip
    rows += [
        [name, number(c.value), unit_label(c.unit), _known(c.low), _known(c.high), DASH,
         *([DASH] if errors else []), c.verdict_text,
         _TOGETHER["/" if " / " in name else "+"]]
        for name, c in card.combinations.items()
    ]  # fmt: skip
    last = len(heads) - 1
    return Table.of_texts("Parameters", heads, rows, (0, 2, 5, last - 1, last), sentences=(5, last))


def breakaway(card: Card) -> Table | None:
    """Mean and spread of each breakaway level that varies from slip to slip."""
    rows = []
    for name, b in card.breakaway.items():
        mean = card.parameters[name]
        rows.append([
            name, unit_label(b.unit), number(mean.value), _known(mean.low), _known(mean.high),
            number(b.sd, 3), number(b.low, 3), number(b.high, 3), str(b.slips),
        ])  # fmt: skip
    heads = ["breakaway", "unit", "mean", "95 % from", "to", "sd of slips", "95 % from", "to"]
    return (
        Table.of_texts("Breakaway from slip to slip", [*heads, "slips"], rows, (0, 1))
        if rows
        else None
    )


def between_logs(card: Card) -> Table | None:
    """Mean and spread of the parameters over several logs."""
    rows = []
    for name, b in card.between_logs.items():
        rows.append([
            name, unit_label(b.unit), number(b.mean), number(b.low, 4), number(b.high, 4),
            number(b.sd, 3), number(b.sd_low, 3), number(b.sd_high, 3), str(b.logs),
            "under 1e-6" if b.chance < LEAST else f"{b.chance:.1g}",
            "differs" if b.differs else DASH,
        ])  # fmt: skip
    heads = ["parameter", "unit", "mean of logs", "95 % from", "to", "sd of logs", "95 % from",
             "to", "logs", "chance", "certainly"]  # fmt: skip
    title = "From log to log"
    return Table.of_texts(title, heads, rows, (0, 1, len(heads) - 1)) if rows else None


def single_logs(report: Report) -> Table | None:
    """The parameters of each log by itself; the first of very many."""
    if not report.single_logs:
        return None
    names = list(report.single_logs[0].values)
    units = {n: unit_label(b.unit) for n, b in report.card.between_logs.items()}
    rows = [
        [r.log, *(DASH if (v := r.values.get(n)) is None else with_error(*v) for n in names)]
        for r in report.single_logs[:LISTED]
    ]  # fmt: skip
    heads = ["log by itself", *(f"{n} / {units[n]}" if units.get(n) else n for n in names)]
    return Table.of_texts("Each log by itself, with standard errors", heads, rows)


def constants(card: Card) -> Table | None:
    """The constants of the rig that the fit rests on, as it has them, and who vouches for each."""
    cards = card.constants
    if not cards:
        return None
    rows = []
    for name, c in cards.items():
        value, origin = number(c.value), str(c.origin)
        tolerance = number(c.tolerance, 2) if c.tolerance > 0 else DASH
        if ends := card.stated.get(name):
            value, origin = " to ".join(dict.fromkeys(map(number, ends))), "the logs"
            tolerance = DASH
        rows.append([name, value, tolerance, unit_label(c.unit), origin])
    heads = ["constant", "value", "±", "unit", "source"]
    return Table.of_texts("Constants of the rig", heads, rows, (0, 3, 4))


def _known(value: float | None, digits: int = 4) -> str:
    return number(np.nan if value is None else value, digits)


def _ended(p: ParameterCard) -> str:
    """Why each side of the interval ended."""
    if p.verdict == "fixed" or p.low_ended is None or p.high_ended is None:
        return DASH
    low, high = ENDS[p.low_ended], ENDS[p.high_ended]
    return low if low == high else f"below: {low}; above: {high}"


def _bound(p: ParameterCard) -> str:
    return f"; at the {p.at_bound} end of its search range" if p.at_bound else ""


def sampled(card: Card) -> Table | None:
    """The posterior's intervals beside those of the profiles."""
    drawn = card.posterior
    if drawn is None:
        return None
    cards = card.parameters
    rows = [
        [n, number(s.median, 4), unit_label(cards[n].unit), _known(cards[n].low),
         _known(cards[n].high), number(s.low, 4), number(s.high, 4)]
        for n, s in drawn.parameters.items()
        if n in cards
    ]  # fmt: skip
    settled = "" if drawn.settled else " The walkers have not settled: ask for more samples."
    return Table.of_texts(
        "Posterior",
        ["parameter", "median", "unit", "profile from", "to", "posterior from", "to"],
        rows,
        (0, 2),
        note=f"{drawn.samples:,} samples; {drawn.accepted:.0%} of the steps were taken.{settled}",
    )


def resampled(report: Report) -> Table | None:
    """The bootstrap's intervals beside those of the profiles."""
    draws = report.draws
    known = {n: p for n, p in report.card.parameters.items() if p.resampled}
    if draws is None or not known:
        return None
    rows = [
        [n, number(p.value), unit_label(p.unit), _known(p.low), _known(p.high),
         *(number(end, 4) for end in p.resampled or ())]
        for n, p in known.items()
    ]  # fmt: skip
    failed = f", of which {draws.failed} could not be fitted" if draws.failed else ""
    return Table.of_texts(
        "Bootstrap intervals",
        ["parameter", "value", "unit", "profile from", "to", "bootstrap from", "to"],
        rows,
        (0, 2),
        note=f"{draws.drawn} data sets with residuals drawn in blocks of {draws.block} rows"
        f"{failed}.",
    )


def misfit(card: Card) -> str:
    """What the misfit is called."""
    return misfit_name(card.objective.name, "relative error of the force")


def scored(card: Card) -> list[tuple[str, ObjectiveCard | HoldoutCard]]:
    """The scores of the training data and of each range held out, with their names."""
    return [
        (", ".join(["training", *card.train]), card.objective),
        *((f"held out, {h.range}", h) for h in card.holdout),
    ]


def beside(card: Card) -> str:
    """What the table of misfits is called: a force balance has no baselines."""
    return "Baselines" if any(s.baselines for _, s in scored(card)) else "Misfit"


def explained(card: Card) -> str:
    """What the misfit is, for who has not met it."""
    how = (
        ", each slip simulated from the rest before it"
        if card.objective.restart or card.objective.breakaway == "scattered"
        else ", the whole motion simulated from its start"
    )
    best = "0 were a perfect fit, and the noise of the sensor is the best to hope for"
    if card.objective.name == "position_rmse":
        return f"J is the root mean square of measured less modelled positions{how}: {best}."
    if card.objective.name == "position_mae":
        return f"The error is the mean size of measured less modelled positions{how}: {best}."
    return (
        "The relative error is that of the force: the size of measured less modelled forces as a "
        "share of that of the measured ones, over the samples that count."
    )


def baselines(card: Card) -> Table:
    """The misfits beside what could be had without a model, and what is tested."""
    scores = scored(card)
    unit_shown = unit_label(card.objective.unit)
    heads = [f"{misfit(card)} / {unit_shown}", "model"]
    names = {"smooth": "best smooth motion, no stick-slip", "still": "an axis that never moves"}
    present = {k: name for k, name in names.items() if any(k in s.baselines for _, s in scores)}
    told = any(h.tests for h in card.holdout)
    rows = [
        [
            name,
            number(s.value, 4),
            *(_known(s.baselines.get(k)) for k in present),
            f"{s.samples:,}",
            *([getattr(s, "tests", "") or DASH] * told),
        ]
        for name, s in scores
    ]
    title = "Misfit of the model and of none" if present else "Misfit of the model"
    heads += [*present.values(), "samples", *["what it tests"] * told]
    last = len(heads) - 1
    return Table.of_texts(
        title, heads, rows, (0, last) if told else (0,), sentences=(last,) if told else ()
    )


def staircases(card: Card) -> Table | None:
    """How often and how far the axis slipped, and how the model did."""
    shown = card.objective.unit
    rows = []
    for name, score in scored(card):
        for s, mover in (
            (score.staircase.get("measured"), "axis"),
            (score.staircase.get("modelled"), "model"),
        ):
            if s is not None:
                jump = float(unit(shown).from_si(s.jump))
                rows.append([f"{name}: {mover}", str(s.slips), number(jump, 3), f"{s.stuck:.0%}"])
    heads = ["stick-slip", "slips", f"median jump / {unit_label(shown)}", "time at rest"]
    return Table.of_texts("Stick-slip of axis and model", heads, rows) if rows else None


def balance(report: Report) -> Table | None:
    """The figures of a force balance."""
    figures = report.card.balance
    rows = balance_figures(figures, report.units.force)
    note = (
        "Condition and collinearity say how far the columns of the balance are from independent, "
        "as they are and scaled to one length: 1 is best, and beyond a collinearity of 30 some "
        "parameter stands in for another."
    ) * ("collinearity" in figures)
    return Table.of_texts("Force balance", ["figure", "value"], rows, note=note) if rows else None


def errors(report: Report) -> Table | None:
    """The misfit on each log, where there are several; the greatest of very many."""
    if not report.errors:
        return None
    names = [name for name, _ in scored(report.card)]
    width = max(len(e.errors) for e in report.errors)
    heads = [
        f"{misfit(report.card)} / {unit_label(report.card.objective.unit)}",
        "samples trained on",
    ]
    every = sorted(
        report.errors, key=lambda e: -max((x for x in e.errors if x is not None), default=0.0)
    )
    kept = every[:LISTED]
    rows = [
        [e.log, f"{e.samples:,}", *(_known(x) for x in e.errors)]
        for e in report.errors
        if e in kept
    ]
    title = "Each log" if len(kept) == len(every) else f"The {LISTED} worst of {len(every)} logs"
    return Table.of_texts(title, [*heads, *names[:width]], rows)


def effects(report: Report) -> Table | None:
    """What the residual shows of what the model leaves out."""
    if not report.effects:
        return None
    rows = [
        [e.text, percent(e.share), number(e.size, 3),
         "under 1e-6" if e.probability < LEAST else f"{e.probability:.1g}", e.moves or DASH]
        for e in report.effects
    ]  # fmt: skip
    heads = [
        "the residual",
        "of its variance",
        f"RMS / {report.units.force}",
        "chance",
        "would move",
    ]
    return Table.of_texts(
        "Effects that chance does not explain", heads, rows, (0, 4), sentences=(0, 4)
    )


def repeats(report: Report) -> Table | None:
    """What each of several searches came to."""
    if len(report.runs) <= 1:
        return None
    names = list(report.runs[0].parameters)
    units = {n: unit_label(p.unit) for n, p in report.card.parameters.items()}
    shown = unit_label(report.card.objective.unit)
    heads = ["repeat", f"misfit / {shown}", "evaluations", "ended by"]
    heads += [f"{n} / {units[n]}" if units.get(n) else n for n in names]
    rows = [
        [str(k), _known(r.cost), f"{r.evaluations + r.polishing:,}", r.ended.replace("_", " "),
         *(number(r.parameters.get(n, np.nan), 4) for n in names)]
        for k, r in enumerate(report.runs, 1)
    ]  # fmt: skip
    best, cards = report.runs[0].parameters, report.card.parameters
    moved = any(abs(best[n] - cards[n].value) > MOVED * abs(best[n]) for n in names if n in cards)
    note = (
        "The parameters above are where a descent from the best repeat ended, with wider ranges "
        "where it sat at the end of a default one, and with constants that have tolerances."
    ) * moved
    return Table.of_texts("Repeats of the search, the best first", heads, rows, (0, 3), note=note)


def qualities(report: Report) -> Table | None:
    """What is in each log, in short, where there are many."""
    if len(report.logs) <= APART:
        return None
    kept = ("samples", "position noise", "strokes", "stuck", "slips")
    rows = []
    for log in report.logs:
        lines = dict(log.lines)
        rows.append([log.label, *(lines.get(name, DASH) for name in kept)])
    return Table.of_texts("Logs as measured", ["log", *kept], rows, range(1 + len(kept)))


def slips(report: Report, log: LogRecord) -> Table | None:
    """The slips of a log: what hovering over them says."""
    if not log.slips:
        return None
    length, speed = report.units.position, report.units.velocity
    rows = [
        [str(k), number(s.start, 6), number(s.jump, 4), number(s.stop - s.start, 3),
         number(s.speed, 3)]
        for k, s in enumerate(log.slips[:LISTED], 1)
    ]  # fmt: skip
    more = f" (the first {LISTED} of {len(log.slips)})" if len(log.slips) > LISTED else ""
    heads = ["slip", "start / s", f"jump / {length}", "duration / s", f"greatest speed / {speed}"]
    return Table.of_texts(f"Slips of {log.label}{more}", heads, rows)


def strokes(report: Report, log: LogRecord) -> Table | None:
    """The strokes of a log."""
    if not log.strokes:
        return None
    length, speed = report.units.position, report.units.velocity
    rows = [
        [str(k), "up" if s.direction > 0 else "down", number(s.start, 5), number(s.stop, 5),
         number(s.travel, 4), number(s.speed, 3)]
        for k, s in enumerate(log.strokes[:LISTED], 1)
    ]  # fmt: skip
    heads = ["stroke", "way", "from / s", "to / s", f"travel / {length}", f"mean speed / {speed}"]
    return Table.of_texts(f"Strokes of {log.label}", heads, rows, (0, 1))


def files(card: Card) -> Table:
    """The logs by their bytes."""
    rows = [[d.file or "recording", f"{d.rows:,}", f"{d.used:,}", d.sha256 or DASH]
            for d in card.data]  # fmt: skip
    return Table.of_texts("Logs", ["file", "rows", "used", "SHA-256"], rows, (0, 3))


def motions(report: Report) -> Table | None:
    """The error of each motion shown, where they share a plot."""
    rows = [[f"{part_name(m)}: {m.label}", _known(m.rms, 3)] for m in report.motions]
    shown = report.units.force if report.road == "inverse" else report.units.position
    return (
        Table.of_texts("Motions shown", ["motion", f"RMS / {shown}"], rows)
        if len(rows) > 1
        else None
    )
