"""One law of a ladder, fitted to portions of logs on either road, and held against others."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING
from zlib import crc32

import numpy as np
from numpy.random import SeedSequence

from ...errors import InputError
from ...optimize import MemeticTabuSearch, Run, Search, configure, steps
from ...rig.balanced import as_balanced
from ...rig.simulated import as_simulated
from ...space import Array
from ..balance import balance
from ..initial_state import FreeStartProblem, free_starts, started_at_each
from ..parameters import Parameters
from ..polish import Polished, polish
from ..problem import MotionProblem
from ..segment import Segment, segments
from ..uncertainty.residuals import parts
from .folds import LogRange
from .nesting import embedded

if TYPE_CHECKING:
    from ...data.recording import Recording
    from .folds import Mask

#: Evaluations that a search may spend on one fit, and after how many for each parameter without
#: anything better it has settled: more in stick-slip, where there are many basins. The simpler
#: laws' answers are candidates as well.
BUDGET, SETTLE, SETTLE_STICK_SLIP = 4_000, 60, 200
#: How many answers of simpler laws are refined, and what that may take for each parameter.
STARTS, REFINED = 2, 25

#: Called with the searches after every step.
Progress = Callable[[Sequence[Search]], None]


@dataclass(frozen=True)
class Plan:
    """How each fit is searched for, on the road that searches.

    Args:
        seed: Of all searches.
        budget: Evaluations of one fit.
        progress: Called with the searches after every step.
    """

    seed: int
    budget: int
    progress: Progress | None = None


@dataclass(frozen=True, eq=False)
class Rung:
    """A law fitted to portions.

    Args:
        parameters: Its parameters.
        p: What was found, a complete set, SI, (k,).
        error: Misfit on what it was trained on, as people read it: J or percent.
        unit: Of the misfit.
        residuals: Of the training, (rows,).
        logs: Rows of each log or segment.
        evaluations: Of the cost.
        seconds: It took.
        problem: What was searched; None on the inverse road.
        x: Free parameters, and the starts where they are unknowns too, SI.
        run: The search; None on the inverse road.
        balance: The solved force balance; None on the simulation road.
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

    @property
    def train(self) -> tuple[Segment, ...]:
        """The segments it was trained on, from the starts found; none on the inverse road."""
        if isinstance(self.problem, FreeStartProblem):
            return started_at_each(self.problem.problem.train, self.x[len(self.parameters.free) :])
        return () if self.problem is None else self.problem.train


def climb(
    parameters: Parameters, on: Sequence[LogRange], below: Sequence[Rung], plan: Plan, key: int = 0
) -> Rung:
    """Fit a law, from other answers too: it trains no worse than any law that it contains.

    Args:
        parameters: Its parameters.
        on: What to train on.
        below: Simpler laws fitted to the same, and the law itself fitted to more: where to
            start decides nothing but which of several minima is seen.
        plan: How to search.
        key: Which round this is, so that rounds draw different numbers.

    Raises:
        InputError: these portions cannot be simulated, or have too few rows.
    """
    began = time.perf_counter()
    if parameters.rig.approach == "output_error":
        return _searched(parameters, on, below, plan, key, began)
    return _solved(parameters, on, below, began)


def _searched(
    parameters: Parameters,
    on: Sequence[LogRange],
    below: Sequence[Rung],
    plan: Plan,
    key: int,
    began: float,
) -> Rung:
    problem = MotionProblem(parameters, _segments(parameters, on))
    seed = SeedSequence(plan.seed, spawn_key=(crc32(parameters.law.name.encode()), key))
    settle = SETTLE_STICK_SLIP if free_starts(problem) else SETTLE
    method = configure(MemeticTabuSearch.name, settle=settle)
    search = Search(problem.space, method, budget=plan.budget, seed=seed)
    for _ in steps(problem, [search]):
        if plan.progress is not None:
            plan.progress([search])
    run = search.run()
    if not np.isfinite(run.cost):
        raise InputError(
            f"no parameter set in the search ranges could be simulated with law "
            f"{parameters.law.name}: check the ranges and the rig's constants"
        )
    spent = run.evaluations
    whole: MotionProblem | FreeStartProblem = problem
    x = [run.x]
    if free_starts(problem):
        whole = FreeStartProblem(problem)
        x = [np.concatenate([run.x, whole.nominal])]
    x += [_carried(rung, parameters, whole) for rung in below]
    costs = whole(np.array(x))
    spent += len(x)
    # What a search of the motion found is at rest there, unless the starts have come free.
    worth = [k for k in np.argsort(costs, kind="stable")[: STARTS + 1] if np.isfinite(costs[k])]
    done = [Polished(x[k], float(costs[k]), 0) for k in range(len(x)) if np.isfinite(costs[k])]
    done += [
        polish(whole, x[k], float(costs[k]), REFINED * whole.space.dim)
        for k in worth
        if k or whole is not problem
    ]
    best = min(done, key=lambda d: d.cost)
    return Rung(
        parameters,
        parameters.full(best.x[None, : len(parameters.free)])[0],
        best.cost,
        problem.unit,
        whole.residuals(best.x[None])[0],
        whole.logs,
        spent + sum(d.evaluations for d in done),
        time.perf_counter() - began,
        whole,
        best.x,
        run,
        None,
    )


