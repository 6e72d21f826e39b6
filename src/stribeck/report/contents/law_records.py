"""The identified law as a report has it: curve and band, loops of slow strokes, loads."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from ...identify.card import directions_between
from ...units import unit
from ..format import unit_label
from .confidence_band import BandSource, band
from .decimation import Detail
from .law_curve import (
    friction_under,
    greatest_load,
    law_parameters,
    loads,
    loop,
    sides,
    stroke,
    velocity_range,
)
from .schema import CurveRecord, SideRecord

if TYPE_CHECKING:
    from ...identify.result import Fit
    from ...space import Array

_QUANTITIES: tuple[Literal["position"], Literal["velocity"]] = ("position", "velocity")


def law_sides(
    fit: Fit, ends: tuple[float, float], detail: Detail
) -> tuple[list[SideRecord], BandSource | None]:
    """The law's curve to both sides of rest, and its band where there is one."""
    p, scale = law_parameters(fit), unit(fit.rig.unit_shown("velocity")).factor
    speeds = sides(*ends, detail.speeds)
    limited = band(fit, speeds)
    moved = directions_between(*velocity_range(fit))
    bands = [None] * len(speeds) if limited is None else limited[1]
    records = [
        SideRecord(
            velocity=detail.series(v / scale, 8),
            friction=detail.series(fit.law.friction(v, p)),
            low=None if limits is None else detail.series(limits[0]),
            high=None if limits is None else detail.series(limits[1]),
            seen=int(np.copysign(1.0, v[-1])) in moved,
        )
        for v, limits in zip(speeds, bands, strict=True)
    ]
    return records, None if limited is None else limited[0]


def loop_records(fit: Fit, detail: Detail) -> tuple[float, list[CurveRecord]]:
    """The pace of slow strokes as shown, and the loops of a law with states in them."""
    way, pace = stroke(fit)
    length, speed = (unit(fit.rig.unit_shown(q)).factor for q in _QUANTITIES)
    records = []
    for share, name in ((1.0, "to and fro"), (0.35, "a third as far")):
        x, F = loop(fit.law, law_parameters(fit), share * way, pace)
        records.append(CurveRecord(name=name, x=detail.series(x / length), y=detail.series(F)))
    return pace / speed, records


def load_unit(fit: Fit) -> tuple[str, float]:
    """What a law is loaded by, with its unit, and how large that is in SI."""
    if "normal" not in fit.law.loads:
        return (
            f"{'Torque' if fit.rig.rotary else 'Force'} / {fit.rig.si_unit('force')}",
            1.0,
        )
    if any(log.pressure is not None for log in fit.recordings):
        return "Pressure / bar", unit("bar").factor
    return "Normal load", 1.0


def load_records(fit: Fit, fast: float, detail: Detail) -> list[CurveRecord]:
    """Friction against load at rest and at the greatest speed, for each way of loading."""
    p, speed = law_parameters(fit), fit.rig.unit_shown("velocity")
    across = np.linspace(0.0, greatest_load(fit), detail.loads)
    moving = f"{fast / unit(speed).factor:.3g} {unit_label(speed)}"
    lines: dict[str, tuple[str, Array]] = {}
    for name, way in loads(fit.law).items():
        for state, v in (("at rest", 0.0), (f"at {moving}", fast)):
            F = np.array([friction_under(fit.law, p, v, way, x) for x in across])
            twin = next(
                (n for n, (a, y) in lines.items() if a == state and np.allclose(y, F)), None
            )
            if twin is None:
                lines[f"{name}, {state}"] = (state, F)
            else:  # two lines on one another have one name
                other = twin.removesuffix(f", {state}").removesuffix(" alone")
                lines[f"{other} or {name}, {state}"] = lines.pop(twin)
    return [
        CurveRecord(name=name, x=detail.series(across / load_unit(fit)[1]), y=detail.series(F))
        for name, (_, F) in lines.items()
    ]
