"""Estimates as a table for programs: a row a parameter, in the units that people see."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..rig.rig import shown_difference, shown_in
from .parameters import Parameters
from .uncertainty.estimates import Estimate

if TYPE_CHECKING:
    import polars as pl


def estimate_table(parameters: Parameters, estimates: Sequence[Estimate]) -> pl.DataFrame:
    """Name, value, 95 % interval, standard error, unit, verdict and its reason of each parameter.

    `low_ended` and `high_ended` are why the interval ends there: at a `threshold`, that is by the
    data, else at a `bound` of its search range, say, or at a guess (`budget`). An end that is not
    known, and those of a fixed parameter, are null. What the law itself holds is left out.
    """
    import polars as pl  # noqa: PLC0415 - a tenth of a second that a fit need not pay

    rig, rows = parameters.rig, []
    for q, e in zip(parameters.every, estimates, strict=True):
        if e.verdict == "fixed" and q.fixed == e.value:
            continue

        def shown(value: float, convert: Any = shown_in, q: Any = q) -> float | None:
            return float(convert(rig, q, value)) if math.isfinite(value) else None

        free = e.verdict != "fixed"
        rows.append({
            "parameter": e.name,
            "value": shown(e.value),
            "low": shown(e.low) if free else None,
            "high": shown(e.high) if free else None,
            "standard_error": shown(e.standard_error, shown_difference),
            "unit": e.unit,
            "verdict": e.verdict,
            "reason": e.reason,
            "low_ended": e.low_ended,
            "high_ended": e.high_ended,
        })  # fmt: skip
    types: dict[str, Any] = dict.fromkeys(("value", "low", "high", "standard_error"), pl.Float64)
    types |= dict.fromkeys(("low_ended", "high_ended"), pl.String)
    return pl.DataFrame(rows, schema_overrides=types)
