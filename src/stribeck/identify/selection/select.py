"""Which law the data support: laws from the simplest up, trained alike and compared on new data.

A richer law trains at least as well as one that it contains; that says nothing. So each is held
against data that it was not trained on, and the simplest is taken whose error there is not worse
than the best's: by a paired test over blocks (`paired`), and by more than 1 %, so that a
difference too small to matter decides nothing. The laws are tested in their order, the simplest
first, up to the first that passes: so many laws err no more often than one test, nominally
(Westfall and Krishen 2001, doi 10.1016/S0378-3758(01)00077-5).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from typing import TYPE_CHECKING, Any

import numpy as np

from ...constant import Stated
from ...data.alignment import Delay, checked_delay
from ...data.log_list import Columns, Logs
from ...errors import InputError
from ...friction import Law
from ...optimize import Search
from ...presenters import presenter
from ...rig import Rig
from ...rig.balanced import as_balanced
from ...rig.lookup import rig_and_law
from ..balance.one_way import without_offset
from ..balance.run_balance import weighted, without_mass
from ..balance.synchronisation import synchronised
from ..balance.velocity_source import VelocitySource, with_velocity
from ..data_split import DataSplit, data_split, log_notes, recording_list, steady_tables
from ..loss import Loss
from ..own_breakaway import breakaway_columns
from ..parameters import Parameters
from ..result import Fit
from ..slip_by_slip import by_slip_where_needed
from .candidate import Candidate
from .candidate_fit import candidate_fit, unidentified
from .findings import Finding, findings, sentences
from .folds import Splits, directions, splits
from .free_curve import FreeCurve, free_curve
from .friction_change import friction_change
from .laws_asked import checked_comparison, law_parameters
from .nesting import ingredients
from .paired_test import Paired, criteria, paired, whiteness
from .trained_law import (
    BUDGET,
    HeldOutErrors,
    TrainedLaw,
    TrainingSettings,
    held_out_errors,
    train_law,
)

if TYPE_CHECKING:
    from ...data.ranges import Range

FOLDS = 5
#: Directions in words.
WAYS = {1: "to greater positions", -1: "to smaller positions"}

#: Told what is being done, with the searches after every step, or none elsewhere.
Progress = Callable[[str, Sequence[Search]], None]


@dataclass(frozen=True, eq=False)
class Selection:
    """Laws compared on what was held out.

    Args:
        rig: The axis.
        candidates: The laws, the simplest first.
        chosen: Which of them is recommended.
        best: Which has the least held-out error.
        splits: What was held out.
        blocks: How many blocks the comparisons rest on at least.
        effective: Training samples in effect, for the criteria.
        findings: Which ingredients are warranted.
        sentences: What a reader must know, a sentence each; the recommendation first.
        unit: Of the errors.
        seed: Of the searches; None by force balance.
        skipped: Laws that an interruption left out.
        excluded: Laws with parameters for each direction, where the logs run one way.
        curve: The free curve that the recommended law is held against; None where it has none.
        interrupted: Whether Ctrl-C came.
        notes: How the logs were read and what was mended in them, a sentence each.
    """

    rig: Rig
    candidates: tuple[Candidate, ...]
    chosen: int
    best: int
    splits: Splits
    blocks: int
    effective: float
    findings: tuple[Finding, ...]
    sentences: tuple[str, ...]
    unit: str
    seed: int | None
    skipped: tuple[str, ...]
    excluded: tuple[str, ...]
    curve: FreeCurve | None = None
    interrupted: bool = False
    notes: tuple[str, ...] = ()

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
            KeyError: it is not among them.
        """
        for candidate in self.candidates:
            if candidate.name == name:
                return candidate
        raise KeyError(name)

    def __repr__(self) -> str:
        laws = ", ".join(f"{c.name} {c.held:.4g}" for c in self.candidates)
        return f"<Selection of {self.law} on {self.rig.name}; held out, {self.unit}: {laws}>"

    def _repr_html_(self) -> str:
        return str(presenter("selection_html")(self))


