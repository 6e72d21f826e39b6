"""Drift: what of a fleet has changed, told by intervals that may be compared."""

from __future__ import annotations

import datetime as dt
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from ..errors import InputError
from ..monitoring.change import LevelChange
from ..monitoring.control_chart import Alarm, ControlChart, Limits, control_chart
from ..monitoring.detectable import detectable_step
from ..monitoring.series import SIDE, Series
from ..wording import option
from .drift_grounds import WITHIN, changed_beside, grounds
from .drift_verdict import Drift, DriftAlarm, DriftChange, ParameterDrift
from .fleet_table import read_table
from .like_motion import FACTOR, kinds
from .manifest_row import as_compared
from .table_check import checked

#: Logs of one kind that it takes before the next can be compared.
_BEFORE = 3
#: Charts of a parameter: CUSUM and EWMA.
_CHARTS = 2
#: Microseconds of a day.
_DAY = 86_400e6
_YEAR = dt.timedelta(days=365.25)
#: Estimates from one false alarm of a chart to the next up to which limits can be computed.
_LONGEST = 1e9
#: Of two changes the one is told beside the other unless that is so much likelier, in logarithms.
_AS_LIKELY = 3.0
#: Days of a week.
_WEEK = 7.0
_VERDICTS = ("identified", "weak")


def drift(
    table: str | Path | pl.DataFrame,
    *,
    false_alarms: float = 1.0,
    since: dt.datetime | dt.date | None = None,
    like: float = FACTOR,
    weak: bool = False,
) -> Drift:
    """Say which parameters of a fleet have changed.

    Per axis and parameter, in the order of time, each identified estimate is compared with those
    before it of like motion (speeds and travel within a factor), law, rig and load: effects of day
    and log are random, a dependence on temperature is taken out where it is known, and no
    difference is standardised by less than the estimate's own interval. A CUSUM and an EWMA of the
    standardised differences raise alarms, at limits that give the wanted rate of false ones.

    Args:
        table: Folder of a fleet, or its table as `Fleet.table` gives it.
        false_alarms: A year, for each axis with all its parameters and charts.
        since: Alarms before it are no longer up.
        like: Factor within which speeds and travel are alike.
        weak: Whether estimates that are weak are compared, too, by what their intervals say.

    Returns:
        A verdict for each parameter, with what it rests on, and the alarms.

    Raises:
        InputError: there is no table, or a number makes no sense.
    """
    if not 0.0 < false_alarms < float("inf"):
        raise InputError(f"{option('false_alarms')}: give a number above 0, got {false_alarms:g}")
    if not 1.0 <= like < float("inf"):
        raise InputError(f"{option('like')}: give a factor of at least 1, got {like:g}")
    if isinstance(since, dt.datetime):
        since = as_compared(since)
    elif since is not None:
        since = dt.datetime(since.year, since.month, since.day)  # noqa: DTZ001 - as the table has it
    frame = checked(table) if isinstance(table, pl.DataFrame) else read_table(Path(table))
    wanted = _VERDICTS if weak else _VERDICTS[:1]
    done = frame.filter(pl.col("status") == "done")
    ordered = done.sort("machine", "axis", "when", "log", maintain_order=True)
    axes = ordered.partition_by("machine", "axis", maintain_order=True)
    verdicts = [p for axis in axes for p in _axis(axis, false_alarms, like, wanted)]
    return Drift(tuple(verdicts), false_alarms, since)


def _axis(
    rows: pl.DataFrame, false_alarms: float, like: float, wanted: Sequence[str]
) -> Iterator[ParameterDrift]:
    """The parameters of an axis."""
    comparisons = [
        _ParameterHistory(part, like, wanted)
        for part in rows.filter(pl.col("verdict") != "fixed").partition_by(
            "parameter", "unit", maintain_order=True
        )
    ]
    charted = [comparison for comparison in comparisons if comparison.fit_for_a_chart]
    if charted:
        logs = max(comparison.logs_per_year for comparison in charted)
        estimates = logs * _CHARTS * len(charted)  # a year, of all charts
        if estimates / false_alarms > _LONGEST:
            raise InputError(
                f"{option('false_alarms')}: no limits are so wide: give at least "
                f"{estimates / _LONGEST:.1g}"
            )
        limits = Limits.of(estimates / false_alarms)
    for comparison in comparisons:
        yield comparison.charted(limits) if comparison in charted else comparison.undecided()


