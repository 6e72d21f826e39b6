"""Tabu search over a continuous space: Glover's, and the adaptive one of the paper."""

from __future__ import annotations

from bisect import insort
from dataclasses import dataclass
from math import isfinite
from typing import ClassVar, Literal

import numpy as np

from ..space import Array, Rng, Space
from .hyperparameters import choice, positive, stages, whole
from .moves import Moves, Note
from .unit_cube import Coordinates, Neighbours, Walls, gaps, neighbourhood, widths

Entry = tuple[float, int, Array]  # a line of the tabu list: cost, round, solution


def random_start(space: Space, rng: Rng) -> Moves[tuple[Array, float]]:
    """A random solution and its cost; one that cannot be run is no solution, and is redrawn."""
    while True:
        start = space.sample(rng, 1)
        J = float((yield start)[0])
        if isfinite(J):
            return start[0], J


@dataclass(frozen=True, kw_only=True)
class TabuSearch:
    """Move to the best neighbour that is not near a place lately visited, even if it is worse.

    Glover's short-term memory carried to a continuous space: a visited point bans the ball of
    radius `r_tabu` about it for `tenure` rounds. Aspiration: a banned candidate is taken all
    the same if it beats the best cost so far. If every candidate is banned, those whose ban
    ends first are free.

    Args:
        N: Candidates a round.
        R: Half-width of the neighbourhood.
        tenure: Rounds for which a visited point stays tabu.
        r_tabu: Radius of the ball it bans.
        count_max: Rounds after which the search ends; None for no limit.
        walls: What happens to a candidate outside the range: "clip" to it, or "reflect".
        coordinates: Whether R and r_tabu are fractions of the range ("unit") or "raw" values.
    """

    name: ClassVar[str] = "ts"
    N: int = 40
    R: float = 0.15
    tenure: int = 10
    r_tabu: float = 0.02
    count_max: int | None = 1000
    walls: Walls = "clip"
    coordinates: Coordinates = "unit"

    def __post_init__(self) -> None:
        whole(self, 1, "N", "tenure", *(["count_max"] if self.count_max is not None else []))
        positive(self, "R", "r_tabu")
        choice(self, "walls", "clip", "reflect")
        choice(self, "coordinates", "unit", "raw")

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        """Yield a random start, then a neighbourhood a round."""
        width = widths(space, self.coordinates)
        current, best = yield from random_start(space, rng)
        tabu = current[None]
        count = 0
        while count != self.count_max:
            count += 1
            note(round=count)
            candidates = neighbourhood(rng, current, self.R / width, self.N, self.walls)
            costs = yield candidates
            current = candidates[
                admitted(candidates * width, costs, tabu * width, self.r_tabu, best)
            ]
            tabu = np.concatenate([tabu, current[None]])[-self.tenure :]
            best = min(best, float(costs.min()))
        return "count_max"


def admitted(candidates: Array, costs: Array, tabu: Array, r_tabu: float, best: float) -> int:
    """Index of the cheapest candidate that the tabu list or aspiration admits.

    Args:
        candidates: Candidates, shape (n, dim).
        costs: Their costs, shape (n,).
        tabu: Points still tabu, oldest first, shape (k, dim).
        r_tabu: Radius of the ball each bans.
        best: The best cost before this round.
    """
    gap = gaps(candidates, tabu)
    banned = np.einsum("nkd,nkd->nk", gap, gap) <= r_tabu**2
    rounds_left = (banned * np.arange(1, len(tabu) + 1)).max(axis=1)  # 0: free
    free = (rounds_left == 0) | (costs < best)
    if not free.any():
        free = rounds_left == rounds_left.min()
    return int(np.flatnonzero(free)[costs[free].argmin()])


