"""The solution of an identification by force balance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...data.ranges import Range, windows
from ...data.recording import Recording
from ...data.segmentation import segment
from ...errors import InputError
from ...space import Array
from ..data_split import DataSplit, recording_list
from ..parameters import Parameters
from ..result import SearchRecord
from ..score import HeldOut, Score
from ..uncertainty.assessment import Uncertainty, uncertainty
from ..uncertainty.estimates import Estimate, bound_warnings, correlation_warnings, estimates
from . import balance
from .checks import BalanceChecks, check_balance
from .force_residuals import BalanceResiduals

#: What the misfit of a force balance is called.
MISFIT = "the force error"


@dataclass(frozen=True, eq=False)
class BalanceSolution:
    """A solved force balance with its uncertainty and its checks.

    Args:
        parameters: Which parameters were free.
        balance: The solved force balance.
        residuals: Its residuals over the box of the parameters.
        uncertainty: How well the free parameters are known.
        checks: What speaks against it.
        recordings: The logs that were solved for.
        data: What was trained on and held out.
    """

    parameters: Parameters
    balance: balance.Balance
    residuals: BalanceResiduals
    uncertainty: Uncertainty
    checks: BalanceChecks
    recordings: tuple[Recording, ...]
    data: DataSplit

    search = SearchRecord("least squares", None, (), (), 0, 0.0, "solved")
    train = ()

    @property
    def p(self) -> Array:
        """The complete parameter set, SI, (k,)."""
        return self.balance.values

    @property
    def correlation(self) -> Array:
        """Of the free parameters' estimates, (dim, dim); 0 where the data see nothing of one."""
        covariance = self.balance.covariance
        spread = np.sqrt(np.diag(covariance))
        with np.errstate(invalid="ignore", divide="ignore"):
            correlation: Array = covariance / np.outer(spread, spread)
        correlation[~np.isfinite(correlation)] = 0.0
        np.fill_diagonal(correlation, 1.0)
        return correlation

    def score(self) -> Score:
        """The relative error of the force."""
        return _score(self.balance)

    def estimates(self, score: Score) -> tuple[Estimate, ...]:
        """The parameters one by one, with intervals as wide as the checks say."""
        del score  # a force balance is doubted by its own checks
        stops = self.balance.at_bound
        ends = {n: at for n, at in stops.items() if at in ("lower", "upper")}
        unwidened = estimates(
            self.parameters,
            self.p,
            self.uncertainty,
            errors=self.balance.standard_errors[self.parameters.free_places],
            ends=ends,
            resting={n: at for n, at in stops.items() if n not in ends},
            misfit=MISFIT,
        )
        return self.checks.widened(self.parameters, self.balance, unwidened)

    def holdout(self) -> tuple[HeldOut, ...]:
        """The relative error of the force over each range held out."""
        logs = self.data.recordings
        return tuple(_held_out(self.parameters, self.p, logs, r) for r in self.data.holdout)

    def warnings(self, estimates: tuple[Estimate, ...], score: Score) -> tuple[str, ...]:
        """What a reader must know, a sentence each."""
        del score  # the same
        label = self.parameters.rig.label
        sentences = [
            *bound_warnings(estimates),
            *(
                f"{label(n)} was stopped by {label(at)}: the data would have it below"
                for n, at in self.balance.at_bound.items()
                if at not in ("lower", "upper")
            ),
            *correlation_warnings(self.parameters, self.correlation),
            *self.uncertainty.notes(self.parameters, MISFIT),
            *self.balance.notes,
            *self.checks.sentences,
            *(f"{log.label}: {note}" for log in self.recordings for note in log.notes),
        ]
        return tuple(dict.fromkeys(sentences))


def solve_balance(parameters: Parameters, data: DataSplit, *, draws: int = 0) -> BalanceSolution:
    """Solve the force balance of one or several logs, profile and check it.

    Args:
        parameters: Of a law on a rig with a measured force.
        data: What to train on and to hold out.
        draws: Data sets of a block bootstrap.

    Raises:
        InputError: no measured force, a range without motion, or too few rows.
    """
    recordings, rows = counting(data.recordings, data.train)
    _check_used(data.recordings, recordings, data.ranges)
    solved = balance.balance(recordings, parameters, rows=rows)
    residuals = BalanceResiduals(solved.system)
    x = solved.values[parameters.free_places]
    uncertain = uncertainty(residuals, x, keep=True, draws=draws)
    checks = check_balance(recordings, solved, rows)
    return BalanceSolution(
        parameters, solved, residuals, uncertain, checks, tuple(recordings), data
    )


def _check_used(
    logs: Sequence[Recording], chosen: Sequence[Recording], ranges: Sequence[Range]
) -> None:
    """Every log has samples in some range: what is passed over in silence is not missed."""
    for log in logs:
        if not any(log is used for used in chosen):
            counting([log], ranges)  # says why not


def balance_scores(parameters: Parameters, p: Array, log: Recording, part: Range | None) -> Score:
    """The relative error of the force of a parameter set (SI) on a log or a range of it."""
    return _held_out(parameters, p, [log], part).score


def _held_out(
    parameters: Parameters, p: Array, logs: Sequence[Recording], part: Range | None
) -> HeldOut:
    chosen, rows = counting(logs, [] if part is None else [part])
    prediction = balance.validate(chosen, parameters, p, rows=rows)
    return HeldOut(part, _score(prediction), (), ())


def _score(prediction: balance.Prediction) -> Score:
    nan = float("nan")
    return Score("relative_error", prediction.relative_error, "%", nan, nan, prediction.rows)


def counting(
    logs: Sequence[Recording], ranges: Sequence[Range]
) -> tuple[list[Recording], list[balance.Rows | None]]:
    """The logs that pass the ranges, and which of their samples count (None: all).

    Raises:
        InputError: no log passes any of the ranges.
    """
    logs = recording_list(logs)
    if not ranges:
        return logs, [None] * len(logs)
    chosen: list[Recording] = []
    masks: list[balance.Rows | None] = []
    refused: InputError | None = None
    for log in logs:
        mask = np.zeros(len(log), dtype=bool)
        segmentation = segment(log)
        for r in ranges:
            try:
                for window in windows(log, r, segmentation):
                    mask[window.rows] = True
            except InputError as error:  # told by the caller, unless another log passes
                refused = refused or error
        if mask.any():
            chosen.append(log)
            masks.append(mask)
    if not chosen and refused is not None:
        raise refused
    return chosen, masks
