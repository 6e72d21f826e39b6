"""A plan: candidate experiments ranked by how far they shrink the errors of doubtful parameters.

The data at hand and each candidate have a Fisher information, at the fit and at further parameter
sets that the data allow. Their sum gives the standard errors to be expected; the search ranges
count as what was known before any data. Noise is as the fit left it, as correlated as that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...data.log_list import Columns, Logs
from ...errors import InputError
from ...presenters import presenter
from ...space import Array
from ...wording import option
from ..card import Card, card_of
from ..card_logs import logs_beside
from ..data_split import log_notes, recording_list, refuse_runs
from ..result import Fit
from ..uncertainty.covariance import HALF_WIDTH
from ..uncertainty.verdict import IDENTIFIED
from .current_model import CurrentModel, current_model
from .expected_information import TwinStudy, twin_study
from .experiment import Experiment, covariance, draws, factors, information_at
from .proposals import Refusals, proposals

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ..card import ParameterCard

#: Parameter sets at which each experiment is looked at.
DRAWS = 9
#: Seconds that a candidate takes at most unless told otherwise.
LONGEST = 120.0
#: Candidates whose promise is checked.
CHECKED = 3
#: A force gauge, by hand, is good to this share.
GAUGE = 0.02
#: How much less noise a finer sensor has, and how much faster a faster one is.
FINER, FASTER = 3.0, 4.0
#: A parameter is said to help others where their errors shrink by this factor once it is known; of
#: a factor above the second no more is told.
HELPED, MOST_TOLD = 2.0, 10.0
#: No share of a variance that is left is less.
_LEAST = 1e-12
#: An uncertainty above this many times a value is no figure to print.
MUCH = 3.0
#: A misfit above this share of that of doing without the model explains little.
LITTLE = 0.5
#: Verdicts of parameters that a plan is for.
DOUBTFUL = ("weak", "not identifiable")


@dataclass(frozen=True)
class Gain:
    """What an experiment does to the interval of one parameter.

    Args:
        name: Of the parameter, as its rig calls it.
        factor: By what factor its half-width shrinks.
        low: Where its interval is expected to begin, in the unit of the card.
        high: Where it is expected to end.
        doubtful: Whether it is one of those that the plan is for.
    """

    name: str
    factor: float
    low: float
    high: float
    doubtful: bool


@dataclass(frozen=True, eq=False)
class Proposal:
    """An experiment with the information that it is expected to add.

    Args:
        experiment: The experiment.
        score: Geometric mean of the factors of the doubtful parameters.
        gains: One a free parameter.
        twin_study: Its check by twins; None where none was asked for.
    """

    experiment: Experiment
    score: float
    gains: tuple[Gain, ...]
    twin_study: TwinStudy | None = None


@dataclass(frozen=True, eq=False)
class Plan:
    """Experiments, the best first.

    Args:
        law: Name of the law.
        rig: Name of the rig.
        doubtful: Names of the parameters that the plan is for.
        cards: What the card says of each free parameter, by name.
        proposals: The experiments, the best first.
        left: What was left out, and why.
        said: What a reader must know, a sentence each.
        seconds: Length of each experiment.
        draws: Parameter sets at which each was looked at.
        seed: Of the draws and checks.
        interrupted: Whether Ctrl-C cut it short: what was finished is in it, `said` has the rest.
        notes: How the logs were read and what was mended in them, a sentence each.
    """

    law: str
    rig: str
    doubtful: tuple[str, ...]
    cards: dict[str, ParameterCard]
    proposals: tuple[Proposal, ...]
    left: tuple[tuple[str, str], ...]
    said: tuple[str, ...]
    seconds: float
    draws: int
    seed: int
    interrupted: bool = False
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        best = "; ".join(p.experiment.name for p in self.proposals[:3]) or "none"
        return f"<Plan of {self.law} on {self.rig} for {', '.join(self.doubtful)}; best: {best}>"

    def _repr_html_(self) -> str:
        return str(presenter("plan_html")(self))


def plan(
    model: Card | Fit | str | Path,
    logs: Logs | None = None,
    *,
    seconds: float | None = None,
    check: int = 0,
    seed: int = 0,
    count: int = DRAWS,
    units: Mapping[str, str] | None = None,
    columns: Columns = None,
    subtract: str | None = None,
) -> Plan:
    """Rank experiments by how much they would shrink the intervals of doubtful parameters.

    Args:
        model: A fit, its card, or the file of one.
        logs: The logs that it was identified on, as `identify` takes them; by default those that
            the fit has, or that lie beside the file.
        seconds: How long an experiment takes; as long as the data at hand by default, but no
            longer than two minutes.
        check: Twins on which the best three are tried out: simulated with noise and refitted.
        seed: Of the draws and of the twins.
        count: Parameter sets at which each experiment is looked at.
        units: Unit by column, as for `identify`.
        columns: Column by channel, as for `identify`.
        subtract: As for `identify`; by default what the card says.

    Raises:
        InputError: a card or logs that do not fit, nothing left to find, or a rig or law for
            which there are no experiments.
    """
    for name, value, least in (("check", check, 0), ("seed", seed, 0), ("draws", count, 1)):
        if value < least:
            raise InputError(f"{name} must be a whole number >= {least}, got {value}")
    card, recordings = _card_and_logs(model, logs, units, columns, subtract)
    refuse_runs(recordings, "a plan of experiments")
    current = current_model(card, recordings)
    axis = current.axis
    length = min(axis.trained, LONGEST) if seconds is None else seconds
    if not 0 < length < np.inf:
        raise InputError(f"seconds must be a number above 0, got {seconds}")
    refusals: Refusals = []
    offered = _candidates(current, length, refusals)
    rng = np.random.default_rng(seed)
    at, information = _draws(current, count, rng)
    share = length / axis.trained
    gained, left = _gained(current, offered, at, share)
    ranked = _ranked(current, offered, gained, information, refusals)
    chosen = _doubtful(current)
    for k, p in enumerate(ranked[: CHECKED if check and not left else 0]):
        try:
            study = _checked(current, p, at, share, offered[0], check, seed)
        except KeyboardInterrupt:
            names = ", ".join(p.experiment.name for p in ranked[k:CHECKED])
            left = f"interrupted: not tried on twins: {names}"
            break
        ranked[k] = replace(p, twin_study=study)
    motions = [F for e, F in zip(offered, gained, strict=False) if e.kind == "motion"]
    return Plan(
        card.law,
        card.rig,
        tuple(current.labels[i] for i in chosen),
        dict(zip(current.labels, current.cards, strict=True)),
        tuple(ranked),
        tuple(refusals),
        (*([left] if left else ()), *current.notes,
         *_incurable(current, information, motions, ranked)),
        length,
        count,
        seed,
        interrupted=bool(left),
        notes=log_notes(recordings),
    )  # fmt: skip


def _card_and_logs(
    model: Card | Fit | str | Path,
    logs: Logs | None,
    units: Mapping[str, str] | None,
    columns: Columns,
    subtract: str | None,
) -> tuple[Card, list[Recording]]:
    """The card of a model, and the logs that it was identified on."""
    card = card_of(model)
    rig = card.model()[0].rig
    given: dict[str, Any] = {"units": units, "columns": columns, "subtract": subtract}
    if logs is not None:
        return card, recording_list(logs, rig, **given)
    if isinstance(model, Fit):  # its logs have been moved in time already
        return card.model_copy(update={"force_delay_ms": 0.0}), list(model.recordings)
    if isinstance(model, str | Path):
        paths = logs_beside(card, Path(model))
        return card, recording_list(paths, rig, **given)
    raise InputError("a card does not know its logs: give them after it")


def _gained(
    current: CurrentModel, offered: Sequence[Experiment], at: Array, share: float
) -> tuple[list[Array], str]:
    """The information of each experiment, up to Ctrl-C; and what that has left out.

    Raises:
        KeyboardInterrupt: Ctrl-C came before the first was done.
    """
    gained: list[Array] = []
    try:
        for e in offered:
            weight = share if e is offered[0] else 1.0
            gained.append(weight * information_at(e, at, current.axis.box))
    except KeyboardInterrupt:
        if not gained:
            raise
        names = ", ".join(e.name for e in offered[len(gained) :])
        return gained, f"interrupted: not looked at, and not ranked: {names}"
    return gained, ""


def _ranked(
    current: CurrentModel,
    offered: Sequence[Experiment],
    gained: Sequence[Array],
    information: Array,
    refusals: Refusals,
) -> list[Proposal]:
    """The experiments whose information is known, the best first; those without are refused."""
    chosen = _doubtful(current)
    scored = []
    for e, F in zip(offered, gained, strict=False):
        shrunk = factors(information, F)
        if np.isfinite(shrunk).all():
            scored.append((_score(shrunk, chosen), e, shrunk))
        else:
            refusals.append((e.name, "the model cannot be simulated there"))
    scored.sort(key=lambda entry: -entry[0])
    return [Proposal(e, score, _gains(current, shrunk)) for score, e, shrunk in scored]


def _doubtful(current: CurrentModel) -> list[int]:
    """Places of the parameters that a plan is for: all of them where none is doubtful."""
    places = [i for i, c in enumerate(current.cards) if c.verdict in DOUBTFUL]
    return places or list(range(len(current.cards)))


def _score(shrunk: Array, chosen: Sequence[int]) -> float:
    return float(np.exp(np.mean(np.log(shrunk[list(chosen)]))))


def _gains(current: CurrentModel, shrunk: Array) -> tuple[Gain, ...]:
    chosen = _doubtful(current)
    return tuple(
        Gain(n, f, *current.ends(i, f), i in chosen)
        for i, (n, f) in enumerate(zip(current.labels, shrunk.tolist(), strict=True))
    )


def _draws(current: CurrentModel, count: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Parameter sets that the data allow, and the information of the data and ranges at each."""
    box, x = current.axis.box, current.axis.x
    prior = box.prior_information
    at_fit = information_at(current.data, x[None], box)[0]
    if not np.isfinite(at_fit).all():
        raise InputError("the model of the card cannot be simulated on these logs: check the card")
    C = covariance(at_fit, prior)
    widening = (
        current.half / HALF_WIDTH / np.sqrt(np.diag(C))
    )  # as wide as on the card, whatever slopes say
    at = draws(x, C * np.outer(widening, widening), count, box, rng)
    information = information_at(current.data, at, box) + prior
    runnable = np.isfinite(information).all(axis=(1, 2))
    return at[runnable], information[runnable]


