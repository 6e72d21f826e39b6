"""What has changed in a fleet, for people: alarms first, then what rests on what."""

from __future__ import annotations

from collections import Counter
from itertools import starmap

from ..report import DASH, Table, number
from ..report.terminal import console, show_table
from .drift_verdict import Drift, DriftAlarm, ParameterDrift

#: Parameters whose reasons are told one by one; of more, the JSON has them all.
_MOST = 40


def show_drift(result: Drift) -> None:
    """Print alarms as a table, and of the rest what their verdicts rest on."""
    if result.up:
        show_table(alarm_table(result))
    counts = Counter(p.verdict for p in result.parameters)
    out = console()
    out.print(summary(result), highlight=False)
    for p in result.parameters[:_MOST]:
        out.print(f"{p.machine} {p.axis} {p.parameter}: {p.verdict}. {p.why}.", highlight=False)
    if counts.total() > _MOST:
        out.print(f"... and {counts.total() - _MOST:,} more, which the JSON has", highlight=False)


def summary(result: Drift) -> str:
    """How many alarms are up, and how many false ones are to be expected, in a sentence or two."""
    counts = Counter(p.verdict for p in result.parameters)
    axes = {(p.machine, p.axis) for p in result.parameters if p.chart is not None}
    parts = [f"{counts[v]:,} {v}" for v in ("alarm", "steady", "undecided")]
    expected = number(result.false_alarms * len(axes), 3)
    alarms = f"{len(result.up):,} alarm{'s' * (len(result.up) != 1)}"
    return (
        f"{alarms} up. {len(result.parameters):,} parameters: {', '.join(parts)}. "
        f"False alarms to be expected: {expected} a year on {len(axes):,} axes."
    )


def alarm_table(result: Drift) -> Table:
    """The alarms that are up, a row each."""
    heads = ("axis", "parameter", "alarm", "by", "changed", "by how much", "before", "beside it")
    return Table.of_texts("Alarms", heads, list(starmap(_alarm_row, result.up)), range(len(heads)))


def _alarm_row(p: ParameterDrift, alarm: DriftAlarm) -> list[str]:
    return [
        f"{p.machine} {p.axis}",
        p.parameter,
        f"{alarm.when:%Y-%m-%d}",
        alarm.chart,
        DASH if alarm.since is None else f"{alarm.since:%Y-%m-%d}",
        change(p, alarm),
        DASH if alarm.level is None else f"{number(alarm.level, 3)} {p.unit}",
        "; ".join(alarm.also) or DASH,
    ]


def change(p: ParameterDrift, alarm: DriftAlarm) -> str:
    """The size of a change with its interval; in per cent where that is of what was before."""
    if alarm.size is None or alarm.low is None or alarm.high is None:
        return "too few logs to tell"
    scale, unit = 1.0, f" {p.unit}"
    if alarm.level and abs(alarm.level) > abs(alarm.size) / 2:
        scale, unit = 100.0 / abs(alarm.level), " %"
    size, low, high = (number(scale * s, 3) for s in (alarm.size, alarm.low, alarm.high))
    sign = "+" * (alarm.size > 0)
    return f"{sign}{size}{unit} [{low}, {high}]"
