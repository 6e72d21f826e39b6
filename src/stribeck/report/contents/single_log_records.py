"""What each of several logs gives by itself, as a report has it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...rig.rig import shown_difference, shown_in
from .schema import SingleLogRecord

if TYPE_CHECKING:
    from ...identify.result import Fit


def single_log_records(fit: Fit) -> Iterator[SingleLogRecord]:
    """The parameters of each log, with standard errors."""
    by_name = {q.name: q for q in fit.parameters.every}
    for k, label in enumerate(fit.differing.logs):
        values: dict[str, tuple[float, float] | None] = {}
        for spread in fit.differing.spreads:
            q, value, error = by_name[spread.parameter], spread.values[k], spread.errors[k]
            shown = (
                float(shown_in(fit.rig, q, value)),
                float(shown_difference(fit.rig, q, error)),
            )
            known = bool(np.isfinite(shown).all())
            values[fit.rig.label(q.name)] = shown if known else None
        yield SingleLogRecord(log=label, values=values)