def _candidates(current: CurrentModel, seconds: float, refusals: Refusals) -> list[Experiment]:
    """More of the same first, then what the rig can do, then better sensors."""
    axis = current.axis
    repetition = replace(
        current.data,
        name="the same again",
        words="what was recorded, once more"
        if seconds >= 0.99 * axis.trained
        else f"what was recorded, {seconds:.3g} s of it once more",
        seconds=seconds,
    )
    offered = proposals(axis, seconds, refusals)
    return [repetition, *offered, *_sensors(current, repetition), *_gauges(current)]


def _sensors(current: CurrentModel, repetition: Experiment) -> list[Experiment]:
    """The same again, seen better."""
    axis = current.axis
    finer = []
    if axis.sensor > 0.0:  # neither unknown nor that of a log without noise
        other_noise = max(axis.noise**2 - axis.sensor**2, 0.0)
        noise = np.sqrt(other_noise + (min(axis.sensor, axis.noise) / FINER) ** 2)
        words = (
            "the same again with a position sensor of a third of the noise, "
            f"{axis.shown.shown('position', axis.sensor / FINER)}"
        )
        finer.append(
            replace(repetition, name="finer sensor", words=words, noise=float(noise), kind="sensor")
        )
    faster = axis.repeated(axis.shown.interval / FASTER)
    words = (
        f"the same again with a position sensor that measures {FASTER:g} times as often, at "
        f"{FASTER / axis.shown.interval:.3g} Hz"
    )
    if current.simulated:
        inflation = faster / FASTER  # of the samples that there are
        finer.append(
            replace(
                repetition, name="faster sensor", words=words, inflation=inflation, kind="sensor"
            )
        )
    return finer


