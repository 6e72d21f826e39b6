"""Which law the data support: a ladder of laws, fitted alike and compared on what none has seen.

A richer law trains at least as well as one that it contains; that says nothing. So each is held
against data that it was not trained on, and the simplest is taken whose error there is not worse
than the best's: by a paired test over blocks (`paired`), and by more than 1 %, so that a
difference too small to matter decides nothing. The laws are tested in their order, the simplest
first, up to the first that passes: so a long ladder errs no more often than one test, nominally
(Westfall and Krishen 2001, doi 10.1016/S0378-3758(01)00077-5).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from numbers import Integral
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ...friction import Law
from ...optimize import Search
from ...rig import Rig
from ..lookup import range_list, recording_list, rig_and_law
from ..parameters import Parameters, partition
from ..result import Fit
from .candidate import BUDGET, Held, Plan, Rung, climb, held
from .candidate_fit import fitted, unseen
from .contender import Candidate
from .findings import Finding, findings, sentences
from .folds import Splits, splits
from .nesting import ingredients
from .paired_test import criteria, paired, whiteness

if TYPE_CHECKING:
    from ...data.ranges import Range
    from ...data.recording import Recording

FOLDS = 5

#: Told what is being done, with the searches after every step, or none elsewhere.
Progress = Callable[[str, Sequence[Search]], None]


@dataclass(frozen=True, eq=False)
class Selection:
    """A ladder of laws, compared.

    Args:
        rig: The axis.
        candidates: The laws, the simplest first.
        chosen: Which of them is recommended.
        best: Which has the least held-out error.
        splits: What was held out.
        blocks: How many blocks the comparisons rest on at least.
        effective: Training samples in effect, for the criteria.
        findings: Which ingredients are warranted.
        said: What a reader must know, a sentence each; the recommendation first.
        unit: Of the errors.
        seed: Of the searches; None on the inverse road.
        left: Laws that an interruption left out.
    """

    rig: Rig
    candidates: tuple[Candidate, ...]
    chosen: int
    best: int
    splits: Splits
    blocks: int
    effective: float
    findings: tuple[Finding, ...]
    said: tuple[str, ...]
    unit: str
    seed: int | None
    left: tuple[str, ...]

    @property
    def recommended(self) -> Candidate:
        """The simplest law that is not worse than the best."""
        return self.candidates[self.chosen]

    @property
    def law(self) -> str:
        """Its name."""
        return self.recommended.name

    @property
    def fit(self) -> Fit:
        """Its fit."""
        return self.recommended.fit

    def __getitem__(self, name: str) -> Candidate:
        """A candidate by its law's name.

        Raises:
            KeyError: it is not on the ladder.
        """
        for one in self.candidates:
            if one.name == name:
                return one
        raise KeyError(name)

    def __repr__(self) -> str:
        laws = ", ".join(f"{c.name} {c.held:.4g}" for c in self.candidates)
        return f"<Selection of {self.law} on {self.rig.name}; held out, {self.unit}: {laws}>"


def select(
    recordings: Recording | Sequence[Recording],
    *,
    rig: str | Rig = "slide-bed",
    laws: Sequence[str | Law] | None = None,
    train: Sequence[Range | str] | Range | str | None = None,
    holdout: Sequence[Range | str] | Range | str | None = None,
    test: Recording | Sequence[Recording] | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    seed: int | None = None,
    budget: int | None = None,
    folds: int | None = None,
    progress: Progress | None = None,
) -> Selection:
    """Fit a ladder of laws and recommend the simplest that the data support.

    Each law starts from the simpler ones' answers as well as from a search of its own. Where
    nothing is given to be held out, logs are held out in turn, or whole strokes or parts of them
    where there are fewer than three logs, and every law is fitted anew in each round.

    Args:
        recordings: Logs to train on.
        rig: A rig or its name.
        laws: Laws or their names; by default those that the rig was made for.
        train: Ranges to train on; everything by default.
        holdout: Ranges to hold out; they must not overlap what is trained on.
        test: Other logs to hold out as a whole.
        fixed: Parameters to hold in every law that has them, in the units the rig shows.
        bounds: Search ranges in every law that has them, in the units the rig shows.
        seed: Of the searches; 0 by default.
        budget: Evaluations of one fit; 4,000 by default. A search settles sooner, as a rule.
        folds: Rounds, where nothing is given to be held out; 5 by default.
        progress: Called with what is being done and the searches, after every step.

    Raises:
        InputError: something asked for cannot be done with these recordings.
    """
    made = _ladder(rig, laws, dict(fixed or {}), dict(bounds or {}))
    axis = made[0].rig
    logs, tests = recording_list(recordings), [] if test is None else recording_list(test)
    simulated = axis.approach == "output_error"
    given = {"seed": seed, "budget": budget}
    for name, value, least in (("seed", seed, 0), ("budget", budget, 1), ("folds", folds, 2)):
        if value is not None and (not isinstance(value, Integral) or value < least):
            raise InputError(f"{name} must be a whole number >= {least}, got {value!r}")
    if idle := [] if simulated else [n for n, v in given.items() if v is not None]:
        raise InputError(
            f"rig {axis.name} is solved by least squares, without a search: "
            f"{', '.join(idle)} does not apply"
        )
    trained, out = range_list(train, axis), range_list(holdout, axis)
    if folds is not None and (out or tests):
        raise InputError("folds are for data of which nothing was held out: leave them away")
    rounds = splits(logs, axis, trained, out, tests, FOLDS if folds is None else folds)
    plan = _Ladder(rounds, 0 if seed is None else seed, budget or BUDGET, progress)
    for one in made:
        try:
            plan.climb(one, trained, out, logs)
        except KeyboardInterrupt:
            if not plan.done:
                raise
            break
    return _compared(axis, plan, [m.law.name for m in made], plan.seed if simulated else None)


def _ladder(
    rig: str | Rig,
    laws: Sequence[str | Law] | None,
    fixed: dict[str, float],
    bounds: dict[str, tuple[float, float]],
) -> list[Parameters]:
    """The laws with their parameters, the simplest first.

    Raises:
        InputError: an unknown law, one that is given twice, or a name that no law knows.
    """
    axis, _ = rig_and_law(rig, None)
    found = [rig_and_law(axis, law)[1] for law in (axis.laws if laws is None else laws)]
    names = [law.name for law in found]
    if twice := [n for n in names if names.count(n) > 1]:
        raise InputError(f"law {twice[0]} is given twice: give it once")
    if not found:
        raise InputError("no law was given")
    known: set[str] = set()
    made = []
    for law in found:
        own = {n for q in axis.parameters(law) for n in (q.name, axis.label(q.name))}
        known |= own
        made.append(
            partition(
                axis,
                law,
                fixed={n: v for n, v in fixed.items() if n in own},
                bounds={n: v for n, v in bounds.items() if n in own},
            )
        )
    if strange := [n for n in (*fixed, *bounds) if n not in known]:
        raise InputError(
            f"no law here has a parameter {strange[0]!r} on rig {axis.name}: there are "
            f"{', '.join(sorted(known))}"
        )
    return sorted(made, key=lambda m: len(m.free))


class _Ladder:
    """The laws that are done, with what is needed to compare them."""

    def __init__(self, rounds: Splits, seed: int, budget: int, progress: Progress | None) -> None:
        self.rounds, self.seed, self.budget, self._progress = rounds, seed, budget, progress
        self.done: list[tuple[Rung, Held, tuple[str, ...], Callable[[], Fit], float, int]] = []
        self._below: list[list[Rung]] = [[] for _ in (rounds.whole, *rounds.rounds)]

    def climb(
        self,
        parameters: Parameters,
        trained: Sequence[Range],
        out: Sequence[Range],
        logs: Sequence[Recording],
    ) -> None:
        """Fit a law to everything and in every round, and hold it against what is left."""
        name, found = parameters.law.name, []
        rounds = self.rounds.rounds
        main = climb(parameters, self.rounds.whole, self._below[0], self._plan(name))
        found.append(main)
        seen: Held | None = None
        for k, split in enumerate(rounds, 1):
            rung = main
            if self.rounds.kind != "hold-out":
                plan = self._plan(f"{name}, round {k} of {len(rounds)}")
                rung = climb(parameters, split.train, [*self._below[k], main], plan, k)
                found.append(rung)
            part = held(rung, split.held)
            seen = part if seen is None else seen.joined(part)
        assert seen is not None  # noqa: S101 - there is at least one round
        if self._progress is not None:
            self._progress(f"{name}, intervals", [])
        conclude = partial(fitted, main, trained, out, logs, self.seed)
        if main.problem is None:  # the rest takes as long as the fit, and may wait
            blind = unseen(main)
        else:
            fit = conclude()
            blind = tuple(e.name for e in fit.estimates if e.verdict == "not identifiable")
            conclude = partial(_kept, fit)
        seconds, spent = sum(r.seconds for r in found), sum(r.evaluations for r in found)
        self.done.append((main, seen, blind, conclude, seconds, spent))
        for below, rung in zip(self._below, found, strict=False):
            below.append(rung)

    def _plan(self, doing: str) -> Plan:
        progress = self._progress
        if progress is None:
            return Plan(self.seed, self.budget)
        progress(doing, [])
        return Plan(self.seed, self.budget, lambda searches: progress(doing, searches))


def _kept(fit: Fit) -> Fit:
    return fit


def _compared(axis: Rig, plan: _Ladder, names: Sequence[str], seed: int | None) -> Selection:
    rungs = [rung for rung, *_ in plan.done]
    seen = [part for _, part, *_ in plan.done]
    errors = [part.error for part in seen]
    if not np.isfinite(min(errors)):
        raise InputError("no law here can be simulated on what was held out")
    best = int(np.argmin(errors))
    pieces = [part.residuals for part in seen]
    against = [paired(one, pieces[best]) for one in pieces]
    others = [i for i in range(len(rungs)) if i != best]
    worse = [i != best and against[i].worse for i in range(len(rungs))]
    ruler = min(rungs, key=lambda r: float(np.mean(r.residuals**2)))
    effective = len(ruler.residuals) / whiteness(ruler.residuals, ruler.logs).time
    made = []
    for i, (rung, part, blind, conclude, seconds, spent) in enumerate(plan.done):
        r, free = rung.residuals, len(rung.parameters.free)
        made.append(
            Candidate(
                parameters=rung.parameters,
                error=rung.error,
                held=part.error,
                criteria=criteria(float(np.mean(r**2)), free, effective),
                white=whiteness(r, rung.logs),
                unseen=blind,
                against=None if i == best else against[i],
                worse=worse[i],
                ingredients=ingredients(
                    rung.parameters.law, [q.name for q in rung.parameters.free]
                ),
                evaluations=spent,
                seconds=seconds,
                conclude=conclude,
            )
        )
    able = [i for i in range(len(made)) if not worse[i]]
    taken = min(able, key=lambda i: (made[i].free, len(made[i].unseen), made[i].held))
    has = [c.ingredients for c in made]
    found = findings(
        [(c.name, c.free) for c in made],
        has,
        taken,
        lambda simple, rich: paired(pieces[simple], pieces[rich]),
        [c.error for c in made],
    )
    left = tuple(names[len(made) :])
    count = min((against[i].blocks for i in others), default=0)
    said = sentences(made, taken, best, found, count, left)
    return Selection(
        axis, tuple(made), taken, best, plan.rounds, count, effective, found, said,
        rungs[0].unit, seed, left,
    )  # fmt: skip
