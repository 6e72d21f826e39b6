"""A CUSUM and an EWMA over the standardised differences of a series, with limits by run length."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ..space import Array
from .change import LevelChange, Shape, change
from .innovations import Filter, centred, shares_of, step
from .run_length import cusum_limit, ewma_limit
from .series import ScatterModel, Series

Chart = Literal["CUSUM", "EWMA"]
_SHAPES: tuple[Shape, ...] = ("step", "ramp")
#: Allowance of the CUSUM: it is quickest for steps of two standard deviations. Weight of the newest
#: value in the EWMA, which is quick for slow drifts.
ALLOWANCE, SHARE = 1.0, 0.1
#: What one difference adds to the CUSUM at most, as a part of its limit: it takes two.
_PART = 0.75
#: From so many standard deviations on a step that raised an alarm is none of the scatter. A smaller
#: one, as the effects of days that are alike may raise, hardly adds to it.
LARGE = 5.0
#: Digits to which run lengths are rounded before limits are sought: each takes milliseconds.
_DIGITS = 3
#: Differences whose correlation is told; how many of its standard errors it has to be.
_FEWEST, _CERTAIN = 10, 2.6
_EWMA_DEVIATION = float(np.sqrt(SHARE / (2.0 - SHARE)))


@dataclass(frozen=True)
class Limits:
    """Where the charts raise an alarm.

    Args:
        run_length: Average number of estimates from one false alarm of a chart to the next.
        cusum: h.
        ewma: c, in standard deviations of the chart.
        most: What a difference counts at most, so that none alone raises an alarm.
    """

    run_length: float
    cusum: float
    ewma: float
    most: float

    @classmethod
    def of(cls, run_length: float) -> Limits:
        """The limits at which each chart runs so long on average while nothing changes."""
        rounded = max(2.0, float(f"{run_length:.{_DIGITS}g}"))
        cusum = cusum_limit(ALLOWANCE, rounded, _PART)
        most = ALLOWANCE + _PART * cusum
        return cls(rounded, cusum, ewma_limit(SHARE, rounded, most), most)


@dataclass(frozen=True)
class Alarm:
    """A chart has left its limits.

    Args:
        at: Index of the estimate at which it did.
        chart: Which chart.
        changes: When and by how much the quantity has changed, as a step and as a ramp, the one
            of greater likelihood first, from all estimates up to the next alarm; none where too
            few are left to tell.
    """

    at: int
    chart: Chart
    changes: tuple[LevelChange, ...]


@dataclass(frozen=True, eq=False)
class ControlChart:
    """The charts of a series.

    Args:
        differences: Standardised, nan where nothing can be compared, (n,).
        up: The CUSUM's side that adds what is above, (n,).
        down: The side that adds what is below, (n,).
        ewma: The EWMA, in its standard deviations, (n,).
        limits: Where they raise an alarm.
        alarms: In the order of time.
        state: Of the filter, after the last estimate.
    """

    differences: Array
    up: Array
    down: Array
    ewma: Array
    limits: Limits
    alarms: tuple[Alarm, ...]
    state: Filter = field(repr=False)

    @property
    def compared(self) -> int:
        """How many estimates were compared with those before them."""
        return int(np.isfinite(self.differences).sum())

    @property
    def deviation(self) -> float:
        """Standard deviation of an estimate about its level; nan where none is compared."""
        return self.state.deviation

    @property
    def likeness(self) -> float:
        """Correlation of neighbouring differences, up to the first change; 0 if chance explains it.

        It is that of differences independent of each other, as the limits take them to be, unless
        it is above 2.6 of its standard errors, by chance in one series of 200.
        """
        changes = [a.changes[0].at if a.changes else a.at for a in self.alarms]
        z = self.differences[: min(changes, default=None)]
        z = z[np.isfinite(z)]
        if len(z) < _FEWEST:
            return 0.0
        correlation = float(z[1:] @ z[:-1] / (z @ z))
        return correlation if correlation * np.sqrt(len(z)) > _CERTAIN else 0.0


@dataclass
class ChartState:
    """The charts while they run: where they stand.

    Args:
        limits: Where they raise an alarm.
        up: The CUSUM's side that adds what is above.
        down: The side that adds what is below.
        ewma: The EWMA, in its standard deviations.
    """

    limits: Limits
    up: float = 0.0
    down: float = 0.0
    ewma: float = 0.0

    def add(self, difference: float, share: float) -> Chart | None:
        """Take one more difference; the chart that leaves its limits with it.

        Args:
            difference: Standardised; nan where there is none.
            share: What a change adds to it, of what it adds to the first difference of a day. It
                weighs the difference, and its square the allowance, as the ratio of likelihoods
                does; no chart raises more false alarms for it.
        """
        if not np.isfinite(difference):
            return None
        z = share * float(np.clip(difference, -self.limits.most, self.limits.most))
        part = share * share
        self.up = max(0.0, self.up + z - part * ALLOWANCE)
        self.down = max(0.0, self.down - z - part * ALLOWANCE)
        self.ewma = (1.0 - part * SHARE) * self.ewma + SHARE * z / _EWMA_DEVIATION
        if max(self.up, self.down) > self.limits.cusum:
            return "CUSUM"
        return "EWMA" if abs(self.ewma) > self.limits.ewma else None


def control_chart(series: Series, limits: Limits) -> ControlChart:
    """The charts of a series.

    After an alarm both begin anew with the next estimate: the level is sought anew, without those
    that have raised it, and what was known of the scatter stays. So the next false alarm is as far
    off as the first. Of a step of `LARGE` standard deviations and more only how the estimates
    scatter before and after it counts as scatter, not the step.

    Args:
        series: At least one estimate.
        limits: Where they raise an alarm.
    """
    n, rows = len(series), _FilterSteps(series)
    traces = np.full((4, n), np.nan)
    first = state = Filter.of(series.design.shape[1])
    run, start, raised = ChartState(limits), 0, list[_Raised]()
    for i in range(n):
        before = state
        state, z, share = rows.step(before, i)
        chart = run.add(z, share)
        traces[:, i] = z, run.up, run.down, run.ewma
        if chart is not None:
            alarm = _Raised(i, chart, start, before.scatter)
            begin, size = _step(series, alarm)
            left = rows.over(rows.over(first, start, begin).forgotten(), begin, i + 1)
            large = abs(size) > LARGE * left.deviation
            first = (before.with_deviation(left.deviation) if large else before).forgotten()
            raised.append(alarm)
            state, run, start = first, ChartState(limits), i + 1
    differences, up, down, ewma = traces
    return ControlChart(differences, up, down, ewma, limits, tuple(_alarms(series, raised)), state)


class _FilterSteps:
    """The estimates of a series as the filter takes them, one after the other.

    Args:
        series: The series.
    """

    def __init__(self, series: Series) -> None:
        self._values, self._design, self._shares = centred(series), series.design, shares_of(series)
        self._days, self._errors = series.days.tolist(), series.errors.tolist()

    def step(self, state: Filter, i: int) -> tuple[Filter, float, float]:
        """The filter's step at estimate i."""
        value, row, shares = float(self._values[i]), self._design[i], self._shares[i]
        return step(state, value, row, self._days[i], shares, self._errors[i])

    def over(self, state: Filter, start: int, end: int) -> Filter:
        """The filter's state after the estimates from `start` to before `end`."""
        for i in range(start, end):
            state, _, _ = self.step(state, i)
        return state


@dataclass(frozen=True)
class _Raised:
    """An alarm, the first estimate that its charts took, and what was known of the scatter."""

    at: int
    chart: Chart
    start: int
    scatter: ScatterModel


def _alarms(series: Series, raised: list[_Raised]) -> Iterator[Alarm]:
    """The alarms, each with its changes as all estimates before the next show them."""
    for k, alarm in enumerate(raised):
        end = _step(series, raised[k + 1])[0] if k + 1 < len(raised) else len(series)
        each = (change(series, alarm.start, end, alarm.scatter, shape) for shape in _SHAPES)
        likely = sorted(filter(None, each), key=lambda c: -c.log_likelihood)
        yield Alarm(alarm.at, alarm.chart, tuple(likely))


def _step(series: Series, alarm: _Raised) -> tuple[int, float]:
    """The estimate at which the change began that has raised an alarm, and its size as a step."""
    step = change(series, alarm.start, alarm.at + 1, alarm.scatter)
    return (alarm.at, 0.0) if step is None else (step.at, step.size)