def _gauges(current: CurrentModel) -> list[Experiment]:
    """A breakaway force measured by hand."""
    axis = current.axis
    if not axis.parameters.rig.hand_gauge:
        return []
    names = [q.name for q in axis.parameters.free]
    at = [i for i, n in enumerate(names) if n.rstrip("+-") == "F_S"]
    if not at or not axis.x[at].all():
        return []
    noise = GAUGE * float(np.mean(axis.x[at]))

    def predict(x: Array) -> Array:
        forces: Array = x[:, at]
        return forces

    words = (
        "disconnect the drive and pull with a force gauge until the axis breaks away: F_S to "
        f"{100 * GAUGE:g} %"
    )
    plain = np.ones(len(axis.x))
    return [
        Experiment("force gauge", words, current.axis.trained, predict, noise, plain, kind="gauge")
    ]


def _checked(
    current: CurrentModel,
    proposal: Proposal,
    at: Array,
    share: float,
    repetition: Experiment,
    check: int,
    seed: int,
) -> TwinStudy:
    e = proposal.experiment
    if e.name == repetition.name:
        e = replace(e, noise=e.noise / np.sqrt(share))
    return twin_study(current.data, e, current.axis.box, at, check, seed)


def _incurable(
    current: CurrentModel,
    information: Array,
    motions: Sequence[Array],
    proposals: Sequence[Proposal],
) -> list[str]:
    """What no motion cures, and what would help."""
    axis, notes = current.axis, list[str]()
    everything = np.sum([np.where(np.isfinite(F), F, 0.0) for F in motions], axis=0)
    shrunk = factors(information, everything)
    reach = current.half / shrunk
    size = np.where(axis.box.log, 1.0, np.abs(axis.x))
    short = [i for i in _doubtful(current) if reach[i] > IDENTIFIED * size[i]]
    aided = []
    for i in short:
        aids = [
            (g.factor, p.experiment.name)
            for p in proposals
            if p.experiment.kind != "motion"
            for g in p.gains
            if g.name == current.labels[i] and g.factor > shrunk[i]
        ]
        if aids:
            aided.append(f"a {max(aids)[1]} does more for {current.labels[i]}")
    if short:
        known_to = ", ".join(
            f"{current.labels[i]} to ±{_share(reach[i], float(size[i]))}" for i in short
        )
        aids_text = "".join(f"; {text}" for text in aided)
        notes.append(
            f"all these motions together leave {known_to}: none of them cures that{aids_text}"
        )
    notes += [
        t
        for t in (
            _scale_warning(current, information),
            _bound_warning(current),
            _model_warning(current),
        )
        if t is not None
    ]
    return notes


