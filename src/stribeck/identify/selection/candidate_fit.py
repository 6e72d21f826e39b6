"""A law that was fitted as one of several, told in the words of every other fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...optimize import MemeticTabuSearch
from ...rig.simulated import as_simulated
from ..balance.balanced_fit import balanced
from ..balance.force_residuals import BalanceResiduals
from ..fit import LITTLE
from ..result import Fit
from ..score import held_out, scores
from ..segment import segments
from ..uncertainty.estimates import bound_warnings, correlation_warnings, estimates, resting
from ..uncertainty.uncertainty import uncertainty
from ..uncertainty.verdict import verdict

if TYPE_CHECKING:
    from ...data.ranges import Range
    from ...data.recording import Recording
    from .candidate import Rung

#: Rows that profiles may evaluate for each parameter, starts included: enough for verdicts.
PROFILES = 80
#: A force balance that is better by less than this share was solved to the same answer.
SAME = 1e-6


def fitted(
    rung: Rung, trained: Sequence[Range], out: Sequence[Range], logs: Sequence[Recording], seed: int
) -> Fit:
    """A rung with its intervals, verdicts and scores.

    Args:
        rung: The law, fitted to `trained` of the logs.
        trained: Ranges; everything if there is none.
        out: Ranges that were held out.
        logs: The recordings.
        seed: Of the search.
    """
    return (
        _balanced(rung, trained, out, logs)
        if rung.problem is None
        else _simulated(rung, trained, out, logs, seed)
    )


def unseen(rung: Rung) -> tuple[str, ...]:
    """The parameters that a solved force balance does not identify, as their rig calls them."""
    assert rung.balance is not None  # noqa: S101 - the inverse road's
    residuals = BalanceResiduals(rung.balance.system)
    known = uncertainty(residuals, rung.x, keep=True).by_name()
    rests = resting(residuals, rung.x)
    return tuple(
        rung.parameters.rig.label(q.name)
        for q in rung.parameters.free
        if q.name in rests or verdict(known[q.name][0], q) == "not identifiable"
    )


def _balanced(
    rung: Rung, trained: Sequence[Range], out: Sequence[Range], logs: Sequence[Recording]
) -> Fit:
    """The force balance as it is always told, with a better answer if a simpler law led there."""
    fit = balanced(rung.parameters, logs, trained, out)
    assert rung.balance is not None  # noqa: S101 - the inverse road's
    if fit.score.value <= rung.error * (1 + SAME):
        return fit
    old = fit.score.value
    better = (
        f"a simpler law led to a better fit ({rung.error:.4g} % in place of {old:.4g} %): the "
        "intervals are those of the worse one"
    )
    return replace(
        fit,
        p=rung.p,
        estimates=tuple(
            replace(e, value=float(v)) for e, v in zip(fit.estimates, rung.p, strict=True)
        ),
        score=replace(fit.score, value=rung.error),
        balance=rung.balance,
        warnings=(*fit.warnings, better),
    )


def _simulated(
    rung: Rung,
    trained: Sequence[Range],
    out: Sequence[Range],
    logs: Sequence[Recording],
    seed: int,
) -> Fit:
    parameters, free = rung.parameters, len(rung.parameters.free)
    rig = as_simulated(parameters.rig)
    assert rung.problem is not None  # noqa: S101 - the simulation road's
    assert rung.run is not None  # noqa: S101
    budget = PROFILES * rung.problem.space.dim
    known = uncertainty(rung.problem, rung.x, among=free, budget=budget, keep=True)
    correlation = known.correlation[:free, :free]
    score = scores(parameters, rung.p, rung.train)
    doubtful = score.value > LITTLE * score.smooth
    found = estimates(parameters, rung.p, known, np.full(free, np.nan), doubtful=doubtful)
    return Fit(
        parameters=parameters,
        p=rung.p,
        estimates=found,
        correlation=correlation,
        score=score,
        holdout=tuple(held_out(parameters, rung.p, r, segments(logs, rig, r)) for r in out),
        runs=(rung.run,),
        polished=(),
        method=MemeticTabuSearch.name,
        seed=seed,
        evaluations=rung.evaluations,
        seconds=rung.seconds,
        ended=rung.run.ended,
        train=rung.train,
        train_ranges=tuple(trained),
        recordings=tuple(logs),
        warnings=(
            *bound_warnings(found),
            *correlation_warnings(parameters, correlation),
            *known.notes(parameters),
            *(f"{log.label}: {note}" for log in logs for note in log.notes),
        ),
        known=known,
    )
