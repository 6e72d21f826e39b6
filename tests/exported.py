"""A model of any law, as exporters are given it: parameters within the search ranges."""

from __future__ import annotations

import numpy as np

from stribeck.export.model import Model, as_model
from stribeck.friction import LAWS, Law, law_named
from stribeck.identify.card import Card
from stribeck.rig import RIGS, Rig
from stribeck.rig.rig import shown_in
from stribeck.space import Array, Param

#: Every law of the catalogue, one with elements of its own, and some with terms.
NAMES = (
    *LAWS,
    "maxwell-slip:6",
    "stribeck+temperature",
    "lugre+position",
    "bam-m4+temperature+position",
)


def model_of(law: str, rig: str | None = None, seed: int = 1) -> Model:
    """A model of a law by its name, on a rig that knows what the law depends on.

    Its parameters are drawn from the middle of their search ranges, the breakaway levels above
    those in motion; it was seen from −0.1 to 0.08 m/s (rad/s).
    """
    made = law_named(law)
    kind = RIGS[rig or _home(made)]
    every = kind.parameters(made)
    values = drawn(every, seed)
    for i, q in enumerate(made.params):
        if q.name.startswith("F_S"):
            values[i] = max(values[i], 1.5 * values[i + 1])  # F_C follows its F_S in every law
    parameters = {
        kind.label(q.name): {
            "value": float(shown_in(kind, q, value)),
            "unit": kind.unit_of(q),
            "low": None,
            "high": None,
            "at_bound": None,
            "verdict": "identified",
        }
        for q, value in zip(every, values, strict=True)
    }
    return as_model(Card.model_validate(_card(law, kind, parameters)))


def drawn(every: tuple[Param, ...], seed: int) -> Array:
    """Parameters from the middle of their ranges, SI."""
    share = np.random.default_rng(seed).uniform(0.3, 0.6, len(every))
    return np.array([
        q.fixed if q.fixed is not None
        else q.lower * (q.upper / q.lower) ** u if q.log
        else q.lower + u * (q.upper - q.lower)
        for q, u in zip(every, share, strict=True)
    ])  # fmt: skip


def _home(law: Law) -> str:
    if "normal" in law.loads:
        return "cylinder"
    return "servo-pendulum" if law.loads else "slide-bed"


def _card(law: str, rig: Rig, parameters: object) -> dict[str, object]:
    return {
        "schema": "stribeck-card/1",
        "law": law,
        "rig": rig.name,
        "kind": rig.name,
        "parameters": parameters,
        "objective": {"name": "position_rmse", "value": 1.0, "unit": "mm", "samples": 100},
        "search": {"method": "mbts", "seed": 0, "evaluations": 1, "seconds": 1.0, "ended": "x"},
        "data": [],
        "software": {"stribeck": "0"},
        "speeds": {"low": -0.1, "high": 0.08, "unit": "rad/s" if rig.rotary else "m/s"},
    }
