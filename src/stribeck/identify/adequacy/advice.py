"""What an effect means for a fit: the parameters that it biases, and what would catch it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...friction import LAWS
from ...friction.law import Term
from ...rig.rig import shown_difference
from ...space import Param
from ...units import percent, unit
from ...wording import option
from ..conditions import Violation
from ..moved_estimates import may_be
from ..uncertainty.verdict import IDENTIFIED

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ..parameters import Parameters
    from ..uncertainty.estimates import Estimate
    from .effects import Effect, Effects

#: Laws without a drop from rest to slip, and those that add one.
_WITH_DROP = {
    "coulomb-viscous": "stribeck",
    "coulomb-viscous-directional": "stribeck-directional",
    "bam-m1": "bam-m2",
    "bam-m3": "bam-m4",
    "dahl": "lugre",
}
#: A parameter that something without a name would move by less than this share is not told.
MATTERS = 0.03
#: What an effect is in words, by variable, kind and pattern.
_WORDS = {
    ("speed", "force", "square"): "grows with the square of the speed",
    ("speed", "force", "side"): "differs between the directions",
    ("speed", "force", "drop"): "falls with speed below {scale}",
    ("speed", "force", ""): "goes with the speed",
    ("position", "force", "slope"): "goes with the position as a spring's or a tilted weight's",
    ("position", "force", "wave"): "goes with the position as cogging's, period {scale}",
    ("position", "force", ""): "goes with the position",
    ("position", "friction", "slope"): "is friction that rises along the travel",
    ("position", "friction", "wave"): "is friction that varies along the travel, period {scale}",
    ("position", "friction", ""): "is friction that varies along the travel",
    ("time", "force", "drift"): "drifts",
    ("time", "force", "tone"): "is a wave in time, period {scale}, that the motion does not have",
    ("time", "force", ""): "changes over the log",
    ("time", "friction", "drift"): "is friction that drifts, as of an axis that warms up",
    ("time", "friction", "intermittent"): "is friction that rises and falls from stroke to stroke",
    ("time", "friction", ""): "is friction that changes over the log",
    ("time", "inertia", "drift"): "is that of an inertia that drifts",
    ("time", "inertia", "change"): "is that of an inertia that changes {scale}",
    ("time", "inertia", "intermittent"): "is that of an inertia that comes and goes",
    ("time", "inertia", ""): "is that of an inertia that changes over the log",
    ("reversal", "force", "play"): "lies within {scale} of reversals as backlash's",
    ("reversal", "force", "turn"): "lies within {scale} of reversals, where the low pass rounds",
    ("acceleration", "force", "load"): "goes with the size of the acceleration",
    ("acceleration", "force", ""): "goes with the acceleration",
}


def with_effects(
    parameters: Parameters,
    estimates: Sequence[Estimate],
    effects: Effects | None,
    recordings: Sequence[Recording],
) -> tuple[tuple[Estimate, ...], list[Violation]]:
    """Estimates whose intervals hold what an effect would make of them, and what to tell.

    An effect takes "identified" away where such an interval is wider than the word allows. One that
    moves no parameter is not told, but for a tone: intervals are as wide as they are because of it.

    Args:
        parameters: Rig and law.
        estimates: As in `parameters.every`.
        effects: What the residual shows; None where the rig cannot say.
        recordings: The logs.
    """
    estimates, violations = tuple(estimates), []
    for effect in effects.effects if effects is not None else ():
        if not effect.shifts and effect.pattern != "tone":
            continue
        shifts, opposite = (
            [moves.get(parameters.tied.get(q.name, q.name), 0.0) for q in parameters.every]
            for moves in (effect.shifts, effect.opposite)
        )
        for ends in (shifts, opposite):
            estimates = tuple(map(_widened, parameters.every, estimates, ends))
        wide = frozenset(
            q.name
            for q, e, *moves in zip(parameters.every, estimates, shifts, opposite, strict=True)
            if any(moves) and max(e.high - e.value, e.value - e.low) > IDENTIFIED * abs(e.value)
        )
        changes = _changes(parameters, estimates, shifts)
        if any(opposite):
            changes += f" and, at its other end, {_changes(parameters, estimates, opposite)}"
        moved = f"; with that in the model {changes}, and the intervals contain that"
        sentence = (
            f"the force that the model leaves over {description(parameters, effect)} "
            f"({percent(effect.share)} of its variance){moved if effect.shifts else ''}: "
            f"{advice(parameters, effect, recordings)}"
        )
        violations.append(Violation("model", sentence, wide, caps=bool(wide)))
    return estimates, violations


def recurrence_violations(
    parameters: Parameters, estimates: Sequence[Estimate], effects: Effects
) -> list[Violation]:
    """That a model leaves something out which has no name, where that may matter.

    It takes no verdict away: what it resembles is not known.

    Args:
        parameters: Rig and law.
        estimates: As in `parameters.every`.
        effects: What the residual shows.
    """
    if (recurring := effects.recurrence) is None:
        return []
    rig, off = parameters.rig, list[str]()
    for q, e in zip(parameters.every, estimates, strict=True):
        shift = recurring.shifts.get(parameters.tied.get(q.name, q.name), 0.0)
        reach = max(0.5 * (e.high - e.low), MATTERS * abs(e.value))
        if e.verdict == "identified" and shift > reach:
            shown = float(shown_difference(rig, q, shift))
            off.append(f"{e.name} by {shown:.2g} {e.unit}".rstrip())
    if not off:
        return []
    sentence = (
        f"{percent(recurring.share)} of the variance of the force that the model leaves comes "
        "back wherever position, velocity and acceleration do: it leaves out something that has "
        "no name here, as a load that is carried one way, a place of more friction, or hysteresis "
        f"of the force sensor; so much force would move {' or '.join(off)}, and the intervals do "
        "not hold that"
    )
    return [Violation("model", sentence, caps=False)]


def _widened(q: Param, e: Estimate, shift: float) -> Estimate:
    """An estimate whose interval holds the shifted value."""
    elsewhere = within(q, e.value + shift)
    return replace(e, low=min(e.low, elsewhere), high=max(e.high, elsewhere))


def within(q: Param, value: float) -> float:
    """The value of a parameter within its range that is nearest to another, SI."""
    return min(max(value, q.lower), q.upper)


def description(parameters: Parameters, effect: Effect) -> str:
    """An effect in words."""
    rig = parameters.rig
    words = _WORDS[effect.variable, effect.kind, effect.pattern]
    if np.isnan(effect.scale):
        return words
    if effect.variable == "time" and effect.pattern == "tone":
        return words.format(scale=f"{effect.scale:.3g} s")
    if effect.variable == "time":
        return words.format(scale=f"{effect.scale:.3g} s after its start")
    if effect.variable == "reversal":
        return words.format(scale=f"{1e3 * effect.scale:.3g} ms")
    shown = rig.unit_shown("velocity" if effect.variable == "speed" else "position")
    return words.format(scale=f"{float(unit(shown).from_si(effect.scale)):.3g} {shown}")


def _changes(parameters: Parameters, estimates: Sequence[Estimate], shifts: Sequence[float]) -> str:
    """What the biased parameters would be with the effect in the model."""
    return " and ".join(
        may_be(parameters.rig, q, e, within(q, e.value + shift))
        for q, e, shift in zip(parameters.every, estimates, shifts, strict=True)
        if shift
    )


def advice(parameters: Parameters, effect: Effect, recordings: Sequence[Recording]) -> str:
    """What catches an effect and can be had on this rig."""
    if effect.variable == "speed":
        text = _of_speed(parameters, effect)
    elif effect.variable == "position":
        text = _of_position(parameters, effect)
    elif effect.pattern == "turn":
        text = "log at a higher rate, or turn round more slowly; if there is play, take it out"
    elif effect.variable == "reversal":
        text = "take the play out, or measure the position where the force acts"
    elif effect.variable == "acceleration":
        text = "a load, a delay between channels or play in the drive does that"
    else:
        text = _of_time(parameters, effect, recordings)
    return text


def _of_time(parameters: Parameters, effect: Effect, recordings: Sequence[Recording]) -> str:
    if effect.kind == "inertia":
        return (
            f"a load comes or goes; train on one load ({option('train')}), or log each load apart"
        )
    if effect.pattern == "tone":
        return (
            "something beside the axis pulls, or what is faster than half the sampling rate folds "
            "down: log with it at rest, or take its force off"
        )
    if effect.kind == "force":
        return f"the zero of a channel or a load drifts; train on shorter parts ({option('train')})"
    if all(log.temperature is not None for log in recordings):
        return _term(parameters, "temperature")
    if effect.pattern == "intermittent":
        return (
            "look for what it goes with (lubricant, temperature, a load on the guides), or reckon "
            "with all of the interval"
        )
    return f"train on the part in which it is steady ({option('train')}), or log the temperature"


def _of_position(parameters: Parameters, effect: Effect) -> str:
    if effect.kind == "friction" and parameters.rig.rotary and _bears_load(parameters):
        return f"use a law of the load, as bam-m4, or law {parameters.law.name}+position"
    if effect.kind == "friction":
        return _term(parameters, "position")
    if effect.pattern == "wave" and parameters.rig.approach == "force_balance":
        return _term(parameters, "cogging")
    if parameters.rig.name == "forced-rotary":
        return "if that is a weight, use rig forced-pendulum"
    less = f"take it off the force, or train on less travel ({option('train')})"
    return _of_spring(parameters, less) if effect.pattern == "slope" else less


def _of_spring(parameters: Parameters, otherwise: str) -> str:
    """What holds a force that goes with the position."""
    spring = "if that is a spring, compose the axis with one ([load.spring], `stribeck rigs --new`)"
    if parameters.rig.approach == "output_error":
        return spring
    return f"{spring} that the force drives; else {otherwise}"


def _bears_load(parameters: Parameters) -> bool:
    """Whether a rig knows the load of a transmission, and the law does not ask for it."""
    law = parameters.law
    return {"drive", "external"} <= set(parameters.rig.loads) and not law.loads and not law.terms


def _of_speed(parameters: Parameters, effect: Effect) -> str:
    law = parameters.law.name
    stem = law.split("+", maxsplit=1)[0].split(":", maxsplit=1)[0]
    if effect.pattern == "side":
        other = f"{stem}-directional"
        if other in LAWS:
            return f"use law {law.replace(stem, other)}"
    if effect.pattern == "drop" and stem in _WITH_DROP:
        return f"use law {law.replace(stem, _WITH_DROP[stem])}"
    if effect.pattern == "square":
        return _of_squares(parameters)
    if stem.startswith("stribeck") and not stem.startswith("stribeck-free"):
        directional = "-directional" * stem.endswith("-directional")
        return f"try law stribeck-free{directional}, or `stribeck select`"
    if parameters.law.states and parameters.rig.approach == "force_balance":
        # Their rows are not those of static laws, so that `select` refuses them.
        return f"try another law with states, and hold each against {option('holdout')}"
    return "compare laws with `stribeck select`"


def _of_squares(parameters: Parameters) -> str:
    """What holds a force that grows with the square of the speed."""
    law, narrower = parameters.law, f"train on a narrower range of speeds ({option('train')})"
    if law.roughness is not None:
        return f"take more knots ({law.name.partition(':')[0]}:24), or {narrower}"
    if parameters.rig.approach == "force_balance" and law.static and not law.loads:
        return f"no formula here has that; law curve{'-directional' * law.directional} has none"
    return f"no law here has that; {narrower}"


def _term(parameters: Parameters, term: Term) -> str:
    if term in parameters.law.terms:
        return f"the term {term} does not catch it; train on less of the log ({option('train')})"
    return f"use law {parameters.law.name}+{term}"
