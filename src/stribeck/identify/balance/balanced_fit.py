"""A fit by force balance: the inverse road, told in the words of every other fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...data.ranges import Range, windows
from ...data.recording import Recording
from ...data.segmentation import segment
from ...errors import InputError
from ...space import Array
from ..lookup import recording_list
from ..parameters import Parameters
from ..result import Fit
from ..score import HeldOut, Score
from ..uncertainty.estimates import bound_warnings, correlation_warnings, estimates
from ..uncertainty.uncertainty import uncertainty
from . import balance
from .checks import doubts
from .force_residuals import BalanceResiduals


def balanced(
    parameters: Parameters,
    logs: Sequence[Recording],
    train: Sequence[Range],
    holdout: Sequence[Range],
    *,
    draws: int = 0,
) -> Fit:
    """Solve the force balance of one or several logs, and score what was held out.

    Args:
        parameters: What is to be found.
        logs: The recordings.
        train: Ranges to use; everything if there are none.
        holdout: Ranges to score besides.
        draws: Data sets of a block bootstrap.

    Raises:
        InputError: no measured force, a range without motion, or too few rows.
    """
    chosen, rows = counting(logs, train)
    _check_used(logs, chosen, [*train, *holdout])
    found = balance.balance(chosen, parameters, rows=rows)
    free = [found.names.index(q.name) for q in parameters.free]
    ends = {n: at for n, at in found.at_bound.items() if at in ("lower", "upper")}
    correlation = _correlation(found.covariance)
    system = BalanceResiduals(found.system)
    known = uncertainty(system, found.values[free], keep=True, draws=draws)
    seen = estimates(
        parameters,
        found.values,
        known,
        errors=found.standard_errors[free],
        ends=ends,
        resting={n: at for n, at in found.at_bound.items() if n not in ends},
        misfit="the force error",
    )
    doubted = doubts(chosen, found, rows)
    seen = doubted.widened(parameters, found, seen)
    warnings = [
        *bound_warnings(seen),
        *(
            f"{parameters.rig.label(n)} was stopped by {parameters.rig.label(at)}: "
            "the data would have it below"
            for n, at in found.at_bound.items()
            if n not in ends
        ),
        *correlation_warnings(parameters, correlation),
        *known.notes(parameters, "the force error"),
        *found.notes,
        *doubted.said,
        *(f"{log.label}: {note}" for log in chosen for note in log.notes),
    ]
    return Fit(
        parameters=parameters,
        p=found.values,
        estimates=seen,
        correlation=correlation,
        score=_score(found),
        holdout=tuple(_held_out(parameters, found.values, logs, r) for r in holdout),
        runs=(),
        polished=(),
        method="least squares",
        seed=None,
        evaluations=0,
        seconds=0.0,
        ended="solved",
        train=(),
        train_ranges=tuple(train),
        recordings=tuple(chosen),
        warnings=tuple(dict.fromkeys(warnings)),
        balance=found,
        known=known,
        residuals=system,
    )


def _check_used(
    logs: Sequence[Recording], chosen: Sequence[Recording], within: Sequence[Range]
) -> None:
    """Every log has samples in some range: what is passed over in silence is not missed."""
    for log in logs:
        if not any(log is one for one in chosen):
            counting([log], within)  # says why not


def balance_scores(parameters: Parameters, p: Array, log: Recording, within: Range | None) -> Score:
    """The relative error of the force of a parameter set (SI) on a log or a range of it."""
    return _held_out(parameters, p, [log], within).score


def _held_out(
    parameters: Parameters, p: Array, logs: Sequence[Recording], within: Range | None
) -> HeldOut:
    chosen, rows = counting(logs, [] if within is None else [within])
    seen = balance.validate(chosen, parameters, p, rows=rows)
    return HeldOut(within, _score(seen), (), ())


def _score(seen: balance.Prediction) -> Score:
    nan = float("nan")
    return Score("relative_error", seen.relative_error, "%", nan, nan, seen.rows)


def counting(
    logs: Sequence[Recording], within: Sequence[Range]
) -> tuple[list[Recording], list[balance.Rows | None]]:
    """The logs that pass the ranges, and which of their samples count (None: all).

    Raises:
        InputError: no log passes any of the ranges.
    """
    logs = recording_list(logs)
    if not within:
        return logs, [None] * len(logs)
    chosen: list[Recording] = []
    masks: list[balance.Rows | None] = []
    refused: InputError | None = None
    for log in logs:
        mask = np.zeros(len(log), dtype=bool)
        found = segment(log)
        for r in within:
            try:
                for window in windows(log, r, found):
                    mask[window.rows] = True
            except InputError as error:  # told by the caller, unless another log passes
                refused = refused or error
        if mask.any():
            chosen.append(log)
            masks.append(mask)
    if not chosen and refused is not None:
        raise refused
    return chosen, masks


def _correlation(covariance: Array) -> Array:
    """Correlations, with zeros where the data see nothing of a parameter."""
    spread = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = covariance / np.outer(spread, spread)
    correlation[~np.isfinite(correlation)] = 0.0
    np.fill_diagonal(correlation, 1.0)
    made: Array = correlation
    return made