def _share(reach: float, size: float) -> str:
    """An uncertainty as a share of a value."""
    return f"{100 * reach / size:.0f} %" if reach < MUCH * size else "much more than its value"


def _scale_warning(current: CurrentModel, information: Array) -> str | None:
    """Which force or stiffness would tell most of the others if it were known, where one does."""
    parameters = current.axis.parameters
    at = [i for i, q in enumerate(parameters.free) if q.unit.startswith("N")]
    if not parameters.rig.known_scale or not at:
        return None
    C = np.array([covariance(F) for F in information])
    known, helped = max(
        ((k, _shrunk_by(C, k)) for k in at), key=lambda entry: float(np.log(entry[1]).sum())
    )
    told = [i for i in np.argsort(-helped, kind="stable").tolist() if helped[i] >= HELPED]
    if not set(told) & set(at):
        return None
    shrinking = ", ".join(
        f"that of {current.labels[i]} "
        + ("more than tenfold" if helped[i] > MOST_TOLD else f"{helped[i]:.2g}-fold")
        for i in told
    )
    return (
        f"if {current.labels[known]} were known from elsewhere, errors would shrink: {shrinking}; "
        "as long as only positions are fitted, the rig's known gains and mass alone set the scale "
        "of forces: check them, or measure a force"
    )


def _shrunk_by(C: Array, known: int) -> Array:
    """By what factor each other's error shrinks once one is known; 1 of that, (dim,).

    Args:
        C: Covariances, (draws, dim, dim).
        known: The one.
    """
    variance = np.diagonal(C, axis1=1, axis2=2)
    shared = np.square(C[:, known]) / (variance * variance[:, known, None])
    shared[:, known] = 0.0
    factor: Array = np.median(1.0 / np.sqrt(np.maximum(1.0 - shared, _LEAST)), axis=0)
    return factor


def _bound_warning(current: CurrentModel) -> str | None:
    """Parameters that sit at the end of their range."""
    at = [n for n, c in zip(current.labels, current.cards, strict=True) if c.at_bound]
    if not at:
        return None
    return (
        f"{', '.join(at)} at an end of the search range: widen that ({option('bounds')}) and "
        "identify again before believing what is expected"
    )


def _model_warning(current: CurrentModel) -> str | None:
    """Whether the model holds at all: a plan for one that does not is a plan for another axis."""
    if current.explained <= LITTLE:
        return None
    return (
        "the model of the card explains little of its own data: what is expected here holds for "
        "an axis that behaves as the model; find a better model first"
    )