def select(
    logs: Logs,
    *,
    rig: str | Rig,
    laws: Sequence[str | Law] | None = None,
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    subtract: str | None = None,
    constants: Mapping[str, Stated] | None = None,
    exact: bool = False,
    train: Sequence[Range | str] | Range | str | None = None,
    holdout: Sequence[Range | str] | Range | str | None = None,
    test: Logs | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    seed: int | None = None,
    budget: int | None = None,
    folds: int | None = None,
    loss: Loss = "squares",
    delay: Delay = "auto",
    velocity: VelocitySource = "auto",
    progress: Progress | None = None,
) -> Selection:
    """Fit several laws and recommend the simplest that the data support.

    Each law starts from the simpler ones' answers as well as from a search of its own. Where
    nothing is given to be held out, logs are held out in turn, or whole strokes or parts of them
    where there are fewer than three logs, and every law is fitted anew in each round.

    Args:
        logs: Logs to train on, as `identify` takes them.
        rig: A rig or its name.
        laws: Laws or their names; by default those that the rig was made for.
        units: Unit by column, as for `identify`.
        columns: Column by channel, as for `identify`.
        subtract: As for `identify`.
        constants: Constants of the rig that are this axis's, as for `identify`.
        exact: Whether the other constants are this axis's, too, without a tolerance.
        train: Ranges to train on; everything by default.
        holdout: Ranges to hold out; they must not overlap what is trained on.
        test: Other logs to hold out as a whole.
        fixed: Parameters to hold in every law that has them, in the units the rig shows.
        bounds: Search ranges in every law that has them, in the units the rig shows.
        seed: Of the searches; 0 by default.
        budget: Evaluations of one fit; 4,000 by default. A search settles sooner, as a rule.
        folds: Rounds, where nothing is given to be held out; 5 by default.
        loss: `squares` of the position errors, or their `absolute` size; see `Objective`.
        delay: Of the force after the motion, as for `identify`; the richest law finds it.
        velocity: Of a force balance, as for `identify`; the richest law chooses it.
        progress: Called with what is being done and the searches, after every step.

    Raises:
        InputError: something asked for cannot be done with these recordings.
    """
    axis, _ = rig_and_law(rig, None, constants, exact=exact)
    asked: dict[str, Any] = {"laws": laws, "fixed": fixed, "bounds": bounds, "loss": loss}
    checked_comparison(
        axis, **asked, seed=seed, budget=budget, folds=folds, delay=delay, velocity=velocity
    )
    given: dict[str, Any] = {"units": units, "columns": columns, "subtract": subtract}
    trained = recording_list(logs, axis, **given)
    tests = [] if test is None else recording_list(test, axis, **given)
    data = data_split(trained, train, holdout, axis)
    steady = steady_tables([*trained, *tests], data.ranges, delay, velocity)
    axis = axis.behind([*trained, *tests])
    parameter_sets = law_parameters(axis, **asked)
    simulated = axis.approach == "output_error"
    parameter_sets, data, velocity_read = _prepared(
        parameter_sets, data, delay, velocity, steady=steady
    )
    axis = parameter_sets[0].rig
    trained, tests = list(data.recordings), [axis.in_step(log, data.delay) for log in tests]
    if folds is not None and (data.holdout or tests):
        raise InputError("folds are for data of which nothing was held out: leave them away")
    count = FOLDS if folds is None else folds
    rounds = splits(trained, axis, data.train, data.holdout, tests, count)
    parameter_sets, excluded = _answerable(parameter_sets, rounds)
    if steady:  # all laws count runs alike: by their errors, and by what they scatter beside
        trained, _ = weighted(parameter_sets[-1], trained)
        rounds = splits(trained, axis, (), (), tests, count)
    conditions = (*velocity_read.sentences, *_one_breakaway(parameter_sets, data))
    training = _Training(rounds, data, 0 if seed is None else seed, budget or BUDGET, progress)
    interrupted = False
    for parameters in parameter_sets:
        try:
            training.add(parameters)
        except KeyboardInterrupt:
            if not training.laws:
                raise
            interrupted = True
            break
    names = [p.law.name for p in parameter_sets]
    compared = partial(_compared, axis, training, names, excluded, simulated=simulated)
    try:
        selection = compared()
    except KeyboardInterrupt:  # short beside the training: from its start, and to its end
        selection, interrupted = compared(), True
    told = (*selection.sentences, *conditions)
    notes = log_notes([*trained, *tests])
    return replace(selection, sentences=told, interrupted=interrupted, notes=notes)


@dataclass(frozen=True)
class _Velocity:
    """Which velocity all laws read, and what is told of it."""

    source: VelocitySource
    sentences: tuple[str, ...] = ()


def _prepared(
    parameter_sets: list[Parameters],
    data: DataSplit,
    delay: Delay,
    velocity: VelocitySource,
    *,
    steady: bool,
) -> tuple[list[Parameters], DataSplit, _Velocity]:
    """Laws and logs with one velocity and at one time; tables of steady speeds have neither."""
    if steady:
        return [without_mass(p) for p in parameter_sets], data, _Velocity("position")
    parameter_sets, velocity_read = _with_velocity(parameter_sets, data, velocity)
    synchronous = _synchronised(parameter_sets[-1], data, delay, velocity_read.source)
    return parameter_sets, synchronous, velocity_read


