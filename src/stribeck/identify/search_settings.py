"""How an identification searches: method, repeats, budget, and when repeats confirm each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral
from typing import Any

import numpy as np
from numpy.random import SeedSequence

from ..data.segmentation import segment
from ..errors import InputError
from ..optimize import Algorithm, MemeticTabuSearch, Search, Target, configure
from ..optimize.descents import Descents
from ..space import Array
from ..wording import option
from .contact_starts import contact_sets, little_friction, scattered
from .fit_warnings import NOISY
from .initial_state import free_starts
from .problem import MotionProblem
from .refinement import MANY
from .segment import recordings_of
from .slip_starts import drawn_starts

#: Evaluations a repeat may spend by default, and what polishing may take of them: a quarter at
#: most.
BUDGET, POLISH = 8_000, 2_400
REPEATS = 3
#: At most so many: they search side by side, in memory.
MOST_REPEATS = 10_000
#: Settings of `mbts` in stick-slip, where a misfit has many basins, and where motions are smooth:
#: after how many evaluations a parameter that brought nothing better it has settled, and, with few
#: parameters, on how much of a misfit its descents end. (Half of what a descent took on the servo
#: logs went into the last thousandth; the answer alone is worth that. In many dimensions each step
#: along a winding valley brings less.)
_STICK_SLIP: dict[str, Any] = {"settle": 200}
_SMOOTH: dict[str, Any] = {"settle": 60}
_FEW: dict[str, Any] = {"tolerance": 1e-4}
#: The same of a search beside the answers of the laws that its law contains.
_BRIEF: dict[str, Any] = {"settle": 20}
#: Rounds of descents from what a force balance or another law shows; see `Descents`.
_CONTACT_ROUNDS = ((8, 4), (3, 12), (2, 60))
#: Fewer slips a log are no stick-slip.
SLIPS = 5
#: Repeats of a smooth problem confirm an answer if two of them came to the same misfit, give or
#: take this share, and each has settled there or not got below it in so many evaluations a
#: parameter since. (On the servo logs minima beside each other differ by a hundredth.)
AGREE, QUIET, CONFIRM = 0.01, 8, 2
#: The same where the misfit is beyond the noise, so that a better one may be elsewhere: a model
#: that leaves something out has rough misfits. (On the go1's logs, benchmarks/nested_laws.py, three
#: of six searches by two repeats had ended in the same wrong minimum as each other.)
QUIET_ROUGH, CONFIRM_ROUGH = 16, 3


@dataclass(frozen=True)
class SearchSettings:
    """How an identification searches.

    Args:
        method: Name of the search method.
        settings: Its settings, where they are not the method's own.
        seed: Seed of all repeats.
        budget: Evaluations of the cost for each repeat, polishing included. In smooth problems
            `mbts` spends as many before that on a law of ten parameters and more that the law
            contains: the richest, searched as it is by itself.
        repeats: Independent searches. In smooth problems, and slip by slip, `mbts` begins with
            two, ends once they confirm each other (three where the misfit is beyond the noise),
            and adds as many again as asked for while none do. In ten dimensions and more, a law
            that contains others has a third as many, brief ones, and starts from the answers of
            these, too, or of the richest alone, which stands for those that it contains: where
            that has as many itself, and a motion may begin as it was measured, descents over longer
            and longer horizons take the place of brief repeats. Where the best hardly moves, one
            more descends from less and less friction.
        target: J at which a search stops.
        polishing: Whether least squares polishes what a search ended with; None: unless the
            method does so itself.

    Raises:
        InputError: a number is not whole, or too small, or there is no such method or setting.
    """

    method: str = MemeticTabuSearch.name
    settings: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0
    budget: int = BUDGET
    repeats: int = REPEATS
    target: float | None = None
    polishing: bool | None = None

    def __post_init__(self) -> None:
        for name, least in (("budget", 1), ("repeats", 1), ("seed", 0)):
            value = getattr(self, name)
            if not isinstance(value, Integral) or value < least:
                raise InputError(f"{option(name)} must be a whole number >= {least}, got {value!r}")
        if self.repeats > MOST_REPEATS:
            raise InputError(
                f"{option('repeats')} must be {MOST_REPEATS:,} at most, got {self.repeats}"
            )
        self._algorithm(smooth=False)

    @property
    def memetic(self) -> bool:
        """Whether the method is the package's own, which restarts, confirms and refines."""
        return self.method == MemeticTabuSearch.name and self.polishing is not False

    @property
    def descends(self) -> bool:
        """Whether descents may begin where something else shows the answer to be."""
        return self.memetic and not self.settings

    @property
    def polish_budget(self) -> int:
        """Evaluations of each repeat that are kept for polishing."""
        polishes_itself = self.polishing is None and self.method == MemeticTabuSearch.name
        if polishes_itself or self.polishing is False:
            return 0
        return min(POLISH, self.budget // 4)

    def searches(
        self, problem: MotionProblem, *, smooth: bool, n: int, brief: bool = False
    ) -> list[Search]:
        """The first n repeats, ready to run.

        Args:
            problem: What they search.
            smooth: Whether its motions are.
            n: How many.
            brief: Whether they end sooner, as there are other places to start from.
        """
        few = problem.space.dim < MANY
        own = self._algorithm(smooth=smooth, few=few, brief=brief)
        algorithm = self._slip_by_slip(problem) or own
        return self._searches_by(algorithm, problem, n)

    def from_contact(self, problem: MotionProblem) -> list[Search]:
        """Repeats that descend from what the force balance of an axis shows, ready to run.

        None where that is not known, or a search is not the package's own.
        """
        if not self.descends or problem.weights is not None:
            return []
        sets = contact_sets(problem.parameters, problem.train)
        if sets is None:
            return []
        algorithm = Descents(lambda rng: scattered(sets, rng), _CONTACT_ROUNDS)
        return self._searches_by(algorithm, problem, min(self.repeats, CONFIRM))

    def from_little_friction(self, problem: MotionProblem) -> list[Search]:
        """A repeat that descends from sets whose levels are small shares of their ranges.

        None where a search is not the package's own.
        """
        if not self.descends or problem.weights is not None:
            return []
        algorithm = Descents(little_friction(problem.parameters), _CONTACT_ROUNDS)
        return self._searches_by(algorithm, problem, 1)

    def from_points(self, problem: MotionProblem, points: Sequence[Array]) -> list[Search]:
        """A repeat that descends from points, SI, (dim,) each, ready to run; none without points.

        None either where another search is asked for than the package's own.
        """
        if not (points and self.descends):
            return []
        return [self.descents(problem, np.array(points), _CONTACT_ROUNDS)]

    def descents(
        self, problem: MotionProblem, points: Array, rounds: tuple[tuple[int, int], ...]
    ) -> Search:
        """A search that descends from points, SI, (n, dim), ready to run; rounds of `Descents`."""
        u = problem.space.encode(points)
        return self._searches_by(Descents(lambda _: u, rounds), problem, 1)[0]

    def _searches_by(self, algorithm: Algorithm, problem: MotionProblem, n: int) -> list[Search]:
        stops = [] if self.target is None else [Target(self.target)]
        budget = self.budget - self.polish_budget
        absolute = problem.parameters.objective.loss == "absolute"
        measure = problem.reported if absolute else None
        return [
            Search(problem.space, algorithm, budget=budget, seed=s, stops=stops, measure=measure)
            for s in SeedSequence(self.seed).spawn(n)
        ]

    def method_on(self, problem: MotionProblem) -> str:
        """Name of the method by which a problem is searched."""
        own = self._slip_by_slip(problem)
        return self.method if own is None else own.name

    def _slip_by_slip(self, problem: MotionProblem) -> Algorithm | None:
        """Descents from what the onsets tell, where a problem is of slips; None elsewhere.

        Slips that break away when they were measured to make a misfit of wide basins.
        """
        if problem.weights is None or not self.memetic or self.settings:
            return None
        parameters, train = problem.parameters, problem.train
        return Descents(lambda rng: drawn_starts(parameters, train, rng))

    def _algorithm(self, *, smooth: bool, few: bool = False, brief: bool = False) -> Algorithm:
        defaults: dict[str, Any] = {}
        if self.method == MemeticTabuSearch.name:
            defaults = _SMOOTH | (_FEW if few else {}) if smooth else _STICK_SLIP
            defaults |= _BRIEF if brief else {}
        return configure(self.method, **defaults | dict(self.settings))


def confirmed(searches: Sequence[Search], noise: float, repeats: int = CONFIRM) -> bool:
    """Whether searches of a smooth problem have come to the same misfit, and stayed there.

    Args:
        searches: The repeats so far.
        noise: What the sensors alone leave of J.
        repeats: How many have to agree.
    """
    return sum(confirms(searches, noise, s) for s in searches) >= repeats


def confirms(searches: Sequence[Search], noise: float, one: Search) -> bool:
    """Whether one of some searches has come to the best misfit of all, and stayed there.

    Args:
        searches: The repeats so far.
        noise: What the sensors alone leave of J.
        one: One of them.
    """
    best = min(s.trace.cost for s in searches)
    quiet = QUIET_ROUGH if rough(searches, noise) else QUIET
    return bool(np.isfinite(best)) and _stayed(one, (1 + AGREE) * best, quiet)


def rough(searches: Sequence[Search], noise: float) -> bool:
    """Whether the least misfit of searches is beyond the noise."""
    return bool(min(s.trace.cost for s in searches) > NOISY * noise)


def _stayed(search: Search, level: float, quiet: int) -> bool:
    reached = search.trace.reached(level) if search.trace.cost <= level else None
    if reached is None:
        return False
    return search.ended == "settled" or len(search.trace) - reached >= quiet * search.space.dim


def sticks_and_slips(problem: MotionProblem) -> bool:
    """Whether the axis sticks and slips in the training data, or elements of its law do.

    Where each slip has a breakaway of its own it does, however few there are.
    """
    if free_starts(problem) or problem.weights is not None or problem.parameters.law.states > 1:
        return True
    slips = {id(log): segment(log).slips for log in recordings_of(problem.train)}
    inside = (
        s.rows.start <= slip.start and slip.stop <= s.rows.stop
        for s in problem.train
        for slip in slips[id(s.recording)]
    )
    return bool(sum(inside) >= SLIPS * len(slips))
