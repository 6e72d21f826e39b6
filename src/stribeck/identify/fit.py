"""From recordings to a fitted law: split, search, polish, look back, say what was found."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.random import SeedSequence

from ..errors import InputError
from ..friction import Law
from ..optimize import Run, Search, Target, configure
from ..rig import Rig
from ..rig.slide_bed import SlideBed
from ..space import Array
from .polish import Polished, polish_run
from .problem import (
    MotionProblem,
    Parameters,
    Stretch,
    chosen,
    listed,
    parameters,
    parts,
    ranges,
    stretches,
)
from .uncertainty import (
    Estimate,
    bound_warnings,
    correlation_warnings,
    estimates,
    standard_errors,
)
from .validate import HeldOut, Score, held_out, scores

if TYPE_CHECKING:
    from ..data.ranges import Range
    from ..data.recording import Recording
    from .inverse import Balance

#: Evaluations a repeat may spend unless told otherwise, and what polishing may take of them.
BUDGET, POLISH = 10_000, 2_400
REPEATS = 3
#: A repeat whose J is within this factor of the best explains the data as well for all we know.
RIVAL = 1.1
#: Stopping rule of the paper (section 4.4): J < 4.5 mm or 1000 rounds.
PAPER_TARGET = 4.5

Look = Callable[[Sequence[Search]], None]


@dataclass(frozen=True, eq=False)
class Fit:
    """What an identification found, and what it rests on.

    Args:
        parameters: Which parameters were free, fixed and tied.
        p: The complete parameter set found, SI.
        estimates: The parameters one by one.
        correlation: Of the free parameters' estimates, (dim, dim).
        score: Misfit on the training data beside its baselines.
        holdout: The same for each range held out.
        runs: The searches, the best first.
        polished: What polishing made of each run.
        method: Name of the search method.
        seed: Seed of the searches.
        evaluations: Of the cost, in all.
        seconds: Wall-clock time of the searches.
        ended: Why the best search ended; "interrupted" if somebody stopped it.
        train: The stretches it was trained on.
        recordings: The logs.
        warnings: What a reader must know, a sentence each.
        balance: The force balance of a rig on the inverse road, else None.
    """

    parameters: Parameters
    p: Array
    estimates: tuple[Estimate, ...]
    correlation: Array
    score: Score
    holdout: tuple[HeldOut, ...]
    runs: tuple[Run, ...]
    polished: tuple[Polished, ...]
    method: str
    seed: int | None
    evaluations: int
    seconds: float
    ended: str
    train: tuple[Stretch, ...]
    train_ranges: tuple[Range, ...]
    recordings: tuple[Recording, ...]
    warnings: tuple[str, ...]
    balance: Balance | None = field(default=None, repr=False)

    @property
    def rig(self) -> Rig:
        """The rig."""
        return self.parameters.rig

    @property
    def law(self) -> Law:
        """The friction law."""
        return self.parameters.law

    def used(self, recording: Recording) -> int:
        """How many samples of a recording the fit was trained on."""
        if self.balance is not None:
            return len(self.balance.signals[self.recordings.index(recording)].t)
        return sum(int(s.track.sums[0, -1]) for s in self.train if s.recording is recording)

    @property
    def values(self) -> dict[str, float]:
        """The complete parameter set by name, SI."""
        return self.parameters.values(self.p)


def identify(
    recordings: Recording | Sequence[Recording],
    *,
    rig: str | Rig = "slide-bed",
    law: str | Law | None = None,
    method: str | None = None,
    train: Sequence[Range | str] | Range | str | None = None,
    holdout: Sequence[Range | str] | Range | str | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    tied: Mapping[str, str] | None = None,
    seed: int | None = None,
    budget: int | None = None,
    repeats: int | None = None,
    target: float | None = None,
    polishing: bool = True,
    settings: Mapping[str, Any] | None = None,
    look: Look | None = None,
) -> Fit:
    """Identify the friction of an axis.

    On a rig of the simulation road (`slide-bed`) repeats of a search run in lockstep on the
    output error J (4.5), and bounded least squares polishes each of their answers. On the
    inverse road (`emps`, `forced`) the force balance is solved by least squares, which leaves
    nothing to search: `method`, `seed`, `budget`, `repeats` and `target` do not apply there.

    Args:
        recordings: One or several logs of the axis.
        rig: A rig or its name.
        law: A law or its name; by default the rig's first.
        method: A search method; by default `bts` with the settings of section 4.4.
        train: Ranges to train on; everything by default.
        holdout: Ranges to validate on.
        fixed: Parameters to hold, in the units the rig shows.
        bounds: Search ranges that replace the rig's, in the units the rig shows.
        tied: Parameters that equal others.
        seed: Seed of all repeats; 0 by default.
        budget: Evaluations of the cost for each repeat, polishing included; 10,000 by default.
        repeats: Independent searches; 3 by default.
        target: Stop a search at this J, in the unit in which the rig shows positions.
        polishing: Whether least squares polishes what a search found.
        settings: Settings of the search method.
        look: Called with the searches after every step; a progress bar looks here.

    Raises:
        InputError: something asked for cannot be done with these recordings.
    """
    rig, law = chosen(rig, law)
    logs = listed(recordings)
    made = parameters(rig, law, fixed=fixed, bounds=bounds, tied=tied)
    trained, held = ranges(train, rig), ranges(holdout, rig)
    if not isinstance(rig, SlideBed):
        asked = {"method": method, "seed": seed, "budget": budget, "repeats": repeats,
                 "target": target, "settings": settings or None}  # fmt: skip
        if idle := [name for name, value in asked.items() if value is not None]:
            raise InputError(
                f"rig {rig.name} is solved by least squares, without a search: "
                f"{', '.join(idle)} does not apply"
            )
        from .balance import balanced  # noqa: PLC0415 - scipy.signal, which a search never needs

        return balanced(made, logs, trained, held)
    train_on = [s for r in parts(train, rig) for s in stretches(logs, rig, r)]
    tests = [(r, stretches(logs, rig, r)) for r in held]
    _check_used(logs, rig, [train_on, *(part for _, part in tests)], [*trained, *held])
    problem = MotionProblem(made, train_on)
    plan = _Plan(
        method or "bts",
        dict(settings or {}),
        0 if seed is None else seed,
        BUDGET if budget is None else budget,
        REPEATS if repeats is None else repeats,
        target,
        polishing,
    )
    searches = plan.searches(problem)
    interrupted = _run(problem, searches, look)
    return _conclude(problem, plan, searches, tests, trained, logs, interrupted)


def _check_used(
    logs: Sequence[Recording], rig: SlideBed, seen: Sequence[Sequence[Stretch]], given: list[Range]
) -> None:
    """Every log has a stretch that counts: what is passed over in silence is not missed."""
    for log in logs:
        if not any(s.recording is log for part in seen for s in part):
            wanted: list[Range | None] = [*given] or [None]
            for within in wanted:
                stretches([log], rig, within)  # says why not


@dataclass(frozen=True)
class _Plan:
    """How the searches are run."""

    method: str
    settings: dict[str, Any]
    seed: int
    budget: int
    repeats: int
    target: float | None
    polishing: bool

    def polish_budget(self) -> int:
        return min(POLISH, self.budget // 4) if self.polishing else 0

    def searches(self, problem: MotionProblem) -> list[Search]:
        if self.repeats < 1:
            raise InputError(f"repeats must be at least 1, got {self.repeats}")
        if self.seed < 0:
            raise InputError(f"seed must be a whole number >= 0, got {self.seed}")
        algorithm = configure(self.method, **self.settings)
        stops = [] if self.target is None else [Target(self.target)]
        budget = self.budget - self.polish_budget() if self.budget > 0 else self.budget
        return [
            Search(problem.space, algorithm, budget=budget, seed=s, stops=stops)
            for s in SeedSequence(self.seed).spawn(self.repeats)
        ]


def _run(problem: MotionProblem, searches: Sequence[Search], look: Look | None) -> bool:
    """Advance all searches together until they have ended; True if somebody interrupted them."""
    try:
        while live := [s for s in searches if s.ended is None]:
            asked = [s.ask() for s in live]
            costs = problem(np.concatenate(asked))
            cuts = np.cumsum([len(a) for a in asked])[:-1]
            for search, part in zip(live, np.split(costs, cuts), strict=True):
                search.tell(part)
            if look is not None:
                look(searches)
    except KeyboardInterrupt:
        if not all(len(s.trace) for s in searches):
            raise
        return True
    return False


def _conclude(
    problem: MotionProblem,
    plan: _Plan,
    searches: Sequence[Search],
    tests: Sequence[tuple[Range, list[Stretch]]],
    trained: Sequence[Range],
    logs: Sequence[Recording],
    interrupted: bool,
) -> Fit:
    runs = [s.run() for s in searches]
    if not np.isfinite(min(r.cost for r in runs)):
        raise InputError(
            f"no parameter set in the search ranges could be simulated with law "
            f"{problem.parameters.law.name}: check the ranges and the rig's constants"
        )
    allowance = 0 if interrupted else plan.polish_budget()
    done: list[Polished] = []
    try:
        done += (polish_run(problem, r, allowance) for r in runs)
    except KeyboardInterrupt:
        interrupted = True
        done += (polish_run(problem, r, 0) for r in runs[len(done) :])
    order = sorted(range(len(runs)), key=lambda k: done[k].cost)
    runs, done = [runs[k] for k in order], [done[k] for k in order]
    best = done[0]
    made = problem.parameters
    p = made.full(best.x[None])[0]
    errors, correlation = standard_errors(problem, best.x)
    rivals = [d.x for d in done if d.cost <= RIVAL * best.cost]
    spread = np.std(rivals, axis=0, ddof=1) if len(rivals) > 1 else np.full(len(best.x), np.nan)
    found = estimates(made, p, errors, spread, correlation)
    score = scores(made, p, problem.train)
    tested = tuple(held_out(made, p, r, s) for r, s in tests)
    return Fit(
        parameters=made,
        p=p,
        estimates=found,
        correlation=correlation,
        score=score,
        holdout=tested,
        runs=tuple(runs),
        polished=tuple(done),
        method=plan.method,
        seed=plan.seed,
        evaluations=sum(r.evaluations for r in runs) + sum(d.evaluations for d in done),
        seconds=max(r.seconds for r in runs),
        ended="interrupted" if interrupted else runs[0].ended,
        train=problem.train,
        train_ranges=tuple(trained),
        recordings=tuple(logs),
        warnings=tuple(
            _warnings(made, found, correlation, score, problem.train, tests, logs, interrupted)
        ),
    )


def _warnings(
    made: Parameters,
    found: Sequence[Estimate],
    correlation: Array,
    score: Score,
    train: Sequence[Stretch],
    tests: Sequence[tuple[Range, list[Stretch]]],
    logs: Sequence[Recording],
    interrupted: bool,
) -> list[str]:
    said = []
    if interrupted:
        said.append("interrupted: the search or its polishing had not ended")
    said += bound_warnings(found)
    said += correlation_warnings(made, correlation)
    if score.value > 0.5 * score.smooth:
        said.append(
            f"the model explains little: J is {score.value:.3g} {score.unit}, a smooth motion "
            f"without stick-slip has {score.smooth:.3g} {score.unit}"
        )
    seen = {s.direction for s in train}
    for within, held in tests:
        if any(_overlap(a, b) for a in held for b in train):
            said.append(
                f"hold-out {within.text} overlaps the training data: there its error says "
                "nothing about new data"
            )
        if not made.law.directional and {s.direction for s in held} - seen:
            said.append(f"hold-out {within.text} runs in a direction that was not trained on")
    if not made.law.directional and len(seen) > 1:
        said.append(
            "both directions share one parameter set: use the law "
            f"{made.law.name}-directional, or train on one direction"
        )
    said += [f"{log.label}: {note}" for log in logs for note in log.notes]
    return said


def _overlap(a: Stretch, b: Stretch) -> bool:
    """Whether two stretches share samples."""
    shared = min(a.rows.stop, b.rows.stop) - max(a.rows.start, b.rows.start)
    return a.recording is b.recording and shared > 0