def _with_velocity(
    parameter_sets: list[Parameters], data: DataSplit, velocity: VelocitySource
) -> tuple[list[Parameters], _Velocity]:
    """The laws on a rig that reads the velocity which the richest of them chooses.

    Raises:
        InputError: an unknown velocity, or one is asked for on a rig that is simulated.
    """
    richest = parameter_sets[-1]
    if richest.rig.approach == "output_error":
        return parameter_sets, _Velocity("position")
    chosen, violations = with_velocity(richest, data, velocity)
    source = as_balanced(chosen.rig).filtering.velocity
    on_rig = [replace(p, rig=as_balanced(p.rig).with_velocity(source)) for p in parameter_sets]
    return on_rig, _Velocity(source, tuple(f"{_capital(v.sentence)}." for v in violations))


def _capital(sentence: str) -> str:
    return sentence[:1].upper() + sentence[1:]


def _one_breakaway(parameter_sets: Sequence[Parameters], data: DataSplit) -> tuple[str, ...]:
    """A word on slips that `identify` takes one by one, where one breakaway is for all here."""
    level = next((p for p in parameter_sets if breakaway_columns(p.law) is not None), None)
    if level is None or level.rig.approach != "output_error":
        return ()
    auto = replace(level, objective=replace(level.objective, breakaway="auto"))
    _, seen = by_slip_where_needed(auto, data)
    if seen is None:
        return ()
    why = (
        f"Breakaway scatters by {seen.share:.0%} from slip to slip ({seen.slips} slips): identify "
        "gives each slip its own"
        if seen.evident
        else "The force of the log follows its reading: identify goes slip by slip, under the "
        "force that the controller held"
    )
    text = (
        f"{why}; here all laws have one breakaway for all, since those without F_S can "
        "have no other. No law then tells when a slip comes, and a "
        "drop may be missed."
    )
    return (text,)


def _synchronised(
    parameters: Parameters, data: DataSplit, delay: Delay, velocity: VelocitySource
) -> DataSplit:
    """The data with force and motion at one time."""
    said = checked_delay(delay)
    if parameters.rig.approach == "output_error":
        if isinstance(said, str):
            return data
        return replace(data.advanced(parameters.rig, said[0]), delay_known=said[1])
    return synchronised(parameters, data, delay, velocity=velocity).data


def _answerable(
    parameter_sets: list[Parameters], rounds: Splits
) -> tuple[list[Parameters], tuple[str, ...]]:
    """The laws that the training data can tell of, and the names of the others.

    Logs that run one way say nothing of parameters for the other way.

    Raises:
        InputError: no law is left.
    """
    ways = directions(rounds.whole)
    excluded = [p.law.name for p in parameter_sets if p.law.directional and len(ways) == 1]
    if excluded and len(excluded) == len(parameter_sets):
        raise InputError(
            f"the logs run {WAYS[min(ways)]} only, which says nothing of a law with parameters "
            f"for each direction: compare others than {', '.join(excluded)}, or record both ways"
        )
    left = [p for p in parameter_sets if p.law.name not in excluded]
    return [without_offset(p) for p in left] if len(ways) == 1 else left, tuple(excluded)


@dataclass(frozen=True, eq=False)
class _Trained:
    """A law trained on everything, with its errors on what was held out in all rounds."""

    main: TrainedLaw
    errors: HeldOutErrors
    unidentified: tuple[str, ...]
    conclude: Callable[[], Fit]
    seconds: float
    evaluations: int


class _Training:
    """The laws that are trained, in everything and in every round."""

    def __init__(
        self,
        rounds: Splits,
        data: DataSplit,
        seed: int,
        budget: int,
        progress: Progress | None,
    ) -> None:
        self.rounds, self.data, self.seed = rounds, data, seed
        self._budget, self._progress = budget, progress
        self.laws: list[_Trained] = []
        self._simpler: list[list[TrainedLaw]] = [[] for _ in (rounds.whole, *rounds.rounds)]

    def add(self, parameters: Parameters) -> None:
        """Train a law on everything and in every round, and measure its held-out errors."""
        name, rounds = parameters.law.name, self.rounds.rounds
        main = train_law(parameters, self.rounds.whole, self._simpler[0], self._settings(name))
        trained = [main]
        errors: list[HeldOutErrors] = []
        for k, split in enumerate(rounds, 1):
            law = main
            if self.rounds.kind != "hold-out":
                settings = self._settings(f"{name}, round {k} of {len(rounds)}")
                law = train_law(parameters, split.train, [*self._simpler[k], main], settings, k)
                trained.append(law)
            errors.append(held_out_errors(law, split.held))
        if self._progress is not None:
            self._progress(f"{name}, intervals", [])
        conclude = partial(candidate_fit, main, self.data, self.seed)
        if main.problem is None:  # the rest takes as long as the fit, and may wait
            missed = unidentified(main)
        else:
            fit = conclude()
            missed = tuple(e.name for e in fit.estimates if e.verdict == "not identifiable")
            conclude = partial(_same, fit)
        seconds, spent = sum(r.seconds for r in trained), sum(r.evaluations for r in trained)
        joined = reduce(HeldOutErrors.joined, errors)
        self.laws.append(_Trained(main, joined, missed, conclude, seconds, spent))
        for simpler, law in zip(self._simpler, trained, strict=False):
            simpler.append(law)

    def _settings(self, doing: str) -> TrainingSettings:
        progress = self._progress
        if progress is None:
            return TrainingSettings(self.seed, self._budget)
        progress(doing, [])
        return TrainingSettings(self.seed, self._budget, lambda searches: progress(doing, searches))


