"""A card's misfit on other logs, for the terminal and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .format import json_text, number
from .misfit import SEVERAL, misfit_head, score_texts
from .table import Table
from .terminal import show_table

if TYPE_CHECKING:
    from ..identify.card import Card
    from ..identify.score import Score


def show_validation(card: Card, rows: Sequence[tuple[str, str, Score]]) -> None:
    """Print a card's misfit on logs and ranges: (log, range, score) a row."""
    cells = [[log, within, *score_texts(score)] for log, within, score in rows]
    error = misfit_head(rows[0][2]) if rows else ""
    heads = ["log", "range", error, "smooth", "never moves", "samples"]
    if (pooled := _pooled([score for _, _, score in rows])) is not None:
        cells.append(["all of these", "", *pooled])
    show_table(Table.of_texts(f"{card.law} on {card.rig}", heads, cells, labels=(0, 1)))


def _pooled(every: Sequence[Score]) -> list[str] | None:
    """One misfit of many, where it can be had from theirs; None for one, and for forces."""
    n = [s.samples for s in every]
    power = {"position_rmse": 2, "position_mae": 1}.get(every[0].name if every else "")
    if power is None or len(every) < SEVERAL:
        return None
    kinds = ([getattr(s, part) for s in every] for part in ("value", "smooth", "still"))
    means = [float(np.average(np.power(v, power), weights=n)) ** (1 / power) for v in kinds]
    return [*(number(m, 4) for m in means), str(sum(n))]


def validation_text(card: Card, rows: Sequence[tuple[str, str, Score]]) -> str:
    """The same as JSON."""
    scores = [
        {"log": log, "range": within, "name": s.name, "value": s.value, "unit": s.unit,
         "samples": s.samples, "baselines": s.baselines()}
        for log, within, s in rows
    ]  # fmt: skip
    return json_text({
        "schema": "stribeck-validation/1", "law": card.law, "rig": card.rig, "scores": scores,
    })  # fmt: skip
