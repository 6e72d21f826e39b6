"""Play and compliance of a drive behind one encoder, which look like friction or a delay.

Where a fit of one mass leaves more than the noise, or its law has states, which follow a hysteresis
that play makes as well, the same log is fitted with the mass in two: a motor and a load with a
spring and play between them, friction on both, and the encoder on either. If that explains the log
as well or better, what the fit says of friction may be the play's.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..friction import law_named
from ..rig.composed import ComposedRig
from ..rig.parts import part_named
from ..rig.parts.transmissions import ratio
from ..rig.rig import shown_in
from ..rig.two_masses import OF_MOTOR, TwoMassRig
from ..units import unit
from .conditions import Violation
from .parameters import Parameters
from .polish import Polished, best_descent
from .problem import MotionProblem

if TYPE_CHECKING:
    from ..friction import Law
    from ..rig.parts import Part
    from ..space import Array

#: Misfit, as a share of the fit's, from which play explains a log that the fit does not explain,
#: and one that a law with states does.
BETTER, AS_WELL = 0.7, 1.1
#: A side whose best refit is further above that than by this factor is refitted no more: more rows
#: gain 8 % at most (nine logs with play and without).
PROMISING = 1.3
Side = Literal["motor", "load"]
#: Hz at which motor and load swing against each other, and play in multiples of the misfit, where
#: refits may start; rows that each takes for a parameter, and those that the best of a side takes
#: beyond; samples that all may simulate: the best places first, and none where that is too little
#: for one.
SWINGS, PLAYS, ROWS, BEYOND, MOST = (30.0, 100.0), (3.0, 30.0), 4, 6, 1_000_000
#: Way by which a step of a refit may be off, m or rad.
ROUGHLY = 2e-8
#: Hz that are searched, damping of the swing, and play as a share of the travel.
SWINGS_SEARCHED, DAMPING, PLAY_SEARCHED = (5.0, 500.0), 0.05, 0.2
#: Parts that hold a motor and a load together as one mass.
_STIFF = ("rigid", "gear", "screw")
_SIDES: tuple[Side, ...] = ("motor", "load")
#: Coefficients that are the inertia of a load.
_INERTIAS = ("M", "J")


def hidden_play(problem: MotionProblem, x: Array, *, rough: bool) -> tuple[list[Violation], int]:
    """What to tell of a play that explains a log as well as a fit; and the rows evaluated.

    Args:
        problem: The motion problem of the fit.
        x: The fit, SI, (dim,).
        rough: Whether its misfit is beyond the noise.
    """
    parameters = problem.parameters
    rig = parameters.rig
    asked = (rough or parameters.law.states) and problem.weights is None
    if not asked or not isinstance(rig, ComposedRig) or isinstance(rig, TwoMassRig):
        return [], 0
    values, stiff = _values(problem, x), any(q.name in _STIFF for q in rig.parts)
    masses = _masses(rig, values)
    if masses is None or not stiff or not rig.commanded:
        return [], 0
    if any(_masses(rig, {**values, **rig.stated(s.recording)}) is None for s in problem.train):
        return [], 0  # a log of a bare motor states that it has no load
    split = {side: _split(problem, x, masses, side) for side in _SIDES}
    each = (ROWS + BEYOND) * split["load"].space.dim
    most = MOST // (each * sum(len(s.track.t) for s in problem.train))
    if not most:
        return [], 0
    cost, rows = float(problem(x[None])[0]), 1
    limit = (BETTER if rough else AS_WELL) * cost
    places = []
    for side, other in split.items():
        points = np.array([_start(other, problem, x, *at) for at in _starts(masses, cost)])
        rows += len(points)
        places += [
            (float(J), side, point)
            for J, point in zip(other(points), points, strict=True)
            if np.isfinite(J)
        ]
    places = sorted(places, key=lambda place: place[0])[:most]
    best: tuple[Polished, MotionProblem, str] | None = None
    for side, other in split.items():
        starts = np.array([point for _, of_side, point in places if of_side == side])
        if not len(starts):
            continue
        refit = _refitted(other, starts, limit)
        rows += refit.evaluations
        if best is None or refit.cost < best[0].cost:
            best = refit, other, side
    if best is None or not best[0].cost < limit:
        return [], rows
    return [_told(*best, cost)], rows


def _refitted(other: MotionProblem, starts: Array, limit: float) -> Polished:
    """The best refit from some starts, and further where it comes near a limit."""
    first = best_descent(other, starts, ((len(starts), ROWS),))
    if not first.cost < PROMISING * limit:
        return first
    further = best_descent(other, first.x[None], ((1, BEYOND),))
    return replace(further, evaluations=first.evaluations + further.evaluations)


def _told(refit: Polished, other: MotionProblem, side: str, cost: float) -> Violation:
    """A play in words."""
    by_name = dict(zip(other.space.names, refit.x.tolist(), strict=True))
    rig = other.parameters.rig
    way = rig.unit_shown("position")
    levels = ", ".join(
        f"{q.name} {float(shown_in(rig, q, by_name[q.name])):.3g} {rig.unit_of(q)}"
        for q in other.space.params
        if q.name in ("F_C", f"F_C{OF_MOTOR}")
    )
    sentence = (
        "play of the drive looks like friction to one encoder: a motor and a load with "
        f"{float(unit(way).from_si(by_name['play'])):.3g} {way} of it between them, read at the "
        f"{side}, leave {refit.cost:.3g} {other.unit} where this fit leaves {cost:.3g}"
        f"{f' (with {levels})' if levels else ''}: compose the axis with "
        "[transmission.compliant], best with an encoder on either side"
    )
    return Violation("model", sentence)


def _values(problem: MotionProblem, x: Array) -> dict[str, float]:
    """Constants and parameters of a fit by name, SI."""
    parameters = problem.parameters
    known = {c.name: c.value for c in parameters.rig.constants}
    return known | parameters.values(parameters.full(x[None])[0])


def _split(
    problem: MotionProblem, x: Array, masses: tuple[float, float], side: Side
) -> MotionProblem:
    """The problem with its mass in two, and the encoder on a side."""
    parameters = problem.parameters
    law = parameters.law if not parameters.law.states else law_named("coulomb-viscous")
    travel = max(float(np.ptp(s.recording.position)) for s in problem.train)
    rig = parameters.rig
    assert isinstance(rig, ComposedRig)  # noqa: S101 - the caller's
    two = _two_masses(rig, _values(problem, x), masses, travel, side, law)
    train = []
    for s in problem.train:
        rows = slice(s.begin, s.rows.stop)
        track = two.track(s.recording, rows, s.track.x0, s.track.score)._replace(v0=s.track.v0)
        train.append(replace(s, track=track, start_directions=None))
    declared = Parameters.declared(two, law)
    return MotionProblem(replace(declared, objective=parameters.objective), train)


def _starts(masses: tuple[float, float], cost: float) -> list[tuple[float, float]]:
    """Stiffness, SI, and play, in the unit of the misfit, where refits may start."""
    reduced = _reduced(masses)
    return [(reduced * (2.0 * np.pi * f) ** 2, times * cost) for f in SWINGS for times in PLAYS]


def _reduced(masses: tuple[float, float]) -> float:
    return masses[0] * masses[1] / (masses[0] + masses[1])


def _start(
    other: MotionProblem, problem: MotionProblem, x: Array, stiffness: float, play: float
) -> Array:
    """A place to start at: half of the friction on each side."""
    values, start = _values(problem, x), []
    for q in other.space.params:
        if q.name in ("stiffness", "play"):
            value = stiffness if q.name == "stiffness" else play * problem.scale
        else:
            known = values.get(q.name.removesuffix(OF_MOTOR), 0.5 * (q.lower + q.upper))
            value = 0.5 * known if q.unit.startswith("N") else known
        start.append(min(max(value, q.lower), q.upper))
    return np.array(start)


def _masses(rig: ComposedRig, values: dict[str, float]) -> tuple[float, float] | None:
    """Inertia of the motor, at the load, and of the load; half each where it is one number."""
    motor = values.get("armature", 0.0) * _ratio(rig, values) ** 2
    total = float(rig.coefficients(values)[0])
    if motor > 0.0:
        return (motor, total - motor) if total > motor else None
    own = {c.name for part in rig.parts for c in part.coefficients}
    return (0.5 * total, 0.5 * total) if own & set(_INERTIAS) else None


def _ratio(rig: ComposedRig, values: dict[str, float]) -> float:
    return float(
        ratio({c.name: values.get(c.name, c.idle) for q in rig.parts for c in q.coefficients})
    )


def _two_masses(
    rig: ComposedRig, values: dict[str, float], masses: tuple[float, float], travel: float,
    side: Side, law: Law,
) -> TwoMassRig:  # fmt: skip
    """The axis of a rig with a compliant transmission, everything but that and friction known."""
    n = _ratio(rig, values)
    known = values | {"armature": masses[0] / n**2, "gear_ratio": n}
    if not values.get("armature", 0.0) > 0.0:
        known |= dict.fromkeys(_INERTIAS, masses[1])
    parts: list[Part] = []
    for part in (*rig.parts, part_named("sensor", side)):
        kept = part_named("transmission", "compliant") if part.role == "transmission" else part
        parts.append(kept.with_coefficients(*(
            c.known(known[c.name], "the fit") for c in kept.coefficients if c.name in known
        )))  # fmt: skip
    reduced = _reduced(masses)
    parts = [_searched(q, reduced, travel) if q.name == "compliant" else q for q in parts]
    two = TwoMassRig.compose(
        rig.name, parts, rotary=rig.rotary, doc=rig.doc, cite=rig.cite, laws=(law.name,),
        constants=tuple(c for c in rig.constants if c.name in ("step", "tolerance")),
        input_columns=rig.input_columns, run_columns=rig.run_columns, shows=rig.shows,
        ranges={**rig.ranges, **{f"{n}{OF_MOTOR}": ends for n, ends in rig.ranges.items()}},
        friction_side="both",
    )  # fmt: skip
    return two.estimated({"tolerance": max(rig["tolerance"], ROUGHLY)})


def _searched(compliant: Part, reduced: float, travel: float) -> Part:
    """A compliant transmission whose stiffness and play are searched."""
    low, high = (reduced * (2.0 * np.pi * swing) ** 2 for swing in SWINGS_SEARCHED)
    damping = 2.0 * DAMPING * reduced * 2.0 * np.pi * float(np.sqrt(np.prod(SWINGS)))
    return compliant.with_coefficients(
        compliant["stiffness"].searched(low, high, log=True),
        compliant["play"].searched(0.0, PLAY_SEARCHED * travel),
        compliant["damping"].known(damping, "a swing that fades"),
    )
