"""Results in a notebook: tables of HTML, in which every text is escaped."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from ..errors import InputError
from ..units import unit
from .compensation_report import LEGEND, sentences, tables
from .format import number, unit_label
from .page.fit_tables import baselines, breakaway, parameters
from .plan_report import experiments_table, plan_sentences
from .selection_report import laws_table
from .table import Table
from .terminal import gathered

if TYPE_CHECKING:
    from ..compensate.compensation import Compensation
    from ..data.quality import Quality
    from ..data.recording import Recording
    from ..identify.card import Card
    from ..identify.design.plan import Plan
    from ..identify.result import Fit
    from ..identify.selection.select import Selection

#: The units in which a notebook shows the channels of a linear axis.
_SHOWN = {"m": "mm", "m/s": "mm/s"}


def fit_html(fit: Fit) -> str:
    """A fit as its card shows it."""
    try:
        return card_html(fit.card())
    except InputError as error:  # a misfit that is no number has no card
        return str(_document(repr(fit), [], [str(error)]))


def card_html(card: Card) -> str:
    """Parameters with intervals and verdicts, the misfit and its baselines, warnings and notes."""
    tables = [parameters(card), breakaway(card), baselines(card)]
    title = f"{card.law} on {card.rig}"
    warnings = [f"warning: {w}" for w in gathered(card.warnings)]
    return str(_document(title, tables, [*warnings, *_notes(card.notes)]))


def recording_html(recording: Recording) -> str:
    """The channels of a log, and what was mended in it."""
    rows = []
    for name, values in recording.channels().items():
        si = recording.si_unit(name)
        shown = unit(_SHOWN.get(si, si)).from_si(values)
        ends = (float(np.min(shown)), float(np.max(shown)))
        rows.append([name, unit_label(_SHOWN.get(si, si)), *(number(x, 4) for x in ends)])
    rows += [
        [name, "", *(number(float(x), 4) for x in (a.min(), a.max()))]
        for name, a in recording.extra.items()
    ]
    seconds = float(recording.t[-1] - recording.t[0])
    title = (
        f"{recording.label}: {len(recording):,} samples in {number(seconds, 4)} s, "
        f"{number(1 / recording.dt, 4)} Hz"
    )
    table = Table.of_texts("Channels", ["channel", "unit", "least", "greatest"], rows, (0, 1))
    return str(_document(title, [table], [f"note: {n}" for n in recording.notes]))


def quality_html(quality: Quality) -> str:
    """What is in a log, and what it is good enough for."""
    table = Table.of_texts("Log", ["", ""], quality.lines(), (0, 1))
    return str(_document(quality.file or "recording", [table]))


def selection_html(selection: Selection) -> str:
    """The laws compared, and what a reader must know."""
    return str(_document(f"Recommended: {selection.law}", [laws_table(selection)],
                         [*selection.sentences, *_notes(selection.notes)]))  # fmt: skip


def compensation_html(compensation: Compensation) -> str:
    """Scales, what the recommended one does, and what a reader must know."""
    mode = compensation.mode
    scale = compensation.compensator.scale if compensation.compensator else 0.0
    title = f"Compensate by {mode} at scale {scale:.4g}" if mode else "Do not compensate yet"
    return str(_document(title, tables(compensation), [LEGEND, *sentences(compensation)]))


def plan_html(plan: Plan) -> str:
    """The experiments in order, how to do them, and what they do not cure."""
    words = [f"{p.experiment.name}: {p.experiment.words}" for p in plan.proposals]
    return str(_document("What to record next", [experiments_table(plan)],
                         [*words, *plan_sentences(plan), *_notes(plan.notes)]))  # fmt: skip


def _notes(notes: Sequence[str]) -> list[str]:
    return [f"note: {n}" for n in gathered(notes)]


def _document(title: str, tables: Sequence[Table | None], sentences: Sequence[str] = ()) -> Markup:
    """A heading, tables, and sentences below them."""
    head = Markup("<p><b>{}</b></p>").format(title)
    body = Markup("\n").join(table.html() for table in tables if table is not None)
    items = Markup("").join(Markup("<li>{}</li>").format(s) for s in sentences)
    return head + body + (Markup("<ul>{}</ul>").format(items) if sentences else Markup(""))
