"""What an effect means for a fit: the parameters that it biases, and what would catch it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...friction import LAWS, TERMS
from ...rig.rig import shown_in
from ...units import unit
from ..conditions import Violation

if TYPE_CHECKING:
    from ...data.recording import Recording
    from ..parameters import Parameters
    from .effects import Effect, Effects

#: Laws without a drop from rest to slip, and those that add one.
_WITH_DROP = {
    "coulomb-viscous": "stribeck",
    "coulomb-viscous-directional": "stribeck-directional",
    "bam-m1": "bam-m2",
    "bam-m3": "bam-m4",
    "dahl": "lugre",
}
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
    ("time", "force", ""): "changes over the log",
    ("time", "friction", "drift"): "is friction that drifts, as of an axis that warms up",
    ("time", "friction", ""): "is friction that changes over the log",
    ("acceleration", "force", "load"): "goes with the size of the acceleration",
    ("acceleration", "force", ""): "goes with the acceleration",
}


def adequacy_violations(
    parameters: Parameters, p: Sequence[float], effects: Effects, recordings: Sequence[Recording]
) -> list[Violation]:
    """The effects that bias parameters, as violations of the model's adequacy.

    Args:
        parameters: Rig and law.
        p: The fit, a complete set, SI, (k,).
        effects: What its residual shows.
        recordings: Its logs.
    """
    return [
        Violation(
            "model",
            f"the force that the model leaves over {description(parameters, e)} "
            f"({100 * e.share:.2g} % of its variance): {_shifts(parameters, p, e)}"
            f"{_joined(advice(parameters, e, recordings))}",
            e.biased,
        )
        for e in effects.effects
        if e.biased
    ]


def description(parameters: Parameters, effect: Effect) -> str:
    """An effect in words."""
    rig = parameters.rig
    words = _WORDS[effect.variable, effect.kind, effect.pattern]
    if np.isnan(effect.scale):
        return words
    shown = rig.unit_shown("velocity" if effect.variable == "speed" else "position")
    return words.format(scale=f"{float(unit(shown).from_si(effect.scale)):.3g} {shown}")


def _shifts(parameters: Parameters, p: Sequence[float], effect: Effect) -> str:
    """What the biased parameters would be with the effect in the model."""
    moved = []
    for q, value in zip(parameters.every, p, strict=True):
        if q.name in effect.biased:
            before, after = (
                float(shown_in(parameters.rig, q, x))
                for x in (value, value + effect.shifts.get(q.name, 0.0))
            )
            written = parameters.rig.unit_of(q)
            label = parameters.rig.label(q.name)
            moved.append(f"{label} {after:.3g}, not {before:.3g} {written}".rstrip())
    return f"with it in the model {'; '.join(moved)}"


def _joined(text: str) -> str:
    return f": {text}" if text else ""


def advice(parameters: Parameters, effect: Effect, recordings: Sequence[Recording]) -> str:
    """What catches an effect and can be had on this rig; empty if nothing can."""
    law = parameters.law.name
    stem = law.split("+")[0].split(":")[0]
    if effect.variable == "speed":
        return _of_speed(law, stem, effect)
    if effect.variable == "position" and effect.kind == "friction":
        return _term(parameters, "position")
    if effect.variable == "position":
        if parameters.rig.rotary and parameters.rig.name == "forced-rotary":
            return "if that is a weight, use rig forced-pendulum"
        return f"no rig here has that: take it off the force, or train on less travel ({_TRAIN})"
    if effect.variable == "time" and effect.kind == "friction":
        if all(log.temperature is not None for log in recordings):
            return _term(parameters, "temperature")
        return f"train on the part in which it is steady ({_TRAIN}), or log the temperature"
    if effect.variable == "time":
        return f"the zero of a channel or a load drifts: train on shorter parts ({_TRAIN})"
    return "a load, a delay between channels or play in the drive does that: look for it first"


_TRAIN = "--train"


def _of_speed(law: str, stem: str, effect: Effect) -> str:
    if effect.pattern == "side":
        other = f"{stem}-directional"
        return f"use law {law.replace(stem, other)}" if other in LAWS else ""
    if effect.pattern == "drop" and stem in _WITH_DROP:
        return f"use law {law.replace(stem, _WITH_DROP[stem])}"
    if effect.pattern == "square":
        return f"no law here has that: train on a narrower range of speeds ({_TRAIN})"
    if stem.startswith("stribeck") and not stem.startswith("stribeck-free"):
        directional = "-directional" * stem.endswith("-directional")
        return f"try law stribeck-free{directional}, or `stribeck select`"
    return "compare laws with `stribeck select`"


def _term(parameters: Parameters, term: str) -> str:
    if term in parameters.law.terms or term not in TERMS:
        return f"the term {term} does not catch it: train on less of the log ({_TRAIN})"
    return f"use law {parameters.law.name}+{term}"
