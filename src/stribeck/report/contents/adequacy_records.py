"""What a model leaves out, as a report has it: residual forces in bins, and effects."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...identify.adequacy.advice import description, within
from ...rig.rig import shown_in
from ...units import unit
from ..format import number, unit_label
from .schema import BinsRecord, EffectRecord

if TYPE_CHECKING:
    from ...identify.adequacy.effects import BinnedResidual, Effect
    from ...identify.result import Fit
    from ...space import Array


def bins_records(fit: Fit) -> Iterator[BinsRecord]:
    """The residual forces in bins of each variable."""
    for look in fit.effects.looks if fit.effects is not None else ():
        factor, written = _unit_of(fit, look)
        yield BinsRecord(
            variable=look.variable,
            kind=look.kind,
            unit=written,
            at=_rounded(look.bins.at / factor),
            mean=_rounded(look.bins.mean),
            chance=_rounded(look.bins.chance),
            share=float(f"{look.bins.share:.3g}"),
            probability=float(f"{look.bins.probability:.3g}"),
        )


def effect_records(fit: Fit) -> Iterator[EffectRecord]:
    """The effects that chance does not explain."""
    for effect in fit.effects.effects if fit.effects is not None else ():
        yield EffectRecord(
            text=description(fit.parameters, effect),
            share=float(f"{effect.share:.3g}"),
            size=float(f"{effect.size:.3g}"),
            probability=float(f"{effect.probability:.2g}"),
            moves=_moves(fit, effect),
        )


def _unit_of(fit: Fit, look: BinnedResidual) -> tuple[float, str]:
    """The unit of a variable as it is shown: its size in SI, and its name."""
    rig = fit.rig
    if look.variable == "time":
        return 1.0, "s"
    if look.variable == "position":
        return unit(rig.unit_shown("position")).factor, unit_label(rig.unit_shown("position"))
    speed = unit(rig.unit_shown("velocity")).factor
    if look.variable == "speed":
        return speed, unit_label(rig.unit_shown("velocity"))
    return speed, f"{unit_label(rig.unit_shown('velocity'))}²"


def _moves(fit: Fit, effect: Effect) -> str:
    """The parameters that an effect moves materially, with what they may be."""
    moved = []
    for q, e in zip(fit.parameters.every, fit.estimates, strict=True):
        ends = []
        for shift in (
            moves[q.name] for moves in (effect.shifts, effect.opposite) if q.name in moves
        ):
            to = within(q, e.value + shift)
            end = "" if to == e.value + shift else " (the end of its range)"
            value = number(float(shown_in(fit.rig, q, to)), 3)
            ends.append(f"{value} {unit_label(e.unit)}".rstrip() + end)
        if ends:
            moved.append(f"{e.name} to {' or '.join(ends)}")
    return ", ".join(moved)


def _rounded(values: Array) -> list[float | None]:
    return [float(f"{x:.5g}") if np.isfinite(x) else None for x in values.tolist()]
