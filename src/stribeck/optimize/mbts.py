"""Memetic bacterial foraging-tabu search: the parts of BTS, carried to today's standard."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from math import inf, isfinite, log, nan
from typing import Any, ClassVar

import numpy as np

from ..space import Array, Rng, Space
from .archive import Memory
from .cma_es import adapt
from .hyperparameters import number, positive, whole
from .quasi_newton import Slope, quasi_newton
from .search import Answer, Detailed, Moves, Note, counted
from .trust_region import Floor, least_squares

#: A cost beyond this is a penalty.
LARGEST = 1e100
#: A descent by residuals is looked at after so many evaluations a parameter, and goes on if it has
#: fallen to this share meanwhile, or is below this share of the best cost known before it.
TRIAL, FALL, STANDS_OUT = 3, 0.8, 0.5
#: How much more patience descents are worth where residuals guide them.
WELL_SHOWN = 3.0


@dataclass(frozen=True, kw_only=True)
class MemeticTabuSearch:
    """BTS with a memory, an intensifier that uses what the problem offers, and a split budget.

    What became of the parts of `bts`:

        foraging            cells fill the cube evenly; the best that stands for a basin of its
                            own is where a descent begins (memory.py)
        tabu list           a memory of the floors of basins and of the starts that led there:
                            no descent begins near a recent one or beside something better, and a
                            neighbourhood where the memory is thinnest
        adaptive radius     trust-region least squares where the problem shows residuals
                            (least_squares.py), a quasi-Newton method on costs alone
                            (quasi_newton.py); where costs are rugged and slopes say nothing, a
                            neighbourhood whose shape adapts, too (swarm.py)
        backtracking        the best floor is taken up again where its descent was left slow, when
                            nothing better was found elsewhere; or the floors themselves are
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

    def __post_init__(self) -> None:
        whole(self, 1, "S", "patience")
        if self.N is not None:
            whole(self, 4, "N")
        if self.settle is not None:
            whole(self, 1, "settle")
        positive(self, "R", "R_N", "apart")
        number(self, "R", "R_N", "apart", low=0.0, high=10.0)
        number(self, "tumbles", low=0.0)
        number(self, "grow", low=1.0)

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        """Yield cells, then descents and neighbourhoods in turn."""
        memory = Memory(space.dim, rng)
        note(stage="foraging", round=1)
        theta = memory.forage(1)
        answer = yield Detailed(theta)  # one point tells whether there are residuals
        memory.keep(theta, answer.costs)
        memory.meet(float(answer.costs[0]))
        shown = answer.residuals is not None

        arms = [
            _Arm("tabu", lambda say: self.descents(memory, shown, say)),
            _Arm("neighbourhood", lambda say: self.neighbourhoods(memory, rng, say)),
        ]
        patience = [float(self.patience * space.dim)] * len(arms)
        patience[0] *= WELL_SHOWN if shown else 1.0
        limit = inf if self.settle is None else self.settle * space.dim
        k, left, count, idle = 0, patience[0], 1, 0
        while idle < limit:
            arm, count = arms[k], count + 1
            asked = arm.asked
            note(**{"stage": arm.stage} | arm.said, round=count)
            answer = yield asked
            costs = answer.costs if isinstance(asked, Detailed) else answer
            costs[costs > LARGEST] = inf
            np.maximum(costs, -LARGEST, out=costs)
            arm.spent += len(costs)
            left, idle = left - len(costs), idle + len(costs)
            if memory.meet(float(costs.min())):
                left, idle = max(left, 0.5 * patience[k]), 0
            arm.go(answer)
            if left <= 0.0:
                patience[k] *= 1.5
                k = (k + 1) % len(arms)
                behind = max(a.spent for a in arms) - arms[k].spent
                left = max(patience[k], 0.5 * behind)
        return "settled"

    def descents(self, memory: Memory, shown: bool, note: Note) -> Moves[None]:
        """By turns: from a cell, on from the best floor, from where the floors seem to lead.

        Each goes again as long as it finds something better.
        """
        swarm = memory.forage(self.S * memory.dim)
        note(stage="foraging")
        memory.keep(swarm, (yield swarm))
        state = _State(memory, shown, note)
        while True:
            for turn in (self.from_cell, self.from_best, self.from_floors):
                while (yield from turn(state)):
                    pass

    def from_cell(self, state: _State) -> Moves[bool]:
        """Let cells tumble on, then descend from the best that stands for a basin of its own."""
        memory = state.memory
        theta = memory.forage(max(1, int(self.tumbles * state.last)))
        state.note(stage="foraging")
        memory.keep(theta, (yield theta))
        start = memory.start(self.apart)
        if start is None:
            state.last = max(state.last, 2 * memory.dim)
            return False
        return (yield from self.descend(state, *start))

    def from_best(self, state: _State) -> Moves[bool]:
        """Take the best floor up again where its descent was left."""
        best = state.best
        if isinstance(best, Floor) and best.ended == "poor":
            descent = least_squares(best.point, state.note, radius=self.R)
            return (yield from state.follow(descent))
        if isinstance(best, Slope) and best.ended == "slow":
            deeper = best._replace(worth=1e-2 * best.worth)
            return (yield from state.follow(quasi_newton(deeper, state.note)))
        return False

    def from_floors(self, state: _State) -> Moves[bool]:
        """Descend from where the floors themselves seem to lead."""
        place = state.memory.funnel()
        if place is None:
            return False
        if state.shown:  # the descent asks for it
            return (yield from self.descend(state, place))
        costs = yield place[None]
        return (yield from self.descend(state, place, float(costs[0])))

    def descend(self, state: _State, u: Array, cost: float = nan) -> Moves[bool]:
        """Find the floor below a place, and say whether it is the best."""
        state.memory.begin(u)
        state.note(event="restart")
        if state.shown:
            descent = least_squares(u, state.note, radius=self.R)
            return (yield from state.follow(_hopeful(descent, state.memory.best, len(u))))
        if not isfinite(cost):
            return False
        here = Slope(u, cost, radius=self.R, worth=1e-3 * state.memory.worth)
        best = inf if state.best is None else state.best.cost
        return (yield from state.follow(quasi_newton(here, state.note, best=best)))

    def neighbourhoods(self, memory: Memory, rng: Rng, note: Note) -> Moves[None]:
        """One neighbourhood after the other, each with more neighbours, where little is known."""
        N: float = self.N or 4 + int(3 * log(memory.dim))
        while True:
            centre = memory.thinnest()
            memory.begin(centre)
            note(event="restart")
            memory.end(*(yield from adapt(centre, self.R_N, int(N), rng, note)))
            N = max(N, min(N * self.grow, 200 * memory.dim))


