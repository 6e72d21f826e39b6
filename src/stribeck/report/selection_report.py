"""A comparison of laws as people read it: a table, sentences, a figure; and as programs do."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.text import Text

from .._version import __version__
from ..identify.card import kind_of
from ..units import unit
from .folder import write_files, write_text
from .format import DASH, json_text, number
from .table import Table
from .terminal import console, show_table, show_warnings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..identify.selection.candidate import Candidate
    from ..identify.selection.free_curve import FreeCurve
    from ..identify.selection.paired_test import Paired
    from ..identify.selection.select import Selection

SCHEMA = "stribeck-selection/1"
#: File names in a folder of results.
FILE, CARD, FIGURE = "selection.json", "card.json", "selection"
#: Names of the files that a folder has of a comparison alone.
OF_A_SELECTION = re.compile(r"selection\.(json|png|svg)")
#: Percent beyond which differences are drawn on a logarithmic scale.
FAR = 100


def laws_table(selection: Selection) -> Table:
    """The laws with their errors, the recommended one marked."""
    s = selection
    heads = ["", "law", "free", f"training/{s.unit}", f"held out/{s.unit}", "against the best"]
    rows = [
        [
            "→" if k == s.chosen else "",
            c.name,
            str(c.free),
            number(c.error, 4),
            number(c.held, 4),
            f"{'best' if k == s.best else against(c.against)}{', worse' * c.worse}",
        ]
        for k, c in enumerate(s.candidates)
    ]
    title = f"laws on {s.rig.name}, held out: {s.splits.text}; → recommended"
    labels = (0, 1, len(heads) - 1)
    return Table.of_texts(title, heads, rows, labels, unbroken=(1,), chosen=s.chosen)


def show_selection(selection: Selection) -> None:
    """The laws in a table, the recommended one marked, and what a reader must know."""
    out, s = console(), selection
    show_table(laws_table(s))
    out.print()
    show_table(_diagnoses(s))
    out.print()
    if s.curve is not None:
        show_table(_curve_table(s, s.curve))
        out.print()
    for k, sentence in enumerate(s.sentences):
        out.print(Text(sentence, style="bold" if k == 0 else ""))
    show_warnings((), s.notes)
    seconds = sum(c.seconds for c in s.candidates)
    compared = f"{s.blocks} blocks or more; " if len(s.candidates) > 1 else ""
    out.print(
        Text(
            f"{compared}{s.effective:,.0f} training samples in effect; fits took {seconds:.1f} s",
            style="dim",
        )
    )


def _diagnoses(s: Selection) -> Table:
    """What else there is to know of each law."""
    searched = s.seed is not None
    heads = ["law", "ΔAICc", "ΔBIC", "lag 1", *(["evaluations"] if searched else []),
             "not identifiable"]  # fmt: skip
    aicc = min(c.criteria.aicc for c in s.candidates)
    bic = min(c.criteria.bic for c in s.candidates)
    rows = [
        [
            c.name,
            _less(c.criteria.aicc, aicc),
            _less(c.criteria.bic, bic),
            f"{c.white.lag_1:.3f}",
            *([f"{c.evaluations:,}"] if searched else []),
            ", ".join(c.unseen),
        ]
        for c in s.candidates
    ]
    return Table.of_texts("", heads, rows, labels=(0, len(heads) - 1), unbroken=(0,))


def _curve_table(s: Selection, curve: FreeCurve) -> Table:
    """The free curve with its intervals, and the recommended law beside it."""
    shown = s.rig.unit_shown("velocity")
    force = s.rig.si_unit("force")
    heads = [f"speed/({shown})", f"free curve/{force}", "95 % from", "to", s.law, "difference/%"]
    rows = [
        [
            number(float(unit(shown).from_si(k.speed)), 3),
            number(k.level, 4),
            number(k.low, 4),
            number(k.high, 4),
            number(k.law, 4),
            f"{100 * k.difference:+.2g}{' *' * k.differs}",
        ]
        for k in curve.knots
    ]
    return Table.of_texts("", heads, rows)


def _less(value: float, least: float) -> str:
    difference = value - least
    return f"{difference:,.1f}" if math.isfinite(difference) else DASH


def against(comparison: Paired | None) -> str:
    """A held-out error against the best's with its 90 % interval: in percent, or as a factor."""
    if comparison is None:
        return ""
    if not math.isfinite(comparison.change):
        return "cannot be run"
    c = comparison
    ends = [c.change, *(e for e in (c.low, c.high) if not math.isnan(e))]
    if max(ends) > 1:
        texts = [f"{1 + e:.3g}" for e in ends]
        texts[0] += " times"
    else:
        texts = [f"{100 * e:+.2g}" for e in ends]
        texts[0] += " %"
    return texts[0] if len(ends) == 1 else f"{texts[0]} ({texts[1]} to {texts[2]})"


