"""A CUSUM and an EWMA over the standardised differences of a series, with limits by run length."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ..space import Array
from .innovations import GRID, Filter, centred, shares_of, step
from .level_shift import LevelShift, level_shift
from .run_length import cusum_limit, ewma_limit
from .series import Series

Chart = Literal["CUSUM", "EWMA"]
#: Allowance of the CUSUM: it is quickest for steps of two standard deviations. Weight of the newest
#: value in the EWMA, which is quick for slow drifts.
ALLOWANCE, SHARE = 1.0, 0.1
#: Digits to which run lengths are rounded before limits are sought: each takes milliseconds.
_DIGITS = 3


@dataclass(frozen=True)
class Limits:
    """Where the charts raise an alarm.

    Args:
        run_length: Average number of estimates from one false alarm of a chart to the next.
        cusum: h.
        ewma: c, in standard deviations of the chart.
    """

    run_length: float
    cusum: float
    ewma: float

    @classmethod
    def of(cls, run_length: float) -> Limits:
        """The limits at which each chart runs so long on average while nothing changes."""
        rounded = max(2.0, float(f"{run_length:.{_DIGITS}g}"))
        return cls(rounded, cusum_limit(ALLOWANCE, rounded), ewma_limit(SHARE, rounded))


@dataclass(frozen=True)
class Alarm:
    """A chart has left its limits.

    Args:
        at: Index of the estimate at which it did.
        chart: Which chart.
        change: When and by how much the quantity has changed, from all estimates up to the next
            alarm; None where too few are left to tell.
    """

    at: int
    chart: Chart
    change: LevelShift | None


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
        scatter: Standard deviation of an estimate of a day of its own about its level, as all
            estimates show it; nan of fewer than three that can be compared.
        day_share: Share of days in that variance.
    """

    differences: Array
    up: Array
    down: Array
    ewma: Array
    limits: Limits
    alarms: tuple[Alarm, ...]
    scatter: float
    day_share: float

    @property
    def compared(self) -> int:
        """How many estimates were compared with those before them."""
        return int(np.isfinite(self.differences).sum())


@dataclass
class _ChartState:
    """The charts while they run: since when, and where they stand."""

    up: float = 0.0
    down: float = 0.0
    ewma: float = 0.0
    _scale: float = field(default=float(np.sqrt(SHARE / (2.0 - SHARE))), repr=False)

    def add(self, z: float) -> None:
        """Take one more difference."""
        if np.isfinite(z):
            self.up = max(0.0, self.up + z - ALLOWANCE)
            self.down = max(0.0, self.down - z - ALLOWANCE)
            self.ewma = (1.0 - SHARE) * self.ewma + SHARE * z / self._scale

    def alarm(self, limits: Limits) -> Chart | None:
        """The chart that has left its limits."""
        if max(self.up, self.down) > limits.cusum:
            return "CUSUM"
        return "EWMA" if abs(self.ewma) > limits.ewma else None


def control_chart(series: Series, limits: Limits) -> ControlChart:
    """The charts of a series.

    After an alarm both begin anew with the next estimate: the level is sought anew, without those
    that have raised it, and what was known of the scatter stays. So the next false alarm is as far
    off as the first.

    Args:
        series: At least one estimate.
        limits: Where they raise an alarm.
    """
    n, values, shares, design = len(series), centred(series), shares_of(series), series.design
    traces = np.full((4, n), np.nan)
    state, run, start, raised = Filter.of(design.shape[1]), _ChartState(), 0, list[_Raised]()
    for i in range(n):
        day, error = int(series.days[i]), float(series.errors[i])
        before = state
        state, z = step(before, float(values[i]), design[i], day, shares[i], error)
        run.add(z)
        traces[:, i] = z, run.up, run.down, run.ewma
        if np.isfinite(z) and (chart := run.alarm(limits)) is not None:
            raised.append(_Raised(i, chart, start, *_expected(before)))
            state, run, start = before.forgotten(), _ChartState(), i + 1
    day_share, _ = _expected(state)
    alarms = tuple(_alarms(series, raised))
    differences, up, down, ewma = traces
    return ControlChart(differences, up, down, ewma, limits, alarms, _scatter(state), day_share)


@dataclass(frozen=True)
class _Raised:
    """An alarm, and what was known when it was raised."""

    at: int
    chart: Chart
    start: int
    day_share: float
    known: float


def _alarms(series: Series, raised: list[_Raised]) -> Iterator[Alarm]:
    """The alarms, each with its change as all estimates before the next show it."""
    for k, alarm in enumerate(raised):
        end = _begin(series, raised[k + 1]) if k + 1 < len(raised) else len(series)
        change = level_shift(series, alarm.start, end, alarm.day_share, alarm.known)
        yield Alarm(alarm.at, alarm.chart, change)


def _begin(series: Series, alarm: _Raised) -> int:
    """The estimate at which the change began that has raised an alarm."""
    change = level_shift(series, alarm.start, alarm.at + 1, alarm.day_share, alarm.known)
    return alarm.at if change is None else change.at


def _expected(state: Filter) -> tuple[float, float]:
    """The means of r and c over the grid."""
    r, c = state.weights @ GRID
    return float(r), float(c)


def _scatter(state: Filter) -> float:
    """s, over the grid."""
    if not state.count:
        return float("nan")
    return float(np.sqrt(state.weights @ (state.squares / state.count)))
