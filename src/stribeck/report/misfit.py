"""The misfit of a fit: what it is called, and how large it is on each log."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..identify.score import scores
from .format import number

if TYPE_CHECKING:
    from ..identify.result import Fit
    from ..identify.score import Score

#: How many logs are several.
SEVERAL = 2


#: What the misfits of positions are called.
_NAMES = {"position_rmse": "J", "position_mae": "mean size of the error"}


def misfit_name(name: str, other: str = "") -> str:
    """What a misfit of the card is called; `other` (or its name) if it is not one of positions."""
    return _NAMES.get(name) or other or name.replace("_", " ")


def misfit_head(score: Score) -> str:
    """The head of a column of misfits."""
    return f"{misfit_name(score.name)} / {score.unit}"


#: What the figures of a force balance that have a unit are called; some are of a log.
_FIGURES = {
    "relative_error_percent": "relative error / %",
    "residual_sd": "residual sd / {force}",
    "friction_range_N": "friction range / N",
}


def balance_figures(figures: Mapping[str, float], force: str) -> list[list[str]]:
    """Names and values of the figures of a force balance.

    Args:
        figures: By name, and the log it is of behind a space, as the card has them.
        force: The unit of the force.
    """
    rows = []
    for name, value in figures.items():
        figure, _, log = name.partition(" ")
        words = _FIGURES.get(figure, figure.replace("_", " ")).format(force=force)
        rows.append([", ".join(filter(None, (words, log))), number(value)])
    return rows


def score_texts(score: Score) -> list[str]:
    """The model's misfit, its two baselines, and the samples."""
    return [
        number(score.value, 4),
        number(score.smooth, 4),
        number(score.still, 4),
        str(score.samples),
    ]


def log_errors(fit: Fit) -> list[tuple[str, int, list[float]]]:
    """The misfit on each log: (log, samples trained on, misfits); nan where it was not used.

    The misfits are on the training data and then on each range held out, as `fit.score` has them.
    """
    rows = []
    for k, log in enumerate(fit.recordings):
        errors = []
        if fit.balance is not None:
            b = fit.balance.signals[k]
            share = float(np.linalg.norm(b.measured - b.predicted) / np.linalg.norm(b.measured))
            errors = [100.0 * share]
        else:
            for segments in (fit.train, *(h.segments for h in fit.holdout)):
                parts = [s for s in segments if s.recording is log]
                errors.append(scores(fit.parameters, fit.p, parts).value if parts else math.nan)
        rows.append((log.label, fit.used(log), errors))
    return rows
