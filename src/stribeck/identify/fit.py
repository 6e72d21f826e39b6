"""From recordings to a fitted law: split, search, polish, look back, say what was found."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.random import SeedSequence

from ..data.segmentation import noise, segment, step
from ..errors import InputError
from ..friction import LAWS, Law
from ..optimize import Algorithm, MemeticTabuSearch, Search, Target, configure, steps
from ..rig import Rig
from ..rig.simulated import SimulatedRig, as_simulated
from ..space import Array
from ..units import unit
from .balance.balanced_fit import balanced
from .initial_state import FreeStartProblem, free_starts, started_at_each
from .lookup import range_list, ranges_or_all, recording_list, rig_and_law
from .loss import Loss, Objective
from .parameters import Parameters, partition
from .polish import Polished, polish, polish_run
from .problem import MotionProblem
from .result import Fit
from .score import Score, held_out, scores
from .segment import Segment, segments
from .sliding_check import mark_never_slid, never_slid
from .uncertainty.estimates import (
    Estimate,
    bound_warnings,
    correlation_warnings,
    estimates,
    resting,
)
from .uncertainty.sensor_noise import rest_noise
from .uncertainty.uncertainty import Uncertainty, uncertainty

if TYPE_CHECKING:
    from ..data.ranges import Range
    from ..data.recording import Recording

#: Evaluations a repeat may spend unless told otherwise, and what polishing may take of them: a
#: quarter at most.
BUDGET, POLISH = 8_000, 2_400
REPEATS = 3
#: Rows that profiles may evaluate: half as many as the search did, so that where a motion takes
#: long to simulate the intervals do not take longer than the answer, and at least so many for each
#: parameter; but never more than the first.
PROFILES, PROFILED = 6_000, 400
#: Evaluations a parameter after which `mbts` has settled, if they brought nothing better: in
#: stick-slip, where a misfit has many basins, and where motions are smooth.
SETTLE, SETTLE_SMOOTH = 200, 60
#: Fewer slips a log are no stick-slip.
SLIPS = 5
#: A repeat whose J is within this factor of the best explains the data as well for all we know.
RIVAL = 1.1
#: A misfit above this share of the best smooth motion's explains little.
LITTLE = 0.5
#: A misfit above this many times the sensor's own noise leaves something unexplained.
NOISY = 1.5
#: Stopping rule of the paper (section 4.4): J < 4.5 mm or 1000 rounds.
PAPER_TARGET = 4.5

Progress = Callable[[Sequence[Search]], None]


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
    polishing: bool | None = None,
    settings: Mapping[str, Any] | None = None,
    loss: Loss = "squares",
    restart: bool = False,
    draws: int = 0,
    progress: Progress | None = None,
) -> Fit:
    """Identify the friction of an axis.

    On a rig of the simulation road (`slide-bed`) repeats of a search run in lockstep on the
    output error J (4.5), and least squares polishes each answer of a method that does not do so
    itself. On the inverse road (`emps`, `forced`) the force balance is solved by least squares,
    which leaves nothing to search: `method`, `seed`, `budget`, `repeats` and `target` do not apply
    there.

    Args:
        recordings: One or several logs of the axis.
        rig: A rig or its name.
        law: A law or its name; by default the rig's first.
        method: A search method; `mbts` by default. It ends by itself once it has settled.
        train: Ranges to train on; everything by default.
        holdout: Ranges to validate on.
        fixed: Parameters to hold, in the units the rig shows.
        bounds: Search ranges that replace the rig's, in the units the rig shows.
        tied: Parameters that equal others.
        seed: Seed of all repeats; 0 by default.
        budget: Evaluations of the cost for each repeat, polishing included; 8,000 by default.
            `mbts` settles sooner, as a rule.
        repeats: Independent searches; 3 by default.
        target: Stop a search at this J, in the unit in which the rig shows positions.
        polishing: Whether least squares polishes what a search found; by default it does, but for
            `mbts`, which does that itself.
        settings: Settings of the search method.
        loss: `squares` of the position errors, or their `absolute` size; see `Objective`.
        restart: Whether the simulation starts anew at every rest; see `Objective`.
        draws: Data sets of a block bootstrap of the residuals, whose intervals then stand beside
            those of the profiles; none by default, 200 are usual.
        progress: Called with the searches after every step.

    Raises:
        InputError: something asked for cannot be done with these recordings.
    """
    rig, law = rig_and_law(rig, law)
    logs = recording_list(recordings)
    objective = Objective(loss, restart)
    parameters = partition(rig, law, fixed=fixed, bounds=bounds, tied=tied, objective=objective)
    trained, held = range_list(train, rig), range_list(holdout, rig)
    if rig.approach == "force_balance":
        asked = {
            "method": method,
            "seed": seed,
            "budget": budget,
            "repeats": repeats,
            "target": target,
            "polishing": polishing,
            "settings": settings or None,
            "loss": None if loss == "squares" else loss,
            "restart": restart or None,
        }
        if idle := [name for name, value in asked.items() if value is not None]:
            raise InputError(
                f"rig {rig.name} is solved by least squares, without a search: "
                f"{', '.join(idle)} does not apply"
            )
        return balanced(parameters, logs, trained, held, draws=draws)
    rig = as_simulated(rig)
    train_on = [
        s for r in ranges_or_all(train, rig) for s in segments(logs, rig, r, restart=restart)
    ]
    tests = [(r, segments(logs, rig, r, restart=restart)) for r in held]
    _check_used(logs, rig, [train_on, *(part for _, part in tests)], [*trained, *held])
    problem = MotionProblem(parameters, train_on)
    plan = _Plan(
        method or MemeticTabuSearch.name,
        dict(settings or {}),
        0 if seed is None else seed,
        BUDGET if budget is None else budget,
        REPEATS if repeats is None else repeats,
        target,
        polishing,
        draws,
    )
    began = time.perf_counter()
    searches = plan.searches(problem)
    interrupted = _run(problem, searches, progress)
    return _conclude(problem, plan, searches, tests, trained, logs, began, interrupted)


def _check_used(
    logs: Sequence[Recording],
    rig: SimulatedRig,
    seen: Sequence[Sequence[Segment]],
    given: list[Range],
) -> None:
    """Every log has a segment that counts: what is passed over in silence is not missed."""
    for log in logs:
        if not any(s.recording is log for part in seen for s in part):
            wanted: list[Range | None] = [*given] or [None]
            for within in wanted:
                segments([log], rig, within)  # says why not


@dataclass(frozen=True)
class _Plan:
    """How the searches are run."""

    method: str
    settings: dict[str, Any]
    seed: int
    budget: int
    repeats: int
    target: float | None
    polishing: bool | None
    draws: int

    def algorithm(self, problem: MotionProblem) -> Algorithm:
        settle = SETTLE if _slips(problem) else SETTLE_SMOOTH
        own = {"settle": settle} if self.method == MemeticTabuSearch.name else {}
        return configure(self.method, **own | self.settings)

    def polish_budget(self) -> int:
        itself = self.polishing is None and self.method == MemeticTabuSearch.name
        return 0 if itself or self.polishing is False else min(POLISH, self.budget // 4)

    def searches(self, problem: MotionProblem) -> list[Search]:
        for name, least in (("budget", 1), ("repeats", 1), ("seed", 0), ("draws", 0)):
            value = getattr(self, name)
            if not isinstance(value, Integral) or value < least:
                raise InputError(f"{name} must be a whole number >= {least}, got {value!r}")
        algorithm = self.algorithm(problem)
        stops = [] if self.target is None else [Target(self.target)]
        budget = self.budget - self.polish_budget()
        return [
            Search(problem.space, algorithm, budget=budget, seed=s, stops=stops)
            for s in SeedSequence(self.seed).spawn(self.repeats)
        ]


def _slips(problem: MotionProblem) -> bool:
    """Whether the axis sticks and slips in what is trained on, or elements of its law do."""
    if free_starts(problem) or problem.parameters.law.states > 1:
        return True
    logs = {id(s.recording): s.recording for s in problem.train}
    slips = {key: segment(log).slips for key, log in logs.items()}
    inside = (
        s.rows.start <= slip.start and slip.stop <= s.rows.stop
        for s in problem.train
        for slip in slips[id(s.recording)]
    )
    return bool(sum(inside) >= SLIPS * len(logs))


def _run(problem: MotionProblem, searches: Sequence[Search], progress: Progress | None) -> bool:
    """Advance all searches together until they have ended; True if somebody interrupted them."""
    try:
        for _ in steps(problem, searches):
            if progress is not None:
                progress(searches)
    except KeyboardInterrupt:
        if not all(len(s.trace) for s in searches):
            raise
        return True
    return False


def _conclude(
    problem: MotionProblem,
    plan: _Plan,
    searches: Sequence[Search],
    tests: Sequence[tuple[Range, list[Segment]]],
    trained: Sequence[Range],
    logs: Sequence[Recording],
    began: float,
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
    seconds = time.perf_counter() - began
    order = sorted(range(len(runs)), key=lambda k: done[k].cost)
    runs, done = [runs[k] for k in order], [done[k] for k in order]
    best = done[0]
    parameters = problem.parameters
    if loss_is_bent := parameters.objective.loss == "absolute" and not interrupted:
        problem = problem.finer()
    try:
        spent = sum(r.evaluations for r in runs) + sum(d.evaluations for d in done)
        left = 0 if interrupted else plan.budget * plan.repeats - spent
        if loss_is_bent and plan.polishing is not False and left > 1:
            near = polish(problem, best.x, float(problem(best.x[None])[0]), min(left, POLISH) - 1)
            best = Polished(near.x, near.cost, best.evaluations + near.evaluations + 1)
            left -= near.evaluations + 1
        begun = _begun(problem, plan, best, min(left, POLISH))
    except KeyboardInterrupt:
        begun, interrupted = None, True
    free = len(best.x)
    on = problem if begun is None else begun[0]
    evaluations = sum(r.evaluations for r in runs) + sum(
        d.evaluations for d in (best, *done[1:], *(begun or ())[1:])
    )
    budget = min(PROFILES, max(evaluations // 2, PROFILED * on.space.dim))
    start = best.x if begun is None else begun[1].x
    known, interrupted = _known(on, start, free, plan, budget, interrupted)
    x, correlation = known.x, known.correlation[:free, :free]
    train = problem.train if begun is None else started_at_each(problem.train, x[free:])
    p = parameters.full(x[None, :free])[0]
    rivals = [d.x for d in done if d.cost <= RIVAL * done[0].cost]
    spread = np.std(rivals, axis=0, ddof=1) if len(rivals) > 1 else np.full(len(best.x), np.nan)
    score = scores(parameters, p, train)
    doubtful = _explains_little(parameters, score)
    found = estimates(parameters, p, known, spread, resting=resting(on, x), doubtful=doubtful)
    found = mark_never_slid(parameters, found, _recordings(train))
    tested = tuple(held_out(parameters, p, r, s) for r, s in tests)
    return Fit(
        parameters=parameters,
        p=p,
        estimates=found,
        correlation=correlation,
        score=score,
        holdout=tested,
        runs=tuple(runs),
        polished=tuple(done),
        method=plan.method,
        seed=plan.seed,
        evaluations=evaluations,
        seconds=seconds,
        ended="interrupted" if interrupted else runs[0].ended,
        train=train,
        train_ranges=tuple(trained),
        recordings=tuple(logs),
        warnings=(
            *_warnings(
                parameters,
                found,
                correlation,
                score,
                problem.train,
                tests,
                logs,
                len(rivals),
                len(runs),
                interrupted,
            ),
            *known.notes(parameters),
        ),
        known=known,
        residuals=on,
    )


def _known(
    on: MotionProblem | FreeStartProblem,
    x: Array,
    free: int,
    plan: _Plan,
    budget: int,
    interrupted: bool,
) -> tuple[Uncertainty, bool]:
    """How well the first `free` parameters are known, and whether somebody would not wait.

    Then it is a quick look.
    """
    quick, keep = 4 * len(x), plan.polishing is False
    if not interrupted:
        try:
            seen = uncertainty(
                on, x, among=free, budget=budget, keep=keep, draws=plan.draws, seed=plan.seed
            )
        except KeyboardInterrupt:
            pass
        else:
            return seen, False
    return uncertainty(on, x, among=free, budget=quick, keep=True), True


def _begun(
    problem: MotionProblem, plan: _Plan, best: Polished, allowance: int
) -> tuple[FreeStartProblem, Polished] | None:
    """The best fit refined with the starts of its motions free, where they matter."""
    if not free_starts(problem) or plan.polishing is False or allowance < 1:
        return None
    started = FreeStartProblem(problem)
    x = np.concatenate([best.x, started.nominal])
    found = polish(started, x, float(started(x[None])[0]), allowance - 1)
    return started, Polished(found.x, found.cost, found.evaluations + 1)


def _resting(score: Score, floor: float) -> list[str]:
    if score.still > NOISY * floor:
        return []
    told = "the axis hardly moves in what was trained on: that supports nothing"
    return [f"{told}, train on a range in which it moves"]


def _recordings(train: Sequence[Segment]) -> list[Recording]:
    """The recordings that segments come from, each once."""
    return list({id(s.recording): s.recording for s in train}.values())


def _explains_little(parameters: Parameters, score: Score) -> bool:
    """Whether a smooth motion, or none where each segment is a slip, does nearly as well."""
    beside = score.still if parameters.objective.restart else score.smooth
    return score.value >= LITTLE * beside


def _noise_floor(rig: Rig, logs: Sequence[Recording]) -> float:
    """What the sensors alone leave of J: noise and quantisation, in the unit of J.

    Rests show it as it is; elsewhere it is taken from the third differences of the motion.
    """
    floors = [np.hypot(noise(log), step(log.position) / np.sqrt(12)) for log in logs]
    floors += [sd for log in logs if np.isfinite(sd := rest_noise([log]))]
    return float(unit(rig.shows.get("position", "m")).from_si(max(floors)))


def _warnings(
    parameters: Parameters,
    found: Sequence[Estimate],
    correlation: Array,
    score: Score,
    train: Sequence[Segment],
    tests: Sequence[tuple[Range, list[Segment]]],
    logs: Sequence[Recording],
    rivals: int,
    repeats: int,
    interrupted: bool,
) -> list[str]:
    said = []
    if interrupted:
        said.append("interrupted: the search, its polishing or its intervals had not ended")
    said += bound_warnings(found)
    said += correlation_warnings(parameters, correlation)
    said += never_slid(parameters, _recordings(train))
    floor = _noise_floor(parameters.rig, logs)
    said += _resting(score, floor)
    if _explains_little(parameters, score):
        said.append(
            f"the model explains little: J is {score.value:.3g} {score.unit}, a smooth motion "
            f"without stick-slip has {score.smooth:.3g} {score.unit}: raise --repeats, "
            "widen the ranges, or check the rig's constants and the units of the log"
        )
    elif score.value > NOISY * floor:
        said.append(
            f"J is {score.value / floor:.2g} times the noise of the sensor ({floor:.3g} "
            f"{score.unit}): the search has not found the best fit, or the rig leaves something out"
        )
    if rivals < 2 <= repeats:  # noqa: PLR2004 - an answer found once is not confirmed
        said.append(
            f"only 1 of {repeats} repeats came within {RIVAL - 1:.0%} of the best J: the answer is "
            "not confirmed; raise --repeats"
        )
    seen = {s.direction for s in train}
    rig = as_simulated(parameters.rig)
    one_way = rig.from_rest and not parameters.law.directional
    for within, held in tests:
        if any(_overlap(a, b) for a in held for b in train):
            said.append(
                f"hold-out {within.text} overlaps the training data: there its error says "
                "nothing about new data"
            )
        if one_way and {s.direction for s in held} - seen:
            said.append(f"hold-out {within.text} runs in a direction that was not trained on")
    if one_way and len(seen) > 1 and f"{parameters.law.name}-directional" in LAWS:
        said.append(
            "both directions share one parameter set: use the law "
            f"{parameters.law.name}-directional, or train on one direction"
        )
    if rig.scale:
        said.append(
            f"forces, masses and stiffnesses are in proportion to {rig.scale}: if those are "
            "10 % off, so are all of these, and no motion would show it"
        )
    said += [f"{log.label}: {note}" for log in logs for note in log.notes]
    return said


def _overlap(a: Segment, b: Segment) -> bool:
    """Whether two segments share samples."""
    shared = min(a.rows.stop, b.rows.stop) - max(a.rows.start, b.rows.start)
    return a.recording is b.recording and shared > 0