def _carried(rung: Rung, parameters: Parameters, whole: MotionProblem | FreeStartProblem) -> Array:
    """A simpler law's answer as a point of a richer law's problem, its starts with it."""
    x = embedded(rung.parameters, rung.p, parameters)
    if not isinstance(whole, FreeStartProblem):
        return x
    starts, own = rung.x[len(rung.parameters.free) :], whole.nominal
    return np.concatenate([x, starts if len(starts) == len(own) else own])


def _segments(parameters: Parameters, on: Sequence[LogRange]) -> list[Segment]:
    """The segments of all portions; one in which the axis never rests counts for nothing.

    Raises:
        InputError: nothing is left.
    """
    rig = as_simulated(parameters.rig)
    found: list[Segment] = []
    refused: InputError | None = None
    for portion in on:
        try:
            found += segments([portion.recording], rig, portion.within)
        except InputError as error:
            refused = refused or error
    if refused is not None and not found:
        raise refused
    return found


def _solved(
    parameters: Parameters, on: Sequence[LogRange], below: Sequence[Rung], began: float
) -> Rung:
    rig, (logs, masks) = as_balanced(parameters.rig), _masks(on)

    def solved(near: Array | None = None) -> balance.Balance:
        return balance.balance(logs, parameters, rows=masks, near=near)

    found = solved()
    linear = {q.name for q in rig.own(parameters.law)} | set(parameters.law.linear)
    if any(q.name not in linear for q in parameters.free):
        for rung in (r for r in below if r.error < found.relative_error):
            near = parameters.full(embedded(rung.parameters, rung.p, parameters)[None])[0]
            other = solved(near)
            if other.relative_error < found.relative_error:
                found = other
    rows = tuple(len(s.t) for s in found.signals)
    free = [found.names.index(q.name) for q in parameters.free]
    return Rung(
        parameters,
        found.values,
        found.relative_error,
        "%",
        found.residuals,
        rows,
        0,
        time.perf_counter() - began,
        None,
        found.values[free],
        None,
        found,
    )


def _masks(on: Sequence[LogRange]) -> tuple[list[Recording], list[Mask]]:
    """Each log once, with all that counts of it."""
    masks: dict[int, tuple[Recording, Mask]] = {}
    for portion in on:
        log = portion.recording
        known = masks.get(id(log), (log, np.zeros(len(log), dtype=bool)))
        masks[id(log)] = (log, known[1] | portion.mask())
    return [log for log, _ in masks.values()], [mask for _, mask in masks.values()]


@dataclass(frozen=True, eq=False)
class Held:
    """A model's residuals on what was held out.

    Args:
        residuals: A piece an array; nan where the model cannot be run.
        size: Sum of squares of what was measured, for an error relative to that.
        relative: Whether it is.
    """

    residuals: tuple[Array, ...]
    size: float
    relative: bool

    @property
    def error(self) -> float:
        """J, or the relative error in percent."""
        squares = sum(float(r @ r) for r in self.residuals)
        if not np.isfinite(squares):
            return float("inf")
        if self.relative:
            return 100 * float(np.sqrt(squares / self.size)) if self.size > 0 else float("inf")
        return float(np.sqrt(squares / sum(len(r) for r in self.residuals)))

    def joined(self, other: Held) -> Held:
        """Both together."""
        return Held(self.residuals + other.residuals, self.size + other.size, self.relative)


def held(rung: Rung, on: Sequence[LogRange]) -> Held:
    """A fitted law on what it has not seen, from where the axis was seen to start.

    Raises:
        InputError: these portions cannot be simulated, or have too few rows.
    """
    parameters = rung.parameters
    if parameters.rig.approach == "output_error":
        problem = MotionProblem(parameters, _segments(parameters, on))
        names = [q.name for q in parameters.every]
        x = rung.p[None, [names.index(q.name) for q in parameters.free]]
        found = parts(problem.residuals(x)[0], problem.logs)
        return Held(tuple(r for r in found if len(r)), 0.0, relative=False)
    logs, masks = _masks(on)
    seen = balance.validate(logs, parameters, rung.p, rows=masks)
    pieces = tuple(s.measured - s.predicted for s in seen.signals if len(s.t))
    size = sum(float(s.measured @ s.measured) for s in seen.signals)
    return Held(pieces, size, relative=True)