@dataclass(frozen=True, kw_only=True)
class AdaptiveTabuSearch:
    """Adaptive tabu search: Steps 8 to 14 of the paper's section 2.3, from a random start.

    As printed it moves only to a better neighbour and keeps the losers in the tabu list TL,
    which serves backtracking (BT, Algorithm 1) and forbids nothing. The search radius shrinks
    with the cost (AR, Algorithm 2). Where the paper can be read in more ways, a setting names
    them and the default is the literal one.

    Args:
        N: Neighbours a round.
        R: Initial search radius: half-width of the square neighbourhood.
        BT: Rounds without improvement that count as a deadlock.
        n_re_back: Which entry of the TL is retrieved then.
        AR: Stages (epsilon, radius), both falling: below epsilon the radius holds. Epsilons
            are absolute costs; the defaults are those of section 4.4, in mm.
        count_max: Rounds after which the search ends, over all restarts; None for no limit.
        deadlock: "backtrack" into the TL, or "restart" with a new initial solution and the
            initial radius and an empty TL (the literal search cannot leave a basin).
        recall: Whether n_re_back counts from the best entry of the TL ("ranked", section 4.4,
            Step 11) or from the last stored ("recent").
        radius_from: Whether AR looks at the "best" cost since the last start or at that of the
            "current" solution, with which the radius grows again after backtracking.
        AR_by: Whether a stage begins by its "cost" threshold or with each "deadlock", "when
            the current solution is relatively close to a local minimum" (Step 13). The latter
            does not depend on the unit of the cost; a restart then waits for the last stage.
        move: Whether the search moves to a "better" neighbour only (Step 10), or to the "best" one
            even if it is worse than where it is, as tabu search in general does; a deadlock is then
            BT rounds without a new best cost.
        neighbours: Whether they lie "within" the radius, uniform in a square, or "at" it, on a
            sphere.
        walls: What happens to a neighbour outside the range: "clip" to it, or "reflect".
        coordinates: Whether radii are fractions of the range ("unit") or "raw" values.
    """

    name: ClassVar[str] = "ats"
    N: int = 40
    R: float = 0.15
    BT: int = 5
    n_re_back: int = 5
    AR: tuple[tuple[float, float], ...] = ((15.0, 0.0375), (8.0, 0.0095), (3.0, 0.0025))
    count_max: int | None = 1000
    deadlock: Literal["backtrack", "restart"] = "backtrack"
    recall: Literal["ranked", "recent"] = "ranked"
    radius_from: Literal["best", "current"] = "best"
    AR_by: Literal["cost", "deadlock"] = "cost"
    move: Literal["better", "best"] = "better"
    neighbours: Neighbours = "within"
    walls: Walls = "clip"
    coordinates: Coordinates = "unit"

    def __post_init__(self) -> None:
        limits = ["count_max"] if self.count_max is not None else []
        whole(self, 1, "N", "BT", "n_re_back", *limits)
        positive(self, "R")
        stages(self, "AR")
        choice(self, "deadlock", "backtrack", "restart")
        choice(self, "recall", "ranked", "recent")
        choice(self, "radius_from", "best", "current")
        choice(self, "AR_by", "cost", "deadlock")
        choice(self, "move", "better", "best")
        choice(self, "neighbours", "within", "at")
        choice(self, "walls", "clip", "reflect")
        choice(self, "coordinates", "unit", "raw")

    def moves(self, space: Space, rng: Rng, note: Note) -> Moves[str | None]:
        """Yield a random initial solution, then a neighbourhood a round."""
        count = 0
        while count != self.count_max:
            S0, J0 = yield from random_start(space, rng)
            count = yield from self.refine(S0, J0, count, space, rng, note)
        return "count_max"

    def refine(
        self, S0: Array, J0: float, count: int, space: Space, rng: Rng, note: Note
    ) -> Moves[int]:
        """Steps 8 to 14: tabu search from S0 of cost J0, after `count` rounds.

        Returns:
            The rounds done when it met count_max, or a deadlock that calls for a restart.
        """
        width = widths(space, self.coordinates)
        TL: list[Entry] = []
        R, n, deadlocks, best_error = self.R, 0, 0, J0
        while count != self.count_max:  # Steps 12 and 14
            count += 1
            note(stage="tabu", round=count, radius=R)

            # Step 8: N solutions around S0 within the search radius.
            candidates = neighbourhood(rng, S0, R / width, self.N, self.walls, self.neighbours)

            # Step 9: best_neighbor1 and its cost.
            costs = yield candidates
            best_neighbor1 = int(costs.argmin())
            S1, J1 = candidates[best_neighbor1].copy(), float(costs[best_neighbor1])

            # Step 10: the better of S0 and S1 stays, the other goes on the tabu list.
            level = J0 if self.move == "better" else best_error
            n = 0 if level > J1 else n + 1
            if J1 < J0 or self.move == "best":
                self._store(TL, (J0, count, S0))
                S0, J0 = S1, J1
            else:
                self._store(TL, (J1, count, S1))
            best_error = min(best_error, J0)

            # Step 11: backtracking, Algorithm 1. (Its printed branches are interchanged.)
            if n >= self.BT:
                n, deadlocks = 0, deadlocks + 1
                if self.deadlock == "backtrack":
                    note(event="backtrack")
                    J0, _, S0 = self._retrieve(TL)
                elif self.AR_by == "cost" or deadlocks > len(self.AR):
                    note(event="restart")
                    break

            # Step 13: adaptive radius, Algorithm 2.
            R = self.radius(best_error if self.radius_from == "best" else J0, deadlocks)
        return count

    def radius(self, error: float, deadlocks: int) -> float:
        """Algorithm 2: the radius of the last stage that has begun, R before the first.

        ("R = R_1 where R < R_1" is a slip for R_1 < R: in section 4.4 each is 1/4 of the last.)
        """
        R = self.R
        for stage, (epsilon, R_stage) in enumerate(self.AR, 1):
            if (error < epsilon) if self.AR_by == "cost" else (deadlocks >= stage):
                R = R_stage
        return R

    def _store(self, TL: list[Entry], entry: Entry) -> None:
        if self.recall == "ranked":
            insort(TL, entry)  # RANK(TL); the round settles equal costs
            del TL[self.n_re_back :]  # what stands behind that is never retrieved
        else:
            TL.append(entry)
            del TL[: -self.n_re_back]

    def _retrieve(self, TL: list[Entry]) -> Entry:
        k = min(self.n_re_back, len(TL))
        return TL[k - 1] if self.recall == "ranked" else TL[-k]