def _same(fit: Fit) -> Fit:
    return fit


def _compared(
    axis: Rig,
    training: _Training,
    names: Sequence[str],
    excluded: tuple[str, ...],
    *,
    simulated: bool,
) -> Selection:
    laws = [t.main for t in training.laws]
    errors = [t.errors.error for t in training.laws]
    if not np.isfinite(min(errors)):
        raise InputError("no law here can be simulated on what was held out")
    best = int(np.argmin(errors))
    residuals = [t.errors.residuals for t in training.laws]
    power = training.laws[0].errors.power

    def compare(i: int, j: int) -> Paired:
        change = friction_change(*sorted((laws[i], laws[j]), key=_free))
        return paired(residuals[i], residuals[j], power=power, friction=change)

    against = [compare(i, best) for i in range(len(laws))]
    rivals = [i for i in range(len(laws)) if i != best]
    worse = [i != best and against[i].worse for i in range(len(laws))]
    ruler = min(laws, key=lambda r: float(np.mean(r.residuals**2)))
    effective = len(ruler.residuals) / whiteness(ruler.residuals, ruler.logs).time
    candidates = [
        _candidate(t, effective, None if i == best else against[i], worse=worse[i])
        for i, t in enumerate(training.laws)
    ]
    able = [i for i in range(len(candidates)) if not worse[i]]
    chosen = min(
        able, key=lambda i: (candidates[i].free, len(candidates[i].unseen), candidates[i].held)
    )
    warranted = findings(
        [(c.name, c.free) for c in candidates],
        [c.ingredients for c in candidates],
        chosen,
        compare,
        [c.error for c in candidates],
        [c.range_ends for c in candidates],
    )
    skipped = tuple(names[len(candidates) :])
    curve = free_curve(laws[chosen])
    count = min((against[i].blocks for i in rivals), default=0)
    return Selection(
        rig=axis,
        candidates=tuple(candidates),
        chosen=chosen,
        best=best,
        splits=training.rounds,
        blocks=count,
        effective=effective,
        findings=warranted,
        sentences=(
            *sentences(
                candidates, chosen, best, warranted, count, skipped, _one_way(training, excluded)
            ),
            *(() if curve is None else (curve.sentence,)),
        ),
        curve=curve,
        unit=laws[0].unit,
        seed=training.seed if simulated else None,
        skipped=skipped,
        excluded=excluded,
    )


def _free(law: TrainedLaw) -> int:
    return len(law.parameters.free)


def _one_way(training: _Training, excluded: Sequence[str]) -> str:
    """What cannot be compared where the logs run one way; empty if nothing is left out."""
    if not excluded:
        return ""
    way = WAYS[min(directions(training.rounds.whole))]
    return (
        f"Whether friction differs between directions cannot be asked: the logs run {way} only. "
        f"Not fitted: {', '.join(excluded)}."
    )


def _candidate(
    trained: _Trained, effective: float, against: Paired | None, *, worse: bool
) -> Candidate:
    law = trained.main
    free = law.parameters.free
    return Candidate(
        parameters=law.parameters,
        error=law.error,
        held=trained.errors.error,
        criteria=criteria(float(np.mean(law.residuals**2)), len(free), effective),
        white=whiteness(law.residuals, law.logs),
        unseen=trained.unidentified,
        against=against,
        worse=worse,
        range_ends={law.parameters.rig.label(n): end for n, end in law.range_ends.items()},
        ingredients=ingredients(law.parameters.law, [q.name for q in free]),
        evaluations=trained.evaluations,
        seconds=trained.seconds,
        conclude=trained.conclude,
    )
