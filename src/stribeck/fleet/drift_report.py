"""What has changed in a fleet, for people: alarms first, then what rests on what."""

from __future__ import annotations

from collections import Counter
from itertools import starmap

from ..report import DASH, Table, number
from ..report.terminal import console, show_table
from .drift_verdict import Drift, DriftAlarm, DriftChange, ParameterDrift

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
    return (
        f"{_count(len(result.up), 'alarm')} up. {_count(len(result.parameters), 'parameter')}: "
        f"{', '.join(parts)}. False alarms to be expected: at most {expected} a year on "
        f"{_count(len(axes), 'axis', 'axes')}."
    )


def _count(n: int, one: str, many: str = "") -> str:
    return f"{n:,} {one if n == 1 else many or one + 's'}"


def alarm_table(result: Drift) -> Table:
    """The alarms that are up, a row each."""
    heads = ("axis", "parameter", "alarm", "by", "changed", "by how much", "before", "beside it")
    return Table.of_texts("Alarms", heads, list(starmap(_alarm_row, result.up)), range(len(heads)))


def _alarm_row(p: ParameterDrift, alarm: DriftAlarm) -> list[str]:
    first = alarm.changes[0] if alarm.changes else None
    return [
        f"{p.machine} {p.axis}",
        p.parameter,
        f"{alarm.when:%Y-%m-%d}",
        alarm.chart,
        DASH if first is None else f"{first.since:%Y-%m-%d}",
        " or ".join(change_text(p.unit, change) for change in alarm.changes)
        or "too few logs to tell",
        DASH if first is None else f"{number(first.level, 3)} {p.unit}",
        "; ".join(alarm.also) or DASH,
    ]


def change_text(unit: str, change: DriftChange) -> str:
    """The size of a change with its interval, and in per cent of what was before, if that is more.

    A ramp's is by week.
    """
    low, high = number(change.low, 3), number(change.high, 3)
    ending = " a week" if change.shape == "ramp" else ""
    share = ""
    if abs(change.level) > abs(change.size) / 2:
        share = f" ({_signed(100.0 * change.size / abs(change.level))} %)"
    return f"{_signed(change.size)} {unit}{ending} [{low}, {high}]{share}"


def _signed(size: float) -> str:
    return f"{'+' * (size > 0)}{number(size, 3)}"