def selection_text(selection: Selection) -> str:
    """The same as JSON; docs/selection.md says what each field means."""
    s = selection
    return json_text({
        "schema": SCHEMA,
        "rig": s.rig.name,
        "kind": kind_of(s.rig),
        "recommended": s.law,
        "best": s.candidates[s.best].name,
        "unit": s.unit,
        "held_out": {"kind": s.splits.kind, "text": s.splits.text, "rounds": len(s.splits.rounds),
                     "blocks": s.blocks},
        "effective_samples": s.effective,
        "seed": s.seed,
        "laws": [_law(c) for c in s.candidates],
        "ingredients": [
            {"ingredient": f.ingredient, "without": f.without, "with": f.within,
             "warranted": f.warranted, "range_ends": list(f.range_ends),
             "training_gain": f.training, "held_out": _paired(f.held), "text": f.text}
            for f in s.findings
        ],
        "free_curve": None if s.curve is None else _curve(s.curve),
        "interrupted": s.interrupted,
        "left_out": list(s.skipped),
        "excluded": list(s.excluded),
        "sentences": list(s.sentences),
        "notes": list(s.notes),
        "data": [
            {"file": log.source.file, "sha256": log.source.sha256, "rows": len(log), "role": role}
            for role, logs in _logs(s).items()
            for log in logs
        ],
        "software": {"stribeck": __version__},
    })  # fmt: skip


def _curve(curve: FreeCurve) -> dict[str, Any]:
    return {
        "training_error": curve.error,
        "knots": [
            {"speed": k.speed, "level": k.level, "interval": [k.low, k.high], "law": k.law,
             "differs": k.differs}
            for k in curve.knots
        ],
    }  # fmt: skip


def _law(c: Candidate) -> dict[str, Any]:
    return {
        "law": c.name,
        "free": c.free,
        "ingredients": sorted(c.ingredients),
        "training_error": c.error,
        "held_out_error": c.held,
        "against_best": None if c.against is None else _paired(c.against),
        "worse": c.worse,
        "aicc": c.criteria.aicc,
        "bic": c.criteria.bic,
        "residuals": {"lag_1": c.white.lag_1, "correlation_time": c.white.time,
                      "ljung_box": c.white.Q, "lags": c.white.lags, "p": c.white.p},
        "not_identifiable": list(c.unseen),
        "range_ends": dict(c.range_ends),
        "evaluations": c.evaluations,
        "seconds": round(c.seconds, 3),
    }  # fmt: skip


def _paired(c: Paired) -> dict[str, Any]:
    return {
        "change": c.change,
        "low": c.low,
        "high": c.high,
        "p": c.p,
        "blocks": c.blocks,
        "friction": c.friction,
    }


def _logs(s: Selection) -> dict[str, list[Any]]:
    """Every log once: those trained on, and those that were only held out."""
    trained = {id(p.recording): p.recording for p in s.splits.whole}
    held_out = {id(p.recording): p.recording for r in s.splits.rounds for p in r.held}
    return {
        "train": list(trained.values()),
        "test": [log for key, log in held_out.items() if key not in trained],
    }


def write_selection(selection: Selection, folder: Path) -> None:
    """Write the comparison into a folder."""
    write_text(folder / FILE, selection_text(selection))


