"""Memetic bacterial foraging-tabu search: the parts of BTS, carried to today's standard."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite, log, nan
from typing import Any, ClassVar

import numpy as np

from ..space import Array, Rng, Space
from .archive import Archive
from .box import Box
from .cma_es import cma_es
from .hyperparameters import number, positive, whole
from .moves import Detailed, Moves, Note, counted
from .quasi_newton import BfgsState, quasi_newton
from .trust_region import Minimum, least_squares

#: A cost beyond this is a penalty.
LARGEST = 1e100
#: A descent by residuals is looked at after so many evaluations a parameter, and goes on if it has
#: fallen to this share meanwhile, or is below this share of the best cost known before it.
TRIAL, FALL, STANDS_OUT = 3, 0.8, 0.5
#: How much more patience descents are worth where residuals guide them.
WELL_SHOWN = 3.0


@dataclass(frozen=True, kw_only=True)
class MemeticTabuSearch:
    """BTS with an archive, an intensifier that uses what the problem offers, and a split budget.

    What became of the parts of `bts`:

        foraging            cells fill the cube evenly; the best that stands for a basin of its
                            own is where a descent begins (archive.py)
        tabu list           an archive of the minima of basins and of the starts that led there:
                            no descent begins near a recent one or beside something better, and a
                            neighbourhood where the archive is thinnest
        adaptive radius     trust-region least squares where the problem shows residuals
                            (trust_region.py), a quasi-Newton method on costs alone
                            (quasi_newton.py); where costs are rugged and slopes say nothing, a
                            neighbourhood whose shape adapts, too (cma_es.py)
        backtracking        the best minimum is taken up again where its descent was left slow, when
                            nothing better was found elsewhere; or the minima themselves are
                            descended, towards where they seem to lead
        count_max           the budget; it is split between descents and neighbourhoods by what
                            each has lately brought

    Nothing here depends on the unit of the cost. A cost above 1e100 counts as a place that cannot
    be run, so that penalties are no part of the landscape.

    Args:
        S: Cells of the first swarm for each parameter.
        tumbles: Cells that follow for every evaluation that a descent took.
        apart: Two cells this many times (ln(n + 1)/n)^(1/dim) apart, of n in all, may stand for
            two basins.
        R: Length of a descent's first step, half-width of a neighbourhood of least squares.
        N: Neighbours a round of the first neighbourhood; None for 4 + 3 ln(dim).
        R_N: Its first radius.
        grow: By which factor the next neighbourhood has more of them.
        patience: Evaluations for each parameter that may bring nothing better before the other
            side has its turn.
        settle: Evaluations for each parameter that brought nothing better (by a millionth of what
            the best is below the middle of its cells), after which the search ends; None: it goes
            on as long as it is let.
        tolerance: Share of the sum of squares that is not worth a step of a descent by residuals.
    """

    name: ClassVar[str] = "mbts"
    S: int = 5
    tumbles: float = 1.0
    apart: float = 0.4
    R: float = 0.1
    N: int | None = None
    R_N: float = 0.25
    grow: float = 2.0
    patience: int = 150
    settle: int | None = None
    tolerance: float = 1e-6

    def __post_init__(self) -> None:
        whole(self, 1, "S", "patience")
        if self.N is not None:
            whole(self, 4, "N")
        if self.settle is not None:
            whole(self, 1, "settle")
        positive(self, "R", "R_N", "apart", "tolerance")
        number(self, "R", "R_N", "apart", low=0.0, high=10.0)
        number(self, "tumbles", low=0.0)
        number(self, "grow", low=1.0)

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        """Yield cells, then descents and neighbourhoods in turn."""
        archive = Archive(space.dim, rng)
        note(stage="foraging", round=1)
        theta = archive.sample(1)
        answer = yield Detailed(theta)  # one point tells whether there are residuals
        archive.keep(theta, answer.costs)
        archive.update(float(answer.costs[0]))
        shown = answer.residuals is not None

        arms = [
            _Arm("tabu", lambda note: self.descents(archive, Box(space), shown, note)),
            _Arm("neighbourhood", lambda note: self.neighbourhoods(archive, rng, note)),
        ]
        patience = [float(self.patience * space.dim)] * len(arms)
        patience[0] *= WELL_SHOWN if shown else 1.0
        limit = inf if self.settle is None else self.settle * space.dim
        k, patience_left, count, idle = 0, patience[0], 1, 0
        while idle < limit:
            arm, count = arms[k], count + 1
            batch = arm.batch
            note(**{"stage": arm.stage} | arm.words, round=count)
            answer = yield batch
            costs = answer.costs if isinstance(batch, Detailed) else answer
            costs[costs > LARGEST] = inf
            np.maximum(costs, -LARGEST, out=costs)
            arm.spent += len(costs)
            patience_left, idle = patience_left - len(costs), idle + len(costs)
            if archive.update(float(costs.min())):
                patience_left, idle = max(patience_left, 0.5 * patience[k]), 0
            arm.advance(answer)
            if patience_left <= 0.0:
                patience[k] *= 1.5
                k = (k + 1) % len(arms)
                behind = max(a.spent for a in arms) - arms[k].spent
                patience_left = max(patience[k], 0.5 * behind)
        return "settled"

    def descents(self, archive: Archive, box: Box, shown: bool, note: Note) -> Moves[None]:
        """By turns: from a cell, on from the best minimum, from where the minima seem to lead.

        Each goes again as long as it finds something better.
        """
        swarm = archive.sample(self.S * archive.dim)
        note(stage="foraging")
        archive.keep(swarm, (yield swarm))
        state = _State(archive, box, shown, note)
        while True:
            for turn in (self.from_cell, self.from_best, self.from_minima):
                while (yield from turn(state)):
                    pass

    def from_cell(self, state: _State) -> Moves[bool]:
        """Let cells tumble on, then descend from the best that stands for a basin of its own."""
        archive = state.archive
        theta = archive.sample(max(1, int(self.tumbles * state.last)))
        state.note(stage="foraging")
        archive.keep(theta, (yield theta))
        start = archive.start(self.apart)
        if start is None:
            state.last = max(state.last, 2 * archive.dim)
            return False
        return (yield from self.descend(state, *start))

    def from_best(self, state: _State) -> Moves[bool]:
        """Take the best minimum up again where its descent was left."""
        best = state.best
        if isinstance(best, Minimum) and best.ended == "poor":
            descent = self._by_residuals(best.point, state)
            return (yield from state.follow(descent))
        if isinstance(best, BfgsState) and best.ended == "slow":
            deeper = best._replace(worth=1e-2 * best.worth)
            return (yield from state.follow(quasi_newton(deeper, state.note)))
        return False

    def from_minima(self, state: _State) -> Moves[bool]:
        """Descend from where the minima themselves seem to lead."""
        place = state.archive.surrogate_minimum()
        if place is None:
            return False
        if state.shown:  # the descent asks for it
            return (yield from self.descend(state, place))
        costs = yield place[None]
        return (yield from self.descend(state, place, float(costs[0])))

    def descend(self, state: _State, u: Array, cost: float = nan) -> Moves[bool]:
        """Find the minimum below a place, and say whether it is the best."""
        state.archive.begin(u)
        state.note(event="restart")
        if state.shown:
            descent = self._by_residuals(u, state)
            return (yield from state.follow(_hopeful(descent, state.archive.best, len(u))))
        if not isfinite(cost):
            return False
        start = BfgsState(u, cost, radius=self.R, worth=1e-3 * state.archive.worth)
        best = inf if state.best is None else state.best.cost
        return (yield from state.follow(quasi_newton(start, state.note, best=best)))

    def _by_residuals(self, u: Array, state: _State) -> Moves[Minimum]:
        return least_squares(u, state.box, state.note, radius=self.R, tolerance=self.tolerance)

    def neighbourhoods(self, archive: Archive, rng: Rng, note: Note) -> Moves[None]:
        """One neighbourhood after the other, each with more neighbours, where little is known."""
        N: float = self.N or 4 + int(3 * log(archive.dim))
        while True:
            centre = archive.thinnest()
            archive.begin(centre)
            note(event="restart")
            archive.end(*(yield from cma_es(centre, self.R_N, int(N), rng, note)))
            N = max(N, min(N * self.grow, 200 * archive.dim))


def _hopeful(descent: Moves[Minimum], best: float, dim: int) -> Moves[Minimum]:
    """Follow a descent as long as it falls, or stands out from the best cost known before it.

    Minima far above the best are many where residuals oscillate; what comes down to the best
    falls fast at first. (The shares were chosen on twins of the slide bed.)
    """
    point, least, before, rows = np.empty(0), inf, inf, 0
    try:
        batch: Any = next(descent)
        while True:
            answer = yield batch
            k = int(answer.costs.argmin())
            if answer.costs[k] < least:
                point, least = batch.points[k].copy(), float(answer.costs[k])
            rows += len(answer.costs)
            if rows >= TRIAL * dim:
                if least > max(FALL * before, STANDS_OUT * best):
                    return Minimum(point, least, "poor")
                before, rows = least, 0
            batch = descent.send(answer)
    except StopIteration as done:
        minimum: Minimum = done.value
        return minimum


class _Arm:
    """One side of the search: its batch, the note on it, and the evaluations spent."""

    def __init__(self, stage: str, moves: Callable[[Note], Moves[None]]) -> None:
        self.stage, self.spent = stage, 0
        self.words: dict[str, Any] = {}
        self._moves = moves(lambda **words: self.words.update(words))
        self._batch: Array | Detailed | None = None

    @property
    def batch(self) -> Array | Detailed:
        """The points it asks for; it begins when that is first looked at."""
        if self._batch is None:
            self._batch = next(self._moves)
        return self._batch

    def advance(self, answer: Any) -> None:
        """Take the answer to its batch, and ask for the next."""
        self.words = {}
        self._batch = self._moves.send(answer)


@dataclass
class _State:
    """What the turns of the descents share.

    Args:
        archive: Of the search.
        box: Where descents may go.
        shown: Whether the problem shows residuals.
        note: Takes what every batch asks for.
        best: The best minimum.
        last: Evaluations of the last descent.
    """

    archive: Archive
    box: Box
    shown: bool
    note: Note
    best: BfgsState | Minimum | None = None
    last: int = 0

    def follow(self, descent: Moves[Any]) -> Moves[bool]:
        """Follow a descent to its end, remember the minimum, and say whether it is the best."""
        minimum: BfgsState | Minimum
        minimum, self.last = yield from counted(descent)
        self.archive.end(minimum.point, minimum.cost)
        least = inf if self.best is None else self.best.cost
        if minimum.cost <= least:
            self.best = minimum
        return bool(minimum.cost < least - self.archive.little)