class _ParameterHistory:
    """The rows of one parameter of one axis, and which of them may be compared.

    Args:
        rows: In the order of time.
        like: Factor within which speeds and travel are alike.
        wanted: Verdicts that may be compared.
    """

    def __init__(self, rows: pl.DataFrame, like: float, wanted: Sequence[str]) -> None:
        self.rows, self._wanted = rows, wanted
        usable = (
            pl.col("verdict").is_in(wanted)
            & pl.col("when").is_not_null()
            & (pl.col("high") > pl.col("low"))
        )
        self._usable = rows.select(usable.fill_null(value=False)).to_series()
        self._compared = rows.filter(self._usable)
        self._kinds = kinds(self._compared.to_dicts(), like)
        temperatures = self._compared["temperature"]
        self._warmth = bool(len(temperatures)) and not temperatures.null_count()
        self._warmth = self._warmth and temperatures.n_unique() > 1

    @property
    def fit_for_a_chart(self) -> bool:
        """Whether there are enough rows of one kind for one to be compared with those before it."""
        return max(Counter(self._kinds).values(), default=0) > _BEFORE

    @property
    def logs_per_year(self) -> float:
        """How many rows a year there are to be compared; of less than a day, as if it were one."""
        first, last = self._compared["when"][0], self._compared["when"][-1]
        years = max(last - first, dt.timedelta(days=1)) / _YEAR
        return float((len(self._compared) - 1) / years)

    def undecided(self) -> ParameterDrift:
        """The verdict where nothing can be compared."""
        verdicts = Counter(
            f"{v} ({r})" if r else str(v)
            for v, r in self.rows.select("verdict", "verdict_reason").iter_rows()
        )
        if self._compared.is_empty():
            told = ", ".join(f"{n} {verdict}" for verdict, n in verdicts.most_common(3))
            why = f"no row can be compared: {told}" + (
                ", none with a time" if self.rows["when"].null_count() == len(self.rows) else ""
            )
        else:
            most = max(Counter(self._kinds).values())
            why = (
                f"{len(self._compared)} of {len(self.rows)} rows are {' or '.join(self._wanted)}, "
                f"at most {most} of them of like motion, law, rig and load: from "
                f"{_BEFORE + 1} on they are compared"
            )
        return self._verdict(None, "undecided", why)

    def charted(self, limits: Limits) -> ParameterDrift:
        """The verdict of the charts."""
        series = self._series()
        chart = control_chart(series, limits)
        if not chart.compared:
            why = (
                f"{len(self._compared)} logs, and {series.design.shape[1]} levels and dependences "
                "to be taken out of them: none is left to be compared"
            )
            return self._verdict(None, "undecided", why)
        step = detectable_step(series, chart, WITHIN)
        why = grounds(self._compared, len(self.rows), series, chart, step)
        alarms = tuple(self._alarm(alarm) for alarm in chart.alarms)
        verdict = "alarm" if alarms else "steady"
        known = step if math.isfinite(step) else None
        return self._verdict(chart, verdict, why, known, alarms)

    def _verdict(
        self,
        chart: ControlChart | None,
        verdict: Any,
        why: str,
        step: float | None = None,
        alarms: tuple[DriftAlarm, ...] = (),
    ) -> ParameterDrift:
        each = iter(self._kinds)
        all_kinds = tuple(next(each) if usable else -1 for usable in self._usable)
        machine, axis, parameter, unit = (
            self.rows[column][0] for column in ("machine", "axis", "parameter", "unit")
        )
        taken_out = self._warmth and chart is not None
        return ParameterDrift(
            machine, axis, parameter, unit, self.rows, all_kinds, chart, verdict, why, step, alarms,
            taken_out,
        )  # fmt: skip

    def _series(self) -> Series:
        rows = self._compared
        times = rows["when"].dt.epoch("us").to_numpy() / _DAY
        widths = (rows["high"] - rows["low"]).to_numpy()
        warmth = rows["temperature"].to_numpy() if self._warmth else None
        each = np.array(self._kinds, dtype=np.int64)
        return Series(rows["value"].to_numpy(), widths / (2.0 * SIDE), times, each, warmth)

    def _alarm(self, alarm: Alarm) -> DriftAlarm:
        rows, changes = self._compared, alarm.changes
        likely = [c for c in changes if changes[0].log_likelihood - c.log_likelihood < _AS_LIKELY]
        return DriftAlarm(
            rows["when"][alarm.at], rows["log"][alarm.at], alarm.chart,
            tuple(self._change(c) for c in likely),
            tuple(self._beside(changes[0].at, alarm.at)) if changes else (),
        )  # fmt: skip

    def _change(self, change: LevelChange) -> DriftChange:
        sizes = np.array([change.size, change.low, change.high])
        size, low, high = (sizes * (_WEEK if change.shape == "ramp" else 1.0)).tolist()
        since = self._compared["when"][change.at]
        return DriftChange(change.shape, since, size, low, high, change.level)

    def _beside(self, at: int, end: int) -> Iterator[str]:
        return changed_beside(self._compared, self._kinds, at, end, taken_out=self._warmth)