def write_card(selection: Selection, folder: Path) -> None:
    """Write the card of the recommended law, whose fit may have to be concluded for it."""
    write_text(folder / CARD, selection.fit.card().text())


def write_figure(selection: Selection, folder: Path) -> None:
    """Draw the comparison into a folder."""
    import matplotlib as mpl  # noqa: PLC0415 - comes late on purpose

    from .figures.style import STYLE, save  # noqa: PLC0415

    with mpl.rc_context(STYLE):
        write_files(folder, lambda place: save(figure(selection), place, FIGURE))


def figure(selection: Selection) -> Figure:
    """Training and held-out error of each law, and how it stands against the best."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - comes late on purpose

    from .figures.style import ACCENT, INK, MEASURED, MODEL  # noqa: PLC0415

    s = selection
    n = len(s.candidates)
    drawn = Figure(figsize=(8.8, 2.1 + 0.42 * n), layout="constrained")
    left, right = drawn.subplots(
        1, 2, sharey=True, width_ratios=[1.25, 1], gridspec_kw={"wspace": 0.08}
    )
    rows = list(range(n))
    shown = [k for k in rows if math.isfinite(s.candidates[k].held)]
    left.plot([c.error for c in s.candidates], rows, "o", color=MEASURED, ms=6, label="training")
    left.plot(
        [s.candidates[k].held for k in shown], shown, "D", color=MODEL, ms=6, label="held out"
    )
    for k in shown:
        ends = [s.candidates[k].error, s.candidates[k].held]
        left.plot(ends, [k, k], color=MEASURED, lw=1, alpha=0.6, zorder=0)
    left.set_yticks(rows, [f"{c.name}  ({c.free})" for c in s.candidates])
    left.set(xlabel=f"{_error_label(s)} / {s.unit}", ylim=(n - 0.45, -0.55))
    left.margins(x=0.08)
    drawn.legend(*left.get_legend_handles_labels(), loc="outside lower left", ncols=2)
    right.axvspan(-1, 1, color="#e5e9ed", zorder=0, lw=0)
    right.axvline(0, color=INK, lw=0.8)
    for k, c in enumerate(s.candidates):
        if c.against is None:
            right.plot([0], [k], "|", color=INK, ms=14, mew=1.5)
            right.annotate("best", (0, k), (5, 4), textcoords="offset points", fontsize=8.5)
            continue
        if not math.isfinite(c.against.change):
            right.annotate("cannot be run", (0, k), (5, -3), textcoords="offset points")
            continue
        colour = MODEL if c.worse else ACCENT
        if math.isfinite(c.against.low):
            ends = [100 * c.against.low, 100 * c.against.high]
            right.plot(ends, [k, k], color=colour, lw=2)
        right.plot([100 * c.against.change], [k], "D", color=colour, ms=5)
    right.set(xlabel="Held-out error against the best / %,\nwith 90 % intervals")
    right.margins(x=0.1)
    ends = [abs(e) for c in s.candidates if c.against for e in (c.against.change, c.against.high)]
    if max((100 * e for e in ends if math.isfinite(e)), default=0) > FAR:
        right.set_xscale("symlog", linthresh=10)
    for axes in (left, right):
        axes.axhspan(s.chosen - 0.45, s.chosen + 0.45, color="#dbeafe", zorder=-1, lw=0)
        axes.tick_params(axis="y", length=0)
        axes.grid(visible=False, axis="y")
    label = left.get_yticklabels()[s.chosen]
    label.set(fontweight="bold", color=ACCENT)
    drawn.suptitle(f"Recommended: {s.law}", x=0.01, ha="left", fontsize=11, fontweight="bold")
    drawn.supxlabel(
        "In brackets: free parameters. Grey band: 1 %, below which a difference does not matter.",
        fontsize=8.5,
        x=0.99,
        ha="right",
    )
    return drawn


def _error_label(s: Selection) -> str:
    if s.seed is None:
        return "Relative force error"
    absolute = s.candidates[0].parameters.objective.loss == "absolute"
    return "Mean position error" if absolute else "Position error J"
