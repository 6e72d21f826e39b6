"""A plan of experiments, for the terminal and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .format import DASH, json_text, number
from .table import Table
from .terminal import console, show_paragraph, show_table, show_warnings

if TYPE_CHECKING:
    from ..identify.design.plan import Gain, Plan, Proposal

#: A factor below this is no gain worth a cell.
GAIN = 1.05


def experiments_table(plan: Plan) -> Table:
    """Experiments in order, with the factors by which they shrink intervals."""
    names = [g.name for g in plan.proposals[0].gains] if plan.proposals else []
    names = [*plan.doubtful, *(n for n in names if n not in plan.doubtful)]
    heads = ["rank", "experiment", "s", "score", *names]
    rows = [
        [
            str(k),
            p.experiment.name,
            f"{p.experiment.seconds:.3g}",
            f"{p.score:.2g}",
            *(_times(_gain(p, n).factor) for n in names),
        ]
        for k, p in enumerate(plan.proposals, 1)
    ]
    title = f"{plan.law} on {plan.rig}: what to record next, by how much intervals shrink"
    return Table.of_texts(title, heads, rows, labels=(0, 1))


def show_plan(plan: Plan) -> None:
    """Experiments in order, how to do them, and what they do not cure."""
    out = console()
    show_table(experiments_table(plan))
    out.print()
    for k, p in enumerate(plan.proposals, 1):
        show_paragraph(f"{p.experiment.name}: {p.experiment.words}", f"{k}. ", style="")
    for text in plan_sentences(plan):
        out.print()
        show_paragraph(text, "")
    if plan.left:
        out.print()
    for name, why in plan.left:
        show_paragraph(f"{name}: {why}", "left out: ", style="")
    show_warnings((), plan.notes)


def _times(factor: float) -> str:
    return f"{factor:.2g}×" if factor >= GAIN else DASH


def _gain(proposal: Proposal, name: str) -> Gain:
    return next(g for g in proposal.gains if g.name == name)


def plan_sentences(plan: Plan) -> list[str]:
    """What the table does not say."""
    doubted = any(_doubted(plan, n) for n in plan.doubtful)
    these = ", ".join(f"{n} ({plan.cards[n].verdict})" if doubted else n for n in plan.doubtful)
    score = f"score: geometric mean of the factors of {'the doubtful ones, ' * doubted}{these}"
    medians = f"medians over {plan.draws} parameter sets that the data allow, seed {plan.seed}"
    sentences = [f"{score}; {medians}"]
    if plan.proposals:
        best = plan.proposals[0]
        sentences.append(f"after {best.experiment.name}, to be expected: {_expected(plan, best)}")
    for p in plan.proposals:
        if p.twin_study is not None:
            pairs = zip(p.gains, p.twin_study.factors, strict=True)
            factors = ", ".join(
                f"{g.name} {f:.2g}× (promised {g.factor:.2g}×)" for g, f in pairs if g.doubtful
            )
            sentences.append(f"{p.experiment.name}, tried on {p.twin_study.twins} twins: {factors}")
    return [*sentences, *plan.said]


def _doubted(plan: Plan, name: str) -> bool:
    return plan.cards[name].verdict in ("weak", "not identifiable")


def _expected(plan: Plan, best: Proposal) -> str:
    """The intervals of the doubtful parameters after an experiment, beside those of now."""
    parts = []
    for g in best.gains:
        if g.doubtful:
            card = plan.cards[g.name]
            present = f"{_end(card.low)} to {_end(card.high)}"
            parts.append(
                f"{g.name} within {number(g.low, 3)} to {number(g.high, 3)} {card.unit} "
                f"(now {present})".replace("  ", " ")
            )
    return ", ".join(parts)


def _end(value: float | None) -> str:
    return "open" if value is None else number(value, 3)


def plan_text(plan: Plan) -> str:
    """The same as JSON."""
    return json_text({
        "schema": "stribeck-plan/1",
        "law": plan.law,
        "rig": plan.rig,
        "seconds": plan.seconds,
        "draws": plan.draws,
        "seed": plan.seed,
        "doubtful": list(plan.doubtful),
        "now": {
            n: {"value": c.value, "unit": c.unit, "low": c.low, "high": c.high,
                "verdict": c.verdict, "reason": c.reason}
            for n, c in plan.cards.items()
        },
        "experiments": [_proposal(p) for p in plan.proposals],
        "left_out": [{"name": name, "why": why} for name, why in plan.left],
        "notes": list(plan.said),
        "log_notes": list(plan.notes),
        "interrupted": plan.interrupted,
    })  # fmt: skip


def _proposal(p: Proposal) -> dict[str, Any]:
    e = p.experiment
    entry: dict[str, Any] = {
        "name": e.name,
        "kind": e.kind,
        "words": e.words,
        "seconds": e.seconds,
        "score": p.score,
        "parameters": {
            g.name: {"factor": g.factor, "expected_low": g.low, "expected_high": g.high}
            for g in p.gains
        },
    }
    if p.twin_study is not None:
        factors = dict(zip((g.name for g in p.gains), p.twin_study.factors.tolist(), strict=True))
        entry["checked"] = {
            "twins": p.twin_study.twins,
            "factors": factors,
        }
    return entry
