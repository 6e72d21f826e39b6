"""What the verdict of a parameter's charts rests on, and what changed beside it, as phrases."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import polars as pl

from ..monitoring.control_chart import ControlChart
from ..monitoring.covariate import covariate_effect
from ..monitoring.series import Series
from ..report import number
from .like_motion import SAME

#: Logs within which a detectable step is told.
WITHIN = 3
#: Share of the temperature's variance from which on a change may be taken for what it does.
_SHARED = 0.8


def grounds(rows: pl.DataFrame, logs: int, series: Series, chart: ControlChart, step: float) -> str:
    """What the verdict of a chart rests on, in a sentence.

    Args:
        rows: Those of the series, in its order.
        logs: How many there are with those that are not compared.
        series: The estimates.
        chart: Its charts.
        step: That they tell within `WITHIN` logs; inf where none would be.
    """
    return "; ".join(_grounds(rows, logs, series, chart, step))


def _grounds(
    rows: pl.DataFrame, logs: int, series: Series, chart: ControlChart, step: float
) -> Iterator[str]:
    unit, level = rows["unit"][0], abs(float(np.median(series.values)))
    distinct, scatter = len(np.unique(series.kinds)), chart.state.scatter
    motions = (
        "all of like motion"
        if distinct == 1
        else f"{distinct} kinds of motion, law, rig or load, each with its own level"
    )
    yield f"{chart.compared} of {logs} logs compared, {motions}"
    days = ""
    if len(np.unique(series.days)) < len(series):  # else nothing tells days from logs
        days = f", {scatter.day_share:.0%} of its variance between days"
    yield f"scatter {_beside(chart.deviation, unit, level)}{days}"
    if math.isfinite(step):
        size = _beside(step, unit, level)
        yield f"a step of {size} is told by its third log in half of all cases"
    else:
        yield "too few logs of this level yet to tell a step within three"
    yield f"a false alarm of a chart every {chart.limits.run_length:,.0f} logs at the most"
    if chart.likeness:
        yield (
            f"neighbouring differences are alike (correlation {chart.likeness:.2f}): a slow "
            "change, or days that are alike for long, which raise more false alarms"
        )
    last, newest = float(chart.differences[-1]), len(series) - 1
    if abs(last) > chart.limits.most and newest not in (alarm.at for alarm in chart.alarms):
        apart = f"{abs(last):.1f} standard deviations {'above' if last > 0 else 'below'}"
        yield f"the last log lies {apart} what was expected, which another one has to confirm"
    yield from _temperature(rows, series, chart)


def _temperature(rows: pl.DataFrame, series: Series, chart: ControlChart) -> Iterator[str]:
    """What temperature does, or why that is not known."""
    unknown = rows["temperature"].null_count()
    if series.covariate is None:
        if 0 < unknown < len(rows):
            yield f"temperature not taken out, as {unknown} of {len(rows)} logs have none"
        return
    steps = [alarm.changes[0].at for alarm in chart.alarms if alarm.changes]
    effect = covariate_effect(series, series.covariate, chart.state.scatter, steps)
    unit = f"{rows['unit'][0]}/°C"
    if math.isfinite(effect.slope):
        slope, low, high = (number(s, 2) for s in (effect.slope, effect.low, effect.high))
        yield f"dependence on temperature taken out, {slope} {unit} [{low}, {high}]"
    else:
        yield "dependence on temperature taken out, which cannot be told from other changes"
    if effect.shared > _SHARED:
        yield (
            f"{effect.shared:.0%} of the temperature's variance goes with time or with one step: a "
            "change of the parameter that goes with it is taken for what temperature does"
        )


def changed_beside(
    rows: pl.DataFrame, kinds: Sequence[int], at: int, end: int, *, taken_out: bool
) -> Iterator[str]:
    """What else is not as it was before a change, as phrases.

    Args:
        rows: Those that are compared, in the order of time.
        kinds: Their kinds.
        at: Index of the first after the change.
        end: Of the one that raised the alarm.
        taken_out: Whether the dependence on temperature is.
    """
    before, after = rows[:at], rows[at : end + 1]
    warm, warmer = (part["temperature"].drop_nulls().to_numpy() for part in (before, after))
    # Temperatures that are what they were give or take their own scatter are not told.
    if len(warm) and len(warmer) and abs(warmer.mean() - warm.mean()) > max(warm.std(), 0.5):
        ends = f"{number(float(warm.mean()), 3)} to {number(float(warmer.mean()), 3)} °C"
        yield f"temperature {ends}{' (taken out)' * taken_out}"
    for name in SAME:
        if new := set(after[name]) - set(before[name]):
            yield f"{name} {', '.join(sorted(map(str, new)))} (a level of its own)"
    if set(kinds[at : end + 1]) - set(kinds[:at]):
        yield "a kind of motion that was not there before (a level of its own)"
    for name, words in (
        ("setup_hash", "the rig's constants, columns or drive"),
        ("version", "the version of stribeck"),
    ):
        if set(after[name]) - set(before[name][-1:]):
            yield words


def _beside(size: float, unit: str, level: float) -> str:
    """A size with its unit, and in per cent of a level that is larger."""
    share = f" ({size / level:.1%})" if level > size else ""
    return f"{number(size, 2)} {unit}{share}"
