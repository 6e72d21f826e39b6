"""Models of axes of known friction, for tests of exporters."""

from __future__ import annotations

from collections.abc import Mapping

from stribeck.export.model import Model, as_model
from stribeck.friction import law_named
from stribeck.identify.card import Card, axis_table
from stribeck.rig import RIGS
from stribeck.rig.composed import ComposedRig
from stribeck.rig.rig import shown_in

#: Entries that all the cards share.
_SHARED = {
    "schema": "stribeck-card/1",
    "objective": {"name": "position_rmse", "value": 0.1, "unit": "mm", "samples": 100},
    "search": {"method": "bts", "seed": 0, "evaluations": 1, "seconds": 0.1, "ended": "budget"},
    "data": [],
    "software": {"stribeck": "0"},
}


def model_of(
    rig: str | ComposedRig,
    law: str,
    values: Mapping[str, float],
    speeds: tuple[float, float] | None = None,
) -> Model:
    """A model of these parameters, SI, on a shipped rig or one of parts; `speeds` in m/s, rad/s."""
    kind = RIGS[rig] if isinstance(rig, str) else rig
    parameters = {}
    for q in kind.parameters(law_named(law)):
        if q.name in values:
            parameters[kind.label(q.name)] = {
                "value": float(shown_in(kind, q, values[q.name])),
                "unit": kind.unit_of(q),
                "low": None,
                "high": None,
                "at_bound": None,
                "verdict": "identified",
            }
    speed_range = speeds and {
        "low": speeds[0],
        "high": speeds[1],
        "unit": "rad/s" if kind.rotary else "m/s",
    }
    return as_model(
        Card.model_validate(
            {
                **_SHARED,
                "law": law,
                "rig": kind.name,
                "kind": rig if isinstance(rig, str) else "composed",
                "axis": axis_table(kind),
                "parameters": parameters,
                "speeds": speed_range,
            }
        )
    )


def slide(speeds: tuple[float, float] | None = (-0.5, 0.5)) -> Model:
    """A linear axis of Coulomb and viscous friction: 12.5 N and 40 N s/m on 10 kg."""
    values = {"F_C": 12.5, "F_V": 40.0, "M": 10.0, "offset": 0.0}
    return model_of("forced", "coulomb-viscous", values, speeds)


def hinge(speeds: tuple[float, float] | None = (-5.0, 5.0)) -> Model:
    """A rotary axis of Coulomb and viscous friction: 0.5 N m and 0.02 N m s/rad on 0.1 kg m^2."""
    values = {"F_C": 0.5, "F_V": 0.02, "M": 0.1, "offset": 0.0}
    return model_of("forced-rotary", "coulomb-viscous", values, speeds)


#: A Stribeck axis of 10 kg, SI.
STRIBECK = {"F_S": 20.0, "F_C": 12.0, "F_V": 40.0, "v_SS": 0.01, "M": 10.0, "offset": 0.0}


def sticking() -> Model:
    """The Stribeck axis."""
    return model_of("forced", "stribeck", STRIBECK, (-0.2, 0.2))
