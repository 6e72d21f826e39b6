"""What a model leaves out: the mean residual force in bins of each variable."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...units import percent
from ..contents.schema import BinsRecord, Report
from ..format import number
from .motion_plots import finite
from .plot import SMALL, Column, Group, Line, Panel, Plot, Rule, View

#: What a residual is called by its kind.
_KINDS = {
    "force": "Residual force",
    "friction": "Residual friction",
    "inertia": "Residual force along the acceleration",
}
#: The same where the axis of a small plot has to hold it.
_SHORT = {**_KINDS, "inertia": "Along acceleration"}


def adequacy_groups(report: Report) -> list[Group]:
    """One small plot for each variable."""
    force = report.units.force
    return [_binned(k, b, force) for k, b in enumerate(_different(report.bins), 1)]


def _different(bins: Sequence[BinsRecord]) -> Iterator[BinsRecord]:
    """Those with something to draw: on an axis that ran one way friction is the force again."""
    drawn = set()
    for b in bins:
        shape = (b.variable, tuple(b.at), tuple(np.abs(finite(b.mean))))
        if len(b.at) > 1 and shape not in drawn:
            drawn.add(shape)
            yield b


def _binned(k: int, b: BinsRecord, force: str) -> Group:
    at, mean, chance = (finite(x) for x in (b.at, b.mean, b.chance))
    columns: dict[str, Column] = {
        "x": at.tolist(), "y": mean.tolist(),
        "low": (-chance).tolist(), "high": chance.tolist(),
    }  # fmt: skip
    lines = [
        Line("x", "high", "model", "95 % by chance", "band", low="low"),
        Line("x", "y", "measured", "mean of the bin", "marks"),
    ]
    name = f"{_KINDS[b.kind]} over {b.variable}"
    outside = int(np.count_nonzero(np.abs(mean) > chance))
    alt = (
        f"{name}: the bins explain {percent(b.share)} of its variance beyond chance; outside "
        f"the band: {outside} of {len(at)}; the farthest from zero: "
        f"{number(float(np.abs(mean).max()), 3)} {force}."
    )
    view = View(name, alt, columns, lines, levels=[Rule(0.0)])
    axis = f"{b.variable.capitalize()} / {b.unit}"
    plot = Plot(f"adequacy-{k}", name, axis, [Panel(f"{_SHORT[b.kind]} / {force}")], [view], SMALL)
    return Group(f"adequacy-group-{k}", name, [plot])