def _hopeful(
    descent: Generator[Detailed, Answer, Floor], best: float, dim: int
) -> Generator[Detailed, Answer, Floor]:
    """Follow a descent as long as it falls, or stands out from the best cost known before it.

    Floors far above the best are many where residuals oscillate; what comes down to the best falls
    fast at first. (The shares were chosen on twins of the slide bed.)
    """
    point, least, before, rows = np.empty(0), inf, inf, 0
    try:
        asked = next(descent)
        while True:
            answer = yield asked
            k = int(answer.costs.argmin())
            if answer.costs[k] < least:
                point, least = asked.points[k].copy(), float(answer.costs[k])
            rows += len(answer.costs)
            if rows >= TRIAL * dim:
                if least > max(FALL * before, STANDS_OUT * best):
                    return Floor(point, least, "poor", np.zeros((dim, dim)))
                before, rows = least, 0
            asked = descent.send(answer)
    except StopIteration as done:
        floor: Floor = done.value
        return floor


class _Arm:
    """One side of the search: what it asks now, what it says of that, what it has spent."""

    def __init__(self, stage: str, moves: Callable[[Note], Moves[None]]) -> None:
        self.stage, self.spent = stage, 0
        self.said: dict[str, Any] = {}
        self._moves = moves(lambda **said: self.said.update(said))
        self._asked: Array | Detailed | None = None

    @property
    def asked(self) -> Array | Detailed:
        """The points it asks; it begins when that is first looked at."""
        if self._asked is None:
            self._asked = next(self._moves)
        return self._asked

    def go(self, answer: Any) -> None:
        """Take the answer to what it asked, and ask anew."""
        self.said = {}
        self._asked = self._moves.send(answer)


@dataclass
class _State:
    """What the turns of the descents share.

    Args:
        memory: The search's.
        shown: Whether the problem shows residuals.
        note: Told of every batch.
        best: The best floor.
        last: Evaluations of the last descent.
    """

    memory: Memory
    shown: bool
    note: Note
    best: Slope | Floor | None = None
    last: int = 0

    def follow(self, descent: Moves[Any]) -> Moves[bool]:
        """Follow a descent to its end, remember the floor, and say whether it is the best."""
        floor: Slope | Floor
        floor, self.last = yield from counted(descent)
        self.memory.end(floor.point, floor.cost)
        least = inf if self.best is None else self.best.cost
        if floor.cost <= least:
            self.best = floor
        return bool(floor.cost < least - self.memory.little)
