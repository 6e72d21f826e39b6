"""The card of a fit: what was identified and what it rests on, in the units that people see."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, Literal

import numpy as np

from .._version import __version__
from ..data.readers.log_map import LogMap
from ..errors import InputError
from ..rig import Rig
from ..rig.balanced import BalancedRig
from ..rig.rig import shown_difference, shown_in
from ..rig.simulated import as_simulated
from ..units import unit
from .card import (
    BreakawayCard,
    Card,
    CombinationCard,
    ConditionCard,
    DataCard,
    HoldoutCard,
    LogSpreadCard,
    ObjectiveCard,
    PaceCard,
    ParameterCard,
    PosteriorCard,
    SampledCard,
    SearchCard,
    SpeedsCard,
    StaircaseCard,
    axis_table,
    constant_cards,
    kind_of,
    origin_of,
)
from .interval_ends import interval_ends
from .pace import paced
from .result import Fit
from .score import Score, simulated

#: Of what the intervals of a fit of a single log are.
ONE_LOG = "the intervals are of this log: what differs from log to log is not in them"


def fit_card(fit: Fit) -> Card:
    """The card of a fit.

    Raises:
        InputError: a misfit is not a finite number, so that there is nothing to believe.
    """
    parameters, score = fit.parameters, fit.score
    rig, law = parameters.rig, parameters.law
    for part in (score, *(h.score for h in fit.holdout)):
        if not math.isfinite(part.value):
            raise InputError(
                "the misfit is not a finite number: the log has no force to explain, or the "
                "model cannot be simulated on it"
            )
    kind = kind_of(rig)
    return Card(
        law=law.name,
        rig=rig.name,
        kind=kind,
        axis=axis_table(rig),
        constants=constant_cards(rig),
        stated=_stated(fit),
        columns=_columns(fit),
        drive=None if rig.chain is None else rig.chain.table(),
        parameters=_parameters(fit),
        combinations=_combinations(fit),
        breakaway=_breakaway(fit),
        between_logs=_between_logs(fit),
        scope=ONE_LOG if len(fit.recordings) == 1 else "",
        conditions=_conditions(fit),
        objective=ObjectiveCard(
            name=score.name,
            value=score.value,
            unit=score.unit,
            baselines=score.baselines(),
            samples=score.samples,
            restart=parameters.objective.restart,
            breakaway="scattered" if parameters.objective.by_slip else "common",
            staircase=_staircase(score),
        ),
        train=[r.text for r in fit.train_ranges],
        speeds=_speeds(fit),
        pace=None if (pace := paced(fit.recordings)) is None else PaceCard(**asdict(pace)),
        holdout=[
            HoldoutCard(
                range=h.within.text if h.within else "all",
                tests=h.scope.text,
                moves=h.scope.moves,
                value=h.score.value,
                unit=h.score.unit,
                baselines=h.score.baselines(),
                samples=h.score.samples,
                staircase=_staircase(h.score),
            )
            for h in fit.holdout
        ],
        search=SearchCard(
            method=fit.search.method,
            seed=fit.search.seed,
            evaluations=fit.search.evaluations,
            seconds=round(fit.search.seconds, 3),
            ended=fit.search.ended,
            # A repeat none of whose points could be simulated has no cost.
            repeats=[d.cost for d in fit.search.polished if math.isfinite(d.cost)],
        ),
        balance=_balance(fit),
        posterior=_posterior(fit),
        force_delay_ms=1e3 * fit.delay,
        velocity=_velocity(rig),
        data=[
            DataCard(
                file=log.source.file,
                sha256=log.source.sha256,
                rows=log.source.rows or len(log),
                used=fit.used(log),
            )
            for log in fit.recordings
        ],
        warnings=list(fit.warnings),
        notes=list(fit.notes),
        software={"stribeck": __version__},
    )


def _velocity(rig: Rig) -> Literal["recorded"] | None:
    """Where a force balance has its velocity from, unless that is the position."""
    if isinstance(rig, BalancedRig) and rig.filtering.velocity == "recorded":
        return "recorded"
    return None


def _speeds(fit: Fit) -> SpeedsCard:
    """Least and greatest velocity of the training data.

    Of the model's own motion under output error: a velocity that is taken from noisy positions
    reaches farther than the axis ever did.
    """
    written = fit.parameters.rig.shows.get(
        "velocity", "rad/s" if fit.parameters.rig.rotary else "m/s"
    )
    if fit.balance is not None:
        velocities = [b.velocity for b in fit.balance.signals]
    else:
        velocities = [m.velocity for m in simulated(fit.parameters, fit.p, fit.train)]
    ends = min(float(v.min()) for v in velocities), max(float(v.max()) for v in velocities)
    low, high = (float(unit(written).from_si(v)) for v in ends)
    return SpeedsCard(low=low, high=high, unit=written)


def _staircase(score: Score) -> dict[Literal["measured", "modelled"], StaircaseCard]:
    if score.measured is None or score.modelled is None:
        return {}
    return {
        "measured": StaircaseCard(**asdict(score.measured)),
        "modelled": StaircaseCard(**asdict(score.modelled)),
    }


def _balance(fit: Fit) -> dict[str, float]:
    figures = {} if fit.balance is None else fit.balance.figures()
    return {n: v for n, v in figures.items() if math.isfinite(v)}


def _posterior(fit: Fit) -> PosteriorCard | None:
    drawn = fit.posterior
    if drawn is None:
        return None
    free = [(drawn.names.index(q.name), q) for q in fit.parameters.free]
    return PosteriorCard(
        samples=len(drawn.samples),
        accepted=drawn.accepted,
        settled=drawn.settled,
        parameters={
            fit.parameters.rig.label(q.name): SampledCard(
                median=float(shown_in(fit.parameters.rig, q, drawn.median[i])),
                low=float(shown_in(fit.parameters.rig, q, drawn.low[i])),
                high=float(shown_in(fit.parameters.rig, q, drawn.high[i])),
            )
            for i, q in free
        },
    )


def _combinations(fit: Fit) -> dict[str, CombinationCard]:
    """Sums of a parameter and a constant, and ratios of parameters, in the unit people see."""
    entries = {}
    for c in fit.combinations:
        (q,) = [q for q in fit.parameters.every if q.name == c.parameter]
        value, low, high = (float(shown_in(fit.rig, q, x)) for x in (c.value, c.low, c.high))
        entries[f"{fit.rig.label(q.name)} + {c.constant}"] = CombinationCard(
            value=value, unit=c.unit, low=low, high=high, verdict=c.verdict, reason=c.reason
        )
    for r in fit.ratios:
        entries[r.name] = CombinationCard(
            value=r.value, unit=r.unit, low=r.low, high=r.high, verdict=r.verdict, reason=r.reason
        )
    return entries


def _breakaway(fit: Fit) -> dict[str, BreakawayCard]:
    """The spread of each breakaway level, in the unit people see."""
    entries = {}
    for b in fit.breakaway:
        (q,) = [q for q in fit.parameters.every if q.name == b.parameter]
        sd, low, high = (float(shown_difference(fit.rig, q, x)) for x in (b.sd, b.low, b.high))
        entries[fit.rig.label(q.name)] = BreakawayCard(
            unit=fit.rig.unit_of(q), sd=sd, low=low, high=high, slips=b.slips
        )
    return entries


def _between_logs(fit: Fit) -> dict[str, LogSpreadCard]:
    """How the free parameters differ from log to log, in the unit people see."""
    entries = {}
    for spread in fit.differing.spreads:
        (q,) = [q for q in fit.parameters.every if q.name == spread.parameter]
        effects = spread.effects
        mean, low, high = (
            float(shown_in(fit.rig, q, x)) for x in (effects.mean, effects.low, effects.high)
        )
        sd, sd_low, sd_high = (
            float(shown_difference(fit.rig, q, x))
            for x in (effects.sd, effects.sd_low, effects.sd_high)
        )
        entries[fit.rig.label(q.name)] = LogSpreadCard(
            unit=fit.rig.unit_of(q),
            mean=mean, low=low, high=high,
            sd=sd, sd_low=sd_low, sd_high=sd_high,
            logs=effects.units, chance=effects.chance, differs=spread.material,
        )  # fmt: skip
    return entries


def _conditions(fit: Fit) -> list[ConditionCard]:
    """What does not hold, parameters by the names that people see."""
    label = fit.rig.label
    return [
        ConditionCard(
            condition=v.condition,
            sentence=v.sentence,
            parameters=None if v.parameters is None else sorted(map(label, v.parameters)),
            caps=v.caps,
        )
        for v in fit.violations
    ]


def _parameters(fit: Fit) -> dict[str, ParameterCard]:
    parameters, cards, others = fit.parameters, {}, _others(fit)
    for q, e in zip(parameters.every, fit.estimates, strict=True):
        if e.verdict == "fixed" and q.fixed == e.value:
            continue  # as the law holds it anyway

        def shown(value: float, convert: Any = shown_in, q: Any = q) -> Any:
            return float(convert(parameters.rig, q, value)) if math.isfinite(value) else None

        free = e.verdict != "fixed"
        cards[e.name] = ParameterCard(
            value=shown(e.value),
            unit=e.unit,
            low=shown(e.low) if free else None,
            high=shown(e.high) if free else None,
            others_at_low=others.get(q.name, ({}, {}))[0],
            others_at_high=others.get(q.name, ({}, {}))[1],
            standard_error=shown(e.standard_error, shown_difference),
            spread=shown(e.spread, shown_difference),
            at_bound=e.at_bound,
            verdict=e.verdict,
            reason=e.reason,
            borderline=e.borderline,
            low_ended=e.low_ended,
            high_ended=e.high_ended,
            resampled=[shown(end) for end in e.resampled]
            if e.resampled is not None and np.isfinite(e.resampled).all()
            else None,
            meaning=e.meaning,
        )
    return cards


def _others(fit: Fit) -> dict[str, tuple[dict[str, float], dict[str, float]]]:
    """The others at both ends of each parameter's interval, by label, in the units people see."""
    params = {q.name: q for q in fit.parameters.every}

    def shown(values: Mapping[str, float]) -> dict[str, float]:
        return {fit.rig.label(n): float(shown_in(fit.rig, params[n], v)) for n, v in values.items()}

    return {name: (shown(low), shown(high)) for name, (low, high) in interval_ends(fit).items()}


def _columns(fit: Fit) -> dict[str, Any]:
    """How the first log was read, or else its rig's columns where they are not the kind's own."""
    first = fit.recordings[0]
    stated = dict(first.source.map or fit.rig.columns)
    if first.known_force is not None:  # of a log in memory, too
        stated = (
            LogMap.of(stated or None).with_words({"subtract": first.known_force.column}).table()
        )
    return stated if stated != dict(origin_of(fit.rig).columns) else {}


def _stated(fit: Fit) -> dict[str, list[float]]:
    """Least and greatest of the constants that all logs state, in the unit of the rig's."""
    rig = fit.parameters.rig
    if rig.approach != "output_error":
        return {}
    logs = [as_simulated(rig).stated(recording) for recording in fit.recordings]
    ends = {c.name: [s[c.name] for s in logs if c.name in s] for c in rig.constants}
    return {
        c.name: [float(unit(c.unit).from_si(end)) for end in (min(values), max(values))]
        for c in rig.constants
        if len(values := ends[c.name]) == len(logs)
    }
