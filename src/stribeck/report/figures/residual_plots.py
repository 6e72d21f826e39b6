"""What the model leaves: in time, in frequency, against itself."""

from __future__ import annotations

import numpy as np

from ..contents.frame import Frame
from ..contents.schema import MotionRecord, Report
from ..format import number
from .motion_plots import finite, part_name, residual_unit, together
from .plot import LOW, Group, Line, Panel, Plot, Rule, View

#: The correlation below which residuals count as unrelated.
_UNRELATED = 0.2
_ZERO = Rule(0.0)


def residual_group(report: Report) -> Group | None:
    """The residuals of all motions; None where there are none."""
    frame = Frame.of_report(report)
    plots = [_plots(frame, m) for m in report.motions if finite(m.residual).size]
    if not plots:
        return None
    drawn = [
        p
        for p in together(plots, "residual")
        if any(finite(view.columns["y"]).size for view in p.views)
    ]
    return Group("residual", "Residual of", drawn)


def _plots(frame: Frame, m: MotionRecord) -> list[Plot]:
    unit, name = residual_unit(frame), f"{part_name(m)}: {m.label}"
    density = Panel(f"Density / {unit if unit.isalpha() else f'({unit})'}²/Hz")
    return [
        Plot("", "Residual in time", "Time / s", [Panel(f"Residual / {unit}")],
             [_in_time(m, name, unit)], LOW),
        Plot("", "Residual in frequency", "Frequency / Hz", [density], [_in_frequency(m, name)],
             LOW, log=True),
        Plot("", "Residual against itself", "Lag / s", [Panel("Autocorrelation")],
             [_correlation(m, name)], LOW),
    ]  # fmt: skip


def _in_time(m: MotionRecord, name: str, unit: str) -> View:
    residual, t = finite(m.residual), finite(m.residual_t)
    k = int(np.abs(residual).argmax())
    alt = (
        f"{name}: RMS {number(m.rms or 0.0, 3)} {unit}; the largest error, "
        f"{number(float(residual[k]), 3)} {unit}, is at {number(float(t[min(k, len(t) - 1)]), 5)} "
        "s."
    )
    lines = [Line("x", "y", "measured", "measured − model")]
    return View(name, alt, {"x": m.residual_t, "y": m.residual}, lines, levels=[_ZERO])


def _in_frequency(m: MotionRecord, name: str) -> View:
    f, density = finite(m.frequency), finite(m.density)
    positive = density > 0
    f, density = f[positive], density[positive]
    if not len(f):
        return _empty(name)
    share = np.cumsum(density) / density.sum()
    half = float(f[np.searchsorted(share, 0.5)])
    level = float(density.sum() * (f[1] - f[0]) / (f[-1])) if len(f) > 1 else float(density[0])
    alt = (
        f"{name}: half of the residual's power lies below {number(half, 3)} Hz, of up to "
        f"{number(float(f[-1]), 4)} Hz; the dashed line is white noise of the same power."
    )
    columns = {"x": f.tolist(), "y": density.tolist(),
               "white_x": [float(f[0]), float(f[-1])], "white_y": [level, level]}  # fmt: skip
    lines = [
        Line("x", "y", "model", "residual"),
        Line("white_x", "white_y", "ink", "white noise", "dashes"),
    ]
    return View(name, alt, columns, lines)


def _correlation(m: MotionRecord, name: str) -> View:
    lag, correlation = finite(m.lag), finite(m.correlation)
    if len(lag) <= 1 or not m.counted:
        return _empty(name)
    below = np.flatnonzero(correlation < _UNRELATED)
    edge = 1.96 / np.sqrt(m.counted)
    until = (
        f"falls below {_UNRELATED:g} after {number(float(lag[below[0]]), 3)} s"
        if len(below)
        else f"stays above {_UNRELATED:g} as far as it is shown"
    )
    alt = (
        f"{name}: the correlation of the residual with itself {until}; of white noise 95 % "
        f"would lie within ±{edge:.2g}."
    )
    levels = [_ZERO, *(Rule(sign * edge, dash=True) for sign in (-1.0, 1.0))]
    lines = [Line("x", "y", "model", "residual")]
    return View(name, alt, {"x": m.lag, "y": m.correlation}, lines, levels=levels)


def _empty(name: str) -> View:
    return View(name, "The residual is too short for this.", {"x": [], "y": []}, [])
