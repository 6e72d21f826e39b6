"""The fit of a law that was trained as one of several."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ...optimize import MemeticTabuSearch
from ...rig.balanced import as_balanced
from ...rig.simulated import as_simulated
from ..arithmetic import Checked, exact_enough
from ..balance.force_balance import solve_balance
from ..balance.force_residuals import BalanceResiduals
from ..balance.run_balance import solve_runs
from ..data_split import DataSplit
from ..free_constants import with_free_constants
from ..multistart import Optimum
from ..output_error_fit import output_error_fit
from ..result import Fit, SearchRecord
from ..segment import SegmentSplit, segments
from ..uncertainty.assessment import Uncertainty, uncertainty
from ..uncertainty.estimates import resting
from ..uncertainty.verdict import verdict
from ..work import Work
from .trained_law import TrainedLaw

#: Rows that profiles may evaluate for each parameter, starts included: enough for verdicts.
PROFILES = 80
#: A force balance that is better by less than this share was solved to the same answer.
SAME = 1e-6


def candidate_fit(trained: TrainedLaw, data: DataSplit, seed: int) -> Fit:
    """A trained law with its intervals, verdicts and scores.

    Args:
        trained: The law, trained on the ranges of `data`.
        data: What it was trained on, and what was held out.
        seed: Of the search.
    """
    if trained.problem is None:
        return _balance_fit(trained, data)
    return _output_error_fit(trained, data, seed)


def unidentified(trained: TrainedLaw) -> tuple[str, ...]:
    """The parameters that a solved force balance does not identify, as their rig labels them."""
    assert trained.balance is not None  # noqa: S101 - of force balances only
    residuals = BalanceResiduals(trained.balance.system)
    profiled = uncertainty(residuals, trained.x, keep=True).by_name()
    rests = resting(residuals, trained.x)
    return tuple(
        trained.parameters.rig.label(q.name)
        for q in trained.parameters.free
        if q.name in rests or verdict(profiled[q.name][0], q)[0] == "not identifiable"
    )


def _balance_fit(trained: TrainedLaw, data: DataSplit) -> Fit:
    """The fit of the force balance, with a better answer if a simpler law led there."""
    if any(log.runs is not None for log in data.recordings):
        return solve_runs(trained.parameters, data)
    source = as_balanced(trained.parameters.rig).filtering.velocity
    fit = solve_balance(trained.parameters, data, delay="off", velocity=source)
    error = fit.score.value
    if error <= trained.error * (1 + SAME):
        return fit
    better = (
        f"a simpler law led to a better fit ({trained.error:.4g} % in place of {error:.4g} %): the "
        "intervals are those of the worse one"
    )
    return replace(
        fit,
        p=trained.p,
        estimates=tuple(
            replace(e, value=float(v)) for e, v in zip(fit.estimates, trained.p, strict=True)
        ),
        score=replace(fit.score, value=trained.error),
        balance=trained.balance,
        warnings=(*fit.warnings, better),
    )


def _output_error_fit(trained: TrainedLaw, data: DataSplit, seed: int) -> Fit:
    parameters, problem, run = trained.parameters, trained.problem, trained.run
    assert problem is not None  # noqa: S101 - of output error only
    assert run is not None  # noqa: S101
    free, rig = len(parameters.free), as_simulated(parameters.rig)
    search = SearchRecord(
        method=MemeticTabuSearch.name,
        seed=seed,
        runs=(run,),
        polished=(),
        evaluations=trained.evaluations,
        seconds=trained.seconds,
        ended=run.ended,
    )
    whole, x, spent = with_free_constants(problem, trained.x)
    optimum = Optimum(
        whole,
        x,
        search,
        spread=np.full(free, np.nan),
        rivals=1,
        repeats=1,
        interrupted=False,
    )
    budget = PROFILES * problem.space.dim
    holdout = tuple((r, tuple(segments(data.recordings, rig, r))) for r in data.holdout)

    def profile(optimum: Optimum) -> tuple[Uncertainty, int]:
        known = uncertainty(optimum.problem, optimum.x, among=free, budget=budget, keep=True)
        return known, known.rows

    uncertain, rows = profile(optimum)
    work = Work(rows=spent + rows)
    checked = work.result(
        partial(exact_enough, optimum, uncertain, profile), Checked(optimum, uncertain)
    )
    return output_error_fit(checked, data, SegmentSplit(trained.train, holdout), work)
