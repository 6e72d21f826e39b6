"""Identified models of every law without an identification, for tests of what is exported."""

from dataclasses import replace

import numpy as np

from stribeck.compensate.compensator import Compensator
from stribeck.export.model import Model, as_model
from stribeck.friction import law_named
from stribeck.friction.law import Law
from stribeck.identify.card import Card
from stribeck.identify.parameters import partition
from stribeck.rig import RIGS, Rig
from stribeck.rig.rig import shown_in
from stribeck.space import Array, Param

#: Every law with a size or a term that the table of laws does not show.
VARIANTS = (
    "maxwell-slip:6",
    "stribeck+temperature",
    "lugre+position",
    "stribeck+position:2",
    "bam-m4+temperature+position",
)

#: A compensator with bands, crossover, smoothing and slew rate; and with all that a controller can
#: ask of one, at once.
SHAPED = Compensator(
    feedback=True,
    dead_band=1e-4,
    reference_band=3e-4,
    crossover=0.02,
    smoothing=1e-3,
    slew=1e4,
    drive=3.0,
)
BUSY = replace(SHAPED, limit=200.0, scale=0.9)
#: A law whose function takes other branches where a parameter differs from its fixed value.
DAHLS = ("dahl, exponent 0.5", "dahl, exponent 1.5")


def model_of(name: str, seed: int = 1, warnings: list[str] | None = None) -> Model:
    """The model of a card with a law's parameters, drawn from their ranges."""
    name, _, exponent = name.partition(", exponent ")
    law = law_named(name)
    values = _values(law, seed)
    if exponent:
        values[law.names.index("exponent")] = float(exponent)
    return as_model(_card(law, values, warnings))


def rude(model: Model) -> Model:
    """A model whose rig's and file's names hold what ends a comment, a string or a file."""
    name = """Führung −1 *) (* */ /* ]]> <b> & " \\ \\" %{
F = 0;
END_FUNCTION
%} \x00\x1b 😀"""
    card = model.card.model_copy(update={"rig": name})
    return replace(model, card=card, source=f"{name}.json")


def model_with(law: Law, seed: int = 1) -> Model:
    """The model of a law that is in no table, with parameters drawn from their ranges."""
    values = _values(law, seed)
    return Model(_card(law, values, None), partition(_rig(law), law), values, "0", "card.json")


def _values(law: Law, seed: int) -> Array:
    params = _rig(law).parameters(law)
    shares = np.random.default_rng(seed).uniform(0.3, 0.6, len(params))
    return np.array([_value_in_range(q, share) for q, share in zip(params, shares, strict=True)])


def _card(law: Law, values: Array, warnings: list[str] | None) -> Card:
    rig = _rig(law)
    params = rig.parameters(law)
    return Card.model_validate(
        {
            "law": law.name,
            "rig": rig.name,
            "kind": rig.name,
            "parameters": {
                rig.label(q.name): _parameter(rig, q, value)
                for q, value in zip(params, values, strict=True)
            },
            "objective": {"name": "position_rmse", "value": 1.0, "unit": "mm", "samples": 3},
            "search": {
                "method": "mbts", "seed": 0, "evaluations": 1, "seconds": 1.0, "ended": "budget",
            },
            "data": [],
            "software": {"stribeck": "0"},
            "speeds": {"low": -100.0, "high": 80.0, "unit": "deg/s" if rig.rotary else "mm/s"},
            "warnings": warnings or [],
        }
    )  # fmt: skip


def _rig(law: Law) -> Rig:
    """A rig that has the loads that the law reads."""
    if "normal" in law.loads:
        return RIGS["cylinder"]
    return RIGS["servo-pendulum" if law.loads else "slide-bed"]


def _value_in_range(parameter: Param, share: float) -> float:
    """A value inside a parameter's range; static friction lies above Coulomb's."""
    if parameter.fixed is not None:
        return parameter.fixed
    value = (
        parameter.lower * (parameter.upper / parameter.lower) ** share
        if parameter.log
        else parameter.lower + share * (parameter.upper - parameter.lower)
    )
    return value * 3.0 if parameter.name.startswith("F_S") else value


def _parameter(rig: Rig, parameter: Param, value: float) -> dict[str, object]:
    return {
        "value": float(shown_in(rig, parameter, value)),
        "unit": rig.unit_of(parameter),
        "low": None,
        "high": None,
        "at_bound": None,
        "verdict": "identified",
    }
