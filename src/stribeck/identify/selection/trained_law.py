"""A law trained on ranges of logs, and its errors on others."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal
from zlib import crc32

import numpy as np
from numpy.random import SeedSequence

from ...errors import InputError
from ...optimize import MemeticTabuSearch, Run, Search, configure
from ...rig.simulated import as_simulated
from ...space import Array
from ..balance import balance
from ..initial_state import FreeStartProblem, free_starts
from ..loss import SQUARES
from ..multistart import with_free_starts
from ..parameters import Parameters
from ..polish import Polished, polish
from ..problem import MotionProblem
from ..score import scores
from ..search_repeats import Progress, run_searches
from ..segment import Segment, segments
from ..uncertainty.residuals import parts
from .folds import LogRange
from .nesting import carried
from .range_ends import End, RangedAnswer, beyond, with_ranges_of

if TYPE_CHECKING:
    from ...data.recording import Recording
    from .folds import Mask

#: Evaluations that a search may spend on one fit, and after how many for each parameter without
#: anything better it has settled: more in stick-slip, where there are many basins. The simpler
#: laws' answers are candidates as well.
BUDGET, SETTLE, SETTLE_STICK_SLIP = 4_000, 60, 200
#: How many answers of simpler laws are refined, and what that may take for each parameter.
STARTS, REFINED = 2, 25


@dataclass(frozen=True)
class TrainingSettings:
    """How each law is searched for under output error.

    Args:
        seed: Of all searches.
        budget: Evaluations of one training.
        progress: Called with the searches after every step.
    """

    seed: int
    budget: int
    progress: Progress | None = None


@dataclass(frozen=True, eq=False)
class TrainedLaw:
    """A law trained on ranges of logs.

    Args:
        parameters: Its parameters.
        p: Its complete parameter set, SI, (k,).
        error: Misfit on its training data in the unit shown: J, the mean size of its errors, or
            percent.
        unit: Of the misfit.
        residuals: Of the training, (rows,).
        logs: Rows of each log or segment.
        evaluations: Of the cost.
        seconds: Wall-clock time.
        problem: The problem searched; None for a force balance.
        x: Free parameters, and the starts where they are unknowns too, SI.
        run: The search; None for a force balance.
        balance: The solved force balance; None for output error.
        range_ends: Parameters that an end of a search range holds, so that the misfit is greater
            than the law's own.
    """

    parameters: Parameters
    p: Array
    error: float
    unit: str
    residuals: Array
    logs: tuple[int, ...]
    evaluations: int
    seconds: float
    problem: MotionProblem | FreeStartProblem | None
    x: Array
    run: Run | None
    balance: balance.Balance | None
    range_ends: Mapping[str, End] = field(default_factory=dict)

    @property
    def train(self) -> tuple[Segment, ...]:
        """The segments trained on, from the starts estimated; none for a force balance."""
        if isinstance(self.problem, FreeStartProblem):
            return self.problem.at(self.x)[0].train
        return () if self.problem is None else self.problem.train


def train_law(
    parameters: Parameters,
    train: Sequence[LogRange],
    simpler: Sequence[TrainedLaw],
    settings: TrainingSettings,
    key: int = 0,
) -> TrainedLaw:
    """Train a law, starting from other answers too: no worse than any law that it contains.

    Args:
        parameters: Its parameters.
        train: Ranges to train on.
        simpler: Simpler laws trained on the same, and the law itself trained on more: where to
            start decides only which of several minima is reached.
        settings: How to search.
        key: Number of the round, so that rounds draw different numbers.

    Raises:
        InputError: these ranges cannot be simulated, or have too few rows.
    """
    start_time = time.perf_counter()
    wide: dict[str, tuple[float, float]] = {}
    for law in simpler:
        wide |= {q.name: (q.lower, q.upper) for q in law.parameters.free}
    parameters = with_ranges_of(parameters, wide)
    if parameters.rig.approach == "output_error":
        return _searched(parameters, train, simpler, settings, key, start_time)
    return _solved(parameters, train, simpler, start_time)


_Place = tuple[MotionProblem | FreeStartProblem, Array]


def _searched(
    parameters: Parameters,
    train: Sequence[LogRange],
    simpler: Sequence[TrainedLaw],
    settings: TrainingSettings,
    key: int,
    start_time: float,
) -> TrainedLaw:
    problem = MotionProblem(parameters, _segments(parameters, train))
    seed = SeedSequence(settings.seed, spawn_key=(crc32(parameters.law.name.encode()), key))
    settle = SETTLE_STICK_SLIP if free_starts(problem) else SETTLE
    method = configure(MemeticTabuSearch.name, settle=settle)
    search = Search(problem.space, method, budget=settings.budget, seed=seed)
    (run,), interrupted = run_searches(problem, [search], settings.progress)
    if interrupted:
        raise KeyboardInterrupt
    if parameters.objective.loss == "absolute":
        problem = problem.finer()
    whole = with_free_starts(problem)
    starts = whole.nominal if isinstance(whole, FreeStartProblem) else np.empty(0)
    x = [np.concatenate([run.x, starts])]
    x += [point for trained in simpler for point in _carried(trained, parameters, whole)]
    costs = whole(np.array(x))
    spent = run.evaluations + len(x)
    # The end of the search is a minimum already, unless the starts have come free since.
    promising = [k for k in np.argsort(costs, kind="stable")[: STARTS + 1] if np.isfinite(costs[k])]
    polished = [Polished(x[k], float(costs[k]), 0) for k in range(len(x)) if np.isfinite(costs[k])]
    polished += [
        polish(whole, x[k], float(costs[k]), REFINED * whole.space.dim)
        for k in promising
        if k or whole is not problem
    ]
    dim = len(parameters.free)

    def further(wider: Parameters, answer: RangedAnswer[_Place]) -> RangedAnswer[_Place]:
        elsewhere = with_free_starts(problem.over(wider))
        x = answer.solution[1]
        trial = polish(elsewhere, x, answer.cost, REFINED * elsewhere.space.dim)
        polished.append(trial)
        return RangedAnswer(wider, trial.x[:dim], trial.cost, (elsewhere, trial.x))

    best = min(polished, key=lambda d: d.cost)
    answer = RangedAnswer(parameters, best.x[:dim], best.cost, (whole, best.x))
    answer, ends = beyond(answer, further)
    parameters, (whole, solution) = answer.parameters, answer.solution
    p = parameters.full(answer.x[None])[0]
    trained = TrainedLaw(
        parameters,
        p,
        answer.cost,
        problem.unit,
        whole.residuals(solution[None])[0],
        whole.logs,
        spent + sum(d.evaluations for d in polished),
        time.perf_counter() - start_time,
        whole,
        solution,
        run,
        None,
        ends,
    )
    if parameters.objective.loss == "absolute":
        return replace(trained, error=scores(parameters, p, trained.train).value)
    return trained


def _carried(
    trained: TrainedLaw, parameters: Parameters, whole: MotionProblem | FreeStartProblem
) -> list[Array]:
    """A simpler law's answer as points of a richer law's problem, its starts with them."""
    points = carried(trained.parameters, trained.p, parameters)
    if not isinstance(whole, FreeStartProblem):
        return points
    starts, nominal = trained.x[len(trained.parameters.free) :], whole.nominal
    kept = starts if len(starts) == len(nominal) else nominal
    return [np.concatenate([x, kept]) for x in points]


def _segments(parameters: Parameters, ranges: Sequence[LogRange]) -> list[Segment]:
    """The segments of all ranges; one in which the axis never rests counts for nothing.

    Raises:
        InputError: nothing is left.
    """
    rig = as_simulated(parameters.rig)
    result: list[Segment] = []
    refused: InputError | None = None
    for log in ranges:
        try:
            result += segments([log.recording], rig, log.within)
        except InputError as error:
            refused = refused or error
    if refused is not None and not result:
        raise refused
    return result


def _solved(
    parameters: Parameters,
    train: Sequence[LogRange],
    simpler: Sequence[TrainedLaw],
    start_time: float,
) -> TrainedLaw:
    logs, masks = _masks(train)

    def solved(parameters: Parameters, start: Array | None = None) -> balance.Balance:
        return balance.balance(logs, parameters, rows=masks, start=start)

    best = solved(parameters)
    if best.system.shape:
        for law in (r for r in simpler if r.error < best.relative_error):
            for start in parameters.full(np.array(carried(law.parameters, law.p, parameters))):
                from_nested = solved(parameters, start)
                if from_nested.relative_error < best.relative_error:
                    best = from_nested

    def further(
        wider: Parameters, answer: RangedAnswer[balance.Balance]
    ) -> RangedAnswer[balance.Balance]:
        return _answer(wider, solved(wider, answer.solution.values))

    answer, ends = beyond(_answer(parameters, best), further)
    best = answer.solution
    parameters = best.system.parameters
    rows = tuple(len(s.t) for s in best.signals)
    return TrainedLaw(
        parameters,
        best.values,
        best.relative_error,
        "%",
        best.residuals,
        rows,
        0,
        time.perf_counter() - start_time,
        None,
        answer.x,
        None,
        best,
        ends,
    )


def _answer(parameters: Parameters, solved: balance.Balance) -> RangedAnswer[balance.Balance]:
    x = solved.values[parameters.free_places]
    return RangedAnswer(parameters, x, solved.relative_error, solved)


def _masks(ranges: Sequence[LogRange]) -> tuple[list[Recording], list[Mask]]:
    """Each log once, with all that counts of it."""
    masks: dict[int, tuple[Recording, Mask]] = {}
    for part in ranges:
        log = part.recording
        entry = masks.get(id(log), (log, np.zeros(len(log), dtype=bool)))
        masks[id(log)] = (log, entry[1] | part.mask())
    return [log for log, _ in masks.values()], [mask for _, mask in masks.values()]


@dataclass(frozen=True, eq=False)
class HeldOutErrors:
    """A model's residuals on data that was held out.

    Args:
        residuals: An array a segment or log; nan where the model cannot be run.
        size: Sum of squares of what was measured, for an error relative to that.
        measure: Relative to that, root mean square, or mean size.
    """

    residuals: tuple[Array, ...]
    size: float
    measure: Literal["relative", "rms", "mean"]

    @property
    def power(self) -> int:
        """What of the residuals counts: 2 for their squares, 1 for their sizes."""
        return 1 if self.measure == "mean" else 2

    @property
    def error(self) -> float:
        """J, the mean size of the errors, or the relative error in percent."""
        total = sum(float(np.sum(np.abs(r) ** self.power)) for r in self.residuals)
        if not np.isfinite(total):
            return float("inf")
        if self.measure == "relative":
            return 100 * float(np.sqrt(total / self.size)) if self.size > 0 else float("inf")
        return float((total / sum(len(r) for r in self.residuals)) ** (1 / self.power))

    def joined(self, other: HeldOutErrors) -> HeldOutErrors:
        """Both together."""
        return HeldOutErrors(self.residuals + other.residuals, self.size + other.size, self.measure)


def held_out_errors(trained: TrainedLaw, ranges: Sequence[LogRange]) -> HeldOutErrors:
    """The errors of a trained law on ranges held out, from where the sensor saw the axis start.

    Raises:
        InputError: these ranges cannot be simulated, or have too few rows.
    """
    parameters = trained.parameters
    if parameters.rig.approach == "output_error":
        measure: Literal["rms", "mean"]
        measure = "mean" if parameters.objective.loss == "absolute" else "rms"
        plain = replace(parameters, objective=SQUARES)
        problem = MotionProblem(plain, _segments(parameters, ranges))
        x = trained.p[None, parameters.free_places]
        residuals = parts(problem.residuals(x)[0], problem.logs)
        return HeldOutErrors(tuple(r for r in residuals if len(r)), 0.0, measure)
    logs, masks = _masks(ranges)
    signals = balance.validate(logs, parameters, trained.p, rows=masks).signals
    residuals = [s.measured - s.predicted for s in signals if len(s.t)]
    size = sum(float(s.measured @ s.measured) for s in signals)
    return HeldOutErrors(tuple(residuals), size, "relative")
