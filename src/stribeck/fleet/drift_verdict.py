"""What has become of each parameter of a fleet: steady, an alarm, or nothing to compare."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import polars as pl

from ..monitoring.change import Shape
from ..monitoring.control_chart import Chart, ControlChart

#: The version of the document.
SCHEMA = "stribeck-drift/1"


@dataclass(frozen=True)
class DriftChange:
    """By how much a parameter has changed, and since when.

    Args:
        shape: A step, or a ramp that goes on.
        since: Time of the first log after a step, of the last before a ramp.
        size: By how much, in the parameter's unit; of a ramp by week.
        low: Lower end of its 95 % interval.
        high: Upper end.
        level: What it was before.
    """

    shape: Shape
    since: dt.datetime
    size: float
    low: float
    high: float
    level: float

    def document(self) -> dict[str, Any]:
        """The change as JSON has it."""
        return {**vars(self), "since": self.since.isoformat()}


@dataclass(frozen=True)
class DriftAlarm:
    """A chart of a parameter has left its limits.

    Args:
        when: Time of the log at which it did.
        log: That log.
        chart: Which chart.
        changes: The change, as all logs before the next alarm show it: of a step and a ramp the
            likelier one, then the other one if it may be that as well; none where too few logs
            can tell.
        also: What else has changed, a phrase each.
    """

    when: dt.datetime
    log: str
    chart: Chart
    changes: tuple[DriftChange, ...] = ()
    also: tuple[str, ...] = ()

    def document(self) -> dict[str, Any]:
        """The alarm as JSON has it."""
        changes = [change.document() for change in self.changes]
        return {
            **vars(self), "when": self.when.isoformat(), "changes": changes, "also": list(self.also)
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class ParameterDrift:
    """A parameter of an axis over time.

    Args:
        machine: The machine.
        axis: The axis.
        parameter: Its name, as the rig shows it.
        unit: Of its values.
        rows: Its rows in the table, in the order of time.
        kinds: The kind of each row that may be compared; -1 of one that is not identified, or has
            no time.
        chart: Its charts; None where nothing can be compared.
        verdict: `alarm`, `steady`, or `undecided` where nothing can be compared.
        why: What the verdict rests on, in a sentence.
        detectable: The step that the charts tell by its third log in half of all cases, in the
            unit; None where none would be told yet.
        alarms: In the order of time.
        temperature: Whether a dependence on temperature is taken out.
    """

    machine: str
    axis: str
    parameter: str
    unit: str
    rows: pl.DataFrame = field(repr=False)
    kinds: tuple[int, ...] = field(repr=False)
    chart: ControlChart | None = field(repr=False)
    verdict: Literal["alarm", "steady", "undecided"]
    why: str
    detectable: float | None = None
    alarms: tuple[DriftAlarm, ...] = ()
    temperature: bool = False

    @property
    def compared(self) -> pl.DataFrame:
        """The rows that its chart is of, in its order."""
        return self.rows.filter(pl.Series([k >= 0 for k in self.kinds], dtype=pl.Boolean))

    def document(self) -> dict[str, Any]:
        """The parameter as JSON has it."""
        names = ("machine", "axis", "parameter", "unit", "verdict", "why", "detectable")
        chart = self.chart
        limits = None if chart is None else dict(vars(chart.limits))
        return {
            **{name: getattr(self, name) for name in names},
            "logs": len(self.rows),
            "compared": 0 if chart is None else chart.compared,
            "kinds": len({k for k in self.kinds if k >= 0}),
            "scatter": None if chart is None else chart.deviation,
            "day_share": None if chart is None else chart.state.scatter.day_share,
            "temperature": self.temperature,
            "limits": limits,
            "alarms": [alarm.document() for alarm in self.alarms],
        }


@dataclass(frozen=True, eq=False)
class Drift:
    """What has become of the parameters of a fleet.

    Args:
        parameters: Each of them.
        false_alarms: A year for each axis, to which the limits are set.
        since: Alarms before it are told, but no longer up; None where all are.
    """

    parameters: tuple[ParameterDrift, ...] = field(repr=False)
    false_alarms: float
    since: dt.datetime | None = None

    @cached_property
    def up(self) -> tuple[tuple[ParameterDrift, DriftAlarm], ...]:
        """The alarms that are up."""
        return tuple(
            (p, a)
            for p in self.parameters
            for a in p.alarms
            if self.since is None or a.when >= self.since
        )

    def table(self) -> pl.DataFrame:
        """A row per axis and parameter: verdict, what it rests on, and the last alarm."""
        rows = [_row(p) for p in self.parameters]
        return pl.DataFrame(rows, infer_schema_length=None)

    def document(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        return {
            "schema": SCHEMA,
            "false_alarms_a_year": self.false_alarms,
            "since": self.since and self.since.isoformat(),
            "alarms_up": len(self.up),
            "parameters": [p.document() for p in self.parameters],
        }


def _row(p: ParameterDrift) -> Mapping[str, Any]:
    document = p.document()
    last = p.alarms[-1] if p.alarms else None
    change = last.changes[0] if last and last.changes else None
    shown = ("machine", "axis", "parameter", "unit", "verdict", "logs", "compared", "scatter")
    return {
        **{name: document[name] for name in shown},
        "detectable": p.detectable,
        "alarms": len(p.alarms),
        "when": last and last.when,
        **{
            name: None if change is None else getattr(change, name)
            for name in ("shape", "since", "size", "low", "high", "level")
        },
        "why": p.why,
    }
