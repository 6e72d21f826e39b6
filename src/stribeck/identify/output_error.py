"""The solution of an identification by output error: scored by simulating its motions."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from ..data.recording import Recording
from ..rig.simulated import as_simulated
from ..space import Array
from .data_split import DataSplit, SegmentSplit, split_segments
from .fit_warnings import explains_little, output_error_warnings
from .initial_state import FreeStartProblem, started_at_each
from .multistart import Optimum, Progress, SearchSettings, multistart
from .parameters import Parameters
from .problem import MotionProblem
from .result import SearchRecord
from .score import HeldOut, Score, held_out, scores
from .segment import Segment, recordings_of
from .sliding_check import mark_never_slid
from .uncertainty.assessment import Uncertainty, uncertainty
from .uncertainty.estimates import (
    Estimate,
    bound_warnings,
    correlation_warnings,
    estimates,
    resting,
)

#: Rows that profiles may evaluate: half as many as the search did, so that where a motion takes
#: long to simulate the intervals do not take longer than the answer, and at least so many for each
#: parameter; but never more than the first.
PROFILES, PROFILED = 6_000, 400


@dataclass(frozen=True, eq=False)
class OutputErrorSolution:
    """A least-misfit parameter set with its uncertainty.

    Args:
        optimum: Where the search ended.
        uncertainty: How well its parameters are known; its `x` is the solution.
        data: What was trained on and held out.
        segments: The same as segments.
    """

    optimum: Optimum
    uncertainty: Uncertainty
    data: DataSplit
    segments: SegmentSplit

    balance = None

    @property
    def residuals(self) -> MotionProblem | FreeStartProblem:
        """The problem that was solved."""
        return self.optimum.problem

    @property
    def parameters(self) -> Parameters:
        """Which parameters were free."""
        return self.residuals.parameters

    @property
    def search(self) -> SearchRecord:
        """How it was searched for."""
        return self.optimum.search

    @property
    def recordings(self) -> tuple[Recording, ...]:
        """The logs."""
        return self.data.recordings

    @property
    def dim(self) -> int:
        """How many parameters were free; the starts of motions follow them."""
        return len(self.parameters.free)

    @cached_property
    def p(self) -> Array:
        """The complete parameter set, SI, (k,)."""
        complete: Array = self.parameters.full(self.uncertainty.x[None, : self.dim])[0]
        return complete

    @property
    def correlation(self) -> Array:
        """Of the free parameters' estimates, (dim, dim)."""
        return self.uncertainty.correlation[: self.dim, : self.dim]

    @cached_property
    def train(self) -> tuple[Segment, ...]:
        """The segments trained on, from the starts that were estimated."""
        if isinstance(self.residuals, FreeStartProblem):
            starts = self.uncertainty.x[self.dim :]
            return started_at_each(self.residuals.problem.train, starts)
        return self.residuals.train

    def score(self) -> Score:
        """J over the training segments."""
        return scores(self.parameters, self.p, self.train)

    def estimates(self, score: Score) -> tuple[Estimate, ...]:
        """The parameters one by one."""
        judged = estimates(
            self.parameters,
            self.p,
            self.uncertainty,
            self.optimum.spread,
            resting=resting(self.residuals, self.uncertainty.x),
            doubtful=explains_little(self.parameters, score),
        )
        return mark_never_slid(self.parameters, judged, recordings_of(self.train))

    def holdout(self) -> tuple[HeldOut, ...]:
        """J over each range held out."""
        return tuple(held_out(self.parameters, self.p, r, s) for r, s in self.segments.holdout)

    def warnings(self, estimates: tuple[Estimate, ...], score: Score) -> tuple[str, ...]:
        """What a reader must know, a sentence each."""
        interrupted = "interrupted: the search, its polishing or its intervals had not ended"
        return (
            *([interrupted] if self.search.ended == "interrupted" else []),
            *bound_warnings(estimates),
            *correlation_warnings(self.parameters, self.correlation),
            *output_error_warnings(
                self.parameters,
                score,
                self.segments,
                self.recordings,
                self.optimum.rivals,
                self.optimum.repeats,
            ),
            *self.uncertainty.notes(self.parameters),
        )


def solve_output_error(
    parameters: Parameters,
    data: DataSplit,
    settings: SearchSettings,
    *,
    draws: int = 0,
    progress: Progress | None = None,
) -> OutputErrorSolution:
    """Identify by output error: search, polish, and profile the answer.

    Args:
        parameters: Of a law on a rig that is simulated.
        data: What to train on and to hold out.
        settings: How to search.
        draws: Data sets of a block bootstrap.
        progress: Called with the searches after every step.

    Raises:
        InputError: a range has no motion to simulate, or no parameter set could be simulated.
    """
    rig, restart = as_simulated(parameters.rig), parameters.objective.restart
    segments = split_segments(data, rig, restart=restart)
    optimum = multistart(MotionProblem(parameters, segments.train), settings, progress)
    uncertain, interrupted = _profiled(optimum, len(parameters.free), settings, draws)
    if interrupted:
        search = replace(optimum.search, ended="interrupted")
        optimum = replace(optimum, search=search, interrupted=True)
    return OutputErrorSolution(optimum, uncertain, data, segments)


def _profiled(
    optimum: Optimum, free: int, settings: SearchSettings, draws: int
) -> tuple[Uncertainty, bool]:
    """How well the first `free` parameters are known, and whether Ctrl-C cut that short.

    Then the profiles have the budget of a rough estimate.
    """
    problem, x = optimum.problem, optimum.x
    budget = min(PROFILES, max(optimum.search.evaluations // 2, PROFILED * problem.space.dim))
    keep = settings.polishing is False
    if not optimum.interrupted:
        try:
            uncertain = uncertainty(
                problem, x, among=free, budget=budget, keep=keep, draws=draws, seed=settings.seed
            )
        except KeyboardInterrupt:
            pass
        else:
            return uncertain, False
    return uncertainty(problem, x, among=free, budget=4 * len(x), keep=True), True
