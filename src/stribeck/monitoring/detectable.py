"""The step that the next few estimates would tell, from what is known of the series now."""

from __future__ import annotations

from .control_chart import ChartState, ControlChart
from .innovations import shares_of, step
from .series import Series

#: Halvings of the range of the step, which begins at so many standard deviations.
_HALVINGS, _MOST = 20, 64.0


def detectable_step(series: Series, chart: ControlChart, logs: int) -> float:
    """The step that so many more estimates tell in about half of all cases, in the values' unit.

    They are like the last one, a day of its own each, and lie where the step puts them without any
    scatter: the charts, from zero, raise an alarm with the last of them. With few estimates so far,
    with levels that are hardly known or a covariate that takes much out, the step is larger.

    Returns:
        The step; inf where none would be told, as after an alarm at the last estimate.
    """
    unit = max(chart.state.deviation, float(series.errors[-1]))
    if not unit > 0.0:
        return 0.0 if unit == 0.0 else float("inf")
    row, shares, error = series.design[-1], shares_of(series)[-1], float(series.errors[-1])
    level = float(chart.state.weights @ (chart.state.mean[:, :-1] @ row))
    day = float(series.days[-1])

    def told(size: float) -> bool:
        state, run = chart.state, ChartState(chart.limits)
        for k in range(1, logs + 1):
            state, z, share = step(state, level + size * unit, row, day + k, shares, error)
            if run.add(z, share) is not None:
                return True
        return False

    if not told(_MOST):
        return float("inf")
    low, high = 0.0, _MOST
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if told(middle) else (middle, high)
    return high * unit
